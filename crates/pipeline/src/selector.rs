//! Selectors: a program chooses for each ray which of several children there is.

use std::collections::BTreeSet;
use std::sync::Arc;

use trisect_core::{Ray, Triangle, Vec3};
use trisect_method::{Culling, Place};
use trisect_tracer::{
    Counted, Crossings, Extent, Instances, MaybeHit, NotExact, RefitError, Statistics, Tracing,
    Tree, TriangleHit, Verdict,
};

use crate::commit::Placed;

/// Chooses one of several children for a ray: as the level of detail that its distance asks for.
pub trait Visit: Send + Sync + 'static {
    /// The index of the child; beyond the last one there is nothing for the ray. The ray is in the space of the
    /// selector. Asked more than once for a ray, it has to answer alike.
    fn visit(&self, ray: &Ray<f32>) -> usize;
}

impl<F: Fn(&Ray<f32>) -> usize + Send + Sync + 'static> Visit for F {
    fn visit(&self, ray: &Ray<f32>) -> usize {
        self(ray)
    }
}

/// Children of which each ray sees one, numbered one after another.
pub(crate) struct Selected {
    visit: Arc<dyn Visit>,
    /// Each with the number of its first triangle.
    children: Vec<(u32, Instances<Placed>)>,
}

impl Selected {
    pub(crate) fn new(visit: Arc<dyn Visit>, children: Vec<Instances<Placed>>) -> Self {
        let mut first = 0_u32;
        let children = children.into_iter().map(|child| {
            let own = first;
            // Where they are too many, what places them says so.
            first =
                first.saturating_add(u32::try_from(child.extent().triangles()).unwrap_or(u32::MAX));
            (own, child)
        });
        Self { visit, children: children.collect() }
    }

    fn of(&self, ray: &Ray<f32>) -> Option<&(u32, Instances<Placed>)> {
        self.children.get(self.visit.visit(ray))
    }

    /// Asks each child all of its rays at once.
    fn ask<X: Clone>(
        &self,
        rays: &[Ray<f32>],
        found: &mut [X],
        nothing: &X,
        of: impl Fn(&Instances<Placed>, &[Ray<f32>], &mut [X]),
        named: impl Fn(u32, X) -> X,
    ) {
        assert!(found.len() >= rays.len(), "each ray has room for its answer");
        let chosen: Vec<usize> = rays.iter().map(|ray| self.visit.visit(ray)).collect();
        found[..rays.len()].fill(nothing.clone());
        for (index, (first, child)) in self.children.iter().enumerate() {
            let which: Vec<usize> = (0..rays.len()).filter(|&at| chosen[at] == index).collect();
            let some: Vec<Ray<f32>> = which.iter().map(|&at| rays[at]).collect();
            let mut answers = vec![nothing.clone(); some.len()];
            of(child, &some, &mut answers);
            for (at, answer) in which.into_iter().zip(answers) {
                found[at] = named(*first, answer);
            }
        }
    }
}

/// A hit of a child, by its number among those of all.
fn named(first: u32, hit: TriangleHit) -> TriangleHit {
    TriangleHit { triangle: first + hit.triangle, ..hit }
}

impl Tree for Selected {
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        let of = |child: &Instances<Placed>, rays: &[Ray<f32>], found: &mut [_]| {
            child.closest(tracing, culling, rays, found);
        };
        self.ask(rays, found, &None, of, |first, hit| hit.map(|hit| named(first, hit)));
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        let of = |child: &Instances<Placed>, rays: &[Ray<f32>], found: &mut [bool]| {
            child.any(tracing, culling, rays, found);
        };
        self.ask(rays, found, &false, of, |_, is_hit| is_hit);
    }

    fn closest_hit(&self, culling: Culling, ray: &Ray<f32>) -> MaybeHit {
        let found = self.of(ray).and_then(|(first, child)| {
            child.closest_hit(culling, ray).found().map(|hit| named(*first, hit))
        });
        found.into()
    }

    fn any_hit(&self, culling: Culling, ray: &Ray<f32>) -> bool {
        self.of(ray).is_some_and(|(_, child)| child.any_hit(culling, ray))
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
        if let Some((first, child)) = self.of(ray) {
            child.all(tracing, culling, crossings, ray, hits);
            for hit in hits {
                *hit = named(*first, *hit);
            }
        }
    }

    fn count(
        &self,
        tracing: Tracing,
        culling: Culling,
        crossings: Crossings,
        ray: &Ray<f32>,
    ) -> u32 {
        self.of(ray).map_or(0, |(_, child)| child.count(tracing, culling, crossings, ray))
    }

    fn filtered(
        &self,
        tracing: Tracing,
        culling: Culling,
        ray: &Ray<f32>,
        program: &mut dyn FnMut(&TriangleHit) -> Verdict,
    ) -> Option<TriangleHit> {
        let (first, child) = self.of(ray)?;
        let mut program = |hit: &TriangleHit| program(&named(*first, *hit));
        child.filtered(tracing, culling, ray, &mut program).map(|hit| named(*first, hit))
    }

    /// # Errors
    /// Always: what there is depends on the ray.
    fn contains(&self, _: Vec3<f32>) -> Result<Place, NotExact> {
        Err(NotExact)
    }

    fn inspect(&self, ray: &Ray<f32>) -> Counted {
        let Some((first, child)) = self.of(ray) else { return Counted::default() };
        let counted = child.inspect(ray);
        Counted { found: counted.found.map(|hit| named(*first, hit)), ..counted }
    }

    fn candidates(&self, ray: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
        if let Some((first, child)) = self.of(ray) {
            child.candidates(ray, &mut |triangle| visit(first + triangle));
        }
    }

    /// # Errors
    /// Always: the triangles belong to what the children place.
    fn refit(&mut self, _: &[Triangle<f32>]) -> Result<(), RefitError> {
        Err(RefitError::Placed)
    }

    /// Of all children together; the depth is that of the deepest.
    fn statistics(&self) -> Statistics {
        let none = Statistics {
            builder: trisect_tracer::Builder::Binned,
            nodes: 0,
            blocks: 0,
            references: 0,
            depth: 0,
            bytes: 0,
            cost: 0.0,
        };
        self.children.iter().map(|(_, child)| child.statistics()).fold(none, |all, own| {
            Statistics {
                builder: own.builder,
                nodes: all.nodes + own.nodes,
                blocks: all.blocks + own.blocks,
                references: all.references + own.references,
                depth: all.depth.max(own.depth),
                bytes: all.bytes + own.bytes,
                cost: all.cost.max(own.cost),
            }
        })
    }

    fn extent(&self) -> Extent {
        Extent::of_all(self.children.iter().map(|(_, child)| child.extent()))
    }

    fn bytes(&self, counted: &mut BTreeSet<usize>) -> usize {
        self.children.iter().map(|(_, child)| child.bytes(counted)).sum()
    }
}
