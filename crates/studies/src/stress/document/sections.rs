//! What the stability study says.

use crate::record::Records;
use crate::stress::record::Stages;
use trisect_core::FloatFormat::{F32, F64};
use trisect_method::Output;

use super::exact::{EXACTNESS, STAGES, stages};
use super::summary::{StressRow, StressSummary, of_view};
use super::{figures, findings, tables};
use crate::comparison::document::view::{BASELINE, View};
use crate::lines::source;
use trisect_report::document::{Document, Finding, Section, Shown};
use trisect_report::format::{grouped, number, scientific};

const METHODS: &str = "wrong: pairs of all hard families but random bits whose answer is off by more than a \
    thousandth. false hits, false misses: decisions that differ from the oracle's, however near to an edge. \
    err/κu: largest error of t over its condition number κ times the unit roundoff u, while κ·u is below a \
    tenth. cracks: rays per million that pass through closed surfaces (a sphere, a ragged sphere, a cube) \
    at the world's origin, aimed at edges and at corners, and aimed at either at an offset of 1000. size, \
    length, distance, offset: the sizes of the scene (with a direction of length 1), lengths of the \
    direction, distances and offsets over the triangle's size within which all probes are right to a \
    thousandth, found by bisection. Plain arithmetic.";

const BRIEF: &str = "wrong: percent of the pairs of all hard families whose answer is off by more than a \
    thousandth. err/κu: largest error of t over its condition number κ times the unit roundoff u, while κu \
    is below a tenth. edges, corners: rays per million aimed there that pass through closed surfaces. size, \
    to: the sizes of scenes, with directions of length 1, and dist: the distance over the triangle's size, \
    within which all probes are right to a thousandth. Deferred division where the method has it.";

const SPECIAL: &str = "A number of a pair that is hit clearly is replaced by the value, over all methods and \
    forms in f32 scalars; the oracle takes the value as it is. flushing: the same with subnormal numbers \
    counted as zeros, as processors do that are told to.";

const ARITHMETIC: &str = "wrong below 1e-6: answers off by more than a thousandth in scenes smaller than \
    that, down to the last bit of f32; flushing: the same with subnormal numbers counted as zeros. fused: \
    what multiply-adds with one rounding change, over the families that are not about range: the share of \
    decisions, and the difference of t over its condition number times the unit roundoff, median and \
    largest. f32, deferred where the method has it.";

pub(crate) fn document(records: &Records) -> Document {
    let view = &View::new(records);
    let summary = &of_view(view);
    let [single, double] = [F32, F64].map(|precision| tables::methods(summary, precision));
    let brief = single.pick(&[
        ("method", "f32, plain"),
        ("wrong %", "wrong"),
        ("err/κu", "err/κu"),
        ("edge cracks", "edges"),
        ("corner cracks", "corners"),
        ("size from", "size"),
        ("to", "to"),
        ("distance", "dist"),
    ]);
    let mut sections = vec![Section::findings("", answers(view, summary))];
    sections.extend(figures::all(view));
    sections.push(Section::brief(brief, BRIEF));
    sections.extend(said(summary));
    sections.extend([
        Section::table("f32", "All methods in f32", METHODS, single).part("stress-f32"),
        Section::table("f64", "All methods in f64", METHODS, double).part("stress-f64"),
        Section::table(
            "watertight",
            "Watertight methods",
            "Rays aimed at the edges and corners of closed surfaces, in plain arithmetic and the deferred \
             form.",
            tables::watertight(view),
        )
        .part("stress-watertight"),
        Section::table(
            "first",
            "First failures in f32",
            "The levels that the map above shows as squares; a dot never fails.",
            tables::first_failures(view, F32),
        ),
        Section::table(
            "limits",
            "Limits",
            "Within these all probes are right to a thousandth, found by bisection: sizes of the scene with \
             a direction of length 1, lengths of the direction, and the distance and the offset over the \
             triangle's size. Plain arithmetic.",
            tables::limits(view),
        ),
        Section::table(
            "contract",
            "The contract",
            "Hostile input, random bits among it, to every kernel of every method; what the clauses say is \
             in docs/CONTRACT.md.",
            tables::contract(view),
        )
        .part("stress-contract"),
        Section::table("special", "Special values", SPECIAL, tables::special_values(view))
            .part("stress-special"),
        Section::table("arithmetic", "Flushing and fusing", ARITHMETIC, tables::arithmetic(view))
            .part("stress-arithmetic"),
    ]);
    // Records of earlier schemas have neither.
    let exact = super::exact::exactness_summary(view.records).table();
    let stages = stages(&view.all::<Stages>().collect::<Vec<_>>());
    sections.push(Section::table("exact", "Exactness", EXACTNESS, exact).part("stress-exact"));
    sections.push(Section::table("stages", "Stages", STAGES, stages).part("stress-stages"));
    sections.extend(findings::sections(view, summary));
    Document {
        title: "Ray–triangle intersection, stiff and extreme",
        heading: "Stiff and extreme cases",
        source: source(&records.header),
        sections,
    }
}

/// What was held to the contract and to exactness, each in a sentence.
fn said(summary: &StressSummary) -> [Section; 2] {
    let contract = format!(
        "Contract: {} tests of hostile input over all kernels, {} violations.",
        grouped(summary.contract_tests),
        grouped(summary.contract_violations)
    );
    let exact = summary.exactness.as_ref().map(|exact| format!("Exactness: {}", exact.sentence()));
    [contract, exact.unwrap_or_default()].map(|says| Section::prose(says).shown(Shown::Terminal))
}

/// The answers at the head of the page.
fn answers(view: &View, summary: &StressSummary) -> Vec<Finding> {
    let single = || summary.rows.iter().filter(|row| row.precision == F32);
    // Of a method without weights fewer numbers can be wrong.
    let weighs = |row: &&StressRow| {
        let fact = view.fact(&row.method);
        fact.is_some_and(|fact| fact.outputs.contains(&Output::Barycentrics))
    };
    let least = |a: &&StressRow, b: &&StressRow| a.wrong_percent().total_cmp(&b.wrong_percent());
    let fewest = single().filter(weighs).min_by(least).map(|row| {
        let how = format!(
            "{} % of {} hard pairs are off by more than a thousandth{}",
            number(row.wrong_percent()),
            grouped(row.pairs),
            against_baseline(single(), |row| Some(row.wrong_percent()), " %"),
        );
        Finding::new("Fewest wrong answers in f32, with weights", view.title(&row.method), how)
    });
    let worst = |row: &StressRow| row.error_over_condition;
    let bounded = single().filter_map(|row| Some((row, worst(row)?)));
    let smallest = bounded.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(row, error)| {
        let how = format!(
            "t is never off by more than {} condition numbers times the unit roundoff{}",
            number(error),
            against_baseline(single(), worst, "")
        );
        Finding::new("Smallest error over κ·u in f32", view.title(&row.method), how)
    });
    let tight = single().filter(|row| row.is_tight()).map(|row| view.title(&row.method));
    let tight = tight.collect::<Vec<_>>().join(", ");
    let cracks = Finding::new(
        "No cracks in f32",
        if tight.is_empty() { "no method".into() } else { tight },
        format!(
            "rays per million aimed at edges that pass through closed surfaces{}",
            against_baseline(single(), |row| row.edge_cracks, "")
        ),
    );
    let contract = Finding::new(
        "The contract",
        format!("{} violations", grouped(summary.contract_violations)),
        format!(
            "in {} tests of hostile input over all kernels",
            scientific(summary.contract_tests as f64)
        ),
    );
    fewest.into_iter().chain(smallest).chain([cracks, contract]).collect()
}

/// "; Möller–Trumbore: 3 %"
fn against_baseline<'a>(
    mut rows: impl Iterator<Item = &'a StressRow>,
    of: impl Fn(&StressRow) -> Option<f64>,
    unit: &str,
) -> String {
    let value = rows.find(|row| row.method == BASELINE).and_then(of);
    value.map_or_else(String::new, |x| format!("; Möller–Trumbore: {}{unit}", number(x)))
}
