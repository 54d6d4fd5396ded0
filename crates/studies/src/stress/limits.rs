//! How small, how large, how far: where a method begins to be wrong, by bisection.

use std::collections::HashMap;

use rayon::prelude::*;
use trisect_catalog::{Entry, Finder};
use trisect_core::MultiplyAdd;
use trisect_workloads::Stress;

use super::measure::{Compiled, finders, weighs};
use super::pairs::TruePair;
use super::record::Limits;
use super::settings::Stability;
use crate::record::Line;
use crate::study::Run;

/// Levels this near to each other are one: limits have three digits.
const NEAR: f64 = 1.0 + 1.0 / 1024.0;

/// How far levels are apart on the way out.
const STRIDE: f64 = 8.0;

/// What is turned until a method fails.
const KNOBS: [Stress; 4] =
    [Stress::Scale, Stress::DirectionLength, Stress::FarOrigin, Stress::FarMesh];

/// The limits of every method, precision and division, in plain arithmetic.
pub(super) fn limits(settings: &Stability, run: &mut Run<'_>) {
    run.progress.phase("stress: looking for limits", 2);
    of_precision::<f32>(settings, run);
    run.progress.step();
    of_precision::<f64>(settings, run);
    run.progress.step();
}

fn of_precision<E: Compiled>(settings: &Stability, run: &mut Run<'_>) {
    let mine: Vec<(usize, &Entry)> =
        settings.methods.iter().filter_map(|entry| Some((run.claim()?, *entry))).collect();
    let found: Vec<(usize, Vec<Line>)> =
        mine.into_par_iter().map(|(part, entry)| (part, of_method::<E>(settings, entry))).collect();
    for (part, lines) in found {
        run.begin(part);
        run.lines.extend(lines);
    }
}

fn of_method<E: Compiled>(settings: &Stability, entry: &Entry) -> Vec<Line> {
    let mut probes =
        Probes::<E> { seed: settings.seed, count: settings.probes, known: HashMap::new() };
    let plain = finders(E::kernels(entry))
        .into_iter()
        .filter(|finder| finder.variant.arithmetic == MultiplyAdd::Plain);
    plain
        .flat_map(|finder| {
            KNOBS.map(|knob| probes.limits(entry, finder, knob)).into_iter().flatten()
        })
        .collect()
}

/// The pairs at a level, with what is true of them; kept, as the forms of a method ask alike.
struct Probes<E> {
    seed: u64,
    count: usize,
    known: HashMap<(Stress, u64), Vec<TruePair<E>>>,
}

impl<E: Compiled> Probes<E> {
    /// The levels between which all pairs are right; none where they are not at 1.
    fn limits(&mut self, entry: &Entry, finder: &Finder, knob: Stress) -> Option<Line> {
        let mut is_right = |level: f64| self.is_right(entry, finder, knob, level);
        if !is_right(1.0) {
            return None;
        }
        // The ends of the precision's range.
        let end = E::largest_t().to_f64();
        let smallest = border(1.0 / end, &mut is_right);
        let largest = border(end, &mut is_right);
        Some(Line::from(Limits {
            variant: finder.variant.clone(),
            family: knob.name().to_owned(),
            smallest,
            largest,
        }))
    }

    fn is_right(&mut self, entry: &Entry, finder: &Finder, knob: Stress, level: f64) -> bool {
        let (seed, count) = (self.seed, self.count);
        let pairs = self.known.entry((knob, level.to_bits())).or_insert_with(|| {
            knob.pairs::<E>(seed, level, count).into_iter().map(TruePair::new).collect()
        });
        pairs.iter().all(|pair| {
            let mut right = true;
            pair.ask(E::kernels(entry), &[finder], |_, answer| {
                right = !pair.is_wrong(answer, weighs(entry));
            });
            right
        })
    }
}

/// The last level that is right on the way from 1 to `end`: in strides until one is wrong, then by
/// halving the ratio. `end` itself where everything is right up to there.
///
/// Strides, because beyond the first level that is wrong there may be others that are right: far off
/// every triangle rounds to a point, and nothing is there to be hit.
fn border(end: f64, mut is_right: impl FnMut(f64) -> bool) -> f64 {
    let stride = if end > 1.0 { STRIDE } else { 1.0 / STRIDE };
    let is_within = |level: f64| if end > 1.0 { level < end } else { level > end };
    let mut good = 1.0;
    let mut bad = stride;
    while is_within(bad) && is_right(bad) {
        (good, bad) = (bad, bad * stride);
    }
    if !is_within(bad) {
        bad = end;
        if is_right(end) {
            return end;
        }
    }
    while (good / bad).max(bad / good) > NEAR {
        // The product may overflow; its factors' roots do not.
        let middle = good.sqrt() * bad.sqrt();
        if is_right(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_is_found_on_either_side() {
        for border_at in [1e-300, 3e-12, 0.5, 7.0, 1e250] {
            let found = if border_at > 1.0 {
                // What lies far beyond is right again.
                border(1e300, |x| x <= border_at || x > border_at * 1e9)
            } else {
                border(1e-305, |x| x >= border_at || x < border_at * 1e-9)
            };
            let off = (found / border_at).max(border_at / found);
            assert!(off <= NEAR, "{found} instead of {border_at}");
        }
        assert_eq!(border(1e30, |_| true), 1e30);
    }
}
