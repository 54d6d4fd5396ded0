//! What every contender can do, and how they are timed in turn.

use std::ops::Range;
use std::time::{Duration, Instant};

use anyhow::Context as _;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use trisect_core::{Ray, Triangle};

/// The closest hit that a contender names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    /// Number of the triangle.
    pub(crate) triangle: u32,
    /// Ray parameter.
    pub(crate) t: f32,
}

/// The answers to all rays.
pub(crate) enum Answers {
    /// The closest hit of each.
    Closest(Vec<Option<Found>>),
    /// Whether each hits anything.
    Any(Vec<bool>),
}

/// A way of tracing with a tree.
pub(crate) trait Contender: Send {
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
}

/// A tree that is not built yet.
pub(crate) struct Entrant {
    /// What the tree is called in tables.
    pub(crate) name: String,
    /// What those are called that trace with it, in the order of [`Built::contenders`].
    pub(crate) contenders: Vec<String>,
    /// Builds the tree on as many threads as are asked for.
    pub(crate) build: Build,
}

/// See [`Entrant::build`].
pub(crate) type Build = Box<dyn Fn(&[Triangle<f32>], usize) -> anyhow::Result<Built>>;

/// A tree that is built, and who traces with it.
pub(crate) struct Built {
    /// One for each way of tracing with the tree, which they share.
    pub(crate) contenders: Vec<Box<dyn Contender>>,
    /// How long the building proper took.
    pub(crate) time: Duration,
    /// Bytes of the tree with what it stores of the triangles; `None` where it does not say.
    pub(crate) bytes: Option<usize>,
}

/// A tree that waits for rays.
pub(crate) struct Standing {
    pub(crate) name: String,
    /// How long each build took.
    pub(crate) builds: Vec<Duration>,
    /// See [`Built::bytes`].
    pub(crate) bytes: Option<usize>,
}

/// A contender that waits for rays.
pub(crate) struct Resident {
    pub(crate) name: String,
    pub(crate) contender: Box<dyn Contender>,
}

/// Runs a build in a pool of its own, and times it.
pub(crate) fn timed<T: Send>(
    threads: usize,
    build: impl FnOnce() -> T + Send,
) -> anyhow::Result<(T, Duration)> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .context("the system gives no threads; ask for fewer with --threads")?;
    Ok(pool.install(|| {
        let start = Instant::now();
        let built = build();
        (built, start.elapsed())
    }))
}

/// Rays that one contender answers before it is the next one's turn: enough that the caches are its
/// own for most of them, few enough that all meet the same weather.
const SLICE: usize = 1 << 14;

/// Builds every tree `times` times, in turn.
pub(crate) fn build(
    entrants: &[Entrant],
    triangles: &[Triangle<f32>],
    threads: usize,
    times: usize,
    random: &mut Pcg64,
) -> anyhow::Result<(Vec<Standing>, Vec<Resident>)> {
    let mut builds: Vec<Vec<Duration>> = entrants.iter().map(|_| Vec::new()).collect();
    let mut last: Vec<Option<Built>> = entrants.iter().map(|_| None).collect();
    let mut order: Vec<usize> = (0..entrants.len()).collect();
    for _ in 0..times.max(1) {
        order.shuffle(random);
        for &place in &order {
            // One tree of each at a time.
            last[place] = None;
            let Entrant { name, build, .. } = &entrants[place];
            let built = build(triangles, threads).with_context(|| name.clone())?;
            builds[place].push(built.time);
            last[place] = Some(built);
        }
    }
    let (mut trees, mut residents) = (Vec::new(), Vec::new());
    for ((entrant, builds), built) in entrants.iter().zip(builds).zip(last.into_iter().flatten()) {
        trees.push(Standing { name: entrant.name.clone(), builds, bytes: built.bytes });
        residents.extend(
            entrant
                .contenders
                .iter()
                .zip(built.contenders)
                .map(|(name, contender)| Resident { name: name.clone(), contender }),
        );
    }
    Ok((trees, residents))
}

/// Times of each contender over all rays, one for each repetition.
pub(crate) fn race(
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
