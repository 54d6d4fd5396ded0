//! The study of pictures: how fast they are, what each technique gains, and one of every feature.

mod document;
mod measure;
pub(crate) mod morozov;
mod record;
mod settings;

use std::fmt::Display;

use trisect_report::document::Document;

use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};

pub use document::{PictureSummary, Technique, TimedFrame, picture_summary};
pub use record::{FrameSeries, Frames, Picture};
pub use settings::{Pictures, Settings};

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
