//! From where a scene is seen.

use glam::{Vec2, Vec3};

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The name that it is asked for by; may be empty.
    pub name: String,
    /// Where it is.
    pub eye: Vec3,
    /// To the right in the picture, of unit length.
    pub right: Vec3,
    /// Upwards in the picture, of unit length.
    pub up: Vec3,
    /// Where it looks, of unit length.
    pub forward: Vec3,
    /// How it makes its picture.
    pub lens: Lens,
}

/// How a camera makes its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// All rays go through one point.
    Pinhole {
        /// Angle between the picture's lower and upper edge, in radians, above 0 and below π.
        field_of_view: f32,
    },
    /// All rays are parallel.
    Orthographic {
        /// Height of what is seen, in the world's units, above 0.
        height: f32,
    },
    /// Rays go through all of a lens; what lies in one plane is sharp.
    Thin {
        /// As of a pinhole.
        field_of_view: f32,
        /// Radius of the lens, in the world's units, from 0.
        radius: f32,
        /// Distance of the sharp plane, above 0.
        focus: f32,
    },
}

impl Lens {
    /// Half the height of the picture at distance 1; of an orthographic camera, at all distances.
    pub fn half_height(self) -> f32 {
        match self {
            Self::Pinhole { field_of_view } | Self::Thin { field_of_view, .. } => {
                (field_of_view * 0.5).tan()
            }
            Self::Orthographic { height } => height * 0.5,
        }
    }
}

/// A vector of unit length; `None` where it has no direction. Of vectors that differ by a power of two
/// it is the same, however long they are.
pub(crate) fn unit(vector: Vec3) -> Option<Vec3> {
    (vector / power_of_two(vector)).try_normalize()
}

/// A vector's length, as exact wherever it is in the range of f32.
pub(crate) fn length(vector: Vec3) -> f32 {
    let power = power_of_two(vector);
    (vector / power).length() * power
}

/// The power of two that the largest part of a vector is 1 to 2 times; 1 where there is none.
pub(crate) fn power_of_two(vector: Vec3) -> f32 {
    let power = f32::from_bits(vector.abs().max_element().to_bits() & 0x7f80_0000);
    if power > 0.0 && power.is_finite() { power } else { 1.0 }
}

impl Camera {
    /// A camera at `eye` that looks at a point, with `up` upwards in the picture; `None` where they give
    /// no direction.
    pub fn looking(eye: Vec3, at: Vec3, up: Vec3, lens: Lens) -> Option<Self> {
        Self::towards(eye, unit(at - eye)?, up, lens)
    }

    /// The same with the direction in which it looks, of unit length.
    pub fn towards(eye: Vec3, forward: Vec3, up: Vec3, lens: Lens) -> Option<Self> {
        let right = unit(forward.cross(up))?;
        Some(Self { name: String::new(), eye, right, up: right.cross(forward), forward, lens })
    }

    /// The ray through a point of the picture: its origin, and its direction, not of unit length.
    ///
    /// `at` is (0, 0) in the middle, (±a, ±1) in the corners, where a is the picture's width in heights;
    /// `half_height` is [`Lens::half_height`], computed once. `on_lens` is a point of the unit disc,
    /// which a thin lens alone asks for.
    #[inline]
    pub fn ray(&self, at: Vec2, half_height: f32, on_lens: impl FnOnce() -> Vec2) -> (Vec3, Vec3) {
        let across = self.right * (at.x * half_height) + self.up * (at.y * half_height);
        match self.lens {
            Lens::Pinhole { .. } => (self.eye, self.forward + across),
            Lens::Orthographic { .. } => (self.eye + across, self.forward),
            Lens::Thin { radius, focus, .. } => {
                let on_lens = on_lens() * radius;
                let from = self.right * on_lens.x + self.up * on_lens.y;
                (self.eye + from, (self.forward + across) * focus - from)
            }
        }
    }
}

/// The rays of a camera through the pixels of a picture: those that the renderer traces.
#[derive(Clone, Debug)]
pub struct PixelRays {
    camera: Camera,
    size: [u32; 2],
    half_height: f32,
    /// Half the picture's size in half heights, and half heights a pixel.
    corner: Vec2,
    step: f32,
}

impl PixelRays {
    /// For a picture of so many pixels across and down, at least 1.
    pub fn new(camera: Camera, size: [u32; 2]) -> Self {
        let [width, height] = size.map(|x| x as f32);
        Self {
            half_height: camera.lens.half_height(),
            camera,
            size,
            corner: Vec2::new(-width / height, 1.0),
            step: 2.0 / height,
        }
    }

    /// The same with a lens of the same kind and angle, which the compiler may know more of.
    #[inline(always)]
    #[must_use]
    pub fn with_lens(&self, lens: Lens) -> Self {
        Self { camera: Camera { lens, ..self.camera.clone() }, ..*self }
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// [`Lens::half_height`].
    pub fn half_height(&self) -> f32 {
        self.half_height
    }

    /// The upper left corner of the picture, in half heights from its middle.
    pub fn corner(&self) -> Vec2 {
        self.corner
    }

    /// Half heights a pixel.
    pub fn step(&self) -> f32 {
        self.step
    }

    /// The ray through the middle of a pixel and of the lens: its origin, and its direction, of unit length.
    #[inline(always)]
    pub fn ray(&self, pixel: [u32; 2]) -> (Vec3, Vec3) {
        self.ray_at(pixel, Vec2::splat(0.5), || Vec2::ZERO)
    }

    /// The ray through a point of a pixel, from 0 to 1 across and down; `on_lens` as for [`Camera::ray`].
    #[inline(always)]
    pub fn ray_at(
        &self,
        [x, y]: [u32; 2],
        point: Vec2,
        on_lens: impl FnOnce() -> Vec2,
    ) -> (Vec3, Vec3) {
        let right_down = Vec2::new(x as f32, y as f32) + point;
        let at = self.corner + right_down * Vec2::new(self.step, -self.step);
        let (o, d) = self.camera.ray(at, self.half_height, on_lens);
        (o, d.normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EYE: Vec3 = Vec3::new(1.0, 2.0, 5.0);

    fn camera(lens: Lens) -> Camera {
        Camera::looking(EYE, Vec3::new(1.0, 2.0, 0.0), Vec3::Y, lens).expect("a direction")
    }

    #[test]
    fn a_pinhole_sees_its_angle() {
        let field_of_view = 60.0_f32.to_radians();
        let lens = Lens::Pinhole { field_of_view };
        let upper = camera(lens).ray(Vec2::new(0.0, 1.0), lens.half_height(), || Vec2::ZERO).1;
        let lower = camera(lens).ray(Vec2::new(0.0, -1.0), lens.half_height(), || Vec2::ZERO).1;
        assert!((upper.angle_between(lower) - field_of_view).abs() < 1e-6);
        assert!(upper.y > lower.y);
    }

    #[test]
    fn parallel_rays_are_as_far_apart_as_asked() {
        let lens = Lens::Orthographic { height: 3.0 };
        let ray = |y| camera(lens).ray(Vec2::new(0.0, y), lens.half_height(), || Vec2::ZERO);
        assert_eq!(ray(1.0).0 - ray(-1.0).0, Vec3::new(0.0, 3.0, 0.0));
        assert_eq!(ray(1.0).1, ray(-1.0).1);
    }

    #[test]
    fn all_rays_of_a_lens_meet_in_the_sharp_plane() {
        let lens = Lens::Thin { field_of_view: 1.0, radius: 0.2, focus: 4.0 };
        let at = Vec2::new(0.3, -0.4);
        let meet = |x, y| {
            let (o, d) = camera(lens).ray(at, lens.half_height(), || Vec2::new(x, y));
            // The plane lies four before the eye, at z = 1.
            o + d * ((1.0 - o.z) / d.z)
        };
        let sharp = meet(0.0, 0.0);
        for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.6, 0.8)] {
            assert!((meet(x, y) - sharp).length() < 1e-5);
        }
    }

    #[test]
    fn a_power_of_two_changes_no_direction() {
        let (vector, of_one) = (Vec3::new(0.3, -0.7, 0.1), unit(Vec3::new(0.3, -0.7, 0.1)));
        assert_eq!(of_one, vector.try_normalize());
        for exponent in [-120, -60, 40, 120] {
            let scale = 2.0_f32.powi(exponent);
            assert_eq!(
                (unit(vector * scale), length(vector * scale)),
                (of_one, length(vector) * scale)
            );
        }
        assert_eq!(unit(Vec3::ZERO), None);
    }

    #[test]
    fn no_direction_no_camera() {
        let lens = Lens::Pinhole { field_of_view: 1.0 };
        assert_eq!(Camera::looking(EYE, EYE, Vec3::Y, lens), None);
        assert_eq!(Camera::looking(EYE, EYE + Vec3::Y, Vec3::Y, lens), None);
    }
}
