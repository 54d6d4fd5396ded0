//! The lines of the study of what is left out.

use serde::{Deserialize, Serialize};

use crate::record::lines;
use trisect_report::stats;

lines! {
    Omission = "omission",
    Code = "code",
}

/// Where something that nobody asks for is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layer {
    /// The test of rays against triangles.
    Kernel,
    /// The way of rays through a tree.
    Tracer,
    /// The renderer.
    Picture,
}

/// What it takes to keep what nobody asks for: the same work timed with it and without, in turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Omission {
    /// Where it is left out.
    pub layer: Layer,
    /// What is left out.
    pub part: String,
    /// Name of the scene, or of the workload.
    pub scene: String,
    /// What is done with it: the form of the division, the class of rays, what is asked of a picture.
    pub of: String,
    /// Name of the method in the catalogue.
    pub method: String,
    /// Nanoseconds of each sample without it, in the order measured.
    pub without_ns: Vec<u64>,
    /// Nanoseconds of each sample with it, in the same rounds.
    pub with_ns: Vec<u64>,
}

impl Omission {
    /// How many times as long it takes with it as without, of each round: the median, and the quartiles.
    /// `None` where nothing was timed.
    pub fn ratio(&self) -> Option<(f64, [f64; 2])> {
        let pairs = self.with_ns.iter().zip(&self.without_ns);
        let ratios: Vec<f64> =
            pairs.map(|(with, without)| *with as f64 / (*without).max(1) as f64).collect();
        let (low, high) = stats::quartiles(&ratios)?;
        Some((stats::median(&ratios)?, [low, high]))
    }
}

/// Code that is compiled once for each of several sets of needs, as the program holds it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Code {
    /// Of what.
    pub of: String,
    /// How often it is compiled.
    pub instances: usize,
    /// Bytes of machine code of all instances.
    pub bytes: u64,
    /// Bytes of machine code of the whole program.
    pub of_bytes: u64,
}
