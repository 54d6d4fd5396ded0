//! Scenes made larger and moved.

use glam::Vec3A;
use trisect_scene::{Lens, Light, Scene, Vec3};

/// A power of two.
pub(crate) fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits((127 + exponent).cast_unsigned() << 23)
}

/// Where a scene's size is: in the transforms of its instances, or in its meshes, where these are placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Grows {
    Instances,
    Meshes,
}

/// The scene made larger by a power of two. No number is rounded.
pub(crate) fn scaled(scene: &Scene, exponent: i32, grows: Grows) -> Scene {
    let by = power_of_two(exponent);
    let mut scene = scene.clone();
    for instance in &mut scene.instances {
        instance.to_world.translation *= by;
        if grows == Grows::Instances {
            instance.to_world.matrix3 *= by;
        }
    }
    if grows == Grows::Meshes {
        for mesh in &mut scene.meshes {
            mesh.triangles.iter_mut().for_each(|triangle| *triangle = triangle.map(|x| x * by));
        }
    }
    for sphere in &mut scene.spheres {
        (sphere.center, sphere.radius) = (sphere.center * by, sphere.radius * by);
    }
    for plane in &mut scene.planes {
        plane.point *= by;
        // It repeats with the world's units; nothing else in these scenes has a plane's texture.
        if let Some(texture) = scene.materials[plane.material].texture {
            scene.textures[texture].scale /= by;
        }
    }
    for light in &mut scene.lights {
        match light {
            Light::Point { position, intensity } | Light::Spot { position, intensity, .. } => {
                (*position, *intensity) = (*position * by, *intensity * by * by);
            }
            Light::Directional { .. } => {}
        }
    }
    for camera in &mut scene.cameras {
        camera.eye *= by;
        match &mut camera.lens {
            Lens::Pinhole { .. } => {}
            Lens::Orthographic { height } => *height *= by,
            Lens::Thin { radius, focus, .. } => (*radius, *focus) = (*radius * by, *focus * by),
        }
    }
    scene
}

/// The scene moved: numbers are rounded where they are not multiples of what the distance leaves.
pub(crate) fn moved(scene: &Scene, by: Vec3) -> Scene {
    let mut scene = scene.clone();
    scene
        .instances
        .iter_mut()
        .for_each(|instance| instance.to_world.translation += Vec3A::from(by));
    scene.spheres.iter_mut().for_each(|sphere| sphere.center += by);
    scene.planes.iter_mut().for_each(|plane| plane.point += by);
    scene.cameras.iter_mut().for_each(|camera| camera.eye += by);
    for light in &mut scene.lights {
        if let Light::Point { position, .. } | Light::Spot { position, .. } = light {
            *position += by;
        }
    }
    scene
}
