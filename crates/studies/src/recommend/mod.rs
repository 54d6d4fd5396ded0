//! One kernel for a user's own triangles and rays: all that answer what is asked are measured on them.

mod decisions;
mod race;
mod sample;
mod search;
mod text;

use std::time::Duration;

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_pcg::Pcg64;
use serde::Serialize;
use trisect_catalog::entries;
use trisect_core::{FloatFormat, MultiplyAdd};
use trisect_method::{Form, Output, ReciprocalKind};

use crate::comparison::Refusal;
use crate::record::Variant;
use crate::study::Progress;
use crate::subject::{Inputs, Judged as _};
use crate::surface::open_edges;
use crate::timing::WrongAnswer;
use crate::timing::middle;
use decisions::Ways;
use race::{Racer, measure_all, race};
use sample::sample;
use search::{Judge, Search};

pub use decisions::Wrong;
pub use text::recommendation_text;

/// How many of the rays that kernels are tried on are timed: enough that a sample is longer than the
/// clock's steps.
const TIMED_RAYS: usize = 64;

/// What is looked for.
pub struct RecommendSettings {
    /// Seed of the order of samples and of the choice of rays.
    pub seed: u64,
    /// What is asked of a hit.
    pub needs: Output,
    /// The largest error allowed, see [`Candidate::error`].
    pub max_error: Option<f64>,
    /// Whether rays may never pass between triangles that share an edge.
    pub watertight: bool,
    /// Whether kernels must do what a tracer does at a leaf, see [`Variant::is_as_in_a_tracer`].
    pub in_tracer: bool,
    /// A method whose fastest kernel stays in the race to the end, right or wrong, to see how far it is
    /// behind.
    pub beside: Option<&'static str>,
    /// How long kernels race.
    pub time: Duration,
    /// Whether all of them are measured as well, to see how good the choice is.
    pub exhaustive: bool,
}

/// A kernel that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Candidate {
    /// Which. What it gives may be more than was asked for.
    #[serde(flatten)]
    pub variant: Variant,
    /// Median nanoseconds of a test.
    pub ns_per_test: f64,
    /// How many samples that is the median of.
    pub samples: usize,
    /// Bytes that a triangle takes.
    pub bytes_per_triangle: usize,
    /// The largest error of what is asked against the exact values, over the hits of the sample: relative
    /// of `t`, absolute of barycentrics, which are shares of one; 0 where no value is asked for.
    pub error: f64,
    /// What it decided wrongly: nothing, but for what stays in the race to be seen beside.
    #[serde(flatten)]
    pub wrong: Wrong,
}

/// What kernels of a method that decide alike decided wrongly.
#[derive(Clone, Debug, Serialize)]
pub struct Decided {
    /// The method.
    pub method: &'static str,
    /// The format of each number.
    pub precision: FloatFormat,
    /// How `a·b + c` is rounded.
    pub arithmetic: MultiplyAdd,
    /// When they divide.
    pub division: Form,
    /// How they divide.
    pub reciprocal: ReciprocalKind,
    /// How many decisions were wrong.
    #[serde(flatten)]
    pub wrong: Wrong,
    /// Whether of all rays that were checked, or else of the sample, or of those rays that a faster kernel
    /// was wrong about.
    pub of_all_rays: bool,
}

/// The race against a measurement of everything.
#[derive(Clone, Debug, Serialize)]
pub struct Exhaustive {
    /// Samples of every candidate.
    pub samples_of_all: usize,
    /// The samples that follow, of the fastest and of the one recommended, all in turn.
    pub samples_of_fastest: usize,
    /// The fastest of all.
    pub best: Candidate,
    /// Nanoseconds of a test of the one recommended, in the same run.
    pub chosen_ns_per_test: f64,
    /// How much slower the recommended one is than the best: 0.01 is a hundredth.
    pub behind: f64,
}

/// What is recommended, and why.
#[derive(Clone, Debug, Serialize)]
pub struct Recommendation {
    /// What was asked.
    pub needs: Output,
    /// The largest error allowed.
    pub max_error: Option<f64>,
    /// Whether it had to be watertight.
    pub watertight: bool,
    /// Edges of the user's surface that do not join two triangles; none where it is closed.
    pub open_edges: usize,
    /// Triangles and rays of the user's, and how many of them kernels were tried on.
    pub triangles: [usize; 2],
    /// Likewise the rays; the last number is of those that were timed.
    pub rays: [usize; 3],
    /// True hits among the pairs.
    pub hits: usize,
    /// Rays on which the decisions of the fastest were checked, and pairs of a ray and a triangle.
    pub checked: [usize; 2],
    /// Kernels that raced.
    pub candidates: usize,
    /// Methods that cannot take the mesh.
    pub refused: Vec<Refusal>,
    /// The decisions of all kernels that give what is asked.
    pub decisions: Vec<Decided>,
    /// The fastest first: the one recommended, and the runners-up.
    pub ranking: Vec<Candidate>,
    /// How good the choice is, where that was asked for.
    pub exhaustive: Option<Exhaustive>,
}

/// Why nothing is recommended.
#[derive(Debug, thiserror::Error)]
pub enum RecommendError {
    /// A timed sample was wrong.
    #[error(transparent)]
    WrongAnswer(#[from] WrongAnswer),
    /// No kernel is good enough.
    #[error(
        "no kernel keeps its error within {allowed:e} here; the least is {least:e}: allow that with --max-error"
    )]
    Imprecise {
        /// The error allowed.
        allowed: f64,
        /// The least there is.
        least: f64,
    },
    /// No error is known.
    #[error(
        "none of the rays tried hits the mesh, so that no error is known; give rays that do with --rays"
    )]
    NoHits,
    /// Every kernel is wrong about some ray.
    #[error(
        "no kernel that gives {needs} decides all pairs of these rays and triangles as exact arithmetic does; the best is wrong about {wrong}: leave out what narrows the choice, or ask the method `exact`"
    )]
    NoneRight {
        /// What is asked.
        needs: Output,
        /// The fewest wrong decisions.
        wrong: usize,
    },
    /// No kernel is compiled for that.
    #[error(
        "no watertight kernel is compiled that gives {needs}; leave out --watertight, or ask for less with --needs"
    )]
    NoneWatertight {
        /// What is asked.
        needs: Output,
    },
}

/// Recommends a kernel: the fastest of those that decide every pair as exact arithmetic does, and keep
/// their error within what is allowed.
///
/// All kernels are held to the exact values on a sample, every ray against every triangle. The fastest of
/// those that pass are held to them again over all rays, or millions of pairs, each ray against the
/// triangles whose boxes it meets. Kernels in either precision are judged by the numbers that they get.
///
/// # Errors
/// When no kernel is good enough, or a timed sample is not what its variant's answers add up to.
///
/// # Panics
/// When there are no triangles or no rays.
pub fn recommend(
    settings: &RecommendSettings,
    inputs: &Inputs,
    progress: &mut dyn Progress,
) -> Result<Recommendation, RecommendError> {
    let mut random = Pcg64::seed_from_u64(settings.seed);
    progress.phase("choosing triangles and rays", 2);
    let mut order: Vec<usize> = (0..inputs.rays.len()).collect();
    order.shuffle(&mut random);
    let subject = sample(inputs, &order);
    progress.step();
    let ways = Ways::new(inputs, &order);
    progress.step();
    let [tried_rays, tried_triangles] = [subject.workload.rays, subject.workload.triangles];
    let timed_rays = TIMED_RAYS.min(tried_rays);
    let hits = subject.double.known().truth.len();
    if hits == 0 && settings.max_error.is_some() {
        return Err(RecommendError::NoHits);
    }

    let mut search = Search::new(settings, timed_rays);
    let methods = entries();
    progress.phase("comparing answers", methods.len() as u64);
    for entry in methods {
        search.consider(entry, inputs, &subject);
        progress.step();
    }
    let Search { groups, mut judge, refused, .. } = search;
    let (mut racing, candidates) = loop {
        let mut racing = judge.racers(&groups, &subject)?;
        let candidates = racing.len();
        race(&mut racing, settings, &mut random, progress)?;
        progress.phase("checking decisions", 1);
        judge.check(&ways, |kind| racing.iter().any(|(_, c)| kind.has(&c.kernel.variant)));
        progress.step();
        racing.retain(|racer| judge.keeps(racer));
        if racing.iter().any(|racer| judge.allows(racer)) {
            break (racing, candidates);
        }
    };
    // What is there to be seen beside may be the fastest, and is not recommended for it.
    racing.sort_by_key(|racer| !judge.allows(racer));
    let chosen = (racing[0].0, racing[0].1.kernel);
    let tests = (timed_rays * tried_triangles) as f64;
    let ranking = racing.iter().map(|racer| candidate(racer, &judge, tests)).collect();
    let exhaustive = if settings.exhaustive {
        judge.check(&ways, |_| true);
        let mut all = judge.racers(&groups, &subject)?;
        let candidate = |racer: &Racer<'_>| candidate(racer, &judge, tests);
        Some(measure_all(&mut all, chosen, &mut random, progress, candidate)?)
    } else {
        None
    };
    Ok(Recommendation {
        needs: settings.needs,
        max_error: settings.max_error,
        watertight: settings.watertight,
        open_edges: open_edges(&inputs.triangles),
        triangles: [inputs.triangles.len(), tried_triangles],
        rays: [inputs.rays.len(), tried_rays, timed_rays],
        hits,
        checked: ways.counts(),
        candidates,
        refused,
        decisions: judge.decisions(),
        ranking,
        exhaustive,
    })
}

/// A racer, so many of whose tests were timed at a time.
fn candidate(racer: &Racer<'_>, judge: &Judge<'_>, tests: f64) -> Candidate {
    let (group, contender) = racer;
    let quality = judge.quality(racer);
    Candidate {
        variant: contender.kernel.variant.clone(),
        ns_per_test: middle(&contender.samples_ns) / tests,
        samples: contender.samples_ns.len(),
        bytes_per_triangle: group.bytes_per_triangle,
        error: quality.error,
        wrong: quality.wrong,
    }
}
