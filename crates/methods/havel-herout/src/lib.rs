#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Forms, Frame, Homogeneous, Implied, Method, MethodInfo, Of, Output, PlaneFirst, Slopes,
    ThreePlanes, Vertex, World,
};

/// Havel–Herout 2010, with constants in frame `F`.
pub struct HavelHerout<F = World>(PhantomData<F>);

impl<F: Frame> Method for HavelHerout<F> {
    const INFO: MethodInfo = MethodInfo {
        name: if F::RELATIVE { "havel-herout-relative" } else { "havel-herout" },
        title: if F::RELATIVE { "Havel–Herout from a corner" } else { "Havel–Herout" },
        year: 2010,
        source: "J. Havel, A. Herout: Yet Faster Ray-Triangle Intersection (Using SSE4). IEEE \
                 Transactions on Visualization and Computer Graphics 16(3), 2010",
        outputs: Output::ALL,
        forms: Forms::Deferred,
        ..MethodInfo::USUAL
    };
    type Prepared = (Slopes<()>, F::Stored);
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        ThreePlanes::<F>::prepare(triangle)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, triangle: &Of<Self::Prepared, L>) -> Homogeneous<L> {
        ThreePlanes::<F>::deferred(ray, triangle)
    }

    /// Here `det = D·N`, which is negative at the front.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, _triangle: &Of<Self::Prepared, L>, det: L) -> L {
        -det
    }

    #[inline(always)]
    fn normal<L: Lanes>((slopes, _): &Of<Self::Prepared, L>, _group: usize) -> Option<Vec3<L>> {
        Some(slopes.plane)
    }
}

trisect_method::methods!(HavelHerout, HavelHerout<Vertex>);
