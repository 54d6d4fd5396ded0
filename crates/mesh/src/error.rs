//! What is wrong with a mesh file.

use std::fmt;

use crate::reading::ReadProblem;

/// What is wrong with a mesh file, and with which.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {problem}")]
pub struct MeshError {
    /// The file as it was named by the caller.
    pub file: String,
    /// What is wrong, where, and what mends it. Not a `source`: the message holds it already.
    pub problem: MeshProblem,
}

/// An element of a mesh file: its number counts from 0, its line (in text formats) from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The number of the vertex or face.
    pub number: usize,
    /// The line of the file, where the format has lines.
    pub line: Option<usize>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.number)?;
        self.line.map_or(Ok(()), |line| write!(f, " (line {line})"))
    }
}

/// What is wrong with a mesh file. The text of each says where, and what mends it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshProblem {
    /// The file, or something in it, is not read.
    #[error("{0}")]
    Unread(#[from] ReadProblem),
    /// The ending of the file's name is not known.
    #[error("unknown file type; known are .ply, .obj, .stl, .gltf and .glb")]
    UnknownType,
    /// The file breaks the rules of its format.
    #[error("{place}: {what}; re-export the mesh")]
    Malformed {
        /// The line, header or element.
        place: String,
        /// What is wrong there.
        what: String,
    },
    /// The file ends before all that it promises.
    #[error("truncated: {what}; copy or export the file again")]
    Truncated {
        /// What is missing.
        what: String,
    },
    /// The file goes on after all that it promises.
    #[error("{what} after the last element; re-export the mesh")]
    Trailing {
        /// What stands there.
        what: String,
    },
    /// The file lacks something that every mesh needs.
    #[error("no {what}; re-export the mesh with it")]
    Missing {
        /// The element, property or buffer.
        what: String,
    },
    /// The file uses a part of its format that is not read.
    #[error("{what} not supported; {mend}")]
    Unsupported {
        /// The feature, with its verb.
        what: String,
        /// What to do instead.
        mend: &'static str,
    },
    /// A face that must be a triangle has fewer corners.
    #[error("face {face} has {corners} corners; export the mesh again")]
    TooFewCorners {
        /// The face.
        face: Place,
        /// How many corners it has.
        corners: usize,
    },
    /// A face names a vertex that does not exist.
    #[error(
        "face {face}: index {index} is out of range, the mesh has {vertices} vertices; re-export \
         the mesh"
    )]
    IndexOutOfRange {
        /// The face.
        face: Place,
        /// The index as the file writes it.
        index: i64,
        /// How many vertices the mesh has.
        vertices: usize,
    },
    /// A coordinate of a face is NaN, infinite, or beyond the range of f32.
    #[error(
        "face {face}: vertex {vertex}: {axis} is {value:?}; every coordinate must be a finite f32"
    )]
    NotFinite {
        /// The face.
        face: Place,
        /// The vertex.
        vertex: Place,
        /// Which coordinate.
        axis: char,
        /// Its value.
        value: f64,
    },
    /// The file has no face.
    #[error("the mesh has no triangles; export it with its faces")]
    Empty,
}
