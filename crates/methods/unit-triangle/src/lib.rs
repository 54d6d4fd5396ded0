#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle};
use trisect_method::{
    Frame, Homogeneous, Implied, MappedRay, Method, MethodInfo, Of, Quotients, Slopes, Vertex,
    World,
};

/// Unit triangle, Woop 2004, with constants in frame `F`.
pub struct UnitTriangle<F = World>(PhantomData<F>);

impl<F: Frame> Method for UnitTriangle<F> {
    const INFO: MethodInfo = MethodInfo {
        name: if F::RELATIVE { "unit-triangle-relative" } else { "unit-triangle" },
        title: if F::RELATIVE { "Unit triangle from a corner" } else { "Unit triangle" },
        year: 2004,
        source: "S. Woop: A Ray Tracing Hardware Architecture for Dynamic Scenes. Diploma thesis, \
                 Saarland University, 2004",
        ..MethodInfo::USUAL
    };
    type Prepared = (Slopes<()>, F::Stored);
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        let mut slopes = Slopes::new(triangle);
        let squared = slopes.plane.dot(slopes.plane);
        slopes.plane = slopes.plane.map(|x| x / squared);
        (slopes, F::store(triangle.a, slopes.to_array()))
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, map: &Of<Self::Prepared, L>) -> Homogeneous<L> {
        MappedRay::new::<F>(ray, map).deferred()
    }

    /// As published: `t` first.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        map: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L> {
        MappedRay::new::<F>(ray, map).early(reciprocal)
    }

    /// Here `det = D·N / N²`, which is negative at the front.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, _map: &Of<Self::Prepared, L>, det: L) -> L {
        -det
    }
}

trisect_method::methods!(UnitTriangle, UnitTriangle<Vertex>);
