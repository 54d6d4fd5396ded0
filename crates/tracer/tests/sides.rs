//! Rays that run along an axis and lie in the sides of boxes: none is lost, however it is traced.

mod common;

use common::{brute_force, tree_by};
use trisect_core::{Ray, Triangle, Vec3};
use trisect_exact::ExactInTrees;
use trisect_method::{Culling, Method};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_oracle::Oracle;
use trisect_tracer::{Builder, EveryTriangle, ScalarBvh, Tracing, Tree, meets_box};
use trisect_watertight::Watertight;

/// Where walls are cut into squares: numbers of so few digits that no method rounds, but a product with a large
/// reciprocal does.
fn cuts(offset: f32) -> Vec<f32> {
    [-21.0, -1.0, 0.0, 11.0, 31.0].map(|x| x / 16.0 + offset).to_vec()
}

/// The six sides of a box, cut into squares of two triangles each.
fn walls(cuts: &[f32]) -> Vec<Triangle<f32>> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for depth in [cuts[0], cuts[cuts.len() - 1]] {
            let at = |u: f32, v: f32| Vec3::new(u, v, depth).with_axis_last(axis);
            for (u, next_u) in cuts.iter().zip(&cuts[1..]) {
                for (v, next_v) in cuts.iter().zip(&cuts[1..]) {
                    let corners =
                        [at(*u, *v), at(*next_u, *v), at(*next_u, *next_v), at(*u, *next_v)];
                    let [a, b, c, d] = corners;
                    triangles.extend([Triangle { a, b, c }, Triangle { a, b: c, c: d }]);
                }
            }
        }
    }
    triangles
}

/// Through every corner, every middle of an edge and every middle of a square, along an axis from either end; of
/// either sign of zero.
fn rays(cuts: &[f32], axis: usize) -> Vec<Ray<f32>> {
    let mut places = cuts.to_vec();
    places.extend(cuts.windows(2).map(|pair| f32::midpoint(pair[0], pair[1])));
    let (near, far) = (cuts[0] - 5.0, cuts[cuts.len() - 1] + 5.0);
    let mut rays = Vec::new();
    let zeros = [[0.0, 0.0], [0.0, -0.0], [-0.0, 0.0], [-0.0, -0.0]];
    let ways = [(near, 1.0), (far, -1.0), (near, 0.25), (far, -8.0)];
    for ([zero, other], (from, along)) in zeros.into_iter().zip(ways) {
        for &u in &places {
            for &v in &places {
                let o = Vec3::new(u, v, from).with_axis_last(axis);
                let d = Vec3::new(zero, other, along).with_axis_last(axis);
                rays.push(Ray::<f32>::new(o, d));
            }
        }
    }
    rays
}

/// Every way of tracing finds a triangle where testing each finds one that the ray truly hits.
fn none_is_lost<M: Method>(triangles: &[Triangle<f32>], rays: &[Ray<f32>]) {
    let mut trees: Vec<(&str, Box<dyn Tree>)> = Vec::new();
    for builder in Builder::ALL {
        trees.push((builder.name(), Box::new(tree_by::<M>(builder, triangles))));
    }
    let scalar = ScalarBvh::<M>::build(triangles, Builder::Spatial).expect("it takes all");
    trees.push(("scalar", Box::new(scalar)));
    trees.push(("no tree", Box::new(EveryTriangle::<M>::new(triangles).expect("it takes all"))));
    let mut oracle = Oracle::default();
    for culling in [Culling::None, Culling::Back, Culling::Front] {
        let all = brute_force::<M>(triangles, rays, culling);
        let expected: Vec<bool> = all
            .iter()
            .zip(rays)
            .map(|(found, ray)| {
                let mut is_true =
                    |number: u32| oracle.classify(ray, &triangles[number as usize]).is_hit();
                found.is_some_and(|found| is_true(found.triangle))
            })
            .collect();
        let hits = expected.iter().filter(|hit| **hit).count();
        assert!(hits * 3 > rays.len(), "{}: {hits} of {}", M::INFO.name, rays.len());
        let is_kept = |what: &str, found: &[bool]| {
            for ((found, expected), ray) in found.iter().zip(&expected).zip(rays) {
                assert!(*found || !expected, "{}, {what}, {culling:?}: {ray:?}", M::INFO.name);
            }
        };
        for (name, tree) in &trees {
            for tracing in [Tracing::Single, Tracing::Packets, Tracing::Plain] {
                let mut found = vec![None; rays.len()];
                tree.closest(tracing, culling, rays, &mut found);
                let mut any = vec![false; rays.len()];
                tree.any(tracing, culling, rays, &mut any);
                is_kept(&format!("{name}, {tracing:?}, any"), &any);
                let found: Vec<bool> = found.iter().map(Option::is_some).collect();
                is_kept(&format!("{name}, {tracing:?}"), &found);
            }
            if culling != Culling::None {
                continue;
            }
            let counted = rays.iter().map(|ray| tree.inspect(ray).found.is_some());
            is_kept(&format!("{name}, counted"), &counted.collect::<Vec<bool>>());
            let candidates = rays.iter().zip(&all).map(|(ray, hit)| {
                let mut is_among = false;
                tree.candidates(ray, &mut |number| {
                    is_among |= hit.is_some_and(|hit| hit.triangle == number);
                    ray.tmax
                });
                is_among
            });
            is_kept(&format!("{name}, candidates"), &candidates.collect::<Vec<bool>>());
        }
    }
}

#[test]
fn rays_in_the_sides_of_boxes_find_what_they_hit() {
    for offset in [0.0, -7.25, 1000.0625] {
        let cuts = cuts(offset);
        let triangles = walls(&cuts);
        for axis in 0..3 {
            let rays = rays(&cuts, axis);
            none_is_lost::<MollerTrumbore>(&triangles, &rays);
            none_is_lost::<Watertight>(&triangles, &rays);
            none_is_lost::<ExactInTrees>(&triangles, &rays);
        }
    }
}

#[test]
fn a_box_is_met_in_each_of_its_sides_and_not_beside_them() {
    // Sides are moved outwards by less, origins being within 4.
    let beside = 16.0 * f32::EPSILON * 4.0;
    let (low, high) = (Vec3::new(-0.1, 0.3, 1e-20), Vec3::new(0.7, 0.9, 1.1));
    for axis in 0..3 {
        let [low, high] = [low, high].map(|corner| corner.with_axis_last(axis));
        let meets = |ray: &Ray<f32>| {
            let [low, high] = [low, high].map(|v| v.with_axis_restored(axis));
            let turned = Ray {
                o: ray.o.with_axis_restored(axis),
                d: ray.d.with_axis_restored(axis),
                ..*ray
            };
            meets_box(&turned, low, high)
        };
        for (zero, away) in [(0.0, -1.0), (-0.0, -1.0), (0.0, 1.0), (-0.0, 1.0)] {
            let from = if away > 0.0 { low.z - 2.0 } else { high.z + 2.0 };
            let ray = |x: f32, y: f32| Ray::<f32>::new([x, y, from], [zero, -zero, away]);
            let middle = [f32::midpoint(low.x, high.x), f32::midpoint(low.y, high.y)];
            for x in [low.x, middle[0], high.x] {
                for y in [low.y, middle[1], high.y] {
                    assert!(meets(&ray(x, y)), "{axis} {x} {y} {away}");
                    // Its end, and behind it.
                    let reach = if away > 0.0 { low.z - from } else { from - high.z };
                    assert!(meets(&Ray { tmax: reach, ..ray(x, y) }));
                    assert!(!meets(&Ray { tmax: reach * 0.999, ..ray(x, y) }));
                    assert!(!meets(&Ray { d: -ray(x, y).d, ..ray(x, y) }));
                }
                assert!(!meets(&ray(x, high.y + beside)) && !meets(&ray(x, low.y - beside)));
            }
            for y in [low.y, middle[1], high.y] {
                assert!(!meets(&ray(high.x + beside, y)) && !meets(&ray(low.x - beside, y)));
            }
        }
    }
    // A box without depth, and rays that are not finite.
    let flat = (Vec3::new(0.0, 0.0, 3.0), Vec3::new(1.0, 1.0, 3.0));
    let ray = Ray::<f32>::new([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    assert!(meets_box(&ray, flat.0, flat.1));
    assert!(!meets_box(&Ray { tmin: f32::NAN, ..ray }, flat.0, flat.1));
    let nan = Vec3::new(f32::NAN, 0.0, 0.0);
    assert!(!meets_box(&Ray { o: nan, ..ray }, flat.0, flat.1));
}

#[test]
#[allow(clippy::cast_precision_loss, reason = "whole numbers below 2¹⁸")]
fn points_of_subnormal_coordinates_are_met() {
    // `t` is 2⁻⁴⁵ on the dot, and the coordinates of the scene are too small to move planes by a part of them.
    let unit = f32::from_bits(1);
    for more in 0..100 {
        let times = [1001_u32, 20_011, 180_001].map(|x| (x + 2 * more) as f32);
        let point = Vec3::from(times.map(|x| x * unit));
        let d = times.map(|x| x * 2.0_f32.powi(-104));
        let ray = Ray::<f32>::new([0.0; 3], d);
        assert!(meets_box(&ray, point, point), "{times:?}");
    }
}
