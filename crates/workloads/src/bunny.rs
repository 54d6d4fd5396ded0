//! The Stanford bunny.

use trisect_mesh::{Mesh, MeshFormat};

/// The Stanford bunny, which is compiled into the program: 69,451 triangles. Stanford Computer Graphics Laboratory;
/// `data/README.md` has its licence.
///
/// # Panics
/// Never: a test loads it.
pub fn bunny() -> Mesh {
    let bytes = include_bytes!("../../../data/meshes/bunny.ply");
    Mesh::from_bytes("bunny", MeshFormat::Ply, bytes)
        .expect("the mesh compiled into the program is sound")
}
