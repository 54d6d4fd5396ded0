//! Whether kernels decide as exact arithmetic does, over all rays and the triangles that each may meet.

use std::collections::BTreeSet;

use rayon::prelude::*;
use serde::Serialize;
use trisect_catalog::{Builder, Entry, Kernels, Tree, Variant, find};
use trisect_core::{Float, FloatFormat, Precision, Ray, Scalar, Triangle};

use crate::answers::{Answers, Pair, shared};
use crate::kernels::REFERENCE;
use crate::subject::{Inputs, OfRay, ask};

/// Pairs of a ray and a triangle that are looked at, at most: a few seconds on one processor.
const PAIRS: usize = 1 << 22;

/// Decisions that are not those of exact arithmetic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Wrong {
    /// Pairs of a ray and a triangle that are called a hit and are none.
    pub false_hits: usize,
    /// Pairs that are called a miss and are a hit.
    pub false_misses: usize,
    /// Rays whose hits are all found and whose closest triangle is not the true one, though the two
    /// distances, rounded once, differ. None where only hits are asked for.
    pub wrong_closest: usize,
}

impl Wrong {
    /// All of them.
    pub fn total(&self) -> usize {
        self.false_hits + self.false_misses + self.wrong_closest
    }

    fn plus(self, other: Self) -> Self {
        Self {
            false_hits: self.false_hits + other.false_hits,
            false_misses: self.false_misses + other.false_misses,
            wrong_closest: self.wrong_closest + other.wrong_closest,
        }
    }

    /// Of answers against the truth, both by ray, then triangle. `rounded` is set where the closest
    /// triangle is asked for, and rounds to the precision of the answers.
    pub(super) fn of(answers: &[Pair], truth: &[Pair], rounded: Option<fn(f64) -> f64>) -> Self {
        let right = shared(answers, truth).count();
        let (false_hits, false_misses) = (answers.len() - right, truth.len() - right);
        let mut wrong = Self { false_hits, false_misses, wrong_closest: 0 };
        let Some(rounded) = rounded else { return wrong };
        let mut rest = truth;
        for found in answers.chunk_by(|a, b| a.ray == b.ray) {
            let begin = rest.partition_point(|pair| pair.ray < found[0].ray);
            let count = rest[begin..].partition_point(|pair| pair.ray == found[0].ray);
            let meant = &rest[begin..begin + count];
            rest = &rest[begin + count..];
            let is_same = found.len() == count
                && found.iter().zip(meant).all(|(a, b)| a.triangle == b.triangle);
            // Of equal ones the first.
            let first = |pairs: &[Pair]| {
                (0..pairs.len()).min_by(|&a, &b| pairs[a].hit.t.total_cmp(&pairs[b].hit.t))
            };
            if is_same
                && let (Some(chosen), Some(closest)) = (first(found), first(meant))
                && rounded(meant[chosen].hit.t) > rounded(meant[closest].hit.t)
            {
                wrong.wrong_closest += 1;
            }
        }
        wrong
    }
}

/// Rounds to f32.
fn to_f32(x: f64) -> f64 {
    f64::from(<f32 as Scalar>::from_f64(x))
}

/// How numbers of a precision are rounded.
pub(super) fn rounding(precision: FloatFormat) -> fn(f64) -> f64 {
    match precision {
        FloatFormat::F32 => to_f32,
        FloatFormat::F64 => |x| x,
    }
}

/// A ray with the triangles whose boxes it meets, in the order of their numbers, and the truth about
/// them, which names them by their places among these.
struct Way {
    ray: usize,
    triangles: Vec<u32>,
    single: Vec<Pair>,
    /// None where the numbers of both precisions are the same.
    double: Option<Vec<Pair>>,
}

/// All rays, or so many that the work is bounded, each with the triangles that it may meet.
pub(super) struct Ways<'a> {
    inputs: &'a Inputs,
    ways: Vec<Way>,
}

/// Kernels of a method that decide alike: on lanes of any width, in any arrangement.
#[derive(Clone, Copy)]
pub(super) struct Kind {
    pub entry: &'static Entry,
    /// On the widest lanes.
    pub variant: &'static Variant,
}

impl Kind {
    /// Whether a variant is of this kind.
    pub(super) fn has(&self, variant: &Variant) -> bool {
        self.variant.rounds_like(variant)
    }

    pub(super) fn is_single(&self) -> bool {
        self.variant.precision == FloatFormat::F32
    }
}

impl<'a> Ways<'a> {
    /// Seeks what each ray may meet, in a tree, and asks the oracle about it. `rays` are the numbers of the
    /// rays, in an order of choice: the last are left out where there is too much to do.
    pub(super) fn new(inputs: &'a Inputs, rays: &[usize]) -> Self {
        let reference = find(REFERENCE).expect("it is in the catalogue");
        let tree = reference.tree(&inputs.triangles, Builder::Binned);
        let tree = tree.expect("the reference takes every mesh");
        let mut ways = Vec::new();
        let mut pairs = 0;
        for some in rays.chunks(64) {
            let found: Vec<Way> =
                some.par_iter().map(|&ray| Way::new(inputs, &*tree, ray)).collect();
            pairs += found.iter().map(|way| way.triangles.len()).sum::<usize>();
            ways.extend(found);
            if pairs > PAIRS {
                break;
            }
        }
        Self { inputs, ways }
    }

    /// Rays, and pairs of a ray and a triangle.
    pub(super) fn counts(&self) -> [usize; 2] {
        [self.ways.len(), self.ways.iter().map(|way| way.triangles.len()).sum()]
    }

    /// What kernels decide wrongly, and the places of the rays on which any does.
    pub(super) fn wrong(
        &self,
        kinds: &[Kind],
        asks_closest: bool,
        among: Option<&BTreeSet<usize>>,
    ) -> (Vec<Wrong>, BTreeSet<usize>) {
        let none = || (vec![Wrong::default(); kinds.len()], BTreeSet::new());
        let places = (0..self.ways.len()).filter(|place| among.is_none_or(|a| a.contains(place)));
        let places: Vec<usize> = places.collect();
        places
            .into_par_iter()
            .fold(none, |(mut sums, mut hard), place| {
                let wrong = self.ways[place].wrong(self.inputs, kinds, asks_closest);
                if wrong.iter().any(|wrong| wrong.total() > 0) {
                    hard.insert(place);
                }
                sums.iter_mut().zip(wrong).for_each(|(sum, wrong)| *sum = sum.plus(wrong));
                (sums, hard)
            })
            .reduce(none, |(a, mut hard), (b, more)| {
                hard.extend(more);
                (a.into_iter().zip(b).map(|(a, b)| a.plus(b)).collect(), hard)
            })
    }
}

impl Way {
    fn new(inputs: &Inputs, tree: &dyn Tree, ray: usize) -> Self {
        let Inputs { rays, triangles, unrounded } = inputs;
        let mut met = Vec::new();
        tree.candidates(&rays[ray], &mut |triangle| {
            met.push(triangle);
            rays[ray].tmax
        });
        met.sort_unstable();
        met.dedup();
        let single = truth(&rays[ray], &met, triangles);
        let double = unrounded.as_ref().map(|wide| truth(&wide.rays[ray], &met, &wide.triangles));
        Self { ray, triangles: met, single, double }
    }

    fn wrong(&self, inputs: &Inputs, kinds: &[Kind], asks_closest: bool) -> Vec<Wrong> {
        let single: Vec<Triangle<f32>> =
            self.triangles.iter().map(|&number| inputs.triangles[number as usize]).collect();
        let ray = inputs.rays[self.ray];
        let (wide_ray, double) = match &inputs.unrounded {
            None => (ray.into(), single.iter().map(|&triangle| triangle.into()).collect()),
            Some(wide) => {
                let of = |&number: &u32| wide.triangles[number as usize];
                (wide.rays[self.ray], self.triangles.iter().map(of).collect::<Vec<_>>())
            }
        };
        let wide_truth = self.double.as_ref().unwrap_or(&self.single);
        // All kinds of a method and precision lie beside each other and share their preparation.
        let is_alike =
            |a: &Kind, b: &Kind| std::ptr::eq(a.entry, b.entry) && a.is_single() == b.is_single();
        let mut all = Vec::with_capacity(kinds.len());
        for kinds in kinds.chunk_by(is_alike) {
            let entry = kinds[0].entry;
            all.extend(if kinds[0].is_single() {
                wrong(&entry.f32, kinds, asks_closest, (&ray, &single), &self.single)
            } else {
                wrong(&entry.f64, kinds, asks_closest, (&wide_ray, &double), wide_truth)
            });
        }
        all
    }
}

/// What kinds of one method and precision decide wrongly about one ray.
fn wrong<E: Precision>(
    kernels: &Kernels<E>,
    kinds: &[Kind],
    asks_closest: bool,
    (ray, triangles): (&Ray<E>, &[Triangle<E>]),
    truth: &[Pair],
) -> Vec<Wrong> {
    let Ok(scene) = (kernels.prepare)(triangles, std::slice::from_ref(ray)) else {
        // What takes the whole mesh takes its parts; one that does not decides nothing here.
        return vec![Wrong::default(); kinds.len()];
    };
    let of = |kind: &Kind| {
        let mut finders = kernels.finders.iter().chain(&kernels.deciders);
        let finder = finders.find(|finder| finder.variant == *kind.variant);
        let answers = finder.map(|finder| Answers::of(finder, &scene));
        let rounded = asks_closest.then(|| rounding(E::FORMAT));
        answers.map_or_else(Wrong::default, |found| Wrong::of(found.pairs(), truth, rounded))
    };
    kinds.iter().map(of).collect()
}

/// What is true of a ray, number 0, and those triangles, which are named by their places.
fn truth<E: Float>(ray: &Ray<E>, met: &[u32], triangles: &[Triangle<E>]) -> Vec<Pair>
where
    Ray<f64>: From<Ray<E>>,
    Triangle<f64>: From<Triangle<E>>,
{
    let met = (0..).zip(met.iter().map(|&number| &triangles[number as usize]));
    let OfRay { truth, .. } = ask(0, ray, met);
    truth.iter().map(Pair::from).collect()
}

#[cfg(test)]
mod tests {
    use trisect_core::Hit;

    use super::*;

    fn pair(ray: u32, triangle: u32, t: f64) -> Pair {
        Pair { ray, triangle, hit: Hit { t, beta: 0.25, gamma: 0.5 } }
    }

    #[test]
    fn wrong_decisions_are_counted_once() {
        let truth =
            [pair(0, 1, 2.0), pair(0, 3, 5.0), pair(1, 1, 1.0), pair(3, 0, 1.0), pair(3, 2, 2.0)];
        let answers =
            [pair(0, 1, 2.0), pair(0, 3, 5.0), pair(2, 1, 1.0), pair(3, 0, 3.0), pair(3, 2, 2.0)];
        let asked = |rounded| Wrong::of(&answers, &truth, rounded);
        // Ray 1 is missed, ray 2 hits what is not there, ray 3 finds the farther one first.
        assert_eq!(asked(Some(to_f32)), Wrong { false_hits: 1, false_misses: 1, wrong_closest: 1 });
        assert_eq!(asked(None), Wrong { false_hits: 1, false_misses: 1, wrong_closest: 0 });
        assert_eq!(Wrong::of(&truth, &truth, Some(|x| x)), Wrong::default());
    }

    /// Two distances that f32 has one number for.
    #[test]
    fn what_a_precision_cannot_tell_apart_is_not_wrong() {
        let near = 1.0 + f64::EPSILON;
        let truth = [pair(0, 0, near), pair(0, 1, 1.0)];
        let answers = [pair(0, 0, 1.0), pair(0, 1, 1.0)];
        assert_eq!(Wrong::of(&answers, &truth, Some(to_f32)).total(), 0);
        assert_eq!(Wrong::of(&answers, &truth, Some(|x| x)).wrong_closest, 1);
    }
}
