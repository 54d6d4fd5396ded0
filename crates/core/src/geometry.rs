//! Rays, triangles and hits: plain data over any number type.

use crate::lanes::{Float, Lanes, Scalar};
use crate::number::Number;

/// Three coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3<X> {
    /// First coordinate.
    pub x: X,
    /// Second coordinate.
    pub y: X,
    /// Third coordinate.
    pub z: X,
}

impl<X> Vec3<X> {
    /// A vector from its coordinates.
    #[inline(always)]
    pub const fn new(x: X, y: X, z: X) -> Self {
        Self { x, y, z }
    }

    /// References to the coordinates.
    #[inline(always)]
    pub const fn each_ref(&self) -> Vec3<&X> {
        let Self { x, y, z } = self;
        Vec3::new(x, y, z)
    }
}

impl<X: Copy> Vec3<X> {
    /// The coordinates in order.
    #[inline(always)]
    pub fn to_array(self) -> [X; 3] {
        [self.x, self.y, self.z]
    }

    /// Applies `f` to each coordinate.
    #[inline(always)]
    pub fn map<Y>(self, mut f: impl FnMut(X) -> Y) -> Vec3<Y> {
        Vec3::new(f(self.x), f(self.y), f(self.z))
    }

    /// The coordinates rotated so that axis `w` comes last: `(x|u, x|v, x|w)` with
    /// `u = (w + 1) mod 3` and `v = (w + 2) mod 3`.
    ///
    /// # Panics
    /// When `w` is not an axis (0, 1 or 2).
    #[inline(always)]
    pub fn with_axis_last(self, w: usize) -> Self {
        match w {
            0 => Self::new(self.y, self.z, self.x),
            1 => Self::new(self.z, self.x, self.y),
            2 => self,
            _ => unreachable!("an axis is 0, 1 or 2"),
        }
    }

    /// Back from [`with_axis_last`](Vec3::with_axis_last).
    ///
    /// # Panics
    /// When `w` is not an axis (0, 1 or 2).
    #[inline(always)]
    pub fn with_axis_restored(self, w: usize) -> Self {
        match w {
            0 => self.with_axis_last(1),
            1 => self.with_axis_last(0),
            _ => self.with_axis_last(w),
        }
    }
}

impl<X> From<[X; 3]> for Vec3<X> {
    #[inline(always)]
    fn from([x, y, z]: [X; 3]) -> Self {
        Self { x, y, z }
    }
}

impl<X: Number> Vec3<X> {
    /// The scalar product. Associates as `x·x + (y·y + z·z)`.
    #[inline(always)]
    pub fn dot(self, other: Self) -> X {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }

    /// The vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y.mul_sub(other.z, self.z * other.y),
            self.z.mul_sub(other.x, self.x * other.z),
            self.x.mul_sub(other.y, self.y * other.x),
        )
    }

    /// Each coordinate times `factor`.
    #[inline(always)]
    pub fn scale(self, factor: X) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }

    /// The sum of the coordinates.
    #[inline(always)]
    pub fn sum(self) -> X {
        self.x + (self.y + self.z)
    }

    /// `self · factor + other`, coordinate by coordinate.
    #[inline(always)]
    pub fn mul_add(self, factor: X, other: Self) -> Self {
        Self::new(
            self.x.mul_add(factor, other.x),
            self.y.mul_add(factor, other.y),
            self.z.mul_add(factor, other.z),
        )
    }
}

impl<L: Lanes> Vec3<L> {
    /// The largest magnitude of a coordinate. What it is where one is NaN is not said.
    #[inline(always)]
    pub fn largest_magnitude(self) -> L {
        self.x.magnitude().max(self.y.magnitude().max(self.z.magnitude()))
    }
}

impl<X: Scalar> Vec3<X> {
    /// The axis (0, 1 or 2) of the coordinate that is largest in magnitude; the first of equals.
    #[inline(always)]
    pub fn largest_axis(self) -> usize {
        let Self { x, y, z } = self.map(X::abs);
        if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        }
    }
}

impl<X: Number> core::ops::Add for Vec3<X> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<X: Number> core::ops::Sub for Vec3<X> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<X: Number> core::ops::Neg for Vec3<X> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

/// Conversions to and from glam, for the edge of the public interface.
macro_rules! glam_vector {
    ($scalar:ty, $vector:ty) => {
        impl From<$vector> for Vec3<$scalar> {
            fn from(v: $vector) -> Self {
                v.to_array().into()
            }
        }
        impl From<Vec3<$scalar>> for $vector {
            fn from(v: Vec3<$scalar>) -> Self {
                v.to_array().into()
            }
        }
    };
}
glam_vector!(f32, glam::Vec3);
glam_vector!(f32, glam::Vec3A);
glam_vector!(f64, glam::DVec3);

impl From<Vec3<f32>> for Vec3<f64> {
    fn from(v: Vec3<f32>) -> Self {
        v.map(f64::from)
    }
}

/// The points `o + t·d` with `tmin ≤ t ≤ tmax`. `d` need not have unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray<X> {
    /// Origin.
    pub o: Vec3<X>,
    /// Direction, of any length but zero.
    pub d: Vec3<X>,
    /// Smallest `t` that counts as a hit.
    pub tmin: X,
    /// Largest `t` that counts as a hit; may be infinite.
    pub tmax: X,
}

impl<X> Ray<X> {
    /// Applies `f` to each number, in order of declaration.
    #[inline(always)]
    pub fn map<Y>(&self, mut f: impl FnMut(&X) -> Y) -> Ray<Y> {
        Ray {
            o: Vec3::new(f(&self.o.x), f(&self.o.y), f(&self.o.z)),
            d: Vec3::new(f(&self.d.x), f(&self.d.y), f(&self.d.z)),
            tmin: f(&self.tmin),
            tmax: f(&self.tmax),
        }
    }
}

impl<L: Lanes> Ray<L> {
    /// The ray in all lanes. As [`map`](Ray::map) with [`Lanes::splat`] but spelled out: it is in every kernel, and a
    /// function of any type is compiled with what happens to its numbers when the next one panics.
    #[inline(always)]
    pub fn splat(token: L::Token, ray: &Ray<L::Elem>) -> Self {
        let Ray { o, d, tmin, tmax } = *ray;
        Self {
            o: Vec3::new(L::splat(token, o.x), L::splat(token, o.y), L::splat(token, o.z)),
            d: Vec3::new(L::splat(token, d.x), L::splat(token, d.y), L::splat(token, d.z)),
            tmin: L::splat(token, tmin),
            tmax: L::splat(token, tmax),
        }
    }
}

impl<X: Copy> Ray<X> {
    /// The ray with axis `w` renamed to the last, see [`Vec3::with_axis_last`].
    #[inline(always)]
    pub fn with_axis_last(&self, w: usize) -> Self {
        Self { o: self.o.with_axis_last(w), d: self.d.with_axis_last(w), ..*self }
    }
}

impl<X: Number> Ray<X> {
    /// The point `o + t·d`.
    #[inline(always)]
    pub fn at(&self, t: X) -> Vec3<X> {
        self.d.mul_add(t, self.o)
    }
}

impl<X: Float> Ray<X> {
    /// The ray from `o` along `d` with `t` in `[0, ∞]`.
    pub fn new(o: impl Into<Vec3<X>>, d: impl Into<Vec3<X>>) -> Self {
        let (tmin, tmax) = (X::from_f64(0.0), X::from_f64(f64::INFINITY));
        Self { o: o.into(), d: d.into(), tmin, tmax }
    }

    /// The same ray with `t` in `[tmin, tmax]`.
    pub fn with_interval(self, tmin: X, tmax: X) -> Self {
        Self { tmin, tmax, ..self }
    }
}

impl From<Ray<f32>> for Ray<f64> {
    fn from(ray: Ray<f32>) -> Self {
        Self { o: ray.o.into(), d: ray.d.into(), tmin: ray.tmin.into(), tmax: ray.tmax.into() }
    }
}

/// Three points. The front face is the one from which `a, b, c` run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle<X> {
    /// First corner, of weight `alpha = 1 − beta − gamma`.
    pub a: Vec3<X>,
    /// Second corner, of weight `beta`.
    pub b: Vec3<X>,
    /// Third corner, of weight `gamma`.
    pub c: Vec3<X>,
}

impl<X> Triangle<X> {
    /// A triangle from its corners.
    pub fn new(a: impl Into<Vec3<X>>, b: impl Into<Vec3<X>>, c: impl Into<Vec3<X>>) -> Self {
        Self { a: a.into(), b: b.into(), c: c.into() }
    }

    /// Applies `f` to each number, corner by corner.
    #[inline(always)]
    pub fn map<Y>(&self, mut f: impl FnMut(&X) -> Y) -> Triangle<Y> {
        let Self { a, b, c } = self;
        Triangle {
            a: Vec3::new(f(&a.x), f(&a.y), f(&a.z)),
            b: Vec3::new(f(&b.x), f(&b.y), f(&b.z)),
            c: Vec3::new(f(&c.x), f(&c.y), f(&c.z)),
        }
    }
}

impl<X: Copy> Triangle<X> {
    /// The triangle with axis `w` renamed to the last, see [`Vec3::with_axis_last`].
    #[inline(always)]
    pub fn with_axis_last(&self, w: usize) -> Self {
        let [a, b, c] = self.corners().map(|v| v.with_axis_last(w));
        Self { a, b, c }
    }

    /// The corners in order.
    pub fn corners(self) -> [Vec3<X>; 3] {
        [self.a, self.b, self.c]
    }
}

impl<X: Scalar> Triangle<X> {
    /// The axis along which the normal is largest: along it the triangle's shadow is largest.
    #[inline(always)]
    pub fn projection_axis(&self) -> usize {
        self.normal().largest_axis()
    }

    /// The normal `(b − a) × (c − a)`, as long as twice the area; it points from the front.
    #[inline(always)]
    pub fn normal(&self) -> Vec3<X> {
        (self.b - self.a).cross(self.c - self.a)
    }

    /// Whether the corners lie on one line, or are equal: exactly so, not as rounding has it. For f64
    /// while the bits of its coordinates along each axis span less than 2⁸³⁷; what underflows beyond
    /// counts as zero.
    #[inline(always)]
    pub fn is_degenerate(&self) -> bool {
        X::are_collinear(self.corners().map(Vec3::to_array))
    }

    /// Whether anything can hit it: it is finite and has an area.
    #[allow(clippy::eq_op, reason = "x − x is NaN where x is not finite")]
    #[inline(always)]
    pub fn can_be_hit(&self) -> bool {
        let Self { a, b, c } = *self;
        let nothing = ((a - a) + (b - b) + (c - c)).sum();
        nothing == X::from_f64(0.0) && !self.is_degenerate()
    }

    /// The triangle as methods get to see it: NaN all over where nothing can hit it, so that nothing
    /// computed from it does, however it rounds.
    #[inline(always)]
    #[must_use]
    pub fn or_nothing(&self) -> Self {
        if self.can_be_hit() { *self } else { Self::nothing() }
    }

    /// A triangle that nothing hits: it fills up blocks.
    #[inline(always)]
    pub fn nothing() -> Self {
        let nan = X::from_f64(f64::NAN);
        let corner = Vec3::new(nan, nan, nan);
        Self { a: corner, b: corner, c: corner }
    }
}

impl From<Triangle<f32>> for Triangle<f64> {
    fn from(t: Triangle<f32>) -> Self {
        Self { a: t.a.into(), b: t.b.into(), c: t.c.into() }
    }
}

/// Where a ray meets a triangle: `o + t·d = (1 − beta − gamma)·a + beta·b + gamma·c`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<X> {
    /// Ray parameter, in units of the length of `d`.
    pub t: X,
    /// Barycentric weight of corner `b`, in `[0, 1]` up to rounding.
    pub beta: X,
    /// Barycentric weight of corner `c`, in `[0, 1]` up to rounding.
    pub gamma: X,
}
