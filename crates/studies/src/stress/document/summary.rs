//! The stability study in numbers, for a program to read.

use crate::record::{Header, Records};
use crate::stress::record::{
    ByCondition, Clause, Contract, Exactness, Limits, Site, StressLevel, SurfaceCracks,
};
use serde::Serialize;
use trisect_core::FloatFormat::{self, F32, F64};
use trisect_method::Form;

use super::exact::{ExactnessSummary, exactness_summary};
use super::select::{BEYOND, division, families, pairs, stands_for};
use crate::comparison::document::view::View;

/// The stability study in a screenful.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StressSummary {
    /// Who studied, where and how.
    pub header: Header,
    /// A row per method and precision, by year; in plain arithmetic, and deferred where the method
    /// has that.
    pub rows: Vec<StressRow>,
    /// Tests of hostile input, over all variants and clauses.
    pub contract_tests: u64,
    /// Those that violate a clause.
    pub contract_violations: u64,
    /// What holding methods to exactness found, where any claims it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exactness: Option<ExactnessSummary>,
}

/// What was found about one method in one precision.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StressRow {
    /// Name in the catalogue.
    pub method: String,
    /// `f32` or `f64`.
    pub precision: FloatFormat,
    /// `early` or `deferred`.
    pub division: Form,
    /// Pairs of all families but random bits.
    pub pairs: u64,
    /// Those called a hit that are none.
    pub false_hits: u64,
    /// Those called a miss that are a hit.
    pub false_misses: u64,
    /// Those whose answer is wrong by more than a thousandth.
    pub wrong: u64,
    /// The largest error of `t` over its condition number `κ` times the unit roundoff `u`, over the
    /// families that are not about the range of numbers, while `κ·u` is below a tenth: beyond, errors
    /// of second order count as well.
    pub error_over_condition: Option<f64>,
    /// Rays per million that pass through closed surfaces at the world's origin, aimed at edges.
    pub edge_cracks: Option<f64>,
    /// The same aimed at corners.
    pub vertex_cracks: Option<f64>,
    /// The same at an offset of 1000, aimed at either.
    pub far_cracks: Option<f64>,
    /// Sizes of a scene between which answers are right to a thousandth, with directions of length 1.
    pub scale: Option<[f64; 2]>,
    /// Lengths of the direction between which they are.
    pub direction_length: Option<[f64; 2]>,
    /// Distance of the origin, in sizes of the triangle, up to which they are.
    pub distance: Option<f64>,
    /// Offset of ray and triangle, in sizes of the triangle, up to which they are.
    pub offset: Option<f64>,
    /// Violations of the contract, over all variants of the precision.
    pub violations: u64,
}

/// Sums up what was studied.
pub fn stress_summary(records: &Records) -> StressSummary {
    of_view(&View::new(records))
}

pub(crate) fn of_view(view: &View) -> StressSummary {
    let rows = view
        .methods()
        .iter()
        .flat_map(|&method| [F32, F64].map(|precision| row(view, method, precision)))
        .filter(|row| row.pairs > 0)
        .collect();
    let clauses = view.all::<Contract>().flat_map(|c| c.clauses.values());
    StressSummary {
        header: view.records.header.clone(),
        rows,
        contract_tests: tests(view),
        contract_violations: clauses.map(|[_, violations]| violations).sum(),
        exactness: exactness(view),
    }
}

/// What holding methods to exactness found, where any claims it.
fn exactness(view: &View) -> Option<ExactnessSummary> {
    view.all::<Exactness>().next().map(|_| exactness_summary(view.records))
}

/// Pairs that the fuzz tested: each was held to every clause about one pair, and counted by kernels.
fn tests(view: &View) -> u64 {
    let of = |clause| {
        let counts = view.all::<Contract>().filter_map(move |c| c.clauses.get(&clause));
        counts.map(|[tests, _]| tests).sum::<u64>()
    };
    of(Clause::FiniteHits) + of(Clause::SameDecisions)
}

fn row(view: &View, method: &str, precision: FloatFormat) -> StressRow {
    let stands = |variant| stands_for(view, variant, method, precision);
    let counted = families(view, method, precision).filter(|f| !BEYOND.contains(&&*f.family));
    let levels: Vec<&StressLevel> = counted.flat_map(|family| &family.levels).collect();
    let sum = |of: fn(&StressLevel) -> u64| levels.iter().map(|level| of(level)).sum();
    let epsilon = if precision == F32 { f64::from(f32::EPSILON) } else { f64::EPSILON };
    let unit_roundoff = epsilon / 2.0;
    let bins = view
        .all::<ByCondition>()
        .filter(|b| b.inputs == precision && b.quantity == "t" && stands(&b.variant))
        .flat_map(|b| &b.decades)
        .filter(|bin| bin.to * unit_roundoff < 0.1);
    let cracks = view.all::<SurfaceCracks>().filter(|c| stands(&c.variant));
    let sites: Vec<&Site> =
        cracks.flat_map(|c| &c.sites).filter(|site| site.scale == 1.0).collect();
    let per_million = |keep: &dyn Fn(&Site) -> bool| {
        let kept = || sites.iter().filter(|site| keep(site));
        let rays: usize = kept().map(|site| site.rays).sum();
        let through: usize = kept().map(|site| site.no_hit).sum();
        (rays > 0).then(|| through as f64 * 1e6 / rays as f64)
    };
    let limits = |family: &str| {
        let mut all = view.all::<Limits>();
        let mine = all.find(|l| l.family == family && stands(&l.variant))?;
        Some([mine.smallest, mine.largest])
    };
    StressRow {
        method: method.to_owned(),
        precision,
        division: division(view, method),
        pairs: sum(pairs),
        false_hits: sum(|level| level.false_hits),
        false_misses: sum(|level| level.false_misses),
        wrong: sum(|level| level.wrong),
        error_over_condition: bins
            .map(|bin| f64::from(bin.over_condition.1))
            .max_by(f64::total_cmp),
        edge_cracks: per_million(&|site| site.offset == 0.0 && site.aim == "edges"),
        vertex_cracks: per_million(&|site| site.offset == 0.0 && site.aim == "vertices"),
        far_cracks: per_million(&|site| site.offset == 1e3),
        scale: limits("scale"),
        direction_length: limits("direction-length"),
        distance: limits("far-origin").map(|[_, largest]| largest),
        offset: limits("far-mesh").map(|[_, largest]| largest),
        violations: view
            .all::<Contract>()
            .filter(|c| c.variant.method == method && c.variant.precision == precision)
            .flat_map(|c| c.clauses.values())
            .map(|[_, violations]| violations)
            .sum(),
    }
}

impl StressRow {
    /// The share of pairs whose answer is wrong by more than a thousandth, in percent.
    pub(super) fn wrong_percent(&self) -> f64 {
        self.wrong as f64 * 100.0 / self.pairs.max(1) as f64
    }
}
