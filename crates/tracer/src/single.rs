//! Rays through the tree, each on its own way.

use std::hint::select_unpredictable;

use trisect_core::{Lanes, Ray, Token as _};

use crate::bvh::{Child, Node, WIDTH, child};
use crate::hit::Found;
use crate::leaves::ForSingleRays;
use crate::rows::{RAYS, Rows, prefetch};
use crate::waiting::{self, Stack};

/// What waits to be visited: a child, as the [`key`](waiting::key) of its number; where any hit will do,
/// a node's number and above it, in bits, those of its children that are left.
type Waiting = u64;

/// Rays that are on their way at the same time: while one waits for the outcome of its last test, the
/// others go on. More lost where it was tried.
const IN_FLIGHT: usize = 4;

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
    fn step<A, L, const ANY: bool, const ROBUST: bool>(
        &mut self,
        tree: &'a A,
        token: L::Token,
        rows: &mut Rows,
    ) -> bool
    where
        A: ForSingleRays<L, ANY, ROBUST>,
        L: Lanes<Elem = f32>,
    {
        let next = if ANY { self.next(tree.nodes()) } else { self.nearest(rows) };
        let Some(current) = next else { return true };
        match child(current) {
            Child::Node(at) => {
                if ANY {
                    self.number = at;
                }
                self.visit::<L, ANY, ROBUST>(token, rows, &tree.nodes()[at]);
            }
            Child::Leaf(first, count) => {
                self.met = 0;
                if tree.test(token, rows, self.place, first..first + count) {
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
pub(crate) fn singly<A, L, T, const ANY: bool, const ROBUST: bool>(
    tree: &A,
    token: L::Token,
    rays: &[Ray<f32>],
    found: &mut [T],
) where
    A: ForSingleRays<L, ANY, ROBUST>,
    L: Lanes<Elem = f32>,
    T: Found,
{
    let root = &tree.nodes()[0];
    let whole = root.whole();
    let mut rows = Rows::EMPTY;
    let room = waiting::room(tree.depth());
    let mut items = vec![0; room * IN_FLIGHT];
    let mut parts = items.chunks_exact_mut(room);
    let mut flights: [Flight<'_>; IN_FLIGHT] = std::array::from_fn(|_| Flight {
        place: 0,
        node: root,
        number: 0,
        met: 0,
        distances: [0.0; WIDTH],
        waiting: Stack::new(parts.next().expect("each has its room")),
    });
    let mut start = 0;
    while start < rays.len() {
        let end = rays.len().min(start + RAYS);
        prefetch(rays, found, end);
        let (rays, found) = (&rays[start..end], &mut found[start..end]);
        start = end;
        let some = rows.fill::<L, ROBUST>(token, rays.iter(), &whole, A::LINES);
        go::<A, L, ANY, ROBUST>(tree, token, &mut rows, &mut flights, some);
        tree.arrive(&mut rows);
        if ANY {
            give_out(&rows, found);
        } else {
            for (found, best) in found.iter_mut().zip(&rows.best) {
                *found = T::of(best);
            }
        }
    }
}

/// Writes down what rays have found.
#[inline(never)]
fn give_out<T: Found>(rows: &Rows, found: &mut [T]) {
    for (found, best) in found.iter_mut().zip(&rows.best) {
        *found = T::of(best);
    }
}

/// Takes rays through the tree. Out of line: what is done before and after needs constants and registers
/// that are wanted here.
#[inline(never)]
fn go<'a, A, L, const ANY: bool, const ROBUST: bool>(
    tree: &'a A,
    token: L::Token,
    rows: &mut Rows,
    flights: &mut [Flight<'a>; IN_FLIGHT],
    some: u64,
) where
    A: ForSingleRays<L, ANY, ROBUST>,
    L: Lanes<Elem = f32>,
{
    token.run(
        #[inline(always)]
        || {
            let root = &tree.nodes()[0];
            let (mut left, mut count) = (some, 0);
            while count < IN_FLIGHT
                && flights[count].launch::<L, ANY, ROBUST>(token, rows, root, &mut left)
            {
                count += 1;
            }
            let mut at = 0;
            while count > 0 {
                let flight = &mut flights[at % IN_FLIGHT];
                if flight.step::<A, L, ANY, ROBUST>(tree, token, rows)
                    && !flight.launch::<L, ANY, ROBUST>(token, rows, root, &mut left)
                {
                    count -= 1;
                    // The last one takes its place, and its turn.
                    flights.swap(at % IN_FLIGHT, count % IN_FLIGHT);
                    if at == count {
                        at = 0;
                    }
                    continue;
                }
                at += 1;
                at = select_unpredictable(at == count, 0, at);
            }
        },
    );
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
