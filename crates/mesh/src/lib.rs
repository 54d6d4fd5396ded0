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
mod quote;
mod reading;
mod stl;
mod text;

pub use error::{MeshError, MeshProblem, Place};
pub use gltf::{
    GltfCamera, GltfDocument, GltfFile, GltfLight, GltfMaterial, GltfTexture, Matrix, Part,
    PlacedMesh,
};
pub use mesh::{Bounds, Mesh, MeshFormat};
pub use obj::{ObjCorner, ObjFile, ObjLine, ObjTriangle};
pub use quote::{cut, quoted};
pub use reading::{FileInMemory, Note, ReadOptions, ReadProblem, Reading};
pub use text::{lines, unquoted, without_comment};
