//! What every contender can do, and how they are timed in turn.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context as _, anyhow};
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

impl Resident {
    /// Has it answer some rays; how long that took.
    fn answer(&mut self, rays: Range<usize>, any: bool) -> anyhow::Result<Duration> {
        let Self { name, contender } = self;
        contender.reset(rays.clone());
        guarded(name, || {
            let begin = Instant::now();
            if any {
                contender.any(rays);
            } else {
                contender.closest(rays);
            }
            begin.elapsed()
        })
    }
}

/// Bytes of the stack of a thread that builds: some builders go as deep as their trees, which have
/// no bottom where all triangles are the same.
const STACK: usize = 1 << 28;

/// Runs a build in a pool of its own, and times it.
pub(crate) fn timed<T: Send>(
    threads: usize,
    build: impl FnOnce() -> T + Send,
) -> anyhow::Result<(T, Duration)> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK)
        .build()
        .context("the system gives no threads; ask for fewer with --threads")?;
    Ok(pool.install(|| {
        let start = Instant::now();
        let built = build();
        (built, start.elapsed())
    }))
}

/// Rays that one contender answers before it is the next one's turn: few enough that all meet the same
/// conditions.
const SLICE: usize = 1 << 16;

/// Rays before them that it answers untimed, so that the caches are its own again, as they are where a
/// program has one tree: the others' trees have just gone through them.
const WARM_UP: usize = 1 << 14;

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
            let built =
                guarded(name, || build(triangles, threads))?.with_context(|| name.clone())?;
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

/// Does what others wrote, and which may panic over a mesh that they did not think of.
fn guarded<T>(name: &str, work: impl FnOnce() -> T) -> anyhow::Result<T> {
    GUARDED.store(true, Ordering::Relaxed);
    // What has panicked is not used again.
    let done = catch_unwind(AssertUnwindSafe(work));
    GUARDED.store(false, Ordering::Relaxed);
    done.map_err(|panic| {
        let said = panic.downcast_ref::<&str>().copied();
        let said = said.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        let said = said.unwrap_or("it does not say why");
        anyhow!("{name} panics over this mesh ({said}); leave it out with --only")
    })
}

/// Whether a panic is reported as an error.
static GUARDED: AtomicBool = AtomicBool::new(false);

/// Keeps panics that are reported as errors from being printed as well.
pub(crate) fn quiet_guarded_panics() {
    let print = take_hook();
    set_hook(Box::new(move |panic| {
        if !GUARDED.load(Ordering::Relaxed) {
            print(panic);
        }
    }));
}

/// The rays before a slice that are answered untimed: before the first one, the last of all.
fn before(slice: &Range<usize>, rays: usize) -> Range<usize> {
    let end = if slice.start == 0 { rays } else { slice.start };
    end.saturating_sub(WARM_UP)..end
}

/// Times of each contender over all rays, one for each repetition.
pub(crate) fn race(
    residents: &mut [Resident],
    rays: &[Ray<f32>],
    any: bool,
    repeat: usize,
    random: &mut Pcg64,
) -> anyhow::Result<Vec<Vec<Duration>>> {
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
                let resident = &mut residents[place];
                resident.answer(before(&slice, rays.len()), any)?;
                let time = resident.answer(slice.clone(), any)?;
                if let Some(counted) = round.checked_sub(1) {
                    times[place][counted] += time;
                }
            }
        }
    }
    Ok(times)
}
