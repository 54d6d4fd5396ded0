//! A scene that is being put together in f64, and moved to near 0 before it is rounded.

use glam::{DAffine3, DMat2, DMat3, DVec2, DVec3, Vec3};

use crate::camera::{Camera, Lens, length};
use crate::error::SceneProblem;
use crate::mesh::{FAR, Mesh, near_origin};
use crate::model::{Instance, Light, Plane, Scene, Sphere};

/// A scene whose instances and spheres are in f64 yet.
pub(crate) struct Draft {
    pub(crate) scene: Scene,
    /// Each instance's transform from its mesh as its file has it.
    places: Vec<DAffine3>,
    /// Each sphere's middle.
    centers: Vec<DVec3>,
    /// Where cameras and lights are.
    viewpoints: Vec<DVec3>,
    /// The diagonal of the box around all of these.
    reach: f64,
}

impl Draft {
    pub(crate) fn new() -> Self {
        Self {
            scene: Scene::empty(),
            places: Vec::new(),
            centers: Vec::new(),
            viewpoints: Vec::new(),
            reach: 0.0,
        }
    }

    /// Adds an instance; its transform is given apart.
    pub(crate) fn put(&mut self, instance: Instance, to_world: DAffine3) {
        self.scene.instances.push(instance);
        self.places.push(to_world);
    }

    /// Adds a mesh as it is.
    pub(crate) fn put_mesh(&mut self, mesh: Mesh) {
        let (number, smooth) = (self.scene.meshes.len(), !mesh.normals.is_empty());
        self.scene.meshes.push(mesh);
        self.put(Instance { mesh: number, smooth, ..Instance::default() }, DAffine3::IDENTITY);
    }

    /// Adds a sphere; its middle is given apart.
    pub(crate) fn put_sphere(&mut self, sphere: Sphere, center: DVec3) {
        self.scene.spheres.push(sphere);
        self.centers.push(center);
    }

    /// Makes known where a camera or a light will be.
    pub(crate) fn put_viewpoint(&mut self, at: DVec3) {
        self.viewpoints.push(at);
    }

    /// Moves all to near 0, if it is far from there, and rounds instances and spheres. What follows is put
    /// where [`local`](Draft::local) says.
    pub(crate) fn settle(&mut self) {
        let scene = &mut self.scene;
        let boxes: Vec<Option<[DVec3; 2]>> = scene.meshes.iter().map(box_of).collect();
        let mut bounds: Option<[DVec3; 2]> = None;
        let add = |bounds: &mut Option<[DVec3; 2]>, at: DVec3| {
            let [low, high] = bounds.unwrap_or([at; 2]);
            *bounds = Some([low.min(at), high.max(at)]);
        };
        for (instance, place) in scene.instances.iter().zip(&mut self.places) {
            let mesh = &scene.meshes[instance.mesh];
            place.translation += place.matrix3 * mesh.origin;
            if let Some([low, high]) = boxes[instance.mesh] {
                for i in 0..8 {
                    let pick =
                        |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
                    add(&mut bounds, place.transform_point3(DVec3::new(pick(0), pick(1), pick(2))));
                }
            }
        }
        for (sphere, center) in scene.spheres.iter().zip(&self.centers) {
            add(&mut bounds, center - DVec3::splat(sphere.radius.into()));
            add(&mut bounds, center + DVec3::splat(sphere.radius.into()));
        }
        let size = bounds.map_or(0.0, |[low, high]| low.distance(high));
        for &at in self.viewpoints.iter().filter(|at| at.is_finite()) {
            add(&mut bounds, at);
        }
        scene.origin = bounds.map_or(DVec3::ZERO, near_origin);
        self.reach = bounds.map_or(0.0, |[low, high]| low.distance(high));
        let mut moved = 0.0_f64;
        let rounded = |at: DVec3| {
            let near = at.as_vec3();
            let by = near.as_dvec3().distance(at);
            (near, by)
        };
        for (instance, place) in scene.instances.iter_mut().zip(&self.places) {
            let (translation, by) = rounded(place.translation - scene.origin);
            instance.to_world.matrix3 = place.matrix3.as_mat3().into();
            instance.to_world.translation = translation.into();
            let longest =
                |m: DMat3| m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length());
            let turned = longest(place.matrix3 - instance.to_world.matrix3.as_dmat3());
            let reach =
                boxes[instance.mesh].map_or(0.0, |[low, high]| low.abs().max(high.abs()).length());
            let of_mesh = scene.meshes[instance.mesh].rounding * longest(place.matrix3);
            moved = moved.max(by + turned * reach + of_mesh);
        }
        for (sphere, center) in scene.spheres.iter_mut().zip(&self.centers) {
            let (center, by) = rounded(center - scene.origin);
            sphere.center = center;
            moved = moved.max(by);
        }
        scene.rounding = if size > 0.0 { moved / size } else { 0.0 };
    }

    /// A position of the files, in the scene.
    pub(crate) fn local(&self, at: DVec3) -> Vec3 {
        (at - self.scene.origin).as_vec3()
    }

    /// Adds a plane; its point is given apart. Where the scene was moved away from the point, another of
    /// its points takes its place, from which the plane's texture is the same.
    pub(crate) fn put_plane(&mut self, plane: Plane, point: DVec3) {
        let mut point = point - self.scene.origin;
        if self.scene.origin != DVec3::ZERO && point.length() > FAR * self.reach {
            let normal = plane.normal.as_dvec3();
            let to_foot = normal * (point.dot(normal) / normal.length_squared()) - point;
            let texture = self.scene.materials[plane.material].texture;
            let by = texture.map_or(to_foot, |texture| {
                let scale = self.scene.textures[texture].scale.as_dvec2();
                let [right, down] = plane.axes().map(Vec3::as_dvec3);
                // Whole periods along each axis; the axes are rounded, so not quite at right angles.
                let axes = DMat2::from_cols(
                    DVec2::new(right.dot(right), down.dot(right)),
                    DVec2::new(right.dot(down), down.dot(down)),
                );
                let along = DVec2::new(to_foot.dot(right), to_foot.dot(down));
                let whole =
                    DVec2::select(scale.cmpeq(DVec2::ZERO), along, (along * scale).round() / scale);
                let by = axes.inverse() * whole;
                right * by.x + down * by.y
            });
            point += by - normal * (by.dot(normal) / normal.length_squared());
        }
        self.scene.planes.push(Plane { point: point.as_vec3(), ..plane });
    }

    /// The scene, with a camera and light where there are none.
    ///
    /// # Errors
    /// When the scene is so large that no camera in the range of f32 sees all of it.
    pub(crate) fn complete(self) -> Result<Scene, SceneProblem> {
        let mut scene = self.scene;
        if scene.cameras.is_empty() {
            let [low, high] = scene.bounds().unwrap_or([Vec3::NEG_ONE, Vec3::ONE]);
            let (middle, radius) = (low * 0.5 + high * 0.5, length(high * 0.5 - low * 0.5));
            let field_of_view = 40.0_f32.to_radians();
            let distance = radius / (field_of_view * 0.5).sin();
            let towards = Vec3::new(0.45, 0.35, 1.0).normalize();
            let (eye, lens) = (middle + towards * distance, Lens::Pinhole { field_of_view });
            // A single point is looked at from where it is.
            let camera = Camera::looking(eye, middle, Vec3::Y, lens)
                .or_else(|| Camera::towards(eye, -towards, Vec3::Y, lens));
            let camera = camera.filter(|camera| camera.eye.is_finite()).ok_or_else(|| {
                let what = "the scene is too large to be looked at";
                SceneProblem::faulty("scene", "camera", what, "make it smaller, or add a camera")
            })?;
            scene.cameras.push(camera);
        }
        if scene.lights.is_empty()
            && let Some(camera) = scene.cameras.first()
        {
            let direction = camera.forward - camera.up * 0.6 + camera.right * 0.4;
            let irradiance = Vec3::splat(2.4);
            scene.lights.push(Light::Directional { direction: direction.normalize(), irradiance });
            scene.ambient = Vec3::splat(0.15);
            scene.background = Vec3::new(0.75, 0.80, 0.86);
            scene.zenith = Vec3::new(0.30, 0.45, 0.70);
        }
        Ok(scene)
    }
}

/// The box around a mesh's triangles.
fn box_of(mesh: &Mesh) -> Option<[DVec3; 2]> {
    let corners = mesh.triangles.iter().flat_map(|triangle| triangle.corners());
    let bounds = corners.fold(None, |bounds, corner| {
        let corner = Vec3::from(corner);
        let [low, high] = bounds.unwrap_or([corner; 2]);
        Some([low.min(corner), high.max(corner)])
    });
    bounds.map(|bounds| bounds.map(Vec3::as_dvec3))
}
