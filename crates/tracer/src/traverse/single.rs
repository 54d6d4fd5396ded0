//! Rays through the tree, each on its own way.

use std::hint::select_unpredictable;

use trisect_core::{Lanes, Ray, Token as _};

use super::stack::{self, Stack};
use super::target::Target;
use crate::bvh::node::{Child, Node, child};
use crate::query::{Boxes, Query};
use crate::rays::batch::{RAYS, RayBatch, Work, prefetch};
use crate::rays::packet_bounds::Octant;
use crate::rays::slabs::Slabs;
use crate::vectors::{WIDTH, splat};

/// What waits to be visited: the [`key`](stack::key) of a child; where any hit will do, the index of a node, and
/// above it, in bits, those of its children that are left.
type Waiting = u64;

/// Rays that are on their way at the same time: while one waits for the outcome of its last test, the others go
/// on. More were slower.
const IN_FLIGHT: usize = 4;

/// How a ray is tested against the boxes of a node.
trait Crossing<L: Lanes<Elem = f32>, Q: Query, const N: usize>: Copy {
    /// Where one of some rays enters as many boxes as there are lanes, from box `lane` on, and where it leaves them.
    fn cross(
        self,
        token: L::Token,
        rays: &RayBatch<N>,
        index: usize,
        node: &Node,
        lane: usize,
    ) -> (L, L);
}

/// By what is stored of the ray among others.
#[derive(Clone, Copy)]
struct Stored;

impl<L: Lanes<Elem = f32>, Q: Query> Crossing<L, Q, RAYS> for Stored {
    #[inline(always)]
    fn cross(
        self,
        token: L::Token,
        rays: &RayBatch,
        index: usize,
        node: &Node,
        lane: usize,
    ) -> (L, L) {
        let slabs = rays.slabs::<L>(token, index);
        let from = node.planes::<L>(token, [0; 3], lane);
        let to = node.planes::<L>(token, [1; 3], lane);
        slabs.cross_either_way::<Q::Boxes>(from, to, rays.interval::<L>(token, index))
    }
}

/// By what is known of a ray that goes alone: in registers, as far as there are any.
#[derive(Clone, Copy)]
struct Alone<L> {
    slabs: Slabs<L>,
    octant: Octant,
    is_plain: bool,
}

impl<L: Lanes<Elem = f32>> Alone<L> {
    #[inline(always)]
    fn new<B: Boxes>(token: L::Token, ray: &Ray<f32>, reach: f32) -> Self {
        let slabs = Slabs::new::<B>(ray, reach);
        let inverse = slabs.inverse;
        let octant = Octant::of(inverse);
        // Not where the interval begins at −0.
        let is_plain = ray.tmin.to_bits() >> 31 == 0 && !inverse.x.is_nan();
        // One by one: mapping an array may stay a call, which is compiled without the lanes' instructions.
        let slabs = Slabs {
            inverse: splat::<L>(token, inverse),
            near: splat::<L>(token, slabs.near),
            far: splat::<L>(token, slabs.far),
        };
        Self { slabs, octant, is_plain }
    }
}

impl<L: Lanes<Elem = f32>, Q: Query> Crossing<L, Q, 1> for Alone<L> {
    #[inline(always)]
    fn cross(
        self,
        token: L::Token,
        rays: &RayBatch<1>,
        index: usize,
        node: &Node,
        lane: usize,
    ) -> (L, L) {
        let (near, far) = self.octant.planes::<L>(token, node, lane);
        let interval = rays.interval::<L>(token, index);
        self.slabs.cross_alone::<Q::Boxes>(near, far, interval, self.is_plain)
    }
}

/// A ray under way. Aligned, so that no vector of it is in two cache lines.
#[repr(C, align(64))]
struct Flight<'a, 's> {
    /// Where it enters the children of the node that was visited last.
    distances: [f32; WIDTH],
    /// Those that it meets, in bits. They are looked at when it is the ray's turn again: they are known by then,
    /// and a mispredicted branch on them costs little.
    met: u64,
    /// The index of the ray in the batch.
    ray: usize,
    node: &'a Node,
    /// The index of the node, where any hit will do.
    at: usize,
    waiting: Stack<'s, Waiting>,
}

impl<'a> Flight<'a, '_> {
    /// Starts the next of the rays that are left at the root; whether there is one.
    #[inline(always)]
    fn launch<L: Lanes<Elem = f32>, Q: Query>(
        &mut self,
        token: L::Token,
        rays: &RayBatch,
        root: &'a Node,
        left: &mut u64,
    ) -> bool {
        if *left == 0 {
            return false;
        }
        self.ray = left.trailing_zeros() as usize;
        *left &= *left - 1;
        self.waiting.clear();
        self.at = 0;
        self.visit::<L, Q, _, _>(token, rays, Stored, root);
        true
    }

    #[inline(always)]
    fn visit<L: Lanes<Elem = f32>, Q: Query, C: Crossing<L, Q, N>, const N: usize>(
        &mut self,
        token: L::Token,
        rays: &RayBatch<N>,
        crossing: C,
        node: &'a Node,
    ) {
        if !Q::ANY {
            self.node = node;
        }
        self.met = 0;
        let mut lane = 0;
        while lane < WIDTH {
            let (from, to) = crossing.cross(token, rays, self.ray, node, lane);
            self.met |= L::bits(from.le(to)) << lane;
            if !Q::ANY {
                from.store(&mut self.distances[lane..]);
            }
            lane += L::N;
        }
    }

    /// The child to visit next, the nearest first; `None` where the ray leaves the tree.
    #[inline(always)]
    fn nearest<const N: usize>(&mut self, rays: &RayBatch<N>) -> Option<u32> {
        if const { N == 1 } {
            return self.nearest_alone(rays.tmax(self.ray));
        }
        if self.met & self.met.wrapping_sub(1) != 0 {
            return Some(descend(&mut self.waiting, self.node, self.met, &self.distances));
        }
        if self.met == 0 && self.waiting.count() == 0 {
            return None;
        }
        // One child, or none and so the top of the stack: without a branch, since that is unpredictable.
        let only = item(self.node, &self.distances, lowest(self.met));
        let mut item = self.waiting.pop_unless(self.met != 0, only);
        // What begins behind the best hit need not be visited any more.
        while stack::distance(item) > rays.tmax(self.ray) {
            item = self.waiting.pop()?;
        }
        Some(stack::item(item))
    }

    /// The same for a ray that goes alone, which ends at `tmax`: it has nothing else to do meanwhile, so it guesses by
    /// branches what others wait for.
    #[inline(always)]
    fn nearest_alone(&mut self, tmax: f32) -> Option<u32> {
        let rest = self.met & self.met.wrapping_sub(1);
        if self.met == 0 {
            let mut item = self.waiting.pop()?;
            while stack::distance(item) > tmax {
                item = self.waiting.pop()?;
            }
            Some(stack::item(item))
        } else if rest == 0 {
            Some(self.node.children[lowest(self.met)])
        } else if rest.is_power_of_two() {
            let first = item(self.node, &self.distances, lowest(self.met));
            let second = item(self.node, &self.distances, lowest(rest));
            let (near, far) = in_order(first, second);
            self.waiting.push(far);
            Some(stack::item(near))
        } else {
            Some(descend(&mut self.waiting, self.node, self.met, &self.distances))
        }
    }

    /// The same where any order will do: that of the lanes, see the builder. All children that are left of a node
    /// wait as one item, so that no branch depends on how many there are, which is unpredictable.
    #[inline(always)]
    fn next<const N: usize>(&mut self, nodes: &[Node]) -> Option<u32> {
        if self.met == 0 && self.waiting.count() == 0 {
            return None;
        }
        let here = self.met << 32 | self.at as u64;
        let item = if const { N == 1 } {
            if self.met != 0 { here } else { self.waiting.pop()? }
        } else {
            self.waiting.pop_unless(self.met != 0, here)
        };
        let (met, at) = (item >> 32, item & u64::from(u32::MAX));
        let rest = met & met.wrapping_sub(1);
        self.waiting.push_if(rest != 0, rest << 32 | at);
        #[allow(clippy::cast_possible_truncation, reason = "it has 32 bits")]
        let node = &nodes[at as usize];
        Some(node.children[lowest(met)])
    }

    /// Visits a node or a leaf; whether the ray has left the tree.
    #[inline(always)]
    fn step<A, L, Q, C, const N: usize>(
        &mut self,
        target: A,
        token: L::Token,
        query: Q,
        crossing: C,
        work: &mut Work<A::Hits, N>,
    ) -> bool
    where
        A: Target<'a, Q, N>,
        L: Lanes<Elem = f32>,
        Q: Query,
        C: Crossing<L, Q, N>,
    {
        let next =
            if Q::ANY { self.next::<N>(&target.tree().nodes) } else { self.nearest(&work.rays) };
        let Some(current) = next else { return true };
        match child(current) {
            Child::Node(at) => {
                if Q::ANY {
                    self.at = at;
                }
                self.visit::<L, Q, _, _>(token, &work.rays, crossing, &target.tree().nodes[at]);
            }
            Child::Leaf(first, count) => {
                self.met = 0;
                if target.test::<L>(token, query, work, self.ray, first..first + count) {
                    return Q::ANY;
                }
            }
        }
        false
    }
}

/// Traces rays each on its own way.
#[inline(always)]
pub(crate) fn singly<'a, A: Target<'a, Q>, L: Lanes<Elem = f32>, Q: Query>(
    target: A,
    seed: A::Seed,
    token: L::Token,
    query: Q,
    rays: &[Ray<f32>],
    found: &mut [Q::Output],
) {
    let tree = target.tree();
    let root = &tree.nodes[0];
    let whole = root.whole();
    let mut work = Work { rays: RayBatch::EMPTY, hits: A::hits(seed) };
    let room = stack::room(tree.depth);
    let mut items = vec![0; room * IN_FLIGHT];
    let mut parts = items.chunks_exact_mut(room);
    let mut flights: [Flight<'_, '_>; IN_FLIGHT] = std::array::from_fn(|_| Flight {
        ray: 0,
        node: root,
        at: 0,
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
        let some = work.rays.fill::<L, Q::Boxes>(token, rays.iter(), &whole, A::LINES);
        target.clear(&mut work.hits);
        go::<A, L, Q>(target, token, query, &mut work, &mut flights, some);
        let of_batch = target.finish::<L>(&mut work);
        if Q::ANY {
            give_out::<Q>(of_batch, found);
        } else {
            for (found, of_ray) in found.iter_mut().zip(of_batch) {
                *found = Q::output(of_ray);
            }
        }
    }
}

/// Traces one ray. The answer is that of [`singly`], to the bit.
#[inline(always)]
pub(crate) fn one<'a, A: Target<'a, Q, 1>, L: Lanes<Elem = f32>, Q: Query>(
    target: A,
    seed: A::Seed,
    token: L::Token,
    query: Q,
    ray: &Ray<f32>,
    items: &mut [Waiting; stack::ROOM],
) -> Q::Found {
    let tree = target.tree();
    let root = &tree.nodes[0];
    let Some(rays) = RayBatch::of(ray) else { return Q::MISS };
    let alone = Alone::<L>::new::<Q::Boxes>(token, &rays.ray(0), tree.reach);
    let mut flight = Flight {
        ray: 0,
        node: root,
        at: 0,
        met: 0,
        distances: [0.0; WIDTH],
        waiting: Stack::new(items),
    };
    flight.visit::<L, Q, _, _>(token, &rays, alone, root);
    if flight.met == 0 {
        return Q::MISS;
    }
    let mut work = Work { rays, hits: A::hits(seed) };
    while !flight.step::<A, L, Q, _, 1>(target, token, query, alone, &mut work) {}
    target.finish::<L>(&mut work)[0]
}

/// Writes down what rays have found.
#[inline(never)]
fn give_out<Q: Query>(of_batch: &[Q::Found; RAYS], found: &mut [Q::Output]) {
    for (found, of_ray) in found.iter_mut().zip(of_batch) {
        *found = Q::output(of_ray);
    }
}

/// Takes rays through the tree. Out of line, since what is done before and after needs constants and registers
/// that are wanted here.
#[inline(never)]
fn go<'a, A: Target<'a, Q>, L: Lanes<Elem = f32>, Q: Query>(
    target: A,
    token: L::Token,
    query: Q,
    work: &mut Work<A::Hits>,
    flights: &mut [Flight<'a, '_>; IN_FLIGHT],
    some: u64,
) {
    token.run(
        #[inline(always)]
        move || {
            let root = &target.tree().nodes[0];
            let (mut left, mut count) = (some, 0);
            while count < IN_FLIGHT
                && flights[count].launch::<L, Q>(token, &work.rays, root, &mut left)
            {
                count += 1;
            }
            let mut at = 0;
            while count > 0 {
                let flight = &mut flights[at % IN_FLIGHT];
                if flight.step::<A, L, Q, _, RAYS>(target, token, query, Stored, work)
                    && !flight.launch::<L, Q>(token, &work.rays, root, &mut left)
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
    // Two or three mostly; how many, and in which order, is unpredictable, so without branches.
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
    stack::item(nearest)
}

/// No child: farther than all.
const NOTHING: Waiting = u64::MAX;

/// The nearer first.
#[inline(always)]
fn in_order(a: Waiting, b: Waiting) -> (Waiting, Waiting) {
    let is_less = a < b;
    (select_unpredictable(is_less, a, b), select_unpredictable(is_less, b, a))
}

/// The index of the lowest bit.
#[inline(always)]
pub(super) fn lowest(bits: u64) -> usize {
    bits.trailing_zeros() as usize % WIDTH
}

/// A child, by where the ray enters it.
#[inline(always)]
fn item(node: &Node, distances: &[f32; WIDTH], lane: usize) -> Waiting {
    stack::key(distances[lane], node.children[lane])
}
