//! A scene as the rasteriser paints it: objects in their places, and what shading asks of their triangles.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use trisect_core::Triangle;
use trisect_scene::{
    Camera, Color, Frame, Light, Material, PixelRays, Plane, Scene, Sphere, Texture,
};

use crate::blocks::{Blocks, Object};

/// What shading asks of an object's triangles.
pub(crate) struct Look {
    /// At the corners, of unit length: as the mesh has them, and in the world.
    own: Vec<[Vec3; 3]>,
    pub(crate) normals: Vec<[Vec3; 3]>,
    /// For textures; empty where there are none.
    pub(crate) coordinates: Vec<[Vec2; 3]>,
    pub(crate) materials: Vec<u32>,
}

impl Look {
    /// Turns the normals to where the object is, in the memory that they have.
    fn turn(&mut self, to_world: &Affine3A) {
        let matrix: Mat3A = to_world.matrix3.inverse().transpose();
        for (to, own) in self.normals.iter_mut().zip(&self.own) {
            *to = own.map(|normal| Vec3::from(matrix * Vec3A::from(normal)).normalize_or_zero());
        }
    }
}

/// A scene as the rasteriser paints it, in the scene's own [`Frame`]. Spheres are meshes here, and planes are
/// large squares.
pub struct Scenery {
    pub(crate) objects: Vec<Object>,
    pub(crate) looks: Vec<Look>,
    pub(crate) materials: Vec<Material>,
    pub(crate) textures: Vec<Texture>,
    pub(crate) lights: Vec<Light>,
    pub(crate) ambient: Color,
    pub(crate) sky: [Color; 2],
    frame: Frame,
    cameras: Vec<Camera>,
}

/// Parts of a sphere around and from pole to pole.
const PARTS: [usize; 2] = [64, 32];

/// Half the side of a square that stands for a plane, in the units of the frame.
const WIDE: f32 = 256.0;

impl Scenery {
    /// Of a scene, lit by the first of its lights, so many at most.
    pub fn new(scene: &Scene, lights: usize) -> Self {
        let frame = Frame::of(scene);
        let mut scenery = Self {
            objects: Vec::new(),
            looks: Vec::new(),
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
            lights: scene.lights.iter().take(lights).map(|light| frame.light(light)).collect(),
            ambient: scene.ambient,
            sky: [scene.background, scene.zenith],
            frame,
            cameras: scene.cameras.clone(),
        };
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh];
            let of_mesh = Frame::of_triangles(&mesh.triangles);
            let triangles: Vec<Triangle<f32>> = mesh
                .triangles
                .iter()
                .map(|triangle| {
                    let [a, b, c] =
                        triangle.corners().map(|corner| of_mesh.point(Vec3::from(corner)));
                    Triangle::new(a, b, c)
                })
                .collect();
            let flat =
                |triangle: &Triangle<f32>| [Vec3::from(triangle.normal()).normalize_or_zero(); 3];
            let normals = if instance.smooth && mesh.normals.len() == triangles.len() {
                mesh.normals.clone()
            } else {
                triangles.iter().map(flat).collect()
            };
            let material = |at: usize| instance.material.unwrap_or_else(|| mesh.materials[at]);
            let materials = (0..triangles.len()).map(|at| narrow(material(at))).collect();
            let place = frame.transform(&instance.to_world, of_mesh);
            scenery.add(&triangles, normals, mesh.coordinates.clone(), materials, place);
        }
        for sphere in &scene.spheres {
            scenery.add_sphere(&frame.sphere(sphere));
        }
        for plane in &scene.planes {
            scenery.add_plane(&frame.plane(plane), plane.axes(), frame.unit());
        }
        scenery
    }

    fn add(
        &mut self,
        triangles: &[Triangle<f32>],
        own: Vec<[Vec3; 3]>,
        coordinates: Vec<[Vec2; 3]>,
        materials: Vec<u32>,
        place: Affine3A,
    ) {
        let mut look = Look { normals: own.clone(), own, coordinates, materials };
        look.turn(&place);
        self.objects.push(Object::placed(Arc::new(Blocks::new(triangles)), place));
        self.looks.push(look);
    }

    fn add_sphere(&mut self, sphere: &Sphere) {
        let [around, down] = PARTS;
        let at = |i: usize, j: usize| {
            let (u, v) = (i as f32 / around as f32, j as f32 / down as f32);
            // As the renderer has it: the share of the way around y, and down from the pole.
            let (turn, tilt) = ((u - 0.5) * TAU, v * PI);
            let normal = Vec3::new(turn.cos() * tilt.sin(), tilt.cos(), turn.sin() * tilt.sin());
            (normal, Vec2::new(u, v))
        };
        let (mut triangles, mut normals, mut coordinates) = (vec![], vec![], vec![]);
        for (i, j) in (0..down).flat_map(|j| (0..around).map(move |i| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            for [a, b, c] in [[a, b, c], [a, c, d]] {
                let corner = |of: Vec3| sphere.center + of * sphere.radius;
                triangles.push(Triangle::new(corner(a.0), corner(b.0), corner(c.0)));
                normals.push([a.0, b.0, c.0]);
                coordinates.push([a.1, b.1, c.1]);
            }
        }
        let materials = vec![narrow(sphere.material); triangles.len()];
        self.add(&triangles, normals, coordinates, materials, Affine3A::IDENTITY);
    }

    fn add_plane(&mut self, plane: &Plane, [right, down]: [Vec3; 2], unit: f32) {
        let corner = |x: f32, y: f32| {
            let at = Vec2::new(x, y) * WIDE;
            (plane.point + right * at.x + down * at.y, at * unit)
        };
        let [a, b, c, d] =
            [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let [first, second] = [[a, b, c], [a, c, d]];
        let triangles = [first, second].map(|[a, b, c]| Triangle::new(a.0, b.0, c.0));
        let coordinates = [first, second].map(|corners| corners.map(|(_, at)| at)).to_vec();
        let (normals, materials) = (vec![[plane.normal; 3]; 2], vec![narrow(plane.material); 2]);
        self.add(&triangles, normals, coordinates, materials, Affine3A::IDENTITY);
    }

    /// The objects: instances of meshes first, in their order.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// How many triangles there are.
    pub fn triangles(&self) -> usize {
        self.objects.iter().map(|object| object.triangles().len()).sum()
    }

    /// Moves an object: to the frame, from that of its mesh. What is computed of its place is computed anew,
    /// and nothing else.
    ///
    /// # Panics
    /// When there is no such object.
    pub fn move_to(&mut self, object: usize, place: Affine3A) {
        if self.objects[object].move_to(place) {
            self.looks[object].turn(&place);
        }
    }

    /// The rays of one of the scene's cameras.
    ///
    /// # Panics
    /// When there is no such camera.
    pub fn rays(&self, camera: usize, size: [u32; 2]) -> PixelRays {
        PixelRays::new(self.frame.camera(&self.cameras[camera]), size)
    }
}

fn narrow(material: usize) -> u32 {
    u32::try_from(material).expect("materials are counted in u32")
}
