//! The contract of docs/CONTRACT.md, put to hostile input: every kernel of every method on random
//! bits, on numbers at the ends of their range, on degenerate triangles.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use rand::{Rng, RngExt};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use trisect_catalog::{Entry, Finder, Kernels, Scene, Variant};
use trisect_core::{Float, Hit, Precision, Ray, Scalar, Triangle, Vec3};
use trisect_method::{Culling, Form, ReciprocalKind};
use trisect_oracle::{Class, Oracle};

use super::measure::{Compiled, flushing_variant, weighs};
use super::record::{Clause, Contract, Outcome, SpecialValues};
use super::settings::Stability;
use crate::record::Line;
use crate::study::Run;

/// Rays, and triangles, of a scene of hostile input.
const SIDE: usize = 64;

/// Puts every method to the contract.
pub(super) fn contract(settings: &Stability, run: &mut Run<'_>) {
    // Both precisions share the tests.
    let each = settings.fuzz / 2 / settings.methods.len().max(1) as u64;
    run.each("stress: hostile input", settings.methods.iter(), |entry| {
        let mut lines = fuzz::<f32>(settings.seed, entry, each);
        lines.extend(fuzz::<f64>(settings.seed, entry, each));
        lines.extend(special_values(settings.seed, entry));
        lines
    });
}

/// Tests and violations of each clause, by clause.
type Tally = BTreeMap<Clause, [u64; 2]>;

fn count(tally: &mut Tally, clause: Clause, tests: u64, violations: u64) {
    let counts = tally.entry(clause).or_default();
    counts[0] += tests;
    counts[1] += violations;
}

/// Every finder, and every kernel, on scenes of hostile input, until there were so many tests.
fn fuzz<E: Compiled>(seed: u64, entry: &Entry, tests: u64) -> Vec<Line> {
    let kernels = E::kernels(entry);
    let finders: Vec<&Finder> =
        kernels.finders.iter().filter(|finder| finder.variant.is_available()).collect();
    let per_scene = (finders.len() + kernels.timed.len()) * SIDE * SIDE;
    let scenes = tests.div_ceil(per_scene as u64);
    let tallies: Vec<Vec<Tally>> = (0..scenes)
        .into_par_iter()
        .map(|number| {
            let mut random = Pcg64::new(u128::from(seed), u128::from(number));
            let (rays, triangles) = hostile_scene::<E>(&mut random);
            test_scene(kernels, weighs(entry), &finders, &rays, &triangles)
        })
        .collect();
    let mut sums = vec![Tally::new(); finders.len()];
    for tallies in tallies {
        for (sum, tally) in sums.iter_mut().zip(tallies) {
            for (clause, [tests, violations]) in tally {
                count(sum, clause, tests, violations);
            }
        }
    }
    finders
        .iter()
        .zip(sums)
        .map(|(finder, clauses)| Line::from(Contract { variant: finder.variant.clone(), clauses }))
        .collect()
}

/// The tallies of the finders on one scene; nothing where the method refuses it.
fn test_scene<E: Precision>(
    kernels: &Kernels<E>,
    weighs: bool,
    finders: &[&Finder],
    rays: &[Ray<E>],
    triangles: &[Triangle<E>],
) -> Vec<Tally> {
    let mut tallies = vec![Tally::new(); finders.len()];
    let Ok(scene) = (kernels.prepare)(triangles, rays) else { return tallies };
    let pairs = (rays.len() * triangles.len()) as u64;
    let mut found: Vec<Vec<(usize, u32, Hit<f64>)>> = Vec::new();
    for (finder, tally) in finders.iter().zip(&mut tallies) {
        let mut hits = Vec::new();
        finder.find(&scene, Culling::None, &mut |ray, triangle, hit| {
            hits.push((ray, triangle, hit));
            ControlFlow::Continue(())
        });
        hits.sort_unstable_by_key(|&(ray, triangle, _)| (ray, triangle));
        judge(slack::<E>(&finder.variant), weighs, (rays, triangles), &hits, tally);
        same_decisions(kernels, finder, &scene, hits.len() as u64, pairs, tally);
        found.push(hits);
    }
    // Of finders that compute alike, the narrowest is the one that all others must equal.
    for (place, finder) in finders.iter().enumerate() {
        let first = finders
            .iter()
            .position(|other| other.variant.rounds_like(&finder.variant))
            .unwrap_or(place);
        let differ = found[first].len().abs_diff(found[place].len())
            + found[first].iter().zip(&found[place]).filter(|(a, b)| !is_same(a, b)).count();
        if first != place {
            count(&mut tallies[place], Clause::SameBits, pairs, differ as u64);
        }
    }
    tallies
}

fn is_same(a: &(usize, u32, Hit<f64>), b: &(usize, u32, Hit<f64>)) -> bool {
    let bits = |hit: &Hit<f64>| [hit.t, hit.beta, hit.gamma].map(f64::to_bits);
    (a.0, a.1) == (b.0, b.1) && bits(&a.2) == bits(&b.2)
}

/// Judges each hit by the clauses about one ray and one triangle.
fn judge<E: Precision>(
    slack: f64,
    weighs: bool,
    (rays, triangles): (&[Ray<E>], &[Triangle<E>]),
    hits: &[(usize, u32, Hit<f64>)],
    tally: &mut Tally,
) {
    let mut oracle = Oracle::default();
    let mut broken = [0_u64; 5];
    for &(ray, triangle, hit) in hits {
        let ray = &rays[ray];
        let class = oracle.classify(ray, &triangles[triangle as usize]);
        let is_still = ray.d.map(Scalar::to_f64) == Vec3::new(0.0, 0.0, 0.0);
        let Hit { t, beta, gamma } = hit;
        let given = if weighs { &[t, beta, gamma][..] } else { &[t] };
        let finite = given.iter().all(|x| x.is_finite());
        let [tmin, tmax] = [ray.tmin, ray.tmax].map(Scalar::to_f64);
        let room = slack * t.abs().max(1.0);
        let in_time = tmin - room <= t && t <= tmax + room;
        let violations =
            [!finite, class == Class::NonFinite, class == Class::Degenerate, is_still, !in_time];
        for (sum, violation) in broken.iter_mut().zip(violations) {
            *sum += u64::from(violation);
        }
    }
    let clauses = [
        Clause::FiniteHits,
        Clause::NotFiniteMisses,
        Clause::DegenerateMisses,
        Clause::ZeroDirectionMisses,
        Clause::WithinInterval,
    ];
    for (clause, violations) in clauses.into_iter().zip(broken) {
        count(tally, clause, (rays.len() * triangles.len()) as u64, violations);
    }
}

/// How far outside the interval the `t` of a hit may lie, relative to itself or to 1, whichever is
/// larger.
///
/// The early form compares what it hands out. The deferred one decides before it divides, and rounds
/// three times after: in the reciprocal, in its product, and in the comparison that decided. Of
/// numerators that are subnormal the unit is absolute, and worth at most that much of the smallest
/// denominator. Newton's reciprocal is a few units more off.
fn slack<E: Precision>(variant: &Variant) -> f64 {
    let roundings = match (variant.division, variant.reciprocal) {
        (Form::Early, _) => 0.0,
        (Form::Deferred, ReciprocalKind::True) => 3.0,
        (Form::Deferred, ReciprocalKind::Newton) => 9.0,
    };
    roundings * 2.0 * E::UNIT_ROUNDOFF
}

/// Every kernel that the finder answers for, whatever it is asked for and however it is
/// arranged, must count the finder's hits: so any-hit and closest-hit agree.
fn same_decisions<E: Precision>(
    kernels: &Kernels<E>,
    finder: &Finder,
    scene: &Scene,
    hits: u64,
    pairs: u64,
    tally: &mut Tally,
) {
    let alike = kernels.answered_by(finder).filter(|kernel| {
        kernel.variant.is_available() && kernel.variant.arrangement.serves(scene.common())
    });
    for kernel in alike {
        let differ = kernel.run(scene).hits.abs_diff(hits);
        count(tally, Clause::SameDecisions, pairs, differ);
    }
}

/// Numbers of all kinds: any bits, powers of two over the whole range, and the ends of it.
fn hostile<E: Float>(random: &mut Pcg64) -> E {
    let bits = E::from_upper_bits(random.next_u64()).bits64();
    match random.random_range(0..8_u8) {
        0..=2 => E::from_bits64(bits),
        // The exponent of any bits, with nothing behind it.
        3 => E::from_bits64(bits & !((1 << (E::SIGNIFICANT_BITS - 1)) - 1)),
        4 => E::from_f64(0.0),
        5 => E::from_f64(-0.0),
        6 => E::from_f64(f64::from(random.random_range(-4..=4_i8))),
        // The smallest numbers there are.
        _ => E::from_bits64(bits & 0xff),
    }
}

/// Rays and triangles of hostile numbers; every other ray aimed at one of the triangles, every fourth
/// triangle degenerate, and every other ray with an open interval.
pub(super) fn hostile_scene<E: Float>(random: &mut Pcg64) -> (Vec<Ray<E>>, Vec<Triangle<E>>) {
    let tame = random.random_range(0..2_u8) == 0;
    let number = |random: &mut Pcg64| {
        if tame {
            E::from_f64(f64::from(random.random_range(-64..=64_i8)))
        } else {
            hostile(random)
        }
    };
    let vector = |random: &mut Pcg64| Vec3::new(number(random), number(random), number(random));
    let triangles: Vec<Triangle<E>> = (0..SIDE)
        .map(|place| {
            let (a, b, c) = (vector(random), vector(random), vector(random));
            match place % 8 {
                0 => Triangle { a, b: a, c },
                // On a line, as far as the sum does not round.
                1 => Triangle { a, b, c: b + (b - a) },
                _ => Triangle { a, b, c },
            }
        })
        .collect();
    let rays = (0..SIDE)
        .map(|place| {
            let (o, d) = (vector(random), vector(random));
            let Triangle { a, b, c } = triangles[random.random_range(0..SIDE)];
            let half = E::from_f64(0.5);
            let d = match place % 4 {
                0 => (a + b).scale(half) - o,
                1 => (a + b).scale(half * half) + c.scale(half) - o,
                2 => d,
                _ if place % 8 == 3 => d.map(|_| E::from_f64(0.0)),
                _ => a - o,
            };
            let (tmin, tmax) = if place % 2 == 0 {
                (E::from_f64(f64::NEG_INFINITY), E::from_f64(f64::INFINITY))
            } else {
                (hostile(random), hostile(random))
            };
            Ray { o, d, tmin, tmax }
        })
        .collect();
    (rays, triangles)
}

/// Values that take the place of one number of a pair that is hit clearly.
const SPECIAL: [(&str, f32); 9] = [
    ("NaN", f32::NAN),
    ("inf", f32::INFINITY),
    ("-inf", f32::NEG_INFINITY),
    ("0", 0.0),
    ("-0", -0.0),
    ("smallest subnormal", 1e-45),
    ("subnormal", 1e-39),
    ("smallest normal", f32::MIN_POSITIVE),
    ("largest", f32::MAX),
];

/// Where a number stands in a ray or a triangle, of the seventeen that there are.
fn place_name(place: usize) -> &'static str {
    match place {
        0..3 => "origin",
        3..6 => "direction",
        6 => "tmin",
        7 => "tmax",
        _ => "corner",
    }
}

fn with_number(
    pair: &(Ray<f32>, Triangle<f32>),
    place: usize,
    x: f32,
) -> (Ray<f32>, Triangle<f32>) {
    let (mut ray, mut triangle) = *pair;
    let [a, b, c] = [&mut triangle.a, &mut triangle.b, &mut triangle.c];
    let all = [
        &mut ray.o.x,
        &mut ray.o.y,
        &mut ray.o.z,
        &mut ray.d.x,
        &mut ray.d.y,
        &mut ray.d.z,
        &mut ray.tmin,
        &mut ray.tmax,
        &mut a.x,
        &mut a.y,
        &mut a.z,
        &mut b.x,
        &mut b.y,
        &mut b.z,
        &mut c.x,
        &mut c.y,
        &mut c.z,
    ];
    if let Some(number) = all.into_iter().nth(place) {
        *number = x;
    }
    (ray, triangle)
}

/// A test of one pair.
type Test<'a> = Box<dyn Fn(&Ray<f32>, &Triangle<f32>) -> bool + 'a>;

/// What special values do, with subnormal numbers kept and flushed to zero.
fn special_values(seed: u64, entry: &Entry) -> Vec<Line> {
    const PAIRS: usize = 16;
    let pairs = trisect_workloads::Stress::Scale.pairs::<f32>(seed, 1.0, PAIRS);
    let scalar = entry.f32.finders.iter().filter(|f| f.variant.width == 1);
    let kept = scalar.map(|finder| {
        let test = move |ray: &Ray<f32>, triangle: &Triangle<f32>| {
            (entry.f32.prepare)(&[*triangle], &[*ray])
                .is_ok_and(|scene| finder.any(&scene, Culling::None, 1)[0])
        };
        (finder.variant.clone(), false, Box::new(test) as Test<'_>)
    });
    let flushed = entry.flushing.iter().map(|(division, test)| {
        let test = move |ray: &Ray<f32>, triangle: &Triangle<f32>| test(ray, triangle).is_some();
        (flushing_variant(entry, *division), true, Box::new(test) as Test<'_>)
    });
    kept.chain(flushed)
        .map(|(variant, flush_to_zero, test)| {
            let outcomes = outcomes(&test, &pairs);
            Line::from(SpecialValues { variant, flush_to_zero, outcomes })
        })
        .collect()
}

fn outcomes(test: &Test<'_>, pairs: &[(Ray<f32>, Triangle<f32>)]) -> Vec<Outcome> {
    let mut oracle = Oracle::default();
    let mut outcomes: BTreeMap<(usize, &str), Outcome> = BTreeMap::new();
    for (number, (name, value)) in SPECIAL.into_iter().enumerate() {
        for place in 0..17 {
            let outcome = outcomes.entry((number, place_name(place))).or_insert_with(|| Outcome {
                value: name.to_owned(),
                place: place_name(place).to_owned(),
                tests: 0,
                hits: 0,
                false_hits: 0,
                false_misses: 0,
            });
            for pair in pairs {
                let (ray, triangle) = with_number(pair, place, value);
                let found = test(&ray, &triangle);
                let truth = oracle.classify(&ray, &triangle).is_hit();
                outcome.tests += 1;
                outcome.hits += u64::from(found);
                outcome.false_hits += u64::from(found && !truth);
                outcome.false_misses += u64::from(!found && truth);
            }
        }
    }
    outcomes.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The violations of each clause among hits that a broken kernel might hand out.
    fn violations(ray: Ray<f32>, triangle: Triangle<f32>, hit: Hit<f64>) -> Vec<Clause> {
        let mut tally = Tally::new();
        judge(1e-6, true, (&[ray], &[triangle]), &[(0, 0, hit)], &mut tally);
        assert!(tally.values().all(|[tests, _]| *tests == 1));
        tally
            .into_iter()
            .filter(|(_, [_, broken])| *broken == 1)
            .map(|(clause, _)| clause)
            .collect()
    }

    #[test]
    fn each_clause_is_violated_by_what_it_forbids() {
        let ray = Ray::<f32>::new([0.25, 0.25, -1.0], [0.0, 0.0, 1.0]);
        let triangle = Triangle::<f32>::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let hit = Hit { t: 1.0, beta: 0.25, gamma: 0.25 };
        assert_eq!(violations(ray, triangle, hit), []);
        let nan = Hit { beta: f64::NAN, ..hit };
        assert_eq!(violations(ray, triangle, nan), [Clause::FiniteHits]);
        let infinite = Ray { o: Vec3 { x: f32::INFINITY, ..ray.o }, ..ray };
        assert_eq!(violations(infinite, triangle, hit), [Clause::NotFiniteMisses]);
        let line = Triangle { c: triangle.b.scale(2.0), ..triangle };
        assert_eq!(violations(ray, line, hit), [Clause::DegenerateMisses]);
        let still = Ray { d: Vec3::new(0.0, -0.0, 0.0), ..ray };
        assert_eq!(violations(still, triangle, hit), [Clause::ZeroDirectionMisses]);
        let short = Ray { tmax: 0.999, ..ray };
        assert_eq!(violations(short, triangle, hit), [Clause::WithinInterval]);
    }

    #[test]
    fn special_values_reach_every_number() {
        let ray = Ray::<f32>::new([1.0; 3], [1.0; 3]);
        let triangle = Triangle::<f32>::new([1.0; 3], [1.0; 3], [1.0; 3]);
        let changed: Vec<&str> = (0..17)
            .map(|place| {
                let (ray2, triangle2) = with_number(&(ray, triangle), place, 7.0);
                assert!(ray2 != ray || triangle2 != triangle);
                place_name(place)
            })
            .collect();
        let count = |name| changed.iter().filter(|found| **found == name).count();
        let counts = ["origin", "direction", "tmin", "tmax", "corner"].map(count);
        assert_eq!(counts, [3, 3, 1, 1, 9]);
    }
}
