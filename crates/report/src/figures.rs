//! The figures: each picks its numbers from the records and hands them to a chart function.

use std::collections::BTreeMap;

use trisect_core::{FloatFormat, Form, InstructionSet};
use trisect_harness::record::{Family, Variant};

use crate::chart::{
    Axis, Drawing, Entry, Group, Join, Look, Mark, Panel, Plane, Row, Rows, Sample, Scale, Series,
    Shape,
};
use crate::format::{bytes, mtests, number, or_dash, ratio, tick};
use crate::stats::geometric_mean;
use crate::summary;
use crate::theme::Ink;
use crate::view::{BASELINE, View, finish_label, lanes_label, need_in_prose};

/// A figure before it is drawn.
pub(crate) struct Figure {
    /// Name of its file.
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    pub(crate) caption: String,
    /// Or the sentence that says which records lack.
    pub(crate) drawing: Result<Drawing, String>,
}

/// All figures, the headline first.
pub(crate) fn all(view: &View) -> Vec<Figure> {
    vec![
        pareto(view),
        throughput(view),
        error(view),
        division(view),
        early_out(view),
        hit_rate(view),
        working_set(view),
    ]
}

/// The look that a method has in every figure.
pub(crate) fn look(view: &View, method: &str) -> Look {
    Look::of(view.methods().iter().position(|m| *m == method).unwrap_or(0))
}

fn heading(view: &View, method: &str) -> String {
    let year = view.fact(method).map(|m| format!(" ({})", m.year)).unwrap_or_default();
    format!("{}{year}", view.title(method))
}

fn nothing_timed() -> String {
    "Left out: the record holds no throughput.".into()
}

/// "on random and three others": workloads in a caption.
fn on(workloads: &[impl AsRef<str>]) -> String {
    match workloads {
        [] => String::new(),
        [one] => format!("on {}", one.as_ref()),
        many => {
            let names: Vec<&str> = many.iter().map(AsRef::as_ref).collect();
            format!("over {} workloads ({})", many.len(), names.join(", "))
        }
    }
}

fn pareto(view: &View) -> Figure {
    let plane = summary::plane(view);
    let need = view.main_need().map(need_in_prose).unwrap_or_default();
    let reference: Vec<f64> = view
        .pooled_error((BASELINE, FloatFormat::F64), "t", |v| v.width == 1)
        .or_else(|| view.pooled_error((BASELINE, FloatFormat::F64), "t", |_| true))
        .map(|q| q.median)
        .into_iter()
        .collect();
    let mut caption = format!(
        "Each point is one variant: a method in one precision, width, arithmetic and form of \
         division, in its fastest arrangement and with or without early-out, whichever is \
         faster. Across, nanoseconds per test when asked for {need}: geometric mean {} of the \
         median over rounds. Up, the median relative error of t against exact arithmetic. The \
         stepped line is the Pareto front: for a variant on it, none is both faster and more \
         accurate.",
        on(&plane.workloads)
    );
    if !reference.is_empty() {
        caption.push_str(
            " The dashed line is the error of the usual reference, Möller–Trumbore in double \
             precision.",
        );
    }
    let errors: Vec<f64> =
        plane.points.iter().map(|p| p.error).chain(reference.iter().copied()).collect();
    let up =
        Axis::over("median relative error of t", Scale::Log, errors.clone(), tick).broken(errors);
    if up.is_broken() {
        caption.push_str(" The vertical axis is cut where no point lies over three decades.");
    }
    let drawing = if view.throughput.is_empty() {
        Err(nothing_timed())
    } else if plane.points.is_empty() {
        Err("Left out: the record holds no error of t against the oracle for the variants that \
             it times."
            .into())
    } else {
        Ok(pareto_drawing(view, &plane, &reference, up))
    };
    Figure { name: "error-against-time", title: "Error against run time", caption, drawing }
}

fn pareto_drawing(view: &View, plane: &summary::Plane, reference: &[f64], up: Axis) -> Drawing {
    let at = |i: &usize| (plane.points[*i].ns_per_test, plane.points[*i].error);
    let front: Vec<(f64, f64)> = plane.front.iter().map(at).collect();
    let mut series = vec![Series {
        look: Look { ink: Ink::Muted, shape: Shape::Circle },
        filled: true,
        join: Join::Step,
        marked: false,
        points: front.clone(),
    }];
    let mut legend = Vec::new();
    for &method in view.methods() {
        let look = look(view, method);
        let mut found = false;
        for (precision, filled) in [(FloatFormat::F64, false), (FloatFormat::F32, true)] {
            let points: Vec<(f64, f64)> = plane
                .points
                .iter()
                .filter(|p| p.variant.method == method && p.variant.precision == precision)
                .map(|p| (p.ns_per_test, p.error))
                .collect();
            found |= !points.is_empty();
            series.push(Series { look, filled, join: Join::No, marked: true, points });
        }
        if found {
            legend.push(Entry { sample: Sample::Point(look, true), text: view.title(method) });
        }
    }
    for (precision, filled) in [(FloatFormat::F32, true), (FloatFormat::F64, false)] {
        if plane.points.iter().any(|p| p.variant.precision == precision) {
            let look = Look { ink: Ink::Muted, shape: Shape::Circle };
            legend.push(Entry { sample: Sample::Point(look, filled), text: precision.to_string() });
        }
    }
    legend.push(Entry { sample: Sample::Line(Ink::Muted), text: "Pareto front".into() });
    if !reference.is_empty() {
        let text = "error of f64 Möller–Trumbore".into();
        legend.push(Entry { sample: Sample::Dashes, text });
    }
    let labels = front.iter().enumerate().map(|(i, &(x, y))| (x, y, (i + 1).to_string()));
    let key = plane.front.iter().enumerate().map(|(i, &p)| {
        let v = &plane.points[p].variant;
        format!("{}  {}, {}, {}", i + 1, view.title(&v.method), lanes_label(v), v.division)
    });
    let points = &plane.points;
    Drawing {
        panels: vec![Panel::Plane(Plane {
            title: String::new(),
            x: Axis::over("ns per test", Scale::Log, points.iter().map(|p| p.ns_per_test), tick),
            y: up,
            height: 380,
            series,
            rules: reference.to_vec(),
            labels: labels.collect(),
        })],
        legend,
        key: key.collect(),
    }
}

/// Instruction sets and widths of one precision, narrowest first, as rows ask for them.
fn lanes(view: &View, precision: FloatFormat) -> Vec<(usize, InstructionSet)> {
    let mut all: Vec<(usize, InstructionSet)> = view
        .throughput
        .keys()
        .filter(|v| v.precision == precision)
        .map(|v| (v.width, v.instruction_set))
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn lane_name(width: usize, instruction_set: InstructionSet) -> String {
    if width == 1 { "scalar".into() } else { format!("{instruction_set} ×{width}") }
}

/// Per precision, methods with a row for each width for which `row` has something to show.
fn rows_by_lanes(
    view: &View,
    mut row: impl FnMut(&str, &dyn Fn(&Variant) -> bool) -> Option<(Vec<Mark>, String)>,
) -> Vec<(FloatFormat, Vec<Group>)> {
    let mut panels = Vec::new();
    for precision in view.precisions() {
        let mut groups = Vec::new();
        for &method in view.methods() {
            let rows: Vec<Row> = lanes(view, precision)
                .into_iter()
                .filter_map(|(width, set)| {
                    let is = |v: &Variant| {
                        v.method == method
                            && v.precision == precision
                            && v.width == width
                            && v.instruction_set == set
                    };
                    let (marks, note) = row(method, &is)?;
                    let label = lane_name(width, set);
                    Some(Row { label, ink: look(view, method).ink, marks, note })
                })
                .collect();
            if !rows.is_empty() {
                groups.push(Group { heading: heading(view, method), rows });
            }
        }
        if !groups.is_empty() {
            panels.push((precision, groups));
        }
    }
    panels
}

/// All values that rows show, to lay an axis over them.
fn values(panels: &[(FloatFormat, Vec<Group>)]) -> Vec<f64> {
    let marks = panels.iter().flat_map(|(_, g)| g).flat_map(|g| &g.rows).flat_map(|r| &r.marks);
    marks
        .flat_map(|m| match *m {
            Mark::Bar(x) => vec![x],
            Mark::Span(a, b) => vec![a, b],
            Mark::Point { at, .. } => vec![at],
        })
        .collect()
}

fn precision_title(precision: FloatFormat) -> &'static str {
    match precision {
        FloatFormat::F32 => "Single precision (f32)",
        FloatFormat::F64 => "Double precision (f64)",
    }
}

fn throughput(view: &View) -> Figure {
    let need = view.main_need();
    let comparable = view.comparable(|v| Some(v.needs) == need);
    let scores = comparable.scores();
    let panels = rows_by_lanes(view, |_, is| {
        let (_, ns) = scores.iter().find(|(v, _)| is(v))?;
        Some((vec![Mark::Bar(mtests(*ns))], number(mtests(*ns))))
    });
    let drawing = if panels.is_empty() {
        Err(nothing_timed())
    } else {
        let shown = values(&panels);
        let draw = |(precision, groups): (FloatFormat, Vec<Group>)| {
            let axis = shown.iter().copied().chain([0.0]);
            let axis = Axis::over("million tests per second", Scale::Linear, axis, tick);
            Panel::Rows(Rows::new(precision_title(precision), axis, None, groups))
        };
        Ok(Drawing { panels: panels.into_iter().map(draw).collect(), ..Drawing::default() })
    };
    Figure {
        name: "throughput",
        title: "Throughput by method and width",
        caption: format!(
            "Million tests per second when asked for {}: the fastest division, arithmetic, \
             arrangement and early-out of each method at each width, by the geometric mean {} \
             of the median over rounds.",
            view.main_need_in_prose(),
            on(&comparable.workloads)
        ),
        drawing,
    }
}

fn error(view: &View) -> Figure {
    let symbols =
        [("t", "t", Shape::Circle), ("beta", "β", Shape::Square), ("gamma", "γ", Shape::Up)];
    let mut panels = Vec::new();
    for precision in view.precisions() {
        let mut groups = Vec::new();
        for &method in view.methods() {
            let rows: Vec<Row> = symbols
                .iter()
                .filter_map(|&(quantity, label, shape)| {
                    let q = view.pooled_error((method, precision), quantity, |_| true)?;
                    let point = |at, filled| Mark::Point { at, shape, filled };
                    let marks = vec![
                        Mark::Span(q.median, q.max),
                        point(q.max, false),
                        point(q.p99, false),
                        point(q.median, true),
                    ];
                    Some(Row {
                        label: label.into(),
                        ink: look(view, method).ink,
                        marks,
                        note: String::new(),
                    })
                })
                .collect();
            if !rows.is_empty() {
                groups.push(Group { heading: heading(view, method), rows });
            }
        }
        if !groups.is_empty() {
            panels.push((precision, groups));
        }
    }
    let drawing = if panels.is_empty() {
        Err("Left out: the record holds no errors against the oracle.".into())
    } else {
        let panels = panels
            .into_iter()
            .map(|panel| {
                let shown = values(std::slice::from_ref(&panel));
                let axis = Axis::over("relative error", Scale::Log, shown, tick);
                Panel::Rows(Rows::new(precision_title(panel.0), axis, None, panel.1))
            })
            .collect();
        Ok(Drawing { panels, ..Drawing::default() })
    };
    Figure {
        name: "error",
        title: "Error by method",
        caption: "Relative errors of t, β and γ against exact arithmetic, over the hits that a \
                  method shares with the oracle. Filled: the median; hollow: the 99th percentile, \
                  then the largest. Median and percentile are medians over variants and \
                  workloads; the largest is the largest of all. A point on 0 is exact."
            .into(),
        drawing,
    }
}

/// Pairs of variants that differ in one field only: the first of each has the field as `first`
/// says. Per first variant: the ratio of throughput, second over first, on each workload.
fn paired<'a>(
    view: &View<'a>,
    first: impl Fn(&Variant) -> bool,
    other: impl Fn(&mut Variant),
) -> Vec<(&'a Variant, BTreeMap<&'a str, f64>)> {
    let need = view.main_need();
    view.throughput
        .iter()
        .filter(|(v, _)| Some(v.needs) == need && first(v))
        .filter_map(|(v, workloads)| {
            let mut partner = (*v).clone();
            other(&mut partner);
            let ratios: BTreeMap<&str, f64> = workloads
                .keys()
                .filter_map(|w| Some((*w, view.ns(v, w)? / view.ns(&partner, w)?)))
                .collect();
            (!ratios.is_empty()).then_some((*v, ratios))
        })
        .collect()
}

/// Rows of ratios around 1: the mean of each and its worst workload.
fn ratio_rows(
    view: &View,
    pairs: &[(&Variant, BTreeMap<&str, f64>)],
    name: &str,
) -> Option<Drawing> {
    let panels = rows_by_lanes(view, |_, is| {
        let mine: Vec<&BTreeMap<&str, f64>> =
            pairs.iter().filter(|(v, _)| is(v)).map(|(_, r)| r).collect();
        let mean = geometric_mean(mine.iter().flat_map(|r| r.values().copied()))?;
        let mut by_workload: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for (w, ratio) in mine.iter().flat_map(|r| r.iter()) {
            by_workload.entry(w).or_default().push(*ratio);
        }
        let worst =
            by_workload.into_values().filter_map(geometric_mean).fold(f64::INFINITY, f64::min);
        let shape = Shape::Circle;
        let marks = vec![
            Mark::Span(worst, mean),
            Mark::Span(1.0, mean),
            Mark::Point { at: worst, shape, filled: false },
            Mark::Point { at: mean, shape, filled: true },
        ];
        Some((marks, ratio(mean)))
    });
    if panels.is_empty() {
        return None;
    }
    let shown = values(&panels);
    let draw = |(precision, groups): (FloatFormat, Vec<Group>)| {
        let spread = shown.iter().copied().chain([0.9, 1.1]);
        let axis = Axis::over(name, Scale::Linear, spread, ratio).with_margin();
        Panel::Rows(Rows::new(precision_title(precision), axis, Some(1.0), groups))
    };
    Some(Drawing { panels: panels.into_iter().map(draw).collect(), ..Drawing::default() })
}

fn division(view: &View) -> Figure {
    let pairs = paired(view, |v| v.division == Form::Early, |v| v.division = Form::Deferred);
    Figure {
        name: "division",
        title: "What deferring the division gains",
        caption: format!(
            "Throughput with the division deferred until a hit is certain, over throughput with \
             the division made early, when asked for {}; right of 1×, deferring wins. Filled: \
             the geometric mean over all workloads and over the pairs of variants that differ in \
             nothing else; hollow: the workload that gains least.",
            view.main_need_in_prose()
        ),
        drawing: ratio_rows(view, &pairs, "deferred over early").ok_or_else(|| {
            "Left out: the record times no variant with both early and deferred division.".into()
        }),
    }
}

fn early_out(view: &View) -> Figure {
    let pairs = paired(view, |v| !v.early_out, |v| v.early_out = true);
    Figure {
        name: "early-out",
        title: "Early-out and its worst case",
        caption: format!(
            "Throughput of tests that end as soon as no lane can hit, over throughput of tests \
             that compute everything, when asked for {}; right of 1×, leaving early wins. \
             Filled: the geometric mean over all workloads and over the pairs of variants that \
             differ in nothing else. Hollow: the workload that gains least, the worst case in \
             which hits block the way out and the branch only costs.",
            view.main_need_in_prose()
        ),
        drawing: ratio_rows(view, &pairs, "early-out over none").ok_or_else(|| {
            "Left out: the record times no variant both with and without early-out.".into()
        }),
    }
}

/// As many lines as can be told apart, without the one that all are compared with.
const LINES: usize = 7;

/// The methods that are told apart in figures of lines: the fastest, and the one that all are
/// compared with.
pub(crate) fn fastest_methods<'a>(view: &View<'a>) -> Vec<&'a str> {
    let scores = view.comparable(|v| Some(v.needs) == view.main_need()).scores();
    let mut methods: Vec<&str> = Vec::new();
    for (variant, _) in scores {
        let method = variant.method.as_ref();
        if !methods.contains(&method) && methods.len() < LINES {
            methods.push(method);
        }
    }
    methods.push(BASELINE);
    methods
}

/// Lines of throughput over a series of workloads, one per method: its fastest f32 variant
/// `among` those asked for, or f64 where there is no other. Also those variants, for the caption.
fn series_lines(
    view: &View,
    family: Family,
    x: impl Fn(&Variant, &str) -> Option<f64>,
    among: impl Fn(&Variant) -> bool,
) -> (Vec<Entry>, Vec<Series>, Vec<String>) {
    let names: Vec<&str> = view.family(family).iter().map(|w| w.name.as_str()).collect();
    let (mut legend, mut lines, mut said) = (Vec::new(), Vec::new(), Vec::new());
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
        let mut points: Vec<(f64, f64)> = names
            .iter()
            .filter_map(|w| Some((x(variant, w)?, mtests(view.ns(variant, w)?))))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let look = look(view, method);
        legend.push(Entry { sample: Sample::Point(look, true), text: view.title(method) });
        lines.push(Series { look, filled: true, join: Join::Straight, marked: true, points });
        said.push(format!(
            "{}: {}, {}",
            view.title(method),
            lanes_label(variant),
            finish_label(variant)
        ));
    }
    (legend, lines, said)
}

/// One panel of lines. `top` is a speed that the axis reaches, so that panels can be compared.
fn lines_panel(
    title: &str,
    x: (&str, Scale, fn(f64) -> String),
    top: f64,
    series: Vec<Series>,
) -> Panel {
    let points = || series.iter().flat_map(|s| s.points.iter());
    let across = Axis::over(x.0, x.1, points().map(|p| p.0), x.2);
    let y = Axis::over("million tests per second", Scale::Linear, [0.0, top * 1.05], tick);
    Panel::Plane(Plane {
        title: title.into(),
        x: across,
        y,
        height: 300,
        series,
        rules: Vec::new(),
        labels: Vec::new(),
    })
}

/// The largest speed of the lines.
fn top_speed(series: &[Series]) -> f64 {
    series.iter().flat_map(|s| &s.points).map(|p| p.1).fold(0.0, f64::max)
}

pub(crate) fn percent(x: f64) -> String {
    format!("{} %", tick((x * 10.0).round() / 10.0))
}

fn hit_rate(view: &View) -> Figure {
    let share = |_: &Variant, w: &str| view.workloads.get(w).map(|w| w.hit_rate * 100.0);
    let sides =
        [("Without early-out", false), ("With early-out", true)].map(|(title, early_out)| {
            let (legend, series, said) =
                series_lines(view, Family::HitRate, share, |v| v.early_out == early_out);
            (title, legend, series, said)
        });
    let top = sides.iter().map(|side| top_speed(&side.2)).fold(0.0, f64::max);
    let mut drawing = Drawing { panels: Vec::new(), legend: Vec::new(), key: Vec::new() };
    let mut said = Vec::new();
    for (title, legend, series, variants) in sides {
        if series.is_empty() {
            continue;
        }
        let x: (_, _, fn(f64) -> _) = ("tests that hit", Scale::Linear, percent);
        drawing.panels.push(lines_panel(title, x, top, series));
        drawing.legend = legend;
        said.extend(variants);
    }
    Figure {
        name: "hit-rate",
        title: "Throughput against hit rate",
        caption: format!(
            "How the share of tests that hit changes the speed of the fastest variant of each of \
             the fastest methods, and of Möller–Trumbore, over this series, when asked for {}. A branch that leaves early costs most \
             where it is hardest to foresee. {}.",
            view.main_need_in_prose(),
            said.join("; ")
        ),
        drawing: if drawing.panels.is_empty() {
            Err("Left out: the record times no workloads of the hit-rate family.".into())
        } else {
            Ok(drawing)
        },
    }
}

fn working_set(view: &View) -> Figure {
    let size = |v: &Variant, w: &str| {
        let timed = view.throughput.get(v)?.get(w)?;
        let triangles = view.workloads.get(w)?.triangles;
        Some(triangles as f64 * timed.bytes_per_triangle as f64)
    };
    let (legend, series, said) = series_lines(view, Family::WorkingSet, size, |_| true);
    Figure {
        name: "working-set",
        title: "Throughput against working set",
        caption: format!(
            "The speed of the fastest variant of each of the fastest methods, and of \
             Möller–Trumbore, against the size of the prepared \
             triangles: their number times the bytes that the method reads for each, so that a method that stores more moves to the \
             right. Asked for {}. {}.",
            view.main_need_in_prose(),
            said.join("; ")
        ),
        drawing: if series.is_empty() {
            Err("Left out: the record times no workloads of the working-set family.".into())
        } else {
            let top = top_speed(&series);
            let x: (_, _, fn(f64) -> _) = ("prepared triangles", Scale::Binary, bytes);
            let panels = vec![lines_panel("", x, top, series)];
            Ok(Drawing { panels, legend, key: Vec::new() })
        },
    }
}

/// Preparation time and bytes of each method and precision: a table is their best figure.
pub(crate) fn preparation(view: &View) -> Vec<[String; 4]> {
    let mut rows = Vec::new();
    for &method in view.methods() {
        for precision in view.precisions() {
            let (ns, size) = (view.preparation(method, precision), view.bytes(method, precision));
            if ns.is_some() {
                rows.push([
                    view.title(method),
                    precision.to_string(),
                    or_dash(ns, number),
                    size.map_or_else(|| "–".into(), |b| b.to_string()),
                ]);
            }
        }
    }
    rows
}
