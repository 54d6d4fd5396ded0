//! A path tracer over a trait of materials: sample, evaluate, density. Light comes from the sky and from a lamp, which is
//! aimed at as well as met by chance, each weighted by how likely the other was.
//!
//! Kajiya: The Rendering Equation. SIGGRAPH 1986. Veach, Guibas: Optimally Combining Sampling Techniques. SIGGRAPH 1995.
//!
//! `cargo run --release -p trisect-pipeline --example paths [PICTURE.png] [SAMPLES]`

#[allow(unused, reason = "each demonstration asks for a part")]
pub(crate) mod common;

use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use common::{Camera, ray_to};
use glam::{Vec2, Vec3};
use trisect_core::Ray;
use trisect_pipeline::random::{Random, cosine_about};
use trisect_pipeline::{
    Buffer, Builder, CommitError, Entry, Geometry, Graph, Launch, On, Parallelogram, Place,
    RayType, Scene, Sphere, Traces,
};

/// How a surface scatters light. Directions have unit length and point away from the surface; the normal is that of the
/// side that is seen, bent where there is a normal map.
pub(crate) trait Bsdf: Send + Sync {
    /// The light that is scattered from one direction to the other, per solid angle, times the cosine.
    fn evaluate(&self, local: &Local, from: Vec3) -> Vec3;
    /// How likely a direction is sampled, per solid angle.
    fn density(&self, local: &Local, from: Vec3) -> f32;
    /// A direction by chance, from two numbers below 1.
    fn sample(&self, local: &Local, chance: [f32; 2]) -> Vec3;
    /// What the surface gives off.
    fn emission(&self) -> Vec3 {
        Vec3::ZERO
    }
    /// What bends the normal, by coordinates on the surface.
    fn normal_map(&self, _at: Vec2) -> Vec2 {
        Vec2::ZERO
    }
}

/// Where light is scattered.
pub(crate) struct Local {
    pub(crate) normal: Vec3,
    /// To where light goes.
    pub(crate) to: Vec3,
    /// Coordinates on the surface.
    pub(crate) at: Vec2,
}

/// Lambert's: the same in all directions.
pub(crate) struct Lambert(pub(crate) Vec3);

impl Bsdf for Lambert {
    fn evaluate(&self, local: &Local, from: Vec3) -> Vec3 {
        self.0 * (local.normal.dot(from).max(0.0) * FRAC_1_PI)
    }

    fn density(&self, local: &Local, from: Vec3) -> f32 {
        local.normal.dot(from).max(0.0) * FRAC_1_PI
    }

    fn sample(&self, local: &Local, [u, v]: [f32; 2]) -> Vec3 {
        cosine_about(local.normal, u, v)
    }
}

/// What gives off light, and scatters none.
pub(crate) struct Lamp(Vec3);

impl Bsdf for Lamp {
    fn evaluate(&self, _: &Local, _: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    fn density(&self, _: &Local, _: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, local: &Local, _: [f32; 2]) -> Vec3 {
        local.normal
    }

    fn emission(&self) -> Vec3 {
        self.0
    }
}

/// Rough metal: facets that are mirrors, after Trowbridge and Reitz, with waves in its normal and its roughness.
///
/// Walter, Marschner, Li, Torrance: Microfacet Models for Refraction through Rough Surfaces. EGSR 2007.
pub(crate) struct Metal {
    color: Vec3,
    roughness: f32,
    is_wavy: bool,
}

impl Metal {
    /// The width of the facets' distribution: a map of roughness.
    fn alpha(&self, at: Vec2) -> f32 {
        let varied = if self.is_wavy { 1.0 + 0.5 * (at.y * 40.0).sin() } else { 1.0 };
        (self.roughness * varied).powi(2).max(1e-3)
    }

    fn facets(alpha: f32, cosine: f32) -> f32 {
        let squared = alpha * alpha;
        squared / (PI * (cosine * cosine * (squared - 1.0) + 1.0).powi(2))
    }

    /// The share of facets that is seen (Smith).
    fn seen(alpha: f32, cosine: f32) -> f32 {
        let squared = alpha * alpha;
        2.0 * cosine / (cosine + (squared + (1.0 - squared) * cosine * cosine).sqrt())
    }
}

impl Bsdf for Metal {
    fn evaluate(&self, local: &Local, from: Vec3) -> Vec3 {
        let (to, normal) = (local.to, local.normal);
        let (seen, lit) = (normal.dot(to), normal.dot(from));
        if seen <= 0.0 || lit <= 0.0 {
            return Vec3::ZERO;
        }
        let (half, alpha) = ((to + from).normalize(), self.alpha(local.at));
        let fresnel = self.color + (1.0 - self.color) * (1.0 - half.dot(to)).max(0.0).powi(5);
        let facets = Self::facets(alpha, normal.dot(half));
        let shadowed = Self::seen(alpha, seen) * Self::seen(alpha, lit);
        fresnel * (facets * shadowed / (4.0 * seen))
    }

    fn density(&self, local: &Local, from: Vec3) -> f32 {
        let half = (local.to + from).normalize_or_zero();
        let (cosine, along) = (local.normal.dot(half), half.dot(local.to));
        if along <= 0.0 || cosine <= 0.0 || local.normal.dot(from) <= 0.0 {
            return 0.0;
        }
        Self::facets(self.alpha(local.at), cosine) * cosine / (4.0 * along)
    }

    fn sample(&self, local: &Local, [u, v]: [f32; 2]) -> Vec3 {
        let alpha = self.alpha(local.at);
        let cosine = ((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)).sqrt();
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (x, y) = local.normal.any_orthonormal_pair();
        let (sin, cos) = (TAU * v).sin_cos();
        let half = (x * cos + y * sin) * sine + local.normal * cosine;
        half * (2.0 * half.dot(local.to)) - local.to
    }

    fn normal_map(&self, at: Vec2) -> Vec2 {
        if self.is_wavy { Vec2::new((at.x * 150.0).sin(), 0.0) * 0.1 } else { Vec2::ZERO }
    }
}

pub(crate) type Material = Box<dyn Bsdf>;

pub(crate) struct Bounce;

impl RayType for Bounce {
    /// The share that counts, and how likely the direction was; 0 for what is not aimed at a lamp as well.
    type Payload = (Vec3, f32);
}

pub(crate) struct ToLamp;

impl RayType for ToLamp {
    /// What arrives if nothing is in the way.
    type Payload = Vec3;
    const ANY: bool = true;
}

/// Traces one path for each pixel.
pub(crate) struct Paths {
    pub(crate) camera: Camera,
    pub(crate) size: [u32; 2],
    pub(crate) sample: u32,
    pub(crate) sky: Vec3,
    /// The lamp, and what it gives off.
    pub(crate) lamp: Option<(Parallelogram, Vec3)>,
    pub(crate) depth: u32,
}

impl Paths {
    fn random(&self, [x, y, _]: [u32; 3]) -> Random {
        Random { seed: 1, pixel: y * self.size[0] + x, sample: self.sample }
    }

    /// How likely a ray is aimed at a point of the lamp, per solid angle.
    fn aimed(lamp: &Parallelogram, ray: &Ray<f32>, t: f32) -> f32 {
        let across = lamp.u.cross(lamp.v);
        t * t / across.dot(ray.d.into()).abs().max(f32::MIN_POSITIVE)
    }
}

/// The weight of a way of sampling that is so likely, where there is another.
fn balance(own: f32, other: f32) -> f32 {
    own / (own + other)
}

impl Entry for Paths {
    type Material = Material;
    type Rays = (Bounce, ToLamp);
    type Out = Vec3;
    type Append = ();

    fn generate(&self, index: [u32; 3], on: &mut On<'_, Self>) {
        let [u, v, ..] = self.random(index).four(0);
        let point = Vec2::new(index[0] as f32 + u, index[1] as f32 + v);
        on.send(Bounce, self.camera.ray(point, self.size), (Vec3::ONE, 0.0));
    }
}

impl Traces<Bounce> for Paths {
    fn closest_hit(
        &self,
        at: &Place<'_, Material>,
        (weight, likely): (Vec3, f32),
        on: &mut On<'_, Self>,
    ) {
        let bsdf = at.material();
        let emission = bsdf.emission();
        if emission != Vec3::ZERO && at.is_front() {
            let share = match &self.lamp {
                Some((lamp, _)) if likely > 0.0 => {
                    balance(likely, Self::aimed(lamp, at.ray(), at.t()))
                }
                _ => 1.0,
            };
            *on.out() += weight * emission * share;
        }
        let depth = on.round();
        if depth == self.depth {
            return;
        }
        let flat = at.normal();
        let around = at.attributes::<Sphere>().or_else(|| at.attributes::<Parallelogram>());
        let coordinates = around.unwrap_or_default();
        let bend = bsdf.normal_map(coordinates);
        let (x, y) = flat.any_orthonormal_pair();
        let normal = (flat + x * bend.x + y * bend.y).normalize();
        let local = Local { normal, to: -at.direction(), at: coordinates };
        let [u, v, a, b] = self.random(on.index()).four(1 + 2 * depth);
        if let Some((lamp, light)) = &self.lamp {
            let way = lamp.corner + lamp.u * a + lamp.v * b - at.point();
            let (towards, distance) = (way.normalize(), way.length());
            let is_lit = lamp.u.cross(lamp.v).dot(towards) < 0.0 && flat.dot(towards) > 0.0;
            let arriving = bsdf.evaluate(&local, towards);
            if is_lit && arriving != Vec3::ZERO {
                let start = at.leave(towards);
                let ray = ray_to(start, towards, distance * (1.0 - 1e-4));
                let aimed = Self::aimed(lamp, &ray, distance);
                let share = balance(aimed, bsdf.density(&local, towards));
                on.send(ToLamp, ray, weight * *light * arriving * (share / aimed));
            }
        }
        let from = bsdf.sample(&local, [u, v]);
        let likely = bsdf.density(&local, from);
        if likely <= 0.0 || flat.dot(from) <= 0.0 {
            return;
        }
        let mut weight = weight * bsdf.evaluate(&local, from) / likely;
        if depth >= 3 {
            let [end, ..] = self.random(on.index()).four(2 + 2 * depth);
            let stay = weight.max_element().clamp(0.05, 1.0);
            if end >= stay {
                return;
            }
            weight /= stay;
        }
        on.send(Bounce, Ray::new(at.leave(from), from), (weight, likely));
    }

    fn miss(&self, _: &Ray<f32>, (weight, _): (Vec3, f32), on: &mut On<'_, Self>) {
        *on.out() += weight * self.sky;
    }
}

impl Traces<ToLamp> for Paths {
    fn miss(&self, _: &Ray<f32>, light: Vec3, on: &mut On<'_, Self>) {
        *on.out() += light;
    }
}

/// Spheres with their materials, and a lamp.
pub(crate) fn scene(
    spheres: Vec<(Sphere, Material)>,
    flat: Vec<(Parallelogram, Material)>,
) -> Result<Scene<Material>, CommitError> {
    let mut graph = Graph::new();
    let mut all = vec![];
    for (sphere, material) in spheres {
        let geometry = Geometry::of::<Sphere>(vec![sphere], Builder::Binned);
        all.push((geometry, material));
    }
    for (shape, material) in flat {
        let geometry = Geometry::of::<Parallelogram>(vec![shape], Builder::Binned);
        all.push((geometry, material));
    }
    let mut nodes = vec![];
    for (geometry, material) in all {
        let geometry = geometry.unwrap_or_else(|error| unreachable!("they are taken: {error}"));
        let (geometry, material) = (graph.geometry(geometry), graph.material(material));
        nodes.push(graph.instance(geometry, material));
    }
    let root = graph.group(nodes);
    Ok(graph.commit(root)?)
}

/// The mean of so many paths.
pub(crate) fn mean(
    scene: &Scene<Material>,
    paths: &mut Paths,
    samples: u32,
    launch: &Launch<'_>,
) -> Vec<Vec3> {
    let mut sum = Buffer::plane(paths.size, Vec3::ZERO);
    for sample in 0..samples {
        paths.sample = sample;
        scene.launch(paths, launch, &mut sum);
    }
    sum.cells().iter().map(|color| color / samples as f32).collect()
}

/// From any radiance to what a screen shows (Reinhard).
fn tone(color: Vec3) -> Vec3 {
    color / (1.0 + color)
}

const LAMP: Parallelogram = Parallelogram {
    corner: Vec3::new(-1.0, 4.0, -1.0),
    u: Vec3::new(2.0, 0.0, 0.0),
    v: Vec3::new(0.0, 0.0, 2.0),
};

/// Four balls on the ground under the lamp, which shines downwards; what it gives off.
fn room() -> Result<(Scene<Material>, Vec3), CommitError> {
    let ball = |x: f32| Sphere { center: Vec3::new(x, 0.9, 0.0), radius: 0.9 };
    let metal = |roughness, is_wavy| {
        Box::new(Metal { color: Vec3::new(0.9, 0.7, 0.4), roughness, is_wavy }) as Material
    };
    let light = Vec3::splat(8.0);
    let ground = Parallelogram {
        corner: Vec3::new(-9.0, 0.0, 9.0),
        u: Vec3::X * 18.0,
        v: Vec3::NEG_Z * 18.0,
    };
    let spheres = vec![
        (ball(-3.0), Box::new(Lambert(Vec3::new(0.8, 0.2, 0.2))) as Material),
        (ball(-1.0), metal(0.5, false)),
        (ball(1.0), metal(0.25, false)),
        (ball(3.0), metal(0.4, true)),
    ];
    let flat = vec![
        (ground, Box::new(Lambert(Vec3::splat(0.6))) as Material),
        (LAMP, Box::new(Lamp(light)) as Material),
    ];
    Ok((scene(spheres, flat)?, light))
}

fn main() -> Result<()> {
    let (scene, light) = room()?;
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next();
    let samples = arguments.next().map_or(Ok(16), |text| text.parse());
    let samples = samples.context("SAMPLES: write a whole number")?;
    let size = [640, 360];
    let camera = Camera::pinhole(Vec3::new(0.0, 3.0, 9.0), Vec3::new(0.0, 0.8, 0.0), 35.0);
    let lamp = Some((LAMP, light));
    let mut paths =
        Paths { camera, size, sample: 0, sky: Vec3::new(0.1, 0.15, 0.25), lamp, depth: 12 };
    let start = Instant::now();
    let pixels = mean(&scene, &mut paths, samples, &Launch::default());
    println!("{samples} samples in {:.1} s", start.elapsed().as_secs_f64());
    if let Some(path) = path {
        let seen: Vec<Vec3> = pixels.into_iter().map(tone).collect();
        common::write(Path::new(&path), size, &seen)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball in a sky of 1.
    fn in_furnace(material: Material, samples: u32) -> Vec<Vec3> {
        let ball = Sphere { center: Vec3::ZERO, radius: 1.0 };
        let scene = scene(vec![(ball, material)], vec![]).expect("it is placed");
        let camera = Camera::pinhole(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 20.0);
        let (size, sky) = ([16, 16], Vec3::ONE);
        let mut paths = Paths { camera, size, sample: 0, sky, lamp: None, depth: 12 };
        mean(&scene, &mut paths, samples, &Launch::default())
    }

    #[test]
    fn what_returns_all_light_is_not_seen_in_a_furnace() {
        for color in in_furnace(Box::new(Lambert(Vec3::ONE)), 4) {
            assert!((color - Vec3::ONE).abs().max_element() < 1e-4, "{color}");
        }
        for color in in_furnace(Box::new(Lambert(Vec3::splat(0.5))), 4) {
            assert!((color - Vec3::splat(0.5)).abs().max_element() < 1e-4, "{color}");
        }
    }

    #[test]
    fn facets_return_no_more_than_they_get() {
        for roughness in [0.1, 0.5, 0.9] {
            let metal = Metal { color: Vec3::ONE, roughness, is_wavy: false };
            let colors = in_furnace(Box::new(metal), 64);
            let mean = colors.iter().sum::<Vec3>() / colors.len() as f32;
            // Light between facets is lost, and more of it the rougher they are.
            assert!(mean.x < 1.01 && mean.x > 1.0 - 0.7 * roughness, "{roughness}: {mean}");
        }
    }

    /// What a surface scatters of light from all sides, by directions that it samples and by directions without preference:
    /// they agree where evaluating, density and sampling belong together.
    #[test]
    fn samples_densities_and_values_belong_together() {
        let metal = Metal { color: Vec3::splat(0.8), roughness: 0.6, is_wavy: true };
        let all: [&dyn Bsdf; 2] = [&Lambert(Vec3::splat(0.7)), &metal];
        let to = Vec3::new(0.6, 0.0, 0.8);
        let local = Local { normal: Vec3::Z, to, at: Vec2::new(0.3, 0.7) };
        let count = 40_000;
        for bsdf in all {
            let (mut sampled, mut even, mut whole) = (0.0, 0.0, 0.0);
            for number in 0..count {
                let random = Random { seed: 1, pixel: number, sample: 0 };
                let [u, v, a, b] = random.four(0);
                let from = bsdf.sample(&local, [u, v]);
                let density = bsdf.density(&local, from);
                if density > 0.0 {
                    sampled += f64::from(bsdf.evaluate(&local, from).x / density);
                }
                let (sin, cos) = (TAU * a).sin_cos();
                let side = (1.0 - b * b).sqrt();
                let from = Vec3::new(cos * side, sin * side, b);
                even += f64::from(bsdf.evaluate(&local, from).x * TAU);
                whole += f64::from(bsdf.density(&local, from) * TAU);
            }
            let count = f64::from(count);
            assert!((sampled - even).abs() / count < 0.02, "{} {}", sampled / count, even / count);
            // Some facets reflect below the surface: these directions are likely, and not counted.
            assert!(whole / count > 0.7 && whole / count < 1.02, "{}", whole / count);
        }
    }

    #[test]
    fn a_lamp_brings_the_same_aimed_at_or_met_by_chance() {
        let (scene, light) = room().expect("it is placed");
        let seen = |lamp: Option<(Parallelogram, Vec3)>, samples: u32| {
            let eye = Vec3::new(0.0, 3.0, 9.0);
            let camera = Camera::pinhole(eye, Vec3::new(0.0, 0.8, 0.0), 35.0);
            let (size, sky) = ([24, 12], Vec3::ZERO);
            let mut paths = Paths { camera, size, sample: 0, sky, lamp, depth: 3 };
            let colors = mean(&scene, &mut paths, samples, &Launch::default());
            colors.iter().sum::<Vec3>().x / colors.len() as f32
        };
        let (aimed, met) = (seen(Some((LAMP, light)), 64), seen(None, 400));
        assert!((aimed - met).abs() < 0.05 * aimed && aimed > 0.01, "{aimed} {met}");
    }

    #[test]
    fn threads_change_nothing() {
        let picture = |threads: usize, tile: u32| {
            let (scene, light) = room().expect("it is placed");
            let camera = Camera::pinhole(Vec3::new(0.0, 3.0, 9.0), Vec3::ZERO, 35.0);
            let (size, sky, lamp) = ([32, 20], Vec3::ONE, Some((LAMP, light)));
            let mut paths = Paths { camera, size, sample: 0, sky, lamp, depth: 6 };
            let launch = Launch { tile, ..Launch::default() };
            common::on_threads(threads, || mean(&scene, &mut paths, 2, &launch))
        };
        assert_eq!(picture(1, 64), picture(3, 5));
    }
}
