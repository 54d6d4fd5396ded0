//! What is drawn: meshes of any number of triangles, scenes whose triangles the tracer has, and the frame of 2012.

use std::cell::RefCell;
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};
use trisect_catalog::{Builder, Entry};
use trisect_core::Triangle;
use trisect_raster::{Blocks, Object};
use trisect_render::{Stage, StageError};
use trisect_scene::{Camera, Instance, Lens, Light, Material, Mesh, Pixels, Scene, Texture};
use trisect_workloads::{Placement, Surface, bunny, crowd};

/// A mesh, and from where it is seen.
pub(super) struct Subject {
    pub(super) name: String,
    pub(super) triangles: Vec<Triangle<f32>>,
    pub(super) camera: Camera,
}

/// Meshes from a thousand triangles on: spheres, the bunny, and turned copies of it, so many each.
pub(super) fn meshes(copies: &[u16]) -> impl Iterator<Item = Subject> + '_ {
    let spheres = [3, 5].into_iter().map(|subdivisions| {
        let sphere = Surface::sphere(subdivisions);
        subject("sphere", sphere.triangles(&Placement::HERE))
    });
    let bunnies = copies.iter().map(|&count| {
        let bunnies = crowd(&bunny(), count).expect("bunnies are small");
        subject(&format!("{count} bunnies"), bunnies.triangles.to_vec())
    });
    let one = std::iter::once_with(|| subject("bunny", bunny().triangles.to_vec()));
    spheres.chain(one).chain(bunnies)
}

/// Seen from the front and a little above, so that it fills most of the picture.
fn subject(name: &str, triangles: Vec<Triangle<f32>>) -> Subject {
    let corners = || triangles.iter().flat_map(|t| t.corners().map(Vec3::from));
    let [low, high] = [Vec3::min, Vec3::max].map(|pick| corners().reduce(pick).unwrap_or_default());
    let (middle, size) = (0.5 * (low + high), (high - low).length());
    let lens = Lens::Pinhole { field_of_view: 0.7 };
    let eye = middle + Vec3::new(0.25, 0.3, 1.0).normalize() * size * 1.1;
    let camera = Camera::looking(eye, middle, Vec3::Y, lens).expect("it looks somewhere");
    Subject { name: name.to_owned(), triangles, camera }
}

/// A scene in trees of a method, and the triangles of each tree for the rasteriser.
///
/// # Errors
/// As [`Stage::new`].
pub fn staged(
    scene: Scene,
    entry: &Entry,
    builder: Builder,
) -> Result<(Stage, Vec<Arc<Blocks>>), StageError> {
    let blocks = RefCell::new(Vec::new());
    let stage = Stage::new(scene, |triangles| {
        let tree = entry.tree(triangles, builder)?;
        blocks.borrow_mut().push(Arc::new(Blocks::new(triangles)));
        Ok(tree)
    })?;
    Ok((stage, blocks.into_inner()))
}

/// The places of a scene as objects of the rasteriser, which sees their triangles by the tracer's numbers.
pub fn objects(stage: &Stage, blocks: &[Arc<Blocks>]) -> Vec<Object> {
    stage
        .placed()
        .map(|(number, transform)| Object::carried(Arc::clone(&blocks[number]), *transform))
        .collect()
}

/// The frame that Amiantov timed in 2012, as far as he describes it: three textured objects on a sixth of the
/// picture, and two lights.
pub(super) fn frame() -> Scene {
    let scene = Scene::shipped("scenes/textures.toml").expect("it is shipped");
    let ball = |subdivisions: u32| {
        let triangles: Vec<Triangle<f32>> =
            Surface::sphere(subdivisions).triangles(&Placement::HERE);
        let mut mesh = Mesh::of_triangles("ball", triangles);
        let around = |normal: Vec3| {
            let u = normal.z.atan2(normal.x) / std::f32::consts::TAU + 0.5;
            Vec2::new(u, normal.y.clamp(-1.0, 1.0).acos() / std::f32::consts::PI)
        };
        mesh.coordinates = mesh
            .normals
            .iter()
            .map(|normals| {
                let mut at = normals.map(around);
                // Where it closes.
                let most = at[0].x.max(at[1].x).max(at[2].x);
                for corner in &mut at {
                    corner.x += if corner.x < most - 0.5 { 1.0 } else { 0.0 };
                }
                at
            })
            .collect();
        mesh
    };
    let picture =
        scene.textures.iter().find(|texture| matches!(texture.pixels, Pixels::Picture { .. }));
    let texture =
        Texture { scale: Vec2::new(4.0, 2.0), ..picture.unwrap_or(&scene.textures[0]).clone() };
    let material = Material {
        texture: Some(0),
        specular: Vec3::splat(0.3),
        shininess: 24.0,
        diffuse: Vec3::splat(0.8),
        ..Material::default()
    };
    let instance = |mesh: usize, x: f32, turn: f32| Instance {
        mesh,
        to_world: Affine3A::from_rotation_translation(
            Quat::from_rotation_y(turn),
            Vec3::new(x, 0.0, 0.0),
        ),
        material: Some(0),
        smooth: true,
    };
    let lens = Lens::Pinhole { field_of_view: 0.75 };
    let eye = Vec3::new(0.5, 1.5, 12.0);
    let light = |position| Light::Point { position, intensity: Vec3::splat(400.0) };
    Scene {
        background: Vec3::splat(0.1),
        zenith: Vec3::splat(0.1),
        ambient: Vec3::splat(0.15),
        cameras: vec![Camera::looking(eye, Vec3::ZERO, Vec3::Y, lens).expect("it looks somewhere")],
        lights: vec![light(Vec3::new(8.0, 10.0, 12.0)), light(Vec3::new(-10.0, 6.0, 8.0))],
        materials: vec![material],
        textures: vec![texture],
        meshes: vec![ball(4), ball(3)],
        instances: vec![instance(0, 0.0, 0.0), instance(1, -5.0, 0.6), instance(1, 5.0, 1.9)],
        spheres: Vec::new(),
        planes: Vec::new(),
        ..scene
    }
}
