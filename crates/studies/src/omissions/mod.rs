//! What is gained by leaving out what nobody asks for: in kernels, in the tracer, and in pictures.

mod code;
mod document;
mod explain;
mod kernels;
mod measure;
mod pictures;
mod record;
mod settings;
mod tracer;

use std::fmt::Display;

use trisect_report::document::Document;

use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};

pub use document::{OmissionKind, OmissionSummary, TimedOmission, omission_summary};
pub use explain::{ExplainedPart, Explanation, explain};
pub use record::{Code, Layer, Omission};
pub use settings::{Omissions, Settings};

impl Study for Omissions {
    const ABOUT: About = About {
        name: "omissions",
        page: "omissions.html",
        record: "omissions.jsonl",
        title: "What is left out",
        says: "what it would take to keep what nobody asks for",
        lines: record::LINES,
    };
    type Settings = Settings;

    fn plan(settings: &Settings, _say: &dyn Fn(&dyn Display)) -> Result<Self, StudyError> {
        settings.plan()
    }

    type Summary = OmissionSummary;

    fn document(records: &Records) -> Document {
        document::document(records)
    }

    fn summary(records: &Records) -> OmissionSummary {
        omission_summary(records)
    }

    fn seed_and_rounds(&self) -> (u64, usize) {
        (self.seed, self.rounds)
    }

    fn measure(self, run: &mut Run<'_>) -> Result<(), StudyError> {
        measure::measure(&self, run)
    }
}
