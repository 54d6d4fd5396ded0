//! How a scene is made.

use std::path::Path;

use trisect_mesh::Mesh;
use trisect_method::{Method, UnsuitableMesh};
use trisect_tracer::{Builder, Leaves, Tracing, Tree};

use crate::error::MOST;
use crate::rounded::Rounded;
use crate::scene::BuildAnew;
use crate::trees::{self, BuildTree};
use crate::{Note, Precision, Scene, SceneError, Triangle};

/// How a scene is made: by which method rays are tested, and how much time its tree may take to build.
#[derive(Clone, Copy, Debug)]
pub struct SceneOptions<P: Precision = f32> {
    pub(crate) build: BuildTree<P>,
    builder: Builder,
    /// How batches are traced.
    batches: Tracing,
}

impl<P: Precision> Default for SceneOptions<P> {
    /// As [`exact`](SceneOptions::exact).
    fn default() -> Self {
        Self { build: P::exact, builder: Builder::default(), batches: Tracing::Packets }
    }
}

impl<P: Precision> SceneOptions<P> {
    /// The default: every decision, and which of two hits comes first, is that of exact arithmetic on the ray and
    /// the triangle as they are given; `t`, `beta` and `gamma` are rounded once.
    pub fn exact(self) -> Self {
        Self { build: P::exact, batches: Tracing::Packets, ..self }
    }

    /// The fastest: the test of Möller and Trumbore. Of all methods of this project no other is faster in a tree
    /// by more than measuring can tell. It may lose a ray that passes between two triangles through their common
    /// edge, or take one that passes beside an edge by a rounding.
    pub fn fast(self) -> Self {
        Self { build: P::fast, batches: Tracing::Single, ..self }
    }

    /// No ray passes between two triangles through their common edge: the test of Woop, Benthin and Wald. What is
    /// hit there, and which of two near hits comes first, is up to rounding.
    pub fn watertight(self) -> Self {
        Self { build: P::watertight, batches: Tracing::Single, ..self }
    }

    /// Any method, one of your own among them. Its tree is compiled where this is called, which takes seconds.
    pub fn with_method<M: Method>(self) -> Self {
        Self { build: trees::build::<M, P>, batches: batches(M::INFO.claims.exact), ..self }
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
    pub fn build(self, vertices: &[[P; 3]], faces: &[[u32; 3]]) -> Result<Scene<P>, SceneError> {
        count(faces.len())?;
        let triangles = corners(vertices, faces)?;
        self.finish(triangles, Some((faces.into(), vertices.len())), vec![])
    }

    /// A scene of triangles. Those that are not finite, or have no area, are never hit.
    ///
    /// # Errors
    /// When there are more than 2²⁷ triangles, or the method cannot take the mesh.
    pub fn from_triangles(self, triangles: &[Triangle<P>]) -> Result<Scene<P>, SceneError> {
        count(triangles.len())?;
        self.finish(triangles.to_vec(), None, vec![])
    }

    fn of_mesh(self, mesh: Mesh) -> Result<Scene<P>, SceneError> {
        count(mesh.triangles.len())?;
        self.finish(P::triangles(&mesh), None, mesh.notes)
    }

    fn finish(
        self,
        triangles: Vec<Triangle<P>>,
        faces: Option<(Box<[[u32; 3]]>, usize)>,
        notes: Vec<Note>,
    ) -> Result<Scene<P>, SceneError> {
        let anew = move |triangles: &[Triangle<P>]| {
            (self.build)(triangles, self.builder, Leaves::default())
        };
        scene(Box::new(anew), triangles, faces, notes, self.batches)
    }
}

impl SceneOptions<f64> {
    /// The scene of a file, in f64: coordinates are not rounded, where the file has more bits than f32.
    ///
    /// # Errors
    /// As [`open`](SceneOptions::open).
    pub fn open_f64(self, path: impl AsRef<Path>) -> Result<Scene<f64>, SceneError> {
        self.of_mesh(Mesh::load(path)?)
    }
}

impl SceneOptions<f32> {
    /// The scene of a file: PLY, OBJ, STL or glTF, by the end of its name. What was read otherwise than the file has
    /// it is said by [`Scene::notes`].
    ///
    /// # Errors
    /// When the file cannot be read or is not sound: the message names the place and the mend; or as
    /// [`from_triangles`](SceneOptions::from_triangles).
    pub fn open(self, path: impl AsRef<Path>) -> Result<Scene, SceneError> {
        self.of_mesh(Mesh::load(path)?)
    }

    /// A scene of f64 that answers in f32, near its own origin: quicker than one in f64, and for coordinates that are
    /// large beside the scene far better than one of rounded vertices. The scene's center is subtracted in f64 from vertices
    /// and from the origins of rays, and then these, directions and intervals are rounded to f32. The method tests what
    /// that gives; so the exact one is exact about rounded triangles and rounded rays. `t` and weights are those of f32;
    /// [`Hit::point`](crate::Hit::point) weights the vertices as they were given.
    ///
    /// A vertex is moved by up to 2⁻²⁵ of the scene's largest extent. A direction beyond the range of f32 hits nothing.
    /// [`Scene::update`] keeps the center, unless the tree is made anew.
    ///
    /// # Errors
    /// As [`build`](SceneOptions::build).
    pub fn build_rounded(
        self,
        vertices: &[[f64; 3]],
        faces: &[[u32; 3]],
    ) -> Result<Scene<f64>, SceneError> {
        count(faces.len())?;
        let triangles = corners(vertices, faces)?;
        let anew =
            move |triangles: &[Triangle<f64>]| -> Result<Box<dyn Tree<f64>>, UnsuitableMesh> {
                Ok(Box::new(Rounded::build(triangles, self.build, self.builder)?))
            };
        let faces = Some((faces.into(), vertices.len()));
        scene(Box::new(anew), triangles, faces, vec![], self.batches)
    }
}

/// The scene of a mesh whose trees are built so.
fn scene<P: Precision>(
    anew: BuildAnew<P>,
    triangles: Vec<Triangle<P>>,
    faces: Option<(Box<[[u32; 3]]>, usize)>,
    notes: Vec<Note>,
    batches: Tracing,
) -> Result<Scene<P>, SceneError> {
    let (faces, vertices) = match faces {
        Some((faces, vertices)) => (Some(faces), vertices),
        None => (None, 3 * triangles.len()),
    };
    let tree = anew(&triangles)?;
    let built = tree.statistics().cost;
    Ok(Scene { tree, triangles, faces, vertices, notes, batches, anew: Some(anew), built })
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
pub(crate) fn corners<P: Precision>(
    vertices: &[[P; 3]],
    faces: &[[u32; 3]],
) -> Result<Vec<Triangle<P>>, SceneError> {
    let corner = |face: usize, vertex: u32| {
        let position = vertices.get(vertex as usize).copied();
        let position =
            position.ok_or(SceneError::NoVertex { face, vertex, vertices: vertices.len() })?;
        if position.iter().all(|x| x.to_f64().is_finite()) {
            Ok(position)
        } else {
            // As it is written, not as it is in f32.
            let position = position.map(|x| format!("{x:?}").parse().unwrap_or(f64::NAN));
            Err(SceneError::NotFinite { face, vertex: vertex as usize, position })
        }
    };
    let triangle = |(face, &[a, b, c]): (usize, &[u32; 3])| {
        Ok(Triangle::new(corner(face, a)?, corner(face, b)?, corner(face, c)?))
    };
    faces.iter().enumerate().map(triangle).collect()
}
