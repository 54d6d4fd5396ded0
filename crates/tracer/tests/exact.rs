//! What the exact method promises holds in the tree: no box discards a hit, and the closest hit is the
//! first in exact arithmetic, however rays are traced.

mod common;

use common::tree_by;
use trisect_core::{Float, Ray, Triangle, Vec3};
use trisect_exact::{Exact, ExactInTrees};
use trisect_method::Culling;
use trisect_oracle::Oracle;
use trisect_tracer::{Builder, EveryTriangle, ScalarBvh, Tracing, Tree, TriangleHit};
use trisect_workloads::{Aim, Placement, Stream, Surface, bunny, diffuse_bounce, primary};

/// A triangle's number, `t`, `beta` and `gamma`, as bits.
type Answer = (u32, [u32; 3]);

fn answer(triangle: u32, [t, beta, gamma]: [f32; 3]) -> Answer {
    // −0 and 0 are one answer.
    (triangle, [t, beta, gamma].map(|x| (x + 0.0).to_bits()))
}

/// What the oracle says of each ray.
fn truth(triangles: &[Triangle<f32>], rays: &[Ray<f32>]) -> Vec<Option<Answer>> {
    let mut oracle = Oracle::default();
    rays.iter()
        .map(|ray| {
            let (place, found) = oracle.closest(ray, triangles)?;
            let hit = found.hit.expect("it is a hit");
            let number = u32::try_from(place).expect("triangles are few");
            Some(answer(number, [hit.t, hit.beta, hit.gamma]))
        })
        .collect()
}

/// Traces in every way, and holds each answer to the truth; how many rays hit.
fn is_true(what: &str, triangles: &[Triangle<f32>], rays: &[Ray<f32>]) -> usize {
    let truth = truth(triangles, rays);
    let holds = |name: &str, tree: &dyn Tree, tracing: Tracing| {
        let mut found: Vec<Option<TriangleHit>> = vec![None; rays.len()];
        tree.closest(tracing, Culling::None, rays, &mut found);
        let mut any = vec![false; rays.len()];
        tree.any(tracing, Culling::None, rays, &mut any);
        for (((found, any), truth), ray) in found.iter().zip(&any).zip(&truth).zip(rays) {
            let found = found.map(|TriangleHit { triangle, hit }| {
                answer(triangle, [hit.t, hit.beta, hit.gamma])
            });
            let numbers =
                |x: Option<Answer>| x.map(|(number, bits)| (number, bits.map(f32::from_bits)));
            let (found, expected) = (numbers(found), numbers(*truth));
            assert_eq!(found, expected, "{what}, {name}, {tracing:?}: {ray:?}");
            assert_eq!(*any, truth.is_some(), "{what}, {name}, {tracing:?}, any: {ray:?}");
        }
    };
    for builder in Builder::ALL {
        let trees: [Box<dyn Tree>; 2] = [
            Box::new(tree_by::<Exact>(builder, triangles)),
            Box::new(tree_by::<ExactInTrees>(builder, triangles)),
        ];
        for tree in trees {
            for tracing in [Tracing::Single, Tracing::Packets, Tracing::Plain] {
                holds(builder.name(), &*tree, tracing);
            }
        }
    }
    let scalar = ScalarBvh::<Exact>::build(triangles, Builder::Spatial).expect("it takes all");
    holds("scalar", &scalar, Tracing::Plain);
    let every = EveryTriangle::<Exact>::new(triangles).expect("it takes all");
    holds("no tree", &every, Tracing::Plain);
    truth.iter().flatten().count()
}

#[test]
fn camera_and_diffuse_rays_find_the_first_triangle_of_the_bunny() {
    let bunny = bunny();
    let tree = tree_by::<Exact>(Builder::Spatial, &bunny.triangles);
    let camera = primary(&bunny, 24, 24).rays;
    let mut closest = |ray: &Ray<f32>| {
        let mut found = [None];
        tree.closest(Tracing::Single, Culling::None, &[*ray], &mut found);
        found[0].map(|TriangleHit { triangle, hit }| (triangle as usize, hit))
    };
    let diffuse = diffuse_bounce(1, &bunny, 64, 64, &mut closest).rays;
    assert!(is_true("camera", &bunny.triangles, &camera) > 30);
    assert!(is_true("diffuse", &bunny.triangles, &diffuse) > 30);
}

#[test]
fn rays_at_edges_and_corners_of_closed_surfaces_find_one_triangle() {
    let along = Vec3::new(0.6, -0.48, 0.64);
    for surface in [Surface::sphere(2), Surface::ragged_sphere(1), Surface::cube(4)] {
        for (offset, scale) in [(0.0, 1.0), (1e3, 1.0), (1e6, 1.0), (0.0, 1e-30), (0.0, 1e30)] {
            let placement = Placement { scale, offset: along.scale(offset) };
            let triangles = surface.triangles::<f32>(&placement);
            for aim in [Aim::Edges, Aim::Vertices] {
                let features = surface.features(aim);
                let rays: Vec<Ray<f32>> = features
                    .iter()
                    .step_by(7)
                    .flat_map(|feature| surface.aimed::<f32>(feature, &placement, 1, 8))
                    .collect();
                let hits = is_true(surface.name, &triangles, &rays);
                // Far from where it was made the corners of a surface fall together.
                assert!(offset > 1e3 || hits == rays.len(), "{}", surface.name);
            }
        }
    }
}

/// Layers that are a unit in the last place apart, or coincide, sheared so that a ray meets them at one
/// rounded `t` in another order than that of their numbers.
#[test]
fn layers_that_are_nearly_one_are_told_apart() {
    let mut stream = Stream::new("layers", 1);
    for round in 0_u32..40 {
        #[allow(clippy::cast_possible_truncation, reason = "any number will do")]
        let mut number = |most: f64| stream.range_f64(-most, most) as f32;
        let tilt = [number(0.5), number(0.5)];
        let mut triangles = Vec::new();
        for _ in 0..40 {
            let lift = number(3.0).round() * f32::EPSILON;
            let corner = |x: f32, y: f32| Vec3::new(x, y, 1.0 + x * tilt[0] + y * tilt[1] + lift);
            let (a, b, c) = (corner(-1.0, -1.0), corner(1.5, -1.0), corner(-1.0, 1.5));
            triangles.push(match number(3.0).round().to_bits() % 3 {
                0 => Triangle { a, b, c },
                1 => Triangle { a: b, b: a, c },
                _ => Triangle { a: c, b: a, c: b },
            });
        }
        let rays: Vec<Ray<f32>> = (0..60)
            .map(|_| {
                let away = if round % 2 == 0 { 64.0 } else { 1.0 };
                let o = Vec3::new(number(0.1), number(0.1), number(1.0) * away);
                let target = Vec3::new(number(0.4), number(0.4), 1.0);
                let ray = Ray::<f32>::new(o, target - o);
                Ray { tmin: -ray.tmax, ..ray }
            })
            .collect();
        assert!(is_true("layers", &triangles, &rays) > 30);
    }
}

/// A number of any exponent, near one, a zero or subnormal, by what `kind` says.
fn hostile(stream: &mut Stream, kind: u64) -> f32 {
    #[allow(clippy::cast_possible_truncation, reason = "any number will do")]
    let near = stream.range_f64(-3.0, 3.0) as f32;
    match kind % 6 {
        0 => f32::from_upper_bits(stream.bits()),
        1 => f32::from_bits64(stream.bits() & 0xff),
        2 => 0.0_f32.copysign(near),
        3 => near.round(),
        4 => near * 1e38,
        _ => near,
    }
}

/// Small scenes of any bits, with rays that are aimed at what is in them: along directions whose inverse
/// overflows or is subnormal, from origins whose distance overflows, in the planes of boxes, and in
/// intervals that end at the hit.
#[test]
fn no_box_discards_a_hit_of_any_bits() {
    let mut stream = Stream::new("boxes", 1);
    let (mut hits, mut slow) = (0, 0);
    for round in 0..400 {
        // Many numbers of the scene are of one kind, so that rays meet triangles.
        let usual = stream.bits();
        let number = |stream: &mut Stream| {
            let kind = if stream.bits().is_multiple_of(4) { stream.bits() } else { usual };
            hostile(stream, kind)
        };
        let vector =
            |stream: &mut Stream| Vec3::new(number(stream), number(stream), number(stream));
        // Those that are small for where they are have boxes that lie far from origins.
        let is_small = stream.bits().is_multiple_of(2);
        let triangles: Vec<Triangle<f32>> = (0..40)
            .map(|_| {
                let a = vector(&mut stream);
                let other = |stream: &mut Stream| {
                    #[allow(clippy::cast_possible_truncation, reason = "any number will do")]
                    let mut near = |x: f32| x * stream.range_f64(0.7, 1.0) as f32;
                    if is_small { a.map(&mut near) } else { vector(stream) }
                };
                Triangle { a, b: other(&mut stream), c: other(&mut stream) }
            })
            .collect();
        let mut rays = Vec::new();
        for triangle in &triangles {
            let Triangle { a, b, c } = *triangle;
            let inside = a.map(|x| x * 0.5) + b.map(|x| x * 0.25) + c.map(|x| x * 0.25);
            let target = if stream.bits().is_multiple_of(2) { inside } else { a };
            let o = vector(&mut stream);
            // Half of it, since the difference may overflow; and all sizes, so that `t` has any.
            let half = target.map(|x| x * 0.5) - o.map(|x| x * 0.5);
            let speed = match stream.bits() % 4 {
                0 => 1.0,
                1 => f32::MIN_POSITIVE,
                2 => 2.0_f32.powi(i32::try_from(stream.bits() % 200).unwrap_or(0) - 100),
                _ => 2.0,
            };
            let d = half.map(|x| x * speed);
            slow += usize::from(d.to_array().iter().any(|x| x.is_subnormal()));
            let ray = Ray::<f32>::new(o, d);
            rays.push(ray);
            rays.push(Ray { tmin: -ray.tmax, ..ray });
            let all = Oracle::default().truth(&ray, triangle);
            #[allow(clippy::cast_possible_truncation, reason = "near the hit is near enough")]
            let end = all.t as f32;
            if end.is_finite() {
                rays.push(Ray { tmin: end, tmax: end, ..ray });
                rays.push(Ray { tmax: end, ..ray });
            }
        }
        hits += is_true(&format!("bits, round {round}"), &triangles, &rays);
    }
    println!("{hits} hits, {slow} directions with subnormal numbers");
    assert!(hits > 10_000 && slow > 1000);
}
