//! Tables of the stability study.

use std::collections::BTreeMap;

use crate::comparison::record::MethodFacts;
use crate::stress::record::{
    Clause, Contract, FusedDifference, Limits, SpecialValues, StressFamily, StressLevel,
    SurfaceCracks,
};
use trisect_core::FloatFormat::{self, F32, F64};
use trisect_method::Form;

use super::select::{
    ENDLESS, division, families, family_names, far, first_failure, level_text, magnitude, pairs,
    stands_for,
};
use super::summary::{StressRow, StressSummary};
use crate::comparison::document::view::View;
use crate::lines::distinct;
use trisect_report::format::{number, scientific};
use trisect_report::table::{Cell, Kind, Table};

/// A row per method in one precision.
pub(super) fn methods(summary: &StressSummary, precision: FloatFormat) -> Table {
    let rows: Vec<&StressRow> =
        summary.rows.iter().filter(|row| row.precision == precision).collect();
    Table::of(&rows)
        .name("method", |row| &row.method)
        .text("form", |row| row.division.name())
        .number("wrong %", number, |row| row.wrong_percent())
        .count("false hits", |row| row.false_hits)
        .count("false misses", |row| row.false_misses)
        .number("err/κu", scientific, |row| row.error_over_condition)
        .number("edge cracks", number, |row| row.edge_cracks)
        .number("corner cracks", number, |row| row.vertex_cracks)
        .number("far cracks", number, |row| row.far_cracks)
        .number("size from", magnitude, |row| Some(row.scale?[0]))
        .number("to", magnitude, |row| Some(row.scale?[1]))
        .number("length from", magnitude, |row| Some(row.direction_length?[0]))
        .number("to", magnitude, |row| Some(row.direction_length?[1]))
        .number("distance", far, |row| row.distance)
        .number("offset", far, |row| row.offset)
        .done()
}

/// The first level of each family at which a method is wrong by more than a thousandth.
pub(super) fn first_failures(view: &View, precision: FloatFormat) -> Table {
    let of = |&method: &&'_ str| (method.to_owned(), families(view, method, precision).collect());
    let mut rows: Vec<(String, Vec<&StressFamily>)> = view.methods().iter().map(of).collect();
    rows.retain(|(_, families)| !families.is_empty());
    let mut table = Table::of(&rows).name("method", |(method, _)| method);
    for (name, _) in family_names(view) {
        table = table.cells(name, Kind::Number, |(_, families)| {
            let family = families.iter().find(|family| family.family == *name);
            let failure = family.and_then(|family| first_failure(family));
            failure
                .map_or(Cell::Text("·".into()), |(_, level)| Cell::Number(level.level, level_text))
        });
    }
    table.done()
}

/// The clauses of the contract, with their tests and violations.
pub(super) fn contract(view: &View) -> Table {
    let mut sums: BTreeMap<Clause, [u64; 2]> = BTreeMap::new();
    for (clause, counts) in view.all::<Contract>().flat_map(|c| &c.clauses) {
        let sum = sums.entry(*clause).or_default();
        sum[0] += counts[0];
        sum[1] += counts[1];
    }
    let says = |(clause, _): &(Clause, [u64; 2])| match clause {
        Clause::FiniteHits => "no hit holds a NaN or an infinity",
        Clause::NotFiniteMisses => "a NaN or an infinity in ray or triangle misses",
        Clause::DegenerateMisses => "a degenerate triangle is missed",
        Clause::ZeroDirectionMisses => "a zero direction misses",
        Clause::WithinInterval => "t is in the closed interval",
        Clause::SameDecisions => "every need and arrangement decides alike",
        Clause::SameBits => "every width and instruction set gives the same bits",
    };
    Table::of(&sums.into_iter().collect::<Vec<_>>())
        .name("clause", says)
        .count("tests", |(_, [tests, _])| *tests)
        .count("violations", |(_, [_, violations])| *violations)
        .done()
}

/// Special values in clear hits, over all methods: what is decided wrongly, with subnormal numbers
/// kept and flushed to zero.
pub(super) fn special_values(view: &View) -> Table {
    let lines = || {
        view.all::<SpecialValues>().flat_map(|line| {
            line.outcomes.iter().map(move |outcome| {
                (outcome.value.as_str(), outcome.place.as_str(), line.flush_to_zero, outcome)
            })
        })
    };
    let mut sums: BTreeMap<(&str, &str, bool), [u64; 3]> = BTreeMap::new();
    for (value, place, flushed, outcome) in lines() {
        let sum = sums.entry((value, place, flushed)).or_default();
        sum[0] += outcome.tests;
        sum[1] += outcome.false_hits;
        sum[2] += outcome.false_misses;
    }
    let rows = distinct(lines().map(|(value, place, ..)| (value, place)));
    let of = |&(value, place): &(&str, &str), flushed, which: usize| {
        sums.get(&(value, place, flushed)).map_or(0, |sum| sum[which])
    };
    Table::of(&rows)
        .name("value", |(value, _)| *value)
        .text("in", |(_, place)| *place)
        .count("tests", |row| of(row, false, 0))
        .count("false hits", |row| of(row, false, 1))
        .count("false misses", |row| of(row, false, 2))
        .count("flushing: false hits", |row| of(row, true, 1))
        .count("false misses", |row| of(row, true, 2))
        .done()
}

/// A share in per cent.
fn percent(x: f64) -> String {
    format!("{} %", number(x))
}

/// What flushing subnormal numbers to zero does to the sizes that a method can take, and what fused
/// multiply-add does to its answers.
pub(super) fn arithmetic(view: &View) -> Table {
    let small = |method: &str, flushed: bool| {
        let families = view.all::<StressFamily>().filter(|s| {
            s.flush_to_zero == flushed
                && (s.family == "scale" || s.family == "subnormal")
                && s.variant.division == division(view, method)
                && s.variant.method == method
                && s.variant.precision == F32
        });
        // All that is subnormal is below.
        let is_small = |family: &StressFamily, level: &StressLevel| {
            family.family == "subnormal" || level.level < 1e-6
        };
        let levels = families.flat_map(|f| f.levels.iter().filter(move |l| is_small(f, l)));
        let (wrong, all) = levels.fold((0, 0), |sum, l| (sum.0 + l.wrong, sum.1 + pairs(l)));
        (all > 0).then(|| wrong as f64 * 100.0 / all as f64)
    };
    let fused = |method: &str| {
        view.all::<FusedDifference>().find(|d| {
            d.inputs == F32
                && d.variant.precision == F32
                && d.variant.method == method
                && d.variant.division == division(view, method)
        })
    };
    let rows: Vec<(&str, f64, Option<&FusedDifference>)> = view
        .methods()
        .iter()
        .filter_map(|&method| Some((method, small(method, false)?, fused(method))))
        .collect();
    Table::of(&rows)
        .name("method", |(method, ..)| *method)
        .number("wrong below 1e-6", percent, |(_, kept, _)| *kept)
        .number("flushing", percent, |(method, ..)| small(method, true))
        .number("fused: decisions", percent, |(.., fused)| {
            fused.map(|d| d.decisions as f64 * 100.0 / d.pairs.max(1) as f64)
        })
        .number("t over κu", number, |(.., fused)| fused.map(|d| f64::from(d.t.0)))
        .number("largest", number, |(.., fused)| fused.map(|d| f64::from(d.t.1)))
        .done()
}

fn precise(x: f64) -> String {
    format!("{x:.2e}")
}

fn precise_or_any(x: f64) -> String {
    if x < ENDLESS { precise(x) } else { far(x) }
}

/// The limits of every method, precision and division.
pub(super) fn limits(view: &View) -> Table {
    let mut rows = Vec::new();
    for &method in view.methods() {
        for precision in [F32, F64] {
            for division in [Form::Deferred, Form::Early] {
                let mine: Vec<&Limits> = view
                    .all::<Limits>()
                    .filter(|l| {
                        l.variant.division == division
                            && l.variant.method == method
                            && l.variant.precision == precision
                    })
                    .collect();
                let find = |family| mine.iter().copied().find(|l| l.family == family);
                let all = ["scale", "direction-length", "far-origin", "far-mesh"].map(find);
                if all.iter().any(Option::is_some) {
                    rows.push((method, precision, division, all));
                }
            }
        }
    }
    let mut table = Table::of(&rows)
        .name("method", |(method, ..)| *method)
        .text("precision", |(_, precision, ..)| precision.name())
        .text("form", |(_, _, division, _)| division.name());
    for (which, head) in ["size from", "length from"].into_iter().enumerate() {
        table = table.number(head, precise, |(.., all)| Some(all[which]?.smallest)).number(
            "to",
            precise,
            |(.., all)| Some(all[which]?.largest),
        );
    }
    for (which, head) in [(2, "distance"), (3, "offset")] {
        table = table.number(head, precise_or_any, |(.., all)| Some(all[which]?.largest));
    }
    table.done()
}

/// Rays aimed at closed surfaces by the forms that claim to be watertight, in plain arithmetic and
/// the deferred form: where, how many, and how many passed through.
pub(super) fn watertight(view: &View) -> Table {
    let claims = |f: &&&MethodFacts| f.claims.iter().any(|claim| claim == "watertight");
    let mut rows = Vec::new();
    for fact in view.facts.iter().filter(claims) {
        for precision in [F32, F64] {
            let mut sums: BTreeMap<(&str, u64), [usize; 2]> = BTreeMap::new();
            let mine = view
                .all::<SurfaceCracks>()
                .filter(|c| stands_for(view, &c.variant, &fact.name, precision));
            for site in mine.flat_map(|c| &c.sites).filter(|site| site.scale == 1.0) {
                let sum = sums.entry((&site.aim, site.offset.to_bits())).or_default();
                sum[0] += site.rays;
                sum[1] += site.no_hit;
            }
            rows.extend(sums.into_iter().map(|(at, counts)| (&fact.name, precision, at, counts)));
        }
    }
    Table::of(&rows)
        .name("method", |(method, ..)| *method)
        .text("precision", |(_, precision, ..)| precision.name())
        .text("aimed at", |(_, _, (aim, _), _)| *aim)
        .number("offset", level_text, |(_, _, (_, offset), _)| f64::from_bits(*offset))
        .count("rays", |(.., [rays, _])| *rays as u64)
        .count("pass through", |(.., [_, through])| *through as u64)
        .done()
}
