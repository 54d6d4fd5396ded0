//! What the study of pictures says.

use crate::pictures::measure::LEVELS;
use crate::pictures::morozov::{self, Asked, Row};
use crate::pictures::record::{FrameSeries, Frames, Picture};
use crate::record::Records;

use super::figures;
use super::select::{SERIES, scene_of, series, speed};
use super::summary::{PictureSummary, TimedFrame, picture_summary};
use crate::lines::source;
use trisect_report::document::{self, Content, Document, Finding, Section, Shown};
use trisect_report::format::{fixed, number};
use trisect_report::table::Table;

pub(crate) fn document(records: &Records) -> Document {
    let summary = &picture_summary(records);
    let techniques = techniques(summary);
    let picture = |p: &Picture| document::Picture {
        name: p.name.clone(),
        says: p.says.clone(),
        size: [p.width, p.height],
        png: p.png.clone(),
    };
    let pictures = records.all::<Picture>().map(picture).collect();
    let brief = ["technique", "frames/s", "gain", "together"].map(|head| (head, head));
    let techniques_say = format!(
        "{}, from a tracer that tests every triangle, one number at a time, on one thread. Each row adds one \
         technique to those above: a tree, lanes of SIMD, threads, and the fastest method of those studied. \
         gain: speed over the row above; together: the product of all gains so far.",
        scene_of(records, FrameSeries::Techniques)
    );
    let sizes_say = "Frames per second of the mirror scene, on all threads, by Möller–Trumbore. After each \
                     level: samples of a pixel (on a circle), how often a ray may be reflected, lights.";
    let series_say = format!(
        "{}, all threads, tiles of 64, leaves where they are the cheapest: each row changes one of these. \
         rays: of one picture, from the camera, reflected, and to lights.",
        scene_of(records, FrameSeries::Threads)
    );
    let sections = vec![
        Section::findings("pictures-findings", findings(records, summary)),
        Section::new("pictures", "Pictures", Content::Pictures(pictures)),
        figures::sizes(summary),
        figures::one_at_a_time(records),
        Section::prose(goal(summary)).shown(Shown::Terminal),
        Section::brief(sizes(summary, "frames/s", |level| level.name.clone()), ""),
        Section::brief(techniques.pick(&brief), ""),
        Section::table("techniques", "What each technique gains", techniques_say, techniques)
            .part("pictures-techniques"),
        Section::table("sizes", "Sizes and levels", sizes_say, sizes(summary, "size", level))
            .part("pictures-sizes"),
        morozov_goals(records),
        morozov(records),
        Section::table(
            "series",
            "One thing at a time, in numbers",
            series_say,
            one_at_a_time(records),
        ),
    ];
    Document {
        title: "Pictures, and what they cost",
        heading: "Pictures",
        source: source(&records.header),
        sections,
    }
}

/// All findings that the record has the numbers for.
fn findings(records: &Records, summary: &PictureSummary) -> Vec<Finding> {
    let goal = summary.goal.as_ref().map(|goal| {
        let how = format!(
            "{} by {} pixels, {} sample, {} light, depth {}, on {} threads, by Möller–Trumbore",
            goal.width, goal.height, goal.samples, goal.lights, goal.depth, goal.threads
        );
        let says = format!("{} frames per second", number(goal.frames_per_second));
        Finding::new("The mirror scene", says, how)
    });
    let techniques = summary.techniques.last().map(|last| {
        let gains = summary.techniques.iter().skip(1);
        let gains: Vec<String> = gains.map(|t| format!("{} {:.2}", t.name, t.gain)).collect();
        Finding::new(
            "All techniques together",
            format!("{} times as fast as the plain tracer", number(last.together)),
            format!("multiplied up: {}; the kernel is that of {}", gains.join(", "), last.method),
        )
    });
    let ends = |which| {
        let mut all = series(records, which).filter_map(speed);
        let first = all.next()?;
        Some((first, all.last()?))
    };
    let threads = ends(FrameSeries::Threads).map(|(one, all)| {
        let says = format!("{:.2} times as fast as one", all / one);
        Finding::new("Threads", says, "on all of them")
    });
    let depth = ends(FrameSeries::Depth).map(|(none, all)| {
        let says = format!("{:.2} times the time without", none / all);
        Finding::new("Reflections", says, "of the mirror scene to depth 16")
    });
    [goal, techniques, threads, depth].into_iter().flatten().collect()
}

/// The picture that the speed is wanted of, in a sentence.
fn goal(summary: &PictureSummary) -> String {
    summary.goal.as_ref().map_or_else(String::new, |goal| {
        format!(
            "The mirror scene at {} by {}, one sample, one light, depth {}: {} frames per second on {} \
             thread(s).",
            goal.width,
            goal.height,
            goal.depth,
            number(goal.frames_per_second),
            goal.threads
        )
    })
}

/// A level with its samples, depth and lights.
fn level(TimedFrame { name, samples, depth, lights, .. }: &TimedFrame) -> String {
    format!("{name} {samples}/{depth}/{lights}")
}

/// A row per size, a column per level.
fn sizes(summary: &PictureSummary, head: &str, level: fn(&TimedFrame) -> String) -> Table {
    let size = |frame: &TimedFrame| [frame.width, frame.height];
    let rows: Vec<&[TimedFrame]> = summary.sizes.chunk_by(|a, b| size(a) == size(b)).collect();
    let mut table =
        Table::of(&rows).name(head, |frames| size(&frames[0]).map(|n| n.to_string()).join("×"));
    for of in summary.levels() {
        table = table.number(level(of), number, |frames| {
            let frame = frames.iter().find(|frame| frame.name == of.name);
            frame.map(|frame| frame.frames_per_second)
        });
    }
    table.done()
}

/// A row per technique.
fn techniques(summary: &PictureSummary) -> Table {
    Table::of(&summary.techniques)
        .name("technique", |t| &t.name)
        .text("method", |t| &t.method)
        .count("threads", |t| t.threads as u64)
        .number("frames/s", number, |t| t.frames_per_second)
        .number("gain", fixed, |t| t.gain)
        .number("together", number, |t| t.together)
        .done()
}

/// Morozov's headline settings, ours beside them.
fn morozov_goals(records: &Records) -> Section {
    let ours =
        |asked: Asked| records.all::<Frames>().find(|frames| asked.is_of(frames)).and_then(speed);
    let table = Table::of(&morozov::GOALS)
        .name("setting", |(asked, _)| asked.name())
        .number("Morozov", number, |(_, his)| *his)
        .number("ours", number, |(asked, _)| ours(*asked))
        .done();
    let says = "Frames per second at the settings that A. S. Morozov sums his tracer up by: size, then samples of a \
                pixel, depth and lights; a dash where the record has none of ours.";
    Section::table("morozov-goals", "Morozov's headline settings", says, table)
        .part("pictures-morozov")
}

/// Morozov's tables, ours beside them where the record has any.
fn morozov(records: &Records) -> Section {
    let rows: Vec<Row> = morozov::rows().collect();
    let ours = |row: &Row, level: usize| {
        records.all::<Frames>().find(|frames| row.is_of(level, frames)).and_then(speed)
    };
    let is_measured = records.all::<Frames>().any(|frames| frames.scene == morozov::SCENE);
    let mut table = Table::of(&rows)
        .text("what changes", |row| format!("{}. {}", row.table, row.says()))
        .count("to", |row| row.x.into());
    for (level, (name, ..)) in LEVELS.into_iter().enumerate() {
        table = table.number(name, number, move |row| row.frames_per_second[level]);
        if is_measured {
            table = table.number("ours", number, move |row| ours(row, level));
        }
    }
    let measured = if is_measured {
        "ours: his scene (`data/scenes/morozov.toml`) and settings on the machine of this record, by \
         Möller–Trumbore; this tracer's leaves have 16 or 32 triangles at most, so that his others have no \
         like here."
    } else {
        "This record has none of ours: `trisect pictures --morozov` takes his scene \
         (`data/scenes/morozov.toml`) and his settings, and puts its own speed beside each."
    };
    let says = format!(
        "Frames per second of A. S. Morozov's ray tracer (2011) on a Core i7-980X, 6 cores, 12 threads at 3.33 \
         GHz, by the number of his table, at his four levels, which are those of the sizes and levels above. \
         {measured}"
    );
    Section::table("morozov", "Morozov's tables", says, table.done()).part("pictures-morozov")
}

/// A row per thing and value.
fn one_at_a_time(records: &Records) -> Table {
    let of = |(which, says)| series(records, which).map(move |frames| (says, frames));
    let rows: Vec<(&str, &Frames)> = SERIES.into_iter().flat_map(of).collect();
    Table::of(&rows)
        .name("what", |(says, frames)| format!("{says}: {}", frames.name))
        .number("frames/s", number, |(_, frames)| speed(frames))
        .count("rays", |(_, frames)| frames.rays)
        .number("million rays/s", number, |(_, frames)| {
            Some(speed(frames)? * frames.rays as f64 / 1e6)
        })
        .done()
}
