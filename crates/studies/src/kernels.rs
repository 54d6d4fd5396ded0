//! Kernels of one method on one scene: their answers, and what is timed of them.

use trisect_catalog::{Entry, Finder, Kernel, Kernels, Scene, Variant, find};
use trisect_core::Precision;

use crate::answers::Answers;
use crate::noise::Spent;
use crate::subject::Subject;
use crate::timing::{Contender, Expected};

/// The method that all are compared with, and, in f64, the reference of the error tables.
pub const REFERENCE: &str = "moller-trumbore";

/// The method that all are compared with.
pub(crate) fn reference() -> &'static Entry {
    find(REFERENCE).expect("it is in the catalogue")
}

/// The answers of each of some finders that computes values of its own here: plain arithmetic gives the
/// same bits on every width, and so does fused, so that the widest stands for all.
pub(crate) fn answers_of_widest<'a>(
    finders: &'a [Finder],
    scene: &Scene,
) -> Vec<(&'a Variant, Answers)> {
    let here = || finders.iter().filter(|finder| finder.variant.is_available());
    let widest = here().map(|finder| finder.variant.width).max();
    here()
        .filter(|finder| Some(finder.variant.width) == widest)
        .map(|finder| (&finder.variant, Answers::of(finder, scene)))
        .collect()
}

/// A method in one precision, prepared for timing.
pub(crate) struct Group {
    pub bytes_per_triangle: usize,
    unit_roundoff: f64,
    scene: Scene,
    timed: Vec<&'static Kernel>,
    answers: Vec<(&'static Variant, Answers)>,
}

/// Each kernel of some groups, ready to be timed, with its group.
pub(crate) fn contenders<'a>(
    groups: &'a [Group],
    subject: &Subject,
) -> Vec<(&'a Group, Contender<'a>)> {
    let of_group = |group: &'a Group| {
        group.timed.iter().map(move |&kernel| (group, group.contender(kernel, subject)))
    };
    groups.iter().flat_map(of_group).collect()
}

impl Group {
    /// The answers of kernels on a scene, those whose arrangement serves its rays.
    pub(crate) fn new<E: Precision>(
        entry: &Entry,
        kernels: &'static Kernels<E>,
        scene: Scene,
        mut timed: Vec<&'static Kernel>,
    ) -> Self {
        timed.retain(|kernel| kernel.variant.arrangement.serves(scene.common()));
        let mut answers: Vec<(&'static Variant, Answers)> = Vec::new();
        for kernel in &timed {
            let finder = kernels.finder_of(kernel);
            if !answers.iter().any(|&(variant, _)| *variant == finder.variant) {
                answers.push((&finder.variant, Answers::of(finder, &scene)));
            }
        }
        Self {
            bytes_per_triangle: entry.cost.stored_numbers * size_of::<E>(),
            unit_roundoff: E::UNIT_ROUNDOFF,
            scene,
            timed,
            answers,
        }
    }

    /// Its kernels, those that serve its rays.
    pub(crate) fn kernels(&self) -> impl Iterator<Item = &'static Kernel> + '_ {
        self.timed.iter().copied()
    }

    /// A kernel of it, ready to be timed.
    pub(crate) fn contender(&self, kernel: &'static Kernel, subject: &Subject) -> Contender<'_> {
        Contender {
            kernel,
            scene: &self.scene,
            expected: self.expected(kernel, subject),
            samples_ns: Vec::new(),
            spent: Spent::default(),
            tally: None,
        }
    }

    fn expected(&self, kernel: &Kernel, subject: &Subject) -> Expected {
        let (_, answers) = kernel
            .variant
            .answered_by(self.answers.iter(), |(variant, _)| variant)
            .expect("every timed variant has a finder");
        let of = subject.of(kernel.variant.precision);
        answers.expected(kernel.variant.needs, self.unit_roundoff, of)
    }
}
