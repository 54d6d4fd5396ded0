//! A mesh that rays are asked of.

use std::path::Path;

use rayon::prelude::*;
use trisect_core::Vec3;
use trisect_method::{Culling, Method, UnsuitableMesh};
use trisect_tracer::{RefitError, Statistics, Tracing, Tree, TriangleHit};

use crate::options::corners;
use crate::{
    AllHits, Crossings, Hit, NotExact, Note, Place, Precision, Ray, SceneError, SceneOptions,
    Triangle, Update, UpdateError, Verdict,
};

/// A mesh that rays are asked of, from any number of threads.
///
/// A ray that is not finite, whose direction is zero, or whose interval is empty hits nothing.
pub struct Scene<P: Precision = f32> {
    pub(crate) tree: Box<dyn Tree<P>>,
    /// None where the scene is one of instances.
    pub(crate) triangles: Vec<Triangle<P>>,
    /// The vertices of each triangle; where there are none, it has three of its own.
    pub(crate) faces: Option<Box<[[u32; 3]]>>,
    /// How many vertices there are.
    pub(crate) vertices: usize,
    pub(crate) notes: Vec<Note>,
    pub(crate) batches: Tracing,
    /// Builds its tree anew; nothing where the scene is one of instances.
    pub(crate) anew: Option<BuildAnew<P>>,
    /// What a ray was expected to cost when the tree was built.
    pub(crate) built: f64,
}

/// Builds the tree of a scene whose triangles have moved.
pub(crate) type BuildAnew<P> =
    Box<dyn Fn(&[Triangle<P>]) -> Result<Box<dyn Tree<P>>, UnsuitableMesh> + Send + Sync>;

/// A scene of which some faces are not seen, or whose triangles own their crossings.
#[derive(Clone, Copy)]
pub struct View<'a, P: Precision = f32> {
    scene: &'a Scene<P>,
    culling: Culling,
    crossings: Crossings,
}

impl Scene {
    /// The scene of a file: PLY, OBJ, STL or glTF.
    ///
    /// # Errors
    /// When the file cannot be read, or is not sound: the message names the place and the mend.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::options().open(path)
    }
}

impl Scene<f64> {
    /// The scene of a file, in f64: coordinates are not rounded, where the file has more bits than f32.
    ///
    /// # Errors
    /// As [`open`](Scene::open).
    pub fn open_f64(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::options().open_f64(path)
    }
}

impl<P: Precision> Scene<P> {
    /// A scene of faces, which name their corners among the vertices. It is never wrong: see
    /// [`SceneOptions::exact`]. [`Scene::options`] has the other methods.
    ///
    /// # Errors
    /// When a face names a vertex that there is not, or one that is not finite, or when there are more than 2²⁷
    /// faces.
    pub fn new(vertices: &[[P; 3]], faces: &[[u32; 3]]) -> Result<Self, SceneError> {
        Self::options().build(vertices, faces)
    }

    /// A scene of triangles. Those that are not finite, or have no area, are never hit.
    ///
    /// # Errors
    /// When there are more than 2²⁷ triangles.
    pub fn from_triangles(triangles: &[Triangle<P>]) -> Result<Self, SceneError> {
        Self::options().from_triangles(triangles)
    }

    /// A scene of faces whose rays are tested by any method, one of your own among them: as
    /// [`SceneOptions::with_method`].
    ///
    /// # Errors
    /// As [`Scene::new`], and when the method cannot take the mesh.
    pub fn with_method<M: Method>(
        vertices: &[[P; 3]],
        faces: &[[u32; 3]],
    ) -> Result<Self, SceneError> {
        Self::options().with_method::<M>().build(vertices, faces)
    }

    /// How a scene is made otherwise.
    pub fn options() -> SceneOptions<P> {
        SceneOptions::default()
    }

    /// The first hit of a ray: that of the smallest `t`; of several at one point, that of the lowest index. On a
    /// processor with AVX2, AVX-512 or Neon it allocates nothing.
    #[inline]
    pub fn first(&self, ray: &Ray<P>) -> Option<Hit<P>> {
        self.seen(Culling::None).first(ray)
    }

    /// Whether a ray hits anything: faster than [`first`](Scene::first), and allocates no more.
    #[inline]
    pub fn any(&self, ray: &Ray<P>) -> bool {
        self.seen(Culling::None).any(ray)
    }

    /// The first hit of each ray, on the threads of the rayon pool that it is called in.
    ///
    /// # Panics
    /// When there are not as many places as rays.
    pub fn first_of(&self, rays: &[Ray<P>], hits: &mut [Option<Hit<P>>]) {
        self.seen(Culling::None).first_of(rays, hits);
    }

    /// Whether each ray hits anything, on the threads of the rayon pool that it is called in.
    ///
    /// # Panics
    /// When there are not as many places as rays.
    pub fn any_of(&self, rays: &[Ray<P>], hits: &mut [bool]) {
        self.seen(Culling::None).any_of(rays, hits);
    }

    /// All hits of a ray, by `t`, then by index: every triangle once. The exact method orders them by their true `t`,
    /// however near they are to each other. `hits` is cleared before; nothing is allocated once it has room.
    pub fn all(&self, ray: &Ray<P>, hits: &mut Vec<Hit<P>>) {
        self.seen(Culling::None).all(ray, hits);
    }

    /// How many hits [`all`](Scene::all) finds. Allocates nothing.
    pub fn count(&self, ray: &Ray<P>) -> u32 {
        self.seen(Culling::None).count(ray)
    }

    /// The first hit that a program accepts. It is offered hits in no particular order, and may be offered one more than
    /// once, but none behind a hit that it has accepted.
    pub fn filtered(
        &self,
        ray: &Ray<P>,
        program: impl FnMut(&Hit<P>) -> Verdict,
    ) -> Option<Hit<P>> {
        self.seen(Culling::None).filtered(ray, program)
    }

    /// The first hit with a triangle left out: the one that the ray starts from.
    pub fn first_but(&self, ray: &Ray<P>, triangle: u32) -> Option<Hit<P>> {
        self.seen(Culling::None).first_but(ray, triangle)
    }

    /// [`all`](Scene::all) of each ray, on the threads of the rayon pool that it is called in.
    pub fn all_of(&self, rays: &[Ray<P>]) -> AllHits<P> {
        self.seen(Culling::None).all_of(rays)
    }

    /// [`count`](Scene::count) of each ray, on the threads of the rayon pool that it is called in.
    ///
    /// # Panics
    /// When there are not as many places as rays.
    pub fn count_of(&self, rays: &[Ray<P>], counts: &mut [u32]) {
        self.seen(Culling::None).count_of(rays, counts);
    }

    /// Whether a point is inside, on or outside the surface of the triangles, decided exactly. Inside is what is
    /// enclosed an odd number of times, so that a surface within another bounds a cavity; which way triangles face plays
    /// no part. The surface has to be closed. A point that is not finite is outside.
    ///
    /// # Errors
    /// When the scene's method is not exact.
    pub fn contains(&self, point: [P; 3]) -> Result<Place, NotExact> {
        self.tree.contains(point.into())
    }

    /// [`contains`](Scene::contains) of each point, on the threads of the rayon pool that it is called in.
    ///
    /// # Errors
    /// As [`contains`](Scene::contains).
    pub fn contains_of(&self, points: &[[P; 3]]) -> Result<Vec<Place>, NotExact> {
        let points: Vec<Vec3<P>> = points.iter().map(|&point| point.into()).collect();
        let mut places = vec![Place::Outside; points.len()];
        self.tree.contains_of(&points, &mut places)?;
        Ok(places)
    }

    /// The same scene for queries that do not see some faces. The front of a triangle is where its corners run
    /// counter-clockwise.
    #[inline]
    pub fn seen(&self, culling: Culling) -> View<'_, P> {
        View { scene: self, culling, crossings: Crossings::Every }
    }

    /// The same scene for queries that find all hits or count them, with a choice of what counts where a ray meets an
    /// edge or a corner that triangles share. [`Crossings::Owned`] takes the exact method.
    pub fn crossings(&self, crossings: Crossings) -> View<'_, P> {
        self.seen(Culling::None).crossings(crossings)
    }

    /// Moves the vertices. The tree is fitted to them, which is far quicker than making it anew; where it has become
    /// worn by that, it is made anew after all, with the builder that it was made with: where a ray is expected to cost
    /// more than 1.25 times what it cost when the tree was built, by the surface area heuristic. What was done is
    /// returned. Make scenes that move with [`SceneOptions::moving`]: where triangles were divided between leaves, a
    /// tree that is fitted is worn at once. Where the scene was not made of faces, its vertices are the corners of its
    /// triangles, one triangle after another.
    ///
    /// # Errors
    /// When there are not as many vertices as before, when one that a face names is not finite, or when the scene is
    /// one of instances. The scene is as before then.
    pub fn update(&mut self, vertices: &[[P; 3]]) -> Result<Update, UpdateError> {
        let Some(anew) = &self.anew else { return Err(UpdateError::Instances) };
        let (made, given) = (self.vertices, vertices.len());
        if made != given {
            return Err(UpdateError::Count { made, given });
        }
        let moved = match &self.faces {
            Some(faces) => corners(vertices, faces)?,
            None => {
                vertices.as_chunks().0.iter().map(|&[a, b, c]| Triangle::new(a, b, c)).collect()
            }
        };
        let update = match self.tree.refit(&moved) {
            Ok(()) => Update::of_cost(self.built, self.tree.statistics().cost),
            // It is in no leaf.
            Err(RefitError::Appeared { .. }) => Update::Rebuilt,
            Err(error) => return Err(error.into()),
        };
        if update == Update::Rebuilt {
            // A mesh that the tree was fitted to suits the method.
            self.tree = anew(&moved).map_err(SceneError::from)?;
            self.built = self.tree.statistics().cost;
        }
        self.triangles = moved;
        Ok(update)
    }

    /// The triangles, by index; none where the scene is one of instances.
    pub fn triangles(&self) -> &[Triangle<P>] {
        &self.triangles
    }

    /// What was read otherwise than the file has it.
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// Facts about the tree: its nodes, its depth, its bytes.
    pub fn statistics(&self) -> Statistics {
        self.tree.statistics()
    }
}

impl<P: Precision> View<'_, P> {
    /// As [`Scene::crossings`].
    pub fn crossings(self, crossings: Crossings) -> Self {
        Self { crossings, ..self }
    }

    /// As [`Scene::all`].
    pub fn all(&self, ray: &Ray<P>, hits: &mut Vec<Hit<P>>) {
        P::gathering(|found| {
            self.scene.tree.all(Tracing::Single, self.culling, self.crossings, ray, found);
            hits.clear();
            hits.extend(found.iter().copied().map(Hit::of));
        });
    }

    /// As [`Scene::count`].
    pub fn count(&self, ray: &Ray<P>) -> u32 {
        self.scene.tree.count(Tracing::Single, self.culling, self.crossings, ray)
    }

    /// As [`Scene::filtered`].
    pub fn filtered(
        &self,
        ray: &Ray<P>,
        mut program: impl FnMut(&Hit<P>) -> Verdict,
    ) -> Option<Hit<P>> {
        let mut of = |hit: &TriangleHit<P>| program(&Hit::of(*hit));
        self.scene.tree.filtered(Tracing::Single, self.culling, ray, &mut of).map(Hit::of)
    }

    /// As [`Scene::first_but`].
    pub fn first_but(&self, ray: &Ray<P>, triangle: u32) -> Option<Hit<P>> {
        self.scene.tree.closest_but(Tracing::Single, self.culling, ray, triangle).map(Hit::of)
    }

    /// As [`Scene::all_of`].
    pub fn all_of(&self, rays: &[Ray<P>]) -> AllHits<P> {
        let mut all = AllHits(trisect_tracer::AllHits::default());
        self.scene.tree.all_of(Tracing::Single, self.culling, self.crossings, rays, &mut all.0);
        all
    }

    /// As [`Scene::count_of`].
    ///
    /// # Panics
    /// When there are not as many places as rays.
    pub fn count_of(&self, rays: &[Ray<P>], counts: &mut [u32]) {
        assert_eq!(rays.len(), counts.len(), "each ray has a place for its count");
        self.scene.tree.count_of(Tracing::Single, self.culling, self.crossings, rays, counts);
    }

    /// As [`Scene::first`].
    #[inline]
    pub fn first(&self, ray: &Ray<P>) -> Option<Hit<P>> {
        self.scene.tree.closest_hit(self.culling, ray).found().map(Hit::of)
    }

    /// As [`Scene::any`].
    #[inline]
    pub fn any(&self, ray: &Ray<P>) -> bool {
        self.scene.tree.any_hit(self.culling, ray)
    }

    /// As [`Scene::first_of`].
    ///
    /// # Panics
    /// When there are not as many places as rays.
    pub fn first_of(&self, rays: &[Ray<P>], hits: &mut [Option<Hit<P>>]) {
        assert_eq!(rays.len(), hits.len(), "each ray has a place for its hit");
        let mut found = vec![None; rays.len()];
        self.scene.tree.closest(self.scene.batches, self.culling, rays, &mut found);
        let parts = hits.par_chunks_mut(CHUNK).zip(found.par_chunks(CHUNK));
        parts.for_each(|(hits, found)| {
            for (hit, found) in hits.iter_mut().zip(found) {
                *hit = found.map(Hit::of);
            }
        });
    }

    /// As [`Scene::any_of`].
    ///
    /// # Panics
    /// When there are not as many places as rays.
    pub fn any_of(&self, rays: &[Ray<P>], hits: &mut [bool]) {
        assert_eq!(rays.len(), hits.len(), "each ray has a place for its answer");
        self.scene.tree.any(self.scene.batches, self.culling, rays, hits);
    }
}

/// Hits that one thread takes down at a time.
const CHUNK: usize = 1 << 14;
