//! The figures of the comparison: each picks its numbers from the records.

use std::collections::BTreeMap;

use crate::comparison::record::Family;
use crate::lines::distinct;
use crate::record::Variant;
use trisect_core::FloatFormat;
use trisect_method::{Form, Input};

use super::summary::{ErrorMeasure, FrontPoint, plane};
use super::view::{BASELINE, View, finish_label, lanes_label, need_in_prose};
use trisect_report::document::Section;
use trisect_report::figure::{
    Axis, Drawing, Entry, Group, Ink, Look, Mark, Panel, Plane, Row, Sample, Scale, Series, Shape,
    points,
};
use trisect_report::format::{bytes, mtests, number, percent, ratio, scientific, tick};
use trisect_report::stats::{geometric_mean, pareto_front};

/// All figures, the headline first.
pub(super) fn all(view: &View) -> [Section; 5] {
    [pareto(view), division(view), early_out(view), hit_rate(view), working_set(view)]
}

const NOTHING_TIMED: &str = "Left out: the record holds no throughput.";

/// "over 2 workloads (a, b)": workloads in a caption.
fn on(workloads: &[impl AsRef<str>]) -> String {
    let names: Vec<&str> = workloads.iter().map(AsRef::as_ref).collect();
    match names[..] {
        [] => String::new(),
        [one] => format!("on {one}"),
        _ => format!("over {} workloads ({})", names.len(), names.join(", ")),
    }
}

/// What figures ask of a hit, in a sentence.
fn asked(view: &View) -> &'static str {
    view.main_need().map_or("", need_in_prose)
}

/// Families of methods, in the order of their colours.
const FAMILIES: [&str; 6] =
    ["from points", "stored edges", "stored planes", "volumes", "watertight", "exact"];

/// The place of a method's family in the list.
fn family(view: &View, method: &str) -> usize {
    let facts = view.fact(method);
    let claims = |what: &str| facts.is_some_and(|facts| facts.claims.iter().any(|c| c == what));
    let is_of = |names: &[&str]| names.iter().any(|name| method.starts_with(name));
    match facts.and_then(|facts| facts.input) {
        _ if claims("exact") => 5,
        _ if claims("watertight") => 4,
        _ if is_of(&["plucker", "signed-volumes", "segura-feito", "jimenez"]) => 3,
        Some(Input::Points) => 0,
        _ if is_of(&["moller-trumbore", "kensler-shirley"]) => 1,
        _ => 2,
    }
}

fn pareto(view: &View) -> Section {
    let (points, measure, workloads) = plane(view);
    let (name, says) = match measure {
        ErrorMeasure::OverCondition => (
            "worst error of t over κ·u",
            "the largest error of t over its condition number times the unit roundoff, which is small where a \
             method errs no more than a pair allows",
        ),
        ErrorMeasure::Relative => (
            "error of t, p99",
            "the 99th percentile of the relative error of t against exact arithmetic",
        ),
    };
    let wrong = points.iter().filter_map(|point| {
        Some(FrontPoint {
            error: view.fewest_cracks(|v| v.rounds_like(&point.variant))?,
            ..point.clone()
        })
    });
    let wrong = Plotted {
        id: "wrong-against-time",
        title: "Wrong decisions against run time",
        name: "wrong decisions per million",
        short: "wrong per million",
        write: number,
        says: "how many of a million rays from inside a closed sphere, aimed at its edges, hit nothing, so that a \
               decision about a pair was wrong",
        points: wrong.collect(),
    };
    let error = Plotted {
        id: "error-against-time",
        title: "Error against run time",
        name,
        short: "error",
        write: scientific,
        says,
        points,
    };
    let missing = if view.throughput.is_empty() {
        NOTHING_TIMED
    } else {
        "Left out: the record holds no error of t against the oracle for the variants that it times."
    };
    let [error, wrong] = [error, wrong].map(|of| against_time(view, of, &workloads));
    error.missing(missing).or(wrong)
}

/// What a figure sets against run time.
struct Plotted {
    id: &'static str,
    title: &'static str,
    /// Of the axis, and of a point.
    name: &'static str,
    short: &'static str,
    write: fn(f64) -> String,
    /// The same in a sentence.
    says: &'static str,
    points: Vec<FrontPoint>,
}

/// A panel for each precision.
fn against_time(view: &View, plotted: Plotted, workloads: &[&str]) -> Section {
    let Plotted { id, title, name, short, write, says, points } = plotted;
    // Of each method in each precision the fastest variant: they come fastest first.
    let mut fastest: Vec<&FrontPoint> = Vec::new();
    for point in &points {
        let of = |p: &FrontPoint| (p.variant.method.clone(), p.variant.precision);
        if fastest.iter().all(|other| of(other) != of(point)) {
            fastest.push(point);
        }
    }
    let caption = format!(
        "The fastest variant of each method. Across, nanoseconds per test when asked for {}: geometric mean {} \
         of the median over rounds; up, {says}. For a method on the stepped line none is both faster and more accurate. Those, \
         Möller–Trumbore and what is exact are named, in the colours of their families.",
        asked(view),
        on(workloads)
    );
    let mut told_families = [false; FAMILIES.len()];
    let shown = |point: &FrontPoint, look| {
        let FrontPoint { variant, ns_per_test, error } = point;
        let says = format!(
            "{}, {}; {} ns, {short} {}",
            lanes_label(variant),
            finish_label(variant),
            tick(*ns_per_test),
            write(*error)
        );
        Series::points(look, true, vec![(*ns_per_test, *error)]).of(&*variant.method).says(says)
    };
    let mut panel = |precision: FloatFormat| {
        let mine: Vec<&&FrontPoint> =
            fastest.iter().filter(|p| p.variant.precision == precision).collect();
        let at: Vec<(f64, f64)> = mine.iter().map(|p| (p.ns_per_test, p.error)).collect();
        let front = pareto_front(&at);
        let (mut others, mut told, mut labels) = (Vec::new(), Vec::new(), Vec::new());
        for (place, point) in mine.iter().enumerate() {
            let method = &*point.variant.method;
            let family = family(view, method);
            if front.contains(&place) || method == BASELINE || FAMILIES[family] == "exact" {
                told_families[family] = true;
                told.push(shown(point, Look::of(family)));
                labels.push((at[place].0, at[place].1, method.to_owned()));
            } else {
                others.push(shown(point, Look::plain(Ink::Grid)));
            }
        }
        let mut series = others;
        series.push(Series::front(front.iter().map(|&place| at[place]).collect()));
        series.extend(told);
        let across = at.iter().map(|at| at.0);
        let across = Axis::over("ns per test", Scale::Log, across, tick);
        let up = Axis::over(name, Scale::Log, at.iter().map(|at| at.1), tick);
        let panel = Plane { labels, ..Plane::new(precision.name(), across, up, 360, series) };
        (!at.is_empty()).then_some(Panel::Plane(panel))
    };
    let panels: Vec<Panel> = view.precisions().into_iter().filter_map(&mut panel).collect();
    let told = (0..FAMILIES.len()).filter(|&family| told_families[family]);
    let mut legend: Vec<Entry> =
        told.map(|family| Entry::of(Look::of(family), FAMILIES[family])).collect();
    legend.push(Entry::of(Look::plain(Ink::Grid), "other methods"));
    legend.push(Entry::new(Sample::Line(Ink::Muted), "Pareto front"));
    let drawing = if panels.is_empty() {
        Drawing::default()
    } else {
        Drawing { panels, legend, key: Vec::new() }
    };
    Section::figure(id, title, caption, drawing)
}

/// How lanes are told apart in a figure: by their instruction set, or as no lanes at all.
fn lanes(v: &Variant) -> &'static str {
    if v.width == 1 { "scalar" } else { v.instruction_set.name() }
}

/// Pairs of variants that differ in one field only: the first of each has the field as `first`
/// says. Per first variant: the ratio of throughput, second over first, on each workload.
fn paired<'a>(
    view: &View<'a>,
    first: impl Fn(&Variant) -> bool,
    other: impl Fn(&mut Variant),
) -> Vec<(&'a Variant, BTreeMap<&'a str, f64>)> {
    let need = view.main_need();
    let firsts = view.throughput.iter();
    let firsts = firsts.filter(|(v, _)| Some(v.needs) == need && first(v));
    let ratios = firsts.filter_map(|(v, workloads)| {
        let mut partner = (*v).clone();
        other(&mut partner);
        let ratio = |w: &&'a str| Some((*w, view.ns(v, w)? / view.ns(&partner, w)?));
        let ratios: BTreeMap<&str, f64> = workloads.keys().filter_map(ratio).collect();
        (!ratios.is_empty()).then_some((*v, ratios))
    });
    ratios.collect()
}

/// Ratios around 1, a row for each method: a point for each kind of lanes, and the workload that gains least.
/// The method that gains most comes first.
fn ratios(view: &View, pairs: &[(&Variant, BTreeMap<&str, f64>)], name: &str) -> Drawing {
    let mut sets: Vec<&Variant> = pairs.iter().map(|(v, _)| *v).collect();
    sets.sort_by_key(|v| (v.width > 1, v.instruction_set));
    let sets = distinct(sets.into_iter().map(lanes));
    let row = |method: &str, precision: FloatFormat| {
        let of = || pairs.iter().filter(|(v, _)| v.method == method && v.precision == precision);
        let mean = geometric_mean(of().flat_map(|(_, r)| r.values().copied()))?;
        let mut by_workload: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
        for (v, ratios) in of() {
            for (workload, ratio) in ratios {
                by_workload.entry((lanes(v), workload)).or_default().push(*ratio);
            }
        }
        let worst = by_workload.into_values().filter_map(geometric_mean).fold(mean, f64::min);
        let point = |(place, set): (usize, &&str)| {
            let mine = of().filter(|(v, _)| lanes(v) == *set);
            let at = geometric_mean(mine.flat_map(|(_, r)| r.values().copied()))?;
            let Look { ink, shape } = Look::of(place);
            Some((ink, Mark::Point { at, shape, filled: true }))
        };
        let worst_at = Mark::Point { at: worst, shape: Shape::Circle, filled: false };
        let ends = [(Ink::Muted, Mark::Span(worst, mean)), (Ink::Muted, worst_at)];
        let marks = ends.into_iter().chain(sets.iter().enumerate().filter_map(point)).collect();
        let (label, note) = (method.to_owned(), ratio(mean));
        Some((mean, Row { label, method: method.to_owned(), marks, note }))
    };
    let panels: Vec<(FloatFormat, Vec<Row>)> = view
        .precisions()
        .into_iter()
        .map(|precision| {
            let rows = view.methods().iter().filter_map(|method| row(method, precision));
            let mut rows: Vec<(f64, Row)> = rows.collect();
            rows.sort_by(|a, b| b.0.total_cmp(&a.0));
            (precision, rows.into_iter().map(|(_, row)| row).collect())
        })
        .filter(|(_, rows): &(_, Vec<Row>)| !rows.is_empty())
        .collect();
    if panels.is_empty() {
        return Drawing::default();
    }
    let marks = panels.iter().flat_map(|(_, rows)| rows).flat_map(|row| &row.marks);
    let values = marks.flat_map(|(_, mark)| match *mark {
        Mark::Bar(x) | Mark::Point { at: x, .. } => [x, x],
        Mark::Span(a, b) => [a, b],
    });
    let axis = Axis::over(name, Scale::Linear, values.chain([0.9, 1.1]), ratio).with_margin();
    let draw = |(precision, rows): (FloatFormat, _)| {
        let group = Group { heading: String::new(), rows };
        Panel::rows(precision.name(), axis.clone(), Some(1.0), vec![group])
    };
    let entry = |(place, set): (usize, &&str)| Entry::of(Look::of(place), *set);
    let mut legend: Vec<Entry> = sets.iter().enumerate().map(entry).collect();
    let worst = Sample::Point(Look::plain(Ink::Muted), false);
    legend.push(Entry::new(worst, "the lanes and workload that gain least"));
    Drawing { panels: panels.into_iter().map(draw).collect(), legend, key: Vec::new() }
}

fn division(view: &View) -> Section {
    let pairs = paired(view, |v| v.division == Form::Early, |v| v.division = Form::Deferred);
    let says = "with the division deferred until a hit is certain, over throughput with the division made early";
    let drawing = ratios(view, &pairs, "deferred over early");
    Section::figure("division", "What deferring the division gains", gains(view, says), drawing)
        .missing("Left out: the record times no variant with both early and deferred division.")
}

fn early_out(view: &View) -> Section {
    let pairs = paired(view, |v| !v.early_out, |v| v.early_out = true);
    let says = "of tests that end as soon as no lane can hit, over throughput of tests that compute everything";
    let drawing = ratios(view, &pairs, "early-out over none");
    Section::figure("early-out", "Early-out and its worst case", gains(view, says), drawing)
        .missing("Left out: the record times no variant both with and without early-out.")
}

/// The caption of a figure of ratios.
fn gains(view: &View, says: &str) -> String {
    format!(
        "Throughput {says}, when asked for {}; right of 1× the former wins. A point for each kind of lanes: \
         the geometric mean over all workloads and over the pairs of variants that differ in nothing else; \
         the number is that over all lanes. Methods that gain most come first.",
        asked(view)
    )
}

/// As many lines as can be told apart, without the one that all are compared with.
const LINES: usize = 6;

/// The methods that are told apart in figures of lines: the fastest, and the one that all are
/// compared with.
pub(crate) fn fastest_methods<'a>(view: &View<'a>) -> Vec<&'a str> {
    let scores = view.comparable(|v| Some(v.needs) == view.main_need()).scores();
    let mut methods = distinct(scores.iter().map(|(v, _)| v.method.as_ref()));
    methods.truncate(LINES);
    distinct(methods.into_iter().chain([BASELINE]))
}

/// Lines of throughput over a series of workloads.
#[derive(Default)]
struct Lines {
    legend: Vec<Entry>,
    series: Vec<Series>,
    /// Which variants they are of, for the caption.
    said: Vec<String>,
}

/// A line per method: its fastest f32 variant `among` those asked for, or f64 where there is no other.
fn lines(
    view: &View,
    family: Family,
    x: impl Fn(&Variant, &str) -> Option<f64>,
    among: impl Fn(&Variant) -> bool,
) -> Lines {
    let names: Vec<&str> = view.family(family).iter().map(|w| w.name.as_str()).collect();
    let mut lines = Lines::default();
    let shown = fastest_methods(view);
    for &method in view.methods().iter().filter(|method| shown.contains(*method)) {
        let fastest = view.precisions().into_iter().find_map(|precision| {
            let keep = |v: &Variant| {
                Some(v.needs) == view.main_need()
                    && v.method == method
                    && v.precision == precision
                    && among(v)
            };
            let on = view.comparable_on(keep, |w| names.contains(&w));
            on.scores().first().map(|(v, _)| *v)
        });
        let Some(variant) = fastest else { continue };
        let point = |w: &&str| Some((x(variant, w)?, mtests(view.ns(variant, w)?)));
        let mut points: Vec<(f64, f64)> = names.iter().filter_map(point).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (look, title) = (view.look(method), view.title(method));
        let said = format!("{title}: {}, {}", lanes_label(variant), finish_label(variant));
        lines.legend.push(Entry::of(look, title).lit_with(method));
        lines.series.push(Series::line(look, points).of(method));
        lines.said.push(said);
    }
    lines
}

/// One panel of lines, whose vertical axis holds `top`, so that panels can be compared.
fn lines_panel(
    title: &str,
    (name, scale, write): (&str, Scale, fn(f64) -> String),
    top: f64,
    series: Vec<Series>,
) -> Panel {
    let x = Axis::over(name, scale, points(&series).map(|p| p.0), write);
    let y = Axis::over("million tests per second", Scale::Linear, [0.0, top * 1.05], tick);
    Panel::plane(title, x, y, 300, series)
}

/// The largest speed of the lines.
fn top_speed(series: &[Series]) -> f64 {
    points(series).map(|p| p.1).fold(0.0, f64::max)
}

fn hit_rate(view: &View) -> Section {
    let share = |_: &Variant, w: &str| view.workloads.get(w).map(|w| w.hit_rate * 100.0);
    let sides =
        [("Without early-out", false), ("With early-out", true)].map(|(title, early_out)| {
            (title, lines(view, Family::HitRate, share, |v| v.early_out == early_out))
        });
    let top = sides.iter().map(|(_, lines)| top_speed(&lines.series)).fold(0.0, f64::max);
    let mut drawing = Drawing::default();
    let mut all_said = Vec::new();
    for (title, Lines { legend, series, said }) in sides {
        if series.is_empty() {
            continue;
        }
        drawing.panels.push(lines_panel(
            title,
            ("tests that hit", Scale::Linear, percent),
            top,
            series,
        ));
        drawing.legend = legend;
        all_said.extend(said);
    }
    let caption = format!(
        "How the share of tests that hit changes the speed of the fastest variant of each of the fastest \
         methods, and of Möller–Trumbore, over this series, when asked for {}. A branch that leaves early \
         costs most where it is hardest to foresee. {}.",
        asked(view),
        all_said.join("; ")
    );
    Section::figure("hit-rate", "Throughput against hit rate", caption, drawing)
        .missing("Left out: the record times no workloads of the hit-rate family.")
}

fn working_set(view: &View) -> Section {
    let size = |v: &Variant, w: &str| {
        let timed = view.throughput.get(v)?.get(w)?;
        let triangles = view.workloads.get(w)?.triangles;
        Some(triangles as f64 * timed.bytes_per_triangle as f64)
    };
    let Lines { legend, series, said } = lines(view, Family::WorkingSet, size, |_| true);
    let caption = format!(
        "The speed of the fastest variant of each of the fastest methods, and of Möller–Trumbore, against \
         the size of the prepared triangles: their number times the bytes that the method reads for each, \
         so that a method that stores more moves to the right. Asked for {}. {}.",
        asked(view),
        said.join("; ")
    );
    let mut drawing = Drawing { legend, ..Drawing::default() };
    if !series.is_empty() {
        let top = top_speed(&series);
        let x: (_, _, fn(f64) -> _) = ("prepared triangles", Scale::Binary, bytes);
        drawing.panels.push(lines_panel("", x, top, series));
    }
    Section::figure("working-set", "Throughput against working set", caption, drawing)
        .missing("Left out: the record times no workloads of the working-set family.")
}
