//! Where a ray hits: what programs read of it. What they do not read is not computed.

use glam::{Affine3A, Vec3, Vec3A};
use trisect_core::{Hit, Ray};
use trisect_tracer::TriangleHit;

use crate::graph::{GeometryId, MaterialId, NodeId};
use crate::primitive::{self, Primitive};
use crate::scene::Scene;
use crate::variables::{Value, Variable};

/// How far off a surface rays start that leave it, in shares of the largest coordinate of the point or of where the ray
/// came from: 64 units of roundoff, eight times what the rounding of a point and of a test on it takes. Needles and
/// transforms that hardly have an inverse may take more.
const OFF: f32 = 32.0 * f32::EPSILON;

/// Where a ray hits. Attributes are computed where they are read: a program that does not ask for a normal has none in
/// its code.
pub struct Place<'a, M> {
    pub(crate) scene: &'a Scene<M>,
    pub(crate) record: usize,
    pub(crate) ray: Ray<f32>,
    pub(crate) found: TriangleHit,
}

impl<M> Clone for Place<'_, M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Place<'_, M> {}

impl<'a, M> Place<'a, M> {
    #[inline]
    fn record(&self) -> &'a crate::commit::Record {
        &self.scene.resolved.records[self.record]
    }

    /// The ray, in the world.
    #[inline]
    pub fn ray(&self) -> &Ray<f32> {
        &self.ray
    }

    /// The direction of the ray.
    #[inline]
    pub fn direction(&self) -> Vec3 {
        self.ray.d.into()
    }

    /// Where along the ray, in lengths of its direction.
    #[inline]
    pub fn t(&self) -> f32 {
        self.found.hit.t
    }

    /// The numbers of the hit.
    #[inline]
    pub fn hit(&self) -> &Hit<f32> {
        &self.found.hit
    }

    /// The weights of a triangle's corners a, b and c.
    #[inline]
    pub fn weights(&self) -> [f32; 3] {
        primitive::weights(&self.found.hit)
    }

    /// The index of the shape in its geometry.
    #[inline]
    pub fn shape(&self) -> u32 {
        self.found.triangle - self.record().first
    }

    /// The number of the shape among those of all instances.
    #[inline]
    pub fn number(&self) -> u32 {
        self.found.triangle
    }

    /// The index of the instance among all, each counted wherever it is placed.
    #[inline]
    pub fn instance(&self) -> usize {
        self.record
    }

    /// The node of the instance.
    #[inline]
    pub fn node(&self) -> NodeId {
        self.record().node
    }

    /// The geometry.
    #[inline]
    pub fn geometry(&self) -> GeometryId {
        self.record().geometry
    }

    /// The material's id.
    #[inline]
    pub fn material_id(&self) -> MaterialId {
        self.record().material
    }

    /// The material.
    #[inline]
    pub fn material(&self) -> &'a M {
        &self.scene.graph.materials[self.record().material.at()]
    }

    /// The scene.
    #[inline]
    pub fn scene(&self) -> &'a Scene<M> {
        self.scene
    }

    /// The value of a variable at this instance.
    #[inline]
    pub fn get<T: Value>(&self, variable: Variable<T>) -> T {
        let count = self.scene.graph.variables.count();
        T::load(self.scene.resolved.values[self.record * count + variable.number])
    }

    /// From the space of the geometry to the world.
    #[inline]
    pub fn to_world(&self) -> &'a Affine3A {
        self.record().transform.to_world()
    }

    /// The ray in the space of the geometry: `t` is the same there.
    #[inline]
    pub fn ray_of_geometry(&self) -> Ray<f32> {
        self.record().transform.carry(&self.ray)
    }

    /// The point, in the world.
    #[inline(always)]
    pub fn point(&self) -> Vec3 {
        Vec3::from(self.ray.o) + self.direction() * self.t()
    }

    /// The normal of the front, of unit length, in the world.
    #[inline(always)]
    pub fn front(&self) -> Vec3 {
        let (record, hit) = (self.record(), &self.found.hit);
        let geometry = self.scene.graph.of(record.geometry);
        let shape = self.found.triangle - record.first;
        if record.transform.is_identity() {
            return geometry.normal(shape, &self.ray, hit).normalize_or_zero();
        }
        let own = geometry.normal(shape, &self.ray_of_geometry(), hit);
        let to_world = record.transform.to_object().matrix3.transpose();
        // Its own length may be out of range of the product.
        Vec3::from(to_world * Vec3A::from(own.normalize_or_zero())).normalize_or_zero()
    }

    /// The point and its normals, computed once for all that is asked of them.
    #[inline(always)]
    pub fn surface(&self) -> Surface {
        let (front, point) = (self.front(), self.point());
        let is_front = front.dot(self.direction()) <= 0.0;
        let normal = if is_front { front } else { -front };
        let reach = point.abs().max(Vec3::from(self.ray.o).abs()).max_element();
        Surface { point, front, normal, is_front, off: reach * OFF }
    }

    /// Whether the front was hit.
    #[inline]
    pub fn is_front(&self) -> bool {
        self.surface().is_front
    }

    /// The normal on the side that the ray came from, of unit length, in the world.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.surface().normal
    }

    /// Where a ray starts that leaves in a direction, see [`Surface::leave`].
    #[inline(always)]
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        self.surface().leave(direction)
    }

    /// What a hit of a primitive says beside its numbers; `None` where the shapes are not of that primitive, or are
    /// triangles in a tree that was [built elsewhere](crate::Geometry::triangles), whose
    /// [weights](Place::weights) are all there is.
    #[inline]
    pub fn attributes<P: Primitive>(&self) -> Option<P::Attributes> {
        let geometry = self.scene.graph.of(self.record().geometry);
        geometry.attributes::<P>(self.shape(), &self.ray_of_geometry(), &self.found.hit)
    }
}

/// A point of a surface in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The point.
    pub point: Vec3,
    /// The normal of the front, of unit length.
    pub front: Vec3,
    /// The same on the side that the ray came from.
    pub normal: Vec3,
    /// Whether that is the front.
    pub is_front: bool,
    /// How far off it rays start.
    off: f32,
}

impl Surface {
    /// Where a ray starts that leaves the surface in a direction: off it, on the side where the direction points.
    #[inline(always)]
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        self.point + self.front * self.off.copysign(self.front.dot(direction))
    }
}
