//! The study of the tracer: what a method, a builder or a thread is worth where rays are traced.

mod document;
pub(crate) mod measure;
mod race;
pub(crate) mod rays;
pub(crate) mod record;
mod settings;
pub(crate) mod together;

use std::fmt::Display;

use trisect_report::document::Document;

use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};

pub use document::{StudyRow, StudySummary, study_summary};
pub use rays::{ClassOfRays, classes_of_rays};
pub use record::{Contest, Traced, TreeBuilt, TreeChecked};
pub use settings::{Settings, Tracer};

impl Study for Tracer {
    const ABOUT: About = About {
        name: "study",
        page: "study.html",
        record: "study.jsonl",
        title: "In a ray tracer",
        says: "what every method is worth where rays are traced",
        lines: record::LINES,
    };
    type Settings = Settings;

    fn plan(settings: &Settings, say: &dyn Fn(&dyn Display)) -> Result<Self, StudyError> {
        settings.plan(say)
    }

    type Summary = StudySummary;

    fn document(records: &Records) -> Document {
        document::document(records)
    }

    fn summary(records: &Records) -> StudySummary {
        study_summary(records)
    }

    fn seed_and_rounds(&self) -> (u64, usize) {
        (self.seed, self.rounds)
    }

    fn measure(self, run: &mut Run<'_>) -> Result<(), StudyError> {
        measure::measure(&self, run)
    }
}
