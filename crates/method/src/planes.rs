//! What methods have in common that are linear functions of a point: the plane first, then the point,
//! then `beta` and `gamma`; or the ray mapped to where the triangle is the unit triangle.

use core::marker::PhantomData;

use crate::frame::{Frame, Function};
use crate::method::{Homogeneous, Quotients};
use crate::record;
use crate::record::Of;
use crate::weights::Implied;
use trisect_core::{Lanes, Scalar};
use trisect_core::{Ray, Triangle, Vec3};

/// A formula that meets the plane first and finds `beta` and `gamma` as linear functions of the
/// point there.
///
/// Both forms of the division come from two functions: the point may be asked for times any
/// weight. Weighted by `det` it needs no division ([`deferred`](PlaneFirst::deferred)); weighted
/// by 1 it is the point itself ([`early`](PlaneFirst::early)), as the papers have it.
pub trait PlaneFirst<L: Lanes> {
    /// What is stored.
    type Triangle;

    /// `(det, t · det)` where the ray meets the plane.
    fn plane(ray: &Ray<L>, triangle: &Self::Triangle) -> (L, L);

    /// `(beta, gamma)`, times `weight`, of the point `(weight·o + t·d) / weight`.
    fn barycentrics(ray: &Ray<L>, triangle: &Self::Triangle, weight: L, t: L) -> (L, L);

    /// What [`Method::intersect`](crate::Method::intersect) returns.
    #[inline(always)]
    fn deferred(ray: &Ray<L>, triangle: &Self::Triangle) -> Homogeneous<L> {
        let (det, t) = Self::plane(ray, triangle);
        let (beta, gamma) = Self::barycentrics(ray, triangle, det, t);
        Homogeneous { det, t, alpha: Implied, beta, gamma }
    }

    /// What [`Method::intersect_early`](crate::Method::intersect_early) returns.
    #[inline(always)]
    fn early(ray: &Ray<L>, triangle: &Self::Triangle, reciprocal: impl Fn(L) -> L) -> Quotients<L> {
        let (det, dett) = Self::plane(ray, triangle);
        let t = dett * reciprocal(det);
        // A product with the constant 1 is compiled to nothing.
        let one = t.constant(L::Elem::from_f64(1.0));
        let (beta, gamma) = Self::barycentrics(ray, triangle, one, t);
        Quotients { det, t, alpha: Implied, beta, gamma }
    }
}

record! {
    /// Slopes of the three functions of a triangle: that of its plane, `beta` and `gamma`.
    pub struct Slopes {
        /// Along the normal: constant on the plane.
        plane: vec3,
        /// `e2 × n / n²`
        beta: vec3,
        /// `n × e1 / n²`
        gamma: vec3,
    }
}

impl<X: Scalar> Slopes<X> {
    /// The slopes, that of the plane being `n = e1 × e2`. Those of a triangle without area, or whose
    /// `n²` overflows, are NaN.
    #[inline(always)]
    pub fn new(triangle: &Triangle<X>) -> Self {
        let (e1, e2) = (triangle.b - triangle.a, triangle.c - triangle.a);
        let n = e1.cross(e2);
        let squared = n.dot(n).or_nan();
        let over_squared = |v: Vec3<X>| v.map(|x| x / squared);
        Self { plane: n, beta: over_squared(e2.cross(n)), gamma: over_squared(n.cross(e1)) }
    }

    /// In the order of [`Frame::store`].
    #[inline(always)]
    pub fn to_array(self) -> [Vec3<X>; 3] {
        [self.plane, self.beta, self.gamma]
    }
}

/// Three slopes, and what frame `F` stores beside them.
pub type Functions<F, L> = (Slopes<L>, Of<<F as Frame>::Stored, L>);

/// The three perpendicular planes of Havel 2008: one through the triangle, and two at right angles
/// to it on which `beta` and `gamma` are distances. What its methods do, whatever their division.
pub struct ThreePlanes<F>(PhantomData<F>);

impl<F: Frame> ThreePlanes<F> {
    /// What is stored for a triangle.
    #[inline(always)]
    pub fn prepare<X: Scalar>(triangle: &Triangle<X>) -> Functions<F, X> {
        let slopes = Slopes::new(triangle);
        (slopes, F::store(triangle.a, slopes.to_array()))
    }
}

impl<F: Frame, L: Lanes> PlaneFirst<L> for ThreePlanes<F> {
    type Triangle = Functions<F, L>;

    #[inline(always)]
    fn plane(ray: &Ray<L>, (slopes, stored): &Functions<F, L>) -> (L, L) {
        let one = ray.tmin.constant(L::Elem::from_f64(1.0));
        let o = F::relative(stored, ray.o);
        let height = F::evaluate(stored, Function::Plane, slopes.plane, o, one);
        (slopes.plane.dot(ray.d), -height)
    }

    #[inline(always)]
    fn barycentrics(ray: &Ray<L>, (slopes, stored): &Functions<F, L>, weight: L, t: L) -> (L, L) {
        let p = ray.d.mul_add(t, F::relative(stored, ray.o).scale(weight));
        (
            F::evaluate(stored, Function::Beta, slopes.beta, p, weight),
            F::evaluate(stored, Function::Gamma, slopes.gamma, p, weight),
        )
    }
}

/// The values of the plane's function, `beta` and `gamma` at a ray's origin, and their change along
/// its direction: the ray as seen from the unit triangle, where `plane` is the height.
#[derive(Clone, Copy, Debug)]
pub struct MappedRay<L> {
    /// At the origin: plane, `beta`, `gamma`.
    pub o: [L; 3],
    /// Along the direction.
    pub d: [L; 3],
}

impl<L: Lanes> MappedRay<L> {
    /// The ray seen through three functions in frame `F`.
    #[inline(always)]
    pub fn new<F: Frame>(ray: &Ray<L>, (slopes, stored): &Functions<F, L>) -> Self {
        let one = ray.tmin.constant(L::Elem::from_f64(1.0));
        let o = F::relative(stored, ray.o);
        let Slopes { plane, beta, gamma } = *slopes;
        Self {
            o: [
                F::evaluate(stored, Function::Plane, plane, o, one),
                F::evaluate(stored, Function::Beta, beta, o, one),
                F::evaluate(stored, Function::Gamma, gamma, o, one),
            ],
            d: [plane.dot(ray.d), beta.dot(ray.d), gamma.dot(ray.d)],
        }
    }

    /// What [`Method::intersect`](crate::Method::intersect) returns.
    #[inline(always)]
    pub fn deferred(&self) -> Homogeneous<L> {
        let Self { o: [height, beta, gamma], d: [det, dbeta, dgamma] } = *self;
        let t = -height;
        Homogeneous {
            det,
            t,
            alpha: Implied,
            beta: beta.mul_add(det, t * dbeta),
            gamma: gamma.mul_add(det, t * dgamma),
        }
    }

    /// What [`Method::intersect_early`](crate::Method::intersect_early) returns.
    #[inline(always)]
    pub fn early(&self, reciprocal: impl Fn(L) -> L) -> Quotients<L> {
        let Self { o: [height, beta, gamma], d: [det, dbeta, dgamma] } = *self;
        let t = -height * reciprocal(det);
        Quotients {
            det,
            t,
            alpha: Implied,
            beta: t.mul_add(dbeta, beta),
            gamma: t.mul_add(dgamma, gamma),
        }
    }
}
