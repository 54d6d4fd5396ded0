//! The lines of the study of pictures.

use serde::{Deserialize, Serialize};

use crate::record::lines;

lines! {
    Frames = "frames",
    Picture = "picture",
}

/// What pictures are timed for: those of one series differ in one thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrameSeries {
    /// The picture that the speed is wanted of: 640 by 480, one sample, one light, depth 16.
    Goal,
    /// Sizes of pictures, each from low to very hard.
    Sizes,
    /// Threads.
    Threads,
    /// Samples of a pixel.
    Samples,
    /// Lights.
    Lights,
    /// How often a ray may be reflected.
    Depth,
    /// When triangles become a leaf.
    Leaves,
    /// Sizes of tiles.
    Tiles,
    /// From a serial scalar tracer that tests every triangle, one technique after another.
    Techniques,
}

/// The time of pictures of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    /// What it is compared with.
    pub series: FrameSeries,
    /// What sets it apart from others of its series.
    pub name: String,
    /// The scene's name.
    pub scene: String,
    /// Name of the method.
    pub method: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples of a pixel.
    pub samples: u32,
    /// How often a ray may be reflected.
    pub depth: u32,
    /// Lights.
    pub lights: usize,
    /// Threads that render.
    pub threads: usize,
    /// Pixels across and down of a tile.
    pub tile: u32,
    /// When triangles become a leaf: `cheapest`, or always up to `16` or `32`.
    pub leaves: String,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Rays of a picture, the same in every sample.
    pub rays: u64,
    /// Nanoseconds of each picture, in the order measured.
    pub samples_ns: Vec<u64>,
}

/// A picture to look at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Its name.
    pub name: String,
    /// What is to be seen.
    pub says: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// A PNG, in base64.
    pub png: String,
}
