//! What the generality of programs costs: five clients, each as programs and as a loop by hand over the tracer's calls.
//!
//! `cargo run --release -p trisect-pipeline --example price [PAIRS] [MESH]` runs both in turn on one thread, holds them to
//! the same answers to the bit, and prints how much longer programs take: the median of the pairs, and where the true one
//! lies with 95 % certainty.

#[allow(unused, reason = "each demonstration asks for a part")]
mod common;
mod price_clients;

use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use common::Camera;
use glam::{Affine3A, Vec3};
use price_clients::{Answer, ByHand, Client, Extra, ambient_with, by_programs};
use trisect_core::Triangle;
use trisect_mesh::{Bounds, Mesh};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_pipeline::{Builder, Geometry, Graph, Scene};

const ALL: [Client; 5] =
    [Client::Ambient, Client::Mirror, Client::Occlusion, Client::Paths, Client::Sight];

/// A mesh, as programs have it and as a loop by hand has it: both go through the same tree.
struct Model {
    scene: Scene<()>,
    geometry: trisect_pipeline::GeometryId,
    triangles: Vec<Triangle<f32>>,
    camera: Camera,
    extent: f32,
}

impl Model {
    fn new(triangles: Vec<Triangle<f32>>, geometry: Geometry, place: Affine3A) -> Result<Self> {
        let bounds = Bounds::of(&triangles).context("the mesh is empty")?;
        let (middle, extent) = (Vec3::from(bounds.center()), bounds.diagonal());
        let mut graph = Graph::new();
        let (geometry, material) = (graph.geometry(geometry), graph.material(()));
        let instance = graph.instance(geometry, material);
        let root = graph.transform(place, instance);
        let eye = middle + Vec3::new(0.2, 0.2, 0.7) * extent;
        let camera = Camera::pinhole(eye, middle, 45.0);
        Ok(Self { scene: graph.commit(root)?, geometry, triangles, camera, extent })
    }

    fn by_hand(&self, side: u32) -> ByHand<'_> {
        let tree = self.scene.geometry(self.geometry).tree();
        ByHand::new(tree, &self.triangles, self.camera, side, self.extent)
    }
}

/// The median of some numbers, and between which of them the true median is with 95 % certainty.
fn median(numbers: &mut [f64]) -> [f64; 3] {
    numbers.sort_by(f64::total_cmp);
    let count = numbers.len() as f64;
    // The number of those below the true median is binomial; as a normal distribution has it.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "among them")]
    let at = |place: f64| numbers[(place.max(0.0) as usize).min(numbers.len() - 1)];
    let (middle, apart) = (count / 2.0, 0.98 * count.sqrt());
    [at(middle), at(middle - apart), at(middle + apart)]
}

fn main() -> Result<()> {
    let bunny = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/meshes/bunny.ply");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let pairs = arguments.first().map_or(Ok(41), |text| text.parse::<u32>());
    let pairs = pairs.context("PAIRS: write a whole number")?.max(1);
    let path = arguments.get(1).map_or(bunny, String::as_str);
    let triangles = Mesh::load(path)?.triangles.to_vec();
    let build = || Geometry::of::<MollerTrumbore>(triangles.clone(), Builder::Spatial);
    let model = Model::new(triangles.clone(), build()?, Affine3A::IDENTITY)?;
    // So little that nothing else is seen, and yet no identity.
    let little = Affine3A::from_translation(Vec3::Z * f32::MIN_POSITIVE);
    let moved = Model::new(triangles.clone(), build()?, little)?;
    let side = 512;
    let Model { scene, camera, extent, .. } = &model;
    println!("client      more time in programs than by hand, %    Mrays/s");
    for client in ALL {
        let mut hand = model.by_hand(side);
        let programs = || by_programs(scene, client, *camera, side, *extent);
        let (times, speed) = compare(pairs, programs, || (hand.run(client), 0))
            .with_context(|| format!("{client:?}"))?;
        println!("{:10}  {times}, {pairs} pairs{:16}{speed:.1}", format!("{client:?}"), "");
    }
    println!("\nin ambient  more time with it than without, %");
    for extra in [Extra::Exceptions, Extra::Attributes, Extra::AnyHit, Extra::Transform] {
        let scene_with = if extra == Extra::Transform { &moved.scene } else { scene };
        let with = || ambient_with(scene_with, extra, *camera, side, *extent);
        let without = || ambient_with(scene, Extra::Nothing, *camera, side, *extent);
        let (times, _) = compare(pairs, with, without).with_context(|| format!("{extra:?}"))?;
        println!("{:10}  {times}, {pairs} pairs", format!("{extra:?}"));
    }
    Ok(())
}

/// How much more time the first takes than the second, in turn on one thread, and the rays of the first per microsecond.
fn compare(
    pairs: u32,
    first: impl Fn() -> Answer + Sync,
    mut second: impl FnMut() -> Answer + Send,
) -> Result<(String, f64)> {
    let timed = |run: &mut (dyn FnMut() -> Answer + Send)| {
        let start = Instant::now();
        (run(), start.elapsed())
    };
    let (mut ratios, mut fastest, mut count) = (vec![], Duration::MAX, 0);
    for pair in 0..=pairs {
        // First the one, then the other, so that neither has the better place.
        let (((answer, rays), time), ((expected, _), other)) = common::on_threads(1, || {
            if pair % 2 == 0 {
                let own = timed(&mut &first);
                (own, timed(&mut second))
            } else {
                let other = timed(&mut second);
                (timed(&mut &first), other)
            }
        });
        ensure!(answer == expected, "the answers differ");
        // The first is to warm up.
        if pair > 0 {
            ratios.push((time.as_secs_f64() / other.as_secs_f64() - 1.0) * 100.0);
            (fastest, count) = (fastest.min(time), rays);
        }
    }
    let [median, low, high] = median(&mut ratios);
    let speed = count as f64 / fastest.as_secs_f64() * 1e-6;
    Ok((format!("{median:+6.1} ({low:+.1} to {high:+.1})"), speed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_answer_as_loops_by_hand() {
        let ball = common::ball(3);
        let low = ball.iter().flat_map(|t| t.corners()).fold(0.0, |low: f32, p| low.min(p.y));
        let triangles: Vec<_> = ball.into_iter().chain(common::ground(low, 2.0)).collect();
        let geometry = common::mesh(triangles.clone(), Builder::Spatial);
        let model =
            Model::new(triangles, geometry, Affine3A::IDENTITY).expect("there are triangles");
        let mut hand = model.by_hand(70);
        for client in ALL {
            let (answer, rays) = by_programs(&model.scene, client, model.camera, 70, model.extent);
            assert!(answer == hand.run(client), "{client:?}");
            assert!(rays >= 70 * 70 && answer.iter().any(|x| *x != answer[0]), "{client:?}");
        }
        let ambient = |extra| ambient_with(&model.scene, extra, model.camera, 70, model.extent);
        for extra in [Extra::Exceptions, Extra::Attributes, Extra::AnyHit] {
            assert!(ambient(extra) == ambient(Extra::Nothing), "{extra:?}");
        }
    }

    #[test]
    fn the_median_is_the_one_in_the_middle() {
        let [median, low, high] = median(&mut (0..101).rev().map(f64::from).collect::<Vec<_>>());
        assert_eq!((median, low, high), (50.0, 40.0, 60.0));
    }
}
