//! Scenes of f64 that answer in f32, near their own origin.

use trisect_core::{Hit, Ray, Triangle, Vec3};
use trisect_method::{Culling, Place, UnsuitableMesh};
use trisect_tracer::{
    Builder, Counted, Crossings, Extent, Leaves, MaybeHit, NotExact, RefitError, Statistics,
    Tracing, Tree, TriangleHit, Verdict,
};

use crate::precision::Scenes as _;
use crate::trees::BuildTree;

/// A tree of f32 over triangles of f64, whose center is its origin.
pub(crate) struct Rounded {
    tree: Box<dyn Tree>,
    center: Vec3<f64>,
}

impl Rounded {
    /// See [`SceneOptions::build_rounded`](crate::SceneOptions::build_rounded).
    ///
    /// # Errors
    /// When the method cannot take the triangles.
    pub(crate) fn build(
        triangles: &[Triangle<f64>],
        build: BuildTree,
        builder: Builder,
    ) -> Result<Self, UnsuitableMesh> {
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in triangles.iter().flat_map(|triangle| triangle.corners()) {
            for (axis, x) in corner.to_array().into_iter().enumerate() {
                (min[axis], max[axis]) = (min[axis].min(x), max[axis].max(x));
            }
        }
        let center = [0, 1, 2].map(|axis| 0.5 * min[axis] + 0.5 * max[axis]);
        // Without triangles there is no center.
        let center = center.map(|x| if x.is_finite() { x } else { 0.0 }).into();
        let tree = build(&bring(triangles, center), builder, Leaves::default())?;
        Ok(Self { tree, center })
    }

    fn point(&self, point: Vec3<f64>) -> Vec3<f32> {
        rounded(point - self.center)
    }

    fn ray(&self, ray: &Ray<f64>) -> Ray<f32> {
        let Ray { o, d, tmin, tmax } = *ray;
        #[allow(clippy::cast_possible_truncation, reason = "rounds")]
        let (tmin, tmax) = (tmin as f32, tmax as f32);
        Ray { o: self.point(o), d: rounded(d), tmin, tmax }
    }

    fn rays(&self, rays: &[Ray<f64>]) -> Vec<Ray<f32>> {
        rays.iter().map(|ray| self.ray(ray)).collect()
    }
}

#[allow(clippy::cast_possible_truncation, reason = "rounds")]
fn rounded(v: Vec3<f64>) -> Vec3<f32> {
    v.map(|x| x as f32)
}

fn bring(triangles: &[Triangle<f64>], center: Vec3<f64>) -> Vec<Triangle<f32>> {
    let bring = |triangle: &Triangle<f64>| {
        let [a, b, c] = triangle.corners().map(|corner| rounded(corner - center));
        Triangle { a, b, c }
    };
    triangles.iter().map(bring).collect()
}

fn widened(TriangleHit { triangle, hit }: TriangleHit) -> TriangleHit<f64> {
    let [t, beta, gamma] = [hit.t, hit.beta, hit.gamma].map(f64::from);
    TriangleHit { triangle, hit: Hit { t, beta, gamma } }
}

impl Tree<f64> for Rounded {
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f64>],
        found: &mut [Option<TriangleHit<f64>>],
    ) {
        let mut in_f32 = vec![None; rays.len()];
        self.tree.closest(tracing, culling, &self.rays(rays), &mut in_f32);
        for (found, in_f32) in found.iter_mut().zip(in_f32) {
            *found = in_f32.map(widened);
        }
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f64>], found: &mut [bool]) {
        self.tree.any(tracing, culling, &self.rays(rays), found);
    }

    fn closest_hit(&self, culling: Culling, ray: &Ray<f64>) -> MaybeHit<f64> {
        self.tree.closest_hit(culling, &self.ray(ray)).found().map(widened).into()
    }

    fn any_hit(&self, culling: Culling, ray: &Ray<f64>) -> bool {
        self.tree.any_hit(culling, &self.ray(ray))
    }

    fn all(
        &self,
        tracing: Tracing,
        culling: Culling,
        crossings: Crossings,
        ray: &Ray<f64>,
        hits: &mut Vec<TriangleHit<f64>>,
    ) {
        f32::gathering(|found| {
            self.tree.all(tracing, culling, crossings, &self.ray(ray), found);
            hits.clear();
            hits.extend(found.iter().copied().map(widened));
        });
    }

    fn count(
        &self,
        tracing: Tracing,
        culling: Culling,
        crossings: Crossings,
        ray: &Ray<f64>,
    ) -> u32 {
        self.tree.count(tracing, culling, crossings, &self.ray(ray))
    }

    fn filtered(
        &self,
        tracing: Tracing,
        culling: Culling,
        ray: &Ray<f64>,
        program: &mut dyn FnMut(&TriangleHit<f64>) -> Verdict,
    ) -> Option<TriangleHit<f64>> {
        let mut of = |hit: &TriangleHit| program(&widened(*hit));
        self.tree.filtered(tracing, culling, &self.ray(ray), &mut of).map(widened)
    }

    fn contains(&self, point: Vec3<f64>) -> Result<Place, NotExact> {
        self.tree.contains(self.point(point))
    }

    fn inspect(&self, ray: &Ray<f64>) -> Counted<f64> {
        let Counted { found, nodes, triangles } = self.tree.inspect(&self.ray(ray));
        Counted { found: found.map(widened), nodes, triangles }
    }

    #[allow(clippy::cast_possible_truncation, reason = "rounds")]
    fn candidates(&self, ray: &Ray<f64>, visit: &mut dyn FnMut(u32) -> f64) {
        self.tree.candidates(&self.ray(ray), &mut |triangle| visit(triangle) as f32);
    }

    fn refit(&mut self, triangles: &[Triangle<f64>]) -> Result<(), RefitError> {
        self.tree.refit(&bring(triangles, self.center))
    }

    fn statistics(&self) -> Statistics {
        self.tree.statistics()
    }

    fn extent(&self) -> Extent {
        self.tree.extent()
    }
}
