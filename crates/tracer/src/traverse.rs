//! One ray through the tree.

use trisect_core::{
    Culling, Deferred, Early, Hit, Interval, Lanes, Method, Ray, Record, TrueDivision, Vec3,
};

use crate::bvh::{Block, Bvh, Child, Node, WIDTH, child};

/// The nearest triangle that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Its number.
    pub triangle: u32,
    /// Where.
    pub hit: Hit<f32>,
}

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
struct Slabs<L> {
    origin: Vec3<L>,
    inverse: Vec3<L>,
    /// `origin · inverse`
    start: Vec3<L>,
    /// The rows of a node that are nearer and farther along each axis.
    near: [usize; 3],
    far: [usize; 3],
}

impl<L: Lanes<Elem = f32>> Slabs<L> {
    #[inline(always)]
    fn new<const ROBUST: bool>(token: L::Token, ray: &Ray<f32>) -> Self {
        let Vec3 { x, y, z } = ray.d;
        let least = if ROBUST { 0.0 } else { FLATTEST * x.abs().max(y.abs()).max(z.abs()) };
        let inverse = |d: f32| 1.0 / d.abs().max(least).copysign(d);
        let r = Vec3::new(inverse(x), inverse(y), inverse(z));
        let splat = |v: Vec3<f32>| {
            Vec3::new(L::splat(token, v.x), L::splat(token, v.y), L::splat(token, v.z))
        };
        let start = Vec3::new(ray.o.x * r.x, ray.o.y * r.y, ray.o.z * r.z);
        let back = [r.x < 0.0, r.y < 0.0, r.z < 0.0].map(usize::from);
        Self {
            origin: splat(ray.o),
            inverse: splat(r),
            start: splat(start),
            near: [back[0], 2 + back[1], 4 + back[2]],
            far: [1 - back[0], 3 - back[1], 5 - back[2]],
        }
    }

    /// Distances to eight planes of each axis. Where `ROBUST`, that along an axis across the ray is
    /// infinite, or NaN for a plane that the ray lies in.
    #[inline(always)]
    fn planes<const ROBUST: bool>(&self, x: L, y: L, z: L) -> (L, L, L) {
        if ROBUST {
            // The difference is exact, or relative to the distance.
            let Vec3 { x: ox, y: oy, z: oz } = self.origin;
            let r = self.inverse;
            ((x - ox) * r.x, (y - oy) * r.y, (z - oz) * r.z)
        } else {
            let (r, s) = (self.inverse, self.start);
            (x.mul_sub(r.x, s.x), y.mul_sub(r.y, s.y), z.mul_sub(r.z, s.z))
        }
    }
}

/// The larger of two; the first where either is NaN.
#[inline(always)]
fn larger<L: Lanes>(a: L, b: L) -> L {
    L::select(b.gt(a), b, a)
}

/// The smaller of two; the first where either is NaN.
#[inline(always)]
fn smaller<L: Lanes>(a: L, b: L) -> L {
    L::select(b.lt(a), b, a)
}

/// Where a ray enters the last of three slabs, or its interval.
#[inline(always)]
fn nearest_of<L: Lanes, const ROBUST: bool>(x: L, y: L, z: L, tmin: L) -> L {
    if ROBUST {
        // From what is not NaN: a plane that the ray lies in says nothing.
        larger(larger(larger(tmin, x), y), z)
    } else {
        larger(larger(x, y), larger(tmin, z))
    }
}

/// Where a ray leaves the first of three slabs, or its interval.
#[inline(always)]
fn farthest_of<L: Lanes, const ROBUST: bool>(x: L, y: L, z: L, tmax: L) -> L {
    if ROBUST {
        smaller(smaller(smaller(tmax, x), y), z)
    } else {
        smaller(smaller(x, y), smaller(tmax, z))
    }
}

/// The places waiting that a tree of some depth can need: seven at each node on the way down. A power
/// of two, so that a place is found by a mask.
pub(crate) fn room(depth: usize) -> usize {
    (depth * (WIDTH - 1) + WIDTH).next_power_of_two()
}

/// The nearest hit of a ray, of equally near ones the lowest number; any hit where `ANY`. The tests of
/// boxes allow for rounding where `ROBUST`.
#[inline(always)]
pub(crate) fn trace<M, L, const ANY: bool, const ROBUST: bool>(
    bvh: &Bvh<M>,
    token: L::Token,
    ray: &Ray<f32>,
    culling: Culling,
    stack: &mut [Waiting],
) -> Option<TriangleHit>
where
    M: Method,
    L: Lanes<Elem = f32>,
{
    if const { M::TURNS } {
        match ray.d.largest_axis() {
            0 => return down::<M, L, ANY, ROBUST, 0>(bvh, token, ray, culling, stack),
            1 => return down::<M, L, ANY, ROBUST, 1>(bvh, token, ray, culling, stack),
            _ => {}
        }
    }
    down::<M, L, ANY, ROBUST, 2>(bvh, token, ray, culling, stack)
}

#[inline(always)]
fn down<M, L, const ANY: bool, const ROBUST: bool, const AXIS: usize>(
    bvh: &Bvh<M>,
    token: L::Token,
    ray: &Ray<f32>,
    culling: Culling,
    stack: &mut [Waiting],
) -> Option<TriangleHit>
where
    M: Method,
    L: Lanes<Elem = f32>,
{
    let whole = Interval::of(ray);
    // A ray that is not finite has nothing; so has one with an empty interval.
    let has_any = whole.tmin <= whole.tmax;
    if !has_any {
        return None;
    }
    let slabs = Slabs::<L>::new::<ROBUST>(token, ray);
    let lanes = ray
        .map(
            #[inline(always)]
            |&x| L::splat(token, x),
        )
        .with_axis_last(AXIS);
    // Three kinds at most; the compiler sees that there is one where there is one.
    let kind = |group: usize| group.min(M::GROUPS - 1);
    let prepared = [
        M::prepare_ray(&lanes, kind(0)),
        M::prepare_ray(&lanes, kind(1)),
        M::prepare_ray(&lanes, kind(2)),
    ];
    let mut interval =
        Interval { tmin: L::splat(token, whole.tmin), tmax: L::splat(token, whole.tmax) };
    let mut tmax = whole.tmax;
    let mut best: Option<TriangleHit> = None;
    let mut waiting = Stack { items: stack, count: 0 };
    let mut current = 0_u32;
    loop {
        match child(current) {
            Child::Node(place) => {
                let node = &bvh.nodes[place];
                let (met, distances) = meet::<L, ROBUST>(token, &slabs, node, interval);
                if met != 0 {
                    current = waiting.descend::<ANY>(node, met, &distances);
                    continue;
                }
            }
            Child::Leaf(first, count) => {
                for (block, at) in bvh.blocks[first..first + count].iter().zip(first..) {
                    let group =
                        if const { M::GROUPS > 1 } { usize::from(bvh.groups[at]) } else { 0 };
                    let ray = &prepared[group % 3];
                    test_block::<M, L, AXIS>(token, ray, block, interval, culling, &mut best);
                }
                if let Some(found) = &best {
                    if ANY {
                        return best;
                    }
                    // The quotient may round to a tie that the numerators do not show: a triangle of a
                    // lower number must not be lost to that.
                    tmax = found.hit.t;
                    if ROBUST {
                        tmax += tmax.abs() * ROUNDINGS;
                    }
                    interval.tmax = L::splat(token, tmax);
                }
            }
        }
        // What begins behind the best hit is not worth a visit any more.
        current = loop {
            let Some(item) = waiting.pop() else { return best };
            if ANY || distance(item) <= tmax {
                break low(item);
            }
        };
    }
}

/// The children whose boxes the ray meets, in bits, and where it enters each.
#[inline(always)]
fn meet<L: Lanes<Elem = f32>, const ROBUST: bool>(
    token: L::Token,
    slabs: &Slabs<L>,
    node: &Node,
    interval: Interval<L>,
) -> (u64, [f32; WIDTH]) {
    let mut distances = [0.0_f32; WIDTH];
    let mut met = 0_u64;
    let mut lane = 0;
    while lane < WIDTH {
        let row = |row: usize| L::load(token, &node.bounds[row][lane..]);
        let [x, y, z] = slabs.near;
        let (x, y, z) = slabs.planes::<ROBUST>(row(x), row(y), row(z));
        let mut from = nearest_of::<L, ROBUST>(x, y, z, interval.tmin);
        let [x, y, z] = slabs.far;
        let (x, y, z) = slabs.planes::<ROBUST>(row(x), row(y), row(z));
        let mut to = farthest_of::<L, ROBUST>(x, y, z, interval.tmax);
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
    best: &mut Option<TriangleHit>,
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
    best: &mut Option<TriangleHit>,
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
        let is_nearer =
            best.is_none_or(|best| t < best.hit.t || t == best.hit.t && triangle < best.triangle);
        if is_nearer {
            let hit = Hit { t, beta: lanes[1][lane], gamma: lanes[2][lane] };
            *best = Some(TriangleHit { triangle, hit });
        }
    }
}
