//! Trees of f64 over the whole range of its numbers, and rays from near and from afar, against rational arithmetic.

use trisect_core::{Ray, Triangle, Vec3};
use trisect_exact::ExactInTrees;
use trisect_method::Culling;
use trisect_moller_trumbore::MollerTrumbore;
use trisect_oracle::Oracle;
use trisect_tracer::{Builder, Bvh, Crossings, Tracing, Tree};
use trisect_workloads::{Placement, Stream, Surface};

fn power(exponent: i32) -> f64 {
    2.0_f64.powi(exponent)
}

/// A ragged sphere of that size, so far from zero in its own sizes.
fn sphere(exponent: i32, away: f64) -> Vec<Triangle<f64>> {
    let offset = Vec3::new(away, -0.75 * away, 0.25 * away);
    let triangles = Surface::ragged_sphere(1).triangles::<f64>(&Placement { scale: 1.0, offset });
    // In two steps, as the power itself may be out of range.
    let scaled = |x: &f64| x * power(exponent / 2) * power(exponent - exponent / 2);
    triangles.iter().map(|triangle| triangle.map(scaled)).collect()
}

/// A ray from so many sizes away at a point of a triangle or beside it. Its direction is as long as the power says, or as
/// the numbers allow.
fn ray(stream: &mut Stream, triangles: &[Triangle<f64>], far: f64, speed: i32) -> Ray<f64> {
    let Triangle { a, b, c } = triangles[stream.below(triangles.len())];
    let Triangle { a: other, .. } = triangles[stream.below(triangles.len())];
    let [u, v] = [0, 1].map(|_| stream.range_f64(-0.1, 0.6));
    let target = match stream.bits() % 4 {
        0 => a,
        1 => a + (b - a).scale(0.5),
        _ => a + ((b - a).scale(u) + (c - a).scale(v)),
    };
    let size = (other - a).map(f64::abs);
    let size = size.x.max(size.y).max(size.z);
    let o = target + stream.cube().scale(size * far);
    let way = target - o;
    let largest = way.x.abs().max(way.y.abs()).max(way.z.abs());
    let d = way.map(|x| x / largest * power(speed / 2) * power(speed - speed / 2));
    let ray = Ray::new(o, d);
    match stream.bits() % 8 {
        0 => ray.with_interval(f64::NEG_INFINITY, f64::INFINITY),
        // Where the target is, more or less.
        1 => ray.with_interval(0.0, way.dot(d) / d.dot(d)),
        _ => ray,
    }
}

#[test]
fn the_first_hit_is_that_of_rational_arithmetic() {
    let (mut stream, mut oracle) = (Stream::new("tracer/range", 1), Oracle::default());
    let (mut hits, mut misses) = (0, 0);
    for (exponent, away) in [
        (0, 0.0),
        (0, 1e3),
        (-20, 1e9),
        (40, 1e14),
        (-300, 3.0),
        (400, 7.0),
        (-1000, 0.0),
        (-1060, 0.0),
        (1010, 0.0),
        (1023, 0.0),
    ] {
        let triangles = sphere(exponent, away);
        let tree = Bvh::<ExactInTrees, f64>::build(&triangles, Builder::Spatial);
        let tree = tree.expect("it takes all");
        for far in [0.1, 1.9, 4.5, 1e3, 1e9, power(39), power(42), 1e30, 1e200] {
            for speed in [0, -300, 300, -1030, 1023] {
                for _ in 0..4 {
                    let ray = ray(&mut stream, &triangles, far, speed);
                    let expected = oracle.closest(&ray, &triangles);
                    let expected = expected.map(|(id, answer)| (id, answer.hit));
                    let found = tree.closest_hit(Culling::None, &ray);
                    let found = found.map(|hit| (hit.triangle as usize, Some(hit.hit)));
                    assert_eq!(found, expected, "2^{exponent}, {away}, {far}: {ray:?}");
                    assert_eq!(tree.any_hit(Culling::None, &ray), expected.is_some(), "{ray:?}");
                    let mut plain = [None];
                    tree.closest(Tracing::Plain, Culling::None, &[ray], &mut plain);
                    let plain = plain[0].map(|hit| (hit.triangle as usize, Some(hit.hit)));
                    assert_eq!(plain, expected, "2^{exponent}, {away}, {far}: {ray:?}");
                    let count = tree.count(Tracing::Single, Culling::None, Crossings::Every, &ray);
                    assert_eq!(count > 0, expected.is_some(), "{ray:?}");
                    hits += usize::from(expected.is_some());
                    misses += usize::from(expected.is_none());
                }
            }
        }
    }
    assert!(hits > 500 && misses > 150, "{hits} {misses}");
}

/// Rays that are not finite, do not move, or have nothing in their intervals.
#[test]
fn what_is_no_ray_hits_nothing() {
    let triangles = sphere(0, 0.0);
    let tree = Bvh::<ExactInTrees, f64>::build(&triangles, Builder::Spatial).expect("it takes all");
    let inside = Ray::<f64>::new([0.01, 0.02, 0.03], [1.0, 0.0, -0.0]);
    assert!(tree.closest_hit(Culling::None, &inside).is_some_and(|hit| hit.hit.t > 0.0));
    let behind = inside.with_interval(f64::NEG_INFINITY, 0.0);
    assert!(tree.closest_hit(Culling::None, &behind).is_some_and(|hit| hit.hit.t < 0.0));
    let (nan, infinity) = (f64::NAN, f64::INFINITY);
    for nothing in [
        inside.with_interval(2.0, 1.0),
        inside.with_interval(nan, 1.0),
        inside.with_interval(0.0, nan),
        Ray { d: [0.0; 3].into(), ..inside },
        Ray { d: [infinity, 0.0, 0.0].into(), ..inside },
        Ray { o: [nan, 0.0, 0.0].into(), ..inside },
        Ray { o: [0.0, infinity, 0.0].into(), ..inside },
    ] {
        assert_eq!(tree.closest_hit(Culling::None, &nothing), None, "{nothing:?}");
        assert!(!tree.any_hit(Culling::None, &nothing), "{nothing:?}");
        assert_eq!(tree.count(Tracing::Single, Culling::None, Crossings::Every, &nothing), 0);
    }
    let nothing = Bvh::<ExactInTrees, f64>::build(&[], Builder::Spatial).expect("it takes all");
    assert_eq!(nothing.closest_hit(Culling::None, &inside), None);
}

/// What a tree leaves out, or takes in when it is fitted, is decided in f64: in f32 these are degenerate.
#[test]
fn triangles_that_f32_cannot_tell_from_lines_are_hit() {
    let thin = |x: f64, width: f64| {
        Triangle::<f64>::new([x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, width, 0.0])
    };
    let wide = thin(0.0, 1.0);
    let sliver = thin(8.0, 1e-12);
    let line = thin(16.0, 0.0);
    let mut tree = Bvh::<ExactInTrees, f64>::build(&[wide, sliver, line], Builder::Spatial)
        .expect("it takes all");
    let at = |x: f64, y: f64| Ray::<f64>::new([x, y, 9.0], [0.0, 0.0, -1.0]);
    let hit = tree.closest_hit(Culling::None, &at(8.25, 5e-13));
    assert_eq!(hit.map(|hit| hit.triangle), Some(1));
    assert_eq!(tree.statistics().references, 2);
    let moved = [wide, sliver, line].map(|triangle| triangle.map(|x| x + 1e6));
    tree.refit(&moved).expect("as before");
    let Triangle { a, b, c } = moved[1];
    let middle = (a + b + c).scale(1.0 / 3.0);
    let found = tree.closest_hit(Culling::None, &at(middle.x, middle.y));
    let is_hit = Oracle::default().classify(&at(middle.x, middle.y), &moved[1]).is_hit();
    assert_eq!(found.is_some(), is_hit);
    let grown = [wide, sliver, thin(16.0, 1.0)];
    assert!(tree.refit(&grown).is_err());
}

/// Near zero and far from it, whatever the method.
#[test]
fn boxes_lose_no_true_hit() {
    let mut stream = Stream::new("tracer/range/rounds", 1);
    let mut hits = 0;
    for away in [0.0, 1e6] {
        let triangles = sphere(0, away);
        let tree = Bvh::<MollerTrumbore, f64>::build(&triangles, Builder::Spatial);
        let tree = tree.expect("it takes all");
        for far in [0.1, 1.9, 4.5, 1e3] {
            for _ in 0..200 {
                let ray = ray(&mut stream, &triangles, far, 0);
                let mut candidates = vec![];
                tree.candidates(&ray, &mut |id| {
                    candidates.push(id);
                    f64::INFINITY
                });
                let mut oracle = Oracle::default();
                let is_hit = |id: &usize| oracle.classify(&ray, &triangles[*id]).is_hit();
                for hit in (0..triangles.len()).filter(is_hit) {
                    assert!(candidates.contains(&u32::try_from(hit).unwrap_or(u32::MAX)));
                    hits += 1;
                }
                let first = tree.closest_hit(Culling::None, &ray);
                assert!(first.is_none_or(|first| candidates.contains(&first.triangle)));
            }
        }
    }
    assert!(hits > 1000, "{hits}");
}
