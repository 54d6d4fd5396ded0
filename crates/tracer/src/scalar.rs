//! What the tracer's techniques are measured against: one number at a time, with a tree and without.

use std::cmp::Ordering;

use trisect_core::{
    Culling, Deferred, Division, Early, Method, PreparedTriangles, Ray, Triangle, TrueDivision,
    UnsuitableMesh, one_ray,
};

use crate::build::Builder;
use crate::bvh::{Bvh, Statistics};
use crate::dispatch::{Tracing, Tree};
use crate::hit::{Found, NO_HIT, TriangleHit};
use crate::lanes::OnOne;
use crate::walk::Counted;

/// A tree whose boxes and triangles are tested one at a time, by the calling thread, in plain arithmetic,
/// however it is asked to trace. Its answers are those of [`Tracing::Plain`].
pub struct ScalarBvh<M: Method>(Bvh<M>);

impl<M: Method> ScalarBvh<M> {
    /// As [`Bvh::build`].
    ///
    /// # Errors
    /// As [`Bvh::build`].
    ///
    /// # Panics
    /// As [`Bvh::build`].
    pub fn build(triangles: &[Triangle<f32>], builder: Builder) -> Result<Self, UnsuitableMesh> {
        Ok(Self(Bvh::build(triangles, builder)?))
    }

    fn trace<T: Found>(&self, culling: Culling, rays: &[Ray<f32>], found: &mut [T]) {
        assert!(found.len() >= rays.len(), "every ray has a place for what it finds");
        self.0.plainly::<OnOne, _>(culling, rays, found);
    }
}

impl<M: Method> Tree for ScalarBvh<M> {
    fn closest(
        &self,
        _: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        self.trace(culling, rays, found);
    }

    fn any(&self, _: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        self.trace(culling, rays, found);
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

/// No tree at all: every ray is tested against every triangle, one at a time, by the calling thread.
pub struct EveryTriangle<M: Method> {
    triangles: PreparedTriangles<M, f32>,
    count: usize,
}

impl<M: Method> EveryTriangle<M> {
    /// Prepares the triangles, whose numbers are their places.
    ///
    /// # Errors
    /// When the method cannot take the mesh.
    ///
    /// # Panics
    /// When there are more than `u32::MAX − 1` triangles.
    pub fn new(triangles: &[Triangle<f32>]) -> Result<Self, UnsuitableMesh> {
        Ok(Self { triangles: PreparedTriangles::new(triangles)?, count: triangles.len() })
    }

    fn trace<T: Found>(&self, culling: Culling, rays: &[Ray<f32>], found: &mut [T]) {
        assert!(found.len() >= rays.len(), "every ray has a place for what it finds");
        for (ray, found) in rays.iter().zip(found) {
            // As in the tree.
            let best = if const { M::INFO.forms.deferred() } {
                self.closest::<Deferred<TrueDivision, true>>(culling, ray)
            } else {
                self.closest::<Early<TrueDivision, true>>(culling, ray)
            };
            *found = T::of(&best);
        }
    }

    #[inline(always)]
    fn closest<D: Division>(&self, culling: Culling, ray: &Ray<f32>) -> TriangleHit {
        let mut best = NO_HIT;
        // The best as it was prepared, where the method orders what is equally near.
        let mut first = None;
        one_ray::<M, f32, D>(
            (),
            ray,
            &self.triangles,
            culling,
            #[inline(always)]
            |tested, met, hit| {
                if met {
                    let triangle = self.triangles.number(tested.triangle_place);
                    let other = TriangleHit { triangle, hit };
                    if const { M::INFO.claims.exact } {
                        let order = || match &first {
                            Some(first) => M::order(ray, tested.triangle, first),
                            None => Ordering::Equal,
                        };
                        if best.improve_by(other, order) {
                            first = Some(*tested.triangle);
                        }
                    } else {
                        best.improve(other);
                    }
                }
            },
        );
        best
    }
}

impl<M: Method> Tree for EveryTriangle<M> {
    fn closest(
        &self,
        _: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        self.trace(culling, rays, found);
    }

    fn any(&self, _: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        self.trace(culling, rays, found);
    }

    fn count(&self, ray: &Ray<f32>) -> Counted {
        let mut found = [None];
        self.trace(Culling::None, &[*ray], &mut found);
        Counted { found: found[0], nodes: 0, triangles: self.count }
    }

    fn candidates(&self, _: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
        for triangle in (0..).take(self.count) {
            visit(triangle);
        }
    }

    /// Of a tree without nodes.
    fn statistics(&self) -> Statistics {
        Statistics {
            builder: Builder::Linear,
            nodes: 0,
            blocks: 0,
            references: self.count,
            depth: 0,
            bytes: PreparedTriangles::<M, f32>::bytes_per_triangle() * self.count,
            cost: self.count as f64,
        }
    }
}
