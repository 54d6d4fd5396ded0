//! Photon mapping: light is followed from the lamp, where it lands is kept, and what a camera sees is as bright as photons
//! lie close there. Photons end by roulette. The map is the same to the bit whatever the threads.
//!
//! Jensen: Global Illumination using Photon Maps. Eurographics Rendering Workshop 1996.
//!
//! `cargo run --release -p trisect-pipeline --example photons [PICTURE.png] [PHOTONS]`

#[allow(unused, reason = "each demonstration asks for a part")]
mod common;

use std::collections::HashMap;
use std::f32::consts::PI;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use common::Camera;
use glam::{IVec3, Vec2, Vec3};
use trisect_core::Ray;
use trisect_pipeline::random::{Random, cosine_about};
use trisect_pipeline::{
    Buffer, Builder, CommitError, Entry, Geometry, Graph, Launch, Launched, On, Parallelogram,
    Place, RayType, Scene, Sphere, Traces,
};

/// How far photons count.
const RADIUS: f32 = 0.12;

/// A photon where it landed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Landed {
    at: Vec3,
    /// Where it came from.
    direction: Vec3,
    power: Vec3,
}

struct Photon;

impl RayType for Photon {
    type Payload = Vec3;
}

/// Sends photons from a lamp; what it appends is the map. The first entry point.
struct Emit {
    lamp: Parallelogram,
    power: Vec3,
    count: u32,
}

/// Colours of the surfaces.
type Material = Vec3;

impl Emit {
    fn random([number, ..]: [u32; 3]) -> Random {
        Random { seed: 1, pixel: number, sample: 0 }
    }
}

impl Entry for Emit {
    type Material = Material;
    type Rays = (Photon,);
    type Out = ();
    type Append = Landed;

    fn generate(&self, index: [u32; 3], on: &mut On<'_, Self>) {
        let [a, b, u, v] = Self::random(index).four(0);
        let Parallelogram { corner, u: across, v: along } = self.lamp;
        let normal = across.cross(along).normalize();
        let from = corner + across * a + along * b + normal * 1e-4;
        on.send(Photon, Ray::new(from, cosine_about(normal, u, v)), self.power / self.count as f32);
    }
}

impl Traces<Photon> for Emit {
    fn closest_hit(&self, at: &Place<'_, Material>, power: Vec3, on: &mut On<'_, Self>) {
        on.append(Landed { at: at.point(), direction: -at.direction(), power });
        // It stays in flight as likely as the surface returns light.
        let color = *at.material();
        let stay = color.max_element();
        let [u, v, end, _] = Self::random(on.index()).four(1 + on.round());
        if end < stay {
            let towards = cosine_about(at.normal(), u, v);
            let ray = Ray::new(at.leave(towards), towards);
            on.send(Photon, ray, power * color / stay);
        }
    }
}

/// Photons by the cells of a grid that are as large as they count far.
struct Map {
    cells: HashMap<IVec3, Vec<Landed>>,
}

impl Map {
    fn cell(at: Vec3) -> IVec3 {
        (at / RADIUS).floor().as_ivec3()
    }

    fn new(all: &[Landed]) -> Self {
        let mut cells: HashMap<IVec3, Vec<Landed>> = HashMap::new();
        for photon in all {
            cells.entry(Self::cell(photon.at)).or_default().push(*photon);
        }
        Self { cells }
    }

    /// The light that arrives at a point of a surface, from the side of its normal: in the order of the cells, and there of
    /// the photons.
    fn arriving(&self, at: Vec3, normal: Vec3) -> Vec3 {
        let middle = Self::cell(at);
        let around = (-1..=1).flat_map(|x| {
            (-1..=1).flat_map(move |y| (-1..=1).map(move |z| middle + IVec3::new(x, y, z)))
        });
        let near = around.filter_map(|cell| self.cells.get(&cell)).flatten().filter(|photon| {
            let is_near = photon.at.distance_squared(at) < RADIUS * RADIUS;
            is_near && photon.direction.dot(normal) > 0.0
        });
        near.fold(Vec3::ZERO, |sum, photon| sum + photon.power) / (PI * RADIUS * RADIUS)
    }
}

struct Sight;

impl RayType for Sight {
    type Payload = ();
}

/// Looks at the scene, and into the map. The second entry point.
struct Gather<'a> {
    map: &'a Map,
    camera: Camera,
    size: [u32; 2],
}

impl Entry for Gather<'_> {
    type Material = Material;
    type Rays = (Sight,);
    type Out = Vec3;
    type Append = ();

    fn generate(&self, [x, y, _]: [u32; 3], on: &mut On<'_, Self>) {
        let point = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        on.send(Sight, self.camera.ray(point, self.size), ());
    }
}

impl Traces<Sight> for Gather<'_> {
    fn closest_hit(&self, at: &Place<'_, Material>, (): (), on: &mut On<'_, Self>) {
        *on.out() = *at.material() / PI * self.map.arriving(at.point(), at.normal());
    }
}

/// A closed room with a ball, whose surfaces return that share of light, and a lamp below its ceiling.
fn room(share: f32) -> Result<(Scene<Material>, Parallelogram), CommitError> {
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 3.0, Vec3::Z * 4.0);
    let low = Vec3::new(-2.0, 0.0, -2.0);
    let wall = |corner, u, v| Parallelogram { corner, u, v };
    let white = Vec3::splat(share);
    let walls = [
        (wall(low, x, z), white),
        (wall(low + y, x, z), white),
        (wall(low, x, y), white),
        (wall(low + z, x, y), white),
        (wall(low, y, z), Vec3::new(1.0, 0.4, 0.3) * share),
        (wall(low + x, y, z), Vec3::new(0.3, 0.5, 1.0) * share),
    ];
    let mut graph = Graph::new();
    let mut nodes = vec![];
    for (wall, color) in walls {
        nodes.push((Geometry::of::<Parallelogram>(vec![wall], Builder::Binned), color));
    }
    let ball = Sphere { center: Vec3::new(0.4, 0.8, 0.0), radius: 0.8 };
    nodes.push((Geometry::of::<Sphere>(vec![ball], Builder::Binned), white));
    let mut all = vec![];
    for (geometry, color) in nodes {
        let geometry = geometry.unwrap_or_else(|error| unreachable!("they are taken: {error}"));
        let (geometry, color) = (graph.geometry(geometry), graph.material(color));
        all.push(graph.instance(geometry, color));
    }
    let root = graph.group(all);
    let lamp = wall(Vec3::new(-0.5, 2.9, -0.5), Vec3::X, Vec3::Z);
    Ok((graph.commit(root)?, lamp))
}

fn emit(scene: &Scene<Material>, lamp: Parallelogram, count: u32) -> Launched<Landed> {
    let emit = Emit { lamp, power: Vec3::splat(60.0), count };
    scene.launch(&emit, &Launch::default(), &mut Buffer::line(count, ()))
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next();
    let count = arguments.next().map_or(Ok(400_000), |text| text.parse());
    let count = count.context("PHOTONS: write a whole number")?;
    let (scene, lamp) = room(0.7)?;
    let start = Instant::now();
    let Launched { appended, rays, .. } = emit(&scene, lamp, count);
    let time = start.elapsed().as_secs_f64();
    println!(
        "{count} photons landed {} times in {:.1} ms, {:.1} Mrays/s",
        appended.len(),
        time * 1e3,
        rays[0] as f64 / time * 1e-6
    );
    let (start, size) = (Instant::now(), [640, 480]);
    let map = Map::new(&appended);
    let camera = Camera::pinhole(Vec3::new(0.0, 1.5, 1.95), Vec3::new(0.0, 1.2, 0.0), 80.0);
    let mut picture = Buffer::plane(size, Vec3::ZERO);
    scene.launch(&Gather { map: &map, camera, size }, &Launch::default(), &mut picture);
    println!("gathered in {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
    if let Some(path) = path {
        common::write(Path::new(&path), size, picture.cells())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_is_the_same_for_any_threads_and_tiles() {
        let (scene, lamp) = room(0.7).expect("it is placed");
        let map = |threads: usize, tile: u32| {
            let emit = Emit { lamp, power: Vec3::ONE, count: 3000 };
            let launch = Launch { tile, ..Launch::default() };
            common::on_threads(threads, || {
                scene.launch(&emit, &launch, &mut Buffer::line(3000, ()))
            })
        };
        let first = map(1, 64);
        assert!(first.appended.len() > 3000);
        assert_eq!(first, map(4, 7));
    }

    #[test]
    fn photons_land_as_often_as_roulette_lets_them() {
        // Every surface that is met returns as much, in its largest colour: the mean of a geometric series.
        let (scene, lamp) = room(0.5).expect("it is placed");
        let (count, share) = (20_000_u32, 0.5);
        let landed = emit(&scene, lamp, count);
        // Each photon is stored where it lands, so that there are as many as rays.
        assert_eq!(landed.appended.len() as u64, landed.rays[0]);
        let mean = landed.appended.len() as f64 / f64::from(count);
        assert!((mean - 1.0 / (1.0 - share)).abs() < 0.05, "{mean}");
    }

    #[test]
    fn the_map_is_as_bright_as_the_light_that_arrives() {
        // No light is returned: what arrives on the floor below the lamp is known.
        let (scene, lamp) = room(0.0).expect("it is placed");
        let landed = emit(&scene, lamp, 200_000);
        assert_eq!(landed.appended.len(), 200_000);
        let map = Map::new(&landed.appended);
        let at = Vec3::new(-1.2, 0.0, 0.6);
        // Points of the lamp, each with its share of the power in the cosine's distribution.
        let (side, mut expected) = (32_u16, 0.0);
        for i in 0..side {
            for j in 0..side {
                let [a, b] = [i, j].map(|i| (f32::from(i) + 0.5) / f32::from(side));
                let way = lamp.corner + lamp.u * a + lamp.v * b - at;
                let cosine = way.normalize().y;
                expected += cosine * cosine / (PI * way.length_squared());
            }
        }
        let expected = 60.0 * expected / f32::from(side).powi(2);
        let seen = map.arriving(at, Vec3::Y).x;
        assert!((seen - expected).abs() < 0.1 * expected, "{seen} {expected}");
    }
}
