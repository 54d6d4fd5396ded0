//! What a comparison can be asked for.

use std::fmt::Display;

use clap::Args;
use trisect_catalog::Entry;
use trisect_mesh::Mesh;

use crate::input::{MOVE, Subjects, methods};
use crate::study::StudyError;

/// What is measured, and for how long.
#[derive(Debug, Args)]
pub struct Settings {
    #[command(flatten)]
    #[allow(missing_docs, reason = "a comment here would become the command's")]
    pub subjects: Subjects,
    /// More rays, triangles and rounds: quarter of an hour instead of two minutes
    #[arg(long)]
    pub full: bool,
    /// Samples of each variant [default: 5, or 15 with --full]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: Option<u32>,
}

/// A comparison, its input read.
pub struct Comparison {
    pub(super) seed: u64,
    pub(super) rounds: usize,
    pub(super) full: bool,
    pub(super) methods: Vec<&'static Entry>,
    pub(super) meshes: Vec<Mesh>,
}

impl Settings {
    pub(super) fn plan(&self, say: &dyn Fn(&dyn Display)) -> Result<Comparison, StudyError> {
        let usual = if self.full { 15 } else { 5 };
        Ok(Comparison {
            seed: self.subjects.seed,
            rounds: self.rounds.map_or(usual, |rounds| rounds as usize),
            full: self.full,
            methods: methods(&self.subjects.methods)?,
            meshes: self.subjects.meshes(|| vec![trisect_workloads::bunny()], MOVE, say)?,
        })
    }
}
