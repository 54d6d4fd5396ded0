//! The figures of the comparison: each picks its numbers from the records.

use std::collections::BTreeMap;

use crate::comparison::record::Family;
use crate::record::Variant;
use trisect_core::FloatFormat::{self, F32, F64};
use trisect_core::InstructionSet;
use trisect_method::Form;

use super::summary::{Plane as Variants, plane};
use super::view::{BASELINE, View, finish_label, lanes_label, need_in_prose};
use trisect_report::document::Section;
use trisect_report::figure::{
    Axis, Drawing, Entry, Group, Ink, Look, Mark, Panel, Plane, Row, Sample, Scale, Series, Shape,
    points,
};
use trisect_report::format::{bytes, mtests, number, percent, ratio, tick};
use trisect_report::stats::geometric_mean;

/// All figures, the headline first.
pub(super) fn all(view: &View) -> [Section; 7] {
    [
        pareto(view),
        throughput(view),
        error(view),
        division(view),
        early_out(view),
        hit_rate(view),
        working_set(view),
    ]
}

const NOTHING_TIMED: &str = "Left out: the record holds no throughput.";

/// A method's title with its year.
fn heading(view: &View, method: &str) -> String {
    let year = view.fact(method).map(|m| format!(" ({})", m.year)).unwrap_or_default();
    format!("{}{year}", view.title(method))
}

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

fn pareto(view: &View) -> Section {
    let plane = plane(view);
    let reference = view
        .pooled_error((BASELINE, F64), "t", |v| v.width == 1)
        .or_else(|| view.pooled_error((BASELINE, F64), "t", |_| true))
        .map(|q| q.median);
    let mut caption = format!(
        "Each point is one variant: a method in one precision, width, arithmetic and form of division, in \
         its fastest arrangement and with or without early-out, whichever is faster. Across, nanoseconds \
         per test when asked for {}: geometric mean {} of the median over rounds. Up, the median relative \
         error of t against exact arithmetic. The stepped line is the Pareto front: for a variant on it, \
         none is both faster and more accurate.",
        asked(view),
        on(&plane.workloads)
    );
    if reference.is_some() {
        caption += " The dashed line is the error of the usual reference, Möller–Trumbore in double precision.";
    }
    let errors = || plane.points.iter().map(|p| p.error).chain(reference);
    let up = Axis::over("median relative error of t", Scale::Log, errors(), tick).broken(errors());
    if up.is_broken() {
        caption += " The vertical axis is cut where no point lies over three decades.";
    }
    let missing = if view.throughput.is_empty() {
        NOTHING_TIMED
    } else {
        "Left out: the record holds no error of t against the oracle for the variants that it times."
    };
    let drawing = if plane.points.is_empty() {
        Drawing::default()
    } else {
        pareto_drawing(view, &plane, reference, up)
    };
    Section::figure("error-against-time", "Error against run time", caption, drawing)
        .missing(missing)
}

fn pareto_drawing(view: &View, plane: &Variants, reference: Option<f64>, up: Axis) -> Drawing {
    let at = |i: &usize| (plane.points[*i].ns_per_test, plane.points[*i].error);
    let front: Vec<(f64, f64)> = plane.front.iter().map(at).collect();
    let of = |keep: &dyn Fn(&Variant) -> bool| {
        let points = plane.points.iter().filter(|p| keep(&p.variant));
        points.map(|p| (p.ns_per_test, p.error)).collect::<Vec<_>>()
    };
    let mut series = vec![Series::front(front.clone())];
    let mut legend = Vec::new();
    for &method in view.methods() {
        let look = view.look(method);
        for (precision, filled) in [(F64, false), (F32, true)] {
            let points = of(&|v| v.method == method && v.precision == precision);
            series.push(Series::points(look, filled, points));
        }
        if plane.points.iter().any(|p| p.variant.method == method) {
            legend.push(Entry::of(look, view.title(method)));
        }
    }
    for (precision, filled) in [(F32, true), (F64, false)] {
        if plane.points.iter().any(|p| p.variant.precision == precision) {
            legend
                .push(Entry::new(Sample::Point(Look::plain(Ink::Muted), filled), precision.name()));
        }
    }
    legend.push(Entry::new(Sample::Line(Ink::Muted), "Pareto front"));
    legend.extend(reference.map(|_| Entry::new(Sample::Dashes, "error of f64 Möller–Trumbore")));
    let labels = front.iter().enumerate().map(|(i, &(x, y))| (x, y, (i + 1).to_string()));
    let key = plane.front.iter().enumerate().map(|(i, &p)| {
        let v = &plane.points[p].variant;
        format!("{}  {}, {}, {}", i + 1, view.title(&v.method), lanes_label(v), v.division)
    });
    let across = plane.points.iter().map(|p| p.ns_per_test);
    let across = Axis::over("ns per test", Scale::Log, across, tick);
    let panel = Plane {
        rules: reference.into_iter().collect(),
        labels: labels.collect(),
        ..Plane::new("", across, up, 380, series)
    };
    Drawing { panels: vec![Panel::Plane(panel)], legend, key: key.collect() }
}

/// Instruction sets and widths of one precision, narrowest first, as rows ask for them.
fn lanes(view: &View, precision: FloatFormat) -> Vec<(usize, InstructionSet)> {
    let of = view.throughput.keys().filter(|v| v.precision == precision);
    let mut all: Vec<_> = of.map(|v| (v.width, v.instruction_set)).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Per precision, its title and methods with the rows that there are of each.
fn by_method(
    view: &View,
    rows: impl Fn(&str, FloatFormat) -> Vec<Row>,
) -> Vec<(String, Vec<Group>)> {
    let panel = |precision: FloatFormat| {
        let title = match precision {
            F32 => "Single precision (f32)",
            F64 => "Double precision (f64)",
        };
        let group = |&method: &&str| Group {
            heading: heading(view, method),
            rows: rows(method, precision),
        };
        let groups = view.methods().iter().map(group).filter(|group| !group.rows.is_empty());
        (title.to_owned(), groups.collect::<Vec<_>>())
    };
    let panels = view.precisions().into_iter().map(panel);
    panels.filter(|(_, groups)| !groups.is_empty()).collect()
}

/// The same with a row for each width for which `row` has something to show.
fn by_lanes(
    view: &View,
    row: impl Fn(&dyn Fn(&Variant) -> bool) -> Option<(Vec<Mark>, String)>,
) -> Vec<(String, Vec<Group>)> {
    by_method(view, |method, precision| {
        let row = |(width, set): (usize, InstructionSet)| {
            let (marks, note) = row(&|v| {
                v.method == method
                    && v.precision == precision
                    && v.width == width
                    && v.instruction_set == set
            })?;
            let label = if width == 1 { "scalar".into() } else { format!("{set} ×{width}") };
            Some(Row { label, ink: view.look(method).ink, marks, note })
        };
        lanes(view, precision).into_iter().filter_map(row).collect()
    })
}

/// All values that rows show, to lay an axis over them.
fn values(groups: &[Group]) -> impl Iterator<Item = f64> {
    groups.iter().flat_map(|g| &g.rows).flat_map(|r| &r.marks).flat_map(|mark| match *mark {
        Mark::Bar(x) | Mark::Point { at: x, .. } => [x, x],
        Mark::Span(a, b) => [a, b],
    })
}

fn throughput(view: &View) -> Section {
    let comparable = view.comparable(|v| Some(v.needs) == view.main_need());
    let scores = comparable.scores();
    let panels = by_lanes(view, |is| {
        let (_, ns) = scores.iter().find(|(v, _)| is(v))?;
        Some((vec![Mark::Bar(mtests(*ns))], number(mtests(*ns))))
    });
    let shown: Vec<f64> = panels.iter().flat_map(|(_, g)| values(g)).chain([0.0]).collect();
    let axis = Axis::over("million tests per second", Scale::Linear, shown, tick);
    let draw = |(title, groups): (String, _)| Panel::rows(&title, axis.clone(), None, groups);
    let caption = format!(
        "Million tests per second when asked for {}: the fastest division, arithmetic, arrangement and \
         early-out of each method at each width, by the geometric mean {} of the median over rounds.",
        asked(view),
        on(&comparable.workloads)
    );
    let drawing = Drawing::of(panels.into_iter().map(draw).collect());
    Section::figure("throughput", "Throughput by method and width", caption, drawing)
        .missing(NOTHING_TIMED)
}

fn error(view: &View) -> Section {
    let symbols =
        [("t", "t", Shape::Circle), ("beta", "β", Shape::Square), ("gamma", "γ", Shape::Up)];
    let panels = by_method(view, |method, precision| {
        let row = |(quantity, label, shape): (&str, &str, Shape)| {
            let q = view.pooled_error((method, precision), quantity, |_| true)?;
            let point = |at, filled| Mark::Point { at, shape, filled };
            let span = Mark::Span(q.median, q.max);
            let marks = vec![span, point(q.max, false), point(q.p99, false), point(q.median, true)];
            Some(Row {
                label: label.into(),
                ink: view.look(method).ink,
                marks,
                note: String::new(),
            })
        };
        symbols.into_iter().filter_map(row).collect()
    });
    let draw = |(title, groups): (String, Vec<Group>)| {
        let axis = Axis::over("relative error", Scale::Log, values(&groups), tick);
        Panel::rows(&title, axis, None, groups)
    };
    let caption = "Relative errors of t, β and γ against exact arithmetic, over the hits that a method \
                   shares with the oracle. Filled: the median; hollow: the 99th percentile, then the \
                   largest. Median and percentile are medians over variants and workloads; the largest is \
                   the largest of all. A point on 0 is exact.";
    let drawing = Drawing::of(panels.into_iter().map(draw).collect());
    Section::figure("error", "Error by method", caption, drawing)
        .missing("Left out: the record holds no errors against the oracle.")
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

/// Rows of ratios around 1: the mean of each and its worst workload.
fn ratios(view: &View, pairs: &[(&Variant, BTreeMap<&str, f64>)], name: &str) -> Drawing {
    let panels = by_lanes(view, |is| {
        let mine = || pairs.iter().filter(|(v, _)| is(v)).flat_map(|(_, r)| r);
        let mean = geometric_mean(mine().map(|(_, ratio)| *ratio))?;
        let mut by_workload: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for (w, ratio) in mine() {
            by_workload.entry(w).or_default().push(*ratio);
        }
        let means = by_workload.into_values().filter_map(geometric_mean);
        let worst = means.fold(f64::INFINITY, f64::min);
        let point = |at, filled| Mark::Point { at, shape: Shape::Circle, filled };
        let spans = [Mark::Span(worst, mean), Mark::Span(1.0, mean)];
        Some(([&spans[..], &[point(worst, false), point(mean, true)]].concat(), ratio(mean)))
    });
    let shown = panels.iter().flat_map(|(_, g)| values(g)).chain([0.9, 1.1]);
    let axis = Axis::over(name, Scale::Linear, shown, ratio).with_margin();
    let draw = |(title, groups): (String, _)| Panel::rows(&title, axis.clone(), Some(1.0), groups);
    Drawing::of(panels.into_iter().map(draw).collect())
}

fn division(view: &View) -> Section {
    let pairs = paired(view, |v| v.division == Form::Early, |v| v.division = Form::Deferred);
    let caption = format!(
        "Throughput with the division deferred until a hit is certain, over throughput with the division \
         made early, when asked for {}; right of 1×, deferring wins. Filled: the geometric mean over all \
         workloads and over the pairs of variants that differ in nothing else; hollow: the workload that \
         gains least.",
        asked(view)
    );
    let drawing = ratios(view, &pairs, "deferred over early");
    Section::figure("division", "What deferring the division gains", caption, drawing)
        .missing("Left out: the record times no variant with both early and deferred division.")
}

fn early_out(view: &View) -> Section {
    let pairs = paired(view, |v| !v.early_out, |v| v.early_out = true);
    let caption = format!(
        "Throughput of tests that end as soon as no lane can hit, over throughput of tests that compute \
         everything, when asked for {}; right of 1×, leaving early wins. Filled: the geometric mean over \
         all workloads and over the pairs of variants that differ in nothing else. Hollow: the workload \
         that gains least, the worst case in which hits block the way out and the branch only costs.",
        asked(view)
    );
    let drawing = ratios(view, &pairs, "early-out over none");
    Section::figure("early-out", "Early-out and its worst case", caption, drawing)
        .missing("Left out: the record times no variant both with and without early-out.")
}

/// As many lines as can be told apart, without the one that all are compared with.
const LINES: usize = 7;

/// The methods that are told apart in figures of lines: the fastest, and the one that all are
/// compared with.
pub(crate) fn fastest_methods<'a>(view: &View<'a>) -> Vec<&'a str> {
    let scores = view.comparable(|v| Some(v.needs) == view.main_need()).scores();
    let mut methods = crate::lines::distinct(scores.iter().map(|(v, _)| v.method.as_ref()));
    methods.truncate(LINES);
    methods.push(BASELINE);
    methods
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
        lines.legend.push(Entry::of(look, title));
        lines.series.push(Series::line(look, points));
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
