//! The study of pictures: how fast they are, what each technique gains, and one of every feature.

mod document;
mod measure;
mod record;
mod settings;

use std::fmt::Display;

use trisect_catalog::Entry;
use trisect_report::document::Document;

use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};

pub use document::{PictureSummary, Technique, TimedFrame, picture_summary};
pub use record::{FrameSeries, Frames, Picture};
pub use settings::Settings;

/// What is studied, and how long.
pub struct Pictures {
    /// Seed of the order of samples.
    pub seed: u64,
    /// The methods that the last technique, the choice of the kernel, is among.
    pub methods: Vec<&'static Entry>,
    /// Pictures of each kind that are timed.
    pub rounds: usize,
    /// Threads, at most.
    pub threads: usize,
    /// The height of the largest pictures, 1080 for all.
    pub largest: u32,
    /// What the sides of all pictures are divided by, at least 1.
    pub shrink: u32,
}

impl Pictures {
    /// A size as it is asked for.
    fn size(&self, full: [u32; 2]) -> [u32; 2] {
        full.map(|side| (side / self.shrink).max(1))
    }
}

impl Study for Pictures {
    const ABOUT: About = About {
        name: "pictures",
        page: "pictures.html",
        record: "pictures.jsonl",
        title: "Pictures",
        says: "scenes rendered, and what they cost",
        lines: record::LINES,
    };
    type Settings = Settings;

    fn plan(settings: &Settings, _say: &dyn Fn(&dyn Display)) -> Result<Self, StudyError> {
        settings.plan()
    }

    type Summary = PictureSummary;

    fn document(records: &Records) -> Document {
        document::document(records)
    }

    fn summary(records: &Records) -> PictureSummary {
        picture_summary(records)
    }

    fn seed_and_rounds(&self) -> (u64, usize) {
        (self.seed, self.rounds)
    }

    fn measure(self, run: &mut Run<'_>) -> Result<(), StudyError> {
        measure::measure(&self, run)
    }
}
