//! Whitted's spheres: a thin shell of glass and a sphere of metal over a chequered parallelogram. Shapes that are no
//! triangles, glass that lets tinted light through to the shadow, and more samples where a pixel needs them.
//!
//! Whitted: An Improved Illumination Model for Shaded Display. Communications of the ACM 23(6), 1980.
//!
//! `cargo run --release -p trisect-pipeline --example spheres [PICTURE.png]`

#[allow(unused, reason = "each demonstration asks for a part")]
mod common;

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use common::{Camera, ray_to};
use glam::{Vec2, Vec3};
use trisect_core::Ray;
use trisect_pipeline::{
    Buffer, Builder, CommitError, Entry, Geometry, Graph, Launch, On, Parallelogram, Place,
    Primitive, RayType, Scene, Shell, Sphere, Traces, Verdict,
};

const SKY: Vec3 = Vec3::new(0.34, 0.55, 0.85);
const LIGHT: Vec3 = Vec3::new(4.0, 8.0, 4.0);
/// What glass lets through at each of its surfaces.
const TINT: Vec3 = Vec3::new(0.9, 0.97, 0.9);
const DEPTH: u32 = 8;
/// Colours may differ by so much, as the eye sees them, before a pixel is sampled again.
const CONTRAST: f32 = 0.08;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Material {
    Chequered,
    Metal,
    Glass,
}

struct Light;

impl RayType for Light {
    type Payload = Vec3;
}

struct Shadow;

impl RayType for Shadow {
    /// What is left of the light.
    type Payload = Vec3;
    const ANY: bool = true;
}

/// Sends a ray through each of some points of the picture.
struct Through<'a> {
    points: &'a [Vec2],
    camera: Camera,
    size: [u32; 2],
}

impl Entry for Through<'_> {
    type Material = Material;
    type Rays = (Light, Shadow);
    type Out = Vec3;
    type Append = ();
    const ROUNDS: u32 = DEPTH;

    fn generate(&self, [at, ..]: [u32; 3], on: &mut On<'_, Self>) {
        on.send(Light, self.camera.ray(self.points[at as usize], self.size), Vec3::ONE);
    }
}

impl Traces<Light> for Through<'_> {
    fn closest_hit(&self, at: &Place<'_, Material>, weight: Vec3, on: &mut On<'_, Self>) {
        let (normal, direction) = (at.normal(), at.direction());
        let mirrored = direction - normal * (2.0 * normal.dot(direction));
        match at.material() {
            Material::Chequered => {
                let squares = at.attributes::<Parallelogram>().unwrap_or_default() * 16.0;
                let is_dark = (squares.x.floor() + squares.y.floor()) % 2.0 == 0.0;
                let color = if is_dark { Vec3::new(0.8, 0.3, 0.05) } else { Vec3::splat(0.8) };
                *on.out() += weight * color * 0.2;
                light(at, normal, weight * color, on);
            }
            Material::Metal => {
                light(at, normal, weight * 0.2, on);
                on.send(Light, Ray::new(at.leave(mirrored), mirrored), weight * 0.7);
            }
            Material::Glass => {
                let ratio = if at.is_front() { 1.0 / 1.4 } else { 1.4 };
                let cosine = -normal.dot(direction);
                let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
                // Schlick's approximation; all is reflected beyond the critical angle.
                let share = if squared <= 0.0 { 1.0 } else { 0.03 + 0.97 * (1.0 - cosine).powi(5) };
                on.send(Light, Ray::new(at.leave(mirrored), mirrored), weight * share);
                if squared > 0.0 {
                    let through = direction * ratio + normal * (ratio * cosine - squared.sqrt());
                    let left = weight * TINT * (1.0 - share);
                    on.send(Light, Ray::new(at.leave(through), through), left);
                }
            }
        }
    }

    fn miss(&self, _: &Ray<f32>, weight: Vec3, on: &mut On<'_, Self>) {
        *on.out() += weight * SKY;
    }
}

/// Sends a ray to the light.
fn light(at: &Place<'_, Material>, normal: Vec3, color: Vec3, on: &mut On<'_, Through<'_>>) {
    let way = LIGHT - at.point();
    let (towards, distance) = (way.normalize(), way.length());
    let cosine = normal.dot(towards);
    if cosine > 0.0 {
        on.send(Shadow, ray_to(at.leave(towards), towards, distance), color * cosine);
    }
}

impl Traces<Shadow> for Through<'_> {
    const ANY_HIT: bool = true;

    /// Glass weakens the light, and all else ends it.
    fn any_hit(&self, at: &Place<'_, Material>, left: &mut Vec3) -> Verdict {
        if *at.material() == Material::Glass {
            *left *= TINT;
            return Verdict::Ignore;
        }
        Verdict::End
    }

    fn miss(&self, _: &Ray<f32>, left: Vec3, on: &mut On<'_, Self>) {
        *on.out() += left;
    }
}

fn scene() -> Result<Scene<Material>, CommitError> {
    let mut graph = Graph::new();
    let glass = Shell { center: Vec3::new(-1.2, 1.5, 1.0), inner: 0.96, outer: 1.0 };
    let metal = Sphere { center: Vec3::new(1.0, 1.0, -1.0), radius: 1.0 };
    let floor = Parallelogram {
        corner: Vec3::new(-8.0, 0.0, 8.0),
        u: Vec3::X * 16.0,
        v: Vec3::NEG_Z * 16.0,
    };
    let all = [
        add::<Shell>(&mut graph, glass, Material::Glass),
        add::<Sphere>(&mut graph, metal, Material::Metal),
        add::<Parallelogram>(&mut graph, floor, Material::Chequered),
    ];
    let root = graph.group(all);
    Ok(graph.commit(root)?)
}

fn add<P: Primitive>(
    graph: &mut Graph<Material>,
    shape: P::Shape,
    material: Material,
) -> trisect_pipeline::NodeId {
    let geometry = Geometry::of::<P>(vec![shape], Builder::Binned)
        .unwrap_or_else(|error| unreachable!("shapes take all shapes: {error}"));
    let (geometry, material) = (graph.geometry(geometry), graph.material(material));
    graph.instance(geometry, material)
}

/// The picture, and in how many pixels there were more samples.
fn picture(scene: &Scene<Material>, size: [u32; 2], launch: &Launch<'_>) -> (Vec<Vec3>, usize) {
    let camera = Camera::pinhole(Vec3::new(0.0, 3.0, 8.0), Vec3::new(0.0, 1.0, 0.0), 40.0);
    let trace = |points: &[Vec2]| {
        let count = u32::try_from(points.len()).unwrap_or(u32::MAX);
        let mut colors = Buffer::line(count, Vec3::ZERO);
        scene.launch(&Through { points, camera, size }, launch, &mut colors);
        colors
    };
    let grid = |[x, y]: [u32; 2], side: u8| {
        let corner = Vec2::new(x as f32, y as f32);
        let at = move |i: u8| (f32::from(i) + 0.5) / f32::from(side);
        (0..side).flat_map(move |j| (0..side).map(move |i| corner + Vec2::new(at(i), at(j))))
    };
    let pixels: Vec<[u32; 2]> =
        (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])).collect();
    // Two by two first; four by four where those differ.
    let few = trace(&pixels.iter().flat_map(|&at| grid(at, 2)).collect::<Vec<_>>());
    let few: Vec<&[Vec3]> = few.cells().chunks(4).collect();
    let rough: Vec<usize> = (0..pixels.len()).filter(|&at| differ(few[at])).collect();
    let more = trace(&rough.iter().flat_map(|&at| grid(pixels[at], 4)).collect::<Vec<_>>());
    let mean = |samples: &[Vec3]| samples.iter().sum::<Vec3>() / samples.len() as f32;
    let mut all: Vec<Vec3> = few.into_iter().map(mean).collect();
    for (at, samples) in rough.iter().zip(more.cells().chunks(16)) {
        all[*at] = mean(samples);
    }
    (all, rough.len())
}

fn differ(samples: &[Vec3]) -> bool {
    let seen = samples.iter().map(|color| color.clamp(Vec3::ZERO, Vec3::ONE).map(f32::sqrt));
    let (low, high) =
        seen.fold((Vec3::ONE, Vec3::ZERO), |(low, high), x| (low.min(x), high.max(x)));
    (high - low).max_element() > CONTRAST
}

fn main() -> Result<()> {
    let (scene, size) = (scene()?, [1024, 1024]);
    let start = Instant::now();
    let (pixels, rough) = picture(&scene, size, &Launch::default());
    let time = start.elapsed().as_secs_f64();
    println!("{:.1} ms, more samples in {rough} of {} pixels", time * 1e3, pixels.len());
    if let Some(path) = std::env::args().nth(1) {
        common::write(Path::new(&path), size, &pixels)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The colour at one point that is looked at from above.
    fn seen_at(scene: &Scene<Material>, point: Vec3) -> Vec3 {
        let size = [1, 1];
        let eye = point + Vec3::new(0.3, 0.4, 0.1);
        let camera = Camera::pinhole(eye, point, 1.0);
        let mut color = Buffer::line(1, Vec3::ZERO);
        let points = &[Vec2::splat(0.5)];
        scene.launch(&Through { points, camera, size }, &Launch::default(), &mut color);
        color[[0; 3]]
    }

    #[test]
    fn light_is_tinted_at_each_surface_of_the_shell() {
        let scene = scene().expect("it is placed");
        // On the floor, in the line through the light and the middle of the shell.
        let middle = Vec3::new(-1.2, 1.5, 1.0);
        let on_floor =
            |through: Vec3| through + (through - LIGHT) * (through.y / (LIGHT.y - through.y));
        let point = on_floor(middle);
        let lit = |weaker: Vec3| {
            let squares = (Vec2::new(point.x + 8.0, 8.0 - point.z) / 16.0) * 16.0;
            let is_dark = (squares.x.floor() + squares.y.floor()) % 2.0 == 0.0;
            let color = if is_dark { Vec3::new(0.8, 0.3, 0.05) } else { Vec3::splat(0.8) };
            color * 0.2 + color * (LIGHT - point).normalize().y * weaker
        };
        let seen = seen_at(&scene, point);
        let expected = lit(TINT * TINT * TINT * TINT);
        assert!((seen - expected).abs().max_element() < 1e-4, "{seen} {expected}");
        // Past the middle but in the glass alone: two surfaces.
        let along = (LIGHT - middle).normalize();
        let rim = on_floor(middle + along.any_orthonormal_vector() * 0.98);
        let through = seen_at(&scene, rim);
        assert!(through.max_element() > 0.0 && through != seen);
        // Under the metal there is shadow.
        let dark = seen_at(&scene, on_floor(Vec3::new(1.0, 1.0, -1.0)));
        assert!(dark.max_element() < 0.2, "{dark}");
    }

    #[test]
    fn pixels_that_differ_are_sampled_again_and_threads_change_nothing() {
        let scene = scene().expect("it is placed");
        let picture = |threads: usize, tile: u32| {
            let launch = Launch { tile, ..Launch::default() };
            common::on_threads(threads, || picture(&scene, [64, 64], &launch))
        };
        let (pixels, rough) = picture(1, 64);
        assert!(rough > 200 && rough < 64 * 64 / 2, "{rough}");
        assert_eq!((pixels, rough), picture(3, 5));
    }
}
