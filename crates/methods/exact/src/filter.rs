//! The first stage: all lanes at once, and a bound of what rounding may have done.
//!
//! Every constant here is derived in `docs/derivations/exact.md`.

use trisect_core::{Interval, Lanes, Of, RayParts, Scalar, Triangle, Vec3, record};

record! {
    /// The corners of a triangle, and how long its edges are.
    pub struct SizedTriangle {
        /// Corner `A`.
        a: vec3,
        /// Corner `B`.
        b: vec3,
        /// Corner `C`.
        c: vec3,
        /// The largest coordinate of `B − A` and `C − A`, at least 2⁻³⁴.
        h: number,
    }
}

/// A power of two.
const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits((1023 + exponent).cast_unsigned() << 52)
}

/// An edge counts as no shorter than this: what underflow takes is nothing beside it.
const SHORTEST: f64 = power_of_two(-34);
/// Likewise for the distance of the origin, where `t` is compared.
const NEAREST: f64 = power_of_two(-20);
/// Directions between these, in the sum of their coordinates' magnitudes, are filtered.
const SLOWEST: f64 = power_of_two(-20);
const FASTEST: f64 = power_of_two(20);
/// A bound as large as this bounds nothing: products may have overflowed.
const NO_BOUND: f64 = power_of_two(30);
/// What stands for the factor of a direction that is not filtered: it makes every bound too large.
const NOT_FILTERED: f64 = power_of_two(126);
/// Ends of the interval beyond this are brought back to it, so that products with them do not
/// overflow.
const LATEST: f64 = power_of_two(60);

/// `18u(1 + 2⁻⁹)`: nine roundings of sums of two; what is more covers the rounding of the bound itself,
/// and underflow.
#[inline(always)]
pub(crate) fn unit<L: Lanes>(x: L, factor: f64) -> L {
    let factor = factor * 18.0 * (1.0 + power_of_two(-9));
    x.constant(L::Elem::unit_roundoff()) * number(x, factor)
}

#[inline(always)]
fn number<L: Lanes>(x: L, value: f64) -> L {
    x.constant(L::Elem::from_f64(value))
}

/// The largest magnitude among the coordinates.
#[inline(always)]
fn largest<L: Lanes>(v: Vec3<L>) -> L {
    v.x.magnitude().max(v.y.magnitude().max(v.z.magnitude()))
}

impl<X: Scalar> SizedTriangle<X> {
    /// The corners as they are, and the size of the edges; NaN for a triangle that is NaN all over.
    #[inline(always)]
    pub fn new(triangle: &Triangle<X>) -> Self {
        let Triangle { a, b, c } = *triangle;
        // The second operand of `max` is what is left of a NaN.
        let h = number(a.x, SHORTEST).max(largest(b - a).max(largest(c - a)));
        Self { a, b, c, h }
    }
}

/// A ray, and the factor of the bounds.
#[derive(Clone, Copy)]
pub struct BoundedRay<L> {
    /// Origin.
    pub o: Vec3<L>,
    /// Direction.
    pub d: Vec3<L>,
    /// `18u(1 + 2⁻⁹)·|D|₁`, more for a direction that is not filtered, −1 for one that is zero, NaN for
    /// one that is not finite.
    pub scale: L,
}

impl<L: Lanes> BoundedRay<L> {
    /// The ray with its factor, `factor` times as large as it must be.
    #[allow(clippy::eq_op, reason = "x − x is NaN where x is not finite")]
    #[inline(always)]
    pub(crate) fn new(o: Vec3<L>, d: Vec3<L>, factor: f64) -> Self {
        let size = d.x.magnitude() + (d.y.magnitude() + d.z.magnitude());
        let filtered = size.ge(number(size, SLOWEST)) & size.le(number(size, FASTEST));
        let scale =
            L::select(filtered, size * unit(size, factor), number(size, NOT_FILTERED));
        let scale = L::select(size.is_zero(), number(size, -1.0), scale);
        Self { o, d, scale: scale + (d - d).sum() }
    }
}

impl<L: Lanes> RayParts for BoundedRay<L> {
    #[inline(always)]
    fn take_origin(&mut self, from: &Self) {
        self.o = from.o;
    }
    #[inline(always)]
    fn take_direction(&mut self, from: &Self) {
        self.d = from.d;
        self.scale = from.scale;
    }
}

/// The volumes whose signs decide, as computed, and the bound of their errors.
#[derive(Clone, Copy)]
pub(crate) struct Volumes<L> {
    pub(crate) det: L,
    /// Of corner `B`.
    pub(crate) u: L,
    /// Of corner `C`.
    pub(crate) v: L,
    /// Of corner `A`.
    pub(crate) w: L,
    /// `e2`
    e2: Vec3<L>,
    /// `s × e1`, whose product with `e2` is the numerator of `t`.
    q: Vec3<L>,
    /// The largest coordinate of `s`, the origin from corner `A`.
    distance: L,
}

impl<L: Lanes> Volumes<L> {
    /// Möller and Trumbore's products, from the corners themselves.
    #[inline(always)]
    pub(crate) fn new(ray: &BoundedRay<L>, triangle: &SizedTriangle<L>) -> Self {
        let SizedTriangle { a, b, c, .. } = *triangle;
        let (s, e1, e2) = (ray.o - a, b - a, c - a);
        let (p, q) = (ray.d.cross(e2), s.cross(e1));
        let (det, u, v) = (e1.dot(p), s.dot(p), ray.d.dot(q));
        Self { det, u, v, w: (det - u) - v, e2, q, distance: largest(s) }
    }

    /// The numerator of `t`.
    #[inline(always)]
    pub(crate) fn t(&self) -> L {
        self.e2.dot(self.q)
    }
}

/// What the filter says of a vector of pairs.
pub(crate) struct Verdict<L: Lanes> {
    /// Lanes that hit for certain.
    pub(crate) hit: L::Mask,
    /// Lanes that are open, in bits.
    pub(crate) open: u64,
}

/// The bound of the errors of `det`, `U`, `V` and `W`.
#[inline(always)]
pub(crate) fn bound<L: Lanes>(
    ray: &BoundedRay<L>,
    triangle: &SizedTriangle<L>,
    volumes: &Volumes<L>,
) -> L {
    (ray.scale * triangle.h) * volumes.distance.mul_add(number(triangle.h, 2.0), triangle.h)
}

/// The lanes that do not miss for certain: not one volume is certainly positive and another certainly
/// negative.
///
/// A bound of NaN comes from a triangle or a ray that never hits. Where products overflow the bound is
/// beyond [`NO_BOUND`], so that whatever they are the lane stays.
#[inline(always)]
pub(crate) fn candidates<L: Lanes>(volumes: &Volumes<L>, bound: L) -> L::Mask {
    let Volumes { u, v, w, .. } = *volumes;
    let (most, least) = (u.max(v).max(w), u.min(v).min(w));
    most.min(-least).min(number(bound, NO_BOUND)).le(bound)
}

/// What is certain of the candidates. `factor` as for [`BoundedRay::new`].
#[inline(always)]
pub(crate) fn verdict<L: Lanes>(
    ray: &BoundedRay<L>,
    triangle: &SizedTriangle<L>,
    volumes: &Volumes<L>,
    (bound, candidates): (L, L::Mask),
    interval: &Interval<L>,
    factor: f64,
) -> Verdict<L> {
    let Volumes { det, u, v, w, .. } = *volumes;
    let (most, least) = (u.max(v).max(w), u.min(v).min(w));
    let inside = least.max(-most).gt(bound) & bound.lt(number(bound, NO_BOUND));
    // All volumes have the sign of any, so that t − τ is the sign of T' − τ·det'.
    let (det, t) = (det.xor_sign(u), volumes.t().xor_sign(u));
    let (latest, earliest) = (number(det, LATEST), number(det, -LATEST));
    // The second operand of `max` and `min` is what is left of a NaN.
    let (tmin, tmax) = (earliest.max(interval.tmin), latest.min(interval.tmax));
    let far = volumes.distance.max(number(det, NEAREST)) * (number(det, 3.0) * unit(det, factor));
    let square = triangle.h * triangle.h;
    let from_error = square * tmin.magnitude().mul_add(ray.scale, far);
    let to_error = square * tmax.magnitude().mul_add(ray.scale, far);
    let (before, after) = (tmin.mul_sub(det, t), tmax.mul_sub(det, t));
    let hit = candidates & inside & before.le(-from_error) & after.ge(to_error);
    let too_early = before.gt(from_error) & interval.tmin.magnitude().le(latest);
    let too_late = after.lt(-to_error) & interval.tmax.magnitude().le(latest);
    let missed = inside & (too_early | too_late);
    Verdict { hit, open: L::bits(candidates) & !L::bits(hit) & !L::bits(missed) }
}

/// The corners alone.
#[inline(always)]
pub(crate) fn corners<X: Copy>(triangle: &SizedTriangle<X>) -> [Vec3<X>; 3] {
    [triangle.a, triangle.b, triangle.c]
}

/// The triangle of lanes, as [`Of`] names it.
pub(crate) type Triangles<L> = Of<SizedTriangle<()>, L>;
