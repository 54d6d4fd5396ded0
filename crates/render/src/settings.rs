//! What is asked of a picture, beside the scene.

use trisect_tracer::Tracing;

use crate::sampling::Sampling;

/// How a picture is made. The same scene and settings give the same picture to the bit, whatever the
/// number of threads and the size of tiles, where `tracing` is [`Tracing::Single`] or [`Tracing::Plain`].
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Pixels across and down, at least 1.
    pub size: [u32; 2],
    /// Which of the scene's cameras.
    pub camera: usize,
    /// Which points of a pixel are sampled; where paths are traced, their number alone counts.
    pub sampling: Sampling,
    /// How light is followed.
    pub mode: Mode,
    /// How often a ray may be reflected or refracted; 0 shows what the camera sees directly.
    pub depth: u32,
    /// Rays that can add no more than this to any colour of a sample are not followed, and neither are
    /// lights. From 0.
    pub cutoff: f32,
    /// So many of the scene's lights, the first ones.
    pub lights: usize,
    /// Seed of every random choice.
    pub seed: u32,
    /// Pixels across and down of what one thread takes at a time, at least 1.
    pub tile: u32,
    /// How the tracer goes through its trees.
    pub tracing: Tracing,
}

/// How light is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Whitted 1980: from the eye through mirrors and glass, and from each point to the lights; all other
    /// light is the scene's ambient.
    Whitted {
        /// What share of the ambient light reaches a point; all where this is none.
        occlusion: Option<Occlusion>,
    },
    /// Kajiya 1986: each sample follows one random path, on which light may be scattered any number of
    /// times up to the depth. The mean of many is the picture.
    Paths,
}

/// How the share of ambient light that reaches a point is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occlusion {
    /// Rays from each point, at least 1.
    pub rays: u32,
    /// What is farther away, in the world's units, shuts nothing out; may be infinite.
    pub distance: f32,
}

impl Settings {
    /// One sample a pixel, after Whitted, up to 16 reflections or refractions, all lights.
    pub fn new(size: [u32; 2]) -> Self {
        Self {
            size,
            camera: 0,
            sampling: Sampling::ONE,
            mode: Mode::Whitted { occlusion: None },
            depth: 16,
            cutoff: 1.0 / 1024.0,
            lights: usize::MAX,
            seed: 1,
            tile: 64,
            tracing: Tracing::Single,
        }
    }
}
