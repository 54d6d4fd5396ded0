//! Tables of the stability study: each once, as heads and cells, for pages and documents alike.

use std::collections::BTreeMap;

use trisect_core::{FloatFormat, Form};
use trisect_harness::record::{Clause, Limits, StressFamily, StressLevel};

use super::figures::level_text;
use super::findings::{ENDLESS, far};
use super::summary::{StressRow, magnitude, of_view};
use super::{families, family_names, first_failure, stands_for};
use crate::format::{grouped, number, or_dash, scientific};
use crate::markdown::Table;
use crate::view::View;

/// A row per method in one precision.
pub(crate) fn methods(view: &View, precision: FloatFormat) -> Table {
    let mut table = Table::new(&[
        "method",
        "form",
        "wrong %",
        "false hits",
        "false misses",
        "err/κu",
        "edge cracks",
        "corner cracks",
        "far cracks",
        "size from",
        "to",
        "length from",
        "to",
        "distance",
        "offset",
    ]);
    let summary = of_view(view);
    for row in summary.rows.iter().filter(|row| row.precision == precision) {
        let StressRow { method, division, false_hits, false_misses, .. } = row;
        table.rows.push(vec![
            method.clone(),
            division.to_string(),
            number(row.wrong_percent()),
            grouped(*false_hits),
            grouped(*false_misses),
            or_dash(row.error_over_condition, scientific),
            or_dash(row.edge_cracks, number),
            or_dash(row.vertex_cracks, number),
            or_dash(row.far_cracks, number),
            or_dash(row.scale.map(|x| x[0]), magnitude),
            or_dash(row.scale.map(|x| x[1]), magnitude),
            or_dash(row.direction_length.map(|x| x[0]), magnitude),
            or_dash(row.direction_length.map(|x| x[1]), magnitude),
            or_dash(row.distance, far),
            or_dash(row.offset, far),
        ]);
    }
    table
}

/// What the columns of [`methods`] mean.
pub(crate) const METHODS: &str = "wrong: pairs of all hard families but random bits whose answer \
    is off by more than a thousandth. false hits, false misses: decisions that differ from the \
    oracle's, however near to an edge. err/κu: largest error of t over its condition number κ times \
    the unit roundoff u, while κ·u is below a tenth. cracks: rays per million that pass through closed surfaces (a sphere, a \
    ragged sphere, a cube) at the world's origin, aimed at edges and at corners, and aimed at \
    either at an offset of 1000. size, length, distance, offset: the sizes of the scene (with a \
    direction of length 1), lengths of the direction, distances and offsets over the triangle's size within which all \
    probes are right to a thousandth, found by bisection. Plain arithmetic.";

/// The first level of each family at which a method is wrong by more than a thousandth.
pub(crate) fn first_failures(view: &View, precision: FloatFormat) -> Table {
    let names = family_names(view);
    let mut table = Table { head: vec!["method".into()], rows: Vec::new() };
    table.head.extend(names.iter().map(|(name, _)| (*name).to_owned()));
    for &method in view.methods() {
        let all: Vec<_> = families(view, method, precision).collect();
        if all.is_empty() {
            continue;
        }
        let mut row = vec![method.to_owned()];
        row.extend(names.iter().map(|(name, _)| {
            let family = all.iter().find(|family| family.family == *name);
            let failure = family.and_then(|family| first_failure(family));
            failure.map_or_else(|| "·".into(), |(_, level)| level_text(level.level))
        }));
        table.rows.push(row);
    }
    table
}

/// The clauses of the contract, with their tests and violations.
pub(crate) fn contract(view: &View) -> Table {
    let mut sums: BTreeMap<Clause, [u64; 2]> = BTreeMap::new();
    for (clause, counts) in view.contract.iter().flat_map(|c| &c.clauses) {
        let sum = sums.entry(*clause).or_default();
        sum[0] += counts[0];
        sum[1] += counts[1];
    }
    let mut table = Table::new(&["clause", "tests", "violations"]);
    let says = |clause| match clause {
        Clause::FiniteHits => "no hit holds a NaN or an infinity",
        Clause::NotFiniteMisses => "a NaN or an infinity in ray or triangle misses",
        Clause::DegenerateMisses => "a degenerate triangle is missed",
        Clause::ZeroDirectionMisses => "a zero direction misses",
        Clause::WithinInterval => "t is in the closed interval",
        Clause::SameDecisions => "every need and arrangement decides alike",
        Clause::SameBits => "every width and instruction set gives the same bits",
    };
    table.rows = sums
        .into_iter()
        .map(|(clause, [tests, violations])| {
            vec![says(clause).to_owned(), grouped(tests), grouped(violations)]
        })
        .collect();
    table
}

/// Special values in clear hits, over all methods: what is decided wrongly, with subnormal numbers
/// kept and flushed to zero.
pub(crate) fn special_values(view: &View) -> Table {
    let mut order: Vec<(&str, &str)> = Vec::new();
    let mut sums: BTreeMap<(&str, &str, bool), [u64; 3]> = BTreeMap::new();
    for line in &view.special_values {
        for outcome in &line.outcomes {
            let key = (outcome.value.as_str(), outcome.place.as_str());
            if !order.contains(&key) {
                order.push(key);
            }
            let sum = sums.entry((key.0, key.1, line.flush_to_zero)).or_default();
            sum[0] += outcome.tests;
            sum[1] += outcome.false_hits;
            sum[2] += outcome.false_misses;
        }
    }
    let mut table = Table::new(&[
        "value",
        "in",
        "tests",
        "false hits",
        "false misses",
        "flushing: false hits",
        "false misses",
    ]);
    for (value, place) in order {
        let of = |flushed| sums.get(&(value, place, flushed)).copied().unwrap_or_default();
        let (kept, flushed) = (of(false), of(true));
        let mut row = vec![value.to_owned(), place.to_owned()];
        row.extend([kept[0], kept[1], kept[2], flushed[1], flushed[2]].map(grouped));
        table.rows.push(row);
    }
    table
}

/// What the columns of [`special_values`] mean.
pub(crate) const SPECIAL: &str = "A number of a pair that is hit clearly is replaced by the value, \
    over all methods and forms in f32 scalars; the oracle takes the value as it is. flushing: the \
    same with subnormal numbers counted as zeros, as processors do that are told to.";

/// What flushing subnormal numbers to zero does to the sizes that a method can take, and what fused
/// multiply-add does to its answers.
pub(crate) fn arithmetic(view: &View) -> Table {
    let mut table = Table::new(&[
        "method",
        "wrong below 1e-6",
        "flushing",
        "fused: decisions",
        "t over κu",
        "largest",
    ]);
    let small = |method: &str, flushed: bool| {
        let families = view.stress.iter().filter(|s| {
            s.flush_to_zero == flushed
                && (s.family == "scale" || s.family == "subnormal")
                && s.variant.division == super::division(view, method)
                && s.variant.method == method
                && s.variant.precision == FloatFormat::F32
        });
        // All that is subnormal is below.
        let is_small = |family: &StressFamily, level: &StressLevel| {
            family.family == "subnormal" || level.level < 1e-6
        };
        let levels = families.flat_map(|f| f.levels.iter().filter(move |l| is_small(f, l)));
        let (mut wrong, mut all) = (0, 0);
        for level in levels {
            wrong += level.wrong;
            all += super::pairs(level);
        }
        (all > 0).then(|| wrong as f64 * 100.0 / all as f64)
    };
    let percent = |x: Option<f64>| or_dash(x, |x| format!("{} %", number(x)));
    for &method in view.methods() {
        let fused = view.fused_differences.iter().find(|d| {
            d.inputs == FloatFormat::F32
                && d.variant.precision == FloatFormat::F32
                && d.variant.method == method
                && d.variant.division == super::division(view, method)
        });
        let kept = small(method, false);
        if kept.is_none() {
            continue;
        }
        let share = fused.map(|d| d.decisions as f64 * 100.0 / d.pairs.max(1) as f64);
        table.rows.push(vec![
            method.to_owned(),
            percent(kept),
            percent(small(method, true)),
            percent(share),
            or_dash(fused.map(|d| f64::from(d.t.0)), number),
            or_dash(fused.map(|d| f64::from(d.t.1)), number),
        ]);
    }
    table
}

/// What the columns of [`arithmetic`] mean.
pub(crate) const ARITHMETIC: &str = "wrong below 1e-6: answers off by more than a thousandth in \
    scenes smaller than that, down to the last bit of f32; flushing: the same with subnormal \
    numbers counted as zeros. fused: what multiply-adds with one rounding change, over the families \
    that are not about range: the share of decisions, and the difference of t over its condition \
    number times the unit roundoff, median and largest. f32, deferred where the method has it.";

fn precise(x: f64) -> String {
    format!("{x:.2e}")
}

fn precise_or_any(x: f64) -> String {
    if x < ENDLESS { precise(x) } else { far(x) }
}

/// The limits of every method, precision and division.
pub(crate) fn limits(view: &View) -> Table {
    let mut table = Table::new(&[
        "method",
        "precision",
        "form",
        "size from",
        "to",
        "length from",
        "to",
        "distance",
        "offset",
    ]);
    for &method in view.methods() {
        for precision in [FloatFormat::F32, FloatFormat::F64] {
            for division in [Form::Deferred, Form::Early] {
                let find = |family: &str| {
                    view.limits.iter().copied().find(|l: &&Limits| {
                        l.family == family
                            && l.variant.division == division
                            && l.variant.method == method
                            && l.variant.precision == precision
                    })
                };
                let all = ["scale", "direction-length", "far-origin", "far-mesh"].map(find);
                if all.iter().all(Option::is_none) {
                    continue;
                }
                let [scale, length, distance, offset] = all;
                let mut row = vec![method.to_owned(), precision.to_string(), division.to_string()];
                for both in [scale, length] {
                    row.push(or_dash(both.map(|l| l.smallest), precise));
                    row.push(or_dash(both.map(|l| l.largest), precise));
                }
                row.push(or_dash(distance.map(|l| l.largest), precise_or_any));
                row.push(or_dash(offset.map(|l| l.largest), precise_or_any));
                table.rows.push(row);
            }
        }
    }
    table
}

/// Rays aimed at closed surfaces by the forms that claim to be watertight, in plain arithmetic and
/// the deferred form: where, how many, and how many passed through.
pub(crate) fn watertight(view: &View) -> Table {
    let mut table =
        Table::new(&["method", "precision", "aimed at", "offset", "rays", "pass through"]);
    for fact in view.facts.iter().filter(|f| f.claims.iter().any(|claim| claim == "watertight")) {
        for precision in [FloatFormat::F32, FloatFormat::F64] {
            let mut sums: BTreeMap<(&str, u64), [usize; 2]> = BTreeMap::new();
            let mine = view
                .surface_cracks
                .iter()
                .filter(|c| stands_for(view, &c.variant, &fact.name, precision));
            for site in mine.flat_map(|c| &c.sites).filter(|site| site.scale == 1.0) {
                let sum = sums.entry((&site.aim, site.offset.to_bits())).or_default();
                sum[0] += site.rays;
                sum[1] += site.no_hit;
            }
            for ((aim, offset), [rays, through]) in sums {
                table.rows.push(vec![
                    fact.name.clone(),
                    precision.to_string(),
                    aim.to_owned(),
                    level_text(f64::from_bits(offset)),
                    grouped(rays as u64),
                    grouped(through as u64),
                ]);
            }
        }
    }
    table
}
