//! The figures of the tracer's study.

use crate::tracer::record::{Contest, Traced, TreeBuilt};

use super::select::{
    against_default, faster, is_single, is_through, middle, scenes, traced, trees,
};
use super::summary::{StudyRow, StudySummary, gains};
use crate::comparison::document::view::{BASELINE, View};
use crate::lines::distinct;
use trisect_report::document::Section;
use trisect_report::figure::{
    Axis, Drawing, Entry, Ink, Look, Panel, Plane, Sample, Scale, Series, points,
};
use trisect_report::format::{ratio, tick};
use trisect_report::stats::geometric_mean;

/// All figures, in the order of the page.
pub(super) fn all(view: &View, summary: &StudySummary) -> [Section; 3] {
    [gain(view, summary), builders(view), threads(view)]
}

const NOTHING_TRACED: &str =
    "Left out: the record holds no study of the tracer; make one with `trisect study`.";

/// How many methods are told apart in a figure of all.
const MARKED: usize = 6;

/// The fastest methods, and the one that all are compared with.
fn marked(rows: &[StudyRow]) -> Vec<&str> {
    let mut order: Vec<(&str, f64)> =
        rows.iter().filter_map(|row| Some((row.method.as_str(), row.single_gain?))).collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let fastest = order.into_iter().map(|(method, _)| method).take(MARKED);
    distinct(fastest.chain([BASELINE]))
}

fn gain(view: &View, summary: &StudySummary) -> Section {
    let marked = marked(&summary.rows);
    let is_marked = |method: &str| marked.contains(&method);
    let panel = |(title, tracing): (&str, &str)| {
        let of = |any| gains(view, tracing, any).into_iter().map(move |(name, at)| (name, any, at));
        let (told, others): (Vec<_>, Vec<_>) =
            [false, true].into_iter().flat_map(of).partition(|(method, ..)| is_marked(method));
        // Those that are told apart last, so that they lie on top.
        let all = [others, told].concat();
        let ends = |of: fn(&(f64, f64)) -> f64| {
            let values = || all.iter().map(|(.., at)| of(at));
            [values().fold(1.0, f64::min), values().fold(1.0, f64::max)]
        };
        let (across, up) = (ends(|at| at.0), ends(|at| at.1));
        // As far as the points go in both directions.
        let line = [across[0].max(up[0]), across[1].min(up[1])];
        let mut series = vec![Series::bare(Ink::Muted, line.map(|x| (x, x)).into())];
        series.extend(all.iter().map(|&(method, any, at)| {
            let look = marked.iter().position(|other| *other == method);
            let look = look.map_or(Look::plain(Ink::Grid), Look::of);
            Series::points(look, !any, vec![at]).of(method)
        }));
        let (x, y) = (
            Axis::over("kernel", Scale::Log, across, ratio),
            Axis::over("tracer", Scale::Log, up, ratio),
        );
        (!all.is_empty()).then(|| Panel::plane(title, x, y, 300, series))
    };
    let told = marked.iter().enumerate();
    let mut legend: Vec<Entry> =
        told.map(|(place, m)| Entry::of(Look::of(place), view.title(m)).lit_with(*m)).collect();
    for (ink, filled, text) in [
        (Ink::Grid, true, "other methods"),
        (Ink::Muted, true, "closest hit"),
        (Ink::Muted, false, "any hit"),
    ] {
        legend.push(Entry::new(Sample::Point(Look::plain(ink), filled), text));
    }
    legend.push(Entry::new(Sample::Line(Ink::Muted), "as much as the kernel"));
    let caption = "Speed over that of Möller–Trumbore: across, of the test alone, one ray against lanes of \
                   triangles on random rays; up, of rays through a tree on one thread, geometric mean over \
                   scenes and classes, both methods in turn. On the line the tracer would gain as much as \
                   its kernel.";
    let panels = [("Single rays", "single"), ("Packets", "packets")].into_iter().filter_map(panel);
    let drawing = Drawing { panels: panels.collect(), legend, key: Vec::new() };
    Section::figure("study-gain", "What is left of a kernel's gain", caption, drawing)
        .missing(NOTHING_TRACED)
}

fn builders(view: &View) -> Section {
    let panel = |scene: &str| {
        let (mut series, mut labels) = (Vec::new(), Vec::new());
        let mine = trees(view, Contest::Trees).filter(|tree| tree.scene == scene);
        for (place, tree) in mine.enumerate() {
            let speed = against_default(view, |t| is_through(t, tree) && is_single(t));
            let (Some(ns), Some(speed)) = (middle(&tree.samples_ns), speed) else { continue };
            series.push(Series::points(Look::of(place), true, vec![(ns / 1e6, speed)]));
            let label = match tree.leaves.as_str() {
                "cheapest" => tree.builder.clone(),
                leaves => format!("{leaves} always"),
            };
            labels.push((ns / 1e6, speed, label));
        }
        let x = Axis::over("ms to build", Scale::Log, points(&series).map(|p| p.0), tick);
        let speeds = points(&series).map(|p| p.1);
        let y =
            Axis::over("over the spatial builder's", Scale::Linear, speeds, ratio).with_margin();
        let is_empty = series.is_empty();
        let plane = Plane { labels, ..Plane::new(scene, x, y, 240, series) };
        (!is_empty).then_some(Panel::Plane(plane))
    };
    let caption = "Trees of Möller–Trumbore, built on all threads, and traced by single rays on one: up, \
                   their speed over that through the spatial builder's tree, round by round, geometric mean \
                   over classes. Up and left is better. The spatial builder's tree also with leaves of up to 16 and 32 triangles always, whether cheaper or \
                   not.";
    let drawing = Drawing::of(scenes(view).into_iter().filter_map(panel).collect());
    Section::figure("study-builders", "Builders: time to build against speed", caption, drawing)
        .missing(NOTHING_TRACED)
}

/// Single rays by threads: the speed over that of one thread, geometric mean over classes.
fn tracing_by_threads(view: &View, scene: &str) -> Vec<(f64, f64)> {
    let all = || traced(view, Contest::Threads).filter(|t| t.scene == scene);
    let mut counts = distinct(all().map(|t| t.threads));
    counts.sort_unstable();
    let point = |threads: usize| {
        let ratios = all().filter(|t| t.threads == threads).filter_map(|mine| {
            let is_one = |t: &&Traced| t.threads == 1 && t.class == mine.class;
            faster(&mine.samples_ns, &all().find(is_one)?.samples_ns)
        });
        Some((threads as f64, geometric_mean(ratios)?))
    };
    counts.into_iter().filter_map(point).collect()
}

/// Building by threads: the speed over that of one thread.
fn building_by_threads(view: &View, scene: &str, builder: &str) -> Vec<(f64, f64)> {
    let is_of = |t: &&TreeBuilt| t.scene == scene && t.builder == builder;
    let all = || trees(view, Contest::Threads).filter(is_of);
    let one = all().find(|t| t.threads == 1);
    let point =
        |mine: &TreeBuilt| Some((mine.threads as f64, faster(&mine.samples_ns, &one?.samples_ns)?));
    all().filter_map(point).collect()
}

fn threads(view: &View) -> Section {
    const LINES: [&str; 4] = ["single rays", "linear builder", "binned builder", "spatial builder"];
    let panel = |scene: &str| {
        let line = |(place, name): (usize, &&str)| {
            let points = match name.strip_suffix(" builder") {
                Some(builder) => building_by_threads(view, scene, builder),
                None => tracing_by_threads(view, scene),
            };
            Series::line(Look::of(place), points)
        };
        let lines = LINES.iter().enumerate().map(line);
        let series: Vec<Series> = lines.filter(|series| !series.points.is_empty()).collect();
        let of_several = points(&series).any(|p| p.0 > 1.0);
        let x = Axis::over("threads", Scale::Binary, points(&series).map(|p| p.0), tick);
        // With air above the highest point.
        let gains = points(&series).map(|p| 1.05 * p.1).chain([0.0]);
        let y = Axis::over("over one thread", Scale::Linear, gains, ratio);
        of_several.then(|| Panel::plane(scene, x, y, 240, series))
    };
    let legend = LINES.iter().enumerate().map(|(i, text)| Entry::of(Look::of(i), *text)).collect();
    let caption = "Speed over that of one thread, round by round: building by each builder, and single rays, \
                   geometric mean over classes. Möller–Trumbore.";
    let is_traced = view.all::<Traced>().next().is_some();
    let missing = if is_traced { "Left out: the record is of one thread." } else { NOTHING_TRACED };
    let panels = scenes(view).into_iter().filter_map(panel).collect();
    let drawing = Drawing { panels, legend, key: Vec::new() };
    Section::figure("study-threads", "Threads", caption, drawing).missing(missing)
}
