//! Trees that trace the same rays in turn; every sample is verified.

use std::ops::Range;
use std::time::Duration;

use rand::seq::SliceRandom as _;
use rand_pcg::Pcg64;
use rayon::ThreadPool;
use trisect_catalog::{Tracing, Tree, TriangleHit};
use trisect_method::Culling;

use super::measure::Resident;
use super::rays::ClassOfRays;
use crate::noise::{Meter, Spent, timed};
use crate::timing::{WrongAnswer, nanoseconds};

/// Rays of a turn: enough that the caches are a contender's own for most of them, few enough that all
/// meet the same conditions.
const SLICE: usize = 1 << 14;

/// How many rays make a turn.
#[derive(Clone, Copy)]
pub(super) enum Order {
    /// A slice of a round's rays, so that turns are short.
    Slices,
    /// All of a round's rays, so that threads have enough to share.
    Whole,
}

/// A tree and a way to trace it.
pub(super) struct Contender<'a> {
    /// Of its tree.
    method: &'a str,
    tree: &'a dyn Tree,
    tracing: Tracing,
    ray_by_ray: bool,
    pub pool: &'a ThreadPool,
    pub samples_ns: Vec<u64>,
    /// What all samples took.
    pub spent: Spent,
    pub hits: u64,
    /// Rays that hit here and miss in plain arithmetic, or the other way round.
    pub differ: u64,
}

/// Where hits are written.
enum Places {
    Closest(Vec<Option<TriangleHit>>),
    Any(Vec<bool>),
}

impl Places {
    fn of(class: &ClassOfRays) -> Self {
        if class.any {
            Self::Any(vec![false; class.rays.len()])
        } else {
            Self::Closest(vec![None; class.rays.len()])
        }
    }

    fn forget(&mut self, slice: Range<usize>) {
        match self {
            Self::Closest(found) => found[slice].fill(None),
            Self::Any(found) => found[slice].fill(false),
        }
    }

    fn is_hit(&self, ray: usize) -> bool {
        match self {
            Self::Closest(found) => found[ray].is_some(),
            Self::Any(found) => found[ray],
        }
    }

    fn hits(&self, slice: Range<usize>) -> u64 {
        slice.filter(|&ray| self.is_hit(ray)).count() as u64
    }
}

impl<'a> Contender<'a> {
    pub(super) fn new(resident: &'a Resident, tracing: Tracing, pool: &'a ThreadPool) -> Self {
        Self {
            method: &resident.built.method,
            tree: &*resident.tree,
            tracing,
            ray_by_ray: false,
            pool,
            samples_ns: Vec::new(),
            spent: Spent::default(),
            hits: 0,
            differ: 0,
        }
    }

    /// The same tree traced in plain arithmetic.
    fn as_plain(&self) -> Self {
        let samples_ns = Vec::new();
        Self { tracing: Tracing::Plain, ray_by_ray: false, samples_ns, ..*self }
    }

    /// The same with one call of the tree for each ray, which traces it singly.
    pub(super) fn ray_by_ray(self) -> Self {
        Self { ray_by_ray: true, ..self }
    }

    pub(super) fn tracing_name(&self) -> &'static str {
        match self.tracing {
            Tracing::Single => "single",
            Tracing::Packets => "packets",
            Tracing::Plain => "plain",
        }
    }

    pub(super) fn calls_name(&self) -> &'static str {
        if self.ray_by_ray { "ray" } else { "batch" }
    }

    /// Traces a slice of the rays; how long that took.
    fn turn(&self, class: &ClassOfRays, slice: Range<usize>, places: &mut Places) -> Spent {
        let rays = &class.rays[slice.clone()];
        let (tree, tracing) = (self.tree, self.tracing);
        let work = || match places {
            Places::Closest(found) if self.ray_by_ray => {
                for (ray, found) in rays.iter().zip(&mut found[slice]) {
                    *found = tree.closest_hit(Culling::None, ray).found();
                }
            }
            Places::Any(found) if self.ray_by_ray => {
                for (ray, found) in rays.iter().zip(&mut found[slice]) {
                    *found = tree.any_hit(Culling::None, ray);
                }
            }
            Places::Closest(found) => tree.closest(tracing, Culling::None, rays, &mut found[slice]),
            Places::Any(found) => tree.any(tracing, Culling::None, rays, &mut found[slice]),
        };
        self.pool.install(|| timed(work)).1
    }

    fn wrong(&self, class: &ClassOfRays, found: String, expected: u64) -> WrongAnswer {
        let kernel = format!("{} ({}, {} rays)", self.method, self.tracing_name(), class.name);
        WrongAnswer { kernel, found, expected: expected.to_string() }
    }
}

/// What contenders that raced on one thread tell about the machine.
pub(super) fn note(meter: &mut Meter, contenders: &[Contender<'_>]) {
    let spent = contenders.iter().map(|contender| contender.spent).sum();
    meter.take(contenders.iter().map(|contender| &contender.samples_ns[..]), spent);
}

/// Rays whose decision rounding explains, of so many: those that pass within rounding of an edge.
/// Generous, as a sum of angles is good to two digits; how many there are is in the record.
fn explained(rays: usize) -> u64 {
    16 + rays as u64 / 100
}

/// Times each contender over all rays once per round, in turns whose order is drawn by lot. Before
/// that each traces all rays once, which is not timed, and is held to what its tree says in plain
/// arithmetic; every timed turn has to find as many hits as that.
pub(super) fn race(
    contenders: &mut [Contender<'_>],
    class: &ClassOfRays,
    rounds: usize,
    random: &mut Pcg64,
    order: Order,
) -> Result<(), WrongAnswer> {
    let count = class.rays.len();
    let length = match order {
        Order::Slices => SLICE,
        Order::Whole => count,
    };
    let slices: Vec<Range<usize>> =
        (0..count).step_by(length).map(|start| start..count.min(start + length)).collect();
    let mut places = Places::of(class);
    // Hits of each contender in each slice.
    let mut expected = Vec::new();
    for contender in &mut *contenders {
        let mut plain = Places::of(class);
        contender.as_plain().turn(class, 0..count, &mut plain);
        places.forget(0..count);
        for slice in &slices {
            contender.turn(class, slice.clone(), &mut places);
        }
        contender.hits = places.hits(0..count);
        contender.differ =
            (0..count).filter(|&ray| places.is_hit(ray) != plain.is_hit(ray)).count() as u64;
        if contender.differ > explained(count) {
            let Contender { hits, differ, .. } = contender;
            let found = format!("{hits} hits, {differ} of {count} rays decided otherwise");
            return Err(contender.wrong(class, found, plain.hits(0..count)));
        }
        expected.push(slices.iter().map(|slice| places.hits(slice.clone())).collect::<Vec<_>>());
    }
    let mut sums = vec![Spent::default(); contenders.len()];
    let mut turns: Vec<usize> = (0..contenders.len()).collect();
    for _ in 0..rounds {
        let mut times = vec![Duration::ZERO; contenders.len()];
        for (number, slice) in slices.iter().enumerate() {
            turns.shuffle(random);
            for &turn in &turns {
                let contender = &contenders[turn];
                places.forget(slice.clone());
                let spent = contender.turn(class, slice.clone(), &mut places);
                times[turn] += spent.wall;
                sums[turn] += spent;
                let hits = places.hits(slice.clone());
                if hits != expected[turn][number] {
                    let found = format!("{hits} hits");
                    return Err(contender.wrong(class, found, expected[turn][number]));
                }
            }
        }
        for (contender, time) in contenders.iter_mut().zip(times) {
            contender.samples_ns.push(nanoseconds(time));
        }
    }
    contenders.iter_mut().zip(sums).for_each(|(contender, spent)| contender.spent = spent);
    Ok(())
}
