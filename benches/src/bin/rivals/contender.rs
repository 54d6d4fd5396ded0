//! What every contender can do, and how they are timed in turn.

use std::ops::Range;
use std::time::{Duration, Instant};

use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use trisect_core::{Ray, Triangle};

/// The closest hit that a contender names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Number of the triangle.
    pub triangle: u32,
    /// Ray parameter.
    pub t: f32,
}

/// The answers to all rays.
pub enum Answers {
    /// The closest hit of each.
    Closest(Vec<Option<Found>>),
    /// Whether each hits anything.
    Any(Vec<bool>),
}

/// A tree over the mesh that waits for rays.
pub trait Contender: Send {
    /// Takes all rays in the form that it likes best. Not timed.
    fn load(&mut self, rays: &[Ray<f32>]);
    /// Undoes what answering wrote over these rays. Not timed.
    fn reset(&mut self, _rays: Range<usize>) {}
    /// Finds the closest hit of these rays, and keeps it.
    fn closest(&mut self, rays: Range<usize>);
    /// Finds whether these rays hit anything, and keeps it.
    fn any(&mut self, rays: Range<usize>);
    /// What was found. Not timed.
    fn answers(&self, any: bool) -> Answers;
    /// Bytes of the tree with what it stores of the triangles; `None` where it does not say.
    fn bytes(&self) -> Option<usize>;
}

/// A contender that is not built yet.
pub struct Entrant {
    /// What it is called in tables.
    pub name: String,
    /// Builds the tree, on the threads of the pool that it is called in or on as many as are asked
    /// for, and says how long the building proper took.
    pub build: Build,
}

/// See [`Entrant::build`].
pub type Build =
    Box<dyn Fn(&[Triangle<f32>], usize) -> anyhow::Result<(Box<dyn Contender>, Duration)>>;

/// A contender in the ring.
pub struct Resident {
    pub name: String,
    pub contender: Box<dyn Contender>,
    /// How long each build took.
    pub builds: Vec<Duration>,
}

/// Rays that one contender answers before it is the next one's turn: enough that the caches are its
/// own for most of them, few enough that all meet the same weather.
const SLICE: usize = 1 << 14;

/// Builds every entrant `times` times, in turn.
pub fn build(
    entrants: &[Entrant],
    triangles: &[Triangle<f32>],
    threads: usize,
    times: usize,
    random: &mut Pcg64,
) -> anyhow::Result<Vec<Resident>> {
    let mut residents: Vec<Option<Resident>> = entrants.iter().map(|_| None).collect();
    let mut order: Vec<usize> = (0..entrants.len()).collect();
    for _ in 0..times.max(1) {
        order.shuffle(random);
        for &place in &order {
            // One tree of each at a time.
            let mut builds = residents[place].take().map_or_else(Vec::new, |last| last.builds);
            let Entrant { name, build } = &entrants[place];
            let (contender, time) = build(triangles, threads)?;
            builds.push(time);
            residents[place] = Some(Resident { name: name.clone(), contender, builds });
        }
    }
    Ok(residents.into_iter().flatten().collect())
}

/// Times of each contender over all rays, one for each repetition.
pub fn race(
    residents: &mut [Resident],
    rays: &[Ray<f32>],
    any: bool,
    repeat: usize,
    random: &mut Pcg64,
) -> Vec<Vec<Duration>> {
    for resident in &mut *residents {
        resident.contender.load(rays);
    }
    let mut times = vec![vec![Duration::ZERO; repeat]; residents.len()];
    let mut order: Vec<usize> = (0..residents.len()).collect();
    // The first round warms up and is not counted.
    for round in 0..=repeat {
        for start in (0..rays.len()).step_by(SLICE) {
            let slice = start..rays.len().min(start + SLICE);
            order.shuffle(random);
            for &place in &order {
                let contender = &mut residents[place].contender;
                contender.reset(slice.clone());
                let begin = Instant::now();
                if any {
                    contender.any(slice.clone());
                } else {
                    contender.closest(slice.clone());
                }
                let time = begin.elapsed();
                if let Some(counted) = round.checked_sub(1) {
                    times[place][counted] += time;
                }
            }
        }
    }
    times
}
