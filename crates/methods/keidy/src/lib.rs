#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Corners, Homogeneous, Implied, Input, Method, MethodInfo, Of, Output, Quotients,
};

/// Keidy's test of a point by the edges' Gram matrix, completed with barycentrics.
pub struct Keidy;

/// The weights of the point `A + p`, times the Gram determinant, and that determinant.
#[inline(always)]
fn weights<L: Lanes>(e1: Vec3<L>, e2: Vec3<L>, p: Vec3<L>) -> (L, L, L) {
    let (a, b, c) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
    let (d, e) = (p.dot(e1), p.dot(e2));
    (d.mul_sub(c, e * b), e.mul_sub(a, d * b), a.mul_sub(c, b * b))
}

impl Method for Keidy {
    const INFO: MethodInfo = MethodInfo {
        name: "keidy",
        title: "Keidy, by the Gram matrix",
        year: 2003,
        source: "K. Fauerby: Improved Collision Detection and Response, 2003, appendix (the point \
                 test that is ascribed to Keidy); D. Sunday: Intersections of Rays and Triangles, \
                 2001",
        input: Input::Points,
        outputs: Output::ALL,
        ..MethodInfo::USUAL
    };
    type Prepared = Corners<()>;
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        Corners::new(triangle)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    /// Both determinants multiplied into one denominator.
    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, corners: &Corners<L>) -> Homogeneous<L> {
        let (e1, e2) = corners.edges();
        let n = e1.cross(e2);
        let s = corners.a - ray.o;
        let (det, t) = (n.dot(ray.d), n.dot(s));
        let (beta, gamma, gram) = weights(e1, e2, ray.d.scale(t) - s.scale(det));
        Homogeneous { det: det * gram, t: t * gram, alpha: Implied, beta, gamma }
    }

    /// As published: a division for `t`, another for the Gram matrix.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        corners: &Corners<L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L> {
        let (e1, e2) = corners.edges();
        let n = e1.cross(e2);
        let s = corners.a - ray.o;
        let det = n.dot(ray.d);
        let t = n.dot(s) * reciprocal(det);
        let (beta, gamma, gram) = weights(e1, e2, ray.d.mul_add(t, -s));
        let r = reciprocal(gram);
        Quotients { det, t, alpha: Implied, beta: beta * r, gamma: gamma * r }
    }

    /// Here `det = D·N`, or that times the Gram determinant, which is `N²`.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, _triangle: &Of<Self::Prepared, L>, det: L) -> L {
        -det
    }

    #[inline(always)]
    fn normal<L: Lanes>(corners: &Corners<L>, _group: usize) -> Option<Vec3<L>> {
        Some(corners.normal())
    }
}

trisect_method::methods!(Keidy);
