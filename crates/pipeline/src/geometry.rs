//! Geometries: shapes of one kind in a tree.

use std::any::Any;
use std::sync::Arc;

use glam::Vec3;
use trisect_core::{Hit, Ray, Triangle};
use trisect_method::UnsuitableMesh;
use trisect_tracer::{Builder, Leaves as LeafSize, RefitError, Tree, Update, is_worn};

use crate::primitive::{self, Primitive, ShapeTree};

/// Builds a tree over triangles: of a method of choice, compiled where that function is.
pub type BuildTree =
    fn(&[Triangle<f32>], Builder, LeafSize) -> Result<Box<dyn Tree>, UnsuitableMesh>;

/// What is done with the tree of a geometry whose shapes have moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It is fitted to them.
    Refit,
    /// It is built anew.
    Rebuild,
    /// It is fitted, and built anew where that leaves it worn, see [`is_worn`].
    AsNeeded,
}

/// Shapes cannot take the place of others.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReshapeError {
    /// They are of another kind.
    #[error(
        "the geometry has shapes of another kind: give it those that it was made of, or add a new one"
    )]
    OtherKind,
    /// The tree cannot be fitted to them.
    #[error(transparent)]
    Refit(#[from] RefitError),
    /// The method cannot take them.
    #[error(transparent)]
    Unsuitable(#[from] UnsuitableMesh),
}

/// Shapes of one kind in a tree.
pub struct Geometry {
    kind: Box<dyn Kind>,
    /// The shapes, where they are triangles: their normals take no call.
    triangles: Option<Arc<[Triangle<f32>]>>,
}

/// What is asked of shapes, whatever their kind.
trait Kind: Any + Send + Sync {
    fn tree(&self) -> &dyn Tree;
    fn count(&self) -> usize;
    fn triangles(&self) -> Option<Arc<[Triangle<f32>]>>;
    /// Of shapes that are no triangles.
    fn normal(&self, shape: usize, ray: &Ray<f32>, hit: &Hit<f32>) -> Vec3;
    /// `shapes` is a vector of such shapes.
    fn reshape(&mut self, shapes: Box<dyn Any>, change: Change) -> Result<Update, ReshapeError>;
}

/// Shapes of a primitive.
struct Of<P: Primitive> {
    shapes: Arc<[P::Shape]>,
    tree: P::Tree,
    builder: Builder,
}

/// Triangles in a tree that somebody else builds.
struct Mesh {
    triangles: Arc<[Triangle<f32>]>,
    tree: Box<dyn Tree>,
    builder: Builder,
    build: BuildTree,
}

impl Geometry {
    /// Shapes of a primitive. For a ray–triangle method this compiles its tree; [`Geometry::triangles`] takes one that is
    /// compiled elsewhere.
    ///
    /// # Errors
    /// When a method cannot take the triangles.
    pub fn of<P: Primitive>(
        shapes: Vec<P::Shape>,
        builder: Builder,
    ) -> Result<Self, UnsuitableMesh> {
        let shapes: Arc<[P::Shape]> = shapes.into();
        let tree = P::Tree::build(&shapes, builder)?;
        Ok(Self::new(Of::<P> { shapes, tree, builder }))
    }

    /// Triangles in a tree.
    ///
    /// # Errors
    /// When the method cannot take them.
    pub fn triangles(
        triangles: Vec<Triangle<f32>>,
        builder: Builder,
        build: BuildTree,
    ) -> Result<Self, UnsuitableMesh> {
        let tree = build(&triangles, builder, LeafSize::default())?;
        Ok(Self::new(Mesh { triangles: triangles.into(), tree, builder, build }))
    }

    fn new(kind: impl Kind) -> Self {
        Self { triangles: kind.triangles(), kind: Box::new(kind) }
    }

    /// The tree.
    pub fn tree(&self) -> &dyn Tree {
        self.kind.tree()
    }

    /// How many shapes there are.
    pub fn count(&self) -> usize {
        self.kind.count()
    }

    /// Whether a shape may be in several leaves, so that programs are offered a hit of it more than once.
    pub(crate) fn is_split(&self) -> bool {
        self.tree().statistics().references > self.count()
    }

    #[inline]
    pub(crate) fn normal(&self, shape: u32, ray: &Ray<f32>, hit: &Hit<f32>) -> Vec3 {
        match &self.triangles {
            Some(triangles) => primitive::normal(&triangles[shape as usize]),
            None => self.kind.normal(shape as usize, ray, hit),
        }
    }

    /// What a hit of a primitive says; `None` where the shapes are not of that primitive.
    pub(crate) fn attributes<P: Primitive>(
        &self,
        shape: u32,
        ray: &Ray<f32>,
        hit: &Hit<f32>,
    ) -> Option<P::Attributes> {
        let kind: &dyn Any = &*self.kind;
        let of = kind.downcast_ref::<Of<P>>()?;
        Some(P::attributes(&of.shapes[shape as usize], ray, hit))
    }

    pub(crate) fn reshape<S: 'static>(
        &mut self,
        shapes: Vec<S>,
        change: Change,
    ) -> Result<Update, ReshapeError> {
        let update = self.kind.reshape(Box::new(shapes), change)?;
        self.triangles = self.kind.triangles();
        Ok(update)
    }
}

/// Whether a tree that was fitted is to be built anew.
fn is_over(update: Update, change: Change) -> bool {
    change == Change::AsNeeded && matches!(update, Update::Refitted { cost } if is_worn(1.0, cost))
}

fn shapes_of<S: 'static>(shapes: Box<dyn Any>) -> Result<Vec<S>, ReshapeError> {
    shapes.downcast().map(|shapes| *shapes).map_err(|_| ReshapeError::OtherKind)
}

impl<P: Primitive> Kind for Of<P> {
    fn tree(&self) -> &dyn Tree {
        &self.tree
    }

    fn count(&self) -> usize {
        self.shapes.len()
    }

    fn triangles(&self) -> Option<Arc<[Triangle<f32>]>> {
        P::triangles(&self.shapes)
    }

    fn normal(&self, shape: usize, ray: &Ray<f32>, hit: &Hit<f32>) -> Vec3 {
        P::normal(&self.shapes[shape], ray, hit)
    }

    fn reshape(&mut self, shapes: Box<dyn Any>, change: Change) -> Result<Update, ReshapeError> {
        let shapes: Arc<[P::Shape]> = shapes_of::<P::Shape>(shapes)?.into();
        if change != Change::Rebuild {
            let update = self.tree.fit(&shapes)?;
            if !is_over(update, change) {
                self.shapes = shapes;
                return Ok(update);
            }
        }
        self.tree = P::Tree::build(&shapes, self.builder)?;
        self.shapes = shapes;
        Ok(Update::Rebuilt)
    }
}

impl Kind for Mesh {
    fn tree(&self) -> &dyn Tree {
        &*self.tree
    }

    fn count(&self) -> usize {
        self.triangles.len()
    }

    fn triangles(&self) -> Option<Arc<[Triangle<f32>]>> {
        Some(Arc::clone(&self.triangles))
    }

    fn normal(&self, shape: usize, _: &Ray<f32>, _: &Hit<f32>) -> Vec3 {
        primitive::normal(&self.triangles[shape])
    }

    fn reshape(&mut self, shapes: Box<dyn Any>, change: Change) -> Result<Update, ReshapeError> {
        let triangles: Arc<[Triangle<f32>]> = shapes_of::<Triangle<f32>>(shapes)?.into();
        if change != Change::Rebuild {
            let update = primitive::fit(&mut *self.tree, &triangles)?;
            if !is_over(update, change) {
                self.triangles = triangles;
                return Ok(update);
            }
        }
        self.tree = (self.build)(&triangles, self.builder, LeafSize::default())?;
        self.triangles = triangles;
        Ok(Update::Rebuilt)
    }
}
