//! Scenes of any size and place, brought to where numbers are about 1.

use glam::{Affine3A, DAffine3, DVec3, Vec3};
use trisect_core::Triangle;

use crate::camera::{Camera, Lens};
use crate::model::{Light, Plane, Scene, Sphere};

/// A scene as far away as this, in powers of two of its size, is moved to the origin.
const FAR: f32 = 16.0;

/// Where a scene is computed with: its points are moved by an origin, and all lengths divided by a power of
/// two. Neither rounds a corner of the scene. A scene that is larger by a power of two has a frame that
/// is, and so the very same numbers in it; and one far away has numbers that are as fine as near the origin.
///
/// ```
/// use trisect_scene::{Frame, Vec3};
///
/// let [low, high] = [Vec3::new(4094.0, 0.0, -3.0), Vec3::new(4098.0, 5.0, 2.0)];
/// let frame = Frame::around(low, high);
/// assert_eq!(frame, Frame { origin: Vec3::new(4096.0, 4.0, 0.0), exponent: 2 });
/// assert_eq!(frame.point(high), Vec3::new(0.5, 0.25, 0.5));
/// assert_eq!(Frame::around(low / 1024.0, high / 1024.0).point(high / 1024.0), frame.point(high));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The world's point that is zero in the frame.
    pub origin: Vec3,
    /// The world's lengths are 2 to this times those of the frame; −126 to 126.
    pub exponent: i32,
}

/// 2 to the power of a number from −126 to 127.
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits((127 + exponent).cast_unsigned() << 23)
}

/// The corners of the box around some points; `None` where there are none.
fn bounds(points: impl Iterator<Item = Vec3>) -> Option<[Vec3; 2]> {
    points.fold(None, |bounds, p| {
        let [low, high] = bounds.unwrap_or([p, p]);
        Some([low.min(p), high.max(p)])
    })
}

impl Frame {
    /// The world itself.
    pub const WORLD: Self = Self { origin: Vec3::ZERO, exponent: 0 };

    /// The frame of what lies between two corners, whose longest side is from 1 to 2 in it. Its origin is the
    /// world's unless that is many sizes away. The world itself where no finite number is not zero.
    pub fn around(low: Vec3, high: Vec3) -> Self {
        let longest = (high - low).max_element();
        let size = if longest > 0.0 { longest } else { low.abs().max(high.abs()).max_element() };
        if !(size > 0.0 && size.is_finite()) {
            return Self::WORLD;
        }
        let biased = (size.to_bits() >> 23).cast_signed();
        let exponent = (biased - 127).clamp(-126, 126);
        let unit = power_of_two(exponent);
        let middle = low * 0.5 + high * 0.5;
        let steps = middle / unit;
        let is_far = middle.abs().max_element() > FAR * unit && steps.is_finite();
        // A multiple of the unit: corners are multiples of something finer, and near it, so that their
        // differences from it are exact.
        let origin = if is_far { steps.round() * unit } else { Vec3::ZERO };
        Self { origin, exponent }
    }

    /// The frame of triangles.
    pub fn of_triangles(triangles: &[Triangle<f32>]) -> Self {
        let corners = triangles.iter().flat_map(|triangle| triangle.corners().map(Vec3::from));
        bounds(corners).map_or(Self::WORLD, |[low, high]| Self::around(low, high))
    }

    /// The frame of a scene's meshes in their places and its spheres; where it has neither, of its planes'
    /// points, cameras and lights. Where a camera looks from so makes no difference to what it sees.
    pub fn of(scene: &Scene) -> Self {
        let boxes: Vec<Option<[Vec3; 2]>> = scene
            .meshes
            .iter()
            .map(|mesh| bounds(mesh.triangles.iter().flat_map(|t| t.corners().map(Vec3::from))))
            .collect();
        let instances = scene.instances.iter().filter_map(|instance| {
            let [low, high] = boxes[instance.mesh]?;
            let corner = |i: usize| {
                let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
                instance.to_world.transform_point3(Vec3::new(pick(0), pick(1), pick(2)))
            };
            Some((0..8).map(corner).collect::<Vec<Vec3>>())
        });
        let spheres = scene
            .spheres
            .iter()
            .flat_map(|s| [s.center - Vec3::splat(s.radius), s.center + Vec3::splat(s.radius)]);
        let others = || {
            let planes = scene.planes.iter().map(|plane| plane.point);
            let lights = scene.lights.iter().filter_map(|light| match light {
                Light::Point { position, .. } | Light::Spot { position, .. } => Some(*position),
                Light::Directional { .. } => None,
            });
            bounds(planes.chain(scene.cameras.iter().map(|camera| camera.eye)).chain(lights))
        };
        let all = bounds(instances.flatten().chain(spheres)).or_else(others);
        all.map_or(Self::WORLD, |[low, high]| Self::around(low, high))
    }

    /// The world's length of 1 in the frame: a power of two.
    pub fn unit(self) -> f32 {
        power_of_two(self.exponent)
    }

    /// A point of the world, in the frame.
    #[inline]
    pub fn point(self, point: Vec3) -> Vec3 {
        (point - self.origin) * power_of_two(-self.exponent)
    }

    /// A length of the world, in the frame; may be infinite.
    #[inline]
    pub fn length(self, length: f32) -> f32 {
        length * power_of_two(-self.exponent)
    }

    /// A camera of the world, in the frame.
    #[must_use]
    pub fn camera(self, camera: &Camera) -> Camera {
        let lens = match camera.lens {
            Lens::Orthographic { height } => Lens::Orthographic { height: self.length(height) },
            Lens::Thin { field_of_view, radius, focus } => {
                let (radius, focus) = (self.length(radius), self.length(focus));
                Lens::Thin { field_of_view, radius, focus }
            }
            pinhole @ Lens::Pinhole { .. } => pinhole,
        };
        Camera { eye: self.point(camera.eye), lens, ..camera.clone() }
    }

    /// A light of the world, in the frame, where it brings as much to each surface.
    #[must_use]
    pub fn light(self, light: &Light) -> Light {
        // Twice, since the square may be out of range.
        let dimmed = |intensity: Vec3| {
            let factor = power_of_two(-self.exponent);
            intensity * factor * factor
        };
        match *light {
            Light::Point { position, intensity } => {
                Light::Point { position: self.point(position), intensity: dimmed(intensity) }
            }
            Light::Spot { position, direction, intensity, inner, outer } => {
                let (position, intensity) = (self.point(position), dimmed(intensity));
                Light::Spot { position, direction, intensity, inner, outer }
            }
            directional @ Light::Directional { .. } => directional,
        }
    }

    /// A sphere of the world, in the frame.
    #[must_use]
    pub fn sphere(self, sphere: &Sphere) -> Sphere {
        Sphere { center: self.point(sphere.center), radius: self.length(sphere.radius), ..*sphere }
    }

    /// A plane of the world, in the frame. Its texture repeats with the [`unit`](Frame::unit) of the world.
    #[must_use]
    pub fn plane(self, plane: &Plane) -> Plane {
        Plane { point: self.point(plane.point), ..*plane }
    }

    /// The transform of a mesh's own frame to this one, given that of the mesh to the world: computed in
    /// f64, since a mesh far from its origin may be carried back by its transform, and rounded once.
    #[must_use]
    pub fn transform(self, to_world: &Affine3A, of_mesh: Self) -> Affine3A {
        let DAffine3 { matrix3, translation } = to_world.as_daffine3();
        let origin = |frame: Self| frame.origin.as_dvec3();
        let scale = |exponent: i32| 2.0_f64.powi(exponent);
        let place: DVec3 = matrix3 * origin(of_mesh) + (translation - origin(self));
        DAffine3 {
            matrix3: matrix3 * scale(of_mesh.exponent - self.exponent),
            translation: place * scale(-self.exponent),
        }
        .as_affine3a()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_follows_what_it_is_around() {
        let [low, high] = [Vec3::new(-1.5, 0.0, 0.25), Vec3::new(2.0, 0.5, 7.0)];
        let frame = Frame::around(low, high);
        assert_eq!(frame, Frame { origin: Vec3::ZERO, exponent: 2 });
        for exponent in [-60, -14, 3, 40] {
            let scale = power_of_two(exponent);
            let scaled = Frame::around(low * scale, high * scale);
            assert_eq!(scaled.exponent, exponent + 2);
            assert_eq!(scaled.point(high * scale), frame.point(high));
            assert_eq!(scaled.unit(), frame.unit() * scale);
        }
        // Far away the differences are exact, and as large as near.
        for away in [Vec3::new(1e3, -4e3, 0.0), Vec3::new(0.0, 0.0, 8e6), Vec3::splat(-7e5)] {
            let far = Frame::around(low + away, high + away);
            assert!((far.origin - away).abs().max_element() <= 8.0, "{far:?}");
            for corner in [low, high] {
                let there = corner + away;
                assert_eq!(far.point(there) * far.unit() + far.origin, there);
                assert!(far.point(there).abs().max_element() <= 3.0);
            }
        }
    }

    #[test]
    fn what_has_no_size_has_a_frame() {
        let nothing = Vec3::ZERO;
        assert_eq!(Frame::around(nothing, nothing), Frame::WORLD);
        assert_eq!(Frame::around(Vec3::splat(f32::NAN), nothing), Frame::WORLD);
        assert_eq!(Frame::around(Vec3::NEG_INFINITY, nothing), Frame::WORLD);
        let point = Vec3::splat(24.0);
        assert_eq!(Frame::around(point, point), Frame { origin: Vec3::ZERO, exponent: 4 });
        let least = Vec3::splat(f32::from_bits(1));
        assert_eq!(Frame::around(nothing, least).exponent, -126);
        assert_eq!(Frame::around(-Vec3::splat(1e38), Vec3::splat(1e38)).exponent, 126);
        assert_eq!(Frame::of_triangles(&[]), Frame::WORLD);
    }

    #[test]
    fn a_transform_leads_from_frame_to_frame() {
        let turn = glam::Quat::from_rotation_y(0.3);
        let scale = Vec3::new(2.0, 0.5, 1.0);
        for away in [Vec3::ZERO, Vec3::new(1e6, 0.0, -2e5)] {
            let corners = [Vec3::ZERO, Vec3::new(3.0, 1.0, 2.0)].map(|corner| corner + away);
            let own = Frame::around(corners[0], corners[1]);
            // Back from afar.
            let place = Vec3::new(0.5, 1.0, -3.0) - turn * (scale * away);
            let to_world = Affine3A::from_scale_rotation_translation(scale, turn, place);
            let world = Frame { origin: Vec3::new(-4.0, 0.0, 0.0), exponent: 3 };
            let between = world.transform(&to_world, own);
            let exact = to_world.as_daffine3();
            for corner in corners {
                let found = between.transform_point3(own.point(corner)).as_dvec3();
                let expected = exact.transform_point3(corner.as_dvec3());
                let expected = (expected - world.origin.as_dvec3()) / 8.0;
                assert!((found - expected).length() < 1e-6, "{found} {expected}");
            }
        }
    }
}
