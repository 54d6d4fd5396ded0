//! One ray against one triangle.

use crate::prepared::turning_axis;
use trisect_core::Scalar;
use trisect_core::{Hit, Ray, Triangle};
use trisect_method::Method;
use trisect_method::{Culling, Deferred, Division, Early, Interval, TrueDivision};
use trisect_method::{Of, Record as _};

/// Where `ray` meets `triangle`, seen from either side, decided with the deferred division where the
/// method has it. Prepares the triangle for the one test: for many tests see
/// [`one_ray`](crate::one_ray) and [`one_triangle`](crate::one_triangle).
pub fn intersect<M: Method, E: Scalar>(ray: &Ray<E>, triangle: &Triangle<E>) -> Option<Hit<E>> {
    if M::INFO.forms.deferred() {
        intersect_with::<M, Deferred<TrueDivision, true>, E>(ray, triangle, Culling::None)
    } else {
        intersect_with::<M, Early<TrueDivision, true>, E>(ray, triangle, Culling::None)
    }
}

/// A ray and a triangle, prepared for each other.
pub struct PreparedPair<M: Method, E: Scalar> {
    /// The ray.
    pub ray: M::PreparedRay<E>,
    /// The triangle.
    pub triangle: Of<M::Prepared, E>,
    /// The kind of the triangle.
    pub group: usize,
}

impl<M: Method, E: Scalar> PreparedPair<M, E> {
    /// Prepares both.
    pub fn new(ray: &Ray<E>, triangle: &Triangle<E>) -> Self {
        Self::of_group(ray, triangle, M::group(triangle))
    }

    /// Prepares both, the triangle as one of kind `group`.
    pub fn of_group(ray: &Ray<E>, triangle: &Triangle<E>, group: usize) -> Self {
        let axis = turning_axis::<M, E>(ray);
        let triangle =
            M::Prepared::with_axis_last(&M::prepare(&triangle.or_nothing(), group), axis);
        Self { ray: M::prepare_ray(&ray.with_axis_last(axis), group), triangle, group }
    }

    /// The hit, if there is one.
    pub fn test<D: Division>(&self, interval: Interval<E>, culling: Culling) -> Option<Hit<E>> {
        let mut result = None;
        M::test::<E, D>(&self.ray, &self.triangle, interval, culling, |mask, hit| {
            result = mask.then_some(hit);
        });
        result
    }
}

/// [`intersect`] with the division and the culling of choice.
pub fn intersect_with<M: Method, D: Division, E: Scalar>(
    ray: &Ray<E>,
    triangle: &Triangle<E>,
    culling: Culling,
) -> Option<Hit<E>> {
    let interval = Interval::of(ray);
    PreparedPair::<M, E>::new(ray, triangle).test::<D>(interval, culling)
}
