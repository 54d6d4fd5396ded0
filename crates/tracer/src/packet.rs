//! Rays in packets: those that look into one octant go down the tree together. A node's eight children
//! are tested at once for all of them; a child that passes is tested for as many rays at once as there are
//! lanes; and a leaf's triangles, eight at once, for each ray that is left.
//!
//! Overbeck, Ramamoorthi, Mark: Large Ray Packets for Real-time Whitted Ray Tracing. IEEE Symposium on
//! Interactive Ray Tracing, 2008.

use std::hint::select_unpredictable;
use std::ops::Range;

use trisect_core::{Culling, Lanes, Method, Ray, Token as _, Vec3};

use crate::bvh::{Bvh, Child, Node, WIDTH, child};
use crate::envelope::Envelope;
use crate::exactly::{Given, arrive, settle_at};
use crate::hit::Found;
use crate::leaf::{end, test_leaf};
use crate::rows::{RAYS, Rows, splat};
use crate::waiting::{self, Stack};

/// A child that waits for a packet.
#[derive(Clone, Copy)]
struct Waiting {
    /// The [`key`](waiting::key) of its node and lane, with where it begins at the nearest.
    key: u64,
    /// The rays that have met its node.
    rays: u64,
}

/// The leaves of a tree, whatever their method: a packet is so long in a leaf that a call costs nothing,
/// and the way through the nodes is compiled once.
pub(crate) trait Leaves {
    /// Has a leaf fetched that will be visited.
    fn prefetch(&self, first: usize);

    /// Tests its triangles for those rays; whether any of them has hit anything so far.
    fn test(&self, rows: &mut Rows, rays: u64, blocks: Range<usize>) -> bool;

    /// Computes what is left to compute of rays that have arrived.
    fn arrive(&self, rows: &mut Rows);
}

/// The leaves of a tree for [`Leaves`], tested on lanes of choice.
pub(crate) struct LeavesOf<'a, M: Method, L: Lanes, const ANY: bool, const ROBUST: bool> {
    pub(crate) bvh: &'a Bvh<M>,
    pub(crate) token: L::Token,
}

impl<M, L, const ANY: bool, const ROBUST: bool> Leaves for LeavesOf<'_, M, L, ANY, ROBUST>
where
    M: Method,
    L: Lanes<Elem = f32>,
{
    fn prefetch(&self, first: usize) {
        if let Some(block) = self.bvh.blocks.get(first) {
            block.prefetch();
        }
    }

    fn test(&self, rows: &mut Rows, mut rays: u64, blocks: Range<usize>) -> bool {
        let Self { bvh, token } = *self;
        token.run(
            #[inline(always)]
            || {
                let mut any = false;
                while rays != 0 {
                    let place = rays.trailing_zeros() as usize % RAYS;
                    rays &= rays - 1;
                    let (ray, best) = (rows.ray(place), &mut rows.best[place]);
                    let blocks = blocks.clone();
                    let given = Given { bvh, ray, culling: Culling::None };
                    let left = test_leaf::<M, L, ANY>(token, blocks, given, best);
                    settle_at(bvh, Culling::None, rows, place, &left);
                    let best = &rows.best[place];
                    let is_hit = best.is_hit();
                    any |= is_hit;
                    let tmax = end::<ANY, ROBUST>(best, ray.tmax);
                    rows.end(place, select_unpredictable(is_hit, tmax, ray.tmax));
                }
                any
            },
        )
    }

    fn arrive(&self, rows: &mut Rows) {
        if const { M::INFO.claims.exact && !ANY } {
            let Self { bvh, token } = *self;
            token.run(
                #[inline(always)]
                || arrive(bvh, rows),
            );
        }
    }
}

/// The nodes of a tree, and its leaves.
#[derive(Clone, Copy)]
pub(crate) struct Whole<'a> {
    pub(crate) nodes: &'a [Node],
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    pub(crate) leaves: &'a dyn Leaves,
}

impl Whole<'_> {
    /// Has a child fetched that will be visited.
    #[inline(always)]
    fn prefetch(self, number: u32) {
        match child(number) {
            Child::Node(at) => self.nodes[at].prefetch(),
            Child::Leaf(first, _) => self.leaves.prefetch(first),
        }
    }
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
            let mut start = 0;
            while start < rays.len() {
                let part = start..rays.len().min(start + RAYS);
                let mut left = if numbers.is_empty() {
                    rows.fill::<L, ROBUST>(token, rays[part.clone()].iter(), false)
                } else {
                    let numbers = numbers[part.clone()].iter();
                    rows.fill::<L, ROBUST>(
                        token,
                        numbers.map(
                            #[inline(always)]
                            |&number| &rays[number as usize],
                        ),
                        false,
                    )
                };
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
