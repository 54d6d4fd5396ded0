//! One kernel for a user's own triangles and rays: all that answer what is asked are measured on them.

use std::time::Duration;

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_pcg::Pcg64;
use serde::Serialize;
use trisect_catalog::{Entry, Kernel, Kernels, Variant, entries, find};
use trisect_core::{Culling, Hit, Output, Precision, Ray, Triangle};

use crate::answers::Pair;
use crate::measure::{Group, Progress, REFERENCE, answers_of_widest, contenders, record_variant};
use crate::record::{self, Family, Refusal};
use crate::stats::middle;
use crate::subject::Subject;
use crate::surface::open_edges;
use crate::timing::{self, Contender, WrongAnswer};

/// Rays of a user that kernels answer, at most.
const RAYS: usize = 256;

/// How many of these are timed: enough that a sample is longer than the clock's steps.
const TIMED_RAYS: usize = 64;

/// Triangles of a mesh that kernels are tried on, at most: such as the second cache holds in every
/// precision, so that kernels are told apart and not memories.
const TRIANGLES: usize = 2048;

/// So many kernels share the last, and longest, part of a race.
const FINALISTS: usize = 16;

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
    /// Whether kernels must do what a tracer does at a leaf, see [`record::Variant::is_as_in_a_tracer`].
    pub in_tracer: bool,
    /// A method whose fastest kernel stays in the race to the end, to see how far it is behind.
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
    pub variant: record::Variant,
    /// Median nanoseconds of a test.
    pub ns_per_test: f64,
    /// How many samples that is the median of.
    pub samples: usize,
    /// Bytes that a triangle takes.
    pub bytes_per_triangle: usize,
    /// The largest error of what is asked against the exact values: relative of `t`, absolute of
    /// barycentrics, which are shares of one; where no value is asked for, the share of hits that are
    /// wrongly decided.
    pub error: f64,
    /// Pairs that are decided wrongly, in a hundred true hits.
    pub wrong_percent: f64,
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
    pub needs: &'static str,
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
    /// Kernels that took part.
    pub candidates: usize,
    /// Methods that cannot take the mesh.
    pub refused: Vec<Refusal>,
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
    /// No kernel is compiled for that.
    #[error(
        "no watertight kernel is compiled that gives {needs}; leave out --watertight, or ask for less with --needs"
    )]
    NoneWatertight {
        /// What is asked.
        needs: &'static str,
    },
}

/// Recommends a kernel.
///
/// # Errors
/// When no kernel is good enough, or a timed sample is not what its variant's answers add up to.
///
/// # Panics
/// When there are no triangles or no rays.
pub fn recommend(
    settings: &RecommendSettings,
    triangles: &[Triangle<f32>],
    rays: &[Ray<f32>],
    progress: &mut dyn Progress,
) -> Result<Recommendation, RecommendError> {
    let mut random = Pcg64::seed_from_u64(settings.seed);
    progress.phase("choosing triangles and rays", 1);
    let subject = sample(triangles, rays, &mut random);
    let timed_rays = TIMED_RAYS.min(subject.rays32.len());
    progress.step();
    if subject.truth.is_empty() && settings.max_error.is_some() {
        return Err(RecommendError::NoHits);
    }

    let mut search = Search {
        settings,
        truth: subject.truth.iter().map(Pair::from).collect(),
        timed_rays,
        groups: Vec::new(),
        qualities: Vec::new(),
        refused: Vec::new(),
        least: f64::INFINITY,
        seen: false,
    };
    let methods = entries();
    progress.phase("comparing answers", methods.len() as u64);
    for entry in methods {
        search.consider(entry, triangles, &subject);
        progress.step();
    }
    let Search { groups, qualities, refused, least, seen, .. } = search;
    let mut racing = contenders(&groups, &subject);
    if racing.is_empty() {
        return Err(match settings.max_error {
            Some(allowed) if seen => RecommendError::Imprecise { allowed, least },
            _ => RecommendError::NoneWatertight { needs: settings.needs.name() },
        });
    }
    let candidates = racing.len();
    race(&mut racing, settings, &mut random, progress)?;

    let tests = (timed_rays * subject.triangles32.len()) as f64;
    let candidate = |(group, contender): &Racer<'_>| {
        let variant = contender.kernel.variant;
        let quality = qualities.iter().find(|quality| quality.is_of(group.method, variant));
        let quality = quality.expect("what is timed has answered");
        Candidate {
            variant: group.record_variant(contender.kernel),
            ns_per_test: middle(&contender.samples_ns) / tests,
            samples: contender.samples_ns.len(),
            bytes_per_triangle: group.bytes_per_triangle,
            error: quality.error,
            wrong_percent: quality.wrong * 100.0,
        }
    };
    let ranking: Vec<Candidate> = racing.iter().map(candidate).collect();
    let exhaustive = if settings.exhaustive {
        let chosen = (racing[0].0, racing[0].1.kernel);
        let mut all = contenders(&groups, &subject);
        Some(measure_all(&mut all, chosen, &mut random, progress, candidate)?)
    } else {
        None
    };
    Ok(Recommendation {
        needs: settings.needs.name(),
        max_error: settings.max_error,
        watertight: settings.watertight,
        open_edges: open_edges(triangles),
        triangles: [triangles.len(), subject.triangles32.len()],
        rays: [rays.len(), subject.rays32.len(), timed_rays],
        hits: subject.truth.len(),
        candidates,
        refused,
        ranking,
        exhaustive,
    })
}

/// A kernel in the race, with its group.
type Racer<'a> = (&'a Group, Contender<'a>);

/// How good the answers of a method are.
struct Quality {
    method: &'static str,
    variant: Variant,
    error: f64,
    /// The share of true hits that are decided wrongly.
    wrong: f64,
}

impl Quality {
    /// Whether it is that of a variant, on lanes of any width: these give the same bits.
    fn is_of(&self, method: &str, variant: Variant) -> bool {
        let Variant { lane, division, reciprocal } = self.variant;
        self.method == method
            && (lane.precision, lane.arithmetic, division, reciprocal)
                == (
                    variant.lane.precision,
                    variant.lane.arithmetic,
                    variant.division,
                    variant.reciprocal,
                )
    }
}

/// A search under way.
struct Search<'a> {
    settings: &'a RecommendSettings,
    truth: Vec<Pair>,
    timed_rays: usize,
    groups: Vec<Group>,
    qualities: Vec<Quality>,
    refused: Vec<Refusal>,
    /// The least error of all that would do otherwise.
    least: f64,
    /// Whether there is any such.
    seen: bool,
}

impl Search<'_> {
    /// Notes which kernels of a method would do.
    fn consider(&mut self, entry: &'static Entry, mesh: &[Triangle<f32>], subject: &Subject) {
        // The whole mesh: what a method asks of all its triangles a part of them may have.
        if let Err(unsuitable) = (entry.f32.prepare)(mesh, &[]) {
            self.refused.push(Refusal {
                method: entry.info.name.to_owned(),
                precision: <f32 as trisect_core::Float>::NAME.to_owned(),
                workload: subject.workload.name.clone(),
                reason: unsuitable.reason,
            });
            return;
        }
        self.consider_in(entry, &entry.f32, &subject.rays32, &subject.triangles32);
        self.consider_in(entry, &entry.f64, &subject.rays64, &subject.triangles64);
    }

    fn consider_in<E: Precision>(
        &mut self,
        entry: &'static Entry,
        kernels: &'static Kernels<E>,
        rays: &[Ray<E>],
        triangles: &[Triangle<E>],
    ) {
        let Ok(scene) = (kernels.prepare)(triangles, rays) else { return };
        let answers = answers_of_widest(&kernels.finders, &scene)
            .into_iter()
            .chain(answers_of_widest(&kernels.deciders, &scene));
        for (variant, answers) in answers {
            let hits = self.truth.len().max(1) as f64;
            let wrong = answers.disagreements(&self.truth) as f64 / hits;
            let needs = self.settings.needs;
            let error = match needs {
                Output::Occlusion => wrong,
                _ => answers.differences(&self.truth, |hit, exact| off(needs, hit, exact)).max,
            };
            self.qualities.push(Quality { method: entry.info.name, variant, error, wrong });
        }
        let timed: Vec<&Kernel> =
            kernels.timed.iter().filter(|kernel| self.would_do(entry, kernel)).collect();
        let Ok(scene) = (kernels.prepare)(triangles, &rays[..self.timed_rays]) else { return };
        self.groups.push(Group::new(entry, kernels, scene, timed));
    }

    /// Whether a kernel runs here, gives what is asked, and does so well enough.
    fn would_do(&mut self, entry: &Entry, kernel: &Kernel) -> bool {
        let Variant { lane, division, .. } = kernel.variant;
        let is_watertight =
            entry.info.claims.watertight && lane.arithmetic == "plain" && division == "deferred";
        let (arrangement, needs) = (kernel.arrangement.name(), kernel.needs.name());
        let is_in_tracer =
            record_variant(entry.info.name, kernel.variant, arrangement, kernel.early_out, needs)
                .is_as_in_a_tracer();
        if !lane.instruction_set.is_available()
            || !gives(kernel.needs, self.settings.needs)
            || (self.settings.watertight && !is_watertight)
            || (self.settings.in_tracer && !is_in_tracer)
        {
            return false;
        }
        let quality = self.qualities.iter().find(|q| q.is_of(entry.info.name, kernel.variant));
        let error = quality.map_or(f64::INFINITY, |quality| quality.error);
        self.least = self.least.min(error);
        self.seen = true;
        self.settings.max_error.is_none_or(|allowed| error <= allowed)
    }
}

/// Whether a kernel that was asked for `output` gives `asked`.
fn gives(output: Output, asked: Output) -> bool {
    match asked {
        Output::Occlusion => true,
        Output::T => matches!(output, Output::T | Output::Barycentrics | Output::Normal),
        other => output == other,
    }
}

/// How far a hit is off in what is asked: `t` relatively, barycentrics absolutely.
fn off(asked: Output, hit: &Hit<f64>, exact: &Hit<f64>) -> f64 {
    let t = (hit.t - exact.t).abs();
    let t = if t == 0.0 { 0.0 } else { (t / exact.t.abs()).min(f64::MAX) };
    match asked {
        Output::Barycentrics => {
            t.max((hit.beta - exact.beta).abs()).max((hit.gamma - exact.gamma).abs())
        }
        _ => t,
    }
}

/// The part of a user's rays and triangles that kernels are tried on: rays at random, those triangles
/// that they hit, and of the others some from all over the mesh, in its order.
fn sample(triangles: &[Triangle<f32>], rays: &[Ray<f32>], random: &mut Pcg64) -> Subject {
    let mut rays = rays.to_vec();
    rays.shuffle(random);
    rays.truncate(RAYS);
    let mut chosen = vec![false; triangles.len()];
    let reference = find(REFERENCE).expect("it is in the catalogue");
    let scene = (reference.f32.prepare)(triangles, &rays).expect("the reference takes every mesh");
    let finder = reference.f32.plain_finder(None, None).expect("one is compiled everywhere");
    let mut count = 0;
    finder.find(&scene, Culling::None, &mut |_, triangle, _| {
        // Half of them are left for what is missed, as most of a mesh is.
        if count < TRIANGLES / 2 && !std::mem::replace(&mut chosen[triangle as usize], true) {
            count += 1;
        }
        std::ops::ControlFlow::Continue(())
    });
    let missing = TRIANGLES.min(triangles.len()) - count;
    let rest: Vec<usize> = (0..triangles.len()).filter(|&number| !chosen[number]).collect();
    for place in 0..missing {
        chosen[rest[place * rest.len() / missing]] = true;
    }
    let triangles = triangles.iter().zip(chosen).filter(|(_, chosen)| *chosen);
    let triangles = triangles.map(|(triangle, _)| *triangle).collect();
    let (name, says) = ("mesh".to_owned(), "a part of a mesh, and of its rays".to_owned());
    Subject::new(name, says, Family::Mesh, rays, triangles)
}

/// Races kernels until a few are left, sorted by their median: in each part of the time, which are of
/// one length, all that are left are timed in turn, and the slower half drops out; so those that are
/// hard to tell apart are timed longest.
///
/// Karnin, Koren, Somekh: Almost Optimal Exploration in Multi-Armed Bandits. ICML 2013: sequential
/// halving.
fn race(
    racing: &mut Vec<Racer<'_>>,
    settings: &RecommendSettings,
    random: &mut Pcg64,
    progress: &mut dyn Progress,
) -> Result<(), WrongAnswer> {
    /// Samples that even the slowest is worth: one alone may have been interrupted.
    const FEWEST: usize = 3;
    let halvings = (racing.len() as f64 / FINALISTS as f64).log2().ceil().max(0.0);
    let part = settings.time.as_nanos() as f64 / (halvings + 1.0);
    loop {
        let is_last = racing.len() <= FINALISTS;
        progress.phase(&format!("timing {} kernels", racing.len()), 1);
        timing::rounds(racing, FEWEST, random, |(_, contender), timed| contender.sample(timed))?;
        let round: f64 = racing.iter().map(|(_, contender)| middle(&contender.samples_ns)).sum();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small count"
        )]
        let more = (part / round.max(1.0)) as usize;
        if let Some(more) = more.checked_sub(FEWEST) {
            timing::rounds(racing, more, random, |(_, contender), timed| contender.sample(timed))?;
        }
        racing.sort_by(|(_, a), (_, b)| middle(&a.samples_ns).total_cmp(&middle(&b.samples_ns)));
        progress.step();
        if is_last {
            return Ok(());
        }
        let stay = (racing.len() / 2).max(FINALISTS);
        let beside = racing.iter().position(|(group, _)| Some(group.method) == settings.beside);
        if let Some(place) = beside.filter(|&place| place >= stay) {
            racing.swap(place, stay - 1);
        }
        racing.truncate(stay);
    }
}

/// Measures every kernel, then the fastest of them and the one chosen for longer, all in turn.
fn measure_all<'a>(
    all: &mut Vec<Racer<'a>>,
    (group, kernel): (&Group, &Kernel),
    random: &mut Pcg64,
    progress: &mut dyn Progress,
    candidate: impl Fn(&Racer<'a>) -> Candidate,
) -> Result<Exhaustive, WrongAnswer> {
    const OF_ALL: usize = 15;
    const OF_FASTEST: usize = 301;
    progress.phase(&format!("timing all {} kernels", all.len()), (OF_ALL + OF_FASTEST) as u64);
    let is_chosen =
        |racer: &Racer<'_>| std::ptr::eq(racer.0, group) && std::ptr::eq(racer.1.kernel, kernel);
    let by_median = |(_, a): &Racer<'_>, (_, b): &Racer<'_>| {
        middle(&a.samples_ns).total_cmp(&middle(&b.samples_ns))
    };
    timing::rounds(all, OF_ALL, random, |(_, contender), timed| contender.sample(timed))?;
    all.sort_by(by_median);
    let mut place = 0;
    all.retain(|racer| {
        place += 1;
        place <= 2 * FINALISTS || is_chosen(racer)
    });
    // What was fastest by luck is not so again.
    for (_, contender) in &mut *all {
        contender.samples_ns.clear();
    }
    timing::rounds(all, OF_FASTEST, random, |(_, contender), timed| contender.sample(timed))?;
    all.sort_by(by_median);
    let chosen = all.iter().find(|racer| is_chosen(racer)).expect("it was kept");
    let (best, chosen) = (candidate(&all[0]), candidate(chosen));
    Ok(Exhaustive {
        samples_of_all: OF_ALL,
        samples_of_fastest: OF_FASTEST,
        behind: chosen.ns_per_test / best.ns_per_test - 1.0,
        chosen_ns_per_test: chosen.ns_per_test,
        best,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_gives_more_answers_as_well() {
        assert!(gives(Output::Barycentrics, Output::T));
        assert!(gives(Output::Normal, Output::Occlusion));
        assert!(!gives(Output::T, Output::Barycentrics));
        assert!(!gives(Output::Occlusion, Output::T));
    }

    #[test]
    fn errors_are_relative_of_t_and_absolute_of_weights() {
        let exact = Hit { t: 8.0, beta: 0.25, gamma: 0.0 };
        let hit = Hit { t: 10.0, beta: 0.25, gamma: 0.5 };
        assert_eq!(off(Output::T, &hit, &exact), 0.25);
        assert_eq!(off(Output::Barycentrics, &hit, &exact), 0.5);
        assert_eq!(off(Output::Barycentrics, &exact, &exact), 0.0);
    }

    #[test]
    fn a_sample_holds_what_the_rays_hit() {
        let mesh = trisect_workloads::Mesh::bunny();
        let rays = trisect_workloads::primary(&mesh, 8, 8).rays;
        let mut random = Pcg64::seed_from_u64(1);
        let subject = sample(&mesh.triangles, &rays, &mut random);
        assert_eq!((subject.rays32.len(), subject.triangles32.len()), (64, TRIANGLES));
        assert!(subject.closest.iter().flatten().count() >= 8, "some rays meet the bunny");
        let few = sample(&mesh.triangles[..3], &rays, &mut random);
        assert_eq!(few.triangles32, &mesh.triangles[..3]);
    }
}
