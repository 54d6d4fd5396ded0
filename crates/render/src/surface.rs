//! Where a ray meets something, and what is there.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use trisect_core::Ray;
use trisect_scene::{Color, Material, Plane, Sphere};
use trisect_tracer::TriangleHit;

use crate::needs::Needs;
use crate::offset;
use crate::stage::Stage;

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    /// One of the next.
    what: u32,
    /// Of the triangle, among those of all instances, or of the sphere or plane.
    number: u32,
}

impl Target {
    const NOTHING: u32 = u32::MAX;
    const SPHERE: u32 = u32::MAX - 1;
    const PLANE: u32 = u32::MAX - 2;
    const TRIANGLE: u32 = 0;
    pub(crate) const NONE: Self = Self { what: Self::NOTHING, number: 0 };

    pub(crate) fn sphere(number: u32) -> Self {
        Self { what: Self::SPHERE, number }
    }

    pub(crate) fn plane(number: u32) -> Self {
        Self { what: Self::PLANE, number }
    }

    #[inline]
    pub(crate) fn triangle(found: &TriangleHit) -> Self {
        Self { what: Self::TRIANGLE, number: found.triangle }
    }

    #[inline]
    pub(crate) fn is_something(self) -> bool {
        self.what != Self::NOTHING
    }
}

/// What shading asks of a point.
pub(crate) struct Surface<'a> {
    position: Vec3,
    /// How far off the surface rays [start](Surface::start).
    offset: f32,
    /// Of unit length, on the side that the ray comes from; interpolated where the surface is smooth.
    pub(crate) normal: Vec3,
    /// The same of the surface as it is.
    pub(crate) true_normal: Vec3,
    /// Whether the ray comes from the front: from outside, where the surface is closed.
    pub(crate) from_front: bool,
    pub(crate) material: &'a Material,
    /// The material's, times its texture.
    pub(crate) diffuse: Color,
    /// Whether the material answers lights, where there may be any.
    pub(crate) is_lit: bool,
}

impl Stage {
    /// What is where a ray's interval ends, at its target.
    #[inline(always)]
    pub(crate) fn surface<N: Needs>(&self, ray: &Ray<f32>, target: Target) -> Surface<'_> {
        let direction = Vec3::from(ray.d);
        let mut position = Vec3::from(ray.o) + direction * ray.tmax;
        let mut number = target.number as usize;
        let (material, front, mut normal, offset);
        let mut inside = None;
        match target.what {
            // Onto the surface in each case, as far as rounding allows: the way from the camera may be long.
            Target::SPHERE if N::SHAPES => {
                let sphere = &self.spheres[number];
                material = sphere.material;
                front = (position - sphere.center).normalize();
                position = sphere.center + front * sphere.radius;
                normal = front;
                offset = offset::of_point(front, position.abs()) + offset::of_radius(sphere.radius);
            }
            Target::PLANE if N::SHAPES => {
                let plane = &self.planes[number];
                material = plane.material;
                front = plane.normal;
                position -= front * (position - plane.point).dot(front);
                normal = front;
                offset = offset::of_point(front, position.abs() + plane.point.abs());
            }
            _ => {
                // Without shapes there is one tree, in the world.
                let (at, own) =
                    if N::SHAPES { self.all.locate(target.number) } else { (0, target.number) };
                let instance = &self.all.instances()[at];
                let group = &**instance.of();
                number = own as usize;
                let facet = &group.facets[number];
                material = group.materials[number] as usize;
                let transform = instance.transform();
                let carried = (N::SHAPES && !transform.is_identity()).then_some(transform);
                let mut own = match carried {
                    Some(carried) => carried.to_object().transform_point3(position),
                    None => position,
                };
                own -= facet.normal * (own.dot(facet.normal) - facet.distance);
                let mut of_facet = facet.normal;
                normal = of_facet;
                if N::VARYING && !group.weights.is_empty() {
                    let weights = group.weights[number].at(own);
                    inside = Some((group, weights));
                    if !group.normals.is_empty() {
                        normal = group.normals[number].at(weights);
                    }
                }
                position = own;
                match carried {
                    None => offset = facet.offset + offset::of_point(of_facet, own.abs()),
                    Some(carried) => {
                        let (to_world, to_object) = (carried.to_world(), carried.to_object());
                        let normals = to_object.matrix3.transpose();
                        position = to_world.transform_point3(own);
                        let back = offset::reach(to_object, position);
                        let in_object = facet.offset + offset::of_point(of_facet, own.abs() + back);
                        of_facet = (normals * glam::Vec3A::from(of_facet)).into();
                        let longer = of_facet.length();
                        of_facet = of_facet.normalize_or_zero();
                        normal = (normals * glam::Vec3A::from(normal)).into();
                        let there = offset::reach(to_world, own);
                        offset = in_object / longer + offset::of_point(of_facet, there);
                    }
                }
                normal = normal.normalize_or(of_facet);
                front = of_facet;
            }
        }
        let described = &self.scene.materials[material];
        let mut diffuse = described.diffuse;
        if let Some(texture) = described.texture.filter(|_| N::VARYING) {
            let at = match (target.what, inside) {
                (Target::SPHERE, _) => around(front),
                (Target::PLANE, _) => {
                    let from = position - self.planes[number].point;
                    let [right, down] = self.plane_axes[number];
                    Vec2::new(from.dot(right), from.dot(down))
                }
                (_, Some((group, weights))) if !group.coordinates.is_empty() => {
                    group.coordinates[number].at(weights)
                }
                _ => Vec2::ZERO,
            };
            diffuse *= self.scene.textures[texture].at(at);
        }
        let from_front = front.dot(direction) <= 0.0;
        let true_normal = if from_front { front } else { -front };
        // An interpolated normal may look away from the ray at the rim.
        if normal.dot(true_normal) < 0.0 {
            normal = -normal;
        }
        Surface {
            position,
            offset,
            normal,
            true_normal,
            from_front,
            material: described,
            diffuse,
            is_lit: N::SHADOWS && self.lit[material],
        }
    }
}

impl Surface<'_> {
    /// Where rays start that leave on the side that the ray came from (`1.0`), or the other (`-1.0`).
    #[inline]
    pub(crate) fn start(&self, side: f32) -> Vec3 {
        self.position + self.true_normal * (self.offset * side)
    }
}

/// Where the line of a ray of unit direction enters and leaves a sphere.
///
/// Haines, Günther, Akenine-Möller: Precision Improvements for Ray/Sphere Intersection. Ray Tracing Gems,
/// chapter 7, 2019.
#[inline]
fn cross_sphere(sphere: &Sphere, o: Vec3, d: Vec3) -> Option<[f32; 2]> {
    let from = o - sphere.center;
    let b = -from.dot(d);
    let squared = sphere.radius * sphere.radius;
    let nearest = from + d * b;
    let discriminant = squared - nearest.length_squared();
    if discriminant.is_nan() || discriminant < 0.0 {
        return None;
    }
    let q = b + discriminant.sqrt().copysign(b);
    let other = (from.length_squared() - squared) / q;
    Some(if b > 0.0 { [other, q] } else { [q, other] })
}

/// Where a ray of unit direction meets a sphere within an interval; infinite where it does not.
#[inline]
pub(crate) fn meet_sphere(sphere: &Sphere, o: Vec3, d: Vec3, tmax: f32) -> f32 {
    let Some([first, last]) = cross_sphere(sphere, o, d) else { return f32::INFINITY };
    let t = if first > 0.0 { first } else { last };
    if t > 0.0 && t < tmax { t } else { f32::INFINITY }
}

/// How often a ray of unit direction goes through a sphere's surface within an interval.
pub(crate) fn crossings(sphere: &Sphere, o: Vec3, d: Vec3, tmax: f32) -> usize {
    let ends = cross_sphere(sphere, o, d);
    ends.into_iter().flatten().filter(|&t| t > 0.0 && t < tmax).count()
}

/// Where a ray meets a plane within an interval; infinite where it does not.
#[inline]
pub(crate) fn meet_plane(plane: &Plane, o: Vec3, d: Vec3, tmax: f32) -> f32 {
    let t = (plane.point - o).dot(plane.normal) / d.dot(plane.normal);
    if t > 0.0 && t < tmax { t } else { f32::INFINITY }
}

/// Coordinates on a sphere: the share of the way around y, and down from the pole.
fn around(normal: Vec3) -> Vec2 {
    let u = normal.z.atan2(normal.x) * (0.5 / PI) + 0.5;
    Vec2::new(u, normal.y.clamp(-1.0, 1.0).acos() / PI)
}

/// Light that comes back from a mirror, given the ray's direction and the normal towards its origin.
#[inline]
pub(crate) fn reflected(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// Glass: the share of light that is reflected, and the direction of the rest, if there is any.
///
/// `ratio` is the index of refraction where the ray comes from, over that where it goes.
pub(crate) fn refracted(direction: Vec3, normal: Vec3, ratio: f32) -> (f32, Option<Vec3>) {
    let cosine = (-direction.dot(normal)).clamp(0.0, 1.0);
    // Snell's law; above 1 all is reflected.
    let squared = ratio * ratio * (1.0 - cosine * cosine);
    if squared >= 1.0 {
        return (1.0, None);
    }
    let behind = (1.0 - squared).sqrt();
    // Fresnel's equations, the mean of both polarisations.
    let across = (ratio * cosine - behind) / (ratio * cosine + behind);
    let within = (cosine - ratio * behind) / (cosine + ratio * behind);
    let share = 0.5 * (across * across + within * within);
    (share, Some((direction * ratio + normal * (ratio * cosine - behind)).normalize()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_obeys_snell() {
        let ratio = 1.0 / 1.5;
        for degrees in [0.0_f32, 10.0, 45.0, 80.0, 89.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (share, direction) = refracted(Vec3::new(sin, -cos, 0.0), Vec3::Y, ratio);
            let direction = direction.expect("into the denser there is always a way");
            assert!((direction.x - sin * ratio).abs() < 1e-6, "{degrees}: {direction}");
            assert!(direction.y < 0.0 && (0.0..=1.0).contains(&share));
        }
    }

    #[test]
    fn fresnel_is_that_of_the_books() {
        // ((n − 1) / (n + 1))² head on.
        assert!((refracted(Vec3::NEG_Y, Vec3::Y, 1.0 / 1.5).0 - 0.04).abs() < 1e-6);
        // At Brewster's angle one polarisation is not reflected at all; half the other's 14.8 % is.
        let angle = 1.5_f32.atan();
        let direction = Vec3::new(angle.sin(), -angle.cos(), 0.0);
        let across = ((1.0 - 2.25) / (1.0 + 2.25_f32)).powi(2);
        assert!((refracted(direction, Vec3::Y, 1.0 / 1.5).0 - across / 2.0).abs() < 1e-6);
    }

    #[test]
    fn beyond_the_critical_angle_all_is_reflected() {
        let critical = (1.0_f32 / 1.5).asin();
        let at = |angle: f32| refracted(Vec3::new(angle.sin(), -angle.cos(), 0.0), Vec3::Y, 1.5);
        assert!(at(critical - 1e-3).1.is_some());
        assert_eq!(at(critical + 1e-3), (1.0, None));
    }

    #[test]
    fn spheres_are_met_from_outside_and_inside() {
        let sphere = Sphere { center: Vec3::new(0.0, 0.0, -5.0), radius: 2.0, material: 0 };
        let meet = |o, tmax| meet_sphere(&sphere, o, Vec3::NEG_Z, tmax);
        assert_eq!(meet(Vec3::ZERO, f32::INFINITY), 3.0);
        assert_eq!(meet(Vec3::ZERO, 2.5), f32::INFINITY);
        assert_eq!(meet(sphere.center, f32::INFINITY), 2.0);
        assert_eq!(meet(Vec3::new(0.0, 0.0, -8.0), f32::INFINITY), f32::INFINITY);
        assert_eq!(meet(Vec3::new(2.1, 0.0, 0.0), f32::INFINITY), f32::INFINITY);
        let count = |o, tmax| crossings(&sphere, o, Vec3::NEG_Z, tmax);
        assert_eq!([2.5, 3.5, 7.5].map(|tmax| count(Vec3::ZERO, tmax)), [0, 1, 2]);
        assert_eq!(count(sphere.center, f32::INFINITY), 1);
        assert_eq!(count(Vec3::new(2.1, 0.0, 0.0), f32::INFINITY), 0);
    }
}
