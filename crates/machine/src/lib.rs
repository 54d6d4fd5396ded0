#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod facts;
pub mod forms;
pub mod noise;

use serde::{Deserialize, Serialize};
use trisect_core::InstructionSet;

/// The machine a record was made on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's own name.
    pub cpu: String,
    /// How many logical processors the process may use.
    pub logical_cpus: usize,
    /// Instruction sets that kernels may use here, weakest first.
    pub instruction_sets: Vec<InstructionSet>,
    /// Operating system and architecture.
    pub platform: String,
    /// The compiler and its version.
    pub compiler: String,
    /// Compiler flags, profile and target of the build.
    pub build: String,
    /// Frequency of the core while measuring, in GHz: median over the rounds of a chain of
    /// dependent operations of known latency. Cycles are derived from it.
    pub core_ghz: f64,
}
