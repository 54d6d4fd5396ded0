//! One ray against one triangle, for who has no more than that.

use crate::division::{Culling, Deferred, Division, Interval, TrueDivision};
use crate::geometry::{Hit, Ray, Triangle};
use crate::lanes::Scalar;
use crate::method::Method;

/// Where `ray` meets `triangle`, seen from either side. Prepares the triangle for the one test:
/// for many tests see [`one_ray`](crate::one_ray) and [`one_triangle`](crate::one_triangle).
pub fn intersect<M: Method, E: Scalar>(ray: &Ray<E>, triangle: &Triangle<E>) -> Option<Hit<E>> {
    intersect_with::<M, Deferred<TrueDivision, true>, E>(ray, triangle, Culling::None)
}

/// [`intersect`] with the division and the culling of choice.
pub fn intersect_with<M: Method, D: Division, E: Scalar>(
    ray: &Ray<E>,
    triangle: &Triangle<E>,
    culling: Culling,
) -> Option<Hit<E>> {
    let group = M::group(triangle);
    let mut result = None;
    D::test::<M, E>(
        &M::prepare_ray(ray, group),
        &M::prepare(triangle, group),
        Interval::new(ray.tmin, ray.tmax),
        culling,
        |mask, hit| result = mask.then_some(hit),
    );
    result
}
