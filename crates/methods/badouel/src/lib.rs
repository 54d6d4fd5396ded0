#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Forms, Frame, Homogeneous, Implied, Method, MethodInfo, Of, Output, Quotients, Start, Vertex,
    World, record,
};

record! {
    /// The normal and the projected edges, the axes in the order `u, v, w`.
    pub struct ProjectedEdges {
        /// `N = e1 × e2`; its last coordinate is the 2×2 determinant of the projected edges.
        n: vec3,
        /// `e1|u`
        e1u: number,
        /// `e1|v`
        e1v: number,
        /// `e2|u`
        e2u: number,
        /// `e2|v`
        e2v: number,
    }
}

/// What is stored: normal, edges, and what frame `F` keeps of the plane and of corner `A`.
type Stored<F> = (ProjectedEdges<()>, <F as Frame>::Anchored);

#[inline(always)]
fn prepare<F: Frame, X: Scalar>(triangle: &Triangle<X>, w: usize) -> Of<Stored<F>, X> {
    let Triangle { a, b, c } = triangle.with_axis_last(w);
    let (e1, e2) = (b - a, c - a);
    let n = e1.cross(e2);
    (ProjectedEdges { n, e1u: e1.x, e1v: e1.y, e2u: e2.x, e2v: e2.y }, F::anchor(a, n))
}

/// `(det, t)` and the projected point as seen from `A`, after the first division.
#[inline(always)]
fn meet<F: Frame, L: Lanes>(
    ray: &Ray<L>,
    (tri, anchor): &Of<Stored<F>, L>,
    reciprocal: impl Fn(L) -> L,
) -> (L, L, L, L) {
    let det = tri.n.dot(ray.d);
    let Start { height, u, v } = F::start(anchor, tri.n, ray.o);
    let t = height * reciprocal(det);
    (det, t, t.mul_sub(ray.d.x, u), t.mul_sub(ray.d.y, v))
}

/// Cramer's rule, both determinants multiplied into one denominator.
#[inline(always)]
fn numerators<F: Frame, L: Lanes>(
    ray: &Ray<L>,
    (tri, anchor): &Of<Stored<F>, L>,
) -> Homogeneous<L> {
    let det = tri.n.dot(ray.d);
    let Start { height, u, v } = F::start(anchor, tri.n, ray.o);
    // The projected point as seen from A, times det.
    let pu = height.mul_sub(ray.d.x, det * u);
    let pv = height.mul_sub(ray.d.y, det * v);
    Homogeneous {
        det: det * tri.n.z,
        t: height * tri.n.z,
        alpha: Implied,
        beta: tri.e2v.mul_sub(pu, tri.e2u * pv),
        gamma: tri.e1u.mul_sub(pv, tri.e1v * pu),
    }
}

/// Positive at the front, of `det = D·N · N|w`.
#[inline(always)]
fn facing<L: Lanes>(tri: &ProjectedEdges<L>, det: L) -> L {
    (-det).xor_sign(tri.n.z)
}

const INFO: MethodInfo = MethodInfo {
    year: 1990,
    source: "D. Badouel: An Efficient Ray-Polygon Intersection. Graphics Gems, Academic Press, 1990",
    outputs: Output::ALL,
    ..MethodInfo::USUAL
};

/// Badouel's projection, solved by Cramer's rule; the plane's constant in frame `F`.
pub struct BadouelCramer<F = World>(PhantomData<F>);

impl<F: Frame> Method for BadouelCramer<F> {
    const INFO: MethodInfo = MethodInfo {
        name: if F::RELATIVE { "badouel-relative" } else { "badouel" },
        title: if F::RELATIVE {
            "Badouel by Cramer's rule from a corner"
        } else {
            "Badouel by Cramer's rule"
        },
        ..INFO
    };
    const GROUPS: usize = 3;
    type Prepared = Stored<F>;
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn group<X: Scalar>(triangle: &Triangle<X>) -> usize {
        triangle.projection_axis()
    }

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, w: usize) -> Of<Self::Prepared, X> {
        prepare::<F, X>(triangle, w)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, w: usize) -> Ray<L> {
        ray.with_axis_last(w)
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, stored: &Of<Self::Prepared, L>) -> Homogeneous<L> {
        numerators::<F, L>(ray, stored)
    }

    /// As published: a division for `t`, another for the 2×2 system.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        stored: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L> {
        let (det, t, pu, pv) = meet::<F, L>(ray, stored, &reciprocal);
        let tri = &stored.0;
        let r = reciprocal(tri.n.z);
        Quotients {
            // Its sign is all that is asked of it, and no product that may underflow.
            det: det.xor_sign(tri.n.z),
            t,
            alpha: Implied,
            beta: tri.e2v.mul_sub(pu, tri.e2u * pv) * r,
            gamma: tri.e1u.mul_sub(pv, tri.e1v * pu) * r,
        }
    }

    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, (tri, _): &Of<Self::Prepared, L>, det: L) -> L {
        facing(tri, det)
    }

    #[inline(always)]
    fn normal<L: Lanes>((tri, _): &Of<Self::Prepared, L>, w: usize) -> Option<Vec3<L>> {
        Some(tri.n.with_axis_restored(w))
    }
}

/// Badouel 1990 as printed: the system solved by elimination, with a branch where `e1|u = 0`.
pub struct Badouel1990;

impl Method for Badouel1990 {
    const INFO: MethodInfo = MethodInfo {
        name: "badouel-branch",
        title: "Badouel as printed",
        forms: Forms::Early,
        // Elimination without pivoting has no bound: a short `e1|u` is divided by. What the testkit's
        // pairs show, four times over.
        error_factor: 16384.0,
        ..INFO
    };
    const GROUPS: usize = 3;
    type Prepared = Stored<World>;
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn group<X: Scalar>(triangle: &Triangle<X>) -> usize {
        triangle.projection_axis()
    }

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, w: usize) -> Of<Self::Prepared, X> {
        prepare::<World, X>(triangle, w)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, w: usize) -> Ray<L> {
        ray.with_axis_last(w)
    }

    /// For decisions alone: elimination without its divisions is Cramer's rule.
    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, stored: &Of<Self::Prepared, L>) -> Homogeneous<L> {
        numerators::<World, L>(ray, stored)
    }

    /// Lanes take both branches and choose.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        stored: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L> {
        let (det, t, pu, pv) = meet::<World, L>(ray, stored, &reciprocal);
        let (n, ProjectedEdges { e1u, e1v, e2u, e2v, .. }) = (stored.0.n, stored.0);
        let upright = e1u.is_zero();
        let left = L::select(upright, pu, e1u.mul_sub(pv, e1v * pu));
        let gamma = left * reciprocal(L::select(upright, e2u, n.z));
        let left = L::select(upright, pv, pu) - gamma * L::select(upright, e2v, e2u);
        let beta = left * reciprocal(L::select(upright, e1v, e1u));
        Quotients { det: det.xor_sign(n.z), t, alpha: Implied, beta, gamma }
    }

    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, (tri, _): &Of<Self::Prepared, L>, det: L) -> L {
        facing(tri, det)
    }

    #[inline(always)]
    fn normal<L: Lanes>((tri, _): &Of<Self::Prepared, L>, w: usize) -> Option<Vec3<L>> {
        Some(tri.n.with_axis_restored(w))
    }
}

trisect_method::methods!(BadouelCramer, Badouel1990, BadouelCramer<Vertex>);
