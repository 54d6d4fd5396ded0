#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Frame, Function, Homogeneous, Implied, Method, MethodInfo, Of, PlaneFirst, Quotients,
    UnsuitableMesh, Vertex, World, record,
};

mod axis;

pub use axis::{AxisChoice, ByIndices, ByTable, Fixed, Grouped, NoCommonAxis, Sorted};

record! {
    /// Slopes over the projected plane: the triangle's plane scaled to `n|w = 1`, `beta`, `gamma`.
    pub struct ProjectedTriangle {
        /// `n|u / n|w`
        nu: number,
        /// `n|v / n|w`
        nv: number,
        /// `beta = bu·P|u + bv·P|v + bd`
        bu: number,
        /// See `bu`.
        bv: number,
        /// `gamma = cu·P|u + cv·P|v + cd`
        cu: number,
        /// See `cu`.
        cv: number,
    }
}

/// Wald 2004: the axis as `A` keeps it, constants in frame `F`.
pub struct Wald<A = Grouped, F = World>(PhantomData<(A, F)>);

/// The test of a ray whose axes are in the order `u, v, w`.
struct Projected<F>(PhantomData<F>);

impl<F: Frame, L: Lanes> PlaneFirst<L> for Projected<F> {
    type Triangle = (ProjectedTriangle<L>, Of<F::Stored, L>);

    #[inline(always)]
    fn plane(ray: &Ray<L>, (tri, stored): &Self::Triangle) -> (L, L) {
        let o = F::relative(stored, ray.o);
        (
            tri.nu.mul_add(ray.d.x, tri.nv.mul_add(ray.d.y, ray.d.z)),
            -tri.nu.mul_add(o.x, tri.nv.mul_add(o.y, F::plus(stored, Function::Plane, o.z))),
        )
    }

    #[inline(always)]
    fn barycentrics(ray: &Ray<L>, (tri, stored): &Self::Triangle, weight: L, t: L) -> (L, L) {
        let o = F::relative(stored, ray.o);
        let pu = t.mul_add(ray.d.x, weight * o.x);
        let pv = t.mul_add(ray.d.y, weight * o.y);
        (
            pu.mul_add(tri.bu, F::last(stored, Function::Beta, tri.bv, pv, weight)),
            pu.mul_add(tri.cu, F::last(stored, Function::Gamma, tri.cv, pv, weight)),
        )
    }
}

impl<A: AxisChoice, F: Frame> Method for Wald<A, F> {
    const INFO: MethodInfo = MethodInfo {
        name: if F::RELATIVE { "wald-relative" } else { A::NAME },
        title: if F::RELATIVE { "Wald from a corner" } else { A::TITLE },
        year: 2004,
        source: "I. Wald: Realtime Ray Tracing and Interactive Global Illumination. \
                 PhD thesis, Saarland University, 2004, section 7.1",
        ..MethodInfo::USUAL
    };
    const GROUPS: usize = A::GROUPS;
    type Prepared = ((ProjectedTriangle<()>, F::Stored), A::Stored);
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn group<X: Scalar>(triangle: &Triangle<X>) -> usize {
        if A::GROUPS == 1 { 0 } else { triangle.projection_axis() }
    }

    fn mesh_group<X: Scalar>(triangles: &[Triangle<X>]) -> Result<Option<usize>, UnsuitableMesh> {
        A::mesh_axis(triangles)
    }

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, group: usize) -> Of<Self::Prepared, X> {
        let w = if A::GROUPS == 1 { triangle.projection_axis() } else { group };
        let Triangle { a, b, c } = triangle.with_axis_last(w);
        let (e1, e2) = (b - a, c - a);
        let n = e1.cross(e2).map(X::or_nan);
        let plane = Vec3::new(n.x / n.z, n.y / n.z, X::from_f64(1.0));
        let beta = Vec3::new(e2.y / n.z, -e2.x / n.z, X::from_f64(0.0));
        let gamma = Vec3::new(-e1.y / n.z, e1.x / n.z, X::from_f64(0.0));
        let projected = ProjectedTriangle {
            nu: plane.x,
            nv: plane.y,
            bu: beta.x,
            bv: beta.y,
            cu: gamma.x,
            cv: gamma.y,
        };
        ((projected, F::store(a, [plane, beta, gamma])), A::store(w))
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, group: usize) -> Ray<L> {
        if A::GROUPS == 1 { *ray } else { ray.with_axis_last(group) }
    }

    #[inline(always)]
    fn intersect<L: Lanes>(
        ray: &Ray<L>,
        (triangle, axis): &Of<Self::Prepared, L>,
    ) -> Homogeneous<L> {
        Projected::<F>::deferred(&A::in_order(axis, ray), triangle)
    }

    /// As published: `t` first, then the point, then `beta` and `gamma`.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        (triangle, axis): &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L> {
        Projected::<F>::early(&A::in_order(axis, ray), triangle, reciprocal)
    }

    /// `det` lost the sign of `n|w` with the scale; `bu·cv − bv·cu = 1 / n|w` brings it back.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, ((tri, _), _): &Of<Self::Prepared, L>, det: L) -> L {
        det * tri.bv.mul_sub(tri.cu, tri.bu * tri.cv)
    }
}

trisect_method::methods!(Wald, Wald<ByTable>, Wald<ByIndices>, Wald<Fixed>, Wald<Grouped, Vertex>);
