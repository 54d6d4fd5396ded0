//! Scenes of instances: scenes that are placed in another one, each any number of times.

use std::any::Any;
use std::sync::Arc;

use trisect_core::Vec3;
use trisect_tracer::{HasTree, Instances, Tracing, Tree, Update};

use crate::{Hit, InstanceError, Precision, Scene};

/// Where an instance is: the rows of the matrix from its space to that of the scene that it is placed in. The point
/// `p` is at `row·(p.x, p.y, p.z, 1)` along each axis. Any affine transform with an inverse will do: turned,
/// stretched unevenly, sheared, mirrored.
pub type Transform = [[f32; 4]; 3];

impl HasTree for Scene {
    fn tree(&self) -> &dyn Tree {
        &*self.tree
    }
}

fn affine(rows: &Transform) -> glam::Affine3A {
    let column = |k: usize| glam::Vec3::from([0, 1, 2].map(|row: usize| rows[row][k]));
    let matrix = glam::Mat3::from_cols(column(0), column(1), column(2));
    glam::Affine3A::from_mat3_translation(matrix, column(3))
}

impl Scene {
    /// A scene of scenes, each in its place: meshes, or scenes of instances in turn, which are shared and not copied.
    /// All queries work as on a mesh: the triangles are numbered as if each instance had its own, one instance after
    /// another, and [`Hit::path`] and [`Hit::in_mesh`] say which is which.
    ///
    /// A ray is carried to the space of each instance that it may meet: its origin and direction are multiplied by the
    /// inverse of the transform, which is computed in f64 and rounded once, and each of the results is rounded to f32
    /// (four times at most). `t` is the same in both spaces. *That* ray is tested there, exactly so by the exact method:
    /// no hit of a carried ray is lost or added, whichever boxes it meets. So two triangles of one instance let no
    /// ray through between them. Two that touch in different instances may, or may both be hit, as each of them sees
    /// a ray that was rounded on its own; where the transforms round nothing, as when they move by whole numbers that
    /// have room, they are as one mesh. Of hits with the same rounded `t` in several instances the first instance's is
    /// taken for the nearest.
    ///
    /// The front of a triangle stays the front in an instance that is mirrored, though its corners run clockwise there.
    /// [`contains`](Scene::contains) takes instances that are closed, each for itself: inside is what an odd number of
    /// them has inside.
    ///
    /// # Errors
    /// When a transform is not finite or is singular, when there are 2³² triangles or more, those of each instance
    /// counted, or more than sixteen levels of instances. The message names the instance.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use trisect::{Ray, Scene};
    ///
    /// let triangle = Arc::new(Scene::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?);
    /// let scene = Scene::instances(&[
    ///     (Arc::clone(&triangle), [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
    ///     (triangle, [[2.0, 0.0, 0.0, 5.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -3.0]]),
    /// ])?;
    /// let hit = scene.first(&Ray::new([5.5, 0.25, 1.0], [0.0, 0.0, -1.0])).ok_or("it is above the second")?;
    /// assert_eq!((hit.t, hit.triangle), (4.0, 1));
    /// assert_eq!((hit.path(&scene).collect::<Vec<_>>(), hit.in_mesh(&scene).1), (vec![1], 0));
    /// assert_eq!(hit.point(&scene), [5.5, 0.25, -3.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn instances(instances: &[(Arc<Self>, Transform)]) -> Result<Self, InstanceError> {
        let placed = instances.iter().map(|(of, at)| (Arc::clone(of), affine(at)));
        let tree = Instances::new(placed)?;
        // As single rays do, where any of them does.
        let is_single = instances.iter().any(|(of, _)| of.batches != Tracing::Packets);
        let batches = if is_single { Tracing::Single } else { Tracing::Packets };
        Ok(Self {
            tree: Box::new(tree),
            triangles: vec![],
            faces: None,
            vertices: 0,
            notes: vec![],
            batches,
            anew: None,
            built: 0.0,
        })
    }

    /// Moves an instance: the tree over the instances is fitted to their places, or built anew by the same rule as
    /// in [`update`](Scene::update); what is placed stays as it is.
    ///
    /// # Errors
    /// When there is no such instance, or its transform is not finite or is singular; nothing has moved then.
    pub fn set_transform(
        &mut self,
        instance: usize,
        transform: &Transform,
    ) -> Result<Update, InstanceError> {
        match self.placed_mut() {
            Some(instances) => instances.set_transform(instance, affine(transform)),
            None => Err(InstanceError::NoInstance { instance, instances: 0 }),
        }
    }

    /// Moves all instances, in the time that moving one takes.
    ///
    /// # Errors
    /// When there are not as many transforms as instances, or one of them is not finite or is singular; nothing has
    /// moved then.
    pub fn set_transforms(&mut self, transforms: &[Transform]) -> Result<Update, InstanceError> {
        match self.placed_mut() {
            Some(instances) => instances.set_transforms(transforms.iter().map(affine)),
            None => Err(InstanceError::Count { instances: 0, given: transforms.len() }),
        }
    }

    fn placed_mut(&mut self) -> Option<&mut Instances<Self>> {
        let tree: &mut dyn Any = &mut *self.tree;
        tree.downcast_mut()
    }
}

impl<P: Precision> Scene<P> {
    /// What is placed in it, where it is a scene of instances.
    fn placed(&self) -> Option<&Instances<Scene>> {
        let tree: &dyn Any = &*self.tree;
        tree.downcast_ref()
    }

    /// The corners of a triangle where it is now, in f64.
    pub(crate) fn corners(&self, triangle: u32) -> [Vec3<f64>; 3] {
        match self.placed() {
            None => self.triangles[triangle as usize].corners().map(|corner| corner.map(P::to_f64)),
            Some(instances) => {
                let (at, own) = instances.locate(triangle);
                let instance = &instances.instances()[at];
                let to_world = instance.transform().to_world().as_daffine3();
                let corners = instance.of().corners(own);
                corners.map(|corner| to_world.transform_point3(corner.into()).into())
            }
        }
    }

    /// Whether the front of a triangle is where its corners run clockwise.
    pub(crate) fn is_mirrored(&self, triangle: u32) -> bool {
        match self.placed() {
            None => false,
            Some(instances) => {
                let (at, own) = instances.locate(triangle);
                let instance = &instances.instances()[at];
                instance.transform().is_mirrored() != instance.of().is_mirrored(own)
            }
        }
    }
}

/// From a scene to the mesh that a triangle is in, instance by instance.
struct Way<'a> {
    scene: &'a Scene,
    triangle: u32,
}

impl Iterator for Way<'_> {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        let instances = self.scene.placed()?;
        let (at, own) = instances.locate(self.triangle);
        *self = Self { scene: instances.instances()[at].of(), triangle: own };
        Some(at)
    }
}

impl Hit {
    /// The instances that the triangle is in, by their indices, the outermost first: none where the scene is a mesh.
    ///
    /// # Panics
    /// When the scene has no such triangle.
    pub fn path<'a>(&self, scene: &'a Scene) -> impl Iterator<Item = usize> + use<'a> {
        Way { scene, triangle: self.triangle }
    }

    /// The scene of a mesh that the triangle is in, and which one it is there: the scene itself where that is a mesh.
    ///
    /// # Panics
    /// When the scene has no such triangle.
    pub fn in_mesh<'a>(&self, scene: &'a Scene) -> (&'a Scene, u32) {
        let mut way = Way { scene, triangle: self.triangle };
        way.by_ref().for_each(|_| ());
        (way.scene, way.triangle)
    }
}
