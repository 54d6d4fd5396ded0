//! One ray down the tree for those who look on: how many tests it takes, and which triangles it may hit.
//!
//! In plain arithmetic, one box at a time. What a method does in a leaf is behind a call, so that the way
//! itself is compiled once for all of them, and what is fast has nothing to count.

use std::ops::Range;

use trisect_core::{Culling, Interval, Method, Ray};

use crate::bvh::{Bvh, Child, Node, WIDTH, child};
use crate::exactly::{Given, arrived, settle};
use crate::hit::{Found as _, NO_HIT, TriangleHit};
use crate::leaf::{end, test_leaf};
use crate::single::descend;
use crate::slabs::Slabs;
use crate::waiting::{self, Stack};

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

/// Goes down the tree, near leaves first, with a call for the blocks of each leaf that says where the
/// ray's interval ends from then on. How many nodes it visits.
fn walk(
    nodes: &[Node],
    depth: usize,
    ray: &Ray<f32>,
    leaf: &mut dyn FnMut(Range<usize>) -> f32,
) -> usize {
    let Interval { tmin, mut tmax } = Interval::of(ray);
    let slabs = Slabs::new::<true>(ray);
    let mut items = vec![0; waiting::room(depth)];
    let mut waiting = Stack::new(&mut items);
    let mut visited = 0;
    waiting.push(waiting::key(tmin, 0));
    while let Some(item) = waiting.pop() {
        // What begins behind the best hit is not worth a visit any more.
        if waiting::distance(item) > tmax {
            continue;
        }
        let mut current = waiting::place(item);
        while let Child::Node(at) = child(current) {
            visited += 1;
            let node = &nodes[at];
            let (mut met, mut distances) = (0_u64, [0.0; WIDTH]);
            for (lane, distance) in distances.iter_mut().enumerate() {
                let from = node.planes::<f32>((), [0; 3], lane);
                let to = node.planes::<f32>((), [1; 3], lane);
                let (from, to) = slabs.cross_either_way::<true>(from, to, (tmin, tmax));
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

impl<M: Method> Bvh<M> {
    /// As [`Tree::count`](crate::Tree::count).
    pub(crate) fn counted(&self, ray: &Ray<f32>) -> Counted {
        // The interval of the contract, as wherever rays are traced: a leaf takes it as it is.
        let Interval { tmin, tmax } = Interval::of(ray);
        let (mut best, mut rest, mut triangles) = (NO_HIT, Ray { tmin, tmax, ..*ray }, 0);
        let nodes = walk(&self.nodes, self.depth, ray, &mut |blocks| {
            for block in &self.blocks[blocks.clone()] {
                triangles += distinct(&block.triangles).len();
            }
            let given = Given { bvh: self, ray: rest, culling: Culling::None };
            let left = test_leaf::<M, f32, false>((), blocks, given, &mut best);
            if const { M::INFO.claims.exact } && left.near != 0 {
                settle(given, left, &mut best);
            }
            if best.is_hit() {
                rest.tmax = end::<false, true>(&best, rest.tmax);
            }
            rest.tmax
        });
        if const { M::INFO.claims.exact } {
            best = arrived(self, ray, &best);
        }
        Counted { found: Option::of(&best), nodes, triangles }
    }

    /// As [`Tree::candidates`](crate::Tree::candidates).
    pub(crate) fn visit_candidates(&self, ray: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
        let mut tmax = ray.tmax;
        walk(&self.nodes, self.depth, ray, &mut |blocks| {
            for block in &self.blocks[blocks] {
                for &triangle in distinct(&block.triangles) {
                    tmax = visit(triangle);
                }
            }
            tmax
        });
    }
}

/// The triangles of a block: where there are fewer than it holds, the last is repeated.
fn distinct(triangles: &[u32; WIDTH]) -> &[u32] {
    let last = triangles[WIDTH - 1];
    let count = triangles.iter().position(|&triangle| triangle == last).map_or(WIDTH, |at| at + 1);
    &triangles[..count]
}
