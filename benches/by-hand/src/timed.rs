//! Times of everything in turn, and each with the same answer every time.

use std::fmt::Debug;
use std::hint::black_box;

use anyhow::{Result, ensure};
use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_pcg::Pcg64;
use trisect_machine::noise::{Meter, Spent, timed};

use crate::{SEED, Tally};

/// Something to time.
pub(crate) struct Timed<'a, X> {
    /// What it is.
    pub(crate) what: X,
    /// Nanoseconds of each sample.
    pub(crate) samples_ns: Vec<u64>,
    /// What the first run found.
    pub(crate) found: Tally,
    run: Box<dyn Fn() -> Tally + 'a>,
    repeats: u32,
    spent: Spent,
}

impl<'a, X: Debug> Timed<'a, X> {
    /// Runs once, and is ready to be timed; `repeats` runs are one sample.
    pub(crate) fn new(what: X, repeats: u32, run: impl Fn() -> Tally + 'a) -> Self {
        let (found, samples_ns, spent) = (run(), Vec::new(), Spent::default());
        Self { what, samples_ns, found, run: Box::new(run), repeats, spent }
    }

    fn sample(&mut self) -> Result<()> {
        let Self { run, repeats, .. } = self;
        let runs = || (0..*repeats).fold(Tally::default(), |_, _| black_box(run()));
        let (found, spent) = timed(runs);
        let hits = self.found.hits;
        ensure!(found.hits == hits, "{:?} found {} hits, then {}", self.what, hits, found.hits);
        self.samples_ns.push(u64::try_from(spent.wall.as_nanos())?);
        self.spent += spent;
        Ok(())
    }
}

/// Times all in turn: a round in an order drawn by lot, then the next.
pub(crate) fn in_turn<X: Debug>(
    all: &mut [Timed<'_, X>],
    rounds: usize,
    meter: &mut Meter,
) -> Result<()> {
    let mut order: Vec<usize> = (0..all.len()).collect();
    let mut lot = Pcg64::seed_from_u64(SEED);
    for _ in 0..rounds {
        order.shuffle(&mut lot);
        for &at in &order {
            all[at].sample()?;
        }
    }
    let spent = all.iter().map(|timed| timed.spent).sum();
    meter.take(all.iter().map(|timed| timed.samples_ns.as_slice()), spent);
    Ok(())
}
