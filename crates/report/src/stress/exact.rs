//! Methods that claim to be exact: what holding them to it found, and which of their stages decide.

use std::collections::BTreeMap;

use serde::Serialize;
use trisect_core::FloatFormat;
use trisect_harness::record::{ExactCounts, Exactness, Record};

use crate::format::{grouped, or_dash};
use crate::markdown::Table;
use crate::text;
use crate::view::View;

/// What holding methods to exactness found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExactnessSummary {
    /// By method, precision and kind of scene, over all ways of testing.
    pub rows: Vec<ExactnessRow>,
    /// How many ways of testing: lanes in an arrangement, and ways through the tree.
    pub ways: usize,
    /// The first answer that was wrong.
    pub first_wrong: Option<String>,
}

/// Counts of one kind of scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExactnessRow {
    /// The method.
    pub method: String,
    /// `f32` or `f64`.
    pub precision: FloatFormat,
    /// The kind of scene.
    pub kind: String,
    /// What was tested, and what was wrong.
    #[serde(flatten)]
    pub counts: ExactCounts,
}

/// Sums up the records of exactness among others.
pub fn exactness_summary<'a>(records: impl IntoIterator<Item = &'a Record>) -> ExactnessSummary {
    let of = records.into_iter().filter_map(|record| match record {
        Record::Exactness(exactness) => Some(exactness),
        _ => None,
    });
    summed(of)
}

pub(super) fn summed<'a>(records: impl IntoIterator<Item = &'a Exactness>) -> ExactnessSummary {
    let mut sums: BTreeMap<(&str, FloatFormat, &str), ExactCounts> = BTreeMap::new();
    let mut summary = ExactnessSummary { rows: Vec::new(), ways: 0, first_wrong: None };
    for Exactness { method, precision, way, kinds, first_wrong } in records {
        summary.ways += 1;
        for (kind, counts) in kinds {
            sums.entry((method, *precision, kind)).or_default().add(counts);
        }
        if let (None, Some(wrong)) = (&summary.first_wrong, first_wrong) {
            summary.first_wrong = Some(format!("{method}, {way}: {wrong}"));
        }
    }
    let rows = sums.into_iter().map(|((method, precision, kind), counts)| ExactnessRow {
        method: method.to_owned(),
        precision,
        kind: kind.to_owned(),
        counts,
    });
    summary.rows = rows.collect();
    summary
}

impl ExactnessSummary {
    /// The sum of all rows.
    pub fn total(&self) -> ExactCounts {
        let mut total = ExactCounts::default();
        for row in &self.rows {
            total.add(&row.counts);
        }
        total
    }

    /// In a sentence.
    pub(crate) fn sentence(&self) -> String {
        let ExactCounts { tests, wrong, wrong_values, rays, wrong_closest } = self.total();
        format!(
            "{} tests in {} ways: {} wrong decisions, {} wrong values; of {} rays {} have a wrong first \
             triangle.",
            grouped(tests),
            self.ways,
            grouped(wrong),
            grouped(wrong_values),
            grouped(rays),
            grouped(wrong_closest)
        )
    }

    /// As text of at most `width` columns, for 40 columns or more.
    pub fn to_text(&self, width: usize) -> String {
        let mut table = text::Table::new(&HEAD);
        table.rows = self.rows.iter().map(cells).collect();
        let mut out = table.render(width);
        out.push('\n');
        out.push_str(&text::wrap(&self.sentence(), width, ""));
        if let Some(wrong) = &self.first_wrong {
            out.push_str(&text::wrap(&format!("The first: {wrong}"), width, "  "));
        }
        out
    }
}

const HEAD: [&str; 7] = ["scenes", "precision", "tests", "wrong", "values", "rays", "wrong first"];

fn cells(row: &ExactnessRow) -> Vec<String> {
    let ExactCounts { tests, wrong, wrong_values, rays, wrong_closest } = row.counts;
    let mut cells = vec![row.kind.clone(), row.precision.to_string()];
    cells.extend([tests, wrong, wrong_values, rays, wrong_closest].map(grouped));
    cells
}

/// Every kind of scene with its counts.
pub(crate) fn exactness(view: &View) -> Table {
    let mut table = Table::new(&HEAD);
    table.rows = summed(view.exactness.iter().copied()).rows.iter().map(cells).collect();
    table
}

/// What the columns of [`exactness`] mean.
pub(crate) const EXACTNESS: &str = "Methods that claim to be exact against the oracle: tests of one ray \
    against one triangle, on every lane type in both arrangements, decisions and values that are wrong in \
    any bit; rays whose first triangle was asked for, of kernels and in the tree, singly, in packets and in \
    plain arithmetic, and those with another one than the true one.";

/// The share of pairs that each stage decides, in per cent, by method, precision and source.
pub(crate) fn stages(view: &View) -> Table {
    let mut table = Table::new(&["pairs of", "method", "precision", "pairs"]);
    for stages in &view.stages {
        for name in &stages.stages {
            if !table.head.contains(name) {
                table.head.push(name.clone());
            }
        }
    }
    for stages in &view.stages {
        let all: u64 = stages.pairs.iter().sum();
        let mut row = vec![
            stages.source.clone(),
            stages.method.clone(),
            stages.precision.to_string(),
            grouped(all),
        ];
        row.extend(table.head[4..].iter().map(|name| {
            let mut decided = stages.stages.iter().zip(&stages.pairs);
            let share = decided
                .find(|(stage, _)| *stage == name)
                .map(|(_, pairs)| *pairs as f64 * 100.0 / all.max(1) as f64);
            or_dash(share, |x| format!("{x:.3}"))
        }));
        table.rows.push(row);
    }
    table
}

/// What the columns of [`stages`] mean.
pub(crate) const STAGES: &str = "Which stage decides, in per cent of the pairs of a family, over all its \
    levels, or of a scene, every ray against every triangle. Each stage takes what the ones before leave \
    open.";
