//! Rays in packets: those whose directions are in one octant go down the tree together. A node's eight children are
//! tested at once for all of them; a child that passes is tested for as many rays at once as there are lanes;
//! then a leaf tests its triangles, eight at once for each ray that is left, or one after another for many rays
//! at once.
//!
//! Overbeck, Ramamoorthi, Mark: Large Ray Packets for Real-time Whitted Ray Tracing. IEEE Symposium on
//! Interactive Ray Tracing, 2008.

use trisect_core::{Lanes, Ray, Token as _, Vec3};

use super::stack::{self, Stack};
use crate::bvh::node::{Child, child};
use crate::bvh::wide::WideTree;
use crate::leaf::erased::LeafTester;
use crate::query::{Boxes, Query};
use crate::rays::batch::{RAYS, RayBatch, prefetch};
use crate::rays::packet_bounds::PacketBounds;
use crate::vectors::{WIDTH, splat};

/// A child that waits for a packet.
#[derive(Clone, Copy)]
struct Waiting {
    /// The [`key`](stack::key) of its node and lane, by the least distance at which a ray may enter it.
    key: u64,
    /// The rays that have met its node.
    rays: u64,
}

/// As [`singly`](super::single::singly), for rays that go together: in the order of `indices`, or as they are where
/// there are none.
pub(crate) fn in_packets<T, L, Q>(
    tree: &WideTree,
    leaves: &mut T,
    token: L::Token,
    rays: &[Ray<f32>],
    indices: Option<&[u32]>,
    found: &mut [Q::Output],
) where
    T: LeafTester<Q::Found>,
    L: Lanes<Elem = f32>,
    Q: Query,
{
    token.run(
        #[inline(always)]
        || {
            let mut batch = RayBatch::EMPTY;
            let mut items = vec![Waiting { key: 0, rays: 0 }; stack::room(tree.depth)];
            let whole = tree.nodes[0].whole();
            let reach = whole.largest();
            let mut start = 0;
            while start < rays.len() {
                let part = start..rays.len().min(start + RAYS);
                let mut left = if let Some(indices) = indices {
                    let indices = indices[part.clone()].iter();
                    batch.fill::<L, Q::Boxes>(
                        token,
                        indices.map(
                            #[inline(always)]
                            |&index| &rays[index as usize],
                        ),
                        &whole,
                        true,
                    )
                } else {
                    let filled =
                        batch.fill::<L, Q::Boxes>(token, rays[part.clone()].iter(), &whole, true);
                    prefetch(rays, found, part.end);
                    filled
                };
                leaves.clear();
                while left != 0 {
                    let bounds = PacketBounds::new::<L>(token, &batch, left, reach);
                    left &= !bounds.rays;
                    go::<T, L, Q>(tree, leaves, token, &mut batch, bounds, &mut items);
                }
                let of_batch = leaves.finish(&batch).iter();
                if let Some(indices) = indices {
                    for (&index, of_ray) in indices[part.clone()].iter().zip(of_batch) {
                        found[index as usize] = Q::output(of_ray);
                    }
                } else {
                    for (found, of_ray) in found[part.clone()].iter_mut().zip(of_batch) {
                        *found = Q::output(of_ray);
                    }
                }
                start = part.end;
            }
        },
    );
}

/// Takes the rays of a packet through the tree.
#[inline(always)]
fn go<T, L, Q>(
    tree: &WideTree,
    leaves: &mut T,
    token: L::Token,
    batch: &mut RayBatch,
    mut bounds: PacketBounds,
    items: &mut [Waiting],
) where
    T: LeafTester<Q::Found>,
    L: Lanes<Elem = f32>,
    Q: Query,
{
    let mut waiting = Stack::new(items);
    let mut distances = [0.0; WIDTH];
    let (mut index, mut rays) = (0, bounds.rays);
    loop {
        let node = &tree.nodes[index];
        let mut met = bounds.meet::<L>(token, node, &mut distances);
        let base = waiting.count();
        while met != 0 {
            let lane = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            match child(node.children[lane]) {
                Child::Node(index) => tree.nodes[index].prefetch(),
                Child::Leaf(first, _) => leaves.prefetch(first),
            }
            #[allow(clippy::cast_possible_truncation, reason = "there are fewer nodes than blocks")]
            let item = (index * WIDTH + lane) as u32;
            let key = stack::key(distances[lane], item);
            waiting.insert(base, Waiting { key, rays }, |waiting| waiting.key);
        }
        loop {
            let Some(next) = waiting.pop() else { return };
            if stack::distance(next.key) > bounds.tmax {
                continue;
            }
            let item = stack::item(next.key) as usize;
            let (node, lane) = (&tree.nodes[item / WIDTH], item % WIDTH);
            let (near, far) = bounds.octant.planes::<f32>((), node, lane);
            let met = meet::<L, Q::Boxes>(token, batch, near, far, next.rays);
            if met == 0 {
                continue;
            }
            match child(node.children[lane]) {
                Child::Node(node) => {
                    (index, rays) = (node, met);
                    break;
                }
                Child::Leaf(first, blocks) => {
                    if leaves.test(batch, met, first..first + blocks) {
                        bounds.shorten::<L>(token, batch);
                    }
                }
            }
        }
    }
}

/// Those of some rays, in bits, that meet a box, given its planes that are nearer and farther for all of them.
#[inline(always)]
fn meet<L: Lanes<Elem = f32>, B: Boxes>(
    token: L::Token,
    batch: &RayBatch,
    near: Vec3<f32>,
    far: Vec3<f32>,
    rays: u64,
) -> u64 {
    let (near, far) = (splat::<L>(token, near), splat::<L>(token, far));
    let (mut met, mut at) = (0, 0);
    while at < RAYS {
        if rays >> at & ((1 << L::N) - 1) != 0 {
            let slabs = batch.many_slabs::<L>(token, at);
            let interval = batch.many_intervals::<L>(token, at);
            let (from, to) = slabs.cross::<B>(near, far, interval);
            met |= L::bits(from.le(to)) << at;
        }
        at += L::N;
    }
    met & rays
}
