//! The comparison: error against run time of every method on ordinary rays.

pub(crate) mod document;
pub(crate) mod measure;
pub(crate) mod record;
pub(crate) mod settings;
pub(crate) mod tasks;

use std::fmt::Display;

use rand::SeedableRng as _;
use rand_pcg::Pcg64;
use trisect_report::document::Document;

use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};
use crate::tracer::together::{both_classes, together};

pub use document::{
    Answer, Answers, ComparedVariant, ErrorDifference, Filter, FrontPoint, Ranked, Ranking,
    RecordComparison, Speed, Summary, compare_records, rank, summary,
};
pub use measure::compare;
pub use record::{
    Agreement, ClassCount, Cracks, Decisions, Error, Family, MethodCount, MethodFacts, PartCost,
    Preparation, Quantiles, Refusal, Throughput, Workload,
};
pub use settings::{Comparison, Settings};
pub use tasks::{Task, Timed, verification};

/// Rounds in which trees go in turn, at least: rays are timed in a fraction of the time of the kernels.
const TREE_ROUNDS: usize = 9;

impl Study for Comparison {
    const ABOUT: About = About {
        name: "comparison",
        page: "index.html",
        record: "record.jsonl",
        title: "The comparison",
        says: "error against run time on ordinary rays",
        lines: record::LINES,
    };
    type Settings = Settings;

    fn plan(settings: &Settings, say: &dyn Fn(&dyn Display)) -> Result<Self, StudyError> {
        settings.plan(say)
    }

    type Summary = Summary;

    fn document(records: &Records) -> Document {
        document::document(records)
    }

    fn summary(records: &Records) -> Summary {
        summary(records)
    }

    fn seed_and_rounds(&self) -> (u64, usize) {
        (self.seed, self.rounds)
    }

    fn measure(self, run: &mut Run<'_>) -> Result<(), StudyError> {
        let meshes = self.meshes.clone();
        let tasks = tasks::comparison(self.seed, self.full, self.meshes);
        compare(&self.methods, (self.seed, self.rounds), tasks, run)?;
        for mesh in &meshes {
            let Some(part) = run.claim() else { continue };
            run.begin(part);
            let mut random = Pcg64::seed_from_u64(self.seed);
            let classes = both_classes(mesh, None, self.seed);
            let turns = (TREE_ROUNDS.max(self.rounds), &mut random);
            together(&self.methods, mesh, &classes, turns, run)?;
        }
        Ok(())
    }
}
