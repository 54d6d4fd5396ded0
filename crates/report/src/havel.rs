//! The conclusions of Havel's thesis, put to the test on a record.

use std::fmt::Write as _;

use trisect_core::{Arrangement, FloatFormat, Form, Input, MultiplyAdd, Output};
use trisect_harness::record::{Family, Variant};

use crate::format::{mtests, number, scientific};
use crate::markdown::{fastest, measured};
use crate::stats::{geometric_mean, median};
use crate::view::{View, lanes_label};

/// A conclusion: what it says, whether it holds here, and the figures.
struct Finding {
    says: &'static str,
    holds: Verdict,
    figures: String,
}

/// Whether a conclusion holds.
enum Verdict {
    Holds,
    NotAnyMore,
    /// Both are within three hundredths of each other.
    NoDifference,
    Unknown,
}

impl Verdict {
    fn of(holds: Option<bool>) -> Self {
        match holds {
            Some(true) => Self::Holds,
            Some(false) => Self::NotAnyMore,
            None => Self::Unknown,
        }
    }

    /// Of a gain that is said to be above 1.
    fn of_gain(gain: Option<f64>) -> Self {
        match gain {
            Some(gain) if gain > 1.03 => Self::Holds,
            Some(gain) if gain < 0.97 => Self::NotAnyMore,
            Some(_) => Self::NoDifference,
            None => Self::Unknown,
        }
    }
}

/// Every conclusion with its verdict, and what the figures were made from.
pub(crate) fn page(view: &View) -> String {
    let mut text = String::new();
    for (heading, findings) in [
        ("No stored data", vec![points(view, Lanes::Scalar), points(view, Lanes::Widest)]),
        ("Stored data", vec![stored(view, Lanes::Scalar), stored(view, Lanes::Widest)]),
        (
            "Packets",
            vec![
                packets(view),
                shared(view, Arrangement::CommonOrigin),
                shared(view, Arrangement::CommonDirection),
            ],
        ),
        ("Moving the division", vec![division(view, Lanes::Scalar), division(view, Lanes::Widest)]),
        (
            "Worst case",
            vec![early_out(view, Lanes::Scalar), early_out(view, Lanes::Widest), worst_case(view)],
        ),
        ("Double precision", vec![double(view)]),
        ("Error", vec![error(view)]),
        (
            "Which method for which use",
            vec![
                ray_tracing(view),
                ray_casting(view),
                collision(view),
                visibility(view),
                radiosity(view),
            ],
        ),
    ] {
        let _ = writeln!(text, "### {heading}\n");
        for Finding { says, holds, figures } in findings {
            let verdict = match holds {
                Verdict::Holds => "Holds.",
                Verdict::NotAnyMore => "Not any more.",
                Verdict::NoDifference => "Makes no difference.",
                Verdict::Unknown => "The record does not tell.",
            };
            let _ = writeln!(text, "- {says} **{verdict}** {figures}");
        }
        text.push('\n');
    }
    let _ = write!(text, "{}", measured(view));
    text.push('\n');
    text
}

#[derive(Clone, Copy)]
enum Lanes {
    Scalar,
    Widest,
}

impl Lanes {
    fn has(self, view: &View, v: &Variant) -> bool {
        match self {
            Self::Scalar => v.width == 1,
            Self::Widest => {
                let all = view.throughput.keys().filter(|o| o.precision == v.precision);
                all.map(|other| other.width).max() == Some(v.width)
            }
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Widest => "on the widest lanes",
        }
    }
}

/// Whether a method is given points and prepares nothing.
fn is_from_points(view: &View, method: &str) -> bool {
    view.fact(method).is_some_and(|facts| facts.input == Some(Input::Points))
}

/// The fastest full hit in f32 on such lanes.
fn full<'a>(
    view: &View<'a>,
    lanes: Lanes,
    keep: impl Fn(&Variant) -> bool,
) -> Option<(&'a Variant, f64)> {
    fastest(view, |v| {
        v.precision == FloatFormat::F32
            && v.needs == Output::Barycentrics
            && lanes.has(view, v)
            && keep(v)
    })
}

fn speed(best: Option<(&Variant, f64)>) -> String {
    best.map_or_else(
        || "nothing was timed".to_owned(),
        |(v, ns)| {
            format!(
                "`{}` ({}, {}) at {} million tests/s",
                v.method,
                lanes_label(v),
                v.division,
                number(mtests(ns))
            )
        },
    )
}

fn points(view: &View, lanes: Lanes) -> Finding {
    let of_points = |v: &Variant| is_from_points(view, &v.method);
    let best = full(view, lanes, of_points);
    let theirs = full(view, lanes, |v| of_points(v) && v.method.starts_with("moller-trumbore"));
    Finding {
        says: match lanes {
            Lanes::Scalar => "From points alone, scalar, Möller–Trumbore is the fastest test.",
            Lanes::Widest => "From points alone, over lanes, Möller–Trumbore is the fastest test.",
        },
        holds: Verdict::of(best.map(|(v, _)| v.method.starts_with("moller-trumbore"))),
        figures: format!(
            "Fastest {}: {}; of Möller–Trumbore's orders {}.",
            lanes.name(),
            speed(best),
            speed(theirs)
        ),
    }
}

fn stored(view: &View, lanes: Lanes) -> Finding {
    let of_points = full(view, lanes, |v| is_from_points(view, &v.method));
    let best = full(view, lanes, |v| !is_from_points(view, &v.method));
    let gain = of_points.zip(best).map(|(a, b)| a.1 / b.1);
    Finding {
        says: match lanes {
            Lanes::Scalar => "Stored data pay, scalar: planes beat every test from points.",
            Lanes::Widest => "Stored data pay, over lanes: planes beat every test from points.",
        },
        holds: Verdict::of_gain(gain),
        figures: format!(
            "Fastest {}: {}; from points {}; {} times as fast.",
            lanes.name(),
            speed(best),
            speed(of_points),
            gain.map_or_else(|| "–".to_owned(), |x| format!("{x:.2}"))
        ),
    }
}

/// Ratios of times, method by method: of the fastest variant that `slow` lets pass over that of
/// `quick`, on the workloads that `on` names.
fn gains(
    view: &View,
    on: impl Fn(&str) -> bool,
    slow: impl Fn(&Variant) -> bool,
    quick: impl Fn(&Variant) -> bool,
) -> Vec<(String, f64)> {
    let best = |method: &str, keep: &dyn Fn(&Variant) -> bool| {
        let of = |v: &Variant| v.method == method && v.precision == FloatFormat::F32 && keep(v);
        view.comparable_on(of, &on).scores().first().map(|(_, ns)| *ns)
    };
    let mut gains: Vec<(String, f64)> = view
        .methods()
        .iter()
        .filter_map(|&m| Some((m.to_owned(), best(m, &slow)? / best(m, &quick)?)))
        .collect();
    gains.sort_by(|a, b| b.1.total_cmp(&a.1));
    gains
}

/// How many gain, the middle, and both ends.
fn spread(gains: &[(String, f64)]) -> String {
    let values: Vec<f64> = gains.iter().map(|g| g.1).collect();
    let (Some(first), Some(last), Some(middle)) = (gains.first(), gains.last(), median(&values))
    else {
        return String::new();
    };
    format!(
        "{} of {} methods gain; median ratio {middle:.2}, from {:.2} (`{}`) to {:.2} (`{}`).",
        values.iter().filter(|&&x| x > 1.0).count(),
        values.len(),
        last.1,
        last.0,
        first.1,
        first.0
    )
}

/// What a method gains in the middle.
fn middle(gains: &[(String, f64)]) -> Option<f64> {
    let values: Vec<f64> = gains.iter().map(|g| g.1).collect();
    median(&values)
}

fn has_division(view: &View, method: &str, division: Form) -> bool {
    view.fact(method).is_some_and(|facts| facts.divisions.contains(&division))
}

fn family<'a>(view: &View<'a>, family: Family) -> Vec<&'a str> {
    view.family(family).iter().map(|w| w.name.as_str()).collect()
}

fn main_workloads<'a>(view: &View<'a>) -> Vec<&'a str> {
    [family(view, Family::Random), family(view, Family::Mesh)].concat()
}

fn packets(view: &View) -> Finding {
    let names = main_workloads(view);
    let both = |v: &Variant, arrangement: Arrangement| {
        // The packet is timed in one form of the division, without early-out.
        let form =
            if has_division(view, &v.method, Form::Early) { Form::Early } else { Form::Deferred };
        v.arrangement == arrangement
            && v.needs == Output::Barycentrics
            && v.arithmetic == MultiplyAdd::Fused
            && !v.early_out
            && v.division == form
            && Lanes::Widest.has(view, v)
    };
    let gains = gains(
        view,
        |w| names.contains(&w),
        |v| both(v, Arrangement::OneRay),
        |v| both(v, Arrangement::OneTriangle),
    );
    Finding {
        says: "A packet of rays against one triangle is faster than one ray against as many \
               triangles.",
        holds: Verdict::of_gain(middle(&gains)),
        figures: format!("On the widest lanes, the same test both ways: {}", spread(&gains)),
    }
}

fn shared(view: &View, arrangement: Arrangement) -> Finding {
    let is_origin = arrangement == Arrangement::CommonOrigin;
    let workload = if is_origin { "packets/origin" } else { "packets/direction" };
    let gains = gains(
        view,
        |w| w == workload,
        |v| v.arrangement == Arrangement::OneTriangle,
        |v| v.arrangement == arrangement,
    );
    Finding {
        says: if is_origin {
            "Rays of one origin gain when what depends on the origin alone is computed once."
        } else {
            "Rays of one direction gain when what depends on the direction alone is computed once."
        },
        holds: Verdict::of_gain(middle(&gains)),
        figures: format!("Against packets that share nothing: {}", spread(&gains)),
    }
}

fn division(view: &View, lanes: Lanes) -> Finding {
    let names = main_workloads(view);
    let on = |v: &Variant, division: Form| {
        v.division == division
            && v.arrangement == Arrangement::OneRay
            && v.needs == Output::Barycentrics
            && lanes.has(view, v)
    };
    let gains =
        gains(view, |w| names.contains(&w), |v| on(v, Form::Early), |v| on(v, Form::Deferred));
    Finding {
        says: match lanes {
            Lanes::Scalar => "Moving the division behind the tests makes them faster, scalar.",
            Lanes::Widest => "Moving the division behind the tests makes them faster, over lanes.",
        },
        holds: Verdict::of_gain(middle(&gains)),
        figures: format!("Each form by its fastest variant: {}", spread(&gains)),
    }
}

fn early_out(view: &View, lanes: Lanes) -> Finding {
    let names = main_workloads(view);
    let on = |v: &Variant, early_out: bool| {
        v.early_out == early_out
            && v.arrangement == Arrangement::OneRay
            && v.needs == Output::Barycentrics
            && lanes.has(view, v)
    };
    let gains = gains(view, |w| names.contains(&w), |v| on(v, false), |v| on(v, true));
    Finding {
        says: match lanes {
            Lanes::Scalar => {
                "A scalar test that leaves as soon as it can is faster than one that \
                              never does."
            }
            Lanes::Widest => {
                "A test over lanes that leaves as soon as it can is faster than one that \
                              never does."
            }
        },
        holds: Verdict::of_gain(middle(&gains)),
        figures: format!("Time without over time with early-out: {}", spread(&gains)),
    }
}

/// When every test hits, against when none does.
fn worst_case(view: &View) -> Finding {
    let worst = |early_out: bool| {
        let best = |method: &str, workload: &str| {
            let keep = |v: &Variant| v.method == method && v.early_out == early_out;
            view.comparable_on(keep, |w| w == workload).scores().first().map(|(_, ns)| *ns)
        };
        let ratio = |m: &&str| Some(best(m, "hit-rate/100")? / best(m, "hit-rate/0")?);
        geometric_mean(view.methods().iter().filter_map(ratio))
    };
    let (with, without) = (worst(true), worst(false));
    let show = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), |x| format!("{x:.2}"));
    Finding {
        says: "The worst case, in which every test runs to its end, is slower for tests that leave early, \
               and no different for those that never do.",
        holds: Verdict::of(with.zip(without).map(|(with, without)| with > 1.03 && without < 1.03)),
        figures: format!(
            "Time when all hit over time when none does, geometric mean over the methods, widest lanes: \
             with early-out {}, without {}.",
            show(with),
            show(without)
        ),
    }
}

fn double(view: &View) -> Finding {
    let ratio = |lanes: Lanes| {
        let best = |method: &str, precision: FloatFormat| {
            fastest(view, |v| {
                v.method == method
                    && v.precision == precision
                    && v.needs == Output::Barycentrics
                    && lanes.has(view, v)
            })
            .map(|(_, ns)| ns)
        };
        let ratios = view
            .methods()
            .iter()
            .filter_map(|m| Some(best(m, FloatFormat::F64)? / best(m, FloatFormat::F32)?));
        geometric_mean(ratios)
    };
    let (scalar, widest) = (ratio(Lanes::Scalar), ratio(Lanes::Widest));
    Finding {
        says: "Double precision costs little while one number is computed at a time, and half the \
               speed or more over lanes.",
        holds: Verdict::of(
            scalar.zip(widest).map(|(scalar, widest)| scalar < 1.25 && widest >= 2.0),
        ),
        figures: format!(
            "Time in f64 over time in f32, geometric mean over the methods: scalar {}, widest lanes {}.",
            scalar.map_or_else(|| "–".to_owned(), |x| format!("{x:.2}")),
            widest.map_or_else(|| "–".to_owned(), |x| format!("{x:.2}"))
        ),
    }
}

fn error(view: &View) -> Finding {
    let mut rows: Vec<(f64, &str)> = view
        .methods()
        .iter()
        .filter_map(|&m| Some((view.pooled_error((m, FloatFormat::F32), "t", |_| true)?.p99, m)))
        .collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = |of: &dyn Fn(&str) -> bool| {
        let of: Vec<f64> = rows.iter().filter(|(_, m)| of(m)).map(|(e, _)| *e).collect();
        median(&of)
    };
    let points = middle(&|m| is_from_points(view, m));
    let planes = middle(&|m| !is_from_points(view, m) && !m.ends_with("-relative"));
    let relative = middle(&|m| m.ends_with("-relative"));
    let show = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), scientific);
    let end = |row: Option<&(f64, &str)>| {
        row.map_or_else(String::new, |(e, m)| format!("`{m}` {}", scientific(*e)))
    };
    Finding {
        says: "Methods differ in error, and stored planes err more than points do.",
        holds: Verdict::of(points.zip(planes).map(|(points, planes)| planes > points)),
        figures: format!(
            "99th percentile of the relative error of t in f32, median over the methods: from points \
             {}, stored data {}, stored from a corner {}. Least: {}; most: {}.",
            show(points),
            show(planes),
            show(relative),
            end(rows.first()),
            end(rows.last())
        ),
    }
}

fn ray_tracing(view: &View) -> Finding {
    let best = full(view, Lanes::Widest, |v| v.arrangement == Arrangement::OneRay);
    Finding {
        says: "Ray tracing, in which each triangle is tested often and a hit is shaded: a method with \
               stored data.",
        holds: Verdict::of(best.map(|(v, _)| !is_from_points(view, &v.method))),
        figures: format!("Fastest with barycentrics, one ray at a time: {}.", speed(best)),
    }
}

fn ray_casting(view: &View) -> Finding {
    let on = |keep: &dyn Fn(&Variant) -> bool| {
        let comparable = view.comparable_on(|v| keep(v), |w| w == "packets/origin");
        comparable.scores().first().copied()
    };
    let best = on(&|_| true);
    let one_ray = on(&|v| v.arrangement == Arrangement::OneRay);
    Finding {
        says: "Ray casting, in which all rays leave one point: packets that share the origin.",
        holds: Verdict::of(best.map(|(v, _)| v.arrangement == Arrangement::CommonOrigin)),
        figures: format!(
            "Fastest: {}, {}; one ray at a time {}.",
            speed(best),
            best.map_or("–", |(v, _)| v.arrangement.name()),
            speed(one_ray)
        ),
    }
}

/// Tests of a triangle after which stored data have paid for their preparation.
fn collision(view: &View) -> Finding {
    let points = full(view, Lanes::Scalar, |v| is_from_points(view, &v.method));
    let mut best: Option<(&str, f64)> = None;
    let mut stored = None;
    if let Some((points, from_points)) = points {
        let own = view.preparation(&points.method, FloatFormat::F32).unwrap_or(0.0);
        for &method in view.methods().iter().filter(|m| !is_from_points(view, m)) {
            let Some((_, ns)) = full(view, Lanes::Scalar, |v| v.method == method) else { continue };
            let Some(preparation) = view.preparation(method, FloatFormat::F32) else { continue };
            if ns < from_points {
                let tests = ((preparation - own) / (from_points - ns)).max(0.0);
                if best.is_none_or(|(_, fewest)| tests < fewest) {
                    best = Some((method, tests));
                    stored = Some(tests);
                }
            }
        }
    }
    Finding {
        says: "Collision of what moves, in which a triangle is tested once or a few times: a method \
               from points.",
        holds: Verdict::of(points.map(|_| stored.is_none_or(|tests| tests > 1.0))),
        figures: format!(
            "From points, scalar: {}. {}",
            speed(points),
            best.map_or_else(
                || "No stored data ever pay for themselves.".to_owned(),
                |(method, tests)| format!(
                    "The first to pay for its preparation is `{method}`, after {} tests of a triangle.",
                    number(tests)
                )
            )
        ),
    }
}

fn visibility(view: &View) -> Finding {
    let best = |need: Output| {
        fastest(view, |v| {
            v.precision == FloatFormat::F32 && v.needs == need && Lanes::Widest.has(view, v)
        })
    };
    let (occlusion, distance) = (best(Output::Occlusion), best(Output::T));
    let gain = occlusion.zip(distance).map(|(a, b)| b.1 / a.1);
    Finding {
        says: "Visibility, in which a hit is a yes or a no: a test that computes nothing else.",
        holds: Verdict::of_gain(gain),
        figures: format!(
            "Fastest: {}; with t {}; {} times as fast.",
            speed(occlusion),
            speed(distance),
            gain.map_or_else(|| "–".to_owned(), |x| format!("{x:.2}"))
        ),
    }
}

fn radiosity(view: &View) -> Finding {
    let best =
        fastest(view, |v| v.precision == FloatFormat::F64 && v.needs == Output::Barycentrics);
    let single = full(view, Lanes::Widest, |_| true);
    let loss = best.zip(single).map(|(double, single)| double.1 / single.1);
    Finding {
        says: "Radiosity, which is solved once and exactly: double precision, its cost being bearable \
               (less than threefold here).",
        holds: Verdict::of(loss.map(|loss| loss < 3.0)),
        figures: format!(
            "Fastest in f64: {}; {} times the time of the fastest in f32.",
            speed(best),
            loss.map_or_else(|| "–".to_owned(), |x| format!("{x:.2}"))
        ),
    }
}
