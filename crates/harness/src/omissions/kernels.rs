//! Kernels that are asked for a hit with all its values, against those that say whether there is one; and
//! those of twice the precision.

use trisect_catalog::{Arrangement, Entry, Kernel, Kernels};
use trisect_core::{Output, Precision, Ray, Triangle, UnsuitableMesh};

use super::{Study, Subject, in_turn};
use crate::measure::Group;
use crate::record::{Family, Layer, Omission};
use crate::subject::{self, Inputs};
use crate::timing::{Contender, WrongAnswer};

/// What whoever asks no more than whether there is a hit does without: `t`, barycentrics, and the division.
const VALUES: &str = "values";

/// What whoever does with single precision does without.
const PRECISION: &str = "f64";

/// The forms of the division, first the one that a tracer takes where a method has both.
const FORMS: [&str; 2] = ["deferred", "early"];

impl Study<'_> {
    /// Every method, in each form of the division: one ray at a time, on the widest fused lanes.
    pub(super) fn kernels(&mut self) -> Result<Vec<Omission>, WrongAnswer> {
        let (seed, tests) = (self.settings.seed, self.settings.tests);
        self.progress.phase("kernels", self.settings.methods.len() as u64);
        let workload = trisect_workloads::random(seed, tests, tests);
        let subject = subject::Subject::new(
            workload.name,
            workload.description,
            Family::Random,
            Inputs::new(workload.rays, workload.triangles.to_vec()),
        );
        let mut found = Vec::new();
        for entry in &self.settings.methods {
            if let (Ok(single), Ok(double)) = (
                group(entry, &entry.f32, &subject.single.triangles, &subject.single.rays),
                group(entry, &entry.f64, &subject.double.triangles, &subject.double.rays),
            ) {
                found.extend(self.of_method(entry, [&single, &double], &subject)?);
            }
            self.progress.step();
        }
        Ok(found)
    }

    /// A method's kernels in single and double precision.
    fn of_method<'a>(
        &mut self,
        entry: &Entry,
        [single, double]: [&'a Group; 2],
        subject: &subject::Subject,
    ) -> Result<Vec<Omission>, WrongAnswer> {
        let fullest = fullest(entry);
        let of = |group: &Group, form, needs| {
            group.kernels().find(|k| k.variant.division == form && k.needs == needs)
        };
        let values = FORMS.into_iter().filter_map(|form| {
            let of = |needs| Some(single.contender(of(single, form, needs)?, subject));
            Some((form, VALUES, of(Output::Occlusion)?, of(fullest)?))
        });
        // In one form: the other takes the same numbers.
        let precision = FORMS.into_iter().find_map(|form| {
            let of = |group: &'a Group| Some(group.contender(of(group, form, fullest)?, subject));
            Some((form, PRECISION, of(single)?, of(double)?))
        });
        let mut found = Vec::new();
        for (form, part, without, with) in values.chain(precision) {
            let raced = in_turn(
                &Subject {
                    layer: Layer::Kernel,
                    scene: &subject.workload.name,
                    of: form,
                    method: entry.info.name,
                },
                without,
                vec![(part, with)],
                self.settings.rounds,
                &mut self.random,
                Contender::run,
            )?;
            found.extend(raced.omissions);
        }
        Ok(found)
    }
}

/// The most that a method can be asked for by all callers alike.
fn fullest(entry: &Entry) -> Output {
    if entry.info.gives(Output::Barycentrics) { Output::Barycentrics } else { Output::T }
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
        kernels.timed.iter().filter(|kernel| {
            let lane = kernel.variant.lane;
            lane.instruction_set.is_available()
                && lane.precision == E::NAME
                && lane.arithmetic == "fused"
                && kernel.variant.reciprocal == "true"
                && kernel.arrangement == Arrangement::OneRay
                && !kernel.early_out
        })
    };
    let widest = here().map(|kernel| kernel.variant.lane.width).max();
    let asked = [Output::Occlusion, fullest(entry)];
    let usual: Vec<&'static Kernel> = here()
        .filter(|kernel| Some(kernel.variant.lane.width) == widest && asked.contains(&kernel.needs))
        .collect();
    Ok(Group::new(entry, kernels, (kernels.prepare)(triangles, rays)?, usual))
}
