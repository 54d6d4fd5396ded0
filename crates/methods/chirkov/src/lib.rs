#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Forms, Frame, Given, Homogeneous, Method, MethodInfo, Of, Output, Start, Vertex, World, record,
};

record! {
    /// The normal and the projected edges, the axes in the order `u, v, w`.
    pub struct ProjectedEdges {
        /// `N = e1 × e2`
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

/// Chirkov 2005, with the plane's constant in frame `F`.
pub struct Chirkov<F = World>(PhantomData<F>);

impl<F: Frame> Method for Chirkov<F> {
    const INFO: MethodInfo = MethodInfo {
        name: if F::RELATIVE { "chirkov-relative" } else { "chirkov" },
        title: if F::RELATIVE { "Chirkov from a corner" } else { "Chirkov" },
        year: 2005,
        source: "N. Chirkov: Fast 3D Line Segment–Triangle Intersection Test. Journal of Graphics \
                 Tools 10(3), 2005",
        outputs: Output::FLAG_T_AND_NORMAL,
        forms: Forms::Deferred,
        ..MethodInfo::USUAL
    };
    const GROUPS: usize = 3;
    type Prepared = (ProjectedEdges<()>, F::Anchored);
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Given<L>;

    #[inline(always)]
    fn group<X: Scalar>(triangle: &Triangle<X>) -> usize {
        triangle.projection_axis()
    }

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, w: usize) -> Of<Self::Prepared, X> {
        let Triangle { a, b, c } = triangle.with_axis_last(w);
        let (e1, e2) = (b - a, c - a);
        let n = e1.cross(e2);
        let edges = ProjectedEdges { n, e1u: e1.x, e1v: e1.y, e2u: e2.x, e2v: e2.y };
        (edges, F::anchor(a, n))
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, w: usize) -> Ray<L> {
        ray.with_axis_last(w)
    }

    /// The weights are areas of the projection times `det`; the sign of `N|w` is taken out of them,
    /// so that they have that of `det` inside.
    #[inline(always)]
    fn intersect<L: Lanes>(
        ray: &Ray<L>,
        (tri, anchor): &Of<Self::Prepared, L>,
    ) -> Homogeneous<L, Given<L>> {
        let ProjectedEdges { n, e1u, e1v, e2u, e2v } = *tri;
        let det = n.dot(ray.d);
        let Start { height: t, u, v } = F::start(anchor, n, ray.o);
        // The projected point as seen from A, and from B, times det.
        let (pu, pv) = (t.mul_sub(ray.d.x, det * u), t.mul_sub(ray.d.y, det * v));
        let (qu, qv) = (pu - det * e1u, pv - det * e1v);
        let (e3u, e3v) = (e1u - e2u, e1v - e2v);
        Homogeneous {
            det,
            t,
            alpha: Given(qu.mul_sub(e3v, qv * e3u).xor_sign(n.z)),
            beta: pu.mul_sub(e2v, pv * e2u).xor_sign(n.z),
            gamma: e1u.mul_sub(pv, e1v * pu).xor_sign(n.z),
        }
    }

    /// Here `det = D·N`, which is negative at the front.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, _triangle: &Of<Self::Prepared, L>, det: L) -> L {
        -det
    }

    #[inline(always)]
    fn normal<L: Lanes>((tri, _): &Of<Self::Prepared, L>, w: usize) -> Option<Vec3<L>> {
        Some(tri.n.with_axis_restored(w))
    }
}

trisect_method::methods!(Chirkov, Chirkov<Vertex>);
