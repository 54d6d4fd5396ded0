//! A tree whose type does not name its method.

use trisect_core::{Culling, Method, Ray, Triangle, UnsuitableMesh};

use crate::build::{Builder, Leaves};
use crate::bvh::{Bvh, Statistics};
use crate::dispatch::{Tracing, Tree};
use crate::hit::TriangleHit;
use crate::walk::Counted;

/// The tree of [`Bvh`], with the method behind a call for each leaf. The way through the nodes is compiled
/// once for all methods, so a method costs a fraction of the time to compile. The answers are the same; a
/// [`Bvh`], which has the method's test in its loop, is faster by what the calls cost.
pub struct ErasedBvh(Box<dyn Tree>);

impl ErasedBvh {
    /// As [`Bvh::build`].
    ///
    /// # Errors
    /// As [`Bvh::build`].
    ///
    /// # Panics
    /// As [`Bvh::build`].
    pub fn build<M: Method>(
        triangles: &[Triangle<f32>],
        builder: Builder,
    ) -> Result<Self, UnsuitableMesh> {
        Self::build_with::<M>(triangles, builder, Leaves::default())
    }

    /// As [`Bvh::build_with`].
    ///
    /// # Errors
    /// As [`Bvh::build`].
    ///
    /// # Panics
    /// As [`Bvh::build`].
    pub fn build_with<M: Method>(
        triangles: &[Triangle<f32>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Self, UnsuitableMesh> {
        Ok(Self(Box::new(Called(Bvh::<M>::build_with(triangles, builder, leaves)?))))
    }
}

impl Tree for ErasedBvh {
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        self.0.closest(tracing, culling, rays, found);
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        self.0.any(tracing, culling, rays, found);
    }

    fn count(&self, ray: &Ray<f32>) -> Counted {
        self.0.count(ray)
    }

    fn candidates(&self, ray: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
        self.0.candidates(ray, visit);
    }

    fn statistics(&self) -> Statistics {
        self.0.statistics()
    }
}

/// A tree that is traced through calls of its leaves.
struct Called<M: Method>(Bvh<M>);

impl<M: Method> Tree for Called<M> {
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        self.0.batch::<_, false, false>(tracing, culling, rays, found);
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        self.0.batch::<_, true, false>(tracing, culling, rays, found);
    }

    fn count(&self, ray: &Ray<f32>) -> Counted {
        self.0.counted(ray)
    }

    fn candidates(&self, ray: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
        self.0.visit_candidates(ray, visit);
    }

    fn statistics(&self) -> Statistics {
        self.0.statistics_of()
    }
}
