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

/// A coordinate of the direction that is smaller than this share of the largest counts as that share where tests are
/// not robust, so that the distances to planes stay finite.
const FLATTEST: f32 = 1e-18;

/// The same where they are: over all of the scene, such a ray moves along the axis by less than what sides are moved.
const FLATTEST_ROBUST: f32 = 1.0 / (1 << 22) as f32;

/// How far sides are moved outwards, in robust tests, relative to the largest coordinate of the origin and the largest
/// of the scene: rounding takes six halves of [`f32::EPSILON`] and what is [flat](FLATTEST_ROBUST) four. The rest is room
/// for a hit that a watertight method accepts beside a box, since the corners that it sees are rounded as well.
const MARGIN: f32 = 16.0 * (f32::EPSILON / 2.0);

/// How far rounding may move `t` of a hit, relative to it.
pub(crate) const ROUNDINGS: f32 = 8.0 * (f32::EPSILON / 2.0);

/// What underflow may take from the distance to a plane, and more: it is not subnormal, since numbers
/// that are take long. Where the processor flushes them it may take a few of the smallest normal ones.
pub(crate) const UNDERFLOW: f32 = 4.0 * f32::MIN_POSITIVE;

/// The scene is so far away at most, in units of the largest coordinate of the direction, where robust tests say
/// anything: no distance overflows then.
const LONGEST: f32 = (1_u128 << 100) as f32;

/// Robust tests say nothing where all of the scene and the origin, or a coordinate of the direction that is used, is
/// smaller than this: a margin of subnormal numbers rounds to nothing, and inverses of them are infinite.
const SMALLEST: f32 = f32::MIN_POSITIVE;

/// What is computed once per ray for the boxes.
#[derive(Clone, Copy)]
pub(crate) struct Slabs<L> {
    /// The inverse of the direction. NaN where robust tests say nothing.
    pub(crate) inverse: Vec3<L>,
    /// `origin · inverse`, to be subtracted from a coordinate's product with the inverse, for a plane where the ray enters
    /// a box. In robust tests with what moves the plane outwards.
    pub(crate) near: Vec3<L>,
    /// The same for a plane where it leaves one.
    pub(crate) far: Vec3<L>,
}

/// Whether a ray moves at all.
#[inline(always)]
pub(crate) fn moves<L: Lanes<Elem = f32>>(ray: &Ray<L>) -> L::Mask {
    ray.d.largest_magnitude().gt(ray.d.x.constant(0.0))
}

/// How far sides are moved outwards: given [`reach`](Slabs::new), and the largest coordinate of the origin.
#[inline(always)]
pub(crate) fn outwards<L: Lanes<Elem = f32>>(reach: f32, o: L) -> L {
    (o + o.constant(reach)) * o.constant(MARGIN)
}

/// The same as a distance along an axis of that inverse direction.
#[inline(always)]
pub(crate) fn margin<L: Lanes<Elem = f32>>(reach: f32, o: L, inverse: Vec3<L>) -> Vec3<L> {
    let by = outwards(reach, o);
    let least = by.constant(UNDERFLOW);
    Vec3::new(
        inverse.x.magnitude() * by + least,
        inverse.y.magnitude() * by + least,
        inverse.z.magnitude() * by + least,
    )
}

/// The products of two, axis by axis.
#[inline(always)]
fn by_axis<L: Lanes>(a: Vec3<L>, b: Vec3<L>) -> Vec3<L> {
    Vec3::new(a.x * b.x, a.y * b.y, a.z * b.z)
}

impl<L: Lanes<Elem = f32>> Slabs<L> {
    /// Of a ray among boxes of which no coordinate is larger in magnitude than `reach`.
    #[inline(always)]
    pub(crate) fn new<B: Boxes>(ray: &Ray<L>, reach: f32) -> Self {
        let Ray { o, d, .. } = *ray;
        let one = o.x.constant(1.0);
        let fastest = d.largest_magnitude();
        let flattest = if B::ROBUST { FLATTEST_ROBUST } else { FLATTEST };
        let least = fastest * o.x.constant(flattest);
        let inverse = Vec3::new(
            one / d.x.magnitude().max(least).xor_sign(d.x),
            one / d.y.magnitude().max(least).xor_sign(d.y),
            one / d.z.magnitude().max(least).xor_sign(d.z),
        );
        if !B::ROBUST {
            let start = by_axis(o, inverse);
            return Self { inverse, near: start, far: start };
        }
        let from = o.largest_magnitude();
        let away = from + from.constant(reach);
        let is_sure = away.max(fastest).le(one.constant(LARGEST))
            & away.min(least).ge(one.constant(SMALLEST))
            & away.le(fastest * one.constant(LONGEST));
        let nothing = one.constant(f32::NAN);
        let inverse = Vec3::new(
            L::select(is_sure, inverse.x, nothing),
            L::select(is_sure, inverse.y, nothing),
            L::select(is_sure, inverse.z, nothing),
        );
        let (start, margin) = (by_axis(o, inverse), margin(reach, from, inverse));
        Self { inverse, near: start + margin, far: start - margin }
    }

    /// The distances to planes of one coordinate each.
    #[inline(always)]
    fn distances(&self, planes: Vec3<L>, start: Vec3<L>) -> Vec3<L> {
        let r = self.inverse;
        Vec3::new(
            planes.x.mul_sub(r.x, start.x),
            planes.y.mul_sub(r.y, start.y),
            planes.z.mul_sub(r.z, start.z),
        )
    }

    /// Where a ray enters, by planes of one coordinate each.
    #[inline(always)]
    fn enters(&self, planes: Vec3<L>) -> Vec3<L> {
        self.distances(planes, self.near)
    }

    /// Where it leaves.
    #[inline(always)]
    fn leaves<B: Boxes>(&self, planes: Vec3<L>) -> Vec3<L> {
        self.distances(planes, if B::ROBUST { self.far } else { self.near })
    }

    /// Where rays enter boxes and where they leave them, within their intervals, from the coordinates of
    /// the nearer and the farther planes. They meet where the first is at most the second.
    #[inline(always)]
    pub(crate) fn cross<B: Boxes>(&self, near: Vec3<L>, far: Vec3<L>, interval: (L, L)) -> (L, L) {
        within(self.enters(near), self.leaves::<B>(far), interval)
    }

    /// The same for a ray that goes alone, and waits for nothing else. Where nothing is NaN and its interval begins at
    /// zero or later, which makes it `plain`, distances are compared by their bits, which takes a quarter of the time.
    /// Negative ones are in no order then, but what ends at any of them is missed.
    #[inline(always)]
    pub(crate) fn cross_alone<B: Boxes>(
        &self,
        near: Vec3<L>,
        far: Vec3<L>,
        (tmin, tmax): (L, L),
        is_plain: bool,
    ) -> (L, L) {
        if !is_plain {
            return self.cross::<B>(near, far, (tmin, tmax));
        }
        // Negated, so that what is not negative has larger bits than what is.
        let (near, far) = (self.enters(near), self.leaves::<B>(far));
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
        let (a, b) = (self.enters(from), self.enters(to));
        let near = Vec3::new(b.x.min(a.x), b.y.min(a.y), b.z.min(a.z));
        let (a, b) =
            if B::ROBUST { (self.leaves::<B>(from), self.leaves::<B>(to)) } else { (a, b) };
        let far = Vec3::new(a.x.max(b.x), a.y.max(b.y), a.z.max(b.z));
        within(near, far, interval)
    }

    /// For boxes that are larger by a margin on each side. Of robust tests.
    #[inline(always)]
    pub(crate) fn widened(self, margin: f32) -> Self {
        let by = self.inverse.map(
            #[inline(always)]
            |inverse| inverse.magnitude() * inverse.constant(margin),
        );
        Self { near: self.near + by, far: self.far - by, ..self }
    }
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
    let slabs =
        Slabs::new::<Robust>(ray, low.largest_magnitude().max(high.largest_magnitude()) + margin);
    let (enters, leaves) =
        slabs.widened(margin).cross_either_way::<Robust>(low, high, (tmin, tmax));
    enters <= leaves && tmin <= tmax && moves(ray)
}

/// The last of three slabs that is entered and the first that is left, within an interval. Those of all axes may be NaN,
/// which says nothing.
#[inline(always)]
pub(crate) fn within<L: Lanes<Elem = f32>>(
    near: Vec3<L>,
    far: Vec3<L>,
    (tmin, tmax): (L, L),
) -> (L, L) {
    (near.x.max(near.y).max(near.z.max(tmin)), far.x.min(far.y).min(far.z.min(tmax)))
}
