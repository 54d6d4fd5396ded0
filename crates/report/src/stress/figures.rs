//! The figures of the stability study.

use trisect_core::FloatFormat;
use trisect_harness::record::{Bin, ByCondition, Site, StressFamily, StressLevel, Variant};

use super::{families, family_names, first_failure, pairs, stands_for};
use crate::chart::{
    Axis, Cell, Drawing, Entry, Join, Look, Map, Panel, Plane, Sample, Scale, Series, Shape,
};
use crate::figures::{Figure, fastest_methods, look, percent};
use crate::format::tick;
use crate::stats::pareto_front;
use crate::summary;
use crate::theme::Ink;
use crate::view::{BASELINE, View};

/// All figures, in the order of the page.
pub(crate) fn all(view: &View) -> Vec<Figure> {
    vec![by_condition(view), decisions(view), cracks(view), map(view), pareto(view)]
}

/// Methods that are told apart in figures of lines, the others being drawn as thin grey ones: the
/// fastest, the one that all are compared with, and those that claim to be watertight.
fn marked<'a>(view: &View<'a>) -> Vec<&'a str> {
    let mut methods = fastest_methods(view);
    let claims = |name: &str| {
        view.fact(name).is_some_and(|fact| fact.claims.iter().any(|claim| claim == "watertight"))
    };
    methods.extend(view.methods().iter().copied().filter(|name| claims(name)).take(1));
    methods.sort_unstable();
    methods.dedup();
    methods
}

/// One line per method: those that are told apart last, so that they lie on top.
fn lines(
    view: &View,
    points: impl Fn(&str) -> Vec<(f64, f64)>,
    reference: Vec<(f64, f64)>,
) -> Vec<Series> {
    let marked = marked(view);
    let (told, others): (Vec<&str>, Vec<&str>) =
        view.methods().iter().copied().partition(|method| marked.contains(method));
    let mut series: Vec<Series> = others
        .into_iter()
        .map(|method| Series {
            look: Look { ink: Ink::Grid, shape: Shape::Circle },
            filled: true,
            join: Join::Straight,
            marked: false,
            points: points(method),
        })
        .collect();
    series.extend(told.into_iter().map(|method| Series {
        look: look(view, method),
        filled: true,
        join: Join::Straight,
        marked: true,
        points: points(method),
    }));
    // Where the lines are, and not as far as a wider type goes.
    let shown = || series.iter().flat_map(|s| &s.points).map(|p| p.0);
    let (low, high) =
        (shown().fold(f64::INFINITY, f64::min), shown().fold(f64::NEG_INFINITY, f64::max));
    let reference = reference.into_iter().filter(|p| (low..=high).contains(&p.0)).collect();
    series.push(Series {
        look: Look { ink: Ink::Text, shape: Shape::Circle },
        filled: false,
        join: Join::Straight,
        marked: false,
        points: reference,
    });
    series.retain(|series| !series.points.is_empty());
    series
}

fn legend(view: &View) -> Vec<Entry> {
    let marked = marked(view);
    let told = view.methods().iter().filter(|method| marked.contains(*method));
    let mut entries: Vec<Entry> = told
        .map(|&method| Entry {
            sample: Sample::Point(look(view, method), true),
            text: view.title(method),
        })
        .collect();
    entries.push(Entry { sample: Sample::Line(Ink::Grid), text: "other methods".into() });
    entries
        .push(Entry { sample: Sample::Line(Ink::Text), text: "Möller–Trumbore in f64".into() });
    entries
}

/// A panel of lines, its axes over all its points.
fn panel(title: &str, x: (&str, Scale), y: (&str, Scale), series: Vec<Series>) -> Panel {
    let points = || series.iter().flat_map(|s| &s.points);
    let write = if y.1 == Scale::Linear { percent } else { tick };
    let from_zero = if y.1 == Scale::Linear { vec![0.0, 1.0] } else { Vec::new() };
    let shown = points().map(|p| p.1).chain(from_zero);
    Panel::Plane(Plane {
        title: title.into(),
        x: Axis::over(x.0, x.1, points().map(|p| p.0), tick),
        y: Axis::over(y.0, y.1, shown, write),
        height: 240,
        series,
        rules: Vec::new(),
        labels: Vec::new(),
    })
}

/// The line of a method in f32, and that of the reference in f64, on the numbers of f32.
fn conditions<'a>(
    view: &View<'a>,
    method: &str,
    precision: FloatFormat,
) -> Option<&'a ByCondition> {
    view.by_condition.iter().copied().find(|b| {
        b.inputs == FloatFormat::F32
            && b.quantity == "t"
            && stands_for(view, &b.variant, method, precision)
    })
}

/// One of the numbers of a bin.
type OfBin = fn(&Bin) -> f64;

fn by_condition(view: &View) -> Figure {
    let points = |of: OfBin| {
        move |line: Option<&ByCondition>| {
            let decades = line.map_or(&[][..], |line| &line.decades);
            // In the middle of the decade.
            decades.iter().map(|bin| (bin.from * 10_f64.sqrt(), of(bin))).collect::<Vec<_>>()
        }
    };
    let drawn: [(&str, OfBin); 4] = [
        ("Median", |bin| f64::from(bin.error.0)),
        ("Largest", |bin| f64::from(bin.error.1)),
        ("Median over κ·u", |bin| f64::from(bin.over_condition.0)),
        ("Largest over κ·u", |bin| f64::from(bin.over_condition.1)),
    ];
    let panels = drawn.map(|(title, of)| {
        let points = points(of);
        let reference = conditions(view, BASELINE, FloatFormat::F64);
        // What is 0 has no place on a logarithmic axis that others fill.
        let above = |points: Vec<(f64, f64)>| points.into_iter().filter(|p| p.1 > 0.0).collect();
        let series = lines(
            view,
            |method| above(points(conditions(view, method, FloatFormat::F32))),
            above(points(reference)),
        );
        let y = if title.contains('κ') { "error of t over κ·u" } else { "relative error of t" };
        panel(title, ("condition number of t", Scale::Log), (y, Scale::Log), series)
    });
    Figure {
        name: "stress-condition",
        title: "Error against condition number",
        caption: "Relative error of t in f32, plain arithmetic, against its relative condition \
                  number κ, per decade, over all families but those about the range of numbers; \
                  below, the same errors over κ times the unit roundoff of the line's own \
                  precision. A method whose line is level there is backward stable; one whose \
                  line climbs is not."
            .into(),
        drawing: drawing(view, panels.into()),
    }
}

fn drawing(view: &View, panels: Vec<Panel>) -> Result<Drawing, String> {
    if view.stress.is_empty() {
        return Err("Left out: the record holds no stability study; make one with `trisect \
                    stress`."
            .into());
    }
    if panels.is_empty() {
        return Err(format!(
            "Left out: the record has no `{BASELINE}`, whose difficulties are drawn; add it to \
             `--methods`."
        ));
    }
    Ok(Drawing { panels, legend: legend(view), key: Vec::new() })
}

/// The family of the variant that stands for a method.
fn family<'a>(
    view: &View<'a>,
    method: &str,
    precision: FloatFormat,
    name: &str,
) -> Option<&'a StressFamily> {
    families(view, method, precision).find(|family| family.family == name)
}

fn wrong_share(level: &StressLevel) -> f64 {
    (level.false_hits + level.false_misses) as f64 * 100.0 / pairs(level).max(1) as f64
}

fn decisions(view: &View) -> Figure {
    let points = |family: Option<&StressFamily>| {
        let levels = family.map_or(&[][..], |family| &family.levels);
        let mut points: Vec<_> = levels.iter().map(|l| (l.level, wrong_share(l))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let panels = family_names(view)
        .into_iter()
        .filter(|(name, _)| points(family(view, BASELINE, FloatFormat::F32, name)).len() > 3)
        .map(|(name, knob)| {
            let series = lines(
                view,
                |method| points(family(view, method, FloatFormat::F32, name)),
                points(family(view, BASELINE, FloatFormat::F64, name)),
            );
            panel(name, (knob, Scale::Log), ("wrong decisions", Scale::Linear), series)
        })
        .collect();
    Figure {
        name: "stress-decisions",
        title: "Wrong decisions against difficulty",
        caption: "The share of pairs whose decision, hit or miss, differs from the oracle's, in \
                  f32 and plain arithmetic; deferred division where the method has it. The levels \
                  of the f64 line are its own, as its pairs are: they go on where those of f32 \
                  have no digits left."
            .into(),
        drawing: drawing(view, panels),
    }
}

fn cracks(view: &View) -> Figure {
    let points = |method: &str, precision: FloatFormat, aim: &str, by_offset: bool| {
        let sites = view
            .surface_cracks
            .iter()
            .filter(|c| stands_for(view, &c.variant, method, precision))
            .flat_map(|c| &c.sites)
            .filter(|site| site.surface == "sphere" && site.aim == aim);
        let place = |site: &Site| {
            if by_offset {
                (site.scale == 1.0).then_some(site.offset)
            } else {
                (site.offset == 0.0).then_some(site.scale)
            }
        };
        let mut points: Vec<_> = sites
            .filter_map(|s| Some((place(s)?, s.no_hit as f64 * 100.0 / s.rays.max(1) as f64)))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let panels = [
        ("Aimed at edges, moved", "edges", true),
        ("Aimed at corners, moved", "vertices", true),
        ("Aimed at edges, scaled", "edges", false),
        ("Aimed at corners, scaled", "vertices", false),
    ]
    .map(|(title, aim, by_offset)| {
        let series = lines(
            view,
            |method| points(method, FloatFormat::F32, aim, by_offset),
            points(BASELINE, FloatFormat::F64, aim, by_offset),
        );
        let x = if by_offset { "offset" } else { "scale" };
        panel(title, (x, Scale::Log), ("rays that pass through", Scale::Linear), series)
    });
    Figure {
        name: "stress-cracks",
        title: "Cracks",
        caption: "Rays from inside a closed sphere of 1,280 triangles, radius 2 times the scale, \
                  that hit nothing, in f32 and plain arithmetic. They are aimed in the precision \
                  of the method, f64's line included: a wider type has cracks as well, finer \
                  ones. Far off, corners and origins lie on a coarse grid, and differences are \
                  exact."
            .into(),
        drawing: drawing(view, panels.into()),
    }
}

/// The first level at which a method fails, by family: as large as it comes early.
fn map(view: &View) -> Figure {
    let names = family_names(view);
    let mut panels = Vec::new();
    for precision in [FloatFormat::F32, FloatFormat::F64] {
        let rows: Vec<(String, Vec<Cell>)> = view
            .methods()
            .iter()
            .filter(|method| families(view, method, precision).next().is_some())
            .map(|method| {
                let cells =
                    names.iter().map(|(name, _)| cell(family(view, method, precision, name)));
                ((*method).to_owned(), cells.collect())
            })
            .collect();
        if !rows.is_empty() {
            panels.push(Panel::Map(Map {
                title: precision.to_string(),
                columns: (1..=names.len()).map(|i| i.to_string()).collect(),
                rows,
            }));
        }
    }
    let key =
        names.iter().enumerate().map(|(i, (name, knob))| format!("{}  {name}: {knob}", i + 1));
    Figure {
        name: "stress-map",
        title: "Where each method first fails",
        caption: "The first level, from easy to hard, at which an answer is wrong by more than a \
                  thousandth: the decision, t relative to itself, or a weight. The earlier in the \
                  family's levels, the larger the square; an empty cell never fails. Plain \
                  arithmetic, deferred division where the method has it. Decisions within a \
                  thousandth of an edge count for nothing here."
            .into(),
        drawing: if panels.is_empty() {
            Err("Left out: the record holds no stability study.".into())
        } else {
            Ok(Drawing { panels, legend: Vec::new(), key: key.collect() })
        },
    }
}

fn cell(family: Option<&StressFamily>) -> Cell {
    let failure = family.and_then(|family| Some((family.levels.len(), first_failure(family)?)));
    failure.map_or(Cell { weight: 0.0, text: String::new() }, |(levels, (place, level))| Cell {
        weight: (levels - place) as f64 / levels as f64,
        text: level_text(level.level),
    })
}

/// A level, short.
pub(crate) fn level_text(level: f64) -> String {
    if level == 0.0 || (1.0..1000.0).contains(&level) {
        tick(level)
    } else {
        format!("{level:.0e}")
    }
}

fn pareto(view: &View) -> Figure {
    let timed = summary::plane(view);
    let strata = [("Easy: κ below 100", 0.0), ("Stiff: κ below a million", 1e2), ("Extreme", 1e6)];
    let error = |variant: &Variant, from: f64| {
        let line = view.by_condition.iter().find(|b| {
            b.inputs == FloatFormat::F32 && b.quantity == "t" && variant.rounds_like(&b.variant)
        })?;
        let bin = line.strata.iter().find(|bin| bin.from == from)?;
        Some(f64::from(bin.error.0))
    };
    let mut panels = Vec::new();
    for (title, from) in strata {
        let points: Vec<(&Variant, (f64, f64))> = timed
            .points
            .iter()
            .filter_map(|p| Some((&p.variant, (p.ns_per_test, error(&p.variant, from)?))))
            .collect();
        if points.is_empty() {
            continue;
        }
        let reference = conditions(view, BASELINE, FloatFormat::F64)
            .and_then(|line| line.strata.iter().find(|bin| bin.from == from))
            .map(|bin| f64::from(bin.error.0));
        panels.push(Panel::Plane(pareto_panel(view, title, &points, reference)));
    }
    let drawing = if panels.is_empty() {
        Err("Left out: the record holds no times beside its errors.".into())
    } else {
        let mut legend = legend(view);
        legend.pop();
        legend.retain(|entry| !matches!(entry.sample, Sample::Line(Ink::Grid)));
        let other = Look { ink: Ink::Grid, shape: Shape::Circle };
        legend.push(Entry { sample: Sample::Point(other, true), text: "other methods".into() });
        let muted = Look { ink: Ink::Muted, shape: Shape::Circle };
        legend.push(Entry { sample: Sample::Point(muted, true), text: "f32".into() });
        legend.push(Entry { sample: Sample::Point(muted, false), text: "f64".into() });
        legend.push(Entry { sample: Sample::Line(Ink::Muted), text: "Pareto front".into() });
        let text = "error of f64 Möller–Trumbore".into();
        legend.push(Entry { sample: Sample::Dashes, text });
        Ok(Drawing { panels, legend, key: Vec::new() })
    };
    Figure {
        name: "stress-pareto",
        title: "Error against run time, from easy to extreme",
        caption: "As on the page of the comparison, a point for each variant: across, nanoseconds \
                  per test on random rays; up, the median relative error of t over the pairs of \
                  the hard families, given in f32, by the condition number of t. What costs \
                  nothing on easy pairs may cost all digits on extreme ones; double precision \
                  keeps them at twice the time."
            .into(),
        drawing,
    }
}

fn pareto_panel(
    view: &View,
    title: &str,
    points: &[(&Variant, (f64, f64))],
    reference: Option<f64>,
) -> Plane {
    let at: Vec<(f64, f64)> = points.iter().map(|p| p.1).collect();
    let front: Vec<(f64, f64)> = pareto_front(&at).into_iter().map(|i| at[i]).collect();
    let marked = marked(view);
    let mut series = vec![Series {
        look: Look { ink: Ink::Muted, shape: Shape::Circle },
        filled: true,
        join: Join::Step,
        marked: false,
        points: front,
    }];
    // Those that are told apart last, so that they lie on top.
    for told in [false, true] {
        for &method in view.methods().iter().filter(|m| marked.contains(*m) == told) {
            let plain = Look { ink: Ink::Grid, shape: Shape::Circle };
            let look = if told { look(view, method) } else { plain };
            for (precision, filled) in [(FloatFormat::F64, false), (FloatFormat::F32, true)] {
                let points = points
                    .iter()
                    .filter(|(v, _)| v.method == method && v.precision == precision)
                    .map(|p| p.1)
                    .collect();
                series.push(Series { look, filled, join: Join::No, marked: true, points });
            }
        }
    }
    let errors: Vec<f64> = at.iter().map(|p| p.1).chain(reference).collect();
    Plane {
        title: title.into(),
        x: Axis::over("ns per test", Scale::Log, at.iter().map(|p| p.0), tick),
        y: Axis::over("median relative error of t", Scale::Log, errors.clone(), tick)
            .broken(errors),
        height: 300,
        series,
        rules: reference.into_iter().collect(),
        labels: Vec::new(),
    }
}
