//! Rays through the tree.

use std::ops::Range;

use trisect_core::{
    Culling, Deferred, Early, Hit, Interval, Lanes, Method, Ray, Record, TrueDivision, Vec3,
};

use crate::bvh::{Block, Bvh, Child, Node, WIDTH, child};
use prefetch_index::prefetch_index;

/// The nearest triangle that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Its number.
    pub triangle: u32,
    /// Where.
    pub hit: Hit<f32>,
}

/// What is kept of a ray's hit.
pub(crate) trait Found: Send {
    /// From the best hit, which may be [`NO_HIT`].
    fn of(best: &TriangleHit) -> Self;
}

impl Found for Option<TriangleHit> {
    #[inline(always)]
    fn of(best: &TriangleHit) -> Self {
        (best.triangle != NO_HIT.triangle).then_some(*best)
    }
}

impl Found for bool {
    #[inline(always)]
    fn of(best: &TriangleHit) -> Self {
        best.triangle != NO_HIT.triangle
    }
}

const ZERO: Vec3<f32> = Vec3 { x: 0.0, y: 0.0, z: 0.0 };

/// What is farther than every hit.
const NO_HIT: TriangleHit =
    TriangleHit { triangle: u32::MAX, hit: Hit { t: f32::INFINITY, beta: 0.0, gamma: 0.0 } };

/// What waits to be visited: the distance in the upper half, the child in the lower.
pub(crate) type Waiting = u64;

/// A coordinate of the direction that is smaller than this share of the largest counts as that share
/// where tests of boxes need not be exact: so the distances to planes stay finite.
const FLATTEST: f32 = 1e-18;

/// How far rounding may move the distance to a plane, relative to it: `(v − o)·(1/d)` rounds three
/// times, the comparison of two of them counts both, and the rest is room for a hit that a watertight
/// method accepts beside a box, since the corners that it sees are rounded as well.
const ROUNDINGS: f32 = 8.0 * (f32::EPSILON / 2.0);

/// What is computed once per ray for the boxes.
#[derive(Clone, Copy)]
struct Slabs {
    origin: Vec3<f32>,
    inverse: Vec3<f32>,
    /// `origin · inverse`
    start: Vec3<f32>,
    /// Along each axis, 1 where the ray goes backwards: the end of a box that is nearer.
    near: [u32; 3],
}

impl Slabs {
    #[inline(always)]
    fn new<const ROBUST: bool>(ray: &Ray<f32>) -> Self {
        let Vec3 { x, y, z } = ray.d;
        let least =
            if ROBUST { 0.0 } else { FLATTEST * greater(greater(x.abs(), y.abs()), z.abs()) };
        let r = Vec3::new(inverse(x, least), inverse(y, least), inverse(z, least));
        let start = Vec3::new(ray.o.x * r.x, ray.o.y * r.y, ray.o.z * r.z);
        let near = [u32::from(r.x < 0.0), u32::from(r.y < 0.0), u32::from(r.z < 0.0)];
        Self { origin: ray.o, inverse: r, start, near }
    }

    /// Distances to the nearer or farther planes of boxes. Where `ROBUST`, that along an axis across the
    /// ray is infinite, or NaN for a plane that the ray lies in.
    #[inline(always)]
    fn planes<L: Lanes<Elem = f32>, const ROBUST: bool>(
        &self,
        token: L::Token,
        node: &Node,
        far: u32,
        lane: usize,
    ) -> (L, L, L) {
        let [x, y, z] = self.near;
        let x = L::load(token, &node.bounds[0][((x ^ far) & 1) as usize][lane..]);
        let y = L::load(token, &node.bounds[1][((y ^ far) & 1) as usize][lane..]);
        let z = L::load(token, &node.bounds[2][((z ^ far) & 1) as usize][lane..]);
        let r = self.inverse;
        let (rx, ry, rz) = (x.constant(r.x), x.constant(r.y), x.constant(r.z));
        if ROBUST {
            // The difference is exact, or relative to the distance.
            let o = self.origin;
            ((x - x.constant(o.x)) * rx, (y - x.constant(o.y)) * ry, (z - x.constant(o.z)) * rz)
        } else {
            let s = self.start;
            (
                x.mul_sub(rx, x.constant(s.x)),
                y.mul_sub(ry, x.constant(s.y)),
                z.mul_sub(rz, x.constant(s.z)),
            )
        }
    }
}

/// The reciprocal of a coordinate of the direction, which counts as `least` where it is smaller.
#[inline(always)]
fn inverse(d: f32, least: f32) -> f32 {
    1.0 / greater(d.abs(), least).copysign(d)
}

/// The greater of two that are no NaN: one instruction, where that of the standard library takes four.
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Where a ray enters the last of three slabs, or its interval.
#[inline(always)]
fn nearest_of<L: Lanes, const ROBUST: bool>(x: L, y: L, z: L, tmin: L) -> L {
    if ROBUST {
        // From what is not NaN: a plane that the ray lies in says nothing.
        z.max(y.max(x.max(tmin)))
    } else {
        x.max(y).max(z.max(tmin))
    }
}

/// Where a ray leaves the first of three slabs, or its interval.
#[inline(always)]
fn farthest_of<L: Lanes, const ROBUST: bool>(x: L, y: L, z: L, tmax: L) -> L {
    if ROBUST { z.min(y.min(x.min(tmax))) } else { x.min(y).min(z.min(tmax)) }
}

/// The places waiting that a tree of some depth can need: seven at each node on the way down. A power
/// of two, so that a place is found by a mask.
pub(crate) fn room(depth: usize) -> usize {
    (depth * (WIDTH - 1) + WIDTH).next_power_of_two()
}

/// Rays that are on their way at the same time. While one waits for what it needs next, or for the
/// outcome of its last test, the others go on.
pub(crate) const IN_FLIGHT: usize = 2;

/// A ray on its way.
#[derive(Clone, Copy)]
#[repr(align(256))]
struct Flight {
    /// Its number.
    number: usize,
    ray: Ray<f32>,
    slabs: Slabs,
    tmin: f32,
    /// Where its interval ends: at the best hit, where there is one.
    tmax: f32,
    best: TriangleHit,
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
    const NOWHERE: Self = Self {
        number: 0,
        ray: Ray { o: ZERO, d: ZERO, tmin: 0.0, tmax: 0.0 },
        slabs: Slabs { origin: ZERO, inverse: ZERO, start: ZERO, near: [0; 3] },
        tmin: 0.0,
        tmax: 0.0,
        best: NO_HIT,
        node: 0,
        met: 0,
        distances: [0.0; WIDTH],
        waiting: 0,
    };

    /// Puts a ray at the root. It has nothing, and does not start, where it is not finite or its
    /// interval is empty.
    #[inline(always)]
    fn start<M: Method, L: Lanes<Elem = f32>, const ROBUST: bool>(
        &mut self,
        bvh: &Bvh<M>,
        token: L::Token,
        number: usize,
        ray: &Ray<f32>,
    ) -> bool {
        let Interval { tmin, tmax } = Interval::of(ray);
        self.number = number;
        self.ray = *ray;
        self.slabs = Slabs::new::<ROBUST>(ray);
        self.tmin = tmin;
        self.tmax = tmax;
        self.best = NO_HIT;
        self.waiting = 0;
        self.visit::<M, L, ROBUST>(bvh, token, 0);
        tmin <= tmax
    }

    /// Visits a node or a leaf; whether the ray has arrived.
    #[inline(always)]
    fn step<M: Method, L: Lanes<Elem = f32>, const ANY: bool, const ROBUST: bool>(
        &mut self,
        bvh: &Bvh<M>,
        token: L::Token,
        culling: Culling,
        stack: &mut [Waiting],
    ) -> bool {
        let mut waiting = Stack { items: stack, count: self.waiting };
        let current = if self.met != 0 {
            let node = &bvh.nodes[self.node as usize];
            waiting.descend::<ANY>(node, self.met, &self.distances)
        } else {
            // What begins behind the best hit is not worth a visit any more.
            loop {
                let Some(item) = waiting.pop() else { return true };
                if ANY || distance(item) <= self.tmax {
                    break low(item);
                }
            }
        };
        self.waiting = waiting.count;
        match child(current) {
            Child::Node(place) => self.visit::<M, L, ROBUST>(bvh, token, place),
            Child::Leaf(first, count) => {
                self.met = 0;
                self.test_leaf::<M, L>(bvh, token, first..first + count, culling);
                if self.best.triangle != NO_HIT.triangle {
                    if ANY {
                        return true;
                    }
                    // The quotient may round to a tie that the numerators do not show: a triangle of a
                    // lower number must not be lost to that.
                    let t = self.best.hit.t;
                    self.tmax = if ROBUST { t + t.abs() * ROUNDINGS } else { t };
                }
            }
        }
        false
    }

    #[inline(always)]
    fn visit<M: Method, L: Lanes<Elem = f32>, const ROBUST: bool>(
        &mut self,
        bvh: &Bvh<M>,
        token: L::Token,
        place: usize,
    ) {
        #[allow(clippy::cast_possible_truncation, reason = "nodes are numbered in u32")]
        let number = place as u32;
        self.node = number;
        (self.met, self.distances) =
            meet::<L, ROBUST>(token, &self.slabs, &bvh.nodes[place], self.tmin, self.tmax);
    }

    #[inline(always)]
    fn test_leaf<M: Method, L: Lanes<Elem = f32>>(
        &mut self,
        bvh: &Bvh<M>,
        token: L::Token,
        blocks: Range<usize>,
        culling: Culling,
    ) {
        if const { M::TURNS } {
            match self.ray.d.largest_axis() {
                0 => return self.test_blocks::<M, L, 0>(bvh, token, blocks, culling),
                1 => return self.test_blocks::<M, L, 1>(bvh, token, blocks, culling),
                _ => {}
            }
        }
        self.test_blocks::<M, L, 2>(bvh, token, blocks, culling);
    }

    #[inline(always)]
    fn test_blocks<M: Method, L: Lanes<Elem = f32>, const AXIS: usize>(
        &mut self,
        bvh: &Bvh<M>,
        token: L::Token,
        blocks: Range<usize>,
        culling: Culling,
    ) {
        let interval =
            Interval { tmin: L::splat(token, self.tmin), tmax: L::splat(token, self.tmax) };
        // What is computed once per ray costs less here than to keep it for every ray in flight.
        let ray = self
            .ray
            .map(
                #[inline(always)]
                |&x| L::splat(token, x),
            )
            .with_axis_last(AXIS);
        for (block, at) in bvh.blocks[blocks.clone()].iter().zip(blocks) {
            let group = if const { M::GROUPS > 1 } { usize::from(bvh.groups[at]) } else { 0 };
            let ray = M::prepare_ray(&ray, group);
            test_block::<M, L, AXIS>(token, &ray, block, interval, culling, &mut self.best);
        }
    }
}

/// The nearest hit of each ray, of equally near ones the lowest number; any hit where `ANY`. The tests
/// of boxes allow for rounding where `ROBUST`.
#[inline(always)]
pub(crate) fn trace<M, L, T, const ANY: bool, const ROBUST: bool>(
    bvh: &Bvh<M>,
    token: L::Token,
    rays: &[Ray<f32>],
    culling: Culling,
    found: &mut [T],
) where
    T: Found,
    M: Method,
    L: Lanes<Elem = f32>,
{
    let room = room(bvh.depth);
    let mut stacks = vec![0; room * IN_FLIGHT];
    let mut flights = [Flight::NOWHERE; IN_FLIGHT];
    let mut next = 0;
    let mut count = 0;
    while count < IN_FLIGHT && next < rays.len() {
        if flights[count].start::<M, L, ROBUST>(bvh, token, next, &rays[next]) {
            count += 1;
        } else {
            found[next] = T::of(&NO_HIT);
        }
        next += 1;
    }
    while count > 0 {
        let mut at = 0;
        while at < count {
            let flight = &mut flights[at % IN_FLIGHT];
            let stack = &mut stacks[at * room..][..room];
            let mut arrived = flight.step::<M, L, ANY, ROBUST>(bvh, token, culling, stack);
            while arrived {
                found[flight.number] = T::of(&flight.best);
                if next == rays.len() {
                    break;
                }
                arrived = !flight.start::<M, L, ROBUST>(bvh, token, next, &rays[next]);
                next += 1;
            }
            if arrived {
                // No ray is left for its place. The last one moves there, with what waits for it.
                count -= 1;
                flights[at] = flights[count];
                stacks.copy_within(count * room..(count + 1) * room, at * room);
            } else {
                at += 1;
            }
        }
    }
}

/// Asks for what is visited next.
#[inline(always)]
fn fetch<M: Method>(bvh: &Bvh<M>, number: u32) {
    match child(number) {
        Child::Node(place) => {
            let node = &bvh.nodes[place];
            prefetch_index(&node.bounds, 0);
            prefetch_index(&node.bounds, 1);
            prefetch_index(&node.bounds, 2);
            prefetch_index(&node.children, 0);
        }
        Child::Leaf(first, _) => {
            // A row is half of what is fetched at once; so every other number is asked for twice.
            let block = &bvh.blocks[first];
            M::Prepared::map(
                &block.prepared,
                #[inline(always)]
                |row: &[f32; WIDTH]| {
                    prefetch_index(row, 0);
                    0.0_f32
                },
            );
        }
    }
}

/// The children whose boxes the ray meets, in bits, and where it enters each.
#[inline(always)]
fn meet<L: Lanes<Elem = f32>, const ROBUST: bool>(
    token: L::Token,
    slabs: &Slabs,
    node: &Node,
    tmin: f32,
    tmax: f32,
) -> (u64, [f32; WIDTH]) {
    let mut distances = [0.0_f32; WIDTH];
    let mut met = 0_u64;
    let mut lane = 0;
    while lane < WIDTH {
        let (x, y, z) = slabs.planes::<L, ROBUST>(token, node, 0, lane);
        let mut from = nearest_of::<L, ROBUST>(x, y, z, L::splat(token, tmin));
        let (x, y, z) = slabs.planes::<L, ROBUST>(token, node, 1, lane);
        let mut to = farthest_of::<L, ROBUST>(x, y, z, L::splat(token, tmax));
        if ROBUST {
            let widen = from.constant(ROUNDINGS);
            from = from - from.magnitude() * widen;
            to = to + to.magnitude() * widen;
        }
        met |= L::bits(from.le(to)) << lane;
        from.store(&mut distances[lane..]);
        lane += L::N;
    }
    (met, distances)
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
            while met != 0 {
                self.push(u64::from(node.children[lowest(met)]));
                met &= met - 1;
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

/// Tests the triangles of a block.
#[inline(always)]
fn test_block<M: Method, L: Lanes<Elem = f32>, const AXIS: usize>(
    token: L::Token,
    ray: &M::PreparedRay<L>,
    block: &Block<M>,
    interval: Interval<L>,
    culling: Culling,
    best: &mut TriangleHit,
) {
    let mut lane = 0;
    while lane < WIDTH {
        let triangle = M::Prepared::map(
            &block.prepared,
            #[inline(always)]
            |row: &[f32; WIDTH]| L::load(token, &row[lane..]),
        );
        let triangle = M::Prepared::with_axis_last(&triangle, AXIS);
        test::<M, L>(
            ray,
            &triangle,
            interval,
            culling,
            #[inline(always)]
            |met, hit| nearest::<L>(met, hit, &block.triangles[lane..], best),
        );
        lane += L::N;
    }
}

#[allow(clippy::cast_possible_truncation, reason = "the lower half")]
#[inline(always)]
fn low(item: Waiting) -> u32 {
    item as u32
}

/// The form of the division: the one that decides without quotients, where there is one.
#[inline(always)]
fn test<M: Method, L: Lanes>(
    ray: &M::PreparedRay<L>,
    triangle: &trisect_core::Of<M::Prepared, L>,
    interval: Interval<L>,
    culling: Culling,
    found: impl FnOnce(L::Mask, Hit<L>),
) {
    if const { M::INFO.forms.deferred() } {
        M::test::<L, Deferred<TrueDivision, true>>(ray, triangle, interval, culling, found);
    } else {
        M::test::<L, Early<TrueDivision, true>>(ray, triangle, interval, culling, found);
    }
}

/// Takes the nearest of the lanes that hit, if it is nearer than what there is, or as near and of a
/// lower number. Rare, so kept out of the loop.
#[inline(never)]
fn nearest<L: Lanes<Elem = f32>>(
    met: L::Mask,
    hit: Hit<L>,
    numbers: &[u32],
    best: &mut TriangleHit,
) {
    let mut lanes = [[0.0_f32; WIDTH]; 3];
    hit.t.store(&mut lanes[0]);
    hit.beta.store(&mut lanes[1]);
    hit.gamma.store(&mut lanes[2]);
    let mut met = L::bits(met);
    while met != 0 {
        let lane = met.trailing_zeros() as usize % WIDTH;
        met &= met - 1;
        let (t, triangle) = (lanes[0][lane], numbers[lane]);
        if t < best.hit.t || t == best.hit.t && triangle < best.triangle {
            let hit = Hit { t, beta: lanes[1][lane], gamma: lanes[2][lane] };
            *best = TriangleHit { triangle, hit };
        }
    }
}
