//! The classes of rays that a tracer is measured with.

use std::fmt;

use trisect_core::Ray;

use crate::generate::{
    Closest, Light, Workload, diffuse_bounce, occlusion, primary, random_through_box,
};
use trisect_mesh::Mesh;

/// Rays of one kind through a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayClass {
    /// See [`primary`]; tile by tile, as renderers trace them.
    Primary,
    /// See [`random_through_box`].
    Random,
    /// See [`diffuse_bounce`].
    Diffuse,
    /// See [`occlusion`], with the light of [`Light::above`].
    Occlusion,
}

impl RayClass {
    /// All classes.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Random, Self::Diffuse, Self::Occlusion];

    /// The name in records and commands.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Random => "random",
            Self::Diffuse => "diffuse",
            Self::Occlusion => "occlusion",
        }
    }

    /// A few words on what the rays are.
    pub const fn says(self) -> &'static str {
        match self {
            Self::Primary => "From a camera",
            Self::Random => "Through two points of the box around the mesh",
            Self::Diffuse => "Bounces from what the camera sees",
            Self::Occlusion => "From what the camera sees to a light; any hit is asked for",
        }
    }

    /// Whether any hit will do instead of the closest.
    pub const fn any_hit(self) -> bool {
        matches!(self, Self::Occlusion)
    }

    /// The rays of a picture whose sides have so many pixels, or as many; none of those from what the
    /// camera sees where it sees nothing.
    pub fn rays(
        self,
        seed: u64,
        mesh: &Mesh,
        pixels: usize,
        closest: Closest<'_>,
    ) -> Vec<Ray<f32>> {
        let Workload { rays, .. } = match self {
            Self::Primary => return in_tiles(&primary(mesh, pixels, pixels).rays, pixels),
            Self::Random => random_through_box(seed, mesh, pixels * pixels),
            Self::Diffuse => diffuse_bounce(seed, mesh, pixels, pixels, closest),
            Self::Occlusion => {
                occlusion(seed, mesh, &Light::above(&mesh.bounds), pixels, pixels, closest)
            }
        };
        rays
    }
}

/// The rays of a picture of square sides, which come row by row, in tiles of 8 × 8 pixels, and those in
/// four of 4 × 4, so that eight, sixteen or sixty-four in a row are near each other.
fn in_tiles(rays: &[Ray<f32>], pixels: usize) -> Vec<Ray<f32>> {
    let mut places: Vec<[usize; 2]> =
        (0..pixels).flat_map(|y| (0..pixels).map(move |x| [x, y])).collect();
    places.sort_by_key(|&[x, y]| [y / 8, x / 8, y / 4, x / 4, y, x]);
    places.into_iter().map(|[x, y]| rays[y * pixels + x]).collect()
}

impl fmt::Display for RayClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
