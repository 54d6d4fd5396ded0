//! Methods that claim to be exact, held to it: every decision, every value and every closest triangle
//! against the oracle, on every lane type, in both arrangements and in the tracer. And which of their
//! stages decides.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use trisect_catalog::{Builder, Entry, Finder, Tracing, TriangleHit, Variant};
use trisect_core::{Float, FloatFormat, Hit, Ray, Triangle, Vec3};
use trisect_method::Culling;
use trisect_oracle::Oracle;
use trisect_workloads::{Aim, Feature, Placement, Stress, Surface, bunny, diffuse_bounce, primary};

use super::contract::hostile_scene;
use super::measure::Compiled;
use super::record::{ExactCounts, Exactness, Stages};
use super::settings::Stability;
use crate::record::Line;
use crate::study::Run;

/// Rays, and triangles, of a scene: every ray is made for one of the triangles.
const SIDE: usize = 16;

/// Scenes of each kind that are judged before the tests are counted again.
const ROUND: u64 = 16;

/// The share of the tests that is in f64: a thirty-second, as the truth of each takes far longer.
const SINGLE: u64 = 31;

/// Rays and triangles, each against each.
struct Scene<E> {
    rays: Vec<Ray<E>>,
    triangles: Vec<Triangle<E>>,
}

/// Scenes of one kind, by number.
struct Kind<E> {
    name: String,
    scene: Box<dyn Fn(u64) -> Scene<E> + Sync>,
}

/// The number's place in a list of so many.
fn place(number: u64, count: usize) -> usize {
    usize::try_from(number % count as u64).expect("it is below a usize")
}

/// A surface with what rays are aimed at, where it was made and elsewhere.
struct Aimed {
    surface: Surface,
    features: Vec<Feature>,
}

impl Aimed {
    fn scene<E: Float>(&self, seed: u64, number: u64) -> Scene<E> {
        const PLACES: [(f64, f64); 5] =
            [(1.0, 0.0), (1.0, 1e3), (1.0, 1e6), (1e-9, 0.0), (1e9, 0.0)];
        let (scale, offset) = PLACES[place(number, PLACES.len())];
        // Without zeros, so that every coordinate of a corner is moved.
        let placement = Placement { scale, offset: Vec3::new(0.6, -0.48, 0.64).scale(offset) };
        let number = number / PLACES.len() as u64;
        let feature = &self.features[place(number, self.features.len())];
        let all = self.surface.triangles::<E>(&placement);
        Scene {
            rays: self.surface.aimed(feature, &placement, seed.wrapping_add(number), SIDE),
            triangles: feature.faces.iter().map(|&face| all[face]).collect(),
        }
    }
}

/// All stress families at all levels, random bits, and rays at the edges and corners of surfaces.
fn kinds<E: Float>(seed: u64) -> Vec<Kind<E>> {
    let mut kinds = Vec::new();
    for family in Stress::ALL {
        let levels = family.levels::<E>();
        let scene = move |number: u64| {
            let level = levels[place(number, levels.len())];
            let pairs = family.pairs::<E>(seed.wrapping_add(number), level, SIDE);
            let (rays, triangles) = pairs.into_iter().unzip();
            Scene { rays, triangles }
        };
        kinds.push(Kind { name: family.name().to_owned(), scene: Box::new(scene) });
    }
    let scene = move |number| {
        let mut random = Pcg64::seed_from_u64(seed ^ number << 8);
        let (mut rays, mut triangles) = hostile_scene::<E>(&mut random);
        rays.truncate(SIDE);
        triangles.truncate(SIDE);
        Scene { rays, triangles }
    };
    kinds.push(Kind { name: "hostile-bits".to_owned(), scene: Box::new(scene) });
    for surface in [Surface::sphere(2), Surface::ragged_sphere(seed), Surface::cube(4)] {
        for aim in [Aim::Edges, Aim::Vertices] {
            let name = format!("{}-{}", surface.name, aim.name());
            let aimed = Aimed { features: surface.features(aim), surface: surface.clone() };
            kinds.push(Kind { name, scene: Box::new(move |number| aimed.scene(seed, number)) });
        }
    }
    kinds
}

/// What a ray does to a triangle: `t`, `beta` and `gamma` as bits, −0 and 0 being one answer.
type Answer = Option<[u64; 3]>;

fn bits(hit: Hit<f64>) -> [u64; 3] {
    [hit.t, hit.beta, hit.gamma].map(|x| (x + 0.0).to_bits())
}

/// What is true of a scene.
struct Truth {
    /// Ray by ray.
    answers: Vec<Answer>,
    /// The number of each ray's first triangle.
    closest: Vec<Option<u32>>,
}

impl Truth {
    fn new<E: Float>(scene: &Scene<E>) -> Self {
        let mut oracle = Oracle::default();
        let mut truth = Self { answers: Vec::new(), closest: Vec::new() };
        for ray in &scene.rays {
            let hits = scene.triangles.iter().map(|triangle| {
                let Hit { t, beta, gamma } = oracle.intersect(ray, triangle).hit?;
                let [t, beta, gamma] = [t, beta, gamma].map(|x: E| x.to_f64());
                Some(bits(Hit { t, beta, gamma }))
            });
            truth.answers.extend(hits);
            let closest = oracle.closest(ray, &scene.triangles);
            let number = |place| u32::try_from(place).expect("triangles are few");
            truth.closest.push(closest.map(|(place, _)| number(place)));
        }
        truth
    }
}

/// Counts by way of testing, and the first wrong answer.
#[derive(Clone, Default)]
struct Tally {
    counts: Vec<ExactCounts>,
    first_wrong: Vec<Option<String>>,
}

impl Tally {
    fn new(ways: usize) -> Self {
        Self { counts: vec![ExactCounts::default(); ways], first_wrong: vec![None; ways] }
    }

    fn with(mut self, other: Self) -> Self {
        for (sum, counts) in self.counts.iter_mut().zip(other.counts) {
            sum.add(&counts);
        }
        for (mine, theirs) in self.first_wrong.iter_mut().zip(other.first_wrong) {
            *mine = mine.take().or(theirs);
        }
        self
    }

    /// Holds the answers of a way to the truth.
    fn judge<E: Float>(&mut self, way: usize, scene: &Scene<E>, found: &[Answer], truth: &Truth) {
        let counts = &mut self.counts[way];
        counts.tests += found.len() as u64;
        for (at, (found, truth)) in found.iter().zip(&truth.answers).enumerate() {
            if found != truth {
                let is_decision = found.is_some() != truth.is_some();
                counts.wrong += u64::from(is_decision);
                counts.wrong_values += u64::from(!is_decision);
                let (ray, triangle) = (at / scene.triangles.len(), at % scene.triangles.len());
                self.first_wrong[way].get_or_insert_with(|| {
                    let numbers = |answer: &Answer| answer.map(|x| x.map(f64::from_bits));
                    format!(
                        "{:?} {:?}: {:?} instead of {:?}",
                        scene.rays[ray],
                        scene.triangles[triangle],
                        numbers(found),
                        numbers(truth)
                    )
                });
            }
        }
    }

    /// Holds the first triangles of all rays to the truth.
    fn judge_closest<E: Float>(
        &mut self,
        way: usize,
        scene: &Scene<E>,
        found: impl Iterator<Item = Option<u32>>,
        truth: &Truth,
    ) {
        let counts = &mut self.counts[way];
        for ((found, truth), ray) in found.zip(&truth.closest).zip(&scene.rays) {
            counts.rays += 1;
            if found != *truth {
                counts.wrong_closest += 1;
                self.first_wrong[way].get_or_insert_with(|| {
                    let triangles = &scene.triangles;
                    format!("{ray:?} {triangles:?}: first {found:?} instead of {truth:?}")
                });
            }
        }
    }
}

/// Ways to trace.
const TRACINGS: [(&str, Tracing); 3] =
    [("single", Tracing::Single), ("packets", Tracing::Packets), ("plain", Tracing::Plain)];

/// Judges one scene: by every finder in both arrangements, by one of them for the first triangles, and, in
/// f32, by a tree.
fn judge<E: Compiled>(
    entry: &Entry,
    finders: &[&Finder],
    scene: &Scene<E>,
    number: u64,
    tally: &mut Tally,
) {
    let truth = Truth::new(scene);
    let kernels = E::kernels(entry);
    let Ok(prepared) = (kernels.prepare)(&scene.triangles, &scene.rays) else { return };
    let count = scene.triangles.len();
    let mut answers = vec![None; scene.rays.len() * count];
    for (at, finder) in finders.iter().enumerate() {
        for (way, packets) in [(2 * at, false), (2 * at + 1, true)] {
            answers.fill(None);
            let mut note = |ray: usize, triangle: u32, hit| {
                answers[ray * count + triangle as usize] = Some(bits(hit));
                ControlFlow::Continue(())
            };
            if packets {
                let found = finder.find_packets(&prepared, Culling::None, &mut note);
                found.expect("it is compiled for what claims to be exact");
            } else {
                finder.find(&prepared, Culling::None, &mut note);
            }
            tally.judge(way, scene, &answers, &truth);
        }
    }
    let at = place(number, finders.len());
    let closest = finders[at].closest(&prepared, Culling::None, scene.rays.len());
    let closest = closest.into_iter().map(|found| found.map(|(triangle, _)| triangle));
    tally.judge_closest(2 * at, scene, closest, &truth);
    if E::FORMAT != FloatFormat::F32 {
        return;
    }
    #[allow(clippy::cast_possible_truncation, reason = "it is a number of f32")]
    let single = |x: &E| x.to_f64() as f32;
    let rays: Vec<Ray<f32>> = scene.rays.iter().map(|ray| ray.map(single)).collect();
    let triangles: Vec<Triangle<f32>> =
        scene.triangles.iter().map(|triangle| triangle.map(single)).collect();
    let builder = Builder::ALL[place(number, Builder::ALL.len())];
    let Ok(tree) = entry.tree(&triangles, builder) else { return };
    for (at, (_, tracing)) in TRACINGS.into_iter().enumerate() {
        let mut found: Vec<Option<TriangleHit>> = vec![None; rays.len()];
        tree.closest(tracing, Culling::None, &rays, &mut found);
        let found = found.into_iter().map(|found| found.map(|found| found.triangle));
        tally.judge_closest(2 * finders.len() + at, scene, found, &truth);
    }
}

/// Holds a method to the truth until there were so many tests: a record per way of testing. Each kind of scene is a part
/// of the study, and their tests are counted whoever does them.
fn hold<E: Compiled>(seed: u64, entry: &Entry, tests: u64, run: &mut Run<'_>) {
    let finders: Vec<&Finder> =
        E::kernels(entry).finders.iter().filter(|finder| finder.variant.is_available()).collect();
    let mut ways: Vec<String> = Vec::new();
    for finder in &finders {
        let Variant { precision, width, instruction_set, arithmetic, .. } = &finder.variant;
        let lanes = format!("{precision}x{width} {instruction_set} {arithmetic}");
        ways.extend([format!("{lanes} one-ray"), format!("{lanes} one-triangle")]);
    }
    if E::FORMAT == FloatFormat::F32 {
        ways.extend(TRACINGS.map(|(name, _)| format!("tree {name}")));
    }
    let kinds = kinds::<E>(seed);
    let (part, is_mine) = run.deal(kinds.len());
    if !is_mine.contains(&true) {
        return;
    }
    let mut tallies = vec![Tally::new(ways.len()); kinds.len()];
    let mut first = 0;
    let mut done = 0;
    while done < tests {
        let round: Vec<(usize, u64, Tally)> = (0..kinds.len() as u64 * ROUND)
            .into_par_iter()
            .map(|at| {
                let (kind, number) = (place(at, kinds.len()), first + at / kinds.len() as u64);
                let scene = (kinds[kind].scene)(number);
                let mut tally = Tally::new(ways.len());
                if is_mine[kind] {
                    judge::<E>(entry, &finders, &scene, number, &mut tally);
                }
                // In two arrangements.
                let pairs = scene.rays.len() * scene.triangles.len();
                (kind, (2 * finders.len() * pairs) as u64, tally)
            })
            .collect();
        let before = done * 100 / tests;
        for (kind, tests, tally) in round {
            tallies[kind] = std::mem::take(&mut tallies[kind]).with(tally);
            done += tests;
        }
        first += ROUND;
        for _ in before..(done * 100 / tests).min(100) {
            run.progress.step();
        }
    }
    run.begin(part);
    for (way, name) in ways.into_iter().enumerate() {
        let mine = kinds.iter().zip(&tallies).zip(&is_mine).filter(|(_, is_mine)| **is_mine);
        let by_name: BTreeMap<&String, &Tally> =
            mine.map(|((kind, tally), _)| (&kind.name, tally)).collect();
        run.add(Exactness {
            method: entry.info.name.to_owned(),
            precision: E::FORMAT,
            way: name,
            first_wrong: by_name.values().find_map(|tally| tally.first_wrong[way].clone()),
            kinds: by_name
                .into_iter()
                .map(|(kind, tally)| (kind.clone(), tally.counts[way]))
                .collect(),
        });
    }
}

/// Holds every method that claims to be exact to it.
pub(super) fn exactness(settings: &Stability, run: &mut Run<'_>) {
    for entry in settings.methods.iter().filter(|entry| entry.info.claims.exact) {
        run.progress.phase("stress: exact decisions", 200);
        let single = settings.exact / (SINGLE + 1) * SINGLE;
        hold::<f32>(settings.seed, entry, single, run);
        hold::<f64>(settings.seed, entry, settings.exact - single, run);
    }
}

/// Rays of a scene whose lanes are counted, about.
const RAYS: usize = 64;

/// Which stage decides, of methods that have several: on the pairs of each family, and for rays against all
/// triangles of scenes.
pub(super) fn stages(settings: &Stability, run: &mut Run<'_>) {
    let staged: Vec<&Entry> =
        settings.methods.iter().copied().filter(|entry| !entry.stages.is_empty()).collect();
    run.each("stress: stages", staged.into_iter(), |entry| {
        let mut lines = of_families::<f32>(settings, entry);
        lines.extend(of_families::<f64>(settings, entry));
        lines.extend(of_scenes(settings.seed, entry));
        lines
    });
}

fn counted<E: Compiled>(
    entry: &Entry,
    source: &str,
    pairs: impl ParallelIterator<Item = (Ray<E>, Triangle<E>)>,
) -> Line {
    let stage = E::kernels(entry).stage;
    let none = || vec![0; entry.stages.len()];
    let one = |mut counts: Vec<u64>, (ray, triangle): (Ray<E>, Triangle<E>)| {
        counts[stage(&ray, &triangle)] += 1;
        counts
    };
    let sum = |mut a: Vec<u64>, b: Vec<u64>| {
        for (a, b) in a.iter_mut().zip(b) {
            *a += b;
        }
        a
    };
    Line::from(Stages {
        method: entry.info.name.to_owned(),
        precision: E::FORMAT,
        source: source.to_owned(),
        stages: entry.stages.iter().map(ToString::to_string).collect(),
        pairs: pairs.fold(none, one).reduce(none, sum),
    })
}

fn of_families<E: Compiled>(settings: &Stability, entry: &Entry) -> Vec<Line> {
    let families = Stress::ALL.into_iter().map(|family| {
        let levels = family.levels::<E>();
        let pairs: Vec<_> = levels
            .into_iter()
            .flat_map(|level| family.pairs::<E>(settings.seed, level, settings.pairs))
            .collect();
        counted::<E>(entry, family.name(), pairs.into_par_iter())
    });
    families.collect()
}

/// Random rays, and the bunny's: from a camera, and diffuse ones from where those hit.
fn of_scenes(seed: u64, entry: &Entry) -> Vec<Line> {
    let bunny = bunny();
    let mut scenes = vec![("random", trisect_workloads::random(seed, RAYS, 2000))];
    if let Ok(tree) = entry.tree(&bunny.triangles, Builder::default()) {
        let mut closest = |ray: &Ray<f32>| {
            let mut found = [None];
            tree.closest(Tracing::Single, Culling::None, &[*ray], &mut found);
            found[0].map(|TriangleHit { triangle, hit }| (triangle as usize, hit))
        };
        let diffuse = diffuse_bounce(seed, &bunny, 32, 32, &mut closest);
        scenes.extend([("bunny/camera", primary(&bunny, 32, 32)), ("bunny/diffuse", diffuse)]);
    }
    let records = scenes.into_iter().map(|(name, workload)| {
        let step = (workload.rays.len() / RAYS).max(1);
        let rays: Vec<Ray<f32>> = workload.rays.iter().copied().step_by(step).collect();
        let triangles = &workload.triangles;
        let pairs =
            rays.par_iter().flat_map_iter(|ray| triangles.iter().map(|triangle| (*ray, *triangle)));
        counted::<f32>(entry, name, pairs)
    });
    records.collect()
}
