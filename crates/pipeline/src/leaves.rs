//! A tree over shapes that are not triangles. Its boxes are those of the tracer; a shape is tested behind a call.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;
use trisect_core::{Ray, Triangle, Vec3 as Coordinates};
use trisect_method::{Culling, Place, UnsuitableMesh};
use trisect_tracer::{
    BoxTree, Builder, Counted, Crossings, Extent, MaybeHit, NotExact, RefitError, Statistics,
    Tracing, Tree, TriangleHit, Update, Verdict,
};

use crate::primitive::{Primitive, ShapeTree};

/// By how much of its largest coordinate a box is larger than the shape says: more than rounding takes in the shapes
/// that are here.
const WIDER: f32 = 16.0 * f32::EPSILON;

/// Rays that one thread takes at a time.
const CHUNK: usize = 256;

/// A tree over shapes. A shape counts as a triangle wherever the tracer numbers these.
pub struct Leaves<P: Primitive> {
    shapes: Arc<[P::Shape]>,
    boxes: BoxTree,
}

impl<P: Primitive> Leaves<P> {
    fn bounds(shapes: &[P::Shape]) -> Vec<[Coordinates<f32>; 2]> {
        let of = |shape: &P::Shape| {
            let [low, high] = P::bounds(shape);
            let margin = low.abs().max(high.abs()).max_element() * WIDER;
            [(low - margin).into(), (high + margin).into()]
        };
        shapes.iter().map(of).collect()
    }

    /// Offers each hit that a ray may have to `take`, near shapes first, until the end that it answers.
    fn each(
        &self,
        tracing: Tracing,
        culling: Culling,
        ray: &Ray<f32>,
        take: &mut dyn FnMut(TriangleHit) -> f32,
    ) {
        let mut end = ray.tmax;
        self.boxes.visit(tracing, ray, &mut |id| {
            let shape = &self.shapes[id];
            let within = Ray { tmax: end, ..*ray };
            P::cross(shape, &within, &mut |hit| {
                if hit.t >= ray.tmin && hit.t <= end && Self::sees(culling, shape, ray, &hit) {
                    #[allow(clippy::cast_possible_truncation, reason = "boxes are fewer")]
                    let triangle = id as u32;
                    end = take(TriangleHit { triangle, hit });
                }
            });
            end
        });
    }

    /// Whether the face is seen that a ray hits.
    #[inline]
    fn sees(
        culling: Culling,
        shape: &P::Shape,
        ray: &Ray<f32>,
        hit: &trisect_core::Hit<f32>,
    ) -> bool {
        let against = || Vec3::from(ray.d).dot(P::normal(shape, ray, hit));
        match culling {
            Culling::None => true,
            Culling::Back => against() < 0.0,
            Culling::Front => against() > 0.0,
        }
    }

    fn nearest(&self, tracing: Tracing, culling: Culling, ray: &Ray<f32>) -> Option<TriangleHit> {
        let mut best: Option<TriangleHit> = None;
        self.each(tracing, culling, ray, &mut |hit| {
            let best = best.get_or_insert(hit);
            if is_nearer(&hit, best) {
                *best = hit;
            }
            best.hit.t
        });
        best
    }

    fn is_hit(&self, tracing: Tracing, culling: Culling, ray: &Ray<f32>) -> bool {
        let mut is_hit = false;
        self.each(tracing, culling, ray, &mut |_| {
            is_hit = true;
            f32::NEG_INFINITY
        });
        is_hit
    }
}

impl<P: Primitive> ShapeTree<P::Shape> for Leaves<P> {
    /// The builder is the one for boxes, whatever is asked for.
    fn build(shapes: &Arc<[P::Shape]>, _: Builder) -> Result<Self, UnsuitableMesh> {
        Ok(Self { shapes: Arc::clone(shapes), boxes: BoxTree::new(&Self::bounds(shapes)) })
    }

    fn fit(&mut self, shapes: &Arc<[P::Shape]>) -> Result<Update, RefitError> {
        let (built, given) = (self.shapes.len(), shapes.len());
        if built != given {
            return Err(RefitError::Count { built, given });
        }
        self.shapes = Arc::clone(shapes);
        Ok(self.boxes.update(&Self::bounds(shapes)))
    }
}

/// Whether a hit comes before another: by `t`, then by the number of the shape.
fn is_nearer(hit: &TriangleHit, other: &TriangleHit) -> bool {
    (hit.hit.t, hit.triangle) < (other.hit.t, other.triangle)
}

/// Answers each ray, on the threads of the pool.
fn answer<X: Send>(rays: &[Ray<f32>], found: &mut [X], of: impl Fn(&Ray<f32>) -> X + Sync) {
    assert!(found.len() >= rays.len(), "each ray has room for its answer");
    if rays.len() <= CHUNK {
        return rays.iter().zip(found).for_each(|(ray, found)| *found = of(ray));
    }
    let parts = rays.par_chunks(CHUNK).zip(found.par_chunks_mut(CHUNK));
    parts.for_each(|(rays, found)| {
        rays.iter().zip(found).for_each(|(ray, found)| *found = of(ray));
    });
}

impl<P: Primitive> Tree for Leaves<P> {
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        answer(rays, found, |ray| self.nearest(tracing, culling, ray));
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        answer(rays, found, |ray| self.is_hit(tracing, culling, ray));
    }

    fn closest_hit(&self, culling: Culling, ray: &Ray<f32>) -> MaybeHit {
        self.nearest(Tracing::Single, culling, ray).into()
    }

    fn any_hit(&self, culling: Culling, ray: &Ray<f32>) -> bool {
        self.is_hit(Tracing::Single, culling, ray)
    }

    fn all(
        &self,
        tracing: Tracing,
        culling: Culling,
        _: Crossings,
        ray: &Ray<f32>,
        hits: &mut Vec<TriangleHit>,
    ) {
        hits.clear();
        self.each(tracing, culling, ray, &mut |hit| {
            hits.push(hit);
            ray.tmax
        });
        hits.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t).then(a.triangle.cmp(&b.triangle)));
    }

    fn count(&self, tracing: Tracing, culling: Culling, _: Crossings, ray: &Ray<f32>) -> u32 {
        let mut count = 0;
        self.each(tracing, culling, ray, &mut |_| {
            count += 1;
            ray.tmax
        });
        count
    }

    fn filtered(
        &self,
        tracing: Tracing,
        culling: Culling,
        ray: &Ray<f32>,
        program: &mut dyn FnMut(&TriangleHit) -> Verdict,
    ) -> Option<TriangleHit> {
        let (mut best, mut end): (Option<TriangleHit>, _) = (None, ray.tmax);
        self.each(tracing, culling, ray, &mut |hit| {
            let is_nearer = best.as_ref().is_none_or(|best| is_nearer(&hit, best));
            if end == f32::NEG_INFINITY || !is_nearer {
                return end;
            }
            match program(&hit) {
                Verdict::Ignore => {}
                Verdict::Accept => (best, end) = (Some(hit), hit.hit.t),
                Verdict::End => (best, end) = (Some(hit), f32::NEG_INFINITY),
            }
            end
        });
        best
    }

    /// # Errors
    /// Always: shapes are not crossed exactly.
    fn contains(&self, _: Coordinates<f32>) -> Result<Place, NotExact> {
        Err(NotExact)
    }

    fn inspect(&self, ray: &Ray<f32>) -> Counted {
        let mut shapes = 0;
        self.boxes.visit(Tracing::Plain, ray, &mut |_| {
            shapes += 1;
            ray.tmax
        });
        let found = self.nearest(Tracing::Plain, Culling::None, ray);
        Counted { found, nodes: 0, triangles: shapes }
    }

    fn candidates(&self, ray: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
        #[allow(clippy::cast_possible_truncation, reason = "boxes are fewer")]
        self.boxes.visit(Tracing::Plain, ray, &mut |id| visit(id as u32));
    }

    /// # Errors
    /// Always: the shapes are not triangles. [`ShapeTree::fit`] takes them.
    fn refit(&mut self, _: &[Triangle<f32>]) -> Result<(), RefitError> {
        Err(RefitError::Placed)
    }

    fn statistics(&self) -> Statistics {
        self.boxes.statistics()
    }

    fn extent(&self) -> Extent {
        self.boxes.extent()
    }

    fn bytes(&self, _: &mut BTreeSet<usize>) -> usize {
        self.statistics().bytes + size_of_val(&self.shapes[..])
    }
}
