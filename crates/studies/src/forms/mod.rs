//! The record of `trisect-by-hand`: forms of one test, which the catalogue does not compile, beside each other.

mod document;
mod morozov;
mod pairs;
mod record;

use trisect_machine::forms::STUDY;

use crate::study::{About, Chapter};

pub use pairs::{FormRatio, FormsSummary, forms_summary};

/// What is said of such a record.
pub(crate) const CHAPTER: Chapter = Chapter::of_program(
    About {
        name: STUDY,
        page: "forms.html",
        record: "forms.jsonl",
        title: "Forms of a test",
        says: "when to divide, what to test first, and what leaves and calls cost",
        lines: record::LINES,
    },
    document::document,
    |records, to| serde_json::to_writer(to, &forms_summary(records)),
);
