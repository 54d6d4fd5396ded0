//! Answers held against each other, and differences settled by the oracle.

use rayon::prelude::*;
use serde::Serialize;
use trisect_core::{Ray, Triangle};
use trisect_oracle::{Oracle, compare_t};

use crate::contender::{Answers, Found};

/// Rays that are settled, at most: each is tested against every triangle.
const SETTLED: usize = 2000;

/// Rays whose answers are settled though all contenders agree, spread evenly.
const SAMPLED: usize = 200;

/// Two distances this close, relative to the larger, are the same to a float: a rounding of each
/// `t` in single precision, times what computing it costs.
const CLOSE: f64 = 1e-5;

/// What the oracle says to one contender's answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// Right: the closest triangle, one as close, or truly nothing.
    pub right: usize,
    /// A triangle whose `t` is the truth's to a rounding, though another is closer.
    pub close: usize,
    /// Beside the triangle that is named, by a rounding, at the `t` of the truth: the neighbour is
    /// hit.
    pub neighbour: usize,
    /// Nothing was found, and there is something.
    pub missed: usize,
    /// Something was found where there is nothing.
    pub invented: usize,
    /// A triangle beyond the closest one.
    pub farther: usize,
    /// A triangle that is not hit, nearer or farther than the truth.
    pub elsewhere: usize,
}

/// What was settled.
#[derive(Debug, Serialize)]
pub struct Settlement {
    /// Rays that not all contenders answer alike.
    pub differing: usize,
    /// Those of them that were settled; the others are like them.
    pub settled: usize,
    /// Rays that all answer alike and that were settled as well.
    pub sampled: usize,
    /// Of each contender, over all settled rays.
    pub verdicts: Vec<Verdict>,
    /// The first rays that somebody has wrong: number, and what each contender says.
    pub examples: Vec<Example>,
}

/// A ray that somebody has wrong.
#[derive(Debug, Serialize)]
pub struct Example {
    pub ray: usize,
    /// The closest triangle in truth.
    pub truth: Option<usize>,
    /// What each contender names; of any-hit the number means nothing.
    pub answers: Vec<Option<u32>>,
}

/// Rays that are named as examples, at most.
const EXAMPLES: usize = 5;

enum Word {
    Right,
    Close,
    Neighbour,
    Missed,
    Invented,
    Farther,
    Elsewhere,
}

pub fn settle(rays: &[Ray<f32>], triangles: &[Triangle<f32>], answers: &[Answers]) -> Settlement {
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
    let words: Vec<(Option<usize>, Vec<Word>)> = chosen
        .par_iter()
        .map(|&at| {
            let mut oracle = Oracle::default();
            let ray = &rays[at];
            let truth = oracle.closest(ray, triangles).map(|(number, _)| number);
            let words = answers.iter().map(|answers| match answers {
                Answers::Closest(found) => word(ray, triangles, truth, found[at]),
                Answers::Any(found) => match (found[at], truth.is_some()) {
                    (true, false) => Word::Invented,
                    (false, true) => Word::Missed,
                    _ => Word::Right,
                },
            });
            (truth, words.collect())
        })
        .collect();
    let mut verdicts = vec![Verdict::default(); answers.len()];
    let mut examples = Vec::new();
    for (&at, (truth, words)) in chosen.iter().zip(&words) {
        for (word, verdict) in words.iter().zip(&mut verdicts) {
            *verdict.of(word) += 1;
        }
        let wrong = words.iter().any(|word| !matches!(word, Word::Right | Word::Close));
        if wrong && examples.len() < EXAMPLES {
            let answers = answers.iter().map(|answers| match answers {
                Answers::Closest(found) => found[at].map(|found| found.triangle),
                Answers::Any(found) => found[at].then_some(0),
            });
            examples.push(Example { ray: at, truth: *truth, answers: answers.collect() });
        }
    }
    let (differing, sampled) = (differing.len(), chosen.len() - settled);
    Settlement { differing, settled, sampled, verdicts, examples }
}

impl Verdict {
    fn of(&mut self, word: &Word) -> &mut usize {
        match word {
            Word::Right => &mut self.right,
            Word::Close => &mut self.close,
            Word::Neighbour => &mut self.neighbour,
            Word::Missed => &mut self.missed,
            Word::Invented => &mut self.invented,
            Word::Farther => &mut self.farther,
            Word::Elsewhere => &mut self.elsewhere,
        }
    }
}

fn word(
    ray: &Ray<f32>,
    triangles: &[Triangle<f32>],
    truth: Option<usize>,
    found: Option<Found>,
) -> Word {
    let (truth, found) = match (truth, found) {
        (None, None) => return Word::Right,
        (None, Some(_)) => return Word::Invented,
        (Some(_), None) => return Word::Missed,
        (Some(truth), Some(found)) => (truth, found),
    };
    if found.triangle as usize == truth {
        return Word::Right;
    }
    let mut oracle = Oracle::default();
    let (nearest, named) = (&triangles[truth], &triangles[found.triangle as usize]);
    let t = oracle.truth(ray, nearest).t;
    if oracle.classify(ray, named).is_hit() {
        let other = oracle.truth(ray, named).t;
        if compare_t(ray, nearest, named) == Some(std::cmp::Ordering::Equal) {
            Word::Right
        } else if (other - t).abs() <= CLOSE * t.abs().max(other.abs()) {
            Word::Close
        } else {
            Word::Farther
        }
    } else if (f64::from(found.t) - t).abs() <= CLOSE * t.abs() {
        Word::Neighbour
    } else {
        Word::Elsewhere
    }
}
