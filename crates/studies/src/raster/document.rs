//! What the study of the rasteriser says.

use serde::Serialize;
use trisect_report::document::{Document, Finding, Section, Shown};
use trisect_report::figure::{Axis, Drawing, Entry, Look, Panel, Scale, Series as Line, points};
use trisect_report::format::{number, ratio, tick};
use trisect_report::table::Table;

use super::crossing::{Crossing, crossings};
use super::record::{Built, Seen, Series};
use crate::lines::{distinct, source};
use crate::record::Records;
use crate::timing::middle;

/// Pictures of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimedWay {
    /// What they are compared with.
    pub series: Series,
    /// How they were made.
    pub way: String,
    /// Of what.
    pub scene: String,
    /// Its triangles.
    pub triangles: usize,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Threads.
    pub threads: usize,
    /// The median, in milliseconds.
    pub milliseconds: f64,
    /// Pixels that differ from what they are held to.
    pub different: Option<u64>,
    /// The share of pixels at which anything is seen.
    pub covered: f64,
    /// Pairs of a pixel and a triangle that exact arithmetic decided, in each pixel.
    pub judged: f64,
}

/// What was found, in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RasterSummary {
    /// All pictures.
    pub ways: Vec<TimedWay>,
    /// Where the two roads cross.
    pub crossings: Vec<Crossing>,
}

/// The same in numbers.
pub(super) fn summary(records: &Records) -> RasterSummary {
    let way = |seen: &Seen| {
        let pixels = f64::from(seen.width) * f64::from(seen.height);
        TimedWay {
            series: seen.series,
            way: seen.way.clone(),
            scene: seen.scene.clone(),
            triangles: seen.triangles,
            size: [seen.width, seen.height],
            threads: seen.threads,
            milliseconds: middle(&seen.samples_ns) / 1e6,
            different: seen.different,
            covered: seen.covered as f64 / pixels,
            judged: seen.judged as f64 / pixels,
        }
    };
    RasterSummary { ways: records.all().map(way).collect(), crossings: crossings(records) }
}

impl RasterSummary {
    fn of(&self, series: Series) -> Vec<&TimedWay> {
        self.ways.iter().filter(|way| way.series == series).collect()
    }
}

const NOTHING: &str =
    "Left out: the record holds no such pictures; make one with `trisect raster`.";

fn size([width, height]: [u32; 2]) -> String {
    format!("{width} × {height}")
}

/// Ways side by side: a row for each mesh and size.
fn side_by_side(ways: &[&TimedWay]) -> Table {
    let rows = distinct(ways.iter().map(|way| (&way.scene, way.triangles, way.size)));
    let mut columns = Table::of(&rows)
        .text("scene", |row| row.0.clone())
        .count("triangles", |row| row.1 as u64)
        .text("pixels", |row| size(row.2));
    for name in distinct(ways.iter().map(|way| &way.way)) {
        columns = columns.number(name.as_str(), number, |row| {
            let mine = |way: &&&TimedWay| {
                way.way == *name && (&way.scene, way.triangles, way.size) == *row
            };
            ways.iter().find(mine).map(|way| way.milliseconds)
        });
    }
    columns.done()
}

/// One way of a frame each.
fn frames(ways: &[&TimedWay]) -> Table {
    Table::of(ways)
        .text("way", |way| way.way.clone())
        .text("pixels", |way| size(way.size))
        .number("ms", number, |way| way.milliseconds)
        .number("frames/s", number, |way| 1e3 / way.milliseconds)
        .number("covered, %", number, |way| 100.0 * way.covered)
        .number("different", number, |way| way.different.map(|count| count as f64))
        .done()
}

/// Milliseconds against triangles, a panel for each size.
fn figure(summary: &RasterSummary) -> Section {
    let ways = summary.of(Series::Visibility);
    let names = distinct(ways.iter().map(|way| &way.way));
    let mut drawing = Drawing::default();
    for (place, name) in names.iter().enumerate() {
        drawing.legend.push(Entry::of(Look::of(place), name.as_str()));
    }
    for of in distinct(ways.iter().map(|way| way.size)) {
        let line = |(place, name): (usize, &&String)| {
            let mine = ways.iter().filter(|way| way.way == **name && way.size == of);
            let points = mine.map(|way| (way.triangles as f64, way.milliseconds)).collect();
            Line::line(Look::of(place), points)
        };
        let series: Vec<Line> = names.iter().enumerate().map(line).collect();
        let x = Axis::over("triangles", Scale::Log, points(&series).map(|p| p.0), tick);
        let y = Axis::over("milliseconds", Scale::Log, points(&series).map(|p| p.1), tick);
        drawing.panels.push(Panel::plane(&size(of), x, y, 200, series));
    }
    let caption =
        "Until it is known what is seen at each pixel, on all threads; the tree is there already.";
    Section::figure("raster-visibility", "Cast and rasterised", caption, drawing).missing(NOTHING)
}

fn findings(summary: &RasterSummary) -> Vec<Finding> {
    let mut all = Vec::new();
    let seen = summary.of(Series::Visibility);
    let filtered: Vec<_> = seen.iter().filter(|way| way.way == "rasterised, filtered").collect();
    let different: u64 = filtered.iter().filter_map(|way| way.different).sum();
    if !filtered.is_empty() {
        all.push(Finding::new(
            "Pixels that differ from the exact caster",
            different.to_string(),
            format!("the filtered rasteriser, in {} pictures", filtered.len()),
        ));
    }
    let price = filtered.iter().filter_map(|way| {
        let bare = seen.iter().find(|other| {
            other.way == "rasterised, bare" && (&other.scene, other.size) == (&way.scene, way.size)
        })?;
        Some(way.milliseconds / bare.milliseconds)
    });
    if let Some(price) = trisect_report::stats::geometric_mean(price) {
        all.push(Finding::new(
            "Exact agreement costs",
            format!("{} the bare one's time", ratio(price)),
            "the geometric mean over all meshes and sizes",
        ));
    }
    let frame = summary.of(Series::Frame);
    if let Some(slowest) = frame.iter().max_by(|a, b| a.milliseconds.total_cmp(&b.milliseconds)) {
        all.push(Finding::new(
            "The frame of 2012",
            format!("{} frames a second, {}", number(1e3 / slowest.milliseconds), slowest.way),
            format!("{} pixels, on one thread; Amiantov had 70 to 80", size(slowest.size)),
        ));
    }
    all
}

pub(super) fn document(records: &Records) -> Document {
    let summary = summary(records);
    let built: Vec<&Built> = records.all().collect();
    let of = |series| summary.of(series);
    let ways = of(Series::Ways);
    let wrong = Table::of(&ways)
        .text("way", |way| way.way.clone())
        .text("scene", |way| way.scene.clone())
        .text("pixels", |way| size(way.size))
        .number("ms", number, |way| way.milliseconds)
        .number("wrong pixels", number, |way| way.different.map(|count| count as f64))
        .number("judged, % of pixels", number, |way| 100.0 * way.judged)
        .done();
    let crossings = Table::of(&summary.crossings)
        .text("pixels", |row| size(row.size))
        .text("the tree", |row| match row.pictures {
            None => "is there".to_owned(),
            Some(1) => "built for each picture".to_owned(),
            Some(count) => format!("built for {count} pictures"),
        })
        .number("cross at, triangles", number, |row| row.triangles.map(|at| at[1]))
        .number("from", number, |row| row.triangles.map(|at| at[0]))
        .number("to", number, |row| row.triangles.map(|at| at[2]))
        .number("smallest mesh", ratio, |row| row.ratios[0])
        .number("largest", ratio, |row| row.ratios[1])
        .done();
    let building = Table::of(&built)
        .text("scene", |built| built.scene.clone())
        .count("triangles", |built| built.triangles as u64)
        .text("what", |built| built.what.clone())
        .number("ms", number, |built| middle(&built.samples_ns) / 1e6)
        .done();
    let everywhere = |section: Section| section.missing(NOTHING).shown(Shown::Everywhere);
    Document {
        title: "The rasteriser",
        heading: "The rasteriser: the same picture by the other road",
        source: source(&records.header),
        sections: vec![
            Section::findings("raster-findings", findings(&summary)),
            everywhere(
                Section::table(
                    "raster-crossings",
                    "Where casting becomes quicker",
                    "The triangles below which the filtered rasteriser is quicker than packets of rays, with what \
                     the 95 % intervals of both times leave open, and casting's time over the rasteriser's at the \
                     ends. Without a crossing one of them is quicker for all meshes here. A tree for one picture is \
                     the one that is built most quickly.",
                    crossings,
                )
                .part("raster-crossings"),
            ),
            figure(&summary),
            Section::table(
                "raster-times",
                "Milliseconds",
                "Until it is known what is seen at each pixel, on all threads, without building anything. Making \
                 the rays is not counted. All rays but the exact ones are Möller and Trumbore's.",
                side_by_side(&of(Series::Visibility)),
            )
            .missing(NOTHING),
            Section::table(
                "raster-built",
                "What is built before",
                "Trees by their builders, a refit, and the blocks that the rasteriser reads.",
                building,
            )
            .missing(NOTHING),
            Section::table(
                "raster-ways",
                "On one thread",
                "Wrong pixels are those at which another triangle is seen than exact arithmetic sees. Culling leaves \
                 out what shows its back: on a mesh that is not closed that is wrong as well.",
                wrong,
            )
            .missing(NOTHING),
            everywhere(
                Section::table(
                    "raster-frame",
                    "The frame of 2012",
                    "Two lights and three textured objects, on one thread, by ways of shading; Amiantov had 70 to 80 \
                     frames a second on a Core i5 M450.",
                    frames(&of(Series::Frame)),
                )
                .part("raster-frame"),
            ),
            everywhere(Section::table(
                "raster-textures",
                "How a texture lies",
                "Shaded after Gouraud. Pixels are compared with those of the texture that lies on the surface.",
                frames(&of(Series::Textures)),
            )),
        ],
    }
}
