//! A scene made ready: its triangles in trees, with what shading asks of each.
//!
//! Meshes that are seen once are carried to the world and share one tree; what is seen several times has
//! a tree of its own, and rays are carried to it. What is clear is apart from what casts shadows.
//!
//! All of it is in the scene's own [`Frame`], and what has a tree of its own in that of its mesh: so numbers
//! are about 1 whatever the scene's unit is and however far away it lies.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Affine3A, DVec3, Vec2, Vec3};
use trisect_core::Triangle;
use trisect_method::UnsuitableMesh;
use trisect_scene::{Camera, Frame, Instance, Light, Material, Plane, Scene, Sphere};
use trisect_tracer::{HasTree, InstanceError, Instances, Statistics, Transform, Tree};

use crate::offset;

/// A triangle's plane.
#[derive(Clone, Copy)]
pub(crate) struct Facet {
    /// Of unit length, towards the front.
    pub(crate) normal: Vec3,
    /// From the origin, along the normal.
    pub(crate) distance: f32,
    /// What the triangle takes of the [offset](crate::offset) of rays that leave it.
    pub(crate) offset: f32,
}

impl Facet {
    /// Of f64: the normal of a needle loses most of its digits otherwise.
    #[allow(clippy::cast_possible_truncation, reason = "rounds once")]
    fn of(triangle: &Triangle<f32>) -> Self {
        let [a, b, c] = corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        let distance = normal.as_dvec3().dot(a) as f32;
        Self { normal, distance, offset: offset::of_triangle(triangle) }
    }
}

/// A triangle's corners in f64, in which no product of them is out of range.
fn corners(triangle: &Triangle<f32>) -> [DVec3; 3] {
    triangle.corners().map(|corner| Vec3::from(corner).as_dvec3())
}

/// The weights of corners b and c at a point, by their gradients: so a method need not give them.
#[derive(Clone, Copy)]
pub(crate) struct Weights {
    a: Vec3,
    beta: Vec3,
    gamma: Vec3,
}

impl Weights {
    fn of(triangle: &Triangle<f32>) -> Self {
        let [a, b, c] = corners(triangle);
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v);
        let scale = 1.0 / normal.length_squared();
        let gradient = |of: DVec3| (of * scale).as_vec3();
        Self { a: a.as_vec3(), beta: gradient(v.cross(normal)), gamma: gradient(normal.cross(u)) }
    }

    #[inline]
    pub(crate) fn at(&self, point: Vec3) -> (f32, f32) {
        let from = point - self.a;
        (from.dot(self.beta), from.dot(self.gamma))
    }
}

/// What varies over a triangle: at corner a, and how it changes towards b and c.
#[derive(Clone, Copy)]
pub(crate) struct Varying<T> {
    a: T,
    b: T,
    c: T,
}

impl<T> Varying<T>
where
    T: Copy
        + std::ops::Sub<Output = T>
        + std::ops::Add<Output = T>
        + std::ops::Mul<f32, Output = T>,
{
    fn of([a, b, c]: [T; 3]) -> Self {
        Self { a, b: b - a, c: c - a }
    }

    #[inline]
    pub(crate) fn at(&self, (beta, gamma): (f32, f32)) -> T {
        self.a + self.b * beta + self.c * gamma
    }
}

/// Triangles in a tree.
pub(crate) struct Group {
    /// In the order in which they were built.
    pub(crate) number: usize,
    pub(crate) tree: Box<dyn Tree>,
    /// Of each triangle; apart from its plane, which not every picture asks for.
    pub(crate) materials: Vec<u32>,
    pub(crate) facets: Vec<Facet>,
    /// Empty where nothing varies over any triangle, as the next two may be.
    pub(crate) weights: Vec<Weights>,
    pub(crate) normals: Vec<Varying<Vec3>>,
    pub(crate) coordinates: Vec<Varying<Vec2>>,
}

impl HasTree for Group {
    fn tree(&self) -> &dyn Tree {
        &*self.tree
    }
}

/// A scene cannot be made ready.
#[derive(Clone, Debug, thiserror::Error)]
pub enum StageError {
    /// The method cannot take its triangles.
    #[error(transparent)]
    Unsuitable(#[from] UnsuitableMesh),
    /// Its instances are too many.
    #[error(transparent)]
    Instances(#[from] InstanceError),
}

/// A scene made ready for a method.
pub struct Stage {
    /// As it was given, in the world.
    pub(crate) scene: Scene,
    /// What all below is in.
    pub(crate) frame: Frame,
    pub(crate) spheres: Vec<Sphere>,
    pub(crate) planes: Vec<Plane>,
    lights: Vec<Light>,
    pub(crate) groups: Vec<Arc<Group>>,
    /// All groups in their places.
    pub(crate) all: Instances<Group>,
    /// Those that cast shadows, and those that are clear.
    pub(crate) solid: Instances<Group>,
    pub(crate) clear: Instances<Group>,
    /// Whether each material answers lights.
    pub(crate) lit: Vec<bool>,
    /// Of each plane's texture, in the world's units.
    pub(crate) plane_axes: Vec<[Vec3; 2]>,
    /// Whether each sphere, and each plane, casts shadows.
    pub(crate) casting: [Vec<bool>; 2],
}

/// What instances have in common that may share a tree.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Look {
    mesh: usize,
    material: Option<usize>,
    smooth: bool,
}

/// Triangles on their way into a tree.
#[derive(Default)]
struct Gathered {
    triangles: Vec<Triangle<f32>>,
    materials: Vec<u32>,
    normals: Vec<[Vec3; 3]>,
    coordinates: Vec<[Vec2; 3]>,
    smooth: bool,
    textured: bool,
}

impl Stage {
    /// Puts the triangles of a scene into trees, with what builds a tree over triangles; it is called for
    /// one tree after another, in the order of their numbers. It gets triangles in the stage's units, see
    /// [`unit`](Stage::unit), or in those of their mesh.
    ///
    /// # Errors
    /// When the method cannot take the triangles, or there are too many instances.
    ///
    /// # Panics
    /// When a number in the scene is out of range, which those of loaded scenes are not.
    pub fn new<B>(scene: Scene, build: B) -> Result<Self, StageError>
    where
        B: Fn(&[Triangle<f32>]) -> Result<Box<dyn Tree>, UnsuitableMesh>,
    {
        let mut looks: BTreeMap<Look, Vec<&Instance>> = BTreeMap::new();
        for instance in &scene.instances {
            let Instance { mesh, material, smooth, .. } = *instance;
            looks.entry(Look { mesh, material, smooth }).or_default().push(instance);
        }
        let frame = Frame::of(&scene);
        let mut groups: Vec<Arc<Group>> = Vec::new();
        let mut placed = [Vec::new(), Vec::new()];
        // Apart: what casts shadows, and what is clear.
        for (casts_shadow, placed) in [true, false].into_iter().zip(&mut placed) {
            let is_wanted = |material: &Material| material.is_clear() != casts_shadow;
            let mut world = Gathered::default();
            for (look, instances) in &looks {
                let of_mesh = Frame::of_triangles(&scene.meshes[look.mesh].triangles);
                let places = instances.iter().map(|of| frame.transform(&of.to_world, of_mesh));
                // What cannot be carried back is seen flat, where it is.
                let (shared, once): (Vec<_>, Vec<_>) =
                    places.partition(|place| instances.len() > 1 && Transform::new(*place).is_ok());
                for place in once {
                    world.gather(&scene, *look, of_mesh, &place, is_wanted);
                }
                if shared.is_empty() {
                    continue;
                }
                let mut own = Gathered::default();
                own.gather(&scene, *look, of_mesh, &Affine3A::IDENTITY, is_wanted);
                if !own.triangles.is_empty() {
                    let group = own.finish(groups.len(), &build)?;
                    placed.extend(shared.into_iter().map(|place| (Arc::clone(&group), place)));
                    groups.push(group);
                }
            }
            if !world.triangles.is_empty() {
                let group = world.finish(groups.len(), &build)?;
                placed.push((Arc::clone(&group), Affine3A::IDENTITY));
                groups.push(group);
            }
        }
        let all = Instances::new(placed.concat())?;
        let [solid, clear] = placed;
        let (solid, clear) = (Instances::new(solid)?, Instances::new(clear)?);
        let lit = |m: &Material| m.diffuse != Vec3::ZERO || m.specular != Vec3::ZERO;
        let lit = scene.materials.iter().map(lit).collect();
        let casts = |material: usize| !scene.materials[material].is_clear();
        let casting = [
            scene.spheres.iter().map(|sphere| casts(sphere.material)).collect(),
            scene.planes.iter().map(|plane| casts(plane.material)).collect(),
        ];
        let plane_axes =
            scene.planes.iter().map(|plane| plane.axes().map(|axis| axis * frame.unit())).collect();
        let spheres = scene.spheres.iter().map(|sphere| frame.sphere(sphere)).collect();
        let planes = scene.planes.iter().map(|plane| frame.plane(plane)).collect();
        let lights = scene.lights.iter().map(|light| frame.light(light)).collect();
        Ok(Self {
            scene,
            frame,
            spheres,
            planes,
            lights,
            groups,
            all,
            solid,
            clear,
            lit,
            plane_axes,
            casting,
        })
    }

    /// The world's length of 1 in the stage: of a `t` along the stage's [`primary`](Stage::primary) rays.
    pub fn unit(&self) -> f32 {
        self.frame.unit()
    }

    /// The scene, as it was given.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// One of the scene's cameras, to be moved; in the world.
    ///
    /// # Panics
    /// When there is no such camera.
    pub fn camera_mut(&mut self, number: usize) -> &mut Camera {
        &mut self.scene.cameras[number]
    }

    /// The first of the scene's lights, so many at most.
    pub(crate) fn lights(&self, most: usize) -> &[Light] {
        &self.lights[..most.min(self.lights.len())]
    }

    /// Facts about each tree.
    pub fn trees(&self) -> impl Iterator<Item = Statistics> + '_ {
        self.groups.iter().map(|group| group.tree.statistics())
    }

    /// Triangles in all trees; what several instances share counts once.
    pub fn triangles(&self) -> usize {
        self.groups.iter().map(|group| group.facets.len()).sum()
    }
}

impl Gathered {
    /// Adds those triangles of a mesh whose material is wanted, from the frame of the mesh to another.
    fn gather(
        &mut self,
        scene: &Scene,
        look: Look,
        of_mesh: Frame,
        to_other: &Affine3A,
        is_wanted: impl Fn(&Material) -> bool,
    ) {
        let mesh = &scene.meshes[look.mesh];
        // Of f64: the products of three of its numbers may be out of range.
        let matrix = to_other.as_daffine3().matrix3;
        let (normals, mirrored) = (matrix.inverse().transpose(), matrix.determinant() < 0.0);
        for (number, triangle) in mesh.triangles.iter().enumerate() {
            let material = look.material.unwrap_or_else(|| mesh.materials[number]);
            if !is_wanted(&scene.materials[material]) {
                continue;
            }
            let mut corners = triangle
                .corners()
                .map(|corner| to_other.transform_point3(of_mesh.point(corner.into())));
            let [a, b, c] = corners;
            let own = Facet::of(&Triangle::new(a, b, c)).normal;
            let mut at_corners = [if mirrored { -own } else { own }; 3];
            if let Some(smooth) = mesh.normals.get(number).filter(|_| look.smooth) {
                at_corners = smooth
                    .map(|n| (normals * n.as_dvec3()).try_normalize().map_or(own, DVec3::as_vec3));
                self.smooth = true;
            }
            let mut coordinates = mesh.coordinates.get(number).copied().unwrap_or_default();
            if mirrored {
                // A mirror turns front to back; the corners' order turns it again.
                corners.swap(1, 2);
                at_corners.swap(1, 2);
                coordinates.swap(1, 2);
            }
            let [a, b, c] = corners;
            self.triangles.push(Triangle::new(a, b, c));
            self.materials.push(u32::try_from(material).expect("materials are counted in u32"));
            self.normals.push(at_corners);
            self.textured |= scene.materials[material].texture.is_some();
            self.coordinates.push(coordinates);
        }
    }

    fn finish(
        self,
        number: usize,
        build: &impl Fn(&[Triangle<f32>]) -> Result<Box<dyn Tree>, UnsuitableMesh>,
    ) -> Result<Arc<Group>, UnsuitableMesh> {
        let tree = build(&self.triangles)?;
        let mut group = Group {
            number,
            tree,
            materials: self.materials,
            facets: self.triangles.iter().map(Facet::of).collect(),
            weights: Vec::new(),
            normals: Vec::new(),
            coordinates: Vec::new(),
        };
        if self.smooth || self.textured {
            group.weights = self.triangles.iter().map(Weights::of).collect();
        }
        if self.smooth {
            group.normals = self.normals.into_iter().map(Varying::of).collect();
        }
        if self.textured {
            group.coordinates = self.coordinates.into_iter().map(Varying::of).collect();
        }
        Ok(Arc::new(group))
    }
}
