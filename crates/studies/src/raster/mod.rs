//! The study of the rasteriser: when it beats casting, and what exact agreement costs it.

mod check;
mod crossing;
mod document;
mod measure;
mod record;
mod settings;
mod subjects;

use std::fmt::Display;

use trisect_report::document::Document;

use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};

pub use check::{CheckSummary, Checked, check};
pub use crossing::Crossing;
pub use document::{RasterSummary, TimedWay};
pub use record::{Built, Seen, Series};
pub use settings::{Raster, Settings};
pub use subjects::{objects, staged};

impl Study for Raster {
    const ABOUT: About = About {
        name: "raster",
        page: "raster.html",
        record: "raster.jsonl",
        title: "The rasteriser",
        says: "when it beats casting, and what exact agreement costs",
        lines: record::LINES,
    };
    type Settings = Settings;

    fn plan(settings: &Settings, _say: &dyn Fn(&dyn Display)) -> Result<Self, StudyError> {
        Ok(settings.plan())
    }

    fn seed_and_rounds(&self) -> (u64, usize) {
        (self.seed, self.rounds)
    }

    fn measure(self, run: &mut Run<'_>) -> Result<(), StudyError> {
        measure::measure(&self, run)
    }

    fn document(records: &Records) -> Document {
        document::document(records)
    }

    type Summary = RasterSummary;

    fn summary(records: &Records) -> RasterSummary {
        document::summary(records)
    }
}
