//! Times kernels in rounds of random order; every sample is verified.

use std::time::Duration;

use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use trisect_catalog::{Kernel, Scene, Tally};
use trisect_report::stats::median;

use crate::noise::{self, Spent};

/// As records have times: whole nanoseconds; the largest number for five hundred years and more.
pub fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

/// The median of some times; infinite where there are none.
pub(crate) fn middle(samples_ns: &[u64]) -> f64 {
    let samples: Vec<f64> = samples_ns.iter().map(|&ns| ns as f64).collect();
    median(&samples).unwrap_or(f64::INFINITY)
}

/// A kernel with the scene it runs on, and what it must return.
pub(crate) struct Contender<'a> {
    pub kernel: &'a Kernel,
    pub scene: &'a Scene,
    pub expected: Expected,
    pub samples_ns: Vec<u64>,
    /// What all samples took.
    pub spent: Spent,
    pub tally: Option<Tally>,
}

/// What a kernel must return, from the answers of the same variant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Expected {
    /// The hits, exactly.
    pub hits: u64,
    /// The sum, up to the rounding of a sum of this many terms.
    pub sum: f64,
    /// How far the sum may be off: `n · u · Σ|x|`, the bound for a sum in any order.
    pub slack: f64,
}

/// A kernel returned something else than its variant's answers add up to.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{kernel} returned {found}, its answers add up to {expected}; this is a bug in trisect, \
     please report it with the command and the record's header"
)]
pub struct WrongAnswer {
    pub(crate) kernel: String,
    pub(crate) found: String,
    pub(crate) expected: String,
}

impl Contender<'_> {
    /// Runs the kernel once; the first run of a contender is not timed.
    pub(crate) fn sample(&mut self, timed: bool) -> Result<(), WrongAnswer> {
        let spent = self.run()?;
        if timed {
            self.samples_ns.push(nanoseconds(spent.wall));
            self.spent += spent;
        }
        Ok(())
    }

    /// Runs the kernel once, and says how long that took.
    pub(crate) fn run(&mut self) -> Result<Spent, WrongAnswer> {
        let (tally, spent) = noise::timed(|| self.kernel.run(self.scene));
        let sum_is_right = (tally.sum - self.expected.sum).abs() <= self.expected.slack;
        let repeats = self.tally.is_none_or(|first| first == tally);
        if tally.hits != self.expected.hits || !sum_is_right || !repeats {
            return Err(WrongAnswer {
                kernel: format!("{:?}", self.kernel.variant),
                found: format!("{tally:?}"),
                expected: format!("{:?}", self.expected),
            });
        }
        self.tally = Some(tally);
        Ok(spent)
    }
}

/// Takes a sample of every contender once per round, each round in a new random order, after one round of
/// warming up; `sample` hears whether it counts.
pub(crate) fn rounds<C>(
    contenders: &mut [C],
    rounds: usize,
    random: &mut Pcg64,
    mut sample: impl FnMut(&mut C, bool) -> Result<(), WrongAnswer>,
) -> Result<(), WrongAnswer> {
    let mut order: Vec<usize> = (0..contenders.len()).collect();
    for round in 0..=rounds {
        order.shuffle(random);
        for &i in &order {
            sample(&mut contenders[i], round > 0)?;
        }
    }
    Ok(())
}
