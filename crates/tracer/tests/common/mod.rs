//! What the tests of the tracer share.
#![allow(dead_code, unreachable_pub, reason = "each test file uses some of it")]

use trisect_core::{Ray, Triangle};
use trisect_kernels::{PADDING, PreparedTriangles, one_ray};
use trisect_method::{Culling, Deferred, Method, TrueDivision};
use trisect_tracer::{Builder, Bvh, Tracing, Tree, TriangleHit};
use trisect_workloads::Mesh;

/// The closest hit of each ray, every triangle being tested.
pub fn brute_force<M: Method>(
    triangles: &[Triangle<f32>],
    rays: &[Ray<f32>],
    culling: Culling,
) -> Vec<Option<TriangleHit>> {
    let prepared = PreparedTriangles::<M, f32>::new(triangles).expect("it takes all meshes");
    let closest = |ray: &Ray<f32>| {
        let mut best: Option<TriangleHit> = None;
        one_ray::<M, f32, Deferred<TrueDivision, true>>(
            (),
            ray,
            &prepared,
            culling,
            |tested, met, hit| {
                let triangle = prepared.number(tested.triangle_place);
                let nearer = best.is_none_or(|best| {
                    hit.t < best.hit.t || hit.t == best.hit.t && triangle < best.triangle
                });
                if met && triangle != PADDING && nearer {
                    best = Some(TriangleHit { triangle, hit });
                }
            },
        );
        best
    };
    rays.iter().map(closest).collect()
}

/// Built by the builder of choice.
pub fn tree_by<M: Method>(builder: Builder, triangles: &[Triangle<f32>]) -> Bvh<M> {
    Bvh::build(triangles, builder).expect("it takes all meshes")
}

/// The tree's answers; any-hit and closest-hit are held to each other, and so are rays that go singly
/// and those that go together, and those that are handed over one by one.
pub fn traced(
    tree: &dyn Tree,
    tracing: Tracing,
    culling: Culling,
    rays: &[Ray<f32>],
) -> Vec<Option<TriangleHit>> {
    let mut found = vec![None; rays.len()];
    tree.closest(tracing, culling, rays, &mut found);
    let mut any = vec![false; rays.len()];
    tree.any(tracing, culling, rays, &mut any);
    for ((found, any), ray) in found.iter().zip(&any).zip(rays) {
        assert_eq!(found.is_some(), *any, "{ray:?}");
    }
    if tracing == Tracing::Single {
        for ((found, any), ray) in found.iter().zip(&any).zip(rays) {
            let alone = (tree.closest_hit(culling, ray).found(), tree.any_hit(culling, ray));
            assert_eq!(alone, (*found, *any), "{ray:?}");
        }
        let together = traced(tree, Tracing::Packets, culling, rays);
        for ((found, together), ray) in found.iter().zip(&together).zip(rays) {
            let t = |hit: &Option<TriangleHit>| hit.map_or(f32::MAX, |hit| hit.hit.t);
            let (found, together) = (t(found), t(together));
            // The nearer box may be culled by a hit that is as near but for its rounding.
            assert!((found - together).abs() <= 4.0 * f32::EPSILON * found.abs(), "{ray:?}");
        }
    }
    found
}

/// The trees answer in plain arithmetic, whatever is culled, as testing every triangle does.
pub fn answers<M: Method>(
    name: &str,
    trees: &[Bvh<M>],
    triangles: &[Triangle<f32>],
    rays: &[Ray<f32>],
) {
    for culling in [Culling::None, Culling::Back, Culling::Front] {
        let all = brute_force::<M>(triangles, rays, culling);
        for tree in trees {
            let found = traced(tree, Tracing::Plain, culling, rays);
            traced(tree, Tracing::Single, culling, rays);
            let builder = tree.statistics().builder;
            for ((all, found), ray) in all.iter().zip(&found).zip(rays) {
                assert_eq!(all, found, "{name}, {builder}, {}, {culling:?}, {ray:?}", M::INFO.name);
            }
        }
    }
}

/// Camera rays, random ones, and rays from corner to corner, where boxes meet.
pub fn rays_of(mesh: &Mesh) -> Vec<Ray<f32>> {
    let mut rays = trisect_workloads::primary(mesh, 16, 16).rays;
    rays.extend(trisect_workloads::random_through_box(1, mesh, 200).rays);
    let corners = mesh.triangles.iter().step_by(97).zip(mesh.triangles.iter().rev().step_by(89));
    rays.extend(corners.take(100).map(|(from, to)| {
        let o = from.a + (from.a - to.a);
        Ray::<f32>::new(o, to.b - o)
    }));
    rays
}
