//! Spheres, thin shells, parallelograms and discs.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use trisect_core::{Hit, Ray};

use crate::leaves::Leaves;
use crate::primitive::Primitive;

/// A sphere. Its front is outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The middle.
    pub center: Vec3,
    /// The radius, above 0.
    pub radius: f32,
}

/// A thin shell: what is between two spheres about one point, as of a hollow ball of glass. Its front is outside of
/// that: also towards the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    /// The middle.
    pub center: Vec3,
    /// The radius of the inner sphere, above 0.
    pub inner: f32,
    /// The radius of the outer one, above that.
    pub outer: f32,
}

/// Which side of a shell was hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShellSide {
    /// The inner sphere.
    Inner,
    /// The outer one.
    Outer,
}

/// The points `corner + a·u + b·v` with a and b from 0 to 1. Its front is where `u × v` points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallelogram {
    /// A corner.
    pub corner: Vec3,
    /// From there to the next one.
    pub u: Vec3,
    /// And to the one on the other side.
    pub v: Vec3,
}

/// A disc. Its front is where the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// The middle.
    pub center: Vec3,
    /// Of unit length.
    pub normal: Vec3,
    /// The radius, above 0.
    pub radius: f32,
}

/// Where the line of a ray, whose direction has any length, enters and leaves a sphere.
///
/// Haines, Günther, Akenine-Möller: Precision Improvements for Ray/Sphere Intersection. Ray Tracing Gems,
/// chapter 7, 2019.
#[inline]
fn cross_sphere(center: Vec3, radius: f32, ray: &Ray<f32>) -> Option<[f32; 2]> {
    let (from, d) = (Vec3::from(ray.o) - center, Vec3::from(ray.d));
    let (a, b) = (d.length_squared(), -from.dot(d));
    let squared = radius * radius;
    let discriminant = squared - (from + d * (b / a)).length_squared();
    if discriminant.is_nan() || discriminant < 0.0 {
        return None;
    }
    let q = b + (a * discriminant).sqrt().copysign(b);
    let (other, far) = ((from.length_squared() - squared) / q, q / a);
    Some(if b > 0.0 { [other, far] } else { [far, other] })
}

/// Where a ray meets a plane, by its distance along the ray; NaN or infinite where it does not.
#[inline]
fn cross_plane(point: Vec3, normal: Vec3, ray: &Ray<f32>) -> f32 {
    (point - Vec3::from(ray.o)).dot(normal) / Vec3::from(ray.d).dot(normal)
}

/// Where a ray is at a hit.
#[inline]
fn at(ray: &Ray<f32>, t: f32) -> Vec3 {
    Vec3::from(ray.o) + Vec3::from(ray.d) * t
}

impl Primitive for Sphere {
    type Shape = Self;
    /// The share of the way around y, and of that down from the pole.
    type Attributes = Vec2;
    type Tree = Leaves<Self>;

    fn bounds(shape: &Self) -> [Vec3; 2] {
        [shape.center - shape.radius, shape.center + shape.radius]
    }

    #[inline]
    fn cross(shape: &Self, ray: &Ray<f32>, report: &mut dyn FnMut(Hit<f32>)) {
        for t in cross_sphere(shape.center, shape.radius, ray).into_iter().flatten() {
            report(Hit { t, beta: 0.0, gamma: 0.0 });
        }
    }

    #[inline]
    fn normal(shape: &Self, ray: &Ray<f32>, hit: &Hit<f32>) -> Vec3 {
        at(ray, hit.t) - shape.center
    }

    fn attributes(shape: &Self, ray: &Ray<f32>, hit: &Hit<f32>) -> Vec2 {
        let out = Self::normal(shape, ray, hit).normalize_or_zero();
        Vec2::new(out.z.atan2(out.x) / TAU + 0.5, out.y.clamp(-1.0, 1.0).acos() / PI)
    }
}

impl Primitive for Shell {
    type Shape = Self;
    type Attributes = ShellSide;
    type Tree = Leaves<Self>;

    fn bounds(shape: &Self) -> [Vec3; 2] {
        [shape.center - shape.outer, shape.center + shape.outer]
    }

    #[inline]
    fn cross(shape: &Self, ray: &Ray<f32>, report: &mut dyn FnMut(Hit<f32>)) {
        for (radius, beta) in [(shape.outer, 0.0), (shape.inner, 1.0)] {
            for t in cross_sphere(shape.center, radius, ray).into_iter().flatten() {
                report(Hit { t, beta, gamma: 0.0 });
            }
        }
    }

    #[inline]
    fn normal(shape: &Self, ray: &Ray<f32>, hit: &Hit<f32>) -> Vec3 {
        let away = at(ray, hit.t) - shape.center;
        if hit.beta == 0.0 { away } else { -away }
    }

    fn attributes(_: &Self, _: &Ray<f32>, hit: &Hit<f32>) -> ShellSide {
        if hit.beta == 0.0 { ShellSide::Outer } else { ShellSide::Inner }
    }
}

impl Primitive for Parallelogram {
    type Shape = Self;
    /// Of u and of v.
    type Attributes = Vec2;
    type Tree = Leaves<Self>;

    fn bounds(shape: &Self) -> [Vec3; 2] {
        let Self { corner, u, v } = *shape;
        let corners = [corner, corner + u, corner + v, corner + u + v];
        corners.into_iter().fold([corner; 2], |[low, high], p| [low.min(p), high.max(p)])
    }

    #[inline]
    fn cross(shape: &Self, ray: &Ray<f32>, report: &mut dyn FnMut(Hit<f32>)) {
        let Self { corner, u, v } = *shape;
        let normal = u.cross(v);
        let t = cross_plane(corner, normal, ray);
        let from = at(ray, t) - corner;
        let scale = 1.0 / normal.length_squared();
        let (beta, gamma) = (from.cross(v).dot(normal) * scale, u.cross(from).dot(normal) * scale);
        if (0.0..=1.0).contains(&beta) && (0.0..=1.0).contains(&gamma) {
            report(Hit { t, beta, gamma });
        }
    }

    #[inline]
    fn normal(shape: &Self, _: &Ray<f32>, _: &Hit<f32>) -> Vec3 {
        shape.u.cross(shape.v)
    }

    fn attributes(_: &Self, _: &Ray<f32>, hit: &Hit<f32>) -> Vec2 {
        Vec2::new(hit.beta, hit.gamma)
    }
}

impl Primitive for Disc {
    type Shape = Self;
    /// How far from the middle, in radii.
    type Attributes = f32;
    type Tree = Leaves<Self>;

    fn bounds(shape: &Self) -> [Vec3; 2] {
        // How far a circle reaches along an axis: the sine of the angle between that and its normal.
        let reach = shape.normal.map(|n| (1.0 - n * n).max(0.0).sqrt()) * shape.radius;
        [shape.center - reach, shape.center + reach]
    }

    #[inline]
    fn cross(shape: &Self, ray: &Ray<f32>, report: &mut dyn FnMut(Hit<f32>)) {
        let t = cross_plane(shape.center, shape.normal, ray);
        let away = (at(ray, t) - shape.center).length() / shape.radius;
        if away <= 1.0 {
            report(Hit { t, beta: away, gamma: 0.0 });
        }
    }

    #[inline]
    fn normal(shape: &Self, _: &Ray<f32>, _: &Hit<f32>) -> Vec3 {
        shape.normal
    }

    fn attributes(_: &Self, _: &Ray<f32>, hit: &Hit<f32>) -> f32 {
        hit.beta
    }
}
