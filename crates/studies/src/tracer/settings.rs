//! What the study of the tracer can be asked for.

use std::fmt::Display;

use clap::Args;
use trisect_catalog::Entry;
use trisect_workloads::{Mesh, hall};

use crate::input::{MOVE, Subjects, method, methods};
use crate::kernels::REFERENCE;
use crate::study::{StudyError, threads};

/// Study what every method is worth in a ray tracer: rays of four classes through a tree, singly and in
/// packets, beside the speed of the kernels alone; builders, sizes of leaves, threads, lanes and calls.
///
/// Prints a table, and adds the page study.html and the record study.jsonl to a report.
#[derive(Debug, Args)]
#[command(mut_arg("methods", |methods| methods.help(
    "Methods, separated by commas, beside moller-trumbore, which always takes part; all if left out"
)))]
#[command(mut_arg("mesh", |mesh| mesh.help(
    "Mesh (PLY, OBJ, STL or glTF), any number of times; the Stanford bunny and a hall if left out"
)))]
pub struct Settings {
    #[command(flatten)]
    #[allow(missing_docs, reason = "a comment here would become the command's")]
    pub subjects: Subjects,
    /// Fewer rays and samples: two minutes for all methods instead of ten
    #[arg(long)]
    pub quick: bool,
    /// Threads, at most; all processors if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// What is studied, and how long.
pub struct Tracer {
    /// Seed of rays and of the order of samples.
    pub seed: u64,
    /// The methods.
    pub methods: Vec<&'static Entry>,
    /// The scenes.
    pub scenes: Vec<Mesh>,
    /// Side, in pixels, of the picture whose rays meet a scene.
    pub pixels: usize,
    /// Samples of everything that is timed.
    pub rounds: usize,
    /// Threads, at most.
    pub threads: usize,
}

impl Settings {
    pub(super) fn plan(&self, say: &dyn Fn(&dyn Display)) -> Result<Tracer, StudyError> {
        let mut methods = methods(&self.subjects.methods)?;
        if methods.iter().all(|entry| entry.info.name != REFERENCE) {
            methods.insert(0, method(REFERENCE)?);
        }
        Ok(Tracer {
            seed: self.subjects.seed,
            methods,
            scenes: self.subjects.meshes(|| vec![trisect_workloads::bunny(), hall()], MOVE, say)?,
            pixels: if self.quick { 160 } else { 384 },
            rounds: 5,
            threads: threads(self.threads),
        })
    }
}
