//! No tree at all: what the tracer is measured against.

use std::cmp::Ordering;

use trisect_core::{Hit, Ray, Triangle, Vec3};
use trisect_kernels::{PreparedTriangles, Tested, one_ray};
use trisect_method::{
    Culling, Deferred, Division, Early, ExactMethod, Method, Of, Place, Refine, TrueDivision,
    UnsuitableMesh,
};

use crate::bvh::builders::RefitError;
use crate::bvh::builders::settings::Builder;
use crate::bvh::wide::Statistics;
use crate::dispatch::{Tracing, assert_room};
use crate::hit::TriangleHit;
use crate::hits::{Crossings, NotExact, Verdict, upwards};
use crate::instances::Extent;
use crate::traverse::inspect::Counted;
use crate::tree::Tree;

/// No tree at all: every ray is tested against every triangle, one at a time, by the calling thread.
pub struct EveryTriangle<M: Method> {
    triangles: PreparedTriangles<M, f32>,
    count: usize,
    extent: Extent,
}

impl<M: Method> EveryTriangle<M> {
    /// Prepares the triangles, whose ids are their places in the slice.
    ///
    /// # Errors
    /// When the method cannot take the mesh.
    ///
    /// # Panics
    /// When there are more than `u32::MAX − 1` triangles.
    pub fn new(triangles: &[Triangle<f32>]) -> Result<Self, UnsuitableMesh> {
        let (count, extent) = (triangles.len(), Extent::of(triangles));
        Ok(Self { triangles: PreparedTriangles::new(triangles)?, count, extent })
    }

    fn all_of_ray(
        &self,
        culling: Culling,
        crossings: Crossings,
        ray: &Ray<f32>,
    ) -> Vec<TriangleHit> {
        let hits = Closest { triangles: &self.triangles, culling, ray };
        M::refine(All { hits, crossings })
    }

    fn closest_of(&self, culling: Culling, ray: &Ray<f32>) -> Option<TriangleHit> {
        let best = M::refine(Closest { triangles: &self.triangles, culling, ray });
        best.is_hit().then_some(best)
    }
}

/// The closest hit of a ray.
struct Closest<'a, M: Method> {
    triangles: &'a PreparedTriangles<M, f32>,
    culling: Culling,
    ray: &'a Ray<f32>,
}

impl<M: Method> Closest<'_, M> {
    /// Tests every triangle.
    #[inline(always)]
    fn each(&self, take: impl FnMut(&Of<M::Prepared, f32>, TriangleHit)) {
        // In the form that the tree uses.
        if const { M::INFO.forms.deferred() } {
            self.each_by::<Deferred<TrueDivision, true>>(take);
        } else {
            self.each_by::<Early<TrueDivision, true>>(take);
        }
    }

    #[inline(always)]
    fn each_by<D: Division>(&self, mut take: impl FnMut(&Of<M::Prepared, f32>, TriangleHit)) {
        let Self { triangles, culling, ray } = *self;
        one_ray::<M, f32, D>(
            (),
            ray,
            triangles,
            culling,
            #[inline(always)]
            |tested: Tested<'_, M, f32>, met: bool, hit: Hit<f32>| {
                if met {
                    let triangle = triangles.number(tested.triangle_place);
                    take(tested.triangle, TriangleHit { triangle, hit });
                }
            },
        );
    }
}

impl<M: Method> Refine<M> for Closest<'_, M> {
    type Output = TriangleHit;

    fn rounded(self) -> TriangleHit {
        let mut best = TriangleHit::NONE;
        self.each(
            #[inline(always)]
            |_, other| best.improve(other),
        );
        best
    }

    fn exact(self) -> TriangleHit
    where
        M: ExactMethod,
    {
        let mut best = TriangleHit::NONE;
        // The best as it was prepared.
        let mut first = None;
        self.each(
            #[inline(always)]
            |triangle, other| {
                let order = || match &first {
                    Some(first) => M::order(self.ray, triangle, first),
                    None => Ordering::Equal,
                };
                if best.improve_by(other, order) {
                    first = Some(*triangle);
                }
            },
        );
        best
    }
}

/// All hits of a ray, in order.
struct All<'a, M: Method> {
    hits: Closest<'a, M>,
    crossings: Crossings,
}

impl<M: Method> Refine<M> for All<'_, M> {
    type Output = Vec<TriangleHit>;

    fn rounded(self) -> Vec<TriangleHit> {
        let mut all = vec![];
        self.hits.each(
            #[inline(always)]
            |_, hit| all.push(hit),
        );
        all.sort_by(|a, b| a.order_by_t(b).then(a.triangle.cmp(&b.triangle)));
        all
    }

    fn exact(self) -> Vec<TriangleHit>
    where
        M: ExactMethod,
    {
        let ray = self.hits.ray;
        let mut all = vec![];
        self.hits.each(
            #[inline(always)]
            |triangle, hit| {
                if self.crossings == Crossings::Every || M::owns(ray, triangle) {
                    all.push((*triangle, hit));
                }
            },
        );
        all.sort_by(|(a, of_a), (b, of_b)| {
            M::order(ray, a, b).then(of_a.triangle.cmp(&of_b.triangle))
        });
        all.into_iter().map(|(_, hit)| hit).collect()
    }
}

/// Where a point is.
struct Locate<'a, M: Method> {
    of: &'a EveryTriangle<M>,
    point: Vec3<f32>,
}

impl<M: Method> Refine<M> for Locate<'_, M> {
    type Output = Result<Place, NotExact>;

    fn rounded(self) -> Self::Output {
        Err(NotExact)
    }

    fn exact(self) -> Self::Output
    where
        M: ExactMethod,
    {
        let Self { of, point } = self;
        if (0..of.count).any(|place| M::is_on(point, of.triangles.prepared(place))) {
            return Ok(Place::On);
        }
        let crossings = of.all_of_ray(Culling::None, Crossings::Owned, &upwards(point));
        let is_inside = crossings.len() % 2 == 1;
        Ok(if is_inside { Place::Inside } else { Place::Outside })
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
        assert_room(rays, found);
        for (ray, found) in rays.iter().zip(found) {
            *found = self.closest_of(culling, ray);
        }
    }

    fn any(&self, _: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        assert_room(rays, found);
        for (ray, found) in rays.iter().zip(found) {
            *found = self.closest_of(culling, ray).is_some();
        }
    }

    fn all(
        &self,
        _: Tracing,
        culling: Culling,
        crossings: Crossings,
        ray: &Ray<f32>,
        hits: &mut Vec<TriangleHit>,
    ) {
        hits.clear();
        hits.extend(self.all_of_ray(culling, crossings, ray));
    }

    fn count(&self, _: Tracing, culling: Culling, crossings: Crossings, ray: &Ray<f32>) -> u32 {
        #[allow(clippy::cast_possible_truncation, reason = "there are fewer triangles")]
        let count = self.all_of_ray(culling, crossings, ray).len() as u32;
        count
    }

    fn filtered(
        &self,
        _: Tracing,
        culling: Culling,
        ray: &Ray<f32>,
        program: &mut dyn FnMut(&TriangleHit) -> Verdict,
    ) -> Option<TriangleHit> {
        let all = self.all_of_ray(culling, Crossings::Every, ray);
        all.into_iter().find(|hit| program(hit) != Verdict::Ignore)
    }

    fn contains(&self, point: Vec3<f32>) -> Result<Place, NotExact> {
        M::refine(Locate { of: self, point })
    }

    fn inspect(&self, ray: &Ray<f32>) -> Counted {
        Counted { found: self.closest_of(Culling::None, ray), nodes: 0, triangles: self.count }
    }

    fn candidates(&self, _: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
        for triangle in (0..).take(self.count) {
            visit(triangle);
        }
    }

    fn refit(&mut self, triangles: &[Triangle<f32>]) -> Result<(), RefitError> {
        let (built, given) = (self.count, triangles.len());
        if built != given {
            return Err(RefitError::Count { built, given });
        }
        *self = Self::new(triangles)?;
        Ok(())
    }

    fn extent(&self) -> Extent {
        self.extent.clone()
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
