//! The stability study: what every method does in stiff and extreme cases.

mod contract;
mod cracks;
mod document;
mod exact;
mod limits;
mod measure;
mod pairs;
mod record;
mod settings;

use std::fmt::Display;

use trisect_report::document::Document;

use crate::comparison::measure::compare;
use crate::comparison::tasks::timing;
use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};

pub use document::{
    ExactnessRow, ExactnessSummary, StressRow, StressSummary, exactness_summary, stress_summary,
};
pub use record::{
    Bin, ByCondition, Clause, Contract, Errors, ExactCounts, Exactness, FusedDifference, Limits,
    Outcome, Site, SpecialValues, Spread, Stages, StressFamily, StressLevel, SurfaceCracks,
};
pub use settings::{Settings, Stability};

impl Study for Stability {
    const ABOUT: About = About {
        name: "stress",
        page: "stress.html",
        record: "stress.jsonl",
        title: "Stiff and extreme cases",
        says: "what every method does when it gets hard",
        lines: record::LINES,
    };
    type Settings = Settings;

    fn plan(settings: &Settings, _say: &dyn Fn(&dyn Display)) -> Result<Self, StudyError> {
        settings.plan()
    }

    type Summary = StressSummary;

    fn document(records: &Records) -> Document {
        document::document(records)
    }

    fn summary(records: &Records) -> StressSummary {
        stress_summary(records)
    }

    fn seed_and_rounds(&self) -> (u64, usize) {
        (self.seed, self.rounds)
    }

    fn measure(self, run: &mut Run<'_>) -> Result<(), StudyError> {
        if self.rounds > 0 {
            compare(&self.methods, (self.seed, self.rounds), [timing(self.seed)], run)?;
        }
        if self.pairs > 0 {
            measure::hard_pairs(&self, run);
            exact::stages(&self, run);
        }
        if self.probes > 0 {
            limits::limits(&self, run);
        }
        if self.crack_rays > 0 {
            cracks::cracks(&self, run);
        }
        if self.fuzz > 0 {
            contract::contract(&self, run);
        }
        if self.exact > 0 {
            exact::exactness(&self, run);
        }
        Ok(())
    }
}
