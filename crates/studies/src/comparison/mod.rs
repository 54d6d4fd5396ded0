//! The comparison: error against run time of every method on ordinary rays.

pub(crate) mod document;
mod measure;
pub(crate) mod record;
mod settings;
mod tasks;

use std::fmt::Display;

use trisect_catalog::Entry;
use trisect_mesh::Mesh;
use trisect_report::document::Document;

use crate::record::Records;
use crate::study::{About, Run, Study, StudyError};

pub use document::{
    ComparedVariant, ErrorDifference, Filter, FrontPoint, MethodRow, PrecisionRow, Ranked, Ranking,
    RecordComparison, Summary, Winner, compare_records, rank, summary,
};
pub use measure::compare;
pub use record::{
    Agreement, ClassCount, Cracks, Decisions, Error, Family, MethodCount, MethodFacts, PartCost,
    Preparation, Quantiles, Refusal, Throughput, Workload,
};
pub use settings::Settings;
pub use tasks::{Task, inputs, inputs_of, usual_rays, verification};

pub(crate) use tasks::timing;

/// A comparison, its input read.
pub struct Comparison {
    seed: u64,
    rounds: usize,
    full: bool,
    methods: Vec<&'static Entry>,
    meshes: Vec<Mesh>,
}

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
        let tasks = tasks::comparison(self.seed, self.full, self.meshes);
        Ok(compare(&self.methods, (self.seed, self.rounds), tasks, run)?)
    }
}
