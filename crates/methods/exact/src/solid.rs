//! Whether a point is inside a solid, by counting where a ray crosses its surface.

use core::cmp::Ordering;

use trisect_core::{Ray, Scalar, Triangle, Vec3};

use crate::double::UNIT;
use crate::ladder::{self, Precision};
use crate::outcome::Outcome;
use crate::widened;

/// Where a point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Inside the solid, not on its surface.
    Inside,
    /// On the surface.
    On,
    /// Outside the solid, not on its surface.
    Outside,
}

/// Where a point is with respect to the solid that a closed surface bounds: exactly so, on any input
/// that is finite. A point that is not finite is outside.
///
/// A ray goes up from the point, along the last axis, and crossings are counted. What it meets at an edge
/// or at a corner has one owner: the ray is thought of as moved by `ε` along the first axis and by `ε²`
/// along the second, less than any distance that there is, so that it meets neither (H. Edelsbrunner,
/// E. P. Mücke: Simulation of Simplicity. ACM Transactions on Graphics 9(1), 1990). Where the surface
/// meets itself, space counts as inside where it is enclosed an odd number of times; which way the
/// triangles face plays no part, and degenerate ones none either.
pub fn point_in_solid<X: Scalar>(point: Vec3<X>, surface: &[Triangle<X>]) -> Place {
    let precision = const { Precision::of_size(size_of::<X>()) };
    let point = point.map(X::to_f64);
    if !point.to_array().iter().all(|x| x.is_finite()) {
        return Place::Outside;
    }
    let mut crossings = 0_u64;
    for triangle in surface.iter().filter(|triangle| triangle.can_be_hit()) {
        let triangle = widened(triangle);
        if is_beside(point, &triangle) {
            continue;
        }
        if is_on(precision, point, &triangle) {
            return Place::On;
        }
        crossings += u64::from(crosses(precision, point, &triangle));
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
fn is_on(precision: Precision, point: Vec3<f64>, triangle: &Triangle<f64>) -> bool {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().any(|axis| {
        let still = Ray { o: point, d: axis.into(), tmin: 0.0, tmax: 0.0 };
        ladder::outcome(precision, &still, triangle, UNIT) != Outcome::Miss
    })
}

/// Whether the ray up from the point, moved by `ε` and `ε²`, crosses the triangle, which the point is
/// not on.
fn crosses(precision: Precision, point: Vec3<f64>, triangle: &Triangle<f64>) -> bool {
    let flat = |v: Vec3<f64>| [v.x, v.y];
    let [a, b, c] = triangle.corners().map(flat);
    let p = flat(point);
    if ladder::turn(precision, [a, b, c]) == Ordering::Equal {
        // Seen from its side, where the moved ray does not meet it.
        return false;
    }
    let turn = |from: [f64; 2], to: [f64; 2]| {
        // The turn towards (p.x + ε, p.y + ε²): the next power of ε decides where those before are zero.
        ladder::turn(precision, [from, to, p])
            .then_with(|| compare(from[1], to[1]))
            .then_with(|| compare(to[0], from[0]))
    };
    let turns = [turn(a, b), turn(b, c), turn(c, a)];
    if turns != [turns[0]; 3] {
        return false;
    }
    let up = Ray { o: point, d: Vec3::new(0.0, 0.0, 1.0), tmin: 0.0, tmax: 0.0 };
    ladder::sign_of_t(precision, &up, triangle) == Ordering::Greater
}

/// The order of two finite numbers, −0 being 0.
fn compare(a: f64, b: f64) -> Ordering {
    a.partial_cmp(&b).unwrap_or(Ordering::Equal)
}
