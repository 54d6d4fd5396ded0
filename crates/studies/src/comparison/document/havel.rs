//! The conclusions of Havel's thesis, put to the test on a record.

use crate::comparison::record::Family;
use crate::record::Variant;
use trisect_core::FloatFormat::{F32, F64};
use trisect_core::MultiplyAdd;
use trisect_kernels::Arrangement::{self, CommonOrigin, OneRay, OneTriangle};
use trisect_method::{Form, Input, Output};

use super::view::{View, lanes_label};
use trisect_report::document::Section;
use trisect_report::format::{fixed, mtests, number, or_dash, scientific};
use trisect_report::stats::{geometric_mean, median};

/// Every conclusion with its verdict, by what it is about.
pub(super) fn sections(view: &View) -> Vec<Section> {
    use Lanes::{Scalar, Widest};
    let record = Record { view };
    let all = [
        ("No stored data", [Scalar, Widest].map(|lanes| record.points(lanes)).to_vec()),
        ("Stored data", [Scalar, Widest].map(|lanes| record.stored(lanes)).to_vec()),
        (
            "Packets",
            vec![
                record.packets(),
                record.shared(CommonOrigin, "origin"),
                record.shared(Arrangement::CommonDirection, "direction"),
            ],
        ),
        ("Moving the division", [Scalar, Widest].map(|lanes| record.division(lanes)).to_vec()),
        (
            "Worst case",
            vec![record.early_out(Scalar), record.early_out(Widest), record.worst_case()],
        ),
        ("Double precision", vec![record.double()]),
        ("Error", vec![record.error()]),
        (
            "Which method for which use",
            vec![
                record.ray_tracing(),
                record.ray_casting(),
                record.collision(),
                record.visibility(),
                record.radiosity(),
            ],
        ),
    ];
    all.into_iter().map(|(heading, items)| Section::list("havel", heading, items)).collect()
}

/// A conclusion as an item of a list: what it says, then whether it holds here, and the figures.
type Conclusion = (String, String);

fn concluded(says: impl Into<String>, verdict: &str, figures: impl AsRef<str>) -> Conclusion {
    (says.into(), format!("**{verdict}** {}", figures.as_ref()))
}

/// Whether a conclusion holds.
fn verdict(holds: Option<bool>) -> &'static str {
    match holds {
        Some(true) => "Holds.",
        Some(false) => "Not any more.",
        None => "The record does not tell.",
    }
}

/// The same of a gain that is said to be above 1.
fn of_gain(gain: Option<f64>) -> &'static str {
    match gain {
        Some(gain) if (0.97..=1.03).contains(&gain) => "Makes no difference.",
        gain => verdict(gain.map(|gain| gain > 1.0)),
    }
}

#[derive(Clone, Copy)]
enum Lanes {
    Scalar,
    Widest,
}

impl Lanes {
    fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Widest => "over lanes",
        }
    }
}

/// A variant with its nanoseconds per test.
type Timed<'a> = Option<(&'a Variant, f64)>;

fn speed(best: Timed) -> String {
    best.map_or_else(
        || "nothing was timed".to_owned(),
        |(v, ns)| {
            let (lanes, speed) = (lanes_label(v), number(mtests(ns)));
            format!("`{}` ({lanes}, {}) at {speed} million tests/s", v.method, v.division)
        },
    )
}

/// Ratios of times by method, the largest first.
struct Gains<'a>(Vec<(&'a str, f64)>);

impl Gains<'_> {
    /// What a method gains in the middle.
    fn middle(&self) -> Option<f64> {
        median(&self.0.iter().map(|gain| gain.1).collect::<Vec<_>>())
    }

    /// How many gain, the middle, and both ends.
    fn spread(&self) -> String {
        let (Some(first), Some(last), Some(middle)) =
            (self.0.first(), self.0.last(), self.middle())
        else {
            return String::new();
        };
        format!(
            "{} of {} methods gain; median ratio {middle:.2}, from {:.2} (`{}`) to {:.2} (`{}`).",
            self.0.iter().filter(|gain| gain.1 > 1.0).count(),
            self.0.len(),
            last.1,
            last.0,
            first.1,
            first.0
        )
    }
}

struct Record<'a> {
    view: &'a View<'a>,
}

impl<'a> Record<'a> {
    fn is_on(&self, lanes: Lanes, v: &Variant) -> bool {
        match lanes {
            Lanes::Scalar => v.width == 1,
            Lanes::Widest => {
                let all = self.view.throughput.keys().filter(|o| o.precision == v.precision);
                all.map(|other| other.width).max() == Some(v.width)
            }
        }
    }

    /// Whether a method is given points and prepares nothing.
    fn is_from_points(&self, method: &str) -> bool {
        self.view.fact(method).is_some_and(|facts| facts.input == Some(Input::Points))
    }

    /// The fastest full hit in f32 on such lanes.
    fn full(&self, lanes: Lanes, keep: impl Fn(&Variant) -> bool) -> Timed<'a> {
        self.view.fastest(|v| {
            v.precision == F32 && v.needs == Output::Barycentrics && self.is_on(lanes, v) && keep(v)
        })
    }

    /// Nanoseconds of the fastest variant that `keep` lets pass on some workloads.
    fn fastest_on(&self, on: impl Fn(&str) -> bool, keep: impl Fn(&Variant) -> bool) -> Timed<'a> {
        self.view.comparable_on(keep, on).scores().first().copied()
    }

    /// Ratios of times in f32, method by method: of the fastest variant that `slow` lets pass over that
    /// of `quick`, on the workloads that `on` names.
    fn gains(
        &self,
        on: impl Fn(&str) -> bool,
        slow: impl Fn(&Variant) -> bool,
        quick: impl Fn(&Variant) -> bool,
    ) -> Gains<'a> {
        let best = |method: &str, keep: &dyn Fn(&Variant) -> bool| {
            let of = |v: &Variant| v.method == method && v.precision == F32 && keep(v);
            self.fastest_on(&on, of).map(|(_, ns)| ns)
        };
        let gain = |&m: &&'a str| Some((m, best(m, &slow)? / best(m, &quick)?));
        let mut gains: Vec<_> = self.view.methods().iter().filter_map(gain).collect();
        gains.sort_by(|a, b| b.1.total_cmp(&a.1));
        Gains(gains)
    }

    /// The same of full hits on random rays and meshes.
    fn gains_in_full(
        &self,
        slow: impl Fn(&Variant) -> bool,
        quick: impl Fn(&Variant) -> bool,
    ) -> Gains<'a> {
        let families = [Family::Random, Family::Mesh].map(|family| self.view.family(family));
        let names: Vec<&str> = families.iter().flatten().map(|w| w.name.as_str()).collect();
        let full = |v: &Variant| v.needs == Output::Barycentrics;
        self.gains(|w| names.contains(&w), |v| full(v) && slow(v), |v| full(v) && quick(v))
    }

    fn points(&self, lanes: Lanes) -> Conclusion {
        let of_points = |v: &Variant| self.is_from_points(&v.method);
        let is_theirs = |v: &Variant| v.method.starts_with("moller-trumbore");
        let best = self.full(lanes, of_points);
        let theirs = self.full(lanes, |v| of_points(v) && is_theirs(v));
        let says =
            format!("From points alone, {}, Möller–Trumbore is the fastest test.", lanes.name());
        let figures =
            format!("Fastest: {}; of Möller–Trumbore's orders {}.", speed(best), speed(theirs));
        concluded(says, verdict(best.map(|(v, _)| is_theirs(v))), figures)
    }

    fn stored(&self, lanes: Lanes) -> Conclusion {
        let of_points = self.full(lanes, |v| self.is_from_points(&v.method));
        let best = self.full(lanes, |v| !self.is_from_points(&v.method));
        let gain = of_points.zip(best).map(|(a, b)| a.1 / b.1);
        let says =
            format!("Stored data pay, {}: planes beat every test from points.", lanes.name());
        let figures = format!(
            "Fastest: {}; from points {}; {} times as fast.",
            speed(best),
            speed(of_points),
            or_dash(gain, fixed)
        );
        concluded(says, of_gain(gain), figures)
    }

    fn packets(&self) -> Conclusion {
        let both = |v: &Variant, arrangement: Arrangement| {
            // The packet is timed in one form of the division, without early-out.
            let facts = self.view.fact(&v.method);
            let has_early = facts.is_some_and(|facts| facts.divisions.contains(&Form::Early));
            v.arrangement == arrangement
                && v.arithmetic == MultiplyAdd::Fused
                && !v.early_out
                && v.division == if has_early { Form::Early } else { Form::Deferred }
                && self.is_on(Lanes::Widest, v)
        };
        let gains = self.gains_in_full(|v| both(v, OneRay), |v| both(v, OneTriangle));
        concluded(
            "A packet of rays against one triangle is faster than one ray against as many triangles.",
            of_gain(gains.middle()),
            format!("On the widest lanes, the same test both ways: {}", gains.spread()),
        )
    }

    fn shared(&self, arrangement: Arrangement, what: &str) -> Conclusion {
        let gains = self.gains(
            |w| w.strip_prefix("packets/") == Some(what),
            |v| v.arrangement == OneTriangle,
            |v| v.arrangement == arrangement,
        );
        let says = format!(
            "Rays of one {what} gain when what depends on the {what} alone is computed once."
        );
        let figures = format!("Against packets that share nothing: {}", gains.spread());
        concluded(says, of_gain(gains.middle()), figures)
    }

    fn division(&self, lanes: Lanes) -> Conclusion {
        let on = |v: &Variant, form: Form| {
            v.division == form && v.arrangement == OneRay && self.is_on(lanes, v)
        };
        let gains = self.gains_in_full(|v| on(v, Form::Early), |v| on(v, Form::Deferred));
        let says =
            format!("Moving the division behind the tests makes them faster, {}.", lanes.name());
        let figures = format!("Each form by its fastest variant: {}", gains.spread());
        concluded(says, of_gain(gains.middle()), figures)
    }

    fn early_out(&self, lanes: Lanes) -> Conclusion {
        let on = |v: &Variant, early_out: bool| {
            v.early_out == early_out && v.arrangement == OneRay && self.is_on(lanes, v)
        };
        let gains = self.gains_in_full(|v| on(v, false), |v| on(v, true));
        let test = match lanes {
            Lanes::Scalar => "A scalar test",
            Lanes::Widest => "A test over lanes",
        };
        let says =
            format!("{test} that leaves as soon as it can is faster than one that never does.");
        let figures = format!("Time without over time with early-out: {}", gains.spread());
        concluded(says, of_gain(gains.middle()), figures)
    }

    /// When every test hits, against when none does.
    fn worst_case(&self) -> Conclusion {
        let worst = |early_out: bool| {
            let best = |method: &str, workload: &str| {
                let keep = |v: &Variant| v.method == method && v.early_out == early_out;
                self.fastest_on(|w| w == workload, keep).map(|(_, ns)| ns)
            };
            let ratio = |m: &&str| Some(best(m, "hit-rate/100")? / best(m, "hit-rate/0")?);
            geometric_mean(self.view.methods().iter().filter_map(ratio))
        };
        let (with, without) = (worst(true), worst(false));
        concluded(
            "The worst case, in which every test runs to its end, is slower for tests that leave early, and \
             no different for those that never do.",
            verdict(with.zip(without).map(|(with, without)| with > 1.03 && without < 1.03)),
            format!(
                "Time when all hit over time when none does, geometric mean over the methods, widest \
                 lanes: with early-out {}, without {}.",
                or_dash(with, fixed),
                or_dash(without, fixed)
            ),
        )
    }

    fn double(&self) -> Conclusion {
        let ratio = |lanes: Lanes| {
            let best = |method: &str, precision| {
                let is_full = |v: &Variant| {
                    v.method == method && v.needs == Output::Barycentrics && self.is_on(lanes, v)
                };
                self.view.fastest(|v| v.precision == precision && is_full(v)).map(|(_, ns)| ns)
            };
            let methods = self.view.methods().iter();
            geometric_mean(methods.filter_map(|m| Some(best(m, F64)? / best(m, F32)?)))
        };
        let (scalar, widest) = (ratio(Lanes::Scalar), ratio(Lanes::Widest));
        concluded(
            "Double precision costs little while one number is computed at a time, and half the speed or \
             more over lanes.",
            verdict(scalar.zip(widest).map(|(scalar, widest)| scalar < 1.25 && widest >= 2.0)),
            format!(
                "Time in f64 over time in f32, geometric mean over the methods: scalar {}, widest lanes {}.",
                or_dash(scalar, fixed),
                or_dash(widest, fixed)
            ),
        )
    }

    fn error(&self) -> Conclusion {
        let error = |&m: &&'a str| Some((self.view.pooled_error((m, F32), "t", |_| true)?.p99, m));
        let mut rows: Vec<(f64, &str)> = self.view.methods().iter().filter_map(error).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        let middle = |of: &dyn Fn(&str) -> bool| {
            median(&rows.iter().filter(|(_, m)| of(m)).map(|(e, _)| *e).collect::<Vec<_>>())
        };
        let is_relative = |m: &str| m.ends_with("-relative");
        let points = middle(&|m| self.is_from_points(m));
        let planes = middle(&|m| !self.is_from_points(m) && !is_relative(m));
        let end = |row: Option<&(f64, &str)>| {
            row.map_or_else(String::new, |(e, m)| format!("`{m}` {}", scientific(*e)))
        };
        concluded(
            "Methods differ in error, and stored planes err more than points do.",
            verdict(points.zip(planes).map(|(points, planes)| planes > points)),
            format!(
                "99th percentile of the relative error of t in f32, median over the methods: from points \
                 {}, stored data {}, stored from a corner {}. Least: {}; most: {}.",
                or_dash(points, scientific),
                or_dash(planes, scientific),
                or_dash(middle(&is_relative), scientific),
                end(rows.first()),
                end(rows.last())
            ),
        )
    }

    fn ray_tracing(&self) -> Conclusion {
        let best = self.full(Lanes::Widest, |v| v.arrangement == OneRay);
        concluded(
            "Ray tracing, in which each triangle is tested often and a hit is shaded: a method with stored \
             data.",
            verdict(best.map(|(v, _)| !self.is_from_points(&v.method))),
            format!("Fastest with barycentrics, one ray at a time: {}.", speed(best)),
        )
    }

    fn ray_casting(&self) -> Conclusion {
        let on = |keep: &dyn Fn(&Variant) -> bool| self.fastest_on(|w| w == "packets/origin", keep);
        let (best, one_ray) = (on(&|_| true), on(&|v| v.arrangement == OneRay));
        concluded(
            "Ray casting, in which all rays leave one point: packets that share the origin.",
            verdict(best.map(|(v, _)| v.arrangement == CommonOrigin)),
            format!(
                "Fastest: {}, {}; one ray at a time {}.",
                speed(best),
                best.map_or("–", |(v, _)| v.arrangement.name()),
                speed(one_ray)
            ),
        )
    }

    /// Tests of a triangle after which stored data have paid for their preparation.
    fn collision(&self) -> Conclusion {
        let points = self.full(Lanes::Scalar, |v| self.is_from_points(&v.method));
        let preparation = |method: &str| self.view.preparation(method, F32);
        let pays = |&method: &&'a str| {
            let (points, from_points) = points.filter(|_| !self.is_from_points(method))?;
            let (_, ns) = self.full(Lanes::Scalar, |v| v.method == method)?;
            let more = preparation(method)? - preparation(&points.method).unwrap_or(0.0);
            (ns < from_points).then(|| (method, (more / (from_points - ns)).max(0.0)))
        };
        let methods = self.view.methods().iter();
        let first = methods.filter_map(pays).min_by(|a, b| a.1.total_cmp(&b.1));
        let pays = first.map_or_else(
            || "No stored data ever pay for themselves.".to_owned(),
            |(method, tests)| {
                let tests = number(tests);
                format!(
                    "The first to pay for its preparation is `{method}`, after {tests} tests of a triangle."
                )
            },
        );
        concluded(
            "Collision of what moves, in which a triangle is tested once or a few times: a method from \
             points.",
            verdict(points.map(|_| first.is_none_or(|(_, tests)| tests > 1.0))),
            format!("From points, scalar: {}. {pays}", speed(points)),
        )
    }

    fn visibility(&self) -> Conclusion {
        let best = |need: Output| {
            let is_asked = |v: &Variant| v.precision == F32 && v.needs == need;
            self.view.fastest(|v| is_asked(v) && self.is_on(Lanes::Widest, v))
        };
        let (occlusion, distance) = (best(Output::Occlusion), best(Output::T));
        let gain = occlusion.zip(distance).map(|(a, b)| b.1 / a.1);
        concluded(
            "Visibility, in which a hit is a yes or a no: a test that computes nothing else.",
            of_gain(gain),
            format!(
                "Fastest: {}; with t {}; {} times as fast.",
                speed(occlusion),
                speed(distance),
                or_dash(gain, fixed)
            ),
        )
    }

    fn radiosity(&self) -> Conclusion {
        let best = self.view.fastest(|v| v.precision == F64 && v.needs == Output::Barycentrics);
        let single = self.full(Lanes::Widest, |_| true);
        let loss = best.zip(single).map(|(double, single)| double.1 / single.1);
        concluded(
            "Radiosity, which is solved once and exactly: double precision, its cost being bearable (less \
             than threefold here).",
            verdict(loss.map(|loss| loss < 3.0)),
            format!(
                "Fastest in f64: {}; {} times the time of the fastest in f32.",
                speed(best),
                or_dash(loss, fixed)
            ),
        )
    }
}
