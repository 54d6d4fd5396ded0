//! Every method on every family of hard pairs; and which finders and variants stand for a method.

use rayon::prelude::*;
use trisect_catalog::{Entry, Finder, Kernels};
use trisect_core::{Float, FloatFormat, MultiplyAdd, Precision};
use trisect_method::{Form, Output, ReciprocalKind};
use trisect_workloads::Stress;

use super::pairs::{self, TruePair, difference, score};
use super::record::Spread;
use super::settings::Stability;
use crate::answers::quantiles;
use crate::record::{Line, Variant};
use crate::study::Run;

/// A precision that the catalogue compiles kernels in.
pub(super) trait Compiled: Precision {
    /// A method's kernels in it.
    fn kernels(entry: &Entry) -> &Kernels<Self>;
}

impl Compiled for f32 {
    fn kernels(entry: &Entry) -> &Kernels<Self> {
        &entry.f32
    }
}

impl Compiled for f64 {
    fn kernels(entry: &Entry) -> &Kernels<Self> {
        &entry.f64
    }
}

/// The finders that compute values of their own: plain arithmetic gives the same bits on every
/// width, and so does fused, so that the widest of each stands for all.
pub(super) fn finders<E: Precision>(kernels: &Kernels<E>) -> Vec<&Finder> {
    let here: Vec<&Finder> = kernels
        .finders
        .iter()
        .filter(|f| f.variant.is_available() && f.variant.reciprocal == ReciprocalKind::True)
        .collect();
    let widest = |finder: &&Finder| {
        let like = |other: &&&Finder| other.variant.arithmetic == finder.variant.arithmetic;
        let width = here.iter().filter(like).map(|other| other.variant.width).max();
        width == Some(finder.variant.width)
    };
    here.iter().copied().filter(widest).collect()
}

/// The variant that a test in flushing arithmetic stands for.
pub(super) fn flushing_variant(entry: &Entry, division: Form) -> Variant {
    let scalar = entry.f32.finders.iter().find(|finder| finder.variant.width == 1);
    let scalar = scalar.expect("scalars are compiled for every processor");
    Variant { division, ..scalar.variant.clone() }
}

/// Whether a method gives barycentrics.
pub(super) fn weighs(entry: &Entry) -> bool {
    entry.info.gives(Output::Barycentrics)
}

/// Median and largest, to three digits.
pub(super) fn spread(values: Vec<f64>) -> Spread {
    let q = quantiles(values);
    Spread(three_digits(q.median), three_digits(q.max))
}

/// The number with three digits, which are all that matter of an error and a quarter of the bytes;
/// what is beyond f32 is its largest number, as JSON has no infinity.
fn three_digits(x: f64) -> f32 {
    format!("{x:.2e}").parse().map_or(f32::MAX, |x: f32| x.min(f32::MAX))
}

/// The pairs of one level with what is true of them.
pub(super) struct Set<E: Float> {
    pub(super) family: Stress,
    pub(super) level: f64,
    pub(super) pairs: Vec<TruePair<E>>,
}

fn sets<E: Float>(settings: &Stability) -> Vec<Set<E>> {
    let levels: Vec<(Stress, f64)> = Stress::ALL
        .into_iter()
        .flat_map(|family| family.levels::<E>().into_iter().map(move |level| (family, level)))
        .collect();
    levels
        .into_par_iter()
        .map(|(family, level)| {
            let pairs = family.pairs::<E>(settings.seed, level, settings.pairs);
            Set { family, level, pairs: pairs.into_iter().map(TruePair::new).collect() }
        })
        .collect()
}

/// Every method on every family of pairs.
pub(super) fn hard_pairs(settings: &Stability, run: &mut Run<'_>) {
    run.progress.phase("stress: asking the oracle", 2);
    let single = sets::<f32>(settings);
    run.progress.step();
    let double = sets::<f64>(settings);
    run.progress.step();
    // The same numbers in double precision: how far a wider type carries.
    let widened: Vec<Set<f64>> = single.iter().map(Set::widened).collect();

    run.each("stress: pairs", settings.methods.iter(), |entry| {
        let mut lines = family_records(entry, &single, FloatFormat::F32, true);
        lines.extend(family_records(entry, &double, FloatFormat::F64, true));
        lines.extend(family_records(entry, &widened, FloatFormat::F32, false));
        lines.extend(pairs::flushing(entry, &single));
        lines
    });
}

impl Set<f32> {
    fn widened(&self) -> Set<f64> {
        let Self { family, level, pairs } = self;
        Set { family: *family, level: *level, pairs: pairs.iter().map(TruePair::widened).collect() }
    }
}

/// What one method does on every set, level by level if asked for, and against the condition number.
fn family_records<E: Compiled>(
    entry: &Entry,
    sets: &[Set<E>],
    inputs: FloatFormat,
    by_level: bool,
) -> Vec<Line> {
    let kernels = E::kernels(entry);
    let finders = finders(kernels);
    // Of each set, per finder, what each pair got.
    let answers: Vec<Vec<Vec<pairs::Answer>>> = sets
        .par_iter()
        .map(|set| {
            let mut answers = vec![Vec::with_capacity(set.pairs.len()); finders.len()];
            for pair in &set.pairs {
                pair.ask(kernels, &finders, |finder, answer| answers[finder].push(answer));
            }
            answers
        })
        .collect();
    let mut lines = Vec::new();
    for (number, finder) in finders.iter().enumerate() {
        let named = &finder.variant;
        let asked = || sets.iter().zip(answers.iter().map(|of_set| &of_set[number][..]));
        if named.arithmetic == MultiplyAdd::Plain {
            if by_level {
                lines.extend(score(named, weighs(entry), asked(), inputs, false));
            }
        } else {
            let is_twin = |other: &&Finder| {
                other.variant.arithmetic == MultiplyAdd::Plain
                    && other.variant.division == named.division
            };
            let twin = finders.iter().position(is_twin);
            let twin = twin.expect("what is compiled fused is compiled plain as well");
            let plain = answers.iter().map(|of_set| &of_set[twin][..]);
            lines.push(difference(named.clone(), weighs(entry), asked().zip(plain), inputs));
        }
        lines.extend(pairs::by_condition(named, weighs(entry), asked(), inputs));
    }
    lines
}
