//! Kernels that are asked for a hit with all its values, against those that say whether there is one; and
//! those of twice the precision.

use trisect_catalog::{Entry, Kernel, Kernels};
use trisect_core::{FloatFormat, MultiplyAdd, Precision, Ray, Triangle};
use trisect_kernels::Arrangement;
use trisect_method::{Forms, Output, ReciprocalKind, UnsuitableMesh};

use super::measure::{Leaving, Subject, in_turn};
use super::record::{Layer, Omission};
use crate::comparison::record::Family;
use crate::kernels::Group;
use crate::subject::{self, Inputs};
use crate::timing::WrongAnswer;

/// What whoever asks no more than whether there is a hit does without: `t`, barycentrics, and the division.
const VALUES: &str = "values";

/// What whoever does with single precision does without.
const PRECISION: FloatFormat = FloatFormat::F64;

impl Leaving<'_, '_> {
    /// Every method, in each form of the division: one ray at a time, on the widest fused lanes.
    pub(super) fn kernels(&mut self) -> Result<(), WrongAnswer> {
        let (seed, tests) = (self.study.seed, self.study.tests);
        self.run.progress.phase("kernels", self.study.methods.len() as u64);
        let workload = trisect_workloads::random(seed, tests, tests);
        let subject = subject::Subject::new(
            workload.name,
            workload.description,
            Family::Random,
            Inputs::new(workload.rays, workload.triangles.to_vec()),
        );
        for entry in &self.study.methods {
            if let (Ok(single), Ok(double)) = (
                group(entry, &entry.f32, &subject.single.triangles, &subject.single.rays),
                group(entry, &entry.f64, &subject.double.triangles, &subject.double.rays),
            ) {
                let found = self.of_method(entry, [&single, &double], &subject)?;
                self.found(found);
            }
            self.run.progress.step();
        }
        Ok(())
    }

    /// A method's kernels in single and double precision.
    fn of_method<'a>(
        &mut self,
        entry: &Entry,
        [single, double]: [&'a Group; 2],
        subject: &subject::Subject,
    ) -> Result<Vec<Omission>, WrongAnswer> {
        let fullest = entry.info.fullest();
        let of = |group: &Group, form, needs| {
            group.kernels().find(|k| k.variant.division == form && k.variant.needs == needs)
        };
        let values = Forms::Both.list().iter().copied().filter_map(|form| {
            let of = |needs| Some(single.contender(of(single, form, needs)?, subject));
            Some((form, VALUES, of(Output::Occlusion)?, of(fullest)?))
        });
        // In one form: the other takes the same numbers.
        let precision = Forms::Both.list().iter().copied().find_map(|form| {
            let of = |group: &'a Group| Some(group.contender(of(group, form, fullest)?, subject));
            Some((form, PRECISION.name(), of(single)?, of(double)?))
        });
        let mut found = Vec::new();
        for (form, part, without, with) in values.chain(precision) {
            let raced = in_turn(
                &Subject {
                    layer: Layer::Kernel,
                    scene: &subject.workload.name,
                    of: form.name(),
                    method: entry.info.name,
                },
                without,
                vec![(part, with)],
                self.study.rounds,
                &mut self.random,
                |contender| Ok(contender.run()?.wall),
            )?;
            found.extend(raced.omissions);
        }
        Ok(found)
    }
}

/// The kernels of a method that are compared, on triangles and rays: of each form the one asked for least,
/// and for most.
fn group<E: Precision>(
    entry: &Entry,
    kernels: &'static Kernels<E>,
    triangles: &[Triangle<E>],
    rays: &[Ray<E>],
) -> Result<Group, UnsuitableMesh> {
    let here = || {
        kernels.timed.iter().filter(|Kernel { variant, .. }| {
            variant.is_available()
                && variant.arithmetic == MultiplyAdd::Fused
                && variant.reciprocal == ReciprocalKind::True
                && variant.arrangement == Arrangement::OneRay
                && !variant.early_out
        })
    };
    let widest = here().map(|kernel| kernel.variant.width).max();
    let asked = [Output::Occlusion, entry.info.fullest()];
    let usual: Vec<&'static Kernel> = here()
        .filter(|Kernel { variant, .. }| {
            Some(variant.width) == widest && asked.contains(&variant.needs)
        })
        .collect();
    Ok(Group::new(entry, kernels, (kernels.prepare)(triangles, rays)?, usual))
}
