//! What stands in the way of a scene: each message says where, and what mends it.

use trisect_mesh::MeshError;
use trisect_method::UnsuitableMesh;
use trisect_tracer::RefitError;

/// A scene cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A face names a vertex that there is not.
    #[error("face {face} names vertex {vertex}, but there are {vertices}, numbered from 0")]
    NoVertex {
        /// The index of the face.
        face: usize,
        /// The index that it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A corner of a face is infinite or NaN. Vertices that no face names may be anything.
    #[error("vertex {vertex}, a corner of face {face}, is not finite: {position:?}")]
    NotFinite {
        /// The index of the face.
        face: usize,
        /// The index of the vertex.
        vertex: usize,
        /// Where it is.
        position: [f64; 3],
    },
    /// There are more faces than a scene can number.
    #[error("{faces} faces are more than a scene holds, {MOST}: divide it")]
    TooMany {
        /// How many there are.
        faces: usize,
    },
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] MeshError),
    /// The method cannot take the mesh.
    #[error(transparent)]
    Unsuitable(#[from] UnsuitableMesh),
}

/// A scene cannot be moved; it is as before.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UpdateError {
    /// There are more or fewer vertices than before.
    #[error("the scene was made of {made} vertices, and there are {given} now: make it anew")]
    Count {
        /// How many it was made of.
        made: usize,
        /// How many there are now.
        given: usize,
    },
    /// The scene is one of instances.
    #[error(
        "a scene of instances has no vertices of its own: move its instances, or make it anew of scenes that have moved"
    )]
    Instances,
    /// A corner of a face is infinite or NaN.
    #[error(transparent)]
    Vertices(#[from] SceneError),
    /// The tree cannot be fitted to them.
    #[error(transparent)]
    Refit(#[from] RefitError),
}

/// Faces of a scene at most: with space split, their blocks are fewer than a tree can number.
pub(crate) const MOST: usize = 1 << 27;
