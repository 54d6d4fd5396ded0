//! The page of the stability study.

use trisect_core::{FloatFormat, Output};

use super::exact;
use super::figures;
use super::markdown;
use super::summary::{StressRow, StressSummary, of_view};
use crate::chapter::{Link, PageError};
use crate::format::{grouped, number, scientific};
use crate::page::{Drawn, Finding, Study, Titled, draw_study};
use crate::view::{BASELINE, View};

/// Draws the page and its figures.
pub(crate) fn draw(view: &View, links: Vec<Link>) -> Result<Drawn, PageError> {
    let study = Study {
        title: "Ray–triangle intersection, stiff and extreme",
        heading: "Stiff and extreme cases",
        findings: findings(view, &of_view(view)),
        tables: tables(view),
        pictures: Vec::new(),
    };
    draw_study(view, links, figures::all(view), study)
}

fn tables(view: &View) -> Vec<Titled> {
    let mut tables = vec![
        Titled::new(
            "f32",
            "All methods in f32",
            markdown::METHODS,
            markdown::methods(view, FloatFormat::F32),
        ),
        Titled::new(
            "f64",
            "All methods in f64",
            markdown::METHODS,
            markdown::methods(view, FloatFormat::F64),
        ),
        Titled::new(
            "watertight",
            "Watertight methods",
            "Rays aimed at the edges and corners of closed surfaces, in plain arithmetic and the \
             deferred form.",
            markdown::watertight(view),
        ),
        Titled::new(
            "first",
            "First failures in f32",
            "The levels that the map above shows as squares; a dot never fails.",
            markdown::first_failures(view, FloatFormat::F32),
        ),
        Titled::new(
            "limits",
            "Limits",
            "Within these all probes are right to a thousandth, found by bisection: sizes of the \
             scene with a direction of length 1, lengths of the direction, and the distance and \
             the offset over the triangle's size. Plain arithmetic.",
            markdown::limits(view),
        ),
        Titled::new(
            "contract",
            "The contract",
            "Hostile input, random bits among it, to every kernel of every method; what the \
             clauses say is in docs/CONTRACT.md.",
            markdown::contract(view),
        ),
        Titled::new("special", "Special values", markdown::SPECIAL, markdown::special_values(view)),
        Titled::new(
            "arithmetic",
            "Flushing and fusing",
            markdown::ARITHMETIC,
            markdown::arithmetic(view),
        ),
    ];
    // Records of earlier schemas have neither.
    if !view.exactness.is_empty() {
        tables.push(Titled::new("exact", "Exactness", exact::EXACTNESS, exact::exactness(view)));
    }
    if !view.stages.is_empty() {
        tables.push(Titled::new("stages", "Stages", exact::STAGES, exact::stages(view)));
    }
    tables
}

fn findings(view: &View, summary: &StressSummary) -> Vec<Finding> {
    let single = || summary.rows.iter().filter(|row| row.precision == FloatFormat::F32);
    let mut findings = Vec::new();
    // Of a method without weights fewer numbers can be wrong.
    let weighs = |row: &&StressRow| {
        let fact = view.fact(&row.method);
        fact.is_some_and(|fact| fact.outputs.contains(&Output::Barycentrics))
    };
    let fewest = |a: &&StressRow, b: &&StressRow| a.wrong_percent().total_cmp(&b.wrong_percent());
    if let Some(row) = single().filter(weighs).min_by(fewest) {
        findings.push(Finding {
            about: "Fewest wrong answers in f32, with weights".into(),
            says: view.title(&row.method),
            how: format!(
                "{} % of {} hard pairs are off by more than a thousandth{}",
                number(row.wrong_percent()),
                grouped(row.pairs),
                against_baseline(single(), |row| Some(row.wrong_percent()), "%"),
            ),
        });
    }
    let worst = |row: &StressRow| row.error_over_condition;
    let bounded = single().filter_map(|row| Some((row, worst(row)?)));
    if let Some((row, error)) = bounded.min_by(|a, b| a.1.total_cmp(&b.1)) {
        findings.push(Finding {
            about: "Smallest error over κ·u in f32".into(),
            says: view.title(&row.method),
            how: format!(
                "t is never off by more than {} condition numbers times the unit roundoff{}",
                number(error),
                against_baseline(single(), worst, "")
            ),
        });
    }
    let tight: Vec<String> = single()
        .filter(|row| {
            [row.edge_cracks, row.vertex_cracks, row.far_cracks].iter().all(|c| *c == Some(0.0))
        })
        .map(|row| view.title(&row.method))
        .collect();
    findings.push(Finding {
        about: "No cracks in f32".into(),
        says: if tight.is_empty() { "no method".into() } else { tight.join(", ") },
        how: format!(
            "rays per million aimed at edges that pass through closed surfaces{}",
            against_baseline(single(), |row| row.edge_cracks, "")
        ),
    });
    findings.push(Finding {
        about: "The contract".into(),
        says: format!("{} violations", grouped(summary.contract_violations)),
        how: format!(
            "in {} tests of hostile input over all kernels",
            scientific(summary.contract_tests as f64)
        ),
    });
    findings
}

/// "; Möller–Trumbore: 3 %"
fn against_baseline<'a>(
    mut rows: impl Iterator<Item = &'a StressRow>,
    of: impl Fn(&StressRow) -> Option<f64>,
    unit: &str,
) -> String {
    let value = rows.find(|row| row.method == BASELINE).and_then(of);
    let space = if unit.is_empty() { "" } else { " " };
    value.map_or_else(String::new, |x| format!("; Möller–Trumbore: {}{space}{unit}", number(x)))
}
