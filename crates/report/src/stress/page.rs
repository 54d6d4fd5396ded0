//! The page of the stability study.

use std::path::Path;

use serde::Serialize;
use trisect_harness::record::{Header, Records};

use super::figures;
use super::markdown::{self, Table};
use super::summary::{StressRow, StressSummary, of_view};
use crate::format::{grouped, number, scientific};
use crate::page::{
    Drawn, FigureOnPage, INDEX_PAGE, Page, PageError, STRESS_PAGE, render, style, write,
};
use crate::view::{BASELINE, View};

/// Draws the page of the stability study and its figures into a folder, beside the page of a
/// comparison where there is one: it leads there, and that page leads here when it is drawn again.
///
/// # Errors
/// As [`write_page`](crate::write_page).
pub fn write_stress_page(records: &Records, folder: &Path) -> Result<Page, PageError> {
    let view = View::new(records);
    let has_index = folder.join(INDEX_PAGE).exists();
    let drawn =
        Drawn::of(&view, figures::all(&view), |on_page| fill_in(&view, on_page, has_index))?;
    write(folder, STRESS_PAGE, &drawn)
}

#[derive(Serialize)]
struct Context<'a> {
    style: String,
    header: &'a Header,
    ghz: String,
    index: Option<&'static str>,
    findings: Vec<Finding>,
    figures: Vec<FigureOnPage>,
    tables: Vec<Titled>,
}

/// A table with what stands above it.
#[derive(Serialize)]
struct Titled {
    id: &'static str,
    title: &'static str,
    says: &'static str,
    table: Table,
}

/// One of the answers at the head of the page.
#[derive(Serialize)]
struct Finding {
    about: String,
    says: String,
    how: String,
}

fn fill_in(
    view: &View,
    figures: Vec<FigureOnPage>,
    has_index: bool,
) -> Result<String, minijinja::Error> {
    let table = |id, title, says, table| Titled { id, title, says, table };
    let tables = vec![
        table("f32", "All methods in f32", markdown::METHODS, markdown::methods(view, "f32")),
        table("f64", "All methods in f64", markdown::METHODS, markdown::methods(view, "f64")),
        table(
            "watertight",
            "Watertight methods",
            "Rays aimed at the edges and corners of closed surfaces, in plain arithmetic and the \
             deferred form.",
            markdown::watertight(view),
        ),
        table(
            "first",
            "First failures in f32",
            "The levels that the map above shows as squares; a dot never fails.",
            markdown::first_failures(view, "f32"),
        ),
        table(
            "limits",
            "Limits",
            "Within these all probes are right to a thousandth, found by bisection: sizes of the \
             scene with a direction of length 1, lengths of the direction, and the distance and \
             the offset over the triangle's size. Plain arithmetic.",
            markdown::limits(view),
        ),
        table(
            "contract",
            "The contract",
            "Hostile input, random bits among it, to every kernel of every method; what the \
             clauses say is in docs/CONTRACT.md.",
            markdown::contract(view),
        ),
        table("special", "Special values", markdown::SPECIAL, markdown::special_values(view)),
        table(
            "arithmetic",
            "Flushing and fusing",
            markdown::ARITHMETIC,
            markdown::arithmetic(view),
        ),
    ];
    let context = Context {
        style: style(),
        header: view.header,
        ghz: number(view.header.machine.core_ghz),
        index: has_index.then_some(INDEX_PAGE),
        findings: findings(view, &of_view(view)),
        figures,
        tables,
    };
    render("stress.html", context)
}

fn findings(view: &View, summary: &StressSummary) -> Vec<Finding> {
    let single = || summary.rows.iter().filter(|row| row.precision == "f32");
    let mut findings = Vec::new();
    // Of a method without weights fewer numbers can be wrong.
    let weighs = |row: &&StressRow| {
        let fact = view.fact(&row.method);
        fact.is_some_and(|fact| fact.outputs.iter().any(|output| output == "barycentrics"))
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
