//! One ray down the tree for inspection: how many tests it takes, and which triangles it may hit.
//!
//! In plain arithmetic, and apart from the loops that trace, so that these count nothing.

use std::ops::Range;

use trisect_core::Ray;
use trisect_method::{Culling, Interval};

use super::walk::Walk;
use crate::bvh::wide::WideTree;
use crate::hit::TriangleHit;
use crate::lanes::PlainLanes;
use crate::leaf::erased::ErasedLeaves;
use crate::rays::batch::RayBatch;
use crate::vectors::WIDTH;

/// A ray's closest hit, and what it took to find it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counted {
    /// The hit.
    pub found: Option<TriangleHit>,
    /// Nodes visited, whose eight boxes are tested together.
    pub nodes: usize,
    /// Triangles tested.
    pub triangles: usize,
}

/// The closest hit of a ray, and what it takes to find it.
pub(crate) fn inspect(tree: &WideTree, leaves: &dyn ErasedLeaves, ray: &Ray<f32>) -> Counted {
    let mut counted = Counted::default();
    leaves.plain(PlainLanes::Scalar, Culling::None, &mut |tester| {
        // A leaf takes the interval as it is.
        let Interval { tmin, tmax } = Interval::of(ray);
        let mut rays = RayBatch::EMPTY;
        rays.set(0, &Ray { tmin, tmax, ..*ray });
        let leaf = &mut |blocks: Range<usize>| {
            for block in blocks.clone() {
                counted.triangles += distinct(leaves.triangles(block)).len();
            }
            tester.test(&mut rays, 1, blocks);
            rays.tmax(0)
        };
        counted.nodes = PlainLanes::Scalar.run(Walk { tree, ray, leaf });
        let found = tester.finish(&rays)[0];
        counted.found = found.is_hit().then_some(found);
    });
    counted
}

/// Visits the triangles that a ray may hit. `visit` says where its interval ends from then on.
pub(crate) fn candidates(
    tree: &WideTree,
    leaves: &dyn ErasedLeaves,
    ray: &Ray<f32>,
    visit: &mut dyn FnMut(u32) -> f32,
) {
    let mut tmax = ray.tmax;
    let leaf = &mut |blocks: Range<usize>| {
        for block in blocks {
            for &triangle in distinct(leaves.triangles(block)) {
                tmax = visit(triangle);
            }
        }
        tmax
    };
    PlainLanes::Scalar.run(Walk { tree, ray, leaf });
}

/// The triangles of a block: where it is not full, the last one is repeated.
fn distinct(triangles: &[u32; WIDTH]) -> &[u32] {
    let last = triangles[WIDTH - 1];
    let count = triangles.iter().position(|&triangle| triangle == last).map_or(WIDTH, |at| at + 1);
    &triangles[..count]
}
