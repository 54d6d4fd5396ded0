//! What Havel found in his thesis of 2008, by its sections, beside what a record shows.
//!
//! Speeds are compared only between variants that differ in the one thing compared, on the same workloads, when
//! asked for t with barycentrics. What the record has no such pairs of is said to be not measured.

use crate::comparison::record::{Agreement, Family};
use crate::record::Variant;
use trisect_core::FloatFormat::{F32, F64};
use trisect_core::MultiplyAdd;
use trisect_kernels::Arrangement::{CommonDirection, CommonOrigin, OneRay, OneTriangle};
use trisect_method::{Form, Output};

use super::view::View;
use trisect_report::document::Section;
use trisect_report::format::{number, or_dash, ratio, scientific};
use trisect_report::stats::{geometric_mean, median};

const POINTS: [&str; 2] = ["moller-trumbore-1", "kensler-shirley-points"];

/// The methods that he built and timed, as they are here.
const HIS: [&str; 7] = [
    "moller-trumbore-1",
    "kensler-shirley-points",
    "keidy",
    "badouel",
    "wald",
    "shevtsov",
    "perpendicular-planes",
];

/// Speeds over speeds, of variants that differ in one thing.
#[derive(Clone)]
struct Ratios {
    mean: f64,
    says: String,
}

/// Whether something is faster by more than nothing.
fn is_gain(of: Option<&Ratios>) -> Option<bool> {
    of.map(|of| of.mean > 1.03)
}

fn says(of: Option<&Ratios>) -> &str {
    of.map_or("no such pair in this record", |of| &of.says)
}

/// A statement, whether it holds, and the figures.
type Statement = (String, String);

fn found(says: &str, holds: Option<bool>, figures: impl AsRef<str>) -> Statement {
    let verdict = match holds {
        Some(true) => "Holds here.",
        Some(false) => "Not here.",
        None => "Not measured.",
    };
    (says.to_owned(), format!("**{verdict}** {}", figures.as_ref()))
}

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
    ) -> Option<Ratios> {
        let is_on = |workload: &str| match (on, self.view.workloads.get(workload)) {
            (Some(name), _) => name == workload,
            (None, Some(w)) => matches!(w.family, Family::Random | Family::Mesh),
            (None, None) => false,
        };
        let mut ratios = Vec::new();
        for (variant, workloads) in &self.view.throughput {
            if variant.needs != Output::Barycentrics || !keep(variant) {
                continue;
            }
            let mut other = (*variant).clone();
            change(&mut other);
            let both = workloads
                .keys()
                .filter(|w| is_on(w))
                .filter_map(|w| Some(self.view.ns(variant, w)? / self.view.ns(&other, w)?));
            ratios.extend(geometric_mean(both.collect::<Vec<_>>()));
        }
        let mean = geometric_mean(ratios.iter().copied())?;
        let [least, most] = [
            ratios.iter().copied().fold(mean, f64::min),
            ratios.iter().copied().fold(mean, f64::max),
        ];
        let says = match ratios.len() {
            1 => format!("{} (one pair)", ratio(mean)),
            count => format!("{} ({least:.2} to {most:.2} over {count} pairs)", ratio(mean)),
        };
        Some(Ratios { mean, says })
    }

    /// Speed of one method over another's, in f32 in the same variants, scalar or on the widest lanes.
    fn over(&self, method: &str, other: &str, is_in: impl Fn(&Variant) -> bool) -> Option<Ratios> {
        let keep = |v: &Variant| v.method == other && v.precision == F32 && is_in(v);
        self.faster(keep, |v| method.clone_into(v.method.to_mut()), None)
    }

    fn is_scalar(v: &Variant) -> bool {
        v.width == 1 && v.arrangement == OneRay && v.early_out
    }

    fn is_wide(&self, v: &Variant) -> bool {
        v.width == self.width && v.arrangement == OneRay && v.arithmetic == MultiplyAdd::Fused
    }

    /// The same, scalar with early-out, then on the widest lanes, in words.
    fn both(&self, method: &str, other: &str) -> (Option<bool>, String) {
        let scalar = self.over(method, other, Self::is_scalar);
        let wide = self.over(method, other, |v| self.is_wide(v));
        let figures = format!(
            "`{method}` over `{other}`: scalar with early-out {}; {} lanes {}.",
            says(scalar.as_ref()),
            self.width,
            says(wide.as_ref())
        );
        (is_gain(scalar.as_ref()), figures)
    }

    fn raw(&self) -> Vec<Statement> {
        let (holds, figures) = self.both(POINTS[1], POINTS[0]);
        vec![
            found("5.1.1: Möller–Trumbore is not the fastest; Kensler–Shirley is.", holds, figures),
            found(
                "5.1.1: the winners win because they test t first.",
                None,
                "No formula is timed with t first and with t last, all else equal.",
            ),
            found(
                "5.1.1: from the fastest to the slowest it is almost an order of magnitude.",
                None,
                "Here preparation is timed apart, so that stored data are not compared from raw triangles.",
            ),
        ]
    }

    fn prepared(&self) -> Vec<Statement> {
        let (holds, figures) = self.both("perpendicular-planes", "wald");
        let axes = ["wald-table", "wald-indices", "wald-fixed-axis"].map(|axis| {
            let over = self.over(axis, "wald", |v| self.is_wide(v));
            format!("`{axis}` {}", says(over.as_ref()))
        });
        vec![
            found(
                "5.1.2: for one ray, projecting costs more than the simpler formulas save; the perpendicular \
                 planes gain up to 20 % over Wald.",
                holds,
                figures,
            ),
            (
                "4.2.5: the axis may come from a table, from three stored indices, or be fixed."
                    .to_owned(),
                format!(
                    "No claim about speed. Over `wald` on {} lanes: {}. Not measured of Badouel and \
                     Shevtsov.",
                    self.width,
                    axes.join("; ")
                ),
            ),
        ]
    }

    fn packets(&self) -> Vec<Statement> {
        let in_packets = |v: &Variant| v.width == self.width && v.arrangement == OneTriangle;
        let over = |a: &str, b: &str| self.over(a, b, in_packets);
        let planes = over("wald", "perpendicular-planes");
        let kensler = [over(POINTS[1], "wald"), over(POINTS[1], "perpendicular-planes")];
        let holds = planes.as_ref().zip(kensler[0].as_ref()).zip(kensler[1].as_ref());
        let share = |arrangement, on| {
            let keep = |v: &Variant| in_packets(v) && v.precision == F32;
            self.faster(keep, |v| v.arrangement = arrangement, Some(on))
        };
        let origin = share(CommonOrigin, "packets/origin");
        let direction = share(CommonDirection, "packets/direction");
        let group = self.faster(
            |v| v.precision == F32 && self.is_wide(v) && !v.early_out,
            |v| v.arrangement = OneTriangle,
            None,
        );
        vec![
            found(
                "5.1.3: in packets Wald no longer suffers from the axis, and Kensler–Shirley falls behind Wald \
                 and the planes.",
                holds.map(|((planes, a), b)| planes.mean > 0.97 && a.mean < 0.97 && b.mean < 0.97),
                format!(
                    "`wald` over `perpendicular-planes` {}; `{}` over `wald` {}, over the planes {}.",
                    says(planes.as_ref()),
                    POINTS[1],
                    says(kensler[0].as_ref()),
                    says(kensler[1].as_ref())
                ),
            ),
            found(
                "4.2.2: a common origin saves half of the plane's intersection; parallel rays save even more.",
                origin
                    .as_ref()
                    .zip(direction.as_ref())
                    .map(|(o, d)| o.mean > 1.03 && d.mean > o.mean),
                format!(
                    "Over packets that share nothing: origin {}; direction {}.",
                    says(origin.as_ref()),
                    says(direction.as_ref())
                ),
            ),
            found(
                "4.2.2: groups of triangles against one ray are rarely worth it; packets are.",
                is_gain(group.as_ref()),
                format!("Packets over groups: {}.", says(group.as_ref())),
            ),
            found(
                "4.2.2: packets of four that end early and fall apart into single rays.",
                None,
                "Packets that end early are compiled with the feature `full` alone.",
            ),
        ]
    }

    fn division(&self) -> Vec<Statement> {
        let worst = |is_in: &dyn Fn(&Variant) -> bool| {
            let keep = |v: &Variant| {
                v.precision == F32 && v.division == Form::Early && !v.early_out && is_in(v)
            };
            self.faster(keep, |v| v.division = Form::Deferred, None)
        };
        let scalar = worst(&|v| v.width == 1 && v.arrangement == OneRay);
        let wide = worst(&|v| self.is_wide(v));
        vec![
            found(
                "5.2: where tests end early, moving the division behind them gains much.",
                None,
                "Here the early form tests t first and the deferred one the inside: two things differ.",
            ),
            (
                "5.2: in the worst case it costs nothing marked, though Wald pays five more products and the \
                 planes six."
                    .to_owned(),
                format!(
                    "**Not settled.** With exits disabled the order of tests is no matter; deferred over early: \
                     scalar {}; {} lanes {}. The loops of both forms are not held to loops written by hand yet, \
                     so that nothing is concluded.",
                    says(scalar.as_ref()),
                    self.width,
                    says(wide.as_ref())
                ),
            ),
            found(
                "4.2.4: tests by sign bits, without turning numerators.",
                None,
                "Numbers are compared here, so that −0 counts as zero.",
            ),
            found(
                "4.2.1: a reciprocal estimate with one Newton step; 4.2.3: arrays of structures, structures of \
                 arrays, and blocks.",
                None,
                "The first is compiled with the feature `full` alone; triangles lie in blocks throughout.",
            ),
        ]
    }

    fn worst_case(&self) -> Vec<Statement> {
        let is_in = |v: &Variant| v.width == 1 && v.arrangement == OneRay && !v.early_out;
        let over = |method: &str| self.over(method, POINTS[0], is_in);
        let [kensler, keidy, wald, shevtsov, planes] =
            [POINTS[1], "keidy", "wald", "shevtsov", "perpendicular-planes"].map(over);
        let near = |of: &Option<Ratios>| of.as_ref().map(|of| (0.9..=1.1).contains(&of.mean));
        let behind = keidy.as_ref().map(|of| of.mean < 0.97);
        let said = |of: &Option<Ratios>| says(of.as_ref()).to_owned();
        vec![
            found(
                "5.3: with early exits disabled Möller–Trumbore is like Kensler–Shirley, and Keidy is behind.",
                near(&kensler).zip(behind).map(|(near, behind)| near && behind),
                format!(
                    "Scalar, over `{}`: `{}` {}; `keidy` {}.",
                    POINTS[0],
                    POINTS[1],
                    said(&kensler),
                    said(&keidy)
                ),
            ),
            found(
                "5.3: the simpler stored formulas win clearly; the planes do oddly badly with one compiler.",
                wald.as_ref().zip(shevtsov.as_ref()).map(|(w, s)| w.mean > 1.1 && s.mean > 1.1),
                format!(
                    "Scalar, over `{}`: `wald` {}; `shevtsov` {}; `perpendicular-planes` {}.",
                    POINTS[0],
                    said(&wald),
                    said(&shevtsov),
                    said(&planes)
                ),
            ),
        ]
    }

    fn double(&self) -> Vec<Statement> {
        let single = |is_in: &dyn Fn(&Variant) -> bool, halve: bool| {
            let keep = |v: &Variant| v.precision == F64 && is_in(v);
            let to_single = |v: &mut Variant| {
                v.precision = F32;
                v.width *= if halve { 2 } else { 1 };
            };
            self.faster(keep, to_single, None)
        };
        let scalar = single(&|v| v.width == 1, false);
        let wide = single(&|v| 2 * v.width == self.width, true);
        vec![(
            "5.4: f64 is there to compare precision alone.".to_owned(),
            format!(
                "No claim about speed. f32 over f64, in the same variant: scalar {}; lanes of one register {}.",
                says(scalar.as_ref()),
                says(wide.as_ref())
            ),
        )]
    }

    fn error(&self) -> Vec<Statement> {
        let mean = |method, precision| {
            Some(self.view.pooled_error((method, precision), "t", |_| true)?.mean)
        };
        let all = |precision| HIS.into_iter().filter_map(move |m| Some((mean(m, precision)?, m)));
        let most = all(F32).max_by(|a, b| a.0.total_cmp(&b.0));
        let middle = |precision| median(&all(precision).map(|of| of.0).collect::<Vec<_>>());
        let moved = HIS.into_iter().filter_map(|method| {
            let of = |form| {
                let pooled = self.view.pooled_error((method, F32), "t", |v| v.division == form);
                pooled.map(|error| error.median).filter(|error| *error > 0.0)
            };
            Some(of(Form::Deferred)? / of(Form::Early)?)
        });
        let moved = geometric_mean(moved.collect::<Vec<_>>());
        let agreed: Vec<&Agreement> =
            self.view.all().filter(|a: &&Agreement| a.precision == F32).collect();
        let [rays, unanimous] =
            agreed.iter().fold([0, 0], |[rays, of], a| [rays + a.rays, of + a.unanimous]);
        vec![
            found(
                "5.5: Möller–Trumbore errs most, and differences are too small to matter: about 1e-6 in f32, 1e-14 \
                 in f64.",
                most.map(|(_, method)| method == POINTS[0]),
                format!(
                    "Mean relative error of t over his seven methods, median: f32 {}, f64 {}; most: {}.",
                    or_dash(middle(F32), scientific),
                    or_dash(middle(F64), scientific),
                    most.map_or_else(String::new, |(e, m)| format!("`{m}` {}", scientific(e)))
                ),
            ),
            found(
                "5.5: moving the division changes the error almost not at all.",
                moved.map(|ratio| (0.8..1.25).contains(&ratio)),
                format!(
                    "Median error of t, deferred over early, over his methods: {}.",
                    or_dash(moved, ratio)
                ),
            ),
            found(
                "5.5: no two methods chose different triangles.",
                (rays > 0).then_some(rays == unanimous),
                format!("All methods chose the same for {unanimous} of {rays} rays."),
            ),
        ]
    }

    fn advice(&self) -> Vec<Statement> {
        let (faster, figures) = self.both("shevtsov", "wald");
        let ns = |method| or_dash(self.view.preparation(method, F32), number);
        vec![
            found("6.1: Wald and Shevtsov suit hierarchies; Shevtsov is faster.", faster, figures),
            found(
                "6.1: Keidy has no advantage but as a test of a point in a triangle, or where no normal is at hand.",
                None,
                "It is timed here as a whole test of a ray alone.",
            ),
            (
                "6.1: Kensler–Shirley is the most universal; the planes suit dynamic scenes, and hardware where \
                 choosing an axis is dear."
                    .to_owned(),
                format!(
                    "Advice, no measurement. To prepare a triangle takes `{}` {} ns, `perpendicular-planes` {}, \
                     `wald` {}, `shevtsov` {}.",
                    POINTS[1],
                    ns(POINTS[1]),
                    ns("perpendicular-planes"),
                    ns("wald"),
                    ns("shevtsov")
                ),
            ),
            found(
                "2.3, 2.4: collision and visibility ask few rays, after bounding volumes: store as little as \
                 possible. 2.5: for radiosity stored data are especially suitable.",
                None,
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
        ("Moving the division", record.division()),
        ("Worst case", record.worst_case()),
        ("Double precision", record.double()),
        ("Error", record.error()),
        ("Advice", record.advice()),
    ]
    .into_iter()
    .map(|(heading, items)| Section::list("havel", heading, items))
    .collect()
}
