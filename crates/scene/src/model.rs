//! What a scene is made of.

use glam::{Affine3A, DVec3, Vec3};
use trisect_mesh::Note;

use crate::camera::Camera;
use crate::error::UnknownCamera;
use crate::mesh::Mesh;
use crate::texture::Texture;

/// Pixels of a picture where a file says nothing of it.
pub(crate) const SIZE: [u32; 2] = [640, 480];

/// Linear red, green and blue: of a surface the share of light that it returns, of light its radiance.
pub type Color = Vec3;

/// How bright a colour is: Rec. ITU-R BT.709's weights of linear red, green and blue.
#[inline]
pub fn luminance(color: Color) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// A scene: what there is to see, what lights it, and from where it is seen. Numbers of materials,
/// textures and meshes are places in the lists here, and in range in every scene that was loaded.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Pixels across and down that a picture has unless it is asked for otherwise.
    pub size: [u32; 2],
    /// Radiance of what a ray meets that meets nothing, where it runs level or down.
    pub background: Color,
    /// The same where it runs straight up (+y); between, it changes with the direction's height.
    pub zenith: Color,
    /// Radiance that reaches every point from all sides: Whitted's stand-in for light that is reflected
    /// more than once. Not used where paths are traced.
    pub ambient: Color,
    /// At least one; the first is the one to look through unless another is asked for.
    pub cameras: Vec<Camera>,
    /// What shines from a point or a direction.
    pub lights: Vec<Light>,
    /// How surfaces return light.
    pub materials: Vec<Material>,
    /// Colours that vary over a surface.
    pub textures: Vec<Texture>,
    /// Triangles, which instances share.
    pub meshes: Vec<Mesh>,
    /// Meshes in their places.
    pub instances: Vec<Instance>,
    /// Spheres.
    pub spheres: Vec<Sphere>,
    /// Planes without end.
    pub planes: Vec<Plane>,
    /// What was subtracted from the positions that the files have: f32 is coarse far from 0. It is 0 where
    /// the scene is no further from 0 than some times its size.
    pub origin: DVec3,
    /// By how much the corner that moves most moves when it is rounded to f32, relative to the scene's
    /// size; 0 where f32 holds every position.
    pub rounding: f64,
    /// What the readers of its files passed over.
    pub notes: Vec<Note>,
}

impl Scene {
    /// A scene with nothing in it, not even a camera.
    pub(crate) fn empty() -> Self {
        Self {
            size: SIZE,
            background: Vec3::ZERO,
            zenith: Vec3::ZERO,
            ambient: Vec3::ZERO,
            cameras: Vec::new(),
            lights: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            meshes: Vec::new(),
            instances: Vec::new(),
            spheres: Vec::new(),
            planes: Vec::new(),
            origin: DVec3::ZERO,
            rounding: 0.0,
            notes: Vec::new(),
        }
    }

    /// The lowest and highest corner of the box around all instances and spheres; `None` where there is
    /// neither.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let corners = self.instances.iter().flat_map(|instance| {
            let triangles = self.meshes.get(instance.mesh).map(|mesh| &mesh.triangles);
            triangles.into_iter().flatten().flat_map(|triangle| {
                triangle.corners().map(|corner| instance.to_world.transform_point3(corner.into()))
            })
        });
        let spheres = self
            .spheres
            .iter()
            .flat_map(|s| [s.center - Vec3::splat(s.radius), s.center + Vec3::splat(s.radius)]);
        corners.chain(spheres).fold(None, |bounds, p| {
            let [low, high] = bounds.unwrap_or([p, p]);
            Some([low.min(p), high.max(p)])
        })
    }

    /// The camera of that name, or of that number from 1.
    ///
    /// # Errors
    /// When there is none; it says which there are.
    pub fn camera(&self, wanted: &str) -> Result<usize, UnknownCamera> {
        let named = self.cameras.iter().position(|camera| camera.name == wanted);
        named
            .or_else(|| wanted.parse().ok().and_then(|number: usize| number.checked_sub(1)))
            .filter(|number| *number < self.cameras.len())
            .ok_or_else(|| UnknownCamera {
                wanted: wanted.to_owned(),
                names: self.cameras.iter().map(|camera| camera.name.clone()).collect(),
            })
    }

    /// Radiance of what a ray of that direction, of unit length, meets that meets nothing.
    #[inline]
    pub fn sky(&self, direction: Vec3) -> Color {
        self.background.lerp(self.zenith, direction.y.clamp(0.0, 1.0))
    }
}

/// How a surface returns light: Lambert's part, Phong's part, a mirror's and that of clear glass, added.
/// That they return no more than they get is left to the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name that files know it by.
    pub name: String,
    /// Share of light that is scattered evenly (Lambert), 0 to 1.
    pub diffuse: Color,
    /// Share of a light's light in the highlight (Phong, as normalised by Lafortune and Willems 1994),
    /// 0 to 1.
    pub specular: Color,
    /// Phong's exponent, from 0; the larger, the smaller the highlight.
    pub shininess: f32,
    /// Share that is reflected as by a mirror, 0 to 1.
    pub reflection: Color,
    /// Share that enters, is refracted, or is reflected after Fresnel's equations, 0 to 1.
    pub transmission: Color,
    /// Index of refraction inside, relative to outside, above 0; 1.5 is glass.
    pub index_of_refraction: f32,
    /// Radiance that the surface gives off.
    pub emission: Color,
    /// The texture that `diffuse` is multiplied by.
    pub texture: Option<usize>,
}

impl Default for Material {
    /// Grey without gloss.
    fn default() -> Self {
        Self {
            name: String::new(),
            diffuse: Vec3::splat(0.7),
            specular: Vec3::ZERO,
            shininess: 32.0,
            reflection: Vec3::ZERO,
            transmission: Vec3::ZERO,
            index_of_refraction: 1.5,
            emission: Vec3::ZERO,
            texture: None,
        }
    }
}

impl Material {
    /// Whether light passes through. What is clear colours the light of lights, but does not bend it.
    pub fn is_clear(&self) -> bool {
        self.transmission != Vec3::ZERO
    }
}

/// A light without extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines to all sides; its light falls off with the square of the distance.
    Point {
        /// Where it is.
        position: Vec3,
        /// Radiant intensity: irradiance at distance 1 of a surface that faces it.
        intensity: Color,
    },
    /// A point that shines into a cone.
    Spot {
        /// Where it is.
        position: Vec3,
        /// Where it shines, of unit length.
        direction: Vec3,
        /// Radiant intensity inside the inner cone.
        intensity: Color,
        /// Cosine of the angle between the axis and where the light begins to fade.
        inner: f32,
        /// Cosine of the angle between the axis and where it has faded; below `inner`.
        outer: f32,
    },
    /// So far away that its light comes from one direction, equally strong everywhere.
    Directional {
        /// Where it shines, of unit length.
        direction: Vec3,
        /// Irradiance of a surface that faces it.
        irradiance: Color,
    },
}

/// A mesh in its place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instance {
    /// The mesh.
    pub mesh: usize,
    /// From the mesh's space to the world's; can be inverted.
    pub to_world: Affine3A,
    /// The material of all its triangles; the mesh's own where there is none.
    pub material: Option<usize>,
    /// Whether normals are interpolated between corners, where the mesh has such.
    pub smooth: bool,
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its middle.
    pub center: Vec3,
    /// Its radius, above 0.
    pub radius: f32,
    /// Its material.
    pub material: usize,
}

/// A plane without end. Its texture repeats with the world's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point of it.
    pub point: Vec3,
    /// Its normal, of unit length.
    pub normal: Vec3,
    /// Its material.
    pub material: usize,
}

impl Plane {
    /// The axes of coordinates on it, from its point, in the world's units; on a floor they are x and z.
    pub fn axes(&self) -> [Vec3; 2] {
        let right = if self.normal.y.abs() > 0.9 {
            Vec3::X.reject_from_normalized(self.normal).normalize()
        } else {
            Vec3::Y.cross(self.normal).normalize()
        };
        [right, right.cross(self.normal)]
    }
}
