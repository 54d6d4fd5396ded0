//! The classes of rays that a scene is traced with.

use trisect_catalog::{Builder, Tracing};
use trisect_core::Ray;
use trisect_method::Culling;
use trisect_workloads::{Mesh, RayClass};

use crate::kernels::reference;

/// Rays of one class.
pub struct ClassOfRays {
    /// The name of the class.
    pub name: &'static str,
    /// Whether any hit is asked for instead of the closest.
    pub any: bool,
    /// The rays.
    pub rays: Vec<Ray<f32>>,
}

/// Rays of some classes through a scene; those that there are none of are left out. What a camera sees
/// is what Möller–Trumbore sees in plain arithmetic.
pub fn classes_of_rays(
    scene: &Mesh,
    pixels: usize,
    seed: u64,
    classes: &[RayClass],
) -> Vec<ClassOfRays> {
    // Quick to build, as it is used once.
    let tree = reference().tree(&scene.triangles, Builder::Binned);
    let Ok(tree) = tree else { return Vec::new() };
    let mut closest = |ray: &Ray<f32>| {
        let mut found = [None];
        tree.closest(Tracing::Plain, Culling::None, std::slice::from_ref(ray), &mut found);
        found[0].map(|found| (found.triangle as usize, found.hit))
    };
    classes
        .iter()
        .map(|class| ClassOfRays {
            name: class.name(),
            any: class.any_hit(),
            rays: class.rays(seed, scene, pixels, &mut closest),
        })
        .filter(|class| !class.rays.is_empty())
        .collect()
}
