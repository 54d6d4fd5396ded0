//! Whether a point is inside a solid, by counting where a ray crosses its surface.

use trisect_core::{Ray, Scalar, Triangle, Vec3};
use trisect_method::Place;

use crate::double::UNIT;
use crate::ladder::{self, Precision};
use crate::outcome::Outcome;
use crate::widened;

/// Where a point is with respect to the solid that a closed surface bounds: exactly so, on any input
/// that is finite. A point that is not finite is outside.
///
/// A ray goes up from the point, along the last axis, and the crossings that triangles
/// [own](trisect_method::ExactMethod::owns) are counted. Where the surface meets itself, space counts as
/// inside where it is enclosed an odd number of times; which way the triangles face plays no part, and
/// degenerate ones none either.
pub fn point_in_solid<X: Scalar>(point: Vec3<X>, surface: &[Triangle<X>]) -> Place {
    let precision = const { Precision::of_size(size_of::<X>()) };
    let point = point.map(X::to_f64);
    if !point.to_array().iter().all(|x| x.is_finite()) {
        return Place::Outside;
    }
    let up = Ray { o: point, d: Vec3::new(0.0, 0.0, 1.0), tmin: 0.0, tmax: f64::INFINITY };
    let mut crossings = 0_u64;
    for triangle in surface.iter().filter(|triangle| triangle.can_be_hit()) {
        let triangle = widened(triangle);
        if is_beside(point, &triangle) {
            continue;
        }
        if is_on(precision, point, &triangle) {
            return Place::On;
        }
        let is_hit = ladder::outcome(precision, &up, &triangle, UNIT) != Outcome::Miss;
        crossings += u64::from(is_hit && ladder::owns(precision, &up, &triangle, UNIT));
    }
    if crossings % 2 == 1 { Place::Inside } else { Place::Outside }
}

/// Whether the triangle is so far to one side, or below, that nothing of it is above the point.
fn is_beside(point: Vec3<f64>, triangle: &Triangle<f64>) -> bool {
    let corners = triangle.corners();
    let [x, y, _] = [0, 1, 2].map(|axis| corners.map(|v| v.to_array()[axis]));
    let is_off =
        |along: [f64; 3], at: f64| along.iter().all(|&c| c < at) || along.iter().all(|&c| c > at);
    is_off(x, point.x) || is_off(y, point.y) || corners.iter().all(|v| v.z < point.z)
}

/// Whether the point is on the closed triangle. A triangle with an area is parallel to two axes at most.
pub(crate) fn is_on(precision: Precision, point: Vec3<f64>, triangle: &Triangle<f64>) -> bool {
    let corners = triangle.corners().map(Vec3::to_array);
    let is_off = |(axis, at): (usize, f64)| {
        corners.iter().all(|v| v[axis] < at) || corners.iter().all(|v| v[axis] > at)
    };
    !(0..3).zip(point.to_array()).any(is_off)
        && [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().any(|axis| {
            let still = Ray { o: point, d: axis.into(), tmin: 0.0, tmax: 0.0 };
            ladder::outcome(precision, &still, triangle, UNIT) != Outcome::Miss
        })
}
