//! What the camera's rays are to each tree: for those who look into the trees, not at the picture.

use glam::Vec2;
use trisect_core::Ray;
use trisect_method::Culling;
use trisect_scene::PixelRays;
use trisect_tracer::{Tracing, Transform, Tree, TriangleHit};

use crate::render::Eye;
use crate::settings::Settings;
use crate::stage::Stage;
use crate::wave::{nearest_simple, ray};

/// A ray as a tree sees it.
#[derive(Clone, Copy)]
pub struct Sight<'a> {
    /// The tree's number, in the order in which they were built.
    pub number: usize,
    /// The tree.
    pub tree: &'a dyn Tree,
    /// The ray in the space of the tree's triangles: where it meets one, its `t` is that of the ray that
    /// was carried there.
    pub ray: Ray<f32>,
}

impl Stage {
    /// The ray through the middle of a pixel and of the lens, its direction of unit length. It ends at the
    /// nearest sphere or plane. It is in the stage's own units: times [`unit`](Stage::unit), its `t` is a
    /// length of the world.
    ///
    /// # Panics
    /// When the scene has no such camera.
    pub fn primary(&self, settings: &Settings, pixel: [u32; 2]) -> Ray<f32> {
        let (o, d) = Eye::new(self, settings).ray(pixel, Vec2::splat(0.5), || Vec2::ZERO);
        let mut ray = ray(o, d, f32::INFINITY);
        nearest_simple(self, &mut ray);
        ray
    }

    /// The camera's rays through the pixels, in the stage's own units.
    ///
    /// # Panics
    /// When the scene has no such camera.
    pub fn pixel_rays(&self, settings: &Settings) -> PixelRays {
        PixelRays::new(self.frame.camera(&self.scene.cameras[settings.camera]), settings.size)
    }

    /// The tree of each place, by its number in the order in which they were built, and where it is. The triangles
    /// that hits name are numbered through all places, one after another.
    pub fn placed(&self) -> impl Iterator<Item = (usize, &Transform)> {
        self.all.instances().iter().map(|place| (place.of().number, place.transform()))
    }

    /// What each ray hits first among the triangles, in the stage's own units.
    ///
    /// # Panics
    /// When there are fewer places in `found` than rays.
    pub fn closest(&self, tracing: Tracing, rays: &[Ray<f32>], found: &mut [Option<TriangleHit>]) {
        self.all.closest(tracing, Culling::None, rays, found);
    }

    /// The trees that a ray may meet, one for each mesh in its place.
    pub fn sights(&self, ray: Ray<f32>) -> impl Iterator<Item = Sight<'_>> {
        self.all.sights(&ray).map(|(instance, ray)| {
            let group = self.all.instances()[instance].of();
            Sight { number: group.number, tree: &*group.tree, ray }
        })
    }
}
