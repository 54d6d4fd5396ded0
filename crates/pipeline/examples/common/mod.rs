//! What the demonstrations share: a camera, a tree, and pictures.
#![allow(dead_code, reason = "each demonstration asks for a part")]

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use anyhow::{Context, Result};
use glam::{Vec2, Vec3};
use trisect_core::{Ray, Triangle};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_pipeline::{Builder, Geometry};
use trisect_tracer::ErasedBvh;
use trisect_workloads::{Placement, Surface};

/// Triangles in a tree whose method is behind calls: it takes no time to compile.
pub(crate) fn mesh(triangles: Vec<Triangle<f32>>, builder: Builder) -> Geometry {
    Geometry::triangles(triangles, builder, |triangles, builder, leaves| {
        Ok(Box::new(ErasedBvh::build_with::<MollerTrumbore>(triangles, builder, leaves)?))
    })
    .unwrap_or_else(|error| unreachable!("Möller and Trumbore take every mesh: {error}"))
}

/// From where a picture is seen.
#[derive(Clone, Copy)]
pub(crate) struct Camera {
    pub(crate) eye: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    is_parallel: bool,
}

impl Camera {
    fn looking(eye: Vec3, at: Vec3, half: f32, is_parallel: bool) -> Self {
        let forward = (at - eye).normalize();
        let right = forward.any_orthonormal_vector();
        let right = forward.cross(Vec3::Y).try_normalize().unwrap_or(right);
        let up = right.cross(forward);
        Self { eye, right: right * half, up: up * half, forward, is_parallel }
    }

    /// All rays go through one point; the angle is that between the lower and the upper edge.
    pub(crate) fn pinhole(eye: Vec3, at: Vec3, degrees: f32) -> Self {
        Self::looking(eye, at, (degrees.to_radians() * 0.5).tan(), false)
    }

    /// All rays are parallel; what is seen is so high.
    pub(crate) fn orthographic(eye: Vec3, at: Vec3, height: f32) -> Self {
        Self::looking(eye, at, height * 0.5, true)
    }

    /// The ray through a point of a picture, in pixels from its upper left corner; its direction has unit length.
    pub(crate) fn ray(&self, point: Vec2, [width, height]: [u32; 2]) -> Ray<f32> {
        let [width, height] = [width, height].map(|side| side as f32);
        let at = Vec2::new(2.0 * point.x - width, height - 2.0 * point.y) / height;
        let across = self.right * at.x + self.up * at.y;
        if self.is_parallel {
            Ray::new(self.eye + across, self.forward)
        } else {
            Ray::new(self.eye, (self.forward + across).normalize())
        }
    }
}

/// A ray that ends at a distance; its direction has unit length.
pub(crate) fn ray_to(from: Vec3, direction: Vec3, distance: f32) -> Ray<f32> {
    Ray::new(from, direction).with_interval(0.0, distance)
}

/// Writes a picture for the eye, as PNG; linear light from 0 to 1.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
pub(crate) fn write(path: &Path, [width, height]: [u32; 2], pixels: &[Vec3]) -> Result<()> {
    let of = |color: &Vec3| color.clamp(Vec3::ZERO, Vec3::ONE).powf(1.0 / 2.2).to_array();
    let bytes: Vec<u8> =
        pixels.iter().flat_map(|color| of(color).map(|x| (x * 255.0 + 0.5) as u8)).collect();
    let naming = || path.display().to_string();
    let file = BufWriter::new(File::create(path).with_context(naming)?);
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().with_context(naming)?;
    writer.write_image_data(&bytes).with_context(naming)?;
    writer.finish().with_context(naming)
}

/// A square of two triangles in the plane of y, from −half to half.
pub(crate) fn ground(y: f32, half: f32) -> Vec<Triangle<f32>> {
    let corner = |x: f32, z: f32| Vec3::new(x * half, y, z * half);
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    vec![Triangle::new(a, b, c), Triangle::new(a, c, d)]
}

/// A ball of radius 1.
pub(crate) fn ball(subdivisions: u32) -> Vec<Triangle<f32>> {
    // The surface has a radius of 2.
    let half = Placement { scale: 0.5, ..Placement::HERE };
    Surface::sphere(subdivisions).triangles(&half)
}

/// Runs something on so many threads.
pub(crate) fn on_threads<X: Send>(threads: usize, job: impl FnOnce() -> X + Send) -> X {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(job),
        Err(error) => unreachable!("a few threads can be had: {error}"),
    }
}
