//! How a scene is made.

use std::path::Path;

use trisect_mesh::Mesh;
use trisect_method::{Method, UnsuitableMesh};
use trisect_tracer::{Builder, Leaves, Tracing, Tree};

use crate::error::MOST;
use crate::instances::SceneTree;
use crate::trees::{self, BuildTree};
use crate::{Note, Scene, SceneError, Triangle};

/// How a scene is made: by which method rays are tested, and how much time its tree may take to build.
#[derive(Clone, Copy, Debug)]
pub struct SceneOptions {
    build: BuildTree,
    builder: Builder,
    /// How batches are traced.
    batches: Tracing,
}

impl Default for SceneOptions {
    /// As [`exact`](SceneOptions::exact).
    fn default() -> Self {
        Self { build: trees::exact, builder: Builder::default(), batches: Tracing::Packets }
    }
}

impl SceneOptions {
    /// The default: every decision, and which of two hits comes first, is that of exact arithmetic on the ray and
    /// the triangle as they are given; `t`, `beta` and `gamma` are rounded once.
    pub fn exact(self) -> Self {
        Self { build: trees::exact, batches: Tracing::Packets, ..self }
    }

    /// The fastest: the test of Möller and Trumbore. Of all methods of this project no other is faster in a tree
    /// by more than measuring can tell. It may lose a ray that passes between two triangles through their common
    /// edge, or take one that passes beside an edge by a rounding.
    pub fn fast(self) -> Self {
        Self { build: trees::fast, batches: Tracing::Single, ..self }
    }

    /// No ray passes between two triangles through their common edge: the test of Woop, Benthin and Wald. What is
    /// hit there, and which of two near hits comes first, is up to rounding.
    pub fn watertight(self) -> Self {
        Self { build: trees::watertight, batches: Tracing::Single, ..self }
    }

    /// Any method, one of your own among them. Its tree is compiled where this is called, which takes seconds.
    pub fn with_method<M: Method>(self) -> Self {
        Self { build: trees::build::<M>, batches: batches(M::INFO.claims.exact), ..self }
    }

    /// For a mesh that moves: no triangle is divided between leaves, so that [`Scene::update`] keeps the tree tight.
    pub fn moving(self) -> Self {
        self.builder(Builder::Binned)
    }

    /// The builder of the tree; [`Builder::Spatial`] where none is named.
    pub fn builder(self, builder: Builder) -> Self {
        Self { builder, ..self }
    }

    /// Rays of a batch that are near each other, as those of a camera, go down the tree in packets: up to three times
    /// as fast. The answers are the same but where two hits are as near as the method's rounding lets be told. The
    /// exact method's batches always go so, as its answers are the same.
    pub fn packets(self) -> Self {
        Self { batches: Tracing::Packets, ..self }
    }

    /// A scene of faces, which name their corners among the vertices.
    ///
    /// # Errors
    /// When a face names a vertex that there is not, or one that is not finite; when there are more than 2²⁷
    /// faces; or when the method cannot take the mesh.
    pub fn build(self, vertices: &[[f32; 3]], faces: &[[u32; 3]]) -> Result<Scene, SceneError> {
        count(faces.len())?;
        let triangles = corners(vertices, faces)?;
        self.finish(triangles, Some((faces.into(), vertices.len())), vec![])
    }

    /// A scene of triangles. Those that are not finite, or have no area, are never hit.
    ///
    /// # Errors
    /// When there are more than 2²⁷ triangles, or the method cannot take the mesh.
    pub fn from_triangles(self, triangles: &[Triangle]) -> Result<Scene, SceneError> {
        count(triangles.len())?;
        self.finish(triangles.to_vec(), None, vec![])
    }

    /// The scene of a file: PLY, OBJ, STL or glTF, by the end of its name. What was read otherwise than the file has
    /// it is said by [`Scene::notes`].
    ///
    /// # Errors
    /// When the file cannot be read or is not sound: the message names the place and the mend; or as
    /// [`from_triangles`](SceneOptions::from_triangles).
    pub fn open(self, path: impl AsRef<Path>) -> Result<Scene, SceneError> {
        let mesh = Mesh::load(path)?;
        count(mesh.triangles.len())?;
        self.finish(mesh.triangles.to_vec(), None, mesh.notes)
    }

    fn finish(
        self,
        triangles: Vec<Triangle>,
        faces: Option<(Box<[[u32; 3]]>, usize)>,
        notes: Vec<Note>,
    ) -> Result<Scene, SceneError> {
        let (faces, vertices) = match faces {
            Some((faces, vertices)) => (Some(faces), vertices),
            None => (None, 3 * triangles.len()),
        };
        let tree = self.tree(&triangles)?;
        let (batches, built) = (self.batches, tree.statistics().cost);
        let tree = SceneTree::Mesh(tree);
        Ok(Scene { tree, triangles, faces, vertices, notes, batches, options: self, built })
    }

    pub(crate) fn tree(self, triangles: &[Triangle]) -> Result<Box<dyn Tree>, UnsuitableMesh> {
        (self.build)(triangles, self.builder, Leaves::default())
    }
}

/// How batches of a method are traced where nothing else is asked for: so that they answer as single rays do.
fn batches(is_exact: bool) -> Tracing {
    if is_exact { Tracing::Packets } else { Tracing::Single }
}

fn count(faces: usize) -> Result<(), SceneError> {
    if faces > MOST { Err(SceneError::TooMany { faces }) } else { Ok(()) }
}

/// The corners of each face.
///
/// # Errors
/// When a face names a vertex that there is not, or one that is not finite.
pub(crate) fn corners(
    vertices: &[[f32; 3]],
    faces: &[[u32; 3]],
) -> Result<Vec<Triangle>, SceneError> {
    let corner = |face: usize, vertex: u32| {
        let position = vertices.get(vertex as usize).copied();
        let position =
            position.ok_or(SceneError::NoVertex { face, vertex, vertices: vertices.len() })?;
        if position.iter().all(|x| x.is_finite()) {
            Ok(position)
        } else {
            Err(SceneError::NotFinite { face, vertex: vertex as usize, position })
        }
    };
    let triangle = |(face, &[a, b, c]): (usize, &[u32; 3])| {
        Ok(Triangle::new(corner(face, a)?, corner(face, b)?, corner(face, c)?))
    };
    faces.iter().enumerate().map(triangle).collect()
}
