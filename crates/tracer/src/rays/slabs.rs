//! Where rays enter and leave boxes: one formula for one ray and eight boxes, and for as many rays as there
//! are lanes and one box.
//!
//! Kay, Kajiya: Ray Tracing Complex Scenes. SIGGRAPH 1986.
//!
//! [`Robust`](crate::query::Robust) tests never leave out a box that a ray meets within its interval: proved in
//! `docs/derivations/exact.md`.

use trisect_core::{Lanes, Ray, Vec3};
use trisect_method::Interval;

use crate::bvh::bounds::LARGEST;
use crate::query::{Boxes, Robust};

/// A coordinate of the direction that is smaller than this share of the largest counts as that share
/// where tests are not robust, so that the distances to planes stay finite.
const FLATTEST: f32 = 1e-18;

/// How far rounding may move the distance to a plane, relative to it: `(v − o)·(1/d)` rounds three
/// times, the comparison of two of them counts both, and the rest is room for a hit that a watertight
/// method accepts beside a box, since the corners that it sees are rounded as well.
pub(crate) const ROUNDINGS: f32 = 8.0 * (f32::EPSILON / 2.0);

/// What underflow may take from the distances to two planes, and more: it is not subnormal, since numbers
/// that are take long. Where the processor flushes them it may take a few of the smallest normal ones.
pub(crate) const UNDERFLOW: f32 = 4.0 * f32::MIN_POSITIVE;

/// What is computed once per ray for the boxes.
#[derive(Clone, Copy)]
pub(crate) struct Slabs<L> {
    /// The inverse of the direction. In robust tests it is plus infinity along an axis that the ray runs across,
    /// and NaN along one that the test says nothing about.
    pub(crate) inverse: Vec3<L>,
    /// `origin · inverse`, to be subtracted from a coordinate's product with the inverse. In robust tests the
    /// origin, to be subtracted from the coordinate itself: the error is relative to the distance then.
    pub(crate) start: Vec3<L>,
}

impl<L: Lanes<Elem = f32>> Slabs<L> {
    #[inline(always)]
    pub(crate) fn new<B: Boxes>(ray: &Ray<L>) -> Self {
        let Ray { o, d, .. } = *ray;
        if B::ROBUST {
            let inverse = Vec3::new(
                certain_inverse(o.x, d.x),
                certain_inverse(o.y, d.y),
                certain_inverse(o.z, d.z),
            );
            return Self { inverse, start: o };
        }
        let one = o.x.constant(1.0);
        let (x, y, z) = (d.x.magnitude(), d.y.magnitude(), d.z.magnitude());
        let least = x.max(y).max(z) * o.x.constant(FLATTEST);
        let inverse = Vec3::new(
            one / x.max(least).xor_sign(d.x),
            one / y.max(least).xor_sign(d.y),
            one / z.max(least).xor_sign(d.z),
        );
        let start = Vec3::new(o.x * inverse.x, o.y * inverse.y, o.z * inverse.z);
        Self { inverse, start }
    }

    /// The distances to planes of one coordinate each, infinite, or NaN for a plane that the ray lies in.
    #[inline(always)]
    fn distances<B: Boxes>(&self, planes: Vec3<L>) -> Vec3<L> {
        let (r, s) = (self.inverse, self.start);
        if B::ROBUST {
            Vec3::new((planes.x - s.x) * r.x, (planes.y - s.y) * r.y, (planes.z - s.z) * r.z)
        } else {
            Vec3::new(
                planes.x.mul_sub(r.x, s.x),
                planes.y.mul_sub(r.y, s.y),
                planes.z.mul_sub(r.z, s.z),
            )
        }
    }

    /// Where rays enter boxes and where they leave them, within their intervals, from the coordinates of
    /// the nearer and the farther planes. They meet where the first is at most the second.
    #[inline(always)]
    pub(crate) fn cross<B: Boxes>(&self, near: Vec3<L>, far: Vec3<L>, interval: (L, L)) -> (L, L) {
        let (near, far) = (self.distances::<B>(near), self.distances::<B>(far));
        within::<L, B>(near, far, interval)
    }

    /// The same for a ray that goes alone, and waits for nothing else. Where tests are not robust and its interval
    /// begins at zero or later, distances are compared by their bits, which takes a quarter of the time. Negative ones
    /// are in no order then, but what ends at any of them is missed.
    #[inline(always)]
    pub(crate) fn cross_alone<B: Boxes>(
        &self,
        near: Vec3<L>,
        far: Vec3<L>,
        (tmin, tmax): (L, L),
        is_ahead: bool,
    ) -> (L, L) {
        if B::ROBUST || !is_ahead {
            return self.cross::<B>(near, far, (tmin, tmax));
        }
        // Negated, so that what is not negative has larger bits than what is.
        let (near, far) = (self.distances::<B>(near), self.distances::<B>(far));
        let from = (-near.x).max_bits(-near.y).max_bits((-near.z).max_bits(-tmin));
        let to = (-far.x).min_bits(-far.y).min_bits((-far.z).min_bits(-tmax));
        (-from, -to)
    }

    /// The same from the coordinates of the planes in order, whichever are nearer.
    #[inline(always)]
    pub(crate) fn cross_either_way<B: Boxes>(
        &self,
        from: Vec3<L>,
        to: Vec3<L>,
        interval: (L, L),
    ) -> (L, L) {
        cross_apart::<L, B>(&[*self; 2], from, to, interval)
    }

    /// Two of the same ray, with its origin moved by a margin along all axes, up and down: for
    /// [boxes](cross_apart) that are larger by it. Of robust tests.
    #[inline(always)]
    pub(crate) fn apart(&self, margin: f32) -> [Self; 2] {
        let by = self.start.x.constant(margin);
        let moved = |by: L| {
            self.start.map(
                #[inline(always)]
                |o| o + by,
            )
        };
        [Self { start: moved(by), ..*self }, Self { start: moved(-by), ..*self }]
    }
}

/// Where rays enter boxes and leave them, from the coordinates of the planes in order, whichever are nearer; those where
/// a box begins and those where it ends as seen from origins of their own.
#[inline(always)]
pub(crate) fn cross_apart<L: Lanes<Elem = f32>, B: Boxes>(
    [begin, end]: &[Slabs<L>; 2],
    from: Vec3<L>,
    to: Vec3<L>,
    interval: (L, L),
) -> (L, L) {
    let (a, b) = (begin.distances::<B>(from), end.distances::<B>(to));
    // Where the ray lies in a plane, its distance is NaN and the inverse plus infinity: the box
    // begins at minus infinity or at NaN, and ends at plus infinity or at NaN.
    let near = Vec3::new(b.x.min(a.x), b.y.min(a.y), b.z.min(a.z));
    let far = Vec3::new(a.x.max(b.x), a.y.max(b.y), a.z.max(b.z));
    within::<L, B>(near, far, interval)
}

/// Whether a ray may meet the points between two corners within its interval, as the contract has it; never
/// wrong where it says no. A ray in a side of the box meets it.
#[inline]
pub fn meets_box(ray: &Ray<f32>, low: Vec3<f32>, high: Vec3<f32>) -> bool {
    meets_wide_box(ray, [low, high], 0.0)
}

/// The same for a box that is larger by a margin on each side.
#[inline]
pub(crate) fn meets_wide_box(ray: &Ray<f32>, [low, high]: [Vec3<f32>; 2], margin: f32) -> bool {
    let Interval { tmin, tmax } = Interval::of(ray);
    let sides = Slabs::new::<Robust>(ray).apart(margin);
    let (enters, leaves) = cross_apart::<f32, Robust>(&sides, low, high, (tmin, tmax));
    enters <= leaves && tmin <= tmax
}

/// The inverse of a coordinate of the direction: plus infinity for either zero. NaN, which says nothing, where
/// it is infinite though the ray moves along the axis, or where what is computed with it may overflow.
#[inline(always)]
fn certain_inverse<L: Lanes<Elem = f32>>(o: L, d: L) -> L {
    let (zero, infinity) = (d.constant(0.0), d.constant(f32::INFINITY));
    let nothing = d.constant(f32::NAN);
    let inverse = d.constant(1.0) / d;
    let is_finite = inverse.magnitude().lt(infinity);
    let of_infinite = L::select(d.magnitude().gt(zero), nothing, infinity);
    let inverse = L::select(is_finite, inverse, of_infinite);
    let is_large = o.magnitude().max(d.magnitude()).gt(d.constant(LARGEST));
    L::select(is_large, nothing, inverse)
}

/// The last of three slabs that is entered and the first that is left, within an interval. What is NaN
/// says nothing.
#[inline(always)]
pub(crate) fn within<L: Lanes<Elem = f32>, B: Boxes>(
    near: Vec3<L>,
    far: Vec3<L>,
    (tmin, tmax): (L, L),
) -> (L, L) {
    if !B::ROBUST {
        // Shorter chains, where nothing is NaN.
        return (near.x.max(near.y).max(near.z.max(tmin)), far.x.min(far.y).min(far.z.min(tmax)));
    }
    let from = near.z.max(near.y.max(near.x.max(tmin)));
    let to = far.z.min(far.y.min(far.x.min(tmax)));
    let by = from.constant(ROUNDINGS);
    // All that underflow may take, at one end: a box that the ray begins in is to begin at zero.
    let slack = to.magnitude().mul_add(by, to.constant(UNDERFLOW));
    (from - from.magnitude() * by, to + slack)
}
