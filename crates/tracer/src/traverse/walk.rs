//! One ray down the tree, leaf by leaf: near ones first, and no box left out that the ray truly meets.
//!
//! Apart from the loops that trace, and compiled once for all methods.

use std::ops::Range;

use trisect_core::{Lanes, Ray, Token as _, Vec3};
use trisect_method::Interval;

use super::single::{descend, lowest};
use super::stack::{self, Stack};
use crate::bvh::node::{Child, child};
use crate::bvh::wide::WideTree;
use crate::lanes::Job;
use crate::query::Robust;
use crate::rays::slabs::{Slabs, moves, outwards};
use crate::vectors::WIDTH;

/// Visits the leaves that a ray may meet; how many nodes it visits.
pub(crate) struct Walk<'a> {
    pub(crate) tree: &'a WideTree,
    pub(crate) ray: &'a Ray<f32>,
    /// Takes the blocks of a leaf, and says where the interval of the ray ends from then on.
    pub(crate) leaf: &'a mut dyn FnMut(Range<usize>) -> f32,
}

impl Job for Walk<'_> {
    type Output = usize;

    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) -> usize {
        token.run(
            #[inline(always)]
            || {
                stack::declare_room!(items, stack::room(self.tree.depth));
                walk::<L>(token, self, 0.0, items)
            },
        )
    }
}

/// Points that are asked what is above them, one after another.
pub(crate) trait Points {
    /// The next one, among the boxes; none after the last.
    fn next(&mut self) -> Option<Vec3<f32>>;

    /// Takes the blocks of a leaf that may be above it; whether it asks for more.
    fn leaf(&mut self, blocks: Range<usize>) -> bool;
}

/// Visits the leaves that may be above points, along the last axis, in no order.
///
/// A ray along an axis meets a box where their extents overlap: no distance is computed, and nothing rounds but the
/// margin, which is that of [`Slabs`]. What is infinite or NaN is above nothing.
pub(crate) struct Above<'a> {
    pub(crate) tree: &'a WideTree,
    pub(crate) points: &'a mut dyn Points,
}

impl Job for Above<'_> {
    type Output = ();

    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        token.run(
            #[inline(always)]
            || {
                let Self { tree, points } = self;
                stack::declare_room!(items, stack::room(tree.depth));
                while let Some(point) = points.next() {
                    above::<L>(token, tree, point, items, points);
                }
            },
        );
    }
}

#[inline(always)]
fn above<L: Lanes<Elem = f32>>(
    token: L::Token,
    tree: &WideTree,
    point: Vec3<f32>,
    items: &mut [u64],
    points: &mut dyn Points,
) {
    let by = outwards(tree.reach, point.largest_magnitude());
    let low = point.map(
        #[inline(always)]
        |x| L::splat(token, x - by),
    );
    let high = point.map(
        #[inline(always)]
        |x| L::splat(token, x + by),
    );
    let mut waiting = Stack::new(items);
    waiting.push(stack::key(0.0, 0));
    while let Some(item) = waiting.pop() {
        let at = match child(stack::item(item)) {
            Child::Node(at) => at,
            Child::Leaf(first, count) => {
                if points.leaf(first..first + count) {
                    continue;
                }
                break;
            }
        };
        let node = &tree.nodes[at];
        let (mut met, mut lane) = (0, 0);
        while lane < WIDTH {
            let from = node.planes::<L>(token, [0; 3], lane);
            let to = node.planes::<L>(token, [1; 3], lane);
            let is_along = from.x.le(high.x) & low.x.le(to.x);
            let is_across = from.y.le(high.y) & low.y.le(to.y);
            met |= L::bits(is_along & is_across & low.z.le(to.z)) << lane;
            lane += L::N;
        }
        while met != 0 {
            waiting.push(stack::key(0.0, node.children[lowest(met)]));
            met &= met - 1;
        }
    }
}

/// Rays, one after another, where every box is larger by a margin on each side.
pub(crate) struct WideWalks<'a> {
    pub(crate) tree: &'a WideTree,
    pub(crate) rays: &'a [Ray<f32>],
    /// By how much, for a ray.
    pub(crate) margin: &'a dyn Fn(&Ray<f32>) -> f32,
    /// Takes the index of the ray, and is as that of [`Walk`].
    pub(crate) leaf: &'a mut dyn FnMut(usize, Range<usize>) -> f32,
}

impl Job for WideWalks<'_> {
    type Output = ();

    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        token.run(
            #[inline(always)]
            || {
                let Self { tree, rays, margin, leaf } = self;
                stack::declare_room!(items, stack::room(tree.depth));
                for (index, ray) in rays.iter().enumerate() {
                    let leaf = &mut |blocks: Range<usize>| leaf(index, blocks);
                    walk::<L>(token, Walk { tree, ray, leaf }, margin(ray), items);
                }
            },
        );
    }
}

#[inline(always)]
fn walk<L: Lanes<Elem = f32>>(
    token: L::Token,
    Walk { tree, ray, leaf }: Walk<'_>,
    margin: f32,
    items: &mut [u64],
) -> usize {
    let Interval { tmin, mut tmax } = Interval::of(ray);
    let slabs = Slabs::new::<Robust>(&Ray::splat(token, ray), tree.reach + margin).widened(margin);
    let mut waiting = Stack::new(items);
    let mut visited = 0;
    if moves(ray) {
        waiting.push(stack::key(tmin, 0));
    }
    while let Some(item) = waiting.pop() {
        // What begins behind the best hit need not be visited any more.
        if stack::distance(item) > tmax {
            continue;
        }
        let interval = (L::splat(token, tmin), L::splat(token, tmax));
        let mut current = stack::item(item);
        while let Child::Node(at) = child(current) {
            visited += 1;
            let node = &tree.nodes[at];
            let (mut met, mut distances, mut lane) = (0, [0.0; WIDTH], 0);
            while lane < WIDTH {
                let from = node.planes::<L>(token, [0; 3], lane);
                let to = node.planes::<L>(token, [1; 3], lane);
                let (from, to) = slabs.cross_either_way::<Robust>(from, to, interval);
                met |= L::bits(from.le(to)) << lane;
                from.store(&mut distances[lane..]);
                lane += L::N;
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
