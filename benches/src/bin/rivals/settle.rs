//! Answers held against each other, and differences settled by the oracle.

use std::cmp::Ordering;

use rayon::prelude::*;
use serde::Serialize;
use trisect_core::{Ray, Triangle};
use trisect_oracle::{Oracle, Truth, compare_t};

use crate::contender::{Answers, Found};

/// Rays that are settled, at most: each is tested against every triangle.
const SETTLED: usize = 2000;

/// Rays whose answers are settled though all contenders agree, spread evenly.
const SAMPLED: usize = 200;

/// Two distances this close, relative to the larger, are the same to a float: a rounding of each
/// `t` in single precision, times what computing it costs.
const CLOSE: f64 = 1e-5;

/// What rounding explains, in units of the oracle's condition numbers: sixteen roundings to single
/// precision.
const ROUNDING: f64 = 16.0 * 0.5 * (f32::EPSILON as f64);

/// How far beside a triangle a ray may pass whose neighbour it hits at the same `t`, as a share of
/// the triangle: methods that are not backward stable err by more than [`ROUNDING`].
const BESIDE: f64 = 0.01;

/// What the oracle says to one contender's answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Verdict {
    /// The closest triangle, one exactly as close, or nothing where there is nothing.
    pub(crate) right: usize,
    /// A triangle that is hit, at the `t` of the closest one but for rounding.
    pub(crate) close: usize,
    /// A triangle that the ray passes by no more than rounding explains, or at the `t` of the
    /// closest one by less than a hundredth of it.
    pub(crate) beside: usize,
    /// Nothing was found, and there is something.
    pub(crate) missed: usize,
    /// Something was found where there is nothing, nor nearly.
    pub(crate) invented: usize,
    /// A triangle that is hit, but beyond the closest one.
    pub(crate) farther: usize,
    /// A triangle that is not hit, nor nearly, or that lies beyond the closest one.
    pub(crate) elsewhere: usize,
    /// The largest relative error of `t`, over the answers that name a triangle that is hit.
    pub(crate) largest_error_of_t: f64,
}

/// What was settled.
#[derive(Debug, Serialize)]
pub(crate) struct Settlement {
    /// Rays that not all contenders answer alike.
    pub(crate) differing: usize,
    /// Those of them that were settled, spread evenly.
    pub(crate) settled: usize,
    /// Rays that all answer alike and that were settled as well.
    pub(crate) sampled: usize,
    /// Of each contender, over all settled rays.
    pub(crate) verdicts: Vec<Verdict>,
    /// The first rays that somebody has wrong: number, and what each contender says.
    pub(crate) examples: Vec<Example>,
}

/// A ray that somebody has wrong.
#[derive(Debug, Serialize)]
pub(crate) struct Example {
    pub(crate) ray: usize,
    /// The closest triangle in truth.
    pub(crate) truth: Option<usize>,
    /// What each contender says.
    pub(crate) answers: Vec<Said>,
}

/// An answer in an example.
#[derive(Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum Said {
    /// Whether anything is hit.
    Any(bool),
    /// The number of the closest triangle.
    Closest(Option<u32>),
}

/// Rays that are named as examples, at most.
const EXAMPLES: usize = 5;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    Right,
    Close,
    Beside,
    Missed,
    Invented,
    Farther,
    Elsewhere,
}

/// A word, and the relative error of `t` where the triangle that is named is hit.
type Judged = (Word, Option<f64>);

/// Compares the contenders' answers ray by ray. Rays that are answered differently are settled, up
/// to a number, and some that are not.
pub(crate) fn settle(
    rays: &[Ray<f32>],
    triangles: &[Triangle<f32>],
    answers: &[Answers],
) -> Settlement {
    let differs = |at: &usize| {
        answers.windows(2).any(|pair| match (&pair[0], &pair[1]) {
            (Answers::Closest(a), Answers::Closest(b)) => {
                a[*at].map(|found| found.triangle) != b[*at].map(|found| found.triangle)
            }
            (Answers::Any(a), Answers::Any(b)) => a[*at] != b[*at],
            _ => true,
        })
    };
    let (differing, alike): (Vec<usize>, Vec<usize>) = (0..rays.len()).partition(differs);
    let sample = alike.iter().step_by(alike.len().div_ceil(SAMPLED).max(1));
    // Spread evenly as well: differences come in clusters.
    let some = differing.iter().step_by(differing.len().div_ceil(SETTLED).max(1));
    let settled = some.len();
    let chosen: Vec<usize> = some.chain(sample).copied().collect();
    let judged: Vec<(Option<usize>, Vec<Judged>)> =
        chosen.par_iter().map(|&at| judge(&rays[at], at, triangles, answers)).collect();
    let mut verdicts = vec![Verdict::default(); answers.len()];
    let mut examples = Vec::new();
    for (&at, (truth, judged)) in chosen.iter().zip(&judged) {
        for (&(word, error), verdict) in judged.iter().zip(&mut verdicts) {
            *verdict.of(word) += 1;
            verdict.largest_error_of_t = verdict.largest_error_of_t.max(error.unwrap_or(0.0));
        }
        let fine = |&(word, _): &Judged| matches!(word, Word::Right | Word::Close | Word::Beside);
        if !judged.iter().all(fine) && examples.len() < EXAMPLES {
            let answers = answers.iter().map(|answers| match answers {
                Answers::Closest(found) => Said::Closest(found[at].map(|found| found.triangle)),
                Answers::Any(found) => Said::Any(found[at]),
            });
            examples.push(Example { ray: at, truth: *truth, answers: answers.collect() });
        }
    }
    let (differing, sampled) = (differing.len(), chosen.len() - settled);
    Settlement { differing, settled, sampled, verdicts, examples }
}

impl Verdict {
    fn of(&mut self, word: Word) -> &mut usize {
        match word {
            Word::Right => &mut self.right,
            Word::Close => &mut self.close,
            Word::Beside => &mut self.beside,
            Word::Missed => &mut self.missed,
            Word::Invented => &mut self.invented,
            Word::Farther => &mut self.farther,
            Word::Elsewhere => &mut self.elsewhere,
        }
    }

    /// Answers that rounding does not explain, but for those that found nothing.
    pub(crate) fn wrong(&self) -> usize {
        self.invented + self.farther + self.elsewhere
    }
}

/// The closest triangle, and a word on what each contender says of one ray.
fn judge(
    ray: &Ray<f32>,
    at: usize,
    triangles: &[Triangle<f32>],
    answers: &[Answers],
) -> (Option<usize>, Vec<Judged>) {
    let mut oracle = Oracle::default();
    let truth = oracle.closest(ray, triangles).map(|(number, _)| number);
    // Asked of every triangle, so only where it is needed, and once.
    let mut passes_any_closely = None;
    let judged = answers.iter().map(|answers| match answers {
        Answers::Closest(found) => judge_closest(ray, triangles, truth, found[at]),
        Answers::Any(found) => {
            let word = match (found[at], truth) {
                (true, Some(_)) | (false, None) => Word::Right,
                (false, Some(_)) => Word::Missed,
                (true, None) => {
                    let closely = *passes_any_closely.get_or_insert_with(|| {
                        triangles.iter().any(|it| passes_closely(ray, &oracle.truth(ray, it), 0.0))
                    });
                    if closely { Word::Beside } else { Word::Invented }
                }
            };
            (word, None)
        }
    });
    (truth, judged.collect())
}

fn judge_closest(
    ray: &Ray<f32>,
    triangles: &[Triangle<f32>],
    truth: Option<usize>,
    found: Option<Found>,
) -> Judged {
    let Some(found) = found else {
        return (if truth.is_some() { Word::Missed } else { Word::Right }, None);
    };
    let mut oracle = Oracle::default();
    let closest = truth.map(|truth| (&triangles[truth], oracle.truth(ray, &triangles[truth])));
    let Some(named) = triangles.get(found.triangle as usize) else {
        return (if closest.is_some() { Word::Elsewhere } else { Word::Invented }, None);
    };
    let there = oracle.truth(ray, named);
    // Distances that the arithmetic of a contender need not tell apart.
    let is_level = |t: f64, other: &Truth| {
        let slack = ROUNDING * (there.condition.t + other.condition.t);
        (t - other.t).abs() <= slack.max(CLOSE * t.abs().max(other.t.abs()))
    };
    if !there.class.is_hit() {
        let word = match &closest {
            None if passes_closely(ray, &there, 0.0) => Word::Beside,
            None => Word::Invented,
            Some((_, truth))
                if is_level(there.t, truth) && passes_closely(ray, &there, BESIDE)
                    || there.t < truth.t && passes_closely(ray, &there, 0.0) =>
            {
                Word::Beside
            }
            Some(_) => Word::Elsewhere,
        };
        return (word, None);
    }
    let word = match &closest {
        // It is hit, so there is a closest one.
        None => Word::Invented,
        Some((nearest, _)) if compare_t(ray, nearest, named) == Some(Ordering::Equal) => {
            Word::Right
        }
        Some((_, truth)) if is_level(there.t, truth) => Word::Close,
        Some(_) => Word::Farther,
    };
    let error = (f64::from(found.t) - there.t).abs() / there.t.abs();
    (word, error.is_finite().then_some(error))
}

/// Whether a ray that does not hit a triangle would, were numbers moved by a few roundings, or by
/// this share of the triangle.
fn passes_closely(ray: &Ray<f32>, truth: &Truth, share: f64) -> bool {
    let Truth { t, beta, gamma, condition, .. } = *truth;
    let slack = |condition: f64| share.max(ROUNDING * condition);
    let (tmin, tmax) = (f64::from(ray.tmin), f64::from(ray.tmax));
    // Not so where any of them is not a number.
    beta >= -slack(condition.beta)
        && gamma >= -slack(condition.gamma)
        && beta + gamma <= 1.0 + slack(condition.beta + condition.gamma)
        && t >= tmin - ROUNDING * condition.t
        && t <= tmax + ROUNDING * condition.t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles at height `z`, above the origin and 1 wide.
    fn square(z: f32) -> [Triangle<f32>; 2] {
        let corner = |x: f32, y: f32| [x, y, z];
        [
            Triangle::new(corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)),
            Triangle::new(corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)),
        ]
    }

    fn up(x: f32, y: f32) -> Ray<f32> {
        Ray::new([x, y, 0.0], [0.0, 0.0, 1.0])
    }

    /// The only word on one answer to one ray.
    fn word(ray: Ray<f32>, triangles: &[Triangle<f32>], found: Option<(u32, f32)>) -> Word {
        let found = found.map(|(triangle, t)| Found { triangle, t });
        let (_, judged) = judge(&ray, 0, triangles, &[Answers::Closest(vec![found])]);
        judged[0].0
    }

    fn word_on_any(ray: Ray<f32>, triangles: &[Triangle<f32>], found: bool) -> Word {
        judge(&ray, 0, triangles, &[Answers::Any(vec![found])]).1[0].0
    }

    #[test]
    fn every_word_on_the_closest_hit() {
        let near = square(1.0);
        let far = square(2.0);
        let level = square(f32::from_bits(1.0_f32.to_bits() + 1));
        let triangles = [near, far, level].concat();
        let inside = up(0.75, 0.25);
        assert_eq!(word(inside, &triangles, Some((0, 1.0))), Word::Right);
        assert_eq!(word(up(2.0, 0.0), &triangles, None), Word::Right);
        assert_eq!(word(inside, &triangles, Some((4, 1.0))), Word::Close);
        assert_eq!(word(inside, &triangles, Some((2, 2.0))), Word::Farther);
        assert_eq!(word(inside, &triangles, None), Word::Missed);
        // The other half of the square, at the same distance, from far off and from close by.
        assert_eq!(word(inside, &triangles, Some((1, 1.0))), Word::Elsewhere);
        assert_eq!(word(up(0.501, 0.499), &triangles, Some((1, 1.0))), Word::Beside);
        assert_eq!(word(inside, &triangles, Some((3, 2.0))), Word::Elsewhere);
        assert_eq!(word(inside, &triangles, Some((6, 1.0))), Word::Elsewhere);
        assert_eq!(word(up(2.0, 0.0), &triangles, Some((0, 1.0))), Word::Invented);
        assert_eq!(word(up(2.0, 0.0), &triangles, Some((6, 1.0))), Word::Invented);
    }

    #[test]
    fn ties_are_right_whichever_is_named() {
        // On the diagonal, which both triangles share, and of the same triangle twice.
        let triangles = [square(1.0), square(1.0)].concat();
        for named in 0..4 {
            assert_eq!(word(up(0.5, 0.5), &triangles, Some((named, 1.0))), Word::Right);
        }
        assert_eq!(word(up(0.75, 0.25), &triangles, Some((2, 1.0))), Word::Right);
    }

    #[test]
    fn what_rounding_explains_lies_beside() {
        let triangles = [square(1.0), square(2.0)].concat();
        // Aslant, as numbers must be rounded for that.
        let edge = |beyond: f32| Ray::new([-0.1, 0.2, 0.0], [0.35, -0.2 - beyond, 1.0]);
        // Nothing is hit.
        assert_eq!(word(edge(1e-7), &triangles, Some((0, 1.0))), Word::Beside);
        assert_eq!(word(edge(1e-3), &triangles, Some((0, 1.0))), Word::Invented);
        assert_eq!(word_on_any(edge(1e-7), &triangles, true), Word::Beside);
        assert_eq!(word_on_any(edge(1e-3), &triangles, true), Word::Invented);
        // A square behind is hit, and one before it nearly.
        let behind = Triangle::new([-9.0, -9.0, 2.0], [9.0, -9.0, 2.0], [0.0, 9.0, 2.0]);
        let triangles = [&square(1.0)[..], &[behind]].concat();
        assert_eq!(word(edge(1e-7), &triangles, Some((2, 2.0))), Word::Right);
        assert_eq!(word(edge(1e-7), &triangles, Some((0, 1.0))), Word::Beside);
        assert_eq!(word(edge(1e-3), &triangles, Some((0, 1.0))), Word::Elsewhere);
        // The ray ends on a triangle, but for a rounding.
        let ends = |tmax: f32| Ray { tmax, ..up(0.75, 0.25) };
        assert_eq!(word(ends(0.999_999_9), &triangles, Some((0, 1.0))), Word::Beside);
        assert_eq!(word(ends(0.999), &triangles, Some((0, 1.0))), Word::Invented);
    }

    #[test]
    fn any_hit_is_right_or_missed() {
        let triangles = square(1.0);
        assert_eq!(word_on_any(up(0.75, 0.25), &triangles, true), Word::Right);
        assert_eq!(word_on_any(up(0.75, 0.25), &triangles, false), Word::Missed);
        assert_eq!(word_on_any(up(2.0, 0.25), &triangles, false), Word::Right);
    }

    #[test]
    fn all_that_differ_are_counted_and_the_wrong_ones_named() {
        let triangles = square(1.0);
        let rays = [up(0.75, 0.25), up(0.25, 0.75), up(2.0, 0.0)];
        let hit = |triangle| Some(Found { triangle, t: 1.0 });
        let right = Answers::Closest(vec![hit(0), hit(1), None]);
        let wrong = Answers::Closest(vec![hit(0), None, hit(1)]);
        let inexact = Found { triangle: 0, t: 1.5 };
        let far_off = Answers::Closest(vec![Some(inexact), hit(1), None]);
        let Settlement { differing, settled, sampled, verdicts, examples } =
            settle(&rays, &triangles, &[right, wrong, far_off]);
        assert_eq!((differing, settled, sampled), (2, 2, 1));
        assert_eq!(verdicts[0], Verdict { right: 3, ..Verdict::default() });
        assert_eq!(verdicts[1], Verdict { right: 1, missed: 1, invented: 1, ..Verdict::default() });
        assert_eq!(
            verdicts[2],
            Verdict { right: 3, largest_error_of_t: 0.5, ..Verdict::default() }
        );
        assert_eq!(verdicts[1].wrong(), 1);
        assert_eq!(examples.len(), 2);
        assert_eq!((examples[0].ray, examples[0].truth), (1, Some(1)));
        assert_eq!(
            examples[0].answers,
            [Said::Closest(Some(1)), Said::Closest(None), Said::Closest(Some(1))]
        );
    }

    #[test]
    fn many_rays_are_sampled_evenly() {
        let triangles = square(1.0);
        let rays = vec![up(0.75, 0.25); 5000];
        let yes = || Answers::Any(vec![true; 5000]);
        let settlement = settle(&rays, &triangles, &[yes(), yes()]);
        assert_eq!((settlement.differing, settlement.settled, settlement.sampled), (0, 0, SAMPLED));
        let settlement = settle(&rays, &triangles, &[yes(), Answers::Any(vec![false; 5000])]);
        assert_eq!(settlement.differing, 5000);
        assert!((SETTLED / 2..=SETTLED).contains(&settlement.settled));
        assert_eq!(settlement.verdicts[1].missed, settlement.settled);
        assert_eq!(settlement.examples.len(), EXAMPLES);
    }
}
