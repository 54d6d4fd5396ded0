//! Objects that move over a landscape: how far each is from anything, by probes in all directions, and which of them see
//! each other. Nothing is drawn. Trees over instances are fitted at each step.
//!
//! `cargo run --release -p trisect-pipeline --example collisions [OBJECTS] [PROBES] [SIDE]`: 4096 objects with 512 probes
//! each over two million triangles, unless less is asked for.

#[allow(unused, reason = "each demonstration asks for a part")]
mod common;

use std::time::Instant;

use anyhow::{Context, Result};
use glam::{Affine3A, Vec3};
use trisect_core::{Ray, Triangle};
use trisect_pipeline::random::Random;
use trisect_pipeline::{
    Buffer, Builder, CommitError, Entry, Graph, Launch, NodeId, On, Place, RayType, Scene, Traces,
};

/// The size of an object: its corners are as far from its middle.
const RADIUS: f32 = 0.02;
/// How far probes look.
const REACH: f32 = 0.5;
const STEP: f32 = 0.01;

struct Probe;

impl RayType for Probe {
    type Payload = ();
}

/// Looks in all directions from each object: indices are the probe and the object. What it hits nearest counts.
struct Probes<'a> {
    places: &'a [Vec3],
    count: u32,
}

impl Entry for Probes<'_> {
    type Material = ();
    type Rays = (Probe,);
    /// The distance of what is near.
    type Out = f32;
    type Append = ();

    fn generate(&self, [probe, object, _]: [u32; 3], on: &mut On<'_, Self>) {
        *on.out() = f32::INFINITY;
        let towards = spread(probe, self.count);
        // From outside the object itself, which has no corner farther away.
        let ray = Ray::new(self.places[object as usize], towards);
        on.send(Probe, ray.with_interval(RADIUS * 1.01, REACH), ());
    }
}

impl Traces<Probe> for Probes<'_> {
    fn closest_hit(&self, at: &Place<'_, ()>, (): (), on: &mut On<'_, Self>) {
        *on.out() = at.t();
    }
}

/// Directions that cover a sphere evenly (Fibonacci's spiral).
fn spread(number: u32, count: u32) -> Vec3 {
    let y = 1.0 - (2.0 * number as f32 + 1.0) / count as f32;
    let (sin, cos) = (number as f32 * 2.399_963_2).sin_cos();
    let around = (1.0 - y * y).sqrt();
    Vec3::new(cos * around, y, sin * around)
}

struct Sees;

impl RayType for Sees {
    type Payload = ();
    const ANY: bool = true;
}

/// Asks for each pair of objects whether anything is between them: indices are both.
struct Pairs<'a> {
    places: &'a [Vec3],
}

impl Entry for Pairs<'_> {
    type Material = ();
    type Rays = (Sees,);
    type Out = bool;
    type Append = ();

    fn generate(&self, [a, b, _]: [u32; 3], on: &mut On<'_, Self>) {
        // Each pair once.
        if a < b {
            let [a, b] = [a, b].map(|at| self.places[at as usize]);
            let way = b - a;
            // Between both: neither is in the way of itself.
            let end = 1.01 * RADIUS / way.length();
            on.send(Sees, Ray::new(a, way).with_interval(end, 1.0 - end), ());
        }
    }
}

impl Traces<Sees> for Pairs<'_> {
    fn miss(&self, _: &Ray<f32>, (): (), on: &mut On<'_, Self>) {
        *on.out() = true;
    }
}

/// Hills.
fn height(x: f32, z: f32) -> f32 {
    0.3 * (3.0 * x).sin() * (2.0 * z + 1.0).cos() + 0.1 * (11.0 * x + 5.0 * z).sin()
}

/// A landscape of two triangles for each of so many squares along each side.
fn landscape(side: u16) -> Vec<Triangle<f32>> {
    let corner = |i: u16, j: u16| {
        let [x, z] = [i, j].map(|i| f32::from(i) / f32::from(side) * 4.0 - 2.0);
        Vec3::new(x, height(x, z), z)
    };
    let squares = (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
    squares
        .flat_map(|(i, j)| {
            let [a, b, c, d] =
                [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            [Triangle::new(a, b, c), Triangle::new(a, c, d)]
        })
        .collect()
}

/// All that moves, and where it is.
struct World {
    scene: Scene<()>,
    root: NodeId,
    movers: Vec<NodeId>,
    places: Vec<Vec3>,
}

/// Where an object is at a step.
fn place(object: u32, step: u16) -> Vec3 {
    let [x, z, up, turn] = Random { seed: 1, pixel: object, sample: 0 }.four(0);
    let (sin, cos) = (turn * 6.3 + f32::from(step) * STEP).sin_cos();
    let (x, z) = (3.4 * x - 1.7 + 0.2 * sin, 3.4 * z - 1.7 + 0.2 * cos);
    Vec3::new(x, height(x, z) + 0.05 + 0.3 * up, z)
}

impl World {
    fn new(objects: u32, side: u16) -> Result<Self, CommitError> {
        let mut graph = Graph::new();
        let ground = graph.geometry(common::mesh(landscape(side), Builder::Binned));
        let small = common::ball(0).into_iter().map(|triangle| triangle.map(|x| x * RADIUS));
        let object = graph.geometry(common::mesh(small.collect(), Builder::Binned));
        let material = graph.material(());
        let object = graph.instance(object, material);
        let places: Vec<Vec3> = (0..objects).map(|number| place(number, 0)).collect();
        let moved = |at: &Vec3| graph.transform(Affine3A::from_translation(*at), object);
        let movers: Vec<NodeId> = places.iter().map(moved).collect();
        let ground = graph.instance(ground, material);
        let root = graph.group(movers.iter().copied().chain([ground]));
        Ok(Self { scene: graph.commit(root)?, root, movers, places })
    }

    /// Moves all objects.
    fn step(self, step: u16) -> Result<Self> {
        let Self { scene, root, movers, mut places } = self;
        let mut graph = scene.edit();
        for ((number, mover), at) in (0..).zip(&movers).zip(&mut places) {
            *at = place(number, step);
            graph.set_transform(*mover, Affine3A::from_translation(*at))?;
        }
        Ok(Self { scene: graph.commit(root)?, root, movers, places })
    }

    fn probe(&self, count: u32, launch: &Launch<'_>) -> (Buffer<f32>, u64) {
        let objects = u32::try_from(self.places.len()).unwrap_or(u32::MAX);
        let mut near = Buffer::plane([count, objects], 0.0);
        let probes = Probes { places: &self.places, count };
        let launched = self.scene.launch(&probes, launch, &mut near);
        (near, launched.rays[0])
    }

    fn look(&self, launch: &Launch<'_>) -> (Buffer<bool>, u64) {
        let objects = u32::try_from(self.places.len()).unwrap_or(u32::MAX);
        let mut seen = Buffer::plane([objects; 2], false);
        let launched = self.scene.launch(&Pairs { places: &self.places }, launch, &mut seen);
        (seen, launched.rays[0])
    }
}

fn main() -> Result<()> {
    let arguments: Vec<u32> = std::env::args()
        .skip(1)
        .map(|text| text.parse().with_context(|| format!("`{text}` is no whole number")))
        .collect::<Result<_>>()?;
    let at = |place: usize, usual: u32| arguments.get(place).copied().unwrap_or(usual);
    let (objects, probes) = (at(0, 4096), at(1, 512));
    let side = u16::try_from(at(2, 1024)).context("SIDE: at most 65535")?;
    let start = Instant::now();
    let mut world = World::new(objects, side)?;
    println!("built in {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
    for step in 1..=4 {
        let start = Instant::now();
        world = world.step(step)?;
        let moved = start.elapsed().as_secs_f64();
        let (near, probed) = world.probe(probes, &Launch::default());
        let after_probes = start.elapsed().as_secs_f64();
        let (seen, looked) = world.look(&Launch::default());
        let all = start.elapsed().as_secs_f64();
        println!(
            "step {step}: moved in {:.1} ms ({:?}); probes {:.1} Mrays/s, {} near; pairs {:.1} Mrays/s, {} see each \
             other; {:.1} Mrays/s in all",
            moved * 1e3,
            world.scene.update(),
            probed as f64 / (after_probes - moved) * 1e-6,
            near.cells().iter().filter(|near| near.is_finite()).count(),
            looked as f64 / (all - after_probes) * 1e-6,
            seen.cells().iter().filter(|seen| **seen).count(),
            (probed + looked) as f64 / all * 1e-6,
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisect_pipeline::Update;

    const OBJECTS: u32 = 64;

    #[test]
    fn after_steps_the_world_is_as_if_built_there() {
        let mut world = World::new(OBJECTS, 32).expect("it is placed");
        for step in 1..4 {
            world = world.step(step).expect("it moves");
            assert!(matches!(world.scene.update(), Update::Refitted { .. }), "it is fitted");
        }
        let other = World::new(OBJECTS, 32).and_then(|other| {
            let World { scene, movers, root, .. } = other;
            let mut graph = scene.edit();
            for (mover, at) in movers.iter().zip(&world.places) {
                graph.set_transform(*mover, Affine3A::from_translation(*at)).expect("a transform");
            }
            // Another root: nothing is kept.
            let above = graph.group([root]);
            Ok(World { scene: graph.commit(above)?, root, movers, places: world.places.clone() })
        });
        let other = other.expect("it is placed");
        assert_eq!(other.scene.update(), Update::Rebuilt);
        let launch = Launch::default();
        let (near, rays) = world.probe(16, &launch);
        assert_eq!(rays, 16 * u64::from(OBJECTS));
        assert_eq!((near.clone(), rays), other.probe(16, &launch));
        assert!(near.cells().iter().any(|near| near.is_finite()));
        assert!(near.cells().iter().any(|near| near.is_infinite()));
        let (seen, rays) = world.look(&launch);
        assert_eq!(rays, u64::from(OBJECTS * (OBJECTS - 1) / 2));
        assert_eq!((seen, rays), other.look(&launch));
    }

    #[test]
    fn what_is_between_two_objects_hides_them() {
        let world = World::new(OBJECTS, 32).expect("it is placed");
        let (seen, _) = world.look(&Launch::default());
        let mut hidden = 0;
        for b in 0..OBJECTS {
            for a in 0..b {
                // Far below the ground there is no way: the middle of the line says so, well apart from rounding.
                let middle = [a, b].map(|at| world.places[at as usize]).iter().sum::<Vec3>() * 0.5;
                if middle.y < height(middle.x, middle.z) - 0.05 {
                    assert!(!seen[[a, b, 0]], "{a} {b}");
                    hidden += 1;
                }
            }
        }
        assert!(hidden > 100, "{hidden}");
        assert!(seen.cells().iter().any(|seen| *seen));
    }

    #[test]
    fn threads_change_nothing() {
        let world = World::new(OBJECTS, 16).expect("it is placed");
        let all = |threads: usize, tile: u32| {
            let launch = Launch { tile, ..Launch::default() };
            common::on_threads(threads, || (world.probe(16, &launch), world.look(&launch)))
        };
        assert_eq!(all(1, 64), all(3, 5));
    }
}
