//! All hits, their number, what a program accepts and where points are, against rational arithmetic.

mod common;

use std::cmp::Ordering;

use common::rays_of;
use trisect_core::{Float, Hit, Ray, Scalar, Triangle, Vec3};
use trisect_exact::{Exact, ExactInTrees, point_in_solid};
use trisect_method::{Culling, Method, Place};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_oracle::{Class, Exact as Rational, Oracle, compare_t};
use trisect_tracer::{
    AllHits, Builder, Bvh, Crossings, ErasedBvh, EveryTriangle, NotExact, Precision, ScalarBvh,
    Tracing, Tree, TriangleHit, Verdict,
};
use trisect_wald::Wald;
use trisect_watertight::Watertight;
use trisect_workloads::{Placement, Stream, Surface, bunny};

/// Triangles on a grid of numbers, so that rays meet edges and corners exactly.
struct Scene<P> {
    name: &'static str,
    triangles: Vec<Triangle<P>>,
    /// The middle and the size of what rays and points are drawn from, and the distance of its numbers.
    around: (Vec3<P>, f64, f64),
    /// Whether a line enters as often as it leaves.
    is_closed: bool,
}

/// A whole number of steps up to `most`.
fn number<P: Float>(stream: &mut Stream, most: f64, step: f64) -> P {
    let most = most / step;
    P::from_f64(stream.range_f64(-most, most).round() * step)
}

fn vector<P: Float>(stream: &mut Stream, most: f64, step: f64) -> Vec3<P> {
    [0, 1, 2].map(|_| number(stream, most, step)).into()
}

fn surface<P: Float>(surface: &Surface, scale: f64, offset: Vec3<f64>) -> Vec<Triangle<P>> {
    surface.triangles(&Placement { scale, offset })
}

fn turned<P: Float>(triangle: &Triangle<P>) -> Triangle<P> {
    Triangle { b: triangle.c, c: triangle.b, ..*triangle }
}

fn scenes<P: Precision>(stream: &mut Stream) -> Vec<Scene<P>> {
    // The fraction is lost in f32.
    let fraction = 2.0_f64.powi(-20);
    let far = Vec3::new(500_000.0 + fraction, 4_649_776.0 + fraction, 320.0);
    let (zero, number) = (Vec3::new(0.0, 0.0, 0.0), P::from_f64);
    let lattice = (0..300)
        .map(|_| {
            let corners = [0, 1, 2].map(|_| vector(stream, 4.0, 1.0));
            Triangle { a: corners[0], b: corners[1], c: corners[2] }
        })
        .collect();
    // Long ones among small ones, so that space is split.
    let hall = (0..800)
        .map(|place| {
            let (long, step) = if place % 10 == 0 { (16.0, 1.0) } else { (1.0, 0.5) };
            let a: Vec3<P> = vector(stream, 16.0, 1.0);
            let b = a.scale(number(1.0 - long / 16.0)) + vector(stream, long, step);
            Triangle { a, b, c: b + Vec3::new(0.5, -0.5, 0.25).map(number) }
        })
        .collect();
    // Their distances round to few numbers.
    let layers = (0..60_u32)
        .flat_map(|layer| {
            let z = number(1.0 + f64::from(layer) * 2.0 * P::UNIT_ROUNDOFF);
            let square = surface(&Surface::square(2), 2.0, zero);
            square.into_iter().map(move |triangle| {
                let up = |v: Vec3<P>| Vec3::new(v.x, v.y, z);
                Triangle { a: up(triangle.a), b: up(triangle.b), c: up(triangle.c) }
            })
        })
        .collect();
    let cube = |divisions, scale| surface(&Surface::cube(divisions), scale, zero);
    let coincident = cube(2, 2.0).repeat(8);
    let sheet = cube(4, 2.0);
    let doubled = sheet.iter().copied().chain(sheet.iter().map(turned)).collect();
    let cavity = cube(4, 4.0)
        .into_iter()
        .chain(cube(2, 2.0).iter().map(turned))
        .chain(cube(1, 1.0))
        .collect();
    let utm = surface(&Surface::cube(8), 64.0, far);
    let scene = |name, triangles, (middle, size, step): (Vec3<f64>, _, _), is_closed| {
        let around = (middle.map(number), size, step);
        Scene { name, triangles, around, is_closed }
    };
    vec![
        scene("lattice", lattice, (zero, 6.0, 0.25), false),
        scene("hall", hall, (zero, 20.0, 0.25), false),
        scene("layered", layers, (Vec3::new(0.0, 0.0, 1.0), 3.0, 0.25), false),
        scene("coincident", coincident, (zero, 3.0, 0.25), true),
        scene("doubled", doubled, (zero, 3.0, 0.25), true),
        scene("cavity", cavity, (zero, 5.0, 0.25), true),
        scene("utm", utm, (far, 96.0, 0.5), true),
    ]
}

/// Rays at corners, at middles of edges and anywhere, some of them lines, and some that end at what they are aimed at.
fn rays<P: Precision>(stream: &mut Stream, scene: &Scene<P>, count: usize) -> Vec<Ray<P>> {
    let (middle, size, step) = scene.around;
    (0..count)
        .map(|_| {
            let o = middle + vector(stream, size, step);
            let place = stream.bits() % scene.triangles.len() as u64;
            let Triangle { a, b, .. } = scene.triangles[usize::try_from(place).unwrap_or(0)];
            let target = match stream.bits() % 4 {
                0 => a,
                1 => a + (b - a).scale(P::from_f64(0.5)),
                _ => middle + vector(stream, size, step),
            };
            let ray = Ray::new(o, target - o);
            match stream.bits() % 4 {
                0 => Ray { tmin: P::from_f64(f64::NEG_INFINITY), ..ray },
                1 => Ray { tmax: P::from_f64(1.0), ..ray },
                _ => ray,
            }
        })
        .collect()
}

fn rational<P: Float>(v: Vec3<P>) -> Vec3<Rational> {
    v.map(|x| Scalar::from_f64(x.to_f64()))
}

/// Whether a ray meets the inside of a triangle once it is moved by a tiny number, its square and its cube.
fn is_owner<P: Float>(ray: &Ray<P>, triangle: &Triangle<P>) -> bool {
    Rational::scope(|| {
        let tiny = [-200, -400, -600].map(|exponent| 2.0_f64.powi(exponent));
        let o = rational(ray.o) + Vec3::from(tiny.map(Scalar::from_f64));
        let [a, b, c] = triangle.corners().map(|corner| rational(corner) - o);
        let d = rational(ray.d);
        let zero = Scalar::from_f64(0.0);
        let signs = [a.cross(b), b.cross(c), c.cross(a)]
            .map(|normal| d.dot(normal).partial_cmp(&zero).expect("rationals are in order"));
        signs[0] != Ordering::Equal && signs == [signs[0]; 3]
    })
}

fn is_seen<P: Float>(ray: &Ray<P>, triangle: &Triangle<P>, culling: Culling) -> bool {
    Rational::scope(|| {
        let [a, b, c] = triangle.corners().map(rational);
        let along = rational(ray.d).dot((b - a).cross(c - a));
        let zero = Scalar::from_f64(0.0);
        match culling {
            Culling::None => true,
            Culling::Back => along < zero,
            Culling::Front => along > zero,
        }
    })
}

/// A triangle's id, `t`, `beta` and `gamma`; −0 and 0 are one answer.
type Answer = (u32, [f64; 3]);

fn answer<P: Float>(&TriangleHit { triangle, hit }: &TriangleHit<P>) -> Answer {
    let Hit { t, beta, gamma } = hit;
    (triangle, [t, beta, gamma].map(|x| x.to_f64() + 0.0))
}

/// All hits in their exact order, and whether each is owned.
fn truth<P: Precision>(
    oracle: &mut Oracle,
    scene: &Scene<P>,
    ray: &Ray<P>,
    culling: Culling,
) -> Vec<(TriangleHit<P>, bool)> {
    let mut hits = vec![];
    for (id, triangle) in (0..).zip(&scene.triangles) {
        let answer = oracle.intersect(ray, triangle);
        if let Some(hit) = answer.hit
            && is_seen(ray, triangle, culling)
        {
            let owned =
                oracle.classify(ray, triangle) == Class::Interior || is_owner(ray, triangle);
            hits.push((TriangleHit { triangle: id, hit }, owned));
        }
    }
    hits.sort_by(|(a, _), (b, _)| {
        let [first, second] = [a, b].map(|hit| &scene.triangles[hit.triangle as usize]);
        compare_t(ray, first, second).expect("both are hit").then(a.triangle.cmp(&b.triangle))
    });
    hits
}

/// The next number that is larger in magnitude, or smaller if there is one.
fn next<P: Float>(x: P, is_larger: bool) -> P {
    let bits = x.bits64();
    let is_zero = x.to_f64() == 0.0;
    P::from_bits64(if is_larger || is_zero { bits + 1 } else { bits - 1 })
}

/// Where a point is, by a ray in no particular direction.
fn true_place<P: Precision>(oracle: &mut Oracle, scene: &Scene<P>, point: Vec3<P>) -> Place {
    let zero = P::from_f64(0.0);
    let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|d| Ray {
        o: point,
        d: Vec3::from(d).map(P::from_f64),
        tmin: zero,
        tmax: zero,
    });
    let mut crossings = 0;
    let ray = Ray::new(point, Vec3::new(3.0, -5.0, 0.5).map(P::from_f64));
    for triangle in &scene.triangles {
        if still.iter().any(|ray| oracle.classify(ray, triangle).is_hit()) {
            return Place::On;
        }
        let is_hit = oracle.classify(&ray, triangle).is_hit();
        crossings += usize::from(is_hit && is_owner(&ray, triangle));
    }
    if crossings % 2 == 1 { Place::Inside } else { Place::Outside }
}

/// Trees, by name, and how they are traced.
type Trees<P> = Vec<(String, Box<dyn Tree<P>>, Tracing)>;

/// Every kind of tree.
fn trees(triangles: &[Triangle<f32>]) -> Trees<f32> {
    let mut trees: Trees<f32> = vec![];
    for builder in Builder::ALL {
        for tracing in [Tracing::Single, Tracing::Plain] {
            let tree = ErasedBvh::build::<ExactInTrees>(triangles, builder).expect("it takes all");
            trees.push((format!("{builder}, {tracing:?}"), Box::new(tree), tracing));
        }
    }
    let tree = Bvh::<Exact>::build(triangles, Builder::Spatial).expect("it takes all");
    trees.push(("in the loop".into(), Box::new(tree), Tracing::Packets));
    let tree = ScalarBvh::<ExactInTrees>::build(triangles, Builder::Spatial).expect("it takes all");
    trees.push(("scalar".into(), Box::new(tree), Tracing::Plain));
    let every = EveryTriangle::<Exact>::new(triangles).expect("it takes all");
    trees.push(("no tree".into(), Box::new(every), Tracing::Plain));
    trees
}

/// The same in f64.
fn trees_f64(triangles: &[Triangle<f64>]) -> Trees<f64> {
    let mut trees: Trees<f64> = vec![];
    for builder in Builder::ALL {
        for tracing in [Tracing::Single, Tracing::Plain] {
            let tree = Bvh::<ExactInTrees, f64>::build(triangles, builder).expect("it takes all");
            trees.push((format!("{builder}, {tracing:?}"), Box::new(tree), tracing));
        }
    }
    trees
}

/// How many answers there were, how many were wrong, and how many were of rays that met an edge or a corner.
#[derive(Debug, Default)]
struct Total {
    answers: usize,
    wrong: usize,
    shared: usize,
}

impl Total {
    fn hold(&mut self, is_right: bool, what: impl FnOnce() -> String) {
        self.answers += 1;
        if !is_right {
            self.wrong += 1;
            println!("wrong: {}", what());
        }
    }
}

/// Holds what each tree answers to so many rays and points of each scene to the truth. An answer is right if
/// that of every tree is.
fn check<P: Precision>(
    seed: u64,
    count: usize,
    trees: impl Fn(&[Triangle<P>]) -> Trees<P>,
) -> Total {
    let (mut total, mut oracle) = (Total::default(), Oracle::default());
    let mut stream = Stream::new("tracer/hits", seed);
    for scene in scenes::<P>(&mut stream) {
        let trees = trees(&scene.triangles);
        let split =
            trees.iter().any(|(_, tree, _)| tree.statistics().references > scene.triangles.len());
        assert!(split || scene.name != "hall", "space is split there");
        for ray in rays(&mut stream, &scene, count) {
            let culling = match stream.bits() % 4 {
                0 => Culling::Back,
                1 => Culling::Front,
                _ => Culling::None,
            };
            let truth = truth(&mut oracle, &scene, &ray, culling);
            total.shared += usize::from(truth.iter().any(|(_, owned)| !owned));
            for crossings in [Crossings::Every, Crossings::Owned] {
                let expected: Vec<Answer> = truth
                    .iter()
                    .filter(|(_, owned)| *owned || crossings == Crossings::Every)
                    .map(|(hit, _)| answer(hit))
                    .collect();
                let is_line =
                    ray.tmin.to_f64() < 0.0 && ray.tmax.to_f64() > 1.0 && culling == Culling::None;
                if scene.is_closed && is_line && crossings == Crossings::Owned {
                    assert_eq!(expected.len() % 2, 0, "{}: {ray:?}", scene.name);
                }
                let (mut all, mut is_all, mut is_count) = (vec![], true, true);
                for (_, tree, tracing) in &trees {
                    tree.all(*tracing, culling, crossings, &ray, &mut all);
                    is_all &= all.iter().map(answer).eq(expected.iter().copied());
                    let count = tree.count(*tracing, culling, crossings, &ray);
                    is_count &= count as usize == expected.len();
                }
                let what = || format!("{}, {culling:?}, {crossings:?}: {ray:?}", scene.name);
                total.hold(is_all, || format!("all, {}", what()));
                total.hold(is_count, || format!("count, {}", what()));
            }
            let expected = truth.first().map(|(hit, _)| answer(hit));
            let is_right = trees.iter().all(|(_, tree, tracing)| {
                let (mut closest, mut any) = ([None], [false]);
                tree.closest(*tracing, culling, &[ray], &mut closest);
                tree.any(*tracing, culling, &[ray], &mut any);
                let single = tree.closest_hit(culling, &ray).found();
                closest[0].as_ref().map(answer) == expected
                    && single.as_ref().map(answer) == expected
                    && [any[0], tree.any_hit(culling, &ray)] == [expected.is_some(); 2]
            });
            total.hold(is_right, || format!("closest, {}: {ray:?}", scene.name));
            // A third of the triangles is there.
            let is_there = |hit: &TriangleHit<P>| hit.triangle.is_multiple_of(3);
            let expected = truth.iter().map(|(hit, _)| hit).find(|hit| is_there(hit)).map(answer);
            let is_right = trees.iter().all(|(_, tree, tracing)| {
                let program = &mut |hit: &TriangleHit<P>| {
                    if is_there(hit) { Verdict::Accept } else { Verdict::Ignore }
                };
                tree.filtered(*tracing, culling, &ray, program).as_ref().map(answer) == expected
            });
            total.hold(is_right, || format!("filtered, {}: {ray:?}", scene.name));
        }
        for _ in 0..count {
            let (middle, size, step) = scene.around;
            let mut point = middle + vector(&mut stream, size, step);
            if stream.bits().is_multiple_of(2) {
                point.x = next(point.x, stream.bits().is_multiple_of(2));
            }
            let mut expected = true_place(&mut oracle, &scene, point);
            let by_every = point_in_solid(point, &scene.triangles);
            // Where nothing is enclosed it is the direction that tells.
            if !scene.is_closed && expected != Place::On {
                expected = by_every;
            }
            let is_right = trees.iter().all(|(_, tree, _)| tree.contains(point) == Ok(expected));
            let what = || format!("contains, {}: {point:?}", scene.name);
            total.hold(is_right && by_every == expected, what);
        }
    }
    total
}

#[test]
fn answers_are_those_of_rational_arithmetic() {
    for total in [check(1, 150, trees), check(1, 150, trees_f64)] {
        assert_eq!(total.wrong, 0, "{total:?}");
        assert!(total.answers > 4000 && total.shared > 200, "{total:?}");
    }
}

/// Run it with `--release --ignored --nocapture`; it prints what it finds.
#[test]
#[ignore = "takes minutes"]
fn a_million_answers_are_those_of_rational_arithmetic() {
    let mut sum = Total::default();
    for seed in 2.. {
        for total in [check(seed, 1000, trees), check(seed, 1000, trees_f64)] {
            sum.answers += total.answers;
            sum.wrong += total.wrong;
            sum.shared += total.shared;
        }
        if sum.answers >= 1_000_000 {
            break;
        }
    }
    println!("{sum:?}");
    assert_eq!(sum.wrong, 0);
}

/// One after another and in batches on any number of threads.
#[test]
fn batches_answer_as_calls_do_on_any_number_of_threads() {
    let mut stream = Stream::new("tracer/hits/threads", 1);
    for scene in scenes::<f32>(&mut stream).into_iter().step_by(2) {
        let rays = rays(&mut stream, &scene, 3000);
        let points: Vec<Vec3<f32>> = rays.iter().map(|ray| ray.o).collect();
        let tree = ErasedBvh::build::<ExactInTrees>(&scene.triangles, Builder::Spatial);
        let tree = tree.expect("it takes all");
        let (tracing, culling, crossings) = (Tracing::Single, Culling::None, Crossings::Every);
        let is_there = |index: usize, hit: &TriangleHit| {
            if (hit.triangle as usize + index).is_multiple_of(2) {
                Verdict::Accept
            } else {
                Verdict::Ignore
            }
        };
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads can be had").install(|| {
                let mut all = AllHits::default();
                tree.all_of(tracing, culling, crossings, &rays, &mut all);
                let mut counts = vec![0; rays.len()];
                tree.count_of(tracing, culling, crossings, &rays, &mut counts);
                let mut filtered = vec![None; rays.len()];
                tree.filtered_of(tracing, culling, &rays, &is_there, &mut filtered);
                let mut places = vec![Place::Outside; rays.len()];
                tree.contains_of(&points, &mut places).expect("it is exact");
                let (mut hits, mut sum) = (vec![], 0);
                for (index, ray) in rays.iter().enumerate() {
                    tree.all(tracing, culling, crossings, ray, &mut hits);
                    assert_eq!(all.of(index), hits);
                    assert_eq!(counts[index] as usize, hits.len());
                    let program = &mut |hit: &TriangleHit| is_there(index, hit);
                    assert_eq!(filtered[index], tree.filtered(tracing, culling, ray, program));
                    assert_eq!(Ok(places[index]), tree.contains(ray.o));
                    sum += hits.len();
                }
                assert_eq!((all.hits().len(), all.ends().last()), (sum, Some(&sum)));
                assert!(sum > rays.len() / 4);
            });
        }
    }
}

/// What a method that rounds accepts is what it accepts of every triangle, each once.
#[test]
fn a_method_that_rounds_finds_what_it_finds_in_every_triangle() {
    fn check<M: Method>(triangles: &[Triangle<f32>], rays: &[Ray<f32>]) -> usize {
        let every = EveryTriangle::<M>::new(triangles).expect("it takes all");
        let (mut expected, mut all, mut sum) = (vec![], vec![], 0);
        for builder in Builder::ALL {
            let tree = ErasedBvh::build::<M>(triangles, builder).expect("it takes all");
            for ray in rays {
                for culling in [Culling::None, Culling::Back, Culling::Front] {
                    let (tracing, crossings) = (Tracing::Plain, Crossings::Every);
                    every.all(tracing, culling, crossings, ray, &mut expected);
                    tree.all(tracing, culling, crossings, ray, &mut all);
                    assert_eq!(all, expected, "{builder}, {}: {ray:?}", M::INFO.name);
                    let count = tree.count(tracing, culling, crossings, ray);
                    assert_eq!(count as usize, all.len());
                    let first = tree.filtered(tracing, culling, ray, &mut |_| Verdict::Accept);
                    assert_eq!(first.as_ref(), all.first());
                    if let Some(nearest) = first {
                        let next = tree.closest_but(tracing, culling, ray, nearest.triangle);
                        assert_eq!(next.as_ref(), all.get(1));
                    }
                    sum += all.len();
                }
            }
            assert_eq!(tree.contains(rays[0].o), Err(NotExact));
        }
        sum
    }
    let mut stream = Stream::new("tracer/hits/rounded", 1);
    for scene in scenes::<f32>(&mut stream) {
        // Where the numbers are large methods that round accept what is beside the boxes.
        if scene.name != "utm" {
            let rays = rays(&mut stream, &scene, 200);
            assert!(check::<Watertight>(&scene.triangles, &rays) > 500, "{}", scene.name);
            assert!(check::<MollerTrumbore>(&scene.triangles, &rays) > 500, "{}", scene.name);
            assert!(check::<Wald>(&scene.triangles, &rays) > 500, "{}", scene.name);
        }
    }
    let bunny = bunny();
    let rays: Vec<Ray<f32>> = rays_of(&bunny).into_iter().step_by(8).collect();
    assert!(check::<Watertight>(&bunny.triangles, &rays) > 100);
}

/// The ray ends where a program says, at a hit that there is.
#[test]
fn a_program_may_end_a_ray() {
    let mut stream = Stream::new("tracer/hits/end", 1);
    let scene = scenes::<f32>(&mut stream).swap_remove(0);
    let tree = ErasedBvh::build::<ExactInTrees>(&scene.triangles, Builder::Spatial);
    let tree = tree.expect("it takes all");
    let (tracing, culling, mut all, mut ended) = (Tracing::Single, Culling::None, vec![], 0);
    for ray in rays(&mut stream, &scene, 500) {
        tree.all(tracing, culling, Crossings::Every, &ray, &mut all);
        let mut offered = 0;
        let found = tree.filtered(tracing, culling, &ray, &mut |hit| {
            assert!(all.contains(hit));
            offered += 1;
            if offered == 2 { Verdict::End } else { Verdict::Ignore }
        });
        assert!(offered <= 2);
        assert_eq!(found.is_some(), offered == 2);
        assert!(found.is_none_or(|found| all.contains(&found)));
        ended += usize::from(found.is_some());
    }
    assert!(ended > 100, "{ended}");
}

/// Far apart, near zero and where nothing is.
#[test]
fn points_over_the_whole_range_are_placed() {
    fn check<P: Precision>(scale: f64) {
        let triangles = surface::<P>(&Surface::cube(2), scale, Vec3::new(0.0, 0.0, 0.0));
        let tree = Bvh::<ExactInTrees, P>::build(&triangles, Builder::Binned);
        let tree = tree.expect("it takes all");
        let side = triangles.iter().map(|t| t.a.x.to_f64()).fold(0.0, f64::max);
        let number = P::from_f64;
        let at = |x: P| tree.contains(Vec3::new(x, number(side * 0.25), number(-side * 0.25)));
        let side = number(side);
        assert_eq!(at(side), Ok(Place::On), "{scale}");
        assert_eq!(at(next(side, false)), Ok(Place::Inside), "{scale}");
        assert_eq!(at(number(0.0)), Ok(Place::Inside), "{scale}");
        assert_eq!(at(next(side, true)), Ok(Place::Outside), "{scale}");
        assert_eq!(at(number(f64::NAN)), Ok(Place::Outside), "{scale}");
        assert_eq!(at(number(f64::INFINITY)), Ok(Place::Outside), "{scale}");
    }
    for scale in [1e-38, 1e-20, 1.0, 1e20, 3e38] {
        check::<f32>(scale);
        check::<f64>(scale);
    }
    for scale in [1e-307, 1e-160, 1e160, 1.7e308] {
        check::<f64>(scale);
    }
    let nothing = ErasedBvh::build::<ExactInTrees>(&[], Builder::Binned).expect("it takes all");
    assert_eq!(nothing.contains(Vec3::new(0.0, 0.0, 0.0)), Ok(Place::Outside));
}
