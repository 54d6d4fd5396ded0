//! Kernels that are asked for a hit with all its values, against those that say whether there is one.

use trisect_catalog::{Arrangement, Entry, Kernel};
use trisect_core::{Float as _, Output};

use super::{Study, Subject, in_turn};
use crate::measure::{Group, contenders};
use crate::record::{Family, Layer, Omission};
use crate::subject;
use crate::timing::{Contender, WrongAnswer};

/// What whoever asks no more than whether there is a hit does without: `t`, barycentrics, and the division.
const VALUES: &str = "values";

impl Study<'_> {
    /// Every method, in each form of the division: one ray at a time, on the widest fused lanes of f32.
    pub(super) fn kernels(&mut self) -> Result<Vec<Omission>, WrongAnswer> {
        let (seed, tests) = (self.settings.seed, self.settings.tests);
        self.progress.phase("kernels", self.settings.methods.len() as u64);
        let workload = trisect_workloads::random(seed, tests, tests);
        let subject = subject::Subject::new(
            workload.name,
            workload.description,
            Family::Random,
            workload.rays,
            workload.triangles.to_vec(),
        );
        let mut found = Vec::new();
        for entry in &self.settings.methods {
            let scene = (entry.f32.prepare)(&subject.triangles32, &subject.rays32);
            if let Ok(scene) = scene {
                let group = Group::new(entry, &entry.f32, scene, usual(entry));
                let mut racing = contenders(std::slice::from_ref(&group), &subject);
                while let Some((_, whole)) = racing.pop() {
                    let kernel = whole.kernel;
                    let is_other = |kernel: &Kernel, other: &Kernel| {
                        other.variant == kernel.variant && other.needs != kernel.needs
                    };
                    let other = racing.iter().position(|(_, other)| is_other(kernel, other.kernel));
                    let Some(other) = other else { continue };
                    let (_, other) = racing.swap_remove(other);
                    let (with, without) = match kernel.needs {
                        Output::Occlusion => (other, whole),
                        _ => (whole, other),
                    };
                    let raced = in_turn(
                        &Subject {
                            layer: Layer::Kernel,
                            scene: &subject.workload.name,
                            of: kernel.variant.division,
                            method: entry.info.name,
                        },
                        without,
                        vec![(VALUES, with)],
                        self.settings.rounds,
                        &mut self.random,
                        Contender::run,
                    )?;
                    found.extend(raced.omissions);
                }
            }
            self.progress.step();
        }
        Ok(found)
    }
}

/// The kernels of a method that are compared: of each form the one asked for least, and for most.
fn usual(entry: &'static Entry) -> Vec<&'static Kernel> {
    let here = || {
        entry.f32.timed.iter().filter(|kernel| {
            let lane = kernel.variant.lane;
            lane.instruction_set.is_available()
                && lane.precision == f32::NAME
                && lane.arithmetic == "fused"
                && kernel.variant.reciprocal == "true"
                && kernel.arrangement == Arrangement::OneRay
                && !kernel.early_out
        })
    };
    let widest = here().map(|kernel| kernel.variant.lane.width).max();
    let fullest =
        if entry.info.gives(Output::Barycentrics) { Output::Barycentrics } else { Output::T };
    here()
        .filter(|kernel| Some(kernel.variant.lane.width) == widest)
        .filter(|kernel| kernel.needs == Output::Occlusion || kernel.needs == fullest)
        .collect()
}
