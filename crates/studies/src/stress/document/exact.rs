//! Methods that claim to be exact: what holding them to it found, and which of their stages decide.

use std::collections::BTreeMap;

use crate::record::Records;
use crate::stress::record::{ExactCounts, Exactness, Stages};
use serde::Serialize;
use trisect_core::FloatFormat;

use crate::lines::distinct;
use trisect_report::document::{Document, Section};
use trisect_report::format::grouped;
use trisect_report::table::Table;

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

/// Sums up what a record says of exactness.
pub fn exactness_summary(records: &Records) -> ExactnessSummary {
    let mut sums: BTreeMap<(&str, FloatFormat, &str), ExactCounts> = BTreeMap::new();
    let mut summary = ExactnessSummary { rows: Vec::new(), ways: 0, first_wrong: None };
    for Exactness { method, precision, way, kinds, first_wrong } in records.all::<Exactness>() {
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
    pub(super) fn sentence(&self) -> String {
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

    /// Every kind of scene with its counts.
    pub(super) fn table(&self) -> Table {
        Table::of(&self.rows)
            .name("scenes", |row| &row.kind)
            .text("precision", |row| row.precision.name())
            .count("tests", |row| row.counts.tests)
            .count("wrong", |row| row.counts.wrong)
            .count("values", |row| row.counts.wrong_values)
            .count("rays", |row| row.counts.rays)
            .count("wrong first", |row| row.counts.wrong_closest)
            .done()
    }

    /// As text of at most `width` columns, for 40 columns or more.
    pub fn to_text(&self, width: usize) -> String {
        let first = self.first_wrong.as_ref().map(|wrong| format!(" The first: {wrong}"));
        let says = self.sentence() + &first.unwrap_or_default();
        Document::text([Section::brief(self.table(), ""), Section::prose(says)], width)
    }
}

/// What the columns of [`ExactnessSummary::table`] mean.
pub(super) const EXACTNESS: &str = "Methods that claim to be exact against the oracle: tests of one ray \
    against one triangle, on every lane type in both arrangements, decisions and values that are wrong in \
    any bit; rays whose first triangle was asked for, of kernels and in the tree, singly, in packets and in \
    plain arithmetic, and those with another one than the true one.";

/// The share of pairs that each stage decides, in per cent, by method, precision and source.
pub(super) fn stages(all: &[&Stages]) -> Table {
    fn sum(stages: &Stages) -> u64 {
        stages.pairs.iter().sum()
    }
    let mut table = Table::of(all)
        .name("pairs of", |stages| &stages.source)
        .text("method", |stages| &stages.method)
        .text("precision", |stages| stages.precision.name())
        .count("pairs", |stages| sum(stages));
    for name in distinct(all.iter().flat_map(|stages| &stages.stages)) {
        table = table.number(
            name,
            |x| format!("{x:.3}"),
            |stages| {
                let mut decided = stages.stages.iter().zip(&stages.pairs);
                let (_, pairs) = decided.find(|(stage, _)| *stage == name)?;
                Some(*pairs as f64 * 100.0 / sum(stages).max(1) as f64)
            },
        );
    }
    table.done()
}

/// What the columns of [`stages`] mean.
pub(super) const STAGES: &str = "Which stage decides, in per cent of the pairs of a family, over all its \
    levels, or of a scene, every ray against every triangle. Each stage takes what the ones before leave \
    open.";
