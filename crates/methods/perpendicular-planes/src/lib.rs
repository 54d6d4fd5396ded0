#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Forms, Frame, Homogeneous, Implied, Method, MethodInfo, Of, Output, PlaneFirst, Quotients,
    Slopes, ThreePlanes, Vertex, World,
};

/// Perpendicular planes, Havel 2008, with constants in frame `F`.
pub struct PerpendicularPlanes<F = World>(PhantomData<F>);

impl<F: Frame> Method for PerpendicularPlanes<F> {
    const INFO: MethodInfo = MethodInfo {
        name: if F::RELATIVE { "perpendicular-planes-relative" } else { "perpendicular-planes" },
        title: if F::RELATIVE {
            "Perpendicular planes from a corner"
        } else {
            "Perpendicular planes"
        },
        year: 2008,
        source: "J. Havel: Rychlý výpočet průsečíku paprsku s trojúhelníkem (Fast Ray-Triangle \
                 Intersection). Master's thesis, Brno University of Technology, 2008, section 3.5",
        outputs: Output::ALL,
        forms: Forms::Early,
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

    /// As Havel and Herout have it.
    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, triangle: &Of<Self::Prepared, L>) -> Homogeneous<L> {
        ThreePlanes::<F>::deferred(ray, triangle)
    }

    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        triangle: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L> {
        ThreePlanes::<F>::early(ray, triangle, reciprocal)
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

trisect_method::methods!(PerpendicularPlanes, PerpendicularPlanes<Vertex>);
