//! Rays through the tree, each on its own way.

use std::hint::select_unpredictable;

use trisect_core::{Culling, Lanes, Method, Ray, Token as _};

use crate::bvh::{Bvh, Child, Node, WIDTH, child};
use crate::exactly::{Given, arrive, settle_at};
use crate::hit::Found;
use crate::leaf::{end, test_leaf};
use crate::rows::{RAYS, Rows};
use crate::waiting::{self, Stack};

/// What waits to be visited: a child, as the [`key`](waiting::key) of its number; where any hit will do,
/// a node's number and above it, in bits, those of its children that are left.
type Waiting = u64;

/// Rays that are on their way at the same time, at most: while one waits for the outcome of its last
/// test, the others go on.
const MOST_IN_FLIGHT: usize = 4;

/// How many: more lost where it was tried.
const fn in_flight(any: bool) -> usize {
    if any { MOST_IN_FLIGHT } else { 3 }
}

/// A ray under way. Aligned, so that no vector of it is in two cache lines.
#[repr(C, align(64))]
struct Flight<'a> {
    /// Where it meets the children of the node that was visited last.
    distances: [f32; WIDTH],
    /// Those that it meets, in bits. They are looked at when it is the ray's turn again: by then they are
    /// known, and a branch on them that was predicted wrongly costs little.
    met: u64,
    /// Its place.
    place: usize,
    node: &'a Node,
    /// The place of the node, where any hit will do.
    number: usize,
    waiting: Stack<'a, Waiting>,
}

impl<'a> Flight<'a> {
    /// Puts the next of the rays that are left at the root; whether there is one.
    #[inline(always)]
    fn launch<L: Lanes<Elem = f32>, const ANY: bool, const ROBUST: bool>(
        &mut self,
        token: L::Token,
        rows: &Rows,
        root: &'a Node,
        left: &mut u64,
    ) -> bool {
        if *left == 0 {
            return false;
        }
        self.place = left.trailing_zeros() as usize;
        *left &= *left - 1;
        self.waiting.clear();
        self.number = 0;
        self.visit::<L, ANY, ROBUST>(token, rows, root);
        true
    }

    #[inline(always)]
    fn visit<L: Lanes<Elem = f32>, const ANY: bool, const ROBUST: bool>(
        &mut self,
        token: L::Token,
        rows: &Rows,
        node: &'a Node,
    ) {
        let slabs = rows.slabs::<L>(token, self.place);
        let interval = rows.interval::<L>(token, self.place);
        if !ANY {
            self.node = node;
        }
        self.met = 0;
        let mut lane = 0;
        while lane < WIDTH {
            let from = node.planes::<L>(token, [0; 3], lane);
            let to = node.planes::<L>(token, [1; 3], lane);
            let (from, to) = slabs.cross_either_way::<ROBUST>(from, to, interval);
            self.met |= L::bits(from.le(to)) << lane;
            if !ANY {
                from.store(&mut self.distances[lane..]);
            }
            lane += L::N;
        }
    }

    /// The child to visit next, the nearest first; nothing where the ray has arrived.
    #[inline(always)]
    fn nearest(&mut self, rows: &Rows) -> Option<u32> {
        if self.met & self.met.wrapping_sub(1) != 0 {
            return Some(descend(&mut self.waiting, self.node, self.met, &self.distances));
        }
        if self.met == 0 && self.waiting.count() == 0 {
            return None;
        }
        // One child, or none, so what waits on top: without a branch, as neither can be foretold.
        let only = item(self.node, &self.distances, lowest(self.met));
        let mut item = self.waiting.pop_unless(self.met != 0, only);
        // What begins behind the best hit is not worth a visit any more.
        while waiting::distance(item) > rows.tmax(self.place) {
            item = self.waiting.pop()?;
        }
        Some(waiting::place(item))
    }

    /// The same where any order will do: that of the lanes, see the builder. All children that are left
    /// of a node wait as one item, so that how many there are makes no branch, which could not be
    /// foretold.
    #[inline(always)]
    fn next(&mut self, nodes: &[Node]) -> Option<u32> {
        if self.met == 0 && self.waiting.count() == 0 {
            return None;
        }
        let here = self.met << 32 | self.number as u64;
        let item = self.waiting.pop_unless(self.met != 0, here);
        let (met, number) = (item >> 32, item & u64::from(u32::MAX));
        let rest = met & met.wrapping_sub(1);
        self.waiting.push_if(rest != 0, rest << 32 | number);
        #[allow(clippy::cast_possible_truncation, reason = "it has 32 bits")]
        let node = &nodes[number as usize];
        Some(node.children[lowest(met)])
    }

    /// Visits a node or a leaf; whether the ray has arrived.
    #[inline(always)]
    fn step<M, L, const ANY: bool, const ROBUST: bool>(
        &mut self,
        bvh: &'a Bvh<M>,
        token: L::Token,
        culling: Culling,
        rows: &mut Rows,
    ) -> bool
    where
        M: Method,
        L: Lanes<Elem = f32>,
    {
        let next = if ANY { self.next(&bvh.nodes) } else { self.nearest(rows) };
        let Some(current) = next else { return true };
        match child(current) {
            Child::Node(at) => {
                if ANY {
                    self.number = at;
                }
                self.visit::<L, ANY, ROBUST>(token, rows, &bvh.nodes[at]);
            }
            Child::Leaf(first, count) => {
                self.met = 0;
                let blocks = first..first + count;
                let ray = if const { M::INFO.claims.exact } {
                    rows.line(self.place)
                } else {
                    rows.ray(self.place)
                };
                let given = Given { bvh, ray, culling };
                let best = &mut rows.best[self.place % RAYS];
                let left = test_leaf::<M, L, ANY>(token, blocks, given, best);
                settle_at(bvh, culling, rows, self.place, &left);
                let best = &rows.best[self.place % RAYS];
                if best.is_hit() {
                    let tmax = end::<ANY, ROBUST>(best, ray.tmax);
                    rows.end(self.place, tmax);
                    return ANY;
                }
            }
        }
        false
    }
}

/// The nearest hit of each ray, of equally near ones that of the lowest number; any hit where `ANY`. The
/// tests of boxes allow for rounding where `ROBUST`.
#[inline(always)]
pub(crate) fn singly<M, L, T, const ANY: bool, const ROBUST: bool>(
    bvh: &Bvh<M>,
    token: L::Token,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [T],
) where
    M: Method,
    L: Lanes<Elem = f32>,
    T: Found,
{
    let root = &bvh.nodes[0];
    let mut rows = Rows::EMPTY;
    let room = waiting::room(bvh.depth);
    let mut items = vec![0; room * MOST_IN_FLIGHT];
    let mut parts = items.chunks_exact_mut(room);
    let mut flights: [Flight<'_>; MOST_IN_FLIGHT] = std::array::from_fn(|_| Flight {
        place: 0,
        node: root,
        number: 0,
        met: 0,
        distances: [0.0; WIDTH],
        waiting: Stack::new(parts.next().expect("each has its room")),
    });
    for (rays, found) in rays.chunks(RAYS).zip(found.chunks_mut(RAYS)) {
        let mut left = take_in::<L, ROBUST>(&mut rows, token, rays, const { M::INFO.claims.exact });
        let mut count = 0;
        while count < const { in_flight(ANY) }
            && flights[count].launch::<L, ANY, ROBUST>(token, &rows, root, &mut left)
        {
            count += 1;
        }
        let mut at = 0;
        while count > 0 {
            let flight = &mut flights[at % MOST_IN_FLIGHT];
            if flight.step::<M, L, ANY, ROBUST>(bvh, token, culling, &mut rows)
                && !flight.launch::<L, ANY, ROBUST>(token, &rows, root, &mut left)
            {
                count -= 1;
                // The last one takes its place, and its turn.
                flights.swap(at % MOST_IN_FLIGHT, count % MOST_IN_FLIGHT);
                if at == count {
                    at = 0;
                }
                continue;
            }
            at += 1;
            at = select_unpredictable(at == count, 0, at);
        }
        if ANY {
            give_out(&rows, found);
        } else {
            if const { M::INFO.claims.exact } {
                arrive(bvh, &mut rows);
            }
            for (found, best) in found.iter_mut().zip(&rows.best) {
                *found = T::of(best);
            }
        }
    }
}

/// Takes rays in. Out of line: or the constants that it needs take registers, and loads at every step,
/// from the way through the tree.
#[inline(never)]
fn take_in<L: Lanes<Elem = f32>, const ROBUST: bool>(
    rows: &mut Rows,
    token: L::Token,
    rays: &[Ray<f32>],
    lines: bool,
) -> u64 {
    token.run(
        #[inline(always)]
        || rows.fill::<L, ROBUST>(token, rays.iter(), lines),
    )
}

/// Writes down whether rays have found anything. Out of line likewise.
#[inline(never)]
fn give_out<T: Found>(rows: &Rows, found: &mut [T]) {
    for (found, best) in found.iter_mut().zip(&rows.best) {
        *found = T::of(best);
    }
}

/// The child to visit next, the nearest of those that are met. The others wait, the nearer above the
/// farther.
#[inline(always)]
pub(crate) fn descend(
    waiting: &mut Stack<'_, Waiting>,
    node: &Node,
    mut met: u64,
    distances: &[f32; WIDTH],
) -> u32 {
    let first = lowest(met);
    met &= met - 1;
    if met == 0 {
        return node.children[first];
    }
    // Two or three mostly, which is as hard to foretell as their order: so without branches.
    let nearest = item(node, distances, first);
    let second = item(node, distances, lowest(met));
    met &= met - 1;
    let third = select_unpredictable(met != 0, item(node, distances, lowest(met)), NOTHING);
    met &= met.wrapping_sub(1);
    let (nearest, second) = in_order(nearest, second);
    let (second, third) = in_order(second, third);
    let (mut nearest, second) = in_order(nearest, second);
    let base = waiting.count();
    waiting.push_if(third != NOTHING, third);
    waiting.push(second);
    while met != 0 {
        let other = item(node, distances, lowest(met));
        met &= met - 1;
        waiting.insert(base, nearest.max(other), |item| item);
        nearest = nearest.min(other);
    }
    waiting::place(nearest)
}

/// No child: farther than all.
const NOTHING: Waiting = u64::MAX;

/// The nearer first.
#[inline(always)]
fn in_order(a: Waiting, b: Waiting) -> (Waiting, Waiting) {
    let is_less = a < b;
    (select_unpredictable(is_less, a, b), select_unpredictable(is_less, b, a))
}

/// The place of the lowest bit.
#[inline(always)]
fn lowest(bits: u64) -> usize {
    bits.trailing_zeros() as usize % WIDTH
}

/// A child and where the ray enters it.
#[inline(always)]
fn item(node: &Node, distances: &[f32; WIDTH], lane: usize) -> Waiting {
    waiting::key(distances[lane], node.children[lane])
}
