//! The classes of rays that a scene is traced with.

use trisect_catalog::{Builder, Tracing};
use trisect_core::{Culling, Ray};
use trisect_workloads::{Light, Mesh, diffuse_bounce, occlusion, primary, random_through_box};

use super::reference;

/// Rays of one kind.
pub(super) struct Class {
    pub name: &'static str,
    /// Whether any hit is asked for instead of the closest.
    pub any: bool,
    pub rays: Vec<Ray<f32>>,
}

/// Camera rays, rays between random points, bounces and shadows; those that there are none of are left
/// out.
pub(super) fn classes(scene: &Mesh, pixels: usize, seed: u64) -> Vec<Class> {
    let tree = (reference().tree)(&scene.triangles, Builder::Binned);
    let Ok(tree) = tree else { return Vec::new() };
    let mut closest = |ray: &Ray<f32>| {
        let mut found = [None];
        tree.closest(Tracing::Plain, Culling::None, std::slice::from_ref(ray), &mut found);
        found[0].map(|found| (found.triangle as usize, found.hit))
    };
    let light = Light::above(&scene.bounds);
    let diffuse = diffuse_bounce(seed, scene, pixels, pixels, &mut closest);
    let shadow = occlusion(seed, scene, &light, pixels, pixels, &mut closest);
    let made = [
        ("primary", primary(scene, pixels, pixels), false),
        ("random", random_through_box(seed, scene, pixels * pixels), false),
        ("diffuse", diffuse, false),
        ("occlusion", shadow, true),
    ];
    made.into_iter()
        .map(|(name, workload, any)| Class { name, any, rays: workload.rays })
        .filter(|class| !class.rays.is_empty())
        .collect()
}
