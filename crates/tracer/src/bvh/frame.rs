//! Where triangles and rays of f64 are for boxes of f32.
//!
//! In the frame a point `x` is at `(x − c)·2⁻ᵉ`: `c` is the center of the scene, and `2ᵉ` is such that no triangle
//! reaches further from it than 1. A direction is brought by a power of two to where its largest coordinate is from 1 to
//! 2. Then everything is rounded to f32, and boxes are made so much larger that no true hit is lost:
//!
//! **A hit is not discarded.** `u` is 2⁻²⁴. Let `p = o + t·d` be the point of a hit, in the frame and before rounding, so
//! that no coordinate is beyond 1, and none of `o` beyond 4. What rounding moves, along each axis:
//!
//! | what | by at most |
//! | --- | --- |
//! | the point of the triangle: it is within its rounded corners as `p` is within the true ones | `u` |
//! | the ray at `t`: `u·|o| + |t|·u·|d|`, and the last is `u` times the way to `p` | `4u + 5u` |
//! | the distance to a side at `v` as it is tested, `v·r − fl(o·r)` with `r = fl(1/d)`, times `d`: that of `o·r`, and two roundings of a distance that is 5 at most | `4u + 10u` |
//! | the side itself when it is moved | `u` |
//!
//! That is `25u`, for tests that are not [robust](crate::query::Robust); those that are lose less. Second orders, `c`
//! that is subtracted in f64, and coordinates of the direction that are [too flat](crate::rays::slabs) or underflow, as
//! `|t|` is at most 5, take far less than another `u`. Sides are moved by `32u`. The ends of the interval are rounded
//! outwards.
//!
//! **From afar.** Where a coordinate of `o` is beyond 4, the ray begins elsewhere: with `a` the axis along which it is
//! fastest, where it has two units to go to the center along `a`. So much of its way to a hit is left, along `a` from 1 to 3
//! units, and along no axis more, as it is slower there: no coordinate of that point is beyond 4, or the ray misses the scene. It is
//! computed with one rounding in f64, which is `2⁻⁵³·(|c| + 4)`, in units of the frame, and makes boxes larger as well. What
//! `t` loses there is rounded outwards. Rays from so far away that they cannot be made to begin there meet all
//! triangles: these are more than 2⁴⁰ units away, or nearly.

use trisect_core::{Ray, Triangle, Vec3};

use crate::parallel::each;
use crate::precision::Entry;

/// See [above](self).
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    center: Vec3<f64>,
    /// `2⁻ᵉ`.
    scale: f64,
    /// How far the sides of boxes are moved outwards.
    pub(crate) margin: f32,
}

/// `32u`.
const MARGIN: f64 = 16.0 * f32::EPSILON as f64;

/// Boxes that are so much larger meet every ray that is in the frame.
const LARGEST_MARGIN: f32 = 16.0;

/// Origins are taken as they are up to here.
const NEAR: f64 = 4.0;

/// Rays that begin at most so far away are moved to the scene for certain, if they meet it.
const FAR: f64 = (1_u64 << 40) as f64;

/// From `t` along a ray to that along the same ray in the frame: `(t − start)·unit`.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    start: f64,
    unit: f64,
}

impl Span {
    /// Of a ray that is not asked about.
    pub(crate) const NOTHING: Self = Self { start: 0.0, unit: 1.0 };

    /// Where the ray ends; not before `t`.
    #[inline(always)]
    pub(crate) fn end(self, t: f64) -> f32 {
        // Where a ray begins elsewhere the difference is rounded. Otherwise that is no more than the last bit.
        up((t - self.start).next_up() * self.unit)
    }
}

/// Rounded to f32, not downwards.
#[allow(clippy::cast_possible_truncation, reason = "rounds")]
#[inline(always)]
fn up(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) < x { rounded.next_up() } else { rounded }
}

/// Rounded to f32, not upwards.
#[inline(always)]
fn down(x: f64) -> f32 {
    -up(-x)
}

#[allow(clippy::cast_possible_truncation, reason = "rounds")]
#[inline(always)]
fn rounded(v: Vec3<f64>) -> Vec3<f32> {
    v.map(|x| x as f32)
}

/// The exponent of a number in its bits.
#[inline(always)]
fn exponent(x: f64) -> u64 {
    x.to_bits() >> 52 & 0x7FF
}

impl Frame {
    /// The frame of triangles, and the triangles in it: NaN all over where nothing can hit them.
    pub(crate) fn around(triangles: &[Triangle<f64>]) -> (Vec<Triangle<f32>>, Self) {
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for triangle in triangles {
            // Whether it has an area plays no part here.
            let is_finite = |corner: Vec3<f64>| corner.to_array().iter().all(|x| x.is_finite());
            if triangle.corners().into_iter().all(is_finite) {
                for corner in triangle.corners() {
                    for (axis, x) in corner.to_array().into_iter().enumerate() {
                        (min[axis], max[axis]) = (min[axis].min(x), max[axis].max(x));
                    }
                }
            }
        }
        let frame = Self::of(min, max);
        let nothing = Triangle::nothing();
        let in_frame = |triangle: &Triangle<f64>| {
            if !triangle.can_be_hit() {
                return Triangle::nothing();
            }
            let [a, b, c] = triangle.corners().map(|corner| rounded(frame.bring(corner)));
            Triangle { a, b, c }
        };
        (each(triangles, nothing, in_frame), frame)
    }

    /// The frame of all points between two corners.
    fn of(min: [f64; 3], max: [f64; 3]) -> Self {
        if min[0] > max[0] {
            return Self { center: Vec3::new(0.0, 0.0, 0.0), scale: 1.0, margin: 0.0 };
        }
        let center = Vec3::from([0, 1, 2].map(|axis| 0.5 * min[axis] + 0.5 * max[axis]));
        let [low, high] =
            [min, max].map(|corner| (Vec3::from(corner) - center).largest_magnitude());
        let reach = low.max(high);
        // A power of two above the reach is 2^(exponent − 1022). Below 2⁻¹⁰⁰⁰ boxes are larger than they need be.
        let scale = f64::from_bits(match exponent(reach) {
            // Subnormal.
            large @ 2045.. => 1 << (2096 - large),
            other => (2045 - other).min(2023) << 52,
        });
        let of_center = center.largest_magnitude() * scale * f64::EPSILON;
        Self { center, scale, margin: up(MARGIN + 2.0 * of_center).min(LARGEST_MARGIN) }
    }

    #[inline(always)]
    fn bring(&self, point: Vec3<f64>) -> Vec3<f64> {
        (point - self.center).scale(self.scale)
    }

    /// A ray in the frame, whose interval is [as leaves take it](trisect_method::Interval::of).
    #[inline(always)]
    pub(crate) fn enter(&self, ray: &Ray<f64>) -> Entry<f64> {
        let Ray { tmin, tmax, .. } = *ray;
        let fastest = ray.d.largest_magnitude();
        // Not so where an end is NaN.
        if !(tmin <= tmax && fastest > 0.0) {
            return Entry::Missed;
        }
        // The inverse of the power of two below the largest coordinate; nothing of use where that is no normal number.
        let exponent = exponent(fastest).clamp(1, 2045);
        let speed = f64::from_bits((2046 - exponent) << 52);
        let unit = f64::from_bits(exponent << 52) * self.scale;
        let d = ray.d.scale(speed);
        let is_usual = (1.0..2.0).contains(&(fastest * speed)) && unit.is_normal();
        if !is_usual {
            return Entry::Everywhere;
        }
        let o = self.bring(ray.o);
        if o.largest_magnitude() > NEAR {
            return self.enter_from_afar(ray, d, (tmin, tmax), unit);
        }
        let (tmin, tmax) = (down(tmin * unit), up(tmax * unit));
        let boxed = Ray { o: rounded(o), d: rounded(d), tmin, tmax };
        Entry::Boxes(boxed, Span { start: 0.0, unit })
    }

    #[cold]
    #[inline(never)]
    fn enter_from_afar(
        &self,
        ray: &Ray<f64>,
        d: Vec3<f64>,
        (tmin, tmax): (f64, f64),
        unit: f64,
    ) -> Entry<f64> {
        let axis = ray.d.largest_axis();
        let along = |v: Vec3<f64>| v.to_array()[axis];
        let ahead = (2.0 / self.scale).copysign(along(d));
        let start = (along(self.center) - ahead - along(ray.o)) / along(ray.d);
        let at = |o: f64, d: f64| start.mul_add(d, o);
        let (from, by) = (ray.o, ray.d);
        let o = self.bring(Vec3::new(at(from.x, by.x), at(from.y, by.y), at(from.z, by.z)));
        let is_there = (along(o) + 2.0_f64.copysign(along(d))).abs() < 0.125;
        // The center is too far from zero for f64 to tell places near it apart.
        if !is_there || self.margin > 1.0 {
            return Entry::Everywhere;
        }
        if o.largest_magnitude() > NEAR {
            // By what `start` may be off.
            let is_certain =
                self.bring(from).largest_magnitude() < FAR && o.largest_magnitude() > NEAR + 0.25;
            return if is_certain { Entry::Missed } else { Entry::Everywhere };
        }
        // All triangles are ahead.
        let tmin = down((tmin - start).next_down() * unit).max(0.0);
        let span = Span { start, unit };
        let boxed = Ray { o: rounded(o), d: rounded(d), tmin, tmax: span.end(tmax) };
        Entry::Boxes(boxed, span)
    }
}
