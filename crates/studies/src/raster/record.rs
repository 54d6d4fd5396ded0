//! The lines of the study of the rasteriser.

use serde::{Deserialize, Serialize};

use crate::record::lines;

lines! {
    Seen = "raster-seen",
    Built = "raster-built",
}

/// What is compared with what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Series {
    /// What is seen at each pixel, cast or rasterised.
    Visibility,
    /// Edges against spans, and which back faces are left out, on one thread.
    Ways,
    /// The frame of Amiantov 2012, shaded, on one thread.
    Frame,
    /// The same frame with textures that lie on it in one way or another.
    Textures,
}

/// Pictures of one kind that were timed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// What it is compared with.
    pub series: Series,
    /// How what is seen was found, or shaded.
    pub way: String,
    /// What is seen.
    pub scene: String,
    /// Its triangles.
    pub triangles: usize,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Threads.
    pub threads: usize,
    /// Pixels at which anything is seen.
    pub covered: u64,
    /// Pixels that differ from what they are held to: the exact caster, or for a frame the texture that lies on
    /// the surface.
    pub different: Option<u64>,
    /// Pairs of a pixel and a triangle that exact arithmetic decided.
    pub judged: u64,
    /// Nanoseconds of each picture.
    pub samples_ns: Vec<u64>,
}

/// What has to be built before anything is cast.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Built {
    /// Of what.
    pub scene: String,
    /// Its triangles.
    pub triangles: usize,
    /// What is built: a tree, by its builder; refit; or blocks of triangles, for the rasteriser.
    pub what: String,
    /// Threads.
    pub threads: usize,
    /// Nanoseconds of each time.
    pub samples_ns: Vec<u64>,
}
