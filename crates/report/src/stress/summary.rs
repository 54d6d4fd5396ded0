//! What a terminal prints after the stability study.

use serde::Serialize;
use trisect_core::{FloatFormat, Form};
use trisect_harness::record::{Clause, Header, Records, Site};

use super::exact::{ExactnessSummary, summed};
use super::{BEYOND, division, families, pairs, stands_for};
use crate::format::{number, or_dash, scientific};
use crate::text::{Table, wrap};
use crate::view::View;

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
        .flat_map(|&method| {
            [FloatFormat::F32, FloatFormat::F64].map(|precision| row(view, method, precision))
        })
        .filter(|row| row.pairs > 0)
        .collect();
    let clauses = || view.contract.iter().flat_map(|c| c.clauses.values());
    StressSummary {
        header: view.header.clone(),
        rows,
        contract_tests: tests(view),
        contract_violations: clauses().map(|[_, violations]| violations).sum(),
        exactness: (!view.exactness.is_empty()).then(|| summed(view.exactness.iter().copied())),
    }
}

/// Pairs that the fuzz tested: each was held to every clause about one pair, and counted by kernels.
fn tests(view: &View) -> u64 {
    let of = |clause| {
        let counts = view.contract.iter().filter_map(move |c| c.clauses.get(&clause));
        counts.map(|[tests, _]| tests).sum::<u64>()
    };
    of(Clause::FiniteHits) + of(Clause::SameDecisions)
}

fn row(view: &View, method: &str, precision: FloatFormat) -> StressRow {
    let mut row = StressRow {
        method: method.to_owned(),
        precision,
        division: division(view, method),
        pairs: 0,
        false_hits: 0,
        false_misses: 0,
        wrong: 0,
        error_over_condition: None,
        edge_cracks: None,
        vertex_cracks: None,
        far_cracks: None,
        scale: None,
        direction_length: None,
        distance: None,
        offset: None,
        violations: 0,
    };
    let counted = families(view, method, precision).filter(|f| !BEYOND.contains(&&*f.family));
    for level in counted.flat_map(|family| &family.levels) {
        row.pairs += pairs(level);
        row.false_hits += level.false_hits;
        row.false_misses += level.false_misses;
        row.wrong += level.wrong;
    }
    let epsilon =
        if precision == FloatFormat::F32 { f64::from(f32::EPSILON) } else { f64::EPSILON };
    let unit_roundoff = epsilon / 2.0;
    row.error_over_condition = view
        .by_condition
        .iter()
        .filter(|b| b.inputs == precision && b.quantity == "t")
        .filter(|b| stands_for(view, &b.variant, method, precision))
        .flat_map(|b| &b.decades)
        .filter(|bin| bin.to * unit_roundoff < 0.1)
        .map(|bin| f64::from(bin.over_condition.1))
        .max_by(f64::total_cmp);
    let sites: Vec<&Site> = view
        .surface_cracks
        .iter()
        .filter(|c| stands_for(view, &c.variant, method, precision))
        .flat_map(|c| &c.sites)
        .filter(|site| site.scale == 1.0)
        .collect();
    let per_million = |keep: &dyn Fn(&Site) -> bool| {
        let kept = || sites.iter().filter(|site| keep(site));
        let rays: usize = kept().map(|site| site.rays).sum();
        let through: usize = kept().map(|site| site.no_hit).sum();
        (rays > 0).then(|| through as f64 * 1e6 / rays as f64)
    };
    row.edge_cracks = per_million(&|site| site.offset == 0.0 && site.aim == "edges");
    row.vertex_cracks = per_million(&|site| site.offset == 0.0 && site.aim == "vertices");
    row.far_cracks = per_million(&|site| site.offset == 1e3);
    let limits = |family: &str| {
        let mine = |l: &&&trisect_harness::record::Limits| {
            l.family == family && stands_for(view, &l.variant, method, precision)
        };
        view.limits.iter().find(mine).map(|l| [l.smallest, l.largest])
    };
    row.scale = limits("scale");
    row.direction_length = limits("direction-length");
    row.distance = limits("far-origin").map(|[_, largest]| largest);
    row.offset = limits("far-mesh").map(|[_, largest]| largest);
    row.violations = view
        .contract
        .iter()
        .filter(|c| c.variant.method == method && c.variant.precision == precision)
        .flat_map(|c| c.clauses.values())
        .map(|[_, violations]| violations)
        .sum();
    row
}

impl StressRow {
    /// The share of pairs whose answer is wrong by more than a thousandth, in percent.
    pub(crate) fn wrong_percent(&self) -> f64 {
        self.wrong as f64 * 100.0 / self.pairs.max(1) as f64
    }
}

/// An order of magnitude, rounded down in digits that fit a narrow column.
pub(crate) fn magnitude(x: f64) -> String {
    format!("{x:.0e}")
}

impl StressSummary {
    /// The summary as text of at most `width` columns, for 40 columns or more.
    pub fn to_text(&self, width: usize) -> String {
        let h = &self.header;
        let machine = format!("trisect {} on {}, {}", h.trisect, h.machine.cpu, h.machine.compiler);
        let mut out = wrap(&machine, width, "  ");
        out.push('\n');
        let mut table = Table::new(&[
            "f32, plain",
            "wrong",
            "err/κu",
            "edges",
            "corners",
            "size",
            "to",
            "dist",
        ]);
        for row in self.rows.iter().filter(|row| row.precision == FloatFormat::F32) {
            table.rows.push(vec![
                row.method.clone(),
                number(row.wrong_percent()),
                or_dash(row.error_over_condition, scientific),
                or_dash(row.edge_cracks, number),
                or_dash(row.vertex_cracks, number),
                or_dash(row.scale.map(|s| s[0]), magnitude),
                or_dash(row.scale.map(|s| s[1]), magnitude),
                or_dash(row.distance, super::findings::far),
            ]);
        }
        out.push_str(&table.render(width));
        out.push_str(&wrap(
            "wrong: percent of the pairs of all hard families whose answer is off by more than a \
             thousandth. err/κu: largest error of t over its condition number κ times the unit \
             roundoff u, while κu is below a tenth. edges, corners: rays per million aimed there that pass through closed \
             surfaces. size, to: the sizes of scenes, with directions of length 1, and dist: the \
             distance over the triangle's size, within which all probes are right to a thousandth. \
             Deferred division where the method has it.",
            width,
            "",
        ));
        let contract = format!(
            "Contract: {} tests of hostile input over all kernels, {} violations.",
            crate::format::grouped(self.contract_tests),
            crate::format::grouped(self.contract_violations)
        );
        out.push('\n');
        out.push_str(&wrap(&contract, width, ""));
        if let Some(exactness) = &self.exactness {
            out.push_str(&wrap(&format!("Exactness: {}", exactness.sentence()), width, ""));
        }
        out
    }
}
