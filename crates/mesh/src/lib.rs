#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod error;
mod faces;
mod gltf;
mod mesh;
mod obj;
mod ply;
mod ply_header;
mod polygon;
mod reading;
mod stl;
mod text;

pub use error::{MeshError, MeshProblem, Place};
pub use gltf::{GltfFile, Matrix, PlacedNode};
pub use mesh::{Bounds, Mesh, MeshFormat};
pub use obj::{ObjCorner, ObjFile, ObjLine, ObjTriangle};
pub use reading::{Note, ReadOptions, ReadProblem, Reading};
pub use text::{lines, unquoted, without_comment};
