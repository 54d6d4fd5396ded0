//! Shapes that rays hit: the programs for bounds and intersection.

use std::sync::Arc;

use glam::Vec3;
use trisect_core::{Hit, Ray, Triangle};
use trisect_method::{Culling, Method, UnsuitableMesh};
use trisect_tracer::{Builder, Bvh, EveryTriangle, Leaves as LeafSize, RefitError, Tree, Update};

/// A kind of shape. Every ray–triangle method is one: its triangles go through the tracer's trees. Others have a tree of
/// their own, [`Leaves`](crate::Leaves).
pub trait Primitive: Send + Sync + Sized + 'static {
    /// What one shape is given by.
    type Shape: Clone + Send + Sync + 'static;
    /// What a hit says beside its numbers. Computed for the nearest hit, and only where a program reads it.
    type Attributes: Copy;
    /// The tree over many shapes.
    type Tree: ShapeTree<Self::Shape>;

    /// The lowest and the highest corner of a box around a shape. Rounding is allowed for where trees are built.
    fn bounds(shape: &Self::Shape) -> [Vec3; 2];

    /// Reports where the line of a ray meets a shape, in any order. What is outside the ray's interval, or on a face
    /// that is not seen, may be reported and is passed over. `beta` and `gamma` of a hit are free: they are kept, and
    /// handed to [`normal`](Primitive::normal) and [`attributes`](Primitive::attributes).
    fn cross(shape: &Self::Shape, ray: &Ray<f32>, report: &mut dyn FnMut(Hit<f32>));

    /// Towards the front of a shape where a ray hits it, of any length but zero.
    fn normal(shape: &Self::Shape, ray: &Ray<f32>, hit: &Hit<f32>) -> Vec3;

    /// The shapes, where they are triangles whose normals are those of their corners: these are computed without a call.
    fn triangles(_shapes: &Arc<[Self::Shape]>) -> Option<Arc<[Triangle<f32>]>> {
        None
    }

    /// What else there is to know of a hit. The ray is in the space of the shape.
    fn attributes(shape: &Self::Shape, ray: &Ray<f32>, hit: &Hit<f32>) -> Self::Attributes;
}

/// A tree that is built over shapes, and fitted to them when they move.
pub trait ShapeTree<S>: Tree + Sized {
    /// Builds the tree.
    ///
    /// # Errors
    /// When the shapes cannot be taken.
    fn build(shapes: &Arc<[S]>, builder: Builder) -> Result<Self, UnsuitableMesh>;

    /// Fits it to as many shapes as before. Says [`Update::Rebuilt`] where it has been built anew by itself, and
    /// otherwise how worn it is.
    ///
    /// # Errors
    /// When it cannot be fitted to these, and is as before.
    fn fit(&mut self, shapes: &Arc<[S]>) -> Result<Update, RefitError>;
}

impl<M: Method> Primitive for M {
    type Shape = Triangle<f32>;
    /// The weights of the corners a, b and c.
    type Attributes = [f32; 3];
    type Tree = Bvh<M>;

    fn bounds(triangle: &Triangle<f32>) -> [Vec3; 2] {
        let [a, b, c] = triangle.corners().map(Vec3::from);
        [a.min(b).min(c), a.max(b).max(c)]
    }

    fn cross(triangle: &Triangle<f32>, ray: &Ray<f32>, report: &mut dyn FnMut(Hit<f32>)) {
        // A method that needs more than one triangle of a mesh hits nothing here.
        let alone = EveryTriangle::<M>::new(&[*triangle]).ok();
        if let Some(found) = alone.and_then(|one| one.closest_hit(Culling::None, ray).found()) {
            report(found.hit);
        }
    }

    fn normal(triangle: &Triangle<f32>, _: &Ray<f32>, _: &Hit<f32>) -> Vec3 {
        normal(triangle)
    }

    fn triangles(triangles: &Arc<[Triangle<f32>]>) -> Option<Arc<[Triangle<f32>]>> {
        Some(Arc::clone(triangles))
    }

    fn attributes(_: &Triangle<f32>, _: &Ray<f32>, hit: &Hit<f32>) -> [f32; 3] {
        weights(hit)
    }
}

/// That of a triangle.
#[inline]
pub(crate) fn normal(triangle: &Triangle<f32>) -> Vec3 {
    triangle.normal().into()
}

/// The weights of a triangle's corners.
#[inline]
pub(crate) fn weights(hit: &Hit<f32>) -> [f32; 3] {
    [1.0 - hit.beta - hit.gamma, hit.beta, hit.gamma]
}

impl<M: Method> ShapeTree<Triangle<f32>> for Bvh<M> {
    fn build(triangles: &Arc<[Triangle<f32>]>, builder: Builder) -> Result<Self, UnsuitableMesh> {
        Self::build_with(triangles, builder, LeafSize::default())
    }

    fn fit(&mut self, triangles: &Arc<[Triangle<f32>]>) -> Result<Update, RefitError> {
        fit(self, triangles)
    }
}

/// Fits a tree over triangles.
pub(crate) fn fit(tree: &mut dyn Tree, triangles: &[Triangle<f32>]) -> Result<Update, RefitError> {
    let built = tree.statistics().cost;
    tree.refit(triangles)?;
    Ok(Update::Refitted { cost: tree.statistics().cost / built })
}
