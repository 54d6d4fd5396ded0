//! What a tree over instances answers.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::sync::Arc;

use trisect_core::{Ray, Triangle, Vec3};
use trisect_method::{Culling, Place};

use super::room::Room;
use super::{Extent, HasTree, Instance, Instances, batch};
use crate::bvh::builders::RefitError;
use crate::bvh::wide::Statistics;
use crate::dispatch::Tracing;
use crate::hit::{MaybeHit, TriangleHit};
use crate::hits::{Crossings, NotExact, Verdict, upwards};
use crate::leaf::query::end_after;
use crate::query::Robust;
use crate::traverse::inspect::Counted;
use crate::tree::Tree;

impl<T: HasTree> Instance<T> {
    fn tree(&self) -> &dyn Tree {
        self.of.tree()
    }

    /// A hit, by its id among the triangles of all instances.
    pub(super) fn named(&self, hit: TriangleHit) -> TriangleHit {
        TriangleHit { triangle: self.first + hit.triangle, ..hit }
    }
}

/// The nearest hit so far of a ray.
#[derive(Clone, Copy)]
pub(super) struct Best(pub(super) TriangleHit);

impl Best {
    pub(super) const NONE: Self = Self(TriangleHit::NONE);

    /// Whether another hit, of another instance, is nearer, or as near and of an earlier one.
    pub(super) fn is_behind(&self, other: &TriangleHit) -> bool {
        let order = other.order_by_t(&self.0);
        !self.0.is_hit() || order.then(other.triangle.cmp(&self.0.triangle)).is_lt()
    }

    pub(super) fn take(&mut self, other: TriangleHit) {
        if self.is_behind(&other) {
            self.0 = other;
        }
    }

    /// Where the interval of a ray ends: it leaves all that is as near, as far as rounding tells.
    pub(super) fn end(&self, tmax: f32) -> f32 {
        if self.0.is_hit() { end_after::<Robust, f32>(self.0.hit.t, tmax) } else { tmax }
    }

    pub(super) fn found(self) -> Option<TriangleHit> {
        self.0.found()
    }
}

impl<T: HasTree> Tree for Instances<T> {
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        batch::closest(self, tracing, culling, rays, found);
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        batch::any(self, tracing, culling, rays, found);
    }

    fn closest_hit(&self, culling: Culling, ray: &Ray<f32>) -> MaybeHit {
        let mut best = Best::NONE;
        self.walk(Tracing::Single, ray, &mut |at| {
            let instance = &self.placed[at];
            let mut carried = instance.transform.carry(ray);
            carried.tmax = best.end(ray.tmax);
            if let Some(hit) = instance.tree().closest_hit(culling, &carried).found() {
                best.take(instance.named(hit));
            }
            best.end(ray.tmax)
        });
        best.found().into()
    }

    fn any_hit(&self, culling: Culling, ray: &Ray<f32>) -> bool {
        let mut is_hit = false;
        self.walk(Tracing::Single, ray, &mut |at| {
            let instance = &self.placed[at];
            is_hit = is_hit || instance.tree().any_hit(culling, &instance.transform.carry(ray));
            if is_hit { f32::NEG_INFINITY } else { ray.tmax }
        });
        is_hit
    }

    fn all(
        &self,
        tracing: Tracing,
        culling: Culling,
        crossings: Crossings,
        ray: &Ray<f32>,
        hits: &mut Vec<TriangleHit>,
    ) {
        hits.clear();
        Room::with(|Room { found, gathered, keys }| {
            self.walk(tracing, ray, &mut |at| {
                let instance = &self.placed[at];
                let carried = instance.transform.carry(ray);
                instance.tree().all(tracing, culling, crossings, &carried, found);
                for &hit in &*found {
                    #[allow(
                        clippy::cast_possible_truncation,
                        reason = "there are fewer triangles"
                    )]
                    keys.push((hit.hit.t, instance.first, gathered.len() as u32));
                    gathered.push(instance.named(hit));
                }
                ray.tmax
            });
            // Those of one instance keep their order, which may be finer than that of rounded numbers.
            keys.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
            hits.extend(keys.iter().map(|key| gathered[key.2 as usize]));
        });
    }

    fn count(
        &self,
        tracing: Tracing,
        culling: Culling,
        crossings: Crossings,
        ray: &Ray<f32>,
    ) -> u32 {
        let mut count = 0;
        self.walk(tracing, ray, &mut |at| {
            let Instance { of, transform, .. } = &self.placed[at];
            count += of.tree().count(tracing, culling, crossings, &transform.carry(ray));
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
        let (mut best, mut is_ended) = (Best::NONE, false);
        self.walk(tracing, ray, &mut |at| {
            // The walk goes on to what is left of a node whose other children it has met.
            if is_ended {
                return f32::NEG_INFINITY;
            }
            let instance = &self.placed[at];
            let mut carried = instance.transform.carry(ray);
            carried.tmax = best.end(ray.tmax);
            let mut offer = |hit: &TriangleHit| {
                let hit = instance.named(*hit);
                if !best.is_behind(&hit) {
                    return Verdict::Ignore;
                }
                let verdict = program(&hit);
                is_ended |= verdict == Verdict::End;
                verdict
            };
            if let Some(hit) = instance.tree().filtered(tracing, culling, &carried, &mut offer) {
                best.0 = instance.named(hit);
            }
            if is_ended { f32::NEG_INFINITY } else { best.end(ray.tmax) }
        });
        best.found()
    }

    /// Inside is what an odd number of instances has inside.
    fn contains(&self, point: Vec3<f32>) -> Result<Place, NotExact> {
        if !self.is_exact {
            return Err(NotExact);
        }
        // The instances whose boxes hold the point, which is where this ray begins and ends.
        let ray = upwards(point).with_interval(0.0, 0.0);
        let (mut is_on, mut is_inside) = (false, false);
        self.walk(Tracing::Single, &ray, &mut |at| {
            let Instance { of, transform, .. } = &self.placed[at];
            match of.tree().contains(transform.carry_point(point)) {
                Ok(Place::On) => is_on = true,
                Ok(Place::Inside) => is_inside = !is_inside,
                Ok(Place::Outside) | Err(NotExact) => {}
            }
            0.0
        });
        Ok(match (is_on, is_inside) {
            (true, _) => Place::On,
            (false, true) => Place::Inside,
            (false, false) => Place::Outside,
        })
    }

    fn inspect(&self, ray: &Ray<f32>) -> Counted {
        let (mut best, mut counted) = (Best::NONE, Counted::default());
        self.walk(Tracing::Plain, ray, &mut |at| {
            let instance = &self.placed[at];
            let mut carried = instance.transform.carry(ray);
            carried.tmax = best.end(ray.tmax);
            let below = instance.tree().inspect(&carried);
            counted.nodes += below.nodes;
            counted.triangles += below.triangles;
            if let Some(hit) = below.found {
                best.take(instance.named(hit));
            }
            best.end(ray.tmax)
        });
        Counted { found: best.found(), ..counted }
    }

    fn candidates(&self, ray: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
        let mut end = ray.tmax;
        self.walk(Tracing::Plain, ray, &mut |at| {
            let Instance { of, transform, first, .. } = &self.placed[at];
            let carried = Ray { tmax: end, ..transform.carry(ray) };
            of.tree().candidates(&carried, &mut |triangle| {
                end = visit(first + triangle);
                end
            });
            end
        });
    }

    /// # Errors
    /// Always: the triangles belong to what is placed.
    fn refit(&mut self, _: &[Triangle<f32>]) -> Result<(), RefitError> {
        Err(RefitError::Placed)
    }

    /// Of the top tree; its blocks and references are instances. The bytes are those of all trees, each counted once
    /// however often it is placed.
    fn statistics(&self) -> Statistics {
        let instances = self.top.origin.references;
        Statistics { bytes: self.bytes(&mut BTreeSet::new()), ..self.top.statistics(instances, 0) }
    }

    fn extent(&self) -> Extent {
        Extent {
            triangles: self
                .placed
                .last()
                .map_or(0, |last| last.first as usize + last.tree().extent().triangles),
            per_origin: f64::from(self.per_length),
            least_direction: f64::from(self.least_direction),
            levels: self.levels,
            ..Extent::of_tree(&self.top)
        }
    }

    fn bytes(&self, counted: &mut BTreeSet<usize>) -> usize {
        let own = self.top.statistics(0, size_of_val(&self.placed[..])).bytes;
        let shared = self.placed.iter().map(|Instance { of, .. }| {
            let is_new = counted.insert(Arc::as_ptr(of).addr());
            if is_new { of.tree().bytes(counted) } else { 0 }
        });
        own + shared.sum::<usize>()
    }
}
