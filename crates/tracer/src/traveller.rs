//! A ray on its way through the tree: what is kept of it, and what it does at a node and at a leaf.

use std::ops::Range;

use trisect_core::{
    Culling, Deferred, Early, Hit, Interval, Lanes, Method, Of, Ray, Record, TrueDivision, Vec3,
};

use crate::bvh::{Block, Bvh, Node, WIDTH};

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
        best.is_hit().then_some(*best)
    }
}

impl Found for bool {
    #[inline(always)]
    fn of(best: &TriangleHit) -> Self {
        best.is_hit()
    }
}

const ZERO: Vec3<f32> = Vec3 { x: 0.0, y: 0.0, z: 0.0 };

/// What is farther than every hit.
const NO_HIT: TriangleHit =
    TriangleHit { triangle: u32::MAX, hit: Hit { t: f32::INFINITY, beta: 0.0, gamma: 0.0 } };

impl TriangleHit {
    /// Whether it is not [`NO_HIT`].
    #[inline(always)]
    fn is_hit(&self) -> bool {
        self.triangle != NO_HIT.triangle
    }
}

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
    inverse: Vec3<f32>,
    /// `origin · inverse`, which is taken from a coordinate's product with the inverse; the origin where
    /// `ROBUST`, which is taken from the coordinate itself: that is exact, or relative to the distance.
    start: Vec3<f32>,
}

impl Slabs {
    #[inline(always)]
    fn new<const ROBUST: bool>(ray: &Ray<f32>) -> Self {
        let Ray { o, d: Vec3 { x, y, z }, .. } = *ray;
        // `Lanes::max` is one instruction, `f32::max` four.
        let largest = Lanes::max(Lanes::max(x.abs(), y.abs()), z.abs());
        let least = if ROBUST { 0.0 } else { FLATTEST * largest };
        let r = Vec3::new(inverse(x, least), inverse(y, least), inverse(z, least));
        let start = if ROBUST { o } else { Vec3::new(o.x * r.x, o.y * r.y, o.z * r.z) };
        Self { inverse: r, start }
    }
}

/// The reciprocal of a coordinate of the direction, which counts as `least` where it is smaller.
#[inline(always)]
fn inverse(d: f32, least: f32) -> f32 {
    1.0 / Lanes::max(d.abs(), least).copysign(d)
}

/// Distances to the nearer and farther planes of boxes along one axis. Where `ROBUST`, they are infinite
/// along an axis across the ray, or NaN for a plane that the ray lies in.
#[inline(always)]
fn planes<L: Lanes<Elem = f32>, const ROBUST: bool>(
    token: L::Token,
    (near, far): (&[f32; WIDTH], &[f32; WIDTH]),
    lane: usize,
    inverse: f32,
    start: f32,
) -> (L, L) {
    let (near, far) = (L::load(token, &near[lane..]), L::load(token, &far[lane..]));
    let (r, s) = (L::splat(token, inverse), L::splat(token, start));
    if ROBUST { ((near - s) * r, (far - s) * r) } else { (near.mul_sub(r, s), far.mul_sub(r, s)) }
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

/// The octant that a ray looks into: along each axis, whether it goes backwards, so that the farther end
/// of a box is nearer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Octant(usize);

impl Octant {
    /// Its number, below eight.
    pub(crate) fn number(self) -> usize {
        self.0
    }

    /// The octant of a number below eight.
    pub(crate) fn of(number: usize) -> Self {
        Self(number % 8)
    }

    /// The ends of a box along an axis, the nearer one first.
    #[inline(always)]
    fn ends(self, node: &Node, axis: usize) -> (&[f32; WIDTH], &[f32; WIDTH]) {
        let near = self.0 >> axis & 1;
        (&node.bounds[axis][near], &node.bounds[axis][near ^ 1])
    }
}

/// A ray on its way.
#[derive(Clone, Copy)]
pub(crate) struct Traveller {
    /// Its interval ends at the best hit, where there is one.
    ray: Ray<f32>,
    slabs: Slabs,
    octant: Octant,
    best: TriangleHit,
}

impl Traveller {
    /// Nobody.
    pub(crate) const NOBODY: Self = Self {
        ray: Ray { o: ZERO, d: ZERO, tmin: 0.0, tmax: 0.0 },
        slabs: Slabs { inverse: ZERO, start: ZERO },
        octant: Octant(0),
        best: NO_HIT,
    };

    /// Becomes this ray. Its interval is empty where it has nothing, so where it is not finite.
    ///
    /// Field by field, in place: what is written in parts and copied as a whole is waited for.
    #[inline(always)]
    pub(crate) fn become_ray<const ROBUST: bool>(&mut self, ray: &Ray<f32>) {
        let Interval { tmin, tmax } = Interval::of(ray);
        self.ray.o = ray.o;
        self.ray.d = ray.d;
        self.ray.tmin = tmin;
        self.ray.tmax = tmax;
        let slabs = Slabs::new::<ROBUST>(ray);
        let r = slabs.inverse;
        self.slabs.inverse = r;
        self.slabs.start = slabs.start;
        self.octant.0 =
            usize::from(r.x < 0.0) | usize::from(r.y < 0.0) << 1 | usize::from(r.z < 0.0) << 2;
        self.best.triangle = NO_HIT.triangle;
        self.best.hit.t = NO_HIT.hit.t;
    }

    /// Whether its interval is not empty.
    #[inline(always)]
    pub(crate) fn has_any(&self) -> bool {
        self.ray.tmin <= self.ray.tmax
    }

    /// Where its interval ends.
    #[inline(always)]
    pub(crate) fn tmax(&self) -> f32 {
        self.ray.tmax
    }

    pub(crate) fn octant(&self) -> Octant {
        self.octant
    }

    /// What it has found.
    #[inline(always)]
    pub(crate) fn best(&self) -> &TriangleHit {
        &self.best
    }

    /// Its direction.
    pub(crate) fn direction(&self) -> Vec3<f32> {
        self.ray.d
    }

    #[inline(always)]
    pub(crate) fn has_hit(&self) -> bool {
        self.best.is_hit()
    }

    /// The children whose boxes the ray meets, in bits, and where it enters each.
    #[inline(always)]
    pub(crate) fn meet<L: Lanes<Elem = f32>, const ROBUST: bool>(
        &self,
        token: L::Token,
        node: &Node,
        octant: Octant,
        distances: &mut [f32; WIDTH],
    ) -> u64 {
        let Vec3 { x: rx, y: ry, z: rz } = self.slabs.inverse;
        let Vec3 { x: sx, y: sy, z: sz } = self.slabs.start;
        let mut met = 0;
        let mut lane = 0;
        while lane < WIDTH {
            let (x, y, z) = (octant.ends(node, 0), octant.ends(node, 1), octant.ends(node, 2));
            let x = planes::<L, ROBUST>(token, x, lane, rx, sx);
            let y = planes::<L, ROBUST>(token, y, lane, ry, sy);
            let z = planes::<L, ROBUST>(token, z, lane, rz, sz);
            let mut from = nearest_of::<L, ROBUST>(x.0, y.0, z.0, L::splat(token, self.ray.tmin));
            let mut to = farthest_of::<L, ROBUST>(x.1, y.1, z.1, L::splat(token, self.ray.tmax));
            if ROBUST {
                let widen = from.constant(ROUNDINGS);
                from = from - from.magnitude() * widen;
                to = to + to.magnitude() * widen;
            }
            met |= L::bits(from.le(to)) << lane;
            from.store(&mut distances[lane..]);
            lane += L::N;
        }
        met
    }

    /// Tests the triangles of a leaf. The interval ends at the nearest hit; it becomes empty with any
    /// hit where `ANY`.
    #[inline(always)]
    pub(crate) fn test_leaf<M, L, const ANY: bool, const ROBUST: bool>(
        &mut self,
        bvh: &Bvh<M>,
        token: L::Token,
        blocks: Range<usize>,
        culling: Culling,
    ) where
        M: Method,
        L: Lanes<Elem = f32>,
    {
        let axis = if const { M::TURNS } { self.ray.d.largest_axis() } else { 2 };
        match axis {
            0 if const { M::TURNS } => self.test_blocks::<M, L, 0>(bvh, token, blocks, culling),
            1 if const { M::TURNS } => self.test_blocks::<M, L, 1>(bvh, token, blocks, culling),
            _ => self.test_blocks::<M, L, 2>(bvh, token, blocks, culling),
        }
        if self.has_hit() {
            // The quotient may round to a tie that the numerators do not show: a triangle of a lower
            // number must not be lost to that.
            let t = self.best.hit.t;
            self.ray.tmax = match (ANY, ROBUST) {
                (true, _) => f32::NEG_INFINITY,
                (false, true) => t + t.abs() * ROUNDINGS,
                (false, false) => t,
            };
        }
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
            Interval { tmin: L::splat(token, self.ray.tmin), tmax: L::splat(token, self.ray.tmax) };
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

/// The form of the division: the one that decides without quotients, where there is one.
#[inline(always)]
fn test<M: Method, L: Lanes>(
    ray: &M::PreparedRay<L>,
    triangle: &Of<M::Prepared, L>,
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
