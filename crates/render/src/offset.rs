//! Where rays start that leave a surface: so far off it that they do not meet it again, and no farther.
//!
//! A point that was computed to lie on a surface lies beside it, and so does what the test of the next ray
//! computes from it. All of that is bounded here, in units of roundoff `u` = 2⁻²⁴ of the numbers that were
//! computed with; nothing is absolute. A chain of `k` roundings is off by less than `(k + 1)·u` of what it
//! sums in magnitude. `N` is the surface's normal of unit length, `P` the point, and `N·|P|` stands for
//! `Σ |Nᵢ|·|Pᵢ|`: what is off along the surface does no harm.
//!
//! **A triangle**, in the frame of its tree, has a corner `A`, edges `E1` and `E2` whose largest coordinate is
//! `h`, and `n = E1 × E2`. Its normal and its plane's distance are computed in f64 and rounded once. As
//! `P` is in the triangle, no coordinate of `P − A` exceeds `h`.
//!
//! | what rounds | off by, along the normal |
//! | --- | --- |
//! | the normal, each coordinate once | `u·N·|P − A| ≤ 2u·h` |
//! | the plane's distance | `u·N·|A| ≤ u·N·|P| + 2u·h` |
//! | how far the hit is from the plane: a scalar product, a difference | `4u·N·|P|` |
//! | the hit brought onto the plane: a product, a difference | `2u·N·|P|` |
//! | `P` moved off it by the bound: a product, a sum | `2u·N·|P|` |
//! | the numerator of the next `t`, from corners: eight roundings of `(P − A)·n` | `9u·h·k` |
//! | the same from a stored plane: a scalar product, a difference, the plane | `7u·N·|P|` |
//!
//! where `k = Σ (|E1| × |E2|)ᵢ / |n|`, the vector product being over magnitudes: 1 for a right angle along
//! axes, and large for a needle. Together `16u·N·|P|`, [`OF_POINT`], and `13u·h·k`, which is rounded up
//! to [`OF_TRIANGLE`].
//!
//! **An instance.** Its map `x ↦ M·x + t` is off by `5u·(|M|·|x| + |t|)` in each coordinate, its inverse
//! too, one unit of each being the rounding of the matrix itself. The point comes to the world by
//! the one, and the next ray to the triangle by the other. A step of length `δ` along the normal in the world,
//! which is `M⁻ᵀ·N` over its length `q`, is one of `q·δ` along `N`. So what is off in the triangle's space
//! counts `1/q` times.
//!
//! **A sphere** of radius `r`: the next test computes `|P − C|² − r²` with six roundings of `r²`, which is
//! off by `3u·r` in length; `P` itself rounds along the way from `C`. **A plane** is like a stored one.
//!
//! **Rays that leave flatly** are not covered where their angle itself is a matter of rounding: their
//! share of light is as small.
//!
//! After M. Pharr, W. Jakob, G. Humphreys: Physically Based Rendering, fourth edition, section 6.8.

use glam::{Affine3A, DVec3, Vec3};
use trisect_core::Triangle;

/// The unit roundoff.
const ROUNDOFF: f32 = f32::EPSILON / 2.0;

/// Units of what has the coordinates of the point.
const OF_POINT: f32 = 16.0;

/// Units of the largest coordinate of an edge, times `k`.
const OF_TRIANGLE: f64 = 16.0;

/// Units of a sphere's radius.
const OF_RADIUS: f32 = 8.0;

/// Units of the point's largest coordinate, whatever the normal: enough to move it by a step of its own
/// precision along the largest coordinate of the normal, where nothing has rounded.
const LEAST: f32 = 4.0;

/// What a triangle alone takes.
#[allow(clippy::cast_possible_truncation, reason = "there is room in the bound for its rounding")]
pub(crate) fn of_triangle(triangle: &Triangle<f32>) -> f32 {
    let [a, b, c] = triangle.corners().map(|corner| Vec3::from(corner).as_dvec3());
    let (u, v) = (b - a, c - a);
    let (p, q) = (u.abs(), v.abs());
    let over_magnitudes =
        DVec3::new(p.y * q.z + p.z * q.y, p.z * q.x + p.x * q.z, p.x * q.y + p.y * q.x);
    let needle = over_magnitudes.element_sum() / u.cross(v).length();
    let units = OF_TRIANGLE * p.max(q).max_element() * needle;
    // Where it has no area nothing hits it.
    if units.is_finite() { ROUNDOFF * units as f32 } else { 0.0 }
}

/// What the coordinates of a point take, given their magnitudes or more.
#[inline]
pub(crate) fn of_point(normal: Vec3, reach: Vec3) -> f32 {
    ROUNDOFF * (OF_POINT * normal.abs().dot(reach) + LEAST * reach.max_element())
}

/// What a sphere takes besides its point.
#[inline]
pub(crate) fn of_radius(radius: f32) -> f32 {
    ROUNDOFF * OF_RADIUS * radius
}

/// The magnitudes that a map sums for a point, coordinate by coordinate.
#[inline]
pub(crate) fn reach(map: &Affine3A, point: Vec3) -> Vec3 {
    let (matrix, point) = (&map.matrix3, point.abs());
    let sum = matrix.x_axis.abs() * point.x
        + matrix.y_axis.abs() * point.y
        + matrix.z_axis.abs() * point.z
        + map.translation.abs();
    sum.into()
}
