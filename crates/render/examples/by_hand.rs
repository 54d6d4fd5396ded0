//! The renderer against a loop that is written by hand for one scene: a mesh in ambient light.
//!
//! `cargo run --release -p trisect-render --example by_hand [MESH]` makes both pictures in turn on one
//! thread, holds them to the same bits, and prints how much longer the renderer takes.

use std::error::Error;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use glam::{Vec2, Vec3};
use trisect_core::{Ray, Triangle};
use trisect_method::Culling;
use trisect_moller_trumbore::MollerTrumbore;
use trisect_render::{Image, Renderer, Settings, Stage, Watch};
use trisect_scene::Scene;
use trisect_tracer::{Builder, Bvh, Tracing, Tree};

const SIZE: [u32; 2] = [640, 480];

/// Pictures of each kind.
const ROUNDS: usize = 51;

/// Side of a tile, as the renderer has it, of so many rays that go together.
const TILE: u32 = 64;

fn build(triangles: &[Triangle<f32>]) -> Box<dyn Tree> {
    let tree = Bvh::<MollerTrumbore>::build(triangles, Builder::Spatial);
    Box::new(tree.expect("the method takes every mesh"))
}

/// What a loop by hand keeps from tile to tile.
#[derive(Default)]
struct ByHand {
    rays: Vec<Ray<f32>>,
    found: Vec<Option<trisect_tracer::TriangleHit>>,
}

impl ByHand {
    /// Camera rays, tile by tile: of each the ambient light of what it meets, or the sky.
    fn render(&mut self, scene: &Scene, tree: &dyn Tree) -> Image {
        let [width, height] = SIZE;
        // On the stack: nothing that is written can change it, and what is the same for a row is computed once.
        let camera = scene.cameras[0].clone();
        let half_height = camera.lens.half_height();
        let corner = Vec2::new(-(width as f32) / height as f32, 1.0);
        let step = 2.0 / height as f32;
        let mesh = &scene.meshes[0];
        let mut image = Image::black(SIZE);
        for top in (0..height).step_by(TILE as usize) {
            for left in (0..width).step_by(TILE as usize) {
                let rows = top..height.min(top + TILE);
                let columns = left..width.min(left + TILE);
                self.rays.clear();
                for y in rows.clone() {
                    for x in columns.clone() {
                        let middle = Vec2::new(x as f32, y as f32) + Vec2::splat(0.5);
                        let at = corner + middle * Vec2::new(step, -step);
                        let across =
                            camera.right * (at.x * half_height) + camera.up * (at.y * half_height);
                        let d = (camera.forward + across).normalize();
                        let (o, d) = (camera.eye.into(), d.into());
                        self.rays.push(Ray { o, d, tmin: 0.0, tmax: f32::INFINITY });
                    }
                }
                self.found.resize(self.rays.len(), None);
                tree.closest(Tracing::Single, Culling::None, &self.rays, &mut self.found);
                let mut seen = self.rays.iter().zip(&self.found);
                for y in rows {
                    for x in columns.clone() {
                        let (ray, found) = seen.next().expect("each pixel has its ray");
                        let color = match found {
                            None => scene.sky(ray.d.into()),
                            Some(found) => {
                                let number = mesh.materials[found.triangle as usize];
                                let material = &scene.materials[number];
                                material.emission + material.diffuse * scene.ambient
                            }
                        };
                        image.pixels[(y * width + x) as usize] = color;
                    }
                }
            }
        }
        image
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let bunny = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/meshes/bunny.ply");
    let path = std::env::args().nth(1).unwrap_or_else(|| bunny.to_owned());
    let mut scene = Scene::load(&path)?;
    for instance in &mut scene.instances {
        instance.smooth = false;
    }
    assert!(scene.ambient != Vec3::ZERO, "there is something to be seen");
    let tree = build(&scene.meshes[0].triangles);
    let stage = Stage::new(scene.clone(), |triangles| Ok(build(triangles)))?;
    let settings = Settings { lights: 0, depth: 0, ..Settings::new(SIZE) };
    let watch = Watch { stop: &AtomicBool::new(false), tile: &|| () };
    let mut renderer = Renderer::new(&stage);
    let mut by_hand = ByHand::default();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut ratios = Vec::new();
    for round in 0..=ROUNDS {
        let mut own = || -> Result<(Image, Duration), Box<dyn Error>> {
            let start = Instant::now();
            let image = pool.install(|| renderer.render(&settings, &watch))?;
            Ok((image, start.elapsed()))
        };
        let mut hand = || {
            let start = Instant::now();
            let image = pool.install(|| by_hand.render(&scene, &*tree));
            (image, start.elapsed())
        };
        // First the one, then the other, so that neither has the better place.
        let ((image, time), (expected, least)) = if round % 2 == 0 {
            let own = own()?;
            (own, hand())
        } else {
            let hand = hand();
            (own()?, hand)
        };
        if image != expected {
            return Err("the pictures differ".into());
        }
        // The first is to warm up.
        if round > 0 {
            ratios.push(time.as_secs_f64() / least.as_secs_f64());
        }
    }
    ratios.sort_by(f64::total_cmp);
    let at = |quarter: usize| (ratios[ratios.len() * quarter / 4] - 1.0) * 100.0;
    println!(
        "time of the renderer over that of a loop by hand: {:+.1} % ({:+.1} to {:+.1}), median and \
         quartiles of {ROUNDS} pairs",
        at(2),
        at(1),
        at(3)
    );
    Ok(())
}
