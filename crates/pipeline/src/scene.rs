//! A graph that is ready for rays.

use trisect_core::Ray;
use trisect_method::Culling;
use trisect_tracer::{Instances, Tree, TriangleHit, Update};

use crate::commit::{Placed, Resolved};
use crate::geometry::Geometry;
use crate::graph::{GeometryId, Graph, MaterialId};
use crate::place::Place;
use crate::variables::{Scope, Value, Variable};

/// A graph that is ready for rays: trees over instances, and for each of them its geometry, its material, its place and the
/// values of all variables.
pub struct Scene<M> {
    pub(crate) graph: Graph<M>,
    pub(crate) resolved: Resolved,
}

impl<M> Scene<M> {
    /// The graph, to be changed and committed again. Trees are kept as far as they still hold.
    pub fn edit(self) -> Graph<M> {
        self.graph
    }

    /// What was done with the tree over instances when the graph was committed.
    pub fn update(&self) -> Update {
        self.resolved.update
    }

    /// A material.
    pub fn material(&self, material: MaterialId) -> &M {
        &self.graph.materials[material.at()]
    }

    /// A geometry.
    pub fn geometry(&self, geometry: GeometryId) -> &Geometry {
        self.graph.of(geometry)
    }

    /// How many instances there are, each counted wherever it is placed.
    pub fn instances(&self) -> usize {
        self.resolved.records.len()
    }

    /// The value of a variable that is set on the context; it is looked up.
    pub fn value<T: Value>(&self, variable: Variable<T>) -> Option<T> {
        self.graph.variables.resolve(variable.number, &[Scope::Context]).map(T::load)
    }

    /// The tree over all, for queries that no launch makes.
    pub fn tree(&self) -> &dyn Tree {
        self.top()
    }

    #[inline]
    pub(crate) fn top(&self) -> &Instances<Placed> {
        match &self.graph.built {
            Some(built) => &built.top,
            None => unreachable!("a scene has been committed"),
        }
    }

    /// Where a ray hits first, at once: what a program asks that cannot go on without it.
    pub fn closest(&self, culling: Culling, ray: &Ray<f32>) -> Option<Place<'_, M>> {
        let hit = self.top().closest_hit(culling, ray).found()?;
        Some(self.place(*ray, hit))
    }

    /// Whether a ray hits anything, at once.
    pub fn is_blocked(&self, culling: Culling, ray: &Ray<f32>) -> bool {
        self.top().any_hit(culling, ray)
    }

    /// What is known of a hit.
    #[inline(always)]
    pub(crate) fn place(&self, ray: Ray<f32>, found: TriangleHit) -> Place<'_, M> {
        // Those without shapes begin where the next one does, and own nothing.
        let records = &self.resolved.records;
        let record = match records.len() {
            1 => 0,
            _ => records.partition_point(|record| record.first <= found.triangle) - 1,
        };
        Place { scene: self, record, ray, found }
    }
}
