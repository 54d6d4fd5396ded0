//! What Havel found in his thesis of 2008, by its sections, beside what a record shows.
//!
//! Speeds are compared only between variants that differ in the one thing compared, on the same workloads, when
//! asked for t with barycentrics. What the record has no such pairs of is said to be not measured. What he says of
//! moving the division is told by [forms](crate::forms), which the catalogue does not compile.

use crate::comparison::record::{Agreement, Family};
use crate::record::Variant;
use trisect_core::FloatFormat::{F32, F64};
use trisect_core::MultiplyAdd;
use trisect_kernels::Arrangement::{CommonDirection, CommonOrigin, OneRay, OneTriangle};
use trisect_method::{Form, Output};

use super::view::View;
use crate::statement::{Statement, found, holds, said, unmeasured};
use trisect_report::document::Section;
use trisect_report::format::{number, or_dash, ratio, scientific};
use trisect_report::stats::{geometric_mean, median, quantile};

const POINTS: [&str; 2] = ["moller-trumbore-1", "kensler-shirley-points"];

/// The methods that he built and timed, as they are here.
const HIS: [&str; 7] =
    [POINTS[0], POINTS[1], "keidy", "badouel", "wald", "shevtsov", "perpendicular-planes"];

fn is_his(v: &Variant) -> bool {
    HIS.contains(&&*v.method)
}

/// Whether something that is said to be faster is: differences of 3 % are none.
fn gains(of: Option<f64>) -> &'static str {
    match of {
        Some(gain) if (0.97..=1.03).contains(&gain) => "No difference here.",
        gain => holds(gain.map(|gain| gain > 1.0)),
    }
}

/// A ratio of speeds, none where the record has no such pair, and in words.
type Ratio = (Option<f64>, String);

struct Record<'a> {
    view: &'a View<'a>,
    /// The widest f32 lanes.
    width: usize,
}

impl Record<'_> {
    /// How much faster variants are once `change` has changed them, on random rays and meshes, or on the
    /// workload of that name.
    fn faster(
        &self,
        keep: impl Fn(&Variant) -> bool,
        change: impl Fn(&mut Variant),
        on: Option<&str>,
    ) -> Ratio {
        let is_on = |workload: &str| match (on, self.view.workloads.get(workload)) {
            (Some(name), _) => name == workload,
            (None, Some(w)) => matches!(w.family, Family::Random | Family::Mesh),
            (None, None) => false,
        };
        let mut ratios = Vec::new();
        let asked = |v: &Variant| v.needs == Output::Barycentrics && keep(v);
        for (variant, workloads) in self.view.throughput.iter().filter(|(v, _)| asked(v)) {
            let mut other = (*variant).clone();
            change(&mut other);
            let both = workloads
                .keys()
                .filter(|w| is_on(w))
                .filter_map(|w| Some(self.view.ns(variant, w)? / self.view.ns(&other, w)?));
            ratios.extend(geometric_mean(both.collect::<Vec<_>>()));
        }
        let mean = geometric_mean(ratios.iter().copied());
        let ends = quantile(&ratios, 0.0).zip(quantile(&ratios, 1.0));
        let says = mean.zip(ends).map(|(mean, (least, most))| match ratios.len() {
            1 => format!("{} (one pair)", ratio(mean)),
            count => format!("{} ({least:.2} to {most:.2} over {count} pairs)", ratio(mean)),
        });
        (mean, says.unwrap_or_else(|| "no such pair in this record".to_owned()))
    }

    /// Speed of one method over another's, in f32 in the same variants.
    fn pair(&self, method: &str, other: &str, is_in: impl Fn(&Variant) -> bool) -> Ratio {
        let keep = |v: &Variant| v.method == other && v.precision == F32 && is_in(v);
        let (mean, says) = self.faster(keep, |v| method.clone_into(v.method.to_mut()), None);
        (mean, format!("`{method}` over `{other}` {says}"))
    }

    fn is_wide(&self, v: &Variant) -> bool {
        v.width == self.width && v.arrangement == OneRay && v.arithmetic == MultiplyAdd::Fused
    }

    /// The same, scalar with early-out, then on the widest lanes: whether it is faster as a scalar, and both in
    /// words.
    fn both(&self, method: &str, other: &str) -> (&'static str, String) {
        let is_scalar = |v: &Variant| v.width == 1 && v.arrangement == OneRay && v.early_out;
        let (scalar, says) = self.pair(method, other, is_scalar);
        let (_, wide) = self.pair(method, other, |v| self.is_wide(v));
        (gains(scalar), format!("Scalar with early-out: {says}; {} lanes: {wide}.", self.width))
    }

    fn raw(&self) -> Vec<Statement> {
        let (holds, figures) = self.both(POINTS[1], POINTS[0]);
        vec![
            found("5.1.1: Möller–Trumbore is not the fastest; Kensler–Shirley is.", holds, figures),
            unmeasured(
                "5.1.1: from the fastest to the slowest it is almost an order of magnitude.",
                "Here preparation is timed apart, so that stored data are not compared from raw triangles.",
            ),
        ]
    }

    fn prepared(&self) -> Vec<Statement> {
        let (holds, figures) = self.both("perpendicular-planes", "wald");
        let axes = ["wald-table", "wald-indices", "wald-fixed-axis"]
            .map(|axis| self.pair(axis, "wald", |v| self.is_wide(v)).1);
        vec![
            found(
                "5.1.2: for one ray, projecting costs more than the simpler formulas save; the perpendicular \
                 planes gain up to 20 % over Wald.",
                holds,
                figures,
            ),
            said(
                "4.2.5: the axis may come from a table, from three stored indices, or be fixed.",
                format!(
                    "No claim about speed. Over triangles sorted by axis, on {} lanes: {}.",
                    self.width,
                    axes.join("; ")
                ),
            ),
            unmeasured(
                "4.2.5: the same of Badouel and Shevtsov.",
                "Their triangles are sorted by axis here, and in no other way.",
            ),
        ]
    }

    fn packets(&self) -> Vec<Statement> {
        let in_packets = |v: &Variant| v.width == self.width && v.arrangement == OneTriangle;
        let [wald, kensler, over_planes] = [
            ("wald", "perpendicular-planes"),
            (POINTS[1], "wald"),
            (POINTS[1], "perpendicular-planes"),
        ]
        .map(|(method, other)| self.pair(method, other, in_packets));
        let share = |arrangement, on| {
            let keep = |v: &Variant| in_packets(v) && v.precision == F32 && is_his(v);
            self.faster(keep, |v| v.arrangement = arrangement, Some(on))
        };
        let origin = share(CommonOrigin, "packets/origin");
        let direction = share(CommonDirection, "packets/direction");
        let keep = |v: &Variant| v.precision == F32 && self.is_wide(v) && !v.early_out && is_his(v);
        let group = self.faster(keep, |v| v.arrangement = OneTriangle, None);
        let all = wald.0.zip(kensler.0).zip(over_planes.0);
        vec![
            found(
                "5.1.3: in packets Wald no longer suffers from the axis, and Kensler–Shirley falls behind Wald \
                 and the planes.",
                holds(all.map(|((wald, a), b)| wald > 0.97 && a < 0.97 && b < 0.97)),
                format!("{}; {}; {}.", wald.1, kensler.1, over_planes.1),
            ),
            found(
                "4.2.2: a common origin saves half of the plane's intersection; parallel rays save even more.",
                holds(origin.0.zip(direction.0).map(|(o, d)| o > 1.03 && d > o)),
                format!(
                    "Over packets that share nothing: origin {}; direction {}.",
                    origin.1, direction.1
                ),
            ),
            found(
                "4.2.2: groups of triangles against one ray are rarely worth it; packets are.",
                gains(group.0),
                format!("Packets over groups: {}.", group.1),
            ),
        ]
    }

    fn worst_case(&self) -> Vec<Statement> {
        let is_in = |v: &Variant| v.width == 1 && v.arrangement == OneRay && !v.early_out;
        let over = |method: &str| self.pair(method, POINTS[0], is_in);
        let [kensler, keidy] = [POINTS[1], "keidy"].map(over);
        let stored = ["wald", "shevtsov", "perpendicular-planes"].map(over);
        let [wald, shevtsov, _] = [0, 1, 2].map(|i: usize| stored[i].0);
        vec![
            found(
                "5.3: with early exits disabled Möller–Trumbore is like Kensler–Shirley, and Keidy is behind.",
                holds(
                    kensler
                        .0
                        .zip(keidy.0)
                        .map(|(near, behind)| (0.9..=1.1).contains(&near) && behind < 0.97),
                ),
                format!("Scalar: {}; {}.", kensler.1, keidy.1),
            ),
            found(
                "5.3: the simpler stored formulas win clearly; the planes do oddly badly with one compiler.",
                holds(wald.zip(shevtsov).map(|(w, s)| w > 1.1 && s > 1.1)),
                format!("Scalar: {}.", stored.map(|of| of.1).join("; ")),
            ),
        ]
    }

    fn double(&self) -> Vec<Statement> {
        let single = |width: usize, times: usize| {
            let keep = |v: &Variant| v.precision == F64 && v.width == width && is_his(v);
            let change = |v: &mut Variant| (v.precision, v.width) = (F32, v.width * times);
            self.faster(keep, change, None).1
        };
        vec![said(
            "5.4: f64 is there to compare precision alone.",
            format!(
                "No claim about speed. f32 over f64, in the same variant: scalar {}; lanes of one register {}.",
                single(1, 1),
                single(self.width / 2, 2)
            ),
        )]
    }

    fn error(&self) -> Vec<Statement> {
        let mean = |method, precision| {
            Some(self.view.pooled_error((method, precision), "t", |_| true)?.mean)
        };
        let all = |precision| HIS.into_iter().filter_map(move |m| Some((mean(m, precision)?, m)));
        let most = all(F32).max_by(|a, b| a.0.total_cmp(&b.0));
        let middle = |precision| {
            or_dash(median(&all(precision).map(|of| of.0).collect::<Vec<_>>()), scientific)
        };
        let moved = HIS.into_iter().filter_map(|method| {
            let of = |form| {
                let pooled = self.view.pooled_error((method, F32), "t", |v| v.division == form);
                pooled.map(|error| error.median).filter(|error| *error > 0.0)
            };
            Some(of(Form::Deferred)? / of(Form::Early)?)
        });
        let moved = geometric_mean(moved.collect::<Vec<_>>());
        let agreed = self.view.all().filter(|a: &&Agreement| a.precision == F32);
        let [rays, of] = agreed.fold([0, 0], |[rays, of], a| [rays + a.rays, of + a.unanimous]);
        vec![
            found(
                "5.5: Möller–Trumbore errs most, and differences are too small to matter: about 1e-6 in f32, 1e-14 \
                 in f64.",
                holds(most.map(|(_, method)| method == POINTS[0])),
                format!(
                    "Mean relative error of t over his seven methods, median: f32 {}, f64 {}; most: {}.",
                    middle(F32),
                    middle(F64),
                    most.map_or_else(String::new, |(e, m)| format!("`{m}` {}", scientific(e)))
                ),
            ),
            found(
                "5.5: moving the division changes the error almost not at all.",
                holds(moved.map(|ratio| (0.8..1.25).contains(&ratio))),
                format!(
                    "Median error of t, deferred over early, over his methods: {}.",
                    or_dash(moved, ratio)
                ),
            ),
            found(
                "5.5: no two methods chose different triangles.",
                holds((rays > 0).then_some(rays == of)),
                format!("All methods of this record chose the same for {of} of {rays} rays."),
            ),
        ]
    }

    fn advice(&self) -> Vec<Statement> {
        let (faster, figures) = self.both("shevtsov", "wald");
        let ns =
            |method| format!("`{method}` {}", or_dash(self.view.preparation(method, F32), number));
        let prepared = [POINTS[1], "perpendicular-planes", "wald", "shevtsov"].map(ns).join(", ");
        vec![
            found("6.1: Wald and Shevtsov suit hierarchies; Shevtsov is faster.", faster, figures),
            unmeasured(
                "6.1: Keidy has no advantage but as a test of a point in a triangle, or where no normal is at hand.",
                "It is timed here as a whole test of a ray alone.",
            ),
            said(
                "6.1: Kensler–Shirley is the most universal; the planes suit dynamic scenes, and hardware where \
                 choosing an axis is dear.",
                format!("Advice, no measurement. Nanoseconds to prepare a triangle: {prepared}."),
            ),
            unmeasured(
                "2.3, 2.4: collision and visibility ask few rays, after bounding volumes: store as little as \
                 possible. 2.5: for radiosity stored data are especially suitable.",
                "No workload here is one of these.",
            ),
        ]
    }
}

/// His statements by what they are about.
pub(super) fn sections(view: &View) -> Vec<Section> {
    let lanes = view.throughput.keys().filter(|v| v.precision == F32);
    let record = Record { view, width: lanes.map(|v| v.width).max().unwrap_or(1) };
    [
        ("From raw triangles", record.raw()),
        ("Prepared triangles", record.prepared()),
        ("Packets", record.packets()),
        ("Worst case", record.worst_case()),
        ("Double precision", record.double()),
        ("Error", record.error()),
        ("Advice", record.advice()),
    ]
    .into_iter()
    .map(|(heading, items)| Section::list("havel", heading, items))
    .collect()
}
