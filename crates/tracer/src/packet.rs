//! Rays in packets: those that look into one octant go down the tree together. A node's eight children
//! are tested at once for all of them; a child that passes is tested for as many rays at once as there are
//! lanes; and a leaf's triangles, eight at once, for each ray that is left, or one after another for
//! many of them, see [`abreast`].
//!
//! Overbeck, Ramamoorthi, Mark: Large Ray Packets for Real-time Whitted Ray Tracing. IEEE Symposium on
//! Interactive Ray Tracing, 2008.

use trisect_core::{Lanes, Ray, Token as _, Vec3};

use crate::bvh::{Child, WIDTH, child};
use crate::envelope::Envelope;
use crate::hit::Found;
use crate::leaves::Whole;
use crate::rows::{RAYS, Rows, prefetch, splat};
use crate::waiting::{self, Stack};

/// A child that waits for a packet.
#[derive(Clone, Copy)]
struct Waiting {
    /// The [`key`](waiting::key) of its node and lane, with where it begins at the nearest.
    key: u64,
    /// The rays that have met its node.
    rays: u64,
}

/// As [`singly`](crate::single::singly), for rays that go together: in an order of choice, as they are
/// where there are no `numbers`.
pub(crate) fn in_packets<L, T, const ROBUST: bool>(
    tree: Whole<'_>,
    token: L::Token,
    rays: &[Ray<f32>],
    numbers: &[u32],
    found: &mut [T],
) where
    L: Lanes<Elem = f32>,
    T: Found,
{
    token.run(
        #[inline(always)]
        || {
            let mut rows = Rows::EMPTY;
            let mut items = vec![Waiting { key: 0, rays: 0 }; waiting::room(tree.depth)];
            let whole = tree.nodes[0].whole();
            let mut start = 0;
            while start < rays.len() {
                let part = start..rays.len().min(start + RAYS);
                let mut left = if numbers.is_empty() {
                    rows.fill::<L, ROBUST>(token, rays[part.clone()].iter(), &whole, true)
                } else {
                    let numbers = numbers[part.clone()].iter();
                    rows.fill::<L, ROBUST>(
                        token,
                        numbers.map(
                            #[inline(always)]
                            |&number| &rays[number as usize],
                        ),
                        &whole,
                        true,
                    )
                };
                if numbers.is_empty() {
                    prefetch(rays, found, part.end);
                }
                while left != 0 {
                    let envelope = Envelope::new::<L>(token, &rows, left);
                    left &= !envelope.rays;
                    go::<L, ROBUST>(tree, token, &mut rows, envelope, &mut items);
                }
                tree.leaves.arrive(&mut rows);
                if numbers.is_empty() {
                    for (found, best) in found[part.clone()].iter_mut().zip(&rows.best) {
                        *found = T::of(best);
                    }
                } else {
                    for (&number, best) in numbers[part.clone()].iter().zip(&rows.best) {
                        found[number as usize] = T::of(best);
                    }
                }
                start = part.end;
            }
        },
    );
}

/// Takes the rays of an envelope through the tree.
#[inline(always)]
fn go<L: Lanes<Elem = f32>, const ROBUST: bool>(
    tree: Whole<'_>,
    token: L::Token,
    rows: &mut Rows,
    mut envelope: Envelope,
    items: &mut [Waiting],
) {
    let mut waiting = Stack::new(items);
    let mut distances = [0.0; WIDTH];
    let (mut number, mut rays) = (0, envelope.rays);
    loop {
        let node = &tree.nodes[number];
        let mut met = envelope.meet::<L>(token, node, &mut distances);
        let base = waiting.count();
        while met != 0 {
            let lane = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            tree.prefetch(node.children[lane]);
            #[allow(clippy::cast_possible_truncation, reason = "there are fewer nodes than blocks")]
            let place = (number * WIDTH + lane) as u32;
            let key = waiting::key(distances[lane], place);
            waiting.insert(base, Waiting { key, rays }, |waiting| waiting.key);
        }
        loop {
            let Some(next) = waiting.pop() else { return };
            if waiting::distance(next.key) > envelope.tmax {
                continue;
            }
            let place = waiting::place(next.key) as usize;
            let (node, lane) = (&tree.nodes[place / WIDTH], place % WIDTH);
            let (near, far) = envelope.octant.planes::<f32>((), node, lane);
            let met = meet::<L, ROBUST>(token, rows, near, far, next.rays);
            if met == 0 {
                continue;
            }
            match child(node.children[lane]) {
                Child::Node(node) => {
                    (number, rays) = (node, met);
                    break;
                }
                Child::Leaf(first, blocks) => {
                    if tree.leaves.test(rows, met, first..first + blocks) {
                        envelope.shorten::<L>(token, rows);
                    }
                }
            }
        }
    }
}

/// Those of some rays that meet a box, between planes that are nearer and farther to all of them.
#[inline(always)]
fn meet<L: Lanes<Elem = f32>, const ROBUST: bool>(
    token: L::Token,
    rows: &Rows,
    near: Vec3<f32>,
    far: Vec3<f32>,
    rays: u64,
) -> u64 {
    let (near, far) = (splat::<L>(token, near), splat::<L>(token, far));
    let (mut met, mut at) = (0, 0);
    while at < RAYS {
        if rays >> at & ((1 << L::N) - 1) != 0 {
            let slabs = rows.many_slabs::<L>(token, at);
            let interval = rows.many_intervals::<L>(token, at);
            let (from, to) = slabs.cross::<ROBUST>(near, far, interval);
            met |= L::bits(from.le(to)) << at;
        }
        at += L::N;
    }
    met & rays
}
