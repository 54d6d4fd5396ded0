//! The lines of `trisect-by-hand`: forms of one test beside each other, which the catalogue does not compile, what they
//! decide on borders, and what leaves and calls cost.

use std::fmt;

use serde::{Deserialize, Serialize};
use trisect_core::{InstructionSet, MultiplyAdd, named};
use trisect_kernels::Arrangement;
use trisect_method::ReciprocalKind;

/// The name of such a record's study in its header.
pub const STUDY: &str = "forms";

named! {
    /// When a test divides, and in what order it decides.
    pub enum TestForm {
        /// It divides first, and tests `t` before the weights.
        Early = "early",
        /// It divides for hits alone, and tests the weights first.
        Deferred = "deferred",
        /// It divides for hits alone, and tests `t` first.
        TFirst = "deferred, t first",
        /// It divides for hits alone, and tests the signs of numerators; `t` comes first.
        Signs = "signs, t first",
    }
}

/// One form of a method's test.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FormVariant {
    /// Name of the method in the catalogue.
    pub method: String,
    /// Lanes of f32; 1 is the scalar.
    pub width: usize,
    /// The instructions that it is compiled for.
    pub instruction_set: InstructionSet,
    /// How `a·b + c` is rounded.
    pub arithmetic: MultiplyAdd,
    /// What the lanes hold.
    pub arrangement: Arrangement,
    /// The form.
    pub form: TestForm,
    /// How it divides.
    pub reciprocal: ReciprocalKind,
    /// Whether a test ends as soon as no lane can hit.
    pub early_out: bool,
}

/// The time of a form on a workload.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FormTime {
    /// The form.
    #[serde(flatten)]
    pub variant: FormVariant,
    /// The settings of the compiler, in words; empty where they are the project's.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub compiler: String,
    /// Name of the workload.
    pub workload: String,
    /// Ray–triangle tests in one sample.
    pub tests: u64,
    /// Those of them that hit, the same in every sample.
    pub hits: u64,
    /// Nanoseconds of each sample, in the order measured: those of one place were taken in the same round.
    pub samples_ns: Vec<u64>,
}

impl fmt::Display for FormTime {
    /// As `wald 8 avx2 one-ray early exits random`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FormVariant { method, width, instruction_set, arrangement, form, .. } = &self.variant;
        let exits = if self.variant.early_out { "exits" } else { "no exits" };
        let workload = &self.workload;
        write!(f, "{method} {width} {instruction_set} {arrangement} {form} {exits} {workload}")
    }
}

/// The decisions of a form, one number at a time in f32, against the oracle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Border {
    /// Name of the method in the catalogue.
    pub method: String,
    /// The form.
    pub form: TestForm,
    /// What was decided: pairs of a family of the stability study at its hardest, or a surface whose edges or corners
    /// are aimed at.
    pub set: String,
    /// Ray–triangle pairs.
    pub pairs: u64,
    /// Hits that are none.
    pub false_hits: u64,
    /// Hits that were missed.
    pub false_misses: u64,
    /// Rays from inside a closed surface; 0 where there is no surface.
    pub rays: u64,
    /// Those of them that hit nothing.
    pub escaped: u64,
}

/// The time of a plain binary tree whose leaves are of one size.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeafTime {
    /// Triangles of a leaf, at most; 0 where there is no tree, and no box either.
    pub leaf: usize,
    /// Leaves.
    pub leaves: usize,
    /// Triangles.
    pub triangles: usize,
    /// Rays of one sample.
    pub rays: u64,
    /// Those of them that hit, the same in every sample.
    pub hits: u64,
    /// Ray–triangle tests of one sample.
    pub tests: u64,
    /// Nanoseconds of each sample.
    pub samples_ns: Vec<u64>,
}

named! {
    /// What is called through a pointer that the compiler cannot see through.
    pub enum Called {
        /// Nothing: the test is compiled into the loop.
        Nothing = "nothing",
        /// The loop over an array of triangles.
        Array = "array",
        /// The test of a block of triangles.
        Block = "block",
        /// Each test.
        Test = "test",
    }
}

/// The time of a loop over an array of triangles, with calls or without.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CallTime {
    /// What is called.
    pub called: Called,
    /// Lanes of f32; 1 is the scalar.
    pub width: usize,
    /// Triangles of the array.
    pub triangles: usize,
    /// Ray–triangle tests in one sample.
    pub tests: u64,
    /// Those of them that hit, the same in every sample.
    pub hits: u64,
    /// Nanoseconds of each sample.
    pub samples_ns: Vec<u64>,
}
