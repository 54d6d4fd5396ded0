//! The tree answers as testing every triangle does.

mod common;

use common::{answers, brute_force, rays_of, traced, tree_by};
use trisect_core::{Ray, Triangle, Vec3};
use trisect_method::{Culling, Method};
use trisect_moller_trumbore::{MollerTrumbore, PublishedOrder};
use trisect_oracle::Oracle;
use trisect_tracer::{
    Builder, Bvh, ErasedBvh, EveryTriangle, ScalarBvh, Statistics, Tracing, Tree, TriangleHit,
};
use trisect_wald::Wald;
use trisect_watertight::Watertight;
use trisect_workloads::{Aim, Placement, Stress, Surface, bunny};

fn tree<M: Method>(triangles: &[Triangle<f32>]) -> Bvh<M> {
    tree_by(Builder::default(), triangles)
}

fn agrees<M: Method>(name: &str, triangles: &[Triangle<f32>], rays: &[Ray<f32>]) {
    answers(name, &[tree::<M>(triangles)], triangles, rays);
}

#[test]
fn plain_tracing_finds_what_testing_every_triangle_finds() {
    let bunny = bunny();
    let rays = rays_of(&bunny);
    agrees::<MollerTrumbore>("bunny", &bunny.triangles, &rays);
    agrees::<Wald>("bunny", &bunny.triangles, &rays);
    agrees::<Watertight>("bunny", &bunny.triangles, &rays);
}

#[test]
fn behind_a_call_one_at_a_time_and_without_a_tree_the_answers_are_the_same() {
    fn check<M: Method>(triangles: &[Triangle<f32>], rays: &[Ray<f32>]) {
        let all = brute_force::<M>(triangles, rays, Culling::None);
        assert!(all.iter().flatten().count() > 100);
        let scalar = ScalarBvh::<M>::build(triangles, Builder::Spatial).expect("it takes all");
        let every = EveryTriangle::<M>::new(triangles).expect("it takes all");
        let erased = ErasedBvh::build::<M>(triangles, Builder::Spatial).expect("it takes all");
        for tree in [&scalar as &dyn Tree, &every, &erased] {
            assert_eq!(traced(tree, Tracing::Plain, Culling::None, rays), all);
        }
        let in_loop = tree::<M>(triangles);
        for tracing in [Tracing::Single, Tracing::Packets] {
            for culling in [Culling::None, Culling::Back, Culling::Front] {
                let expected = traced(&in_loop, tracing, culling, rays);
                assert_eq!(traced(&erased, tracing, culling, rays), expected, "{tracing:?}");
            }
        }
        for ray in rays {
            assert_eq!(erased.inspect(ray), in_loop.inspect(ray));
        }
        assert_eq!(erased.statistics(), in_loop.statistics());
    }
    let triangles = Surface::sphere(3).triangles::<f32>(&Placement::HERE);
    let rays: Vec<Ray<f32>> = (0..500)
        .map(|i| {
            let (x, y) = ((i % 25) as f32 / 6.0 - 2.0, (i / 25) as f32 / 5.0 - 2.0);
            Ray::new([x, y, -9.0], [0.01 * y, -0.02 * x, 1.0])
        })
        .collect();
    check::<MollerTrumbore>(&triangles, &rays);
    check::<Wald>(&triangles, &rays);
}

/// A method whose published form divides first decides by numerators where any hit will do: they round
/// otherwise, but hardly ever to another decision.
#[test]
fn any_hit_is_decided_by_numerators_alike() {
    type Order1 = PublishedOrder<1>;
    assert!(!<Order1 as Method>::INFO.forms.deferred(), "another method is to be tested");
    let bunny = bunny();
    let tree = tree::<Order1>(&bunny.triangles);
    let rays = rays_of(&bunny);
    let mut closest = vec![None; rays.len()];
    tree.closest(Tracing::Single, Culling::None, &rays, &mut closest);
    for tracing in [Tracing::Single, Tracing::Packets] {
        let mut any = vec![false; rays.len()];
        tree.any(tracing, Culling::None, &rays, &mut any);
        assert!(any.iter().filter(|hit| **hit).count() > 100);
        let differ = closest.iter().zip(&any).filter(|(hit, any)| hit.is_some() != **any).count();
        assert!(differ <= 1 + rays.len() / 500, "{tracing:?}: {differ} of {}", rays.len());
    }
}

/// Along axes, through lattice points: rays that lie in the sides of boxes.
#[test]
fn rays_in_the_sides_of_boxes_are_not_lost() {
    let mut rays = Vec::new();
    for axis in 0..3 {
        for (i, j) in (0..9).flat_map(|i| (0..9).map(move |j| (i, j))) {
            let side = |k: i32| k as f32 / 4.0 - 1.0;
            for away in [-3.0, 3.0] {
                let o = Vec3::new(side(i), side(j), away).with_axis_last(axis);
                let d = Vec3::new(0.0, -0.0, -away).with_axis_last(axis);
                rays.push(Ray::<f32>::new(o, d));
            }
        }
    }
    for surface in [Surface::cube(4), Surface::square(8)] {
        let triangles = surface.triangles::<f32>(&Placement::HERE);
        agrees::<MollerTrumbore>(surface.name, &triangles, &rays);
        agrees::<Watertight>(surface.name, &triangles, &rays);
    }
}

/// Where a method hits truly, the test of the box does not stand in its way, however hard the pair.
#[test]
fn no_box_discards_a_true_hit() {
    fn check<M: Method>() {
        for family in Stress::ALL {
            for level in family.levels::<f32>() {
                for (ray, triangle) in family.pairs::<f32>(1, level, 60) {
                    let all = brute_force::<M>(&[triangle], &[ray], Culling::None);
                    let is_true = Oracle::default().classify(&ray, &triangle).is_hit();
                    if all[0].is_some() && is_true {
                        let tree = tree::<M>(&[triangle]);
                        let found = traced(&tree, Tracing::Plain, Culling::None, &[ray]);
                        let place = (family.name(), level);
                        assert_eq!(found, all, "{place:?}: {ray:?} {triangle:?}");
                    }
                }
            }
        }
    }
    check::<MollerTrumbore>();
    check::<Watertight>();
}

#[test]
fn closed_surfaces_stay_closed_for_a_watertight_method() {
    for surface in [Surface::sphere(3), Surface::ragged_sphere(1), Surface::cube(4)] {
        for (offset, scale) in [(0.0, 1.0), (1e3, 1.0), (1e6, 1.0), (0.0, 1e-6), (0.0, 1e6)] {
            let offset = Vec3::new(0.6, -0.48, 0.64).scale(offset);
            let placement = Placement { scale, offset };
            let tree = tree::<Watertight>(&surface.triangles::<f32>(&placement));
            for aim in [Aim::Edges, Aim::Vertices] {
                let rays: Vec<Ray<f32>> = surface
                    .features(aim)
                    .iter()
                    .flat_map(|feature| surface.aimed::<f32>(feature, &placement, 1, 100))
                    .collect();
                for tracing in [Tracing::Single, Tracing::Plain] {
                    let found = traced(&tree, tracing, Culling::None, &rays);
                    let through = found.iter().filter(|hit| hit.is_none()).count();
                    assert_eq!(through, 0, "{} {placement:?} of {}", surface.name, rays.len());
                }
            }
        }
    }
}

/// Fast tracing rounds otherwise, and may decide otherwise at an edge: nearly all rays find the same.
#[test]
fn fast_tracing_finds_nearly_always_the_same() {
    let bunny = bunny();
    let rays = trisect_workloads::random_through_box(5, &bunny, 20_000).rays;
    let tree = tree::<MollerTrumbore>(&bunny.triangles);
    let mut hits = Vec::new();
    for culling in [Culling::None, Culling::Back, Culling::Front] {
        let plain = traced(&tree, Tracing::Plain, culling, &rays);
        for tracing in [Tracing::Single, Tracing::Packets] {
            let fast = traced(&tree, tracing, culling, &rays);
            let differ = fast
                .iter()
                .zip(&plain)
                .filter(|(a, b)| a.map(|hit| hit.triangle) != b.map(|hit| hit.triangle));
            assert!(differ.count() < 20, "{culling:?} {tracing:?}");
        }
        hits.push(plain);
    }
    let [both, fronts, backs] = &hits[..] else { unreachable!("there are three") };
    for ((both, front), back) in both.iter().zip(fronts).zip(backs) {
        assert!(both == front || both == back, "what is nearest is one or the other");
    }
    assert!(fronts != backs);
}

fn statistics(triangles: &[Triangle<f32>]) -> Statistics {
    tree::<MollerTrumbore>(triangles).statistics()
}

#[test]
fn meshes_of_all_kinds_are_built_and_traced() {
    let unit = Triangle::<f32>::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let ray = Ray::<f32>::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
    let hit = |triangles: &[Triangle<f32>], ray: Ray<f32>| {
        traced(&tree::<MollerTrumbore>(triangles), Tracing::Single, Culling::None, &[ray])[0]
    };
    let number = |triangles: &[Triangle<f32>], ray| hit(triangles, ray).map(|hit| hit.triangle);
    assert_eq!(number(&[], ray), None);
    assert_eq!(number(&[unit], ray), Some(0));
    // A million copies: bounded in depth and memory, and the lowest number is found.
    let copies = vec![unit; 1_000_000];
    let facts = statistics(&copies);
    assert!(facts.depth < 24, "{facts:?}");
    assert!(facts.bytes < copies.len() * 128, "{facts:?}");
    assert_eq!(number(&copies, ray), Some(0));
    // Ever smaller ones: a chain, if nothing held it.
    let chain: Vec<Triangle<f32>> = (0..1000)
        .map(|k: u16| {
            let size = 0.9_f32.powi(i32::from(k));
            Triangle::new([size, 0.0, 0.0], [1.1 * size, 0.0, 0.0], [size, 0.1 * size, 0.0])
        })
        .collect();
    assert!(statistics(&chain).depth < 80);
    // Nothing to hit: NaN, infinities, no area.
    let nan = Triangle { a: Vec3::new(f32::NAN, 0.0, 0.0), ..unit };
    let infinite = Triangle { b: Vec3::new(0.0, f32::INFINITY, 0.0), ..unit };
    let line = Triangle { c: unit.b, ..unit };
    assert_eq!(number(&[nan, infinite, line], ray), None);
    assert_eq!(number(&[nan, infinite, line, unit], ray), Some(3));
    // Areas that overflow, and those that underflow.
    for size in [1e-18, 1e18] {
        let scaled: Vec<Triangle<f32>> = (0..100_u8)
            .map(|k| {
                let at = |x: f32, y: f32| Vec3::new(x * size, y * size, -f32::from(k) * size);
                Triangle { a: at(0.0, 0.0), b: at(1.0, 0.0), c: at(0.0, 1.0) }
            })
            .collect();
        let o = Vec3::new(0.25, 0.25, 1.0).scale(size);
        let ray = Ray::<f32>::new(o, [0.0, 0.0, -1.0]);
        let found = traced(&tree::<Wald>(&scaled), Tracing::Single, Culling::None, &[ray])[0];
        assert_eq!(found.map(|hit| hit.triangle), Some(0), "{size}");
    }
}

#[test]
fn rays_of_all_kinds_are_survived() {
    let sphere = Surface::sphere(2).triangles::<f32>(&Placement::HERE);
    let tree = tree::<MollerTrumbore>(&sphere);
    let mut rays: Vec<Ray<f32>> =
        Stress::RandomBits.pairs::<f32>(1, 0.0, 5000).into_iter().map(|(ray, _)| ray).collect();
    let inside = Ray::<f32>::new([0.1, 0.2, 0.3], [1.0, 0.0, 0.0]);
    rays.extend([
        Ray { d: Vec3::new(0.0, 0.0, 0.0), ..inside },
        Ray { tmin: 2.0, tmax: 1.0, ..inside },
        Ray { tmin: f32::NAN, ..inside },
        Ray { tmax: f32::NEG_INFINITY, ..inside },
    ]);
    for tracing in [Tracing::Single, Tracing::Plain] {
        for (ray, found) in rays.iter().zip(traced(&tree, tracing, Culling::None, &rays)) {
            let Some(TriangleHit { hit, .. }) = found else { continue };
            assert!([hit.t, hit.beta, hit.gamma].iter().all(|x| x.is_finite()), "{ray:?}");
        }
    }
    // Behind the origin as well, where the interval says so.
    let both_ways = Ray { tmin: f32::NEG_INFINITY, tmax: 0.0, ..inside };
    let found = traced(&tree, Tracing::Single, Culling::None, &[both_ways]);
    assert!(found[0].is_some_and(|found| found.hit.t < 0.0));
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let bunny = bunny();
    let rays = trisect_workloads::random_through_box(2, &bunny, 3000).rays;
    let of_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let tree = tree::<MollerTrumbore>(&bunny.triangles);
            (tree.statistics(), traced(&tree, Tracing::Single, Culling::None, &rays))
        })
    };
    assert_eq!(of_threads(1), of_threads(4));
}
