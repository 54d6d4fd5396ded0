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

use trisect_catalog::Entry;
use trisect_report::document::Document;

use crate::comparison::{compare, timing};
use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};

pub use document::{
    ExactnessRow, ExactnessSummary, StressRow, StressSummary, exactness_summary, stress_summary,
};
pub use record::{
    Bin, ByCondition, Clause, Contract, Errors, ExactCounts, Exactness, FusedDifference, Limits,
    Outcome, Site, SpecialValues, Spread, Stages, StressFamily, StressLevel, SurfaceCracks,
};
pub use settings::Settings;

/// How much is studied; a part with nothing to do is left out.
pub struct Stability {
    /// Seed of everything.
    pub seed: u64,
    /// The methods.
    pub methods: Vec<&'static Entry>,
    /// Samples of each kernel; without any, none is timed.
    pub rounds: usize,
    /// Pairs at each level of each family.
    pub pairs: usize,
    /// Pairs that must be right within the limits.
    pub probes: usize,
    /// Rays at each place of each closed surface, aimed at edges, and again at vertices.
    pub crack_rays: usize,
    /// The same in all for a form that claims to be watertight, at the offsets 0, 10³ and 10⁶.
    pub watertight_rays: usize,
    /// Tests of random bits and of other hostile input, over all methods and kernels.
    pub fuzz: u64,
    /// Tests of the methods that claim to be exact, against the oracle.
    pub exact: u64,
}

impl Stability {
    /// Nothing, to be filled in.
    pub fn nothing(seed: u64, methods: Vec<&'static Entry>) -> Self {
        Self {
            seed,
            methods,
            rounds: 0,
            pairs: 0,
            probes: 0,
            crack_rays: 0,
            watertight_rays: 0,
            fuzz: 0,
            exact: 0,
        }
    }
}

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
            run.lines.extend(measure::hard_pairs(&self, run.progress));
            run.lines.extend(exact::stages(&self, run.progress));
        }
        if self.probes > 0 {
            run.lines.extend(limits::limits(&self, run.progress));
        }
        if self.crack_rays > 0 {
            run.lines.extend(cracks::cracks(&self, run.progress));
        }
        if self.fuzz > 0 {
            run.lines.extend(contract::contract(&self, run.progress));
        }
        if self.exact > 0 {
            run.lines.extend(exact::exactness(&self, run.progress));
        }
        Ok(())
    }
}
