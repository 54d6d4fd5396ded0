//! Rays through the tree, each on its own way.

use trisect_core::{Culling, Lanes, Method, Ray};

use crate::bvh::{Bvh, Child, Node, WIDTH, child};
use crate::traveller::{Found, Traveller};

/// What waits to be visited: the distance in the upper half, the child in the lower.
type Waiting = u64;

/// Rays that are on their way at the same time: while one waits for the outcome of its last test, the
/// other goes on. More than two gained nothing where it was tried.
const IN_FLIGHT: usize = 2;

/// A ray under way.
#[derive(Clone, Copy)]
struct Flight {
    /// Its number.
    number: usize,
    traveller: Traveller,
    /// The node that was visited last.
    node: u32,
    /// Its children that the ray meets, in bits, and where. They are looked at when it is the ray's
    /// turn again: by then they are known, and a branch on them that was predicted wrongly costs little.
    met: u64,
    distances: [f32; WIDTH],
    /// How many wait.
    waiting: usize,
}

impl Flight {
    const NOBODY: Self = Self {
        number: 0,
        traveller: Traveller::NOBODY,
        node: 0,
        met: 0,
        distances: [0.0; WIDTH],
        waiting: 0,
    };

    /// Puts the next ray that has anything to find at the root; those before it find nothing. Whether
    /// there is one.
    #[inline(always)]
    fn launch<'a, M, L, T, const ROBUST: bool>(
        &mut self,
        bvh: &Bvh<M>,
        token: L::Token,
        rays: &mut impl Iterator<Item = (usize, &'a Ray<f32>)>,
        found: &mut [T],
    ) -> bool
    where
        M: Method,
        L: Lanes<Elem = f32>,
        T: Found,
    {
        for (number, ray) in rays {
            self.traveller.become_ray::<ROBUST>(ray);
            if self.traveller.has_any() {
                self.number = number;
                self.waiting = 0;
                self.visit::<M, L, ROBUST>(bvh, token, 0);
                return true;
            }
            found[number] = T::of(self.traveller.best());
        }
        false
    }

    #[inline(always)]
    fn visit<M, L, const ROBUST: bool>(&mut self, bvh: &Bvh<M>, token: L::Token, node: u32)
    where
        M: Method,
        L: Lanes<Elem = f32>,
    {
        self.node = node;
        let (traveller, node) = (&self.traveller, &bvh.nodes[node as usize]);
        self.met =
            traveller.meet::<L, ROBUST>(token, node, traveller.octant(), &mut self.distances);
    }

    /// Visits a node or a leaf; whether the ray has arrived.
    #[inline(always)]
    fn step<M, L, const ANY: bool, const ROBUST: bool>(
        &mut self,
        bvh: &Bvh<M>,
        token: L::Token,
        culling: Culling,
        stack: &mut [Waiting],
    ) -> bool
    where
        M: Method,
        L: Lanes<Elem = f32>,
    {
        let mut waiting = Stack { items: stack, count: self.waiting };
        let current = if self.met != 0 {
            let node = &bvh.nodes[self.node as usize];
            waiting.descend::<ANY>(node, self.met, &self.distances)
        } else {
            // What begins behind the best hit is not worth a visit any more.
            loop {
                let Some(item) = waiting.pop() else { return true };
                if ANY || distance(item) <= self.traveller.tmax() {
                    break low(item);
                }
            }
        };
        self.waiting = waiting.count;
        match child(current) {
            Child::Node(_) => self.visit::<M, L, ROBUST>(bvh, token, current),
            Child::Leaf(first, count) => {
                self.met = 0;
                let blocks = first..first + count;
                self.traveller.test_leaf::<M, L, ANY, ROBUST>(bvh, token, blocks, culling);
                return ANY && self.traveller.has_hit();
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
    // Seven wait at each node on the way down.
    let room = (bvh.depth * (WIDTH - 1) + WIDTH).next_power_of_two();
    let mut items = vec![0; room * IN_FLIGHT];
    let mut parts = items.chunks_exact_mut(room);
    let mut stacks: [&mut [Waiting]; IN_FLIGHT] =
        std::array::from_fn(|_| parts.next().expect("each has its room"));
    let mut flights = [Flight::NOBODY; IN_FLIGHT];
    let mut rays = rays.iter().enumerate();
    let mut count = 0;
    while count < IN_FLIGHT
        && flights[count].launch::<M, L, T, ROBUST>(bvh, token, &mut rays, found)
    {
        count += 1;
    }
    while count > 0 {
        let mut at = 0;
        while at < count {
            let flight = &mut flights[at];
            if flight.step::<M, L, ANY, ROBUST>(bvh, token, culling, stacks[at]) {
                found[flight.number] = T::of(flight.traveller.best());
                if !flight.launch::<M, L, T, ROBUST>(bvh, token, &mut rays, found) {
                    // No ray is left; the last one takes its place, with what waits for it.
                    count -= 1;
                    flights.swap(at, count);
                    stacks.swap(at, count);
                    continue;
                }
            }
            at += 1;
        }
    }
}

/// What waits to be visited. Its room is a power of two that the tree cannot exceed, so that a place
/// is found by a mask.
struct Stack<'a> {
    items: &'a mut [Waiting],
    count: usize,
}

impl Stack<'_> {
    #[inline(always)]
    fn push(&mut self, item: Waiting) {
        let mask = self.items.len() - 1;
        self.items[self.count & mask] = item;
        self.count += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Waiting> {
        if self.count == 0 {
            return None;
        }
        self.count -= 1;
        let mask = self.items.len() - 1;
        Some(self.items[self.count & mask])
    }

    /// The child to visit next, of those that are met: the nearest, or any where that is all the same.
    /// The others wait, the nearer above the farther.
    #[inline(always)]
    fn descend<const ANY: bool>(
        &mut self,
        node: &Node,
        mut met: u64,
        distances: &[f32; WIDTH],
    ) -> u32 {
        let first = lowest(met);
        met &= met - 1;
        if met == 0 {
            return node.children[first];
        }
        if ANY {
            // In the order of the lanes: see the builder.
            while met != 0 {
                let last = met.ilog2() as usize % WIDTH;
                self.push(u64::from(node.children[last]));
                met ^= 1 << last;
            }
            return node.children[first];
        }
        let mut nearest = item(node, distances, first);
        let base = self.count;
        loop {
            let other = item(node, distances, lowest(met));
            met &= met - 1;
            // By insertion: those that are nearer than the new one move up.
            let far = nearest.max(other);
            nearest = nearest.min(other);
            let mask = self.items.len() - 1;
            let mut place = self.count;
            while place > base && self.items[(place - 1) & mask] < far {
                self.items[place & mask] = self.items[(place - 1) & mask];
                place -= 1;
            }
            self.items[place & mask] = far;
            self.count += 1;
            if met == 0 {
                return low(nearest);
            }
        }
    }
}

/// The place of the lowest bit.
#[inline(always)]
fn lowest(bits: u64) -> usize {
    bits.trailing_zeros() as usize % WIDTH
}

/// A child with its distance in front, so that numbers are in the order of distances: of those that are
/// not negative; the others are near enough to be in any order.
#[inline(always)]
fn item(node: &Node, distances: &[f32; WIDTH], lane: usize) -> Waiting {
    u64::from(distances[lane].to_bits()) << 32 | u64::from(node.children[lane])
}

#[allow(clippy::cast_possible_truncation, reason = "the upper half")]
#[inline(always)]
fn distance(item: Waiting) -> f32 {
    f32::from_bits((item >> 32) as u32)
}

#[allow(clippy::cast_possible_truncation, reason = "the lower half")]
#[inline(always)]
fn low(item: Waiting) -> u32 {
    item as u32
}
