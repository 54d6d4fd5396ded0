//! What a variant answers on a subject, and how far that is from the truth.

use std::ops::ControlFlow;

use trisect_catalog::{Finder, Scene};
use trisect_core::{Hit, Vec3};
use trisect_method::{Culling, Output};
use trisect_oracle::Condition;

use crate::comparison::record::{ClassCount, Quantiles};
use crate::subject::{Judged, Truth};
use crate::timing::Expected;

/// One pair that hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    pub ray: u32,
    pub triangle: u32,
    pub hit: Hit<f64>,
}

impl Pair {
    fn key(&self) -> (u32, u32) {
        (self.ray, self.triangle)
    }
}

/// Every pair that a variant calls a hit, by ray, then triangle.
pub(crate) struct Answers {
    pairs: Vec<Pair>,
}

/// One of the numbers of a hit.
pub(crate) type Quantity = fn(&Hit<f64>) -> f64;

/// What is compared, of a hit.
pub(crate) const QUANTITIES: [(&str, Quantity); 3] =
    [("t", |hit| hit.t), ("beta", |hit| hit.beta), ("gamma", |hit| hit.gamma)];

/// How far rounding can move one of them.
pub(crate) type ConditionOf = fn(&Condition) -> f64;

/// The same of each that is compared.
pub(crate) const CONDITIONS: [ConditionOf; 3] = [|of| of.t, |of| of.beta, |of| of.gamma];

impl Answers {
    pub(crate) fn of(finder: &Finder, scene: &Scene) -> Self {
        let mut pairs = Vec::new();
        finder.find(scene, Culling::None, &mut |ray, triangle, hit| {
            let ray = u32::try_from(ray).expect("a subject has fewer than 2^32 rays");
            pairs.push(Pair { ray, triangle, hit });
            ControlFlow::Continue(())
        });
        pairs.sort_unstable_by_key(Pair::key);
        Self { pairs }
    }

    pub(crate) fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// What a timed kernel of the same variant must return that is asked for `asked`: the hits, and
    /// the sum of what [`Needs::fold`](trisect_method::Needs::fold) makes of each.
    pub(crate) fn expected(&self, asked: Output, unit_roundoff: f64, of: &dyn Judged) -> Expected {
        let hits = self.pairs.len() as u64;
        let (mut sum, mut magnitude) = (0.0, 0.0);
        let mut add = |terms: &[f64], size: f64| {
            sum += terms.iter().sum::<f64>();
            magnitude += size;
        };
        let size = |v: Vec3<f64>| v.map(f64::abs).sum();
        for Pair { ray, triangle, hit } in &self.pairs {
            match asked {
                Output::Occlusion => {}
                Output::T => add(&[hit.t], hit.t.abs()),
                Output::Barycentrics => {
                    let terms = [hit.t, hit.beta, hit.gamma];
                    add(&terms, terms.map(f64::abs).iter().sum());
                }
                Output::Point => {
                    let ray = of.ray(*ray);
                    add(&ray.at(hit.t).to_array(), size(ray.o) + size(ray.d) * hit.t.abs());
                }
                Output::Normal => {
                    let triangle = of.triangle(*triangle);
                    let (e1, e2) = (triangle.b - triangle.a, triangle.c - triangle.a);
                    // Corners round before edges do, and edges before their products.
                    let reach = size(triangle.a) + size(e1) + size(e2);
                    let n = triangle.normal();
                    let size = 8.0 * reach * (size(e1) + size(e2)) + hit.t.abs();
                    add(&[hit.t, n.sum()], size);
                }
            }
        }
        // Up to five roundings per hit, and one addition into the sum, in whatever order.
        let slack = (hits + 8) as f64 * unit_roundoff * magnitude;
        Expected { hits, sum, slack }
    }

    /// Errors over the pairs that both call a hit: relative, and in units in the last place of a
    /// precision with that many bits. Pairs whose reference is exactly 0 have no relative error
    /// and are left out unless the answer is 0 as well.
    pub(crate) fn errors(
        &self,
        reference: &[Pair],
        quantity: Quantity,
        significant_bits: i32,
    ) -> (u64, Quantiles, Quantiles) {
        let mut relative = Vec::new();
        let mut ulps = Vec::new();
        for (pair, reference) in shared(&self.pairs, reference) {
            let (x, exact) = (quantity(&pair.hit), quantity(&reference.hit));
            let error = (x - exact).abs();
            if error == 0.0 {
                relative.push(0.0);
                ulps.push(0.0);
            } else if exact != 0.0 {
                // Beyond the largest number there is nothing left to tell apart, and JSON has no
                // infinity.
                relative.push((error / exact.abs()).min(f64::MAX));
                ulps.push((error / unit_in_last_place(exact, significant_bits)).min(f64::MAX));
            }
        }
        let count = relative.len() as u64;
        (count, quantiles(relative), quantiles(ulps))
    }

    /// Errors over the condition number times the unit roundoff, over the pairs that both call a hit: a method
    /// whose errors are small here errs no more than the pair allows.
    pub(crate) fn over_condition(
        &self,
        truth: &[Truth],
        (quantity, condition): (Quantity, ConditionOf),
        unit_roundoff: f64,
    ) -> Quantiles {
        let errors = self.pairs.iter().filter_map(|pair| {
            let place = truth.binary_search_by_key(&pair.key(), |t| (t.ray, t.triangle)).ok()?;
            let error = (quantity(&pair.hit) - quantity(&truth[place].hit)).abs();
            let unit = condition(&truth[place].condition) * unit_roundoff;
            Some(if error == 0.0 { 0.0 } else { (error / unit).min(f64::MAX) })
        });
        quantiles(errors.collect())
    }

    /// The confusion table against the oracle.
    pub(crate) fn decisions(&self, of: &dyn Judged) -> Vec<ClassCount> {
        let mut called_hit = vec![0_u64; trisect_oracle::Class::ALL.len()];
        for pair in &self.pairs {
            called_hit[of.class(pair.ray, pair.triangle) as usize] += 1;
        }
        trisect_oracle::Class::ALL
            .iter()
            .zip(&of.known().class_counts)
            .zip(called_hit)
            .map(|((class, &all), called_hit)| ClassCount {
                class: class.name().to_owned(),
                is_hit: class.is_hit(),
                called_hit,
                called_miss: all - called_hit,
            })
            .filter(|row| row.called_hit + row.called_miss > 0)
            .collect()
    }

    /// Of that many rays those without a hit, and those with more than one.
    pub(crate) fn none_and_many(&self, rays: usize) -> (usize, usize) {
        let mut hits = vec![0_u32; rays];
        for pair in &self.pairs {
            hits[pair.ray as usize] += 1;
        }
        let count = |of: fn(u32) -> bool| hits.iter().filter(|&&n| of(n)).count();
        (count(|n| n == 0), count(|n| n > 1))
    }

    /// The closest triangle of each ray: smallest `t`, then lowest number.
    pub(crate) fn closest(&self, rays: usize) -> Vec<Option<u32>> {
        let mut closest: Vec<Option<&Pair>> = vec![None; rays];
        for pair in &self.pairs {
            let best = &mut closest[pair.ray as usize];
            // Pairs come by number, so a tie keeps the lower one.
            if best.is_none_or(|best| pair.hit.t < best.hit.t) {
                *best = Some(pair);
            }
        }
        closest.into_iter().map(|pair| pair.map(|pair| pair.triangle)).collect()
    }
}

impl From<&Truth> for Pair {
    fn from(truth: &Truth) -> Self {
        Self { ray: truth.ray, triangle: truth.triangle, hit: truth.hit }
    }
}

/// The pairs that two lists sorted by key share.
pub(crate) fn shared<'a>(
    a: &'a [Pair],
    b: &'a [Pair],
) -> impl Iterator<Item = (&'a Pair, &'a Pair)> {
    let mut b = b.iter().peekable();
    a.iter().filter_map(move |pair| {
        while b.next_if(|other| other.key() < pair.key()).is_some() {}
        b.next_if(|other| other.key() == pair.key()).map(|other| (pair, other))
    })
}

/// The distance between neighbouring numbers of that many bits at `x ≠ 0`, above the subnormals.
pub(crate) fn unit_in_last_place(x: f64, significant_bits: i32) -> f64 {
    // The biased exponent of an f64; subnormals do not come up in answers of order one.
    let exponent = i32::try_from((x.to_bits() >> 52) & 0x7ff).expect("eleven bits") - 1023;
    2.0_f64.powi(exponent + 1 - significant_bits)
}

pub(crate) fn quantiles(mut values: Vec<f64>) -> Quantiles {
    if values.is_empty() {
        return Quantiles::default();
    }
    values.sort_unstable_by(f64::total_cmp);
    // Nearest rank: the smallest value that at least this share does not exceed.
    let rank = |percent: usize| values[(values.len() * percent).div_ceil(100).max(1) - 1];
    Quantiles {
        mean: (values.iter().sum::<f64>() / values.len() as f64).min(f64::MAX),
        median: rank(50),
        p99: rank(99),
        max: rank(100),
    }
}

#[cfg(test)]
mod tests {
    use trisect_oracle::Class;

    use super::*;

    fn pair(ray: u32, triangle: u32, t: f64) -> Pair {
        Pair { ray, triangle, hit: Hit { t, beta: 0.25, gamma: 0.5 } }
    }

    #[test]
    fn quantiles_are_nearest_ranks() {
        let values = (1..=200).rev().map(f64::from).collect();
        let q = quantiles(values);
        assert_eq!((q.mean, q.median, q.p99, q.max), (100.5, 100.0, 198.0, 200.0));
        assert_eq!(quantiles(vec![]), Quantiles::default());
        assert_eq!(quantiles(vec![3.0]).median, 3.0);
    }

    #[test]
    fn errors_are_over_shared_hits() {
        let answers = Answers { pairs: vec![pair(0, 1, 2.0), pair(0, 7, 1.0), pair(3, 0, 5.0)] };
        let truth = [pair(0, 1, 2.0), pair(0, 2, 9.0), pair(3, 0, 4.0), pair(4, 4, 1.0)];
        let (count, relative, ulps) = answers.errors(&truth, QUANTITIES[0].1, 24);
        assert_eq!(count, 2);
        assert_eq!(relative.max, 0.25);
        // The unit of f32 at 4 is 2^-21.
        assert_eq!(ulps.max, 2.0_f64.powi(21));
        assert_eq!(relative.median, 0.0);
    }

    #[test]
    fn errors_are_held_against_what_rounding_can_do() {
        let truth = |ray, condition| {
            let Pair { triangle, hit, .. } = pair(ray, 1, 2.0);
            let condition = Condition { t: condition, beta: 1.0, gamma: 1.0 };
            Truth { ray, triangle, class: Class::Interior, hit, condition }
        };
        let truth = [truth(0, 8.0), truth(1, 4.0), truth(3, 1.0)];
        let answers = Answers { pairs: vec![pair(0, 1, 4.0), pair(1, 1, 2.0), pair(2, 1, 9.0)] };
        let over = answers.over_condition(&truth, (QUANTITIES[0].1, CONDITIONS[0]), 0.125);
        // Off by 2 where a rounding can move t by 1; right; and never a hit.
        assert_eq!((over.max, over.median, over.mean), (2.0, 0.0, 1.0));
    }

    #[test]
    fn closest_prefers_the_lower_number_on_ties() {
        let answers = Answers { pairs: vec![pair(0, 3, 2.0), pair(0, 4, 1.0), pair(0, 9, 1.0)] };
        assert_eq!(answers.closest(2), [Some(4), None]);
    }

    #[test]
    fn units_in_the_last_place_match_the_float_types() {
        for x in [1.0_f32, 1.5, 2.0, 1e-20, 3e20, 0.999] {
            let ulp = f64::from(f32::from_bits(x.to_bits() + 1)) - f64::from(x);
            assert_eq!(unit_in_last_place(f64::from(x), 24), ulp, "{x}");
        }
    }
}
