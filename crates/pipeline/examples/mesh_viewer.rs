//! A mesh viewer: five ways to shade, two cameras, samples that add up while nothing moves, exceptions in green, and a
//! ride around the mesh as a benchmark.
//!
//! `cargo run --release -p trisect-pipeline --example mesh_viewer [MESH] [FOLDER]` prints the times to load, to build and
//! to trace, and writes a picture of each way into the folder.

#[allow(unused, reason = "each demonstration asks for a part")]
mod common;

use std::f32::consts::TAU;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use common::{Camera, ray_to};
use glam::{Vec2, Vec3};
use trisect_core::{Ray, Triangle};
use trisect_mesh::{Bounds, Mesh};
use trisect_pipeline::random::{Random, cosine_about};
use trisect_pipeline::{
    Buffer, Builder, Entry, Exception, Graph, Launch, On, Place, RayType, Scene, Traces,
};

/// Ways to shade.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shade {
    /// Three lights, with shadows.
    Phong,
    /// How much of what is around is open.
    Occlusion,
    /// The normals, as colours.
    Normals,
    /// Phong, and light that comes over one other surface.
    Diffuse,
    /// Phong in ambient light that is shut out.
    Both,
}

const ALL: [Shade; 5] =
    [Shade::Phong, Shade::Occlusion, Shade::Normals, Shade::Diffuse, Shade::Both];

const SKY: Vec3 = Vec3::new(0.34, 0.55, 0.85);
const DIFFUSE: Vec3 = Vec3::splat(0.7);
const AMBIENT: f32 = 0.3;
/// From where light comes, and how much.
const LIGHTS: [(Vec3, f32); 3] = [
    (Vec3::new(0.6, 0.7, 0.4), 0.5),
    (Vec3::new(-0.7, 0.5, 0.5), 0.3),
    (Vec3::new(0.1, 0.4, -0.9), 0.2),
];

/// What the camera sees, and what is seen over a surface.
struct Sight;

impl RayType for Sight {
    /// The share that counts.
    type Payload = Vec3;
}

/// To a light, or to what is around.
struct Open;

impl RayType for Open {
    /// What arrives if nothing is in the way.
    type Payload = Vec3;
    const ANY: bool = true;
}

struct Viewer {
    shade: Shade,
    camera: Camera,
    size: [u32; 2],
    /// The number of the sample that is added to each pixel.
    sample: u32,
    /// How far ambient light is shut out.
    distance: f32,
}

impl Viewer {
    fn random(&self, [x, y, _]: [u32; 3]) -> Random {
        Random { seed: 1, pixel: y * self.size[0] + x, sample: self.sample }
    }

    /// Sends a ray that adds to the pixel if it gets away.
    fn look_around(&self, at: &Place<'_, ()>, weight: Vec3, on: &mut On<'_, Self>) {
        let [u, v, ..] = self.random(on.index()).four(1);
        let towards = cosine_about(at.normal(), u, v);
        on.send(Open, ray_to(at.leave(towards), towards, self.distance), weight);
    }

    fn light(at: &Place<'_, ()>, weight: Vec3, on: &mut On<'_, Self>) {
        let normal = at.normal();
        for (towards, strength) in LIGHTS {
            let towards = towards.normalize();
            let cosine = normal.dot(towards);
            if cosine > 0.0 {
                let half = (towards - at.direction()).normalize();
                let highlight = 0.3 * normal.dot(half).max(0.0).powi(40);
                let light = weight * (DIFFUSE * cosine + highlight) * strength;
                on.send(Open, Ray::new(at.leave(towards), towards), light);
            }
        }
    }
}

impl Entry for Viewer {
    type Material = ();
    type Rays = (Sight, Open);
    type Out = Vec3;
    type Append = ();
    const CATCHES: bool = true;

    fn generate(&self, index: [u32; 3], on: &mut On<'_, Self>) {
        let [u, v, ..] = self.random(index).four(0);
        let point = Vec2::new(index[0] as f32 + u, index[1] as f32 + v);
        on.send(Sight, self.camera.ray(point, self.size), Vec3::ONE);
    }

    fn exception(&self, _: Exception, out: &mut Vec3) {
        *out = Vec3::Y;
    }
}

impl Traces<Sight> for Viewer {
    fn closest_hit(&self, at: &Place<'_, ()>, weight: Vec3, on: &mut On<'_, Self>) {
        let is_first = on.round() == 0;
        match self.shade {
            Shade::Normals => *on.out() += (at.normal() + 1.0) * 0.5,
            Shade::Occlusion => self.look_around(at, weight, on),
            Shade::Phong => {
                *on.out() += weight * DIFFUSE * AMBIENT;
                Self::light(at, weight, on);
            }
            Shade::Both => {
                self.look_around(at, weight * DIFFUSE * AMBIENT, on);
                Self::light(at, weight, on);
            }
            Shade::Diffuse => {
                Self::light(at, weight, on);
                if is_first {
                    let [u, v, ..] = self.random(on.index()).four(1);
                    let towards = cosine_about(at.normal(), u, v);
                    on.send(Sight, Ray::new(at.leave(towards), towards), weight * DIFFUSE);
                }
            }
        }
    }

    fn miss(&self, _: &Ray<f32>, weight: Vec3, on: &mut On<'_, Self>) {
        *on.out() += weight * SKY;
    }
}

impl Traces<Open> for Viewer {
    fn miss(&self, _: &Ray<f32>, light: Vec3, on: &mut On<'_, Self>) {
        *on.out() += light;
    }
}

/// A mesh, ready to be seen.
struct Model {
    scene: Scene<()>,
    middle: Vec3,
    extent: f32,
}

impl Model {
    fn new(triangles: Vec<Triangle<f32>>) -> Result<Self> {
        let bounds = Bounds::of(&triangles).context("the mesh is empty")?;
        let mut graph = Graph::new();
        let mesh = graph.geometry(common::mesh(triangles, Builder::Binned));
        let material = graph.material(());
        let root = graph.instance(mesh, material);
        let (middle, extent) = (bounds.center().into(), bounds.diagonal());
        Ok(Self { scene: graph.commit(root)?, middle, extent })
    }

    /// From an angle around the mesh.
    fn viewer(&self, shade: Shade, turn: f32, size: [u32; 2], is_parallel: bool) -> Viewer {
        let away = Vec3::new((turn * TAU).sin(), 0.3, (turn * TAU).cos()) * self.extent;
        let eye = self.middle + away;
        let camera = if is_parallel {
            Camera::orthographic(eye, self.middle, self.extent)
        } else {
            Camera::pinhole(eye, self.middle, 45.0)
        };
        Viewer { shade, camera, size, sample: 0, distance: 0.3 * self.extent }
    }

    /// The mean of so many samples of each pixel, and how many rays there were.
    fn picture(&self, viewer: &mut Viewer, samples: u32, launch: &Launch<'_>) -> (Vec<Vec3>, u64) {
        let mut sum = Buffer::plane(viewer.size, Vec3::ZERO);
        let mut rays = 0;
        for sample in 0..samples {
            viewer.sample = sample;
            rays += self.scene.launch(viewer, launch, &mut sum).rays.iter().sum::<u64>();
        }
        (sum.cells().iter().map(|color| color / samples as f32).collect(), rays)
    }
}

fn main() -> Result<()> {
    let bunny = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/meshes/bunny.ply");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().map_or(bunny, String::as_str);
    let start = Instant::now();
    let triangles = Mesh::load(path)?.triangles.to_vec();
    println!("load   {:8.1} ms, {} triangles", milliseconds(start), triangles.len());
    let start = Instant::now();
    let model = Model::new(triangles)?;
    println!("build  {:8.1} ms", milliseconds(start));
    let size = [640, 480];
    for shade in ALL {
        // One sample while the camera moves, nine where it stands.
        let (start, mut rays, frames) = (Instant::now(), 0, 8_u8);
        for frame in 0..frames {
            let turn = f32::from(frame) / f32::from(frames);
            let mut viewer = model.viewer(shade, turn, size, false);
            rays += model.picture(&mut viewer, 1, &Launch::default()).1;
        }
        let time = start.elapsed().as_secs_f64();
        println!(
            "trace  {:8.1} ms a frame, {:6.1} Mrays/s, {shade:?}",
            time * 1e3 / f64::from(frames),
            rays as f64 / time * 1e-6
        );
        if let Some(folder) = arguments.get(1) {
            let mut viewer = model.viewer(shade, 0.1, size, false);
            let (pixels, _) = model.picture(&mut viewer, 9, &Launch::default());
            common::write(&Path::new(folder).join(format!("{shade:?}.png")), size, &pixels)?;
        }
    }
    Ok(())
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [40, 30];

    /// A ball above the ground.
    fn model() -> Model {
        let triangles = common::ball(2);
        let low = triangles.iter().flat_map(|t| t.corners()).fold(0.0, |low: f32, p| low.min(p.y));
        let all = triangles.into_iter().chain(common::ground(low, 2.0)).collect();
        Model::new(all).expect("there are triangles")
    }

    #[test]
    fn every_way_gives_the_same_picture_for_any_threads_and_tiles() {
        let model = model();
        let mut seen: Vec<Vec<Vec3>> = vec![];
        for shade in ALL {
            for is_parallel in [false, true] {
                let picture = |threads: usize, tile: u32| {
                    let launch = Launch { tile, ..Launch::default() };
                    let mut viewer = model.viewer(shade, 0.1, SIZE, is_parallel);
                    common::on_threads(threads, || model.picture(&mut viewer, 2, &launch))
                };
                let first = picture(1, 64);
                assert_eq!(first, picture(3, 7), "{shade:?} {is_parallel}");
                let (middle, corner) = (first.0[15 * 40 + 20], first.0[0]);
                assert_ne!(middle, corner, "{shade:?} {is_parallel}");
                assert!(!seen.contains(&first.0), "{shade:?} {is_parallel} looks like another");
                seen.push(first.0);
            }
        }
    }

    #[test]
    fn samples_add_up_to_less_noise() {
        let model = model();
        let picture = |samples| {
            let mut viewer = model.viewer(Shade::Occlusion, 0.1, SIZE, false);
            model.picture(&mut viewer, samples, &Launch::default()).0
        };
        let truth = picture(256);
        let off = |samples| -> f32 {
            picture(samples).iter().zip(&truth).map(|(a, b)| (*a - *b).length_squared()).sum()
        };
        let (one, many) = (off(1), off(16));
        // The variance falls with the number; both share their samples with the truth.
        assert!(many < one / 8.0 && many > 0.0, "{one} {many}");
    }

    #[test]
    fn exceptions_are_green() {
        let model = model();
        let mut viewer = model.viewer(Shade::Phong, 0.1, SIZE, false);
        viewer.camera.eye.x = f32::NAN;
        let (pixels, rays) = model.picture(&mut viewer, 1, &Launch::default());
        assert!(rays == 0 && pixels.iter().all(|pixel| *pixel == Vec3::Y));
    }
}
