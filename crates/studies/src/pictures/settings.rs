//! What the study of pictures can be asked for.

use clap::Args;
use trisect_catalog::Entry;

use crate::input::methods;
use crate::study::{StudyError, threads};

/// Study how fast pictures of the mirror scene are: sizes and levels; threads, samples, lights, depth,
/// leaves and tiles; and what a tree, SIMD, threads and the kernel gain over a plain tracer.
///
/// Prints tables, and adds the page pictures.html, with a picture of every feature, and the record
/// pictures.jsonl to a report.
#[derive(Debug, Args)]
pub struct Settings {
    /// Methods that the fastest kernel is sought among, separated by commas; all if left out
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Seed of the order of samples
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Fewer samples, and no pictures of more than 600 rows
    #[arg(long)]
    pub quick: bool,
    /// Also time the scene and the settings of Morozov's tables of 2011: twenty minutes more
    #[arg(long)]
    pub morozov: bool,
    /// Divide the sides of all pictures, for a trial
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub shrink: u32,
    /// Threads, at most; all processors if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

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
    /// Whether Morozov's tables are timed as well.
    pub morozov: bool,
    /// The height of the largest pictures, 1080 for all.
    pub largest: u32,
    /// What the sides of all pictures are divided by, at least 1.
    pub shrink: u32,
}

impl Pictures {
    /// A size as it is asked for.
    pub(super) fn size(&self, full: [u32; 2]) -> [u32; 2] {
        full.map(|side| (side / self.shrink).max(1))
    }
}

impl Settings {
    pub(super) fn plan(&self) -> Result<Pictures, StudyError> {
        Ok(Pictures {
            seed: self.seed,
            methods: methods(&self.methods)?,
            rounds: if self.quick { 3 } else { 7 },
            threads: threads(self.threads),
            morozov: self.morozov,
            largest: if self.quick { 600 } else { u32::MAX },
            shrink: self.shrink,
        })
    }
}
