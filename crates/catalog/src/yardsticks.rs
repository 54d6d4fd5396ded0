//! Trees that are no method's fastest: what a study measures techniques and promises against. They are
//! compiled here, where loops are compiled well.

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{Claims, Homogeneous, Method, MethodInfo, Of, UnsuitableMesh};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_tracer::{Builder, ErasedBvh, EveryTriangle, Leaves, ScalarBvh, Tree};
use trisect_watertight::Watertight;

/// No tree: every ray is tested against every triangle, by scalar Möller–Trumbore on the calling thread.
///
/// # Errors
/// None: the method takes every mesh.
pub fn every_triangle(
    triangles: &[Triangle<f32>],
    _: Builder,
    _: Leaves,
) -> Result<Box<dyn Tree>, UnsuitableMesh> {
    Ok(Box::new(EveryTriangle::<MollerTrumbore>::new(triangles)?))
}

/// A tree of scalar Möller–Trumbore: one box and one triangle at a time, on the calling thread, with leaves of
/// the default size.
///
/// # Errors
/// None: the method takes every mesh.
pub fn scalar_tree(
    triangles: &[Triangle<f32>],
    builder: Builder,
    _: Leaves,
) -> Result<Box<dyn Tree>, UnsuitableMesh> {
    Ok(Box::new(ScalarBvh::<MollerTrumbore>::build(triangles, builder)?))
}

/// The [`erased_tree`](crate::Entry::erased_tree) of the method watertight without its promise: the same
/// formula, in boxes that do not allow for their rounding.
///
/// # Errors
/// None: the method takes every mesh.
pub fn waived_watertight(
    triangles: &[Triangle<f32>],
    builder: Builder,
    leaves: Leaves,
) -> Result<Box<dyn Tree>, UnsuitableMesh> {
    Ok(Box::new(ErasedBvh::build_with::<Waived>(triangles, builder, leaves)?))
}

/// Watertight without its promise: the same formula, in boxes that do not allow for their rounding.
struct Waived;

impl Method for Waived {
    const INFO: MethodInfo = MethodInfo {
        claims: Claims { watertight: false, ..<Watertight as Method>::INFO.claims },
        ..<Watertight as Method>::INFO
    };
    const TURNS: bool = <Watertight as Method>::TURNS;
    type Prepared = <Watertight as Method>::Prepared;
    type PreparedRay<L: Lanes> = <Watertight as Method>::PreparedRay<L>;
    type Alpha<L: Lanes> = <Watertight as Method>::Alpha<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, group: usize) -> Of<Self::Prepared, X> {
        <Watertight as Method>::prepare(triangle, group)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, group: usize) -> Self::PreparedRay<L> {
        <Watertight as Method>::prepare_ray(ray, group)
    }

    #[inline(always)]
    fn intersect<L: Lanes>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
    ) -> Homogeneous<L, Self::Alpha<L>> {
        <Watertight as Method>::intersect(ray, triangle)
    }

    #[inline(always)]
    fn facing<L: Lanes>(ray: &Self::PreparedRay<L>, triangle: &Of<Self::Prepared, L>, det: L) -> L {
        <Watertight as Method>::facing(ray, triangle, det)
    }

    #[inline(always)]
    fn normal<L: Lanes>(triangle: &Of<Self::Prepared, L>, group: usize) -> Option<Vec3<L>> {
        <Watertight as Method>::normal(triangle, group)
    }
}
