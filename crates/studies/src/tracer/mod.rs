//! The study of the tracer: what a method, a builder or a thread is worth where rays are traced.

mod document;
mod measure;
mod race;
mod rays;
mod record;
mod settings;
mod together;

use std::fmt::Display;

use trisect_catalog::Entry;
use trisect_report::document::Document;
use trisect_workloads::Mesh;

use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};

pub use document::{StudyRow, StudySummary, study_summary};
pub use rays::{ClassOfRays, classes_of_rays};
pub use record::{Contest, Traced, TreeBuilt, TreeChecked};
pub use settings::Settings;

pub(crate) use measure::thread_counts;
pub(crate) use together::{both_classes, together};

/// What is studied, and how long.
pub struct Tracer {
    /// Seed of rays and of the order of samples.
    pub seed: u64,
    /// The methods.
    pub methods: Vec<&'static Entry>,
    /// The scenes.
    pub scenes: Vec<Mesh>,
    /// Side, in pixels, of the picture whose rays meet a scene.
    pub pixels: usize,
    /// Samples of everything that is timed.
    pub rounds: usize,
    /// Threads, at most.
    pub threads: usize,
}

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
