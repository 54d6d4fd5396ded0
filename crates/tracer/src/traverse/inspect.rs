//! One ray down the tree for inspection: how many tests it takes, and which triangles it may hit.
//!
//! In plain arithmetic, one box at a time, and apart from the loops that trace, so that these count nothing.

use std::ops::Range;

use trisect_core::Ray;
use trisect_method::{Culling, Interval};

use super::single::descend;
use super::stack::{self, Stack};
use crate::bvh::node::{Child, child};
use crate::bvh::wide::WideTree;
use crate::hit::TriangleHit;
use crate::lanes::PlainLanes;
use crate::leaf::erased::ErasedLeaves;
use crate::query::Robust;
use crate::rays::batch::RayBatch;
use crate::rays::slabs::Slabs;
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

/// Visits the leaves that a ray may meet, near ones first; how many nodes it visits. `leaf` gets the blocks of one, and
/// says where the interval of the ray ends from then on.
fn walk(tree: &WideTree, ray: &Ray<f32>, leaf: &mut dyn FnMut(Range<usize>) -> f32) -> usize {
    let Interval { tmin, mut tmax } = Interval::of(ray);
    let slabs = Slabs::new::<Robust>(ray);
    let mut items = vec![0; stack::room(tree.depth)];
    let mut waiting = Stack::new(&mut items);
    let mut visited = 0;
    waiting.push(stack::key(tmin, 0));
    while let Some(item) = waiting.pop() {
        // What begins behind the best hit need not be visited any more.
        if stack::distance(item) > tmax {
            continue;
        }
        let mut current = stack::item(item);
        while let Child::Node(at) = child(current) {
            visited += 1;
            let node = &tree.nodes[at];
            let (mut met, mut distances) = (0_u64, [0.0; WIDTH]);
            for (lane, distance) in distances.iter_mut().enumerate() {
                let from = node.planes::<f32>((), [0; 3], lane);
                let to = node.planes::<f32>((), [1; 3], lane);
                let (from, to) = slabs.cross_either_way::<Robust>(from, to, (tmin, tmax));
                met |= u64::from(from <= to) << lane;
                *distance = from;
            }
            if met == 0 {
                break;
            }
            current = descend(&mut waiting, node, met, &distances);
        }
        if let Child::Leaf(first, count) = child(current) {
            tmax = leaf(first..first + count);
        }
    }
    visited
}

/// The closest hit of a ray, and what it takes to find it.
pub(crate) fn count(tree: &WideTree, leaves: &dyn ErasedLeaves, ray: &Ray<f32>) -> Counted {
    let mut counted = Counted::default();
    leaves.plain(PlainLanes::Scalar, Culling::None, &mut |tester| {
        // A leaf takes the interval as it is.
        let Interval { tmin, tmax } = Interval::of(ray);
        let mut rays = RayBatch::EMPTY;
        rays.set(0, &Ray { tmin, tmax, ..*ray });
        counted.nodes = walk(tree, ray, &mut |blocks| {
            for block in blocks.clone() {
                counted.triangles += distinct(leaves.triangles(block)).len();
            }
            tester.test(&mut rays, 1, blocks);
            rays.tmax(0)
        });
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
    walk(tree, ray, &mut |blocks| {
        for block in blocks {
            for &triangle in distinct(leaves.triangles(block)) {
                tmax = visit(triangle);
            }
        }
        tmax
    });
}

/// The triangles of a block: where it is not full, the last one is repeated.
fn distinct(triangles: &[u32; WIDTH]) -> &[u32] {
    let last = triangles[WIDTH - 1];
    let count = triangles.iter().position(|&triangle| triangle == last).map_or(WIDTH, |at| at + 1);
    &triangles[..count]
}
