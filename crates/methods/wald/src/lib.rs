#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{
    Hit, Homogeneous, Lanes, Method, MethodInfo, Of, PlaneFirst, Ray, Scalar, Triangle, Vec3,
    record,
};

record! {
    /// The plane scaled to `n|w = 1`, and `beta` and `gamma` as functions of the projected point.
    pub struct ProjectedTriangle {
        /// `n|u / n|w`
        nu: number,
        /// `n|v / n|w`
        nv: number,
        /// `nu·A|u + nv·A|v + A|w`
        nd: number,
        /// `beta = bu·P|u + bv·P|v + bd`
        bu: number,
        /// See `bu`.
        bv: number,
        /// See `bu`.
        bd: number,
        /// `gamma = cu·P|u + cv·P|v + cd`
        cu: number,
        /// See `cu`.
        cv: number,
        /// See `cu`.
        cd: number,
    }
}

/// A ray with its coordinates in the order `u, v, w`.
#[derive(Clone, Copy)]
pub struct ProjectedRay<L> {
    o: Vec3<L>,
    d: Vec3<L>,
}

/// Wald 2004.
pub struct Wald;

impl PlaneFirst for Wald {
    #[inline(always)]
    fn plane<L: Lanes>(ray: &ProjectedRay<L>, tri: &ProjectedTriangle<L>) -> (L, L) {
        let along = |p: Vec3<L>| tri.nu.mul_add(p.x, tri.nv.mul_add(p.y, p.z));
        (along(ray.d), tri.nd - along(ray.o))
    }

    #[inline(always)]
    fn barycentrics<L: Lanes>(
        ray: &ProjectedRay<L>,
        tri: &ProjectedTriangle<L>,
        weight: L,
        t: L,
    ) -> (L, L) {
        let pu = t.mul_add(ray.d.x, weight * ray.o.x);
        let pv = t.mul_add(ray.d.y, weight * ray.o.y);
        (
            pu.mul_add(tri.bu, pv.mul_add(tri.bv, weight * tri.bd)),
            pu.mul_add(tri.cu, pv.mul_add(tri.cv, weight * tri.cd)),
        )
    }
}

impl Method for Wald {
    const INFO: MethodInfo = MethodInfo {
        name: "wald",
        title: "Wald",
        year: 2004,
        source: "I. Wald: Realtime Ray Tracing and Interactive Global Illumination. \
                 PhD thesis, Saarland University, 2004, section 7.1",
        outputs: &["hit", "t", "beta", "gamma"],
        error_factor: 64.0,
    };
    const GROUPS: usize = 3;
    type Prepared = ProjectedTriangle<()>;
    type PreparedRay<L: Lanes> = ProjectedRay<L>;

    /// The axis `w` along which the normal is largest.
    #[inline(always)]
    fn group<X: Scalar>(triangle: &Triangle<X>) -> usize {
        let n = (triangle.b - triangle.a).cross(triangle.c - triangle.a).map(X::abs);
        if n.x >= n.y && n.x >= n.z {
            0
        } else if n.y >= n.z {
            1
        } else {
            2
        }
    }

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, w: usize) -> Of<Self::Prepared, X> {
        let a = triangle.a.with_axis_last(w);
        let e1 = triangle.b.with_axis_last(w) - a;
        let e2 = triangle.c.with_axis_last(w) - a;
        let n = e1.cross(e2);
        let (nu, nv) = (n.x / n.z, n.y / n.z);
        ProjectedTriangle {
            nu,
            nv,
            nd: nu.mul_add(a.x, nv.mul_add(a.y, a.z)),
            bu: e2.y / n.z,
            bv: -e2.x / n.z,
            bd: a.y.mul_sub(e2.x, a.x * e2.y) / n.z,
            cu: -e1.y / n.z,
            cv: e1.x / n.z,
            cd: a.x.mul_sub(e1.y, a.y * e1.x) / n.z,
        }
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, w: usize) -> ProjectedRay<L> {
        ProjectedRay { o: ray.o.with_axis_last(w), d: ray.d.with_axis_last(w) }
    }

    #[inline(always)]
    fn intersect<L: Lanes>(
        ray: &ProjectedRay<L>,
        triangle: &ProjectedTriangle<L>,
    ) -> Homogeneous<L> {
        Self::deferred(ray, triangle)
    }

    /// As published: `t` first, then the point, then `beta` and `gamma`.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &ProjectedRay<L>,
        triangle: &ProjectedTriangle<L>,
        reciprocal: impl Fn(L) -> L,
    ) -> (L, Hit<L>) {
        Self::early(ray, triangle, reciprocal)
    }

    /// `det` lost the sign of `n|w` with the scale; `bu·cv − bv·cu = 1 / n|w` brings it back.
    #[inline(always)]
    fn facing<L: Lanes>(tri: &ProjectedTriangle<L>, det: L) -> L {
        det * tri.bv.mul_sub(tri.cu, tri.bu * tri.cv)
    }
}

trisect_core::methods!(Wald);
