//! The same scene, seed and settings give the same picture, to the bit.
#![allow(missing_docs, reason = "tests")]

#[allow(dead_code, reason = "each test asks for a part")]
mod common;

use std::sync::atomic::AtomicBool;

use common::{render, shipped, stage};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_render::{
    Image, Mode, Occlusion, Part, Parts, Renderer, Sampling, Settings, Stage, Watch,
};
use trisect_tracer::Tracing;
use trisect_wald::Wald;
use trisect_watertight::Watertight;

fn bits(image: &Image) -> Vec<u32> {
    image.pixels.iter().flat_map(|color| color.to_array().map(f32::to_bits)).collect()
}

/// Every feature: mirrors, glass, instances, textures, a lens, occlusion, paths.
fn pictures() -> Vec<(&'static str, Settings)> {
    let small = Settings::new([50, 37]);
    let occlusion = Some(Occlusion { rays: 5, distance: 3.0 });
    vec![
        ("mirror.toml", Settings { sampling: Sampling::Circle(3), ..small.clone() }),
        ("glass.toml", Settings { sampling: Sampling::Adaptive(3), ..small.clone() }),
        ("teapots.toml", Settings { mode: Mode::Whitted { occlusion }, ..small.clone() }),
        ("textures.toml", Settings { sampling: Sampling::Jittered(2), ..small.clone() }),
        ("lens.toml", Settings { sampling: Sampling::Grid(2), ..small.clone() }),
        ("room.toml", Settings { mode: Mode::Paths, sampling: Sampling::Circle(3), ..small }),
    ]
}

#[test]
fn pictures_are_the_same_for_any_threads_and_tiles() {
    for (name, settings) in pictures() {
        let stage = stage::<MollerTrumbore>(shipped(name));
        for tracing in [Tracing::Single, Tracing::Plain] {
            let mut first = None;
            for (threads, tile) in [(1, 64), (1, 7), (2, 1), (3, 16), (2, 1000)] {
                let settings = Settings { tile, tracing, ..settings.clone() };
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let image = pool.expect("there are threads").install(|| render(&stage, &settings));
                let image = bits(&image);
                assert!(image.iter().any(|bits| *bits != image[0]), "{name} is not empty");
                let first = first.get_or_insert_with(|| image.clone());
                assert!(*first == image, "{name} {tracing:?} {threads} {tile}");
            }
        }
    }
}

#[test]
fn what_is_left_out_changes_no_bit() {
    let small = Settings::new([50, 37]);
    let mut pictures = pictures();
    for name in ["mirror.toml", "glass.toml", "teapots.toml", "block.obj"] {
        for (depth, lights) in [(0, 0), (0, 9), (16, 0)] {
            pictures.push((name, Settings { depth, lights, ..small.clone() }));
        }
    }
    let watch = Watch { stop: &AtomicBool::new(false), tile: &|| () };
    let mut needed = Vec::new();
    let smooth_and_flat = pictures.iter().flat_map(|picture| [(picture, true), (picture, false)]);
    for ((name, settings), smooth) in smooth_and_flat {
        let mut scene = shipped(name);
        scene.instances.iter_mut().for_each(|instance| instance.smooth &= smooth);
        let stage = stage::<MollerTrumbore>(scene);
        let render = |parts: Parts| {
            let mut renderer = Renderer::new(&stage).keeping(parts);
            let image = renderer.render(settings, &watch).expect("nobody stopped it");
            (bits(&image), renderer.counts())
        };
        let parts = Renderer::new(&stage).facts().needs(settings);
        needed.push(parts);
        let own = render(Parts::NONE);
        for kept in Part::ALL.map(Parts::from).into_iter().chain([Parts::ALL]) {
            assert!(render(kept) == own, "{name} {settings:?}, with {kept:?}");
        }
    }
    for part in Part::ALL {
        let with = needed.iter().filter(|parts| parts.has(part)).count();
        assert!(with > 0 && with < needed.len(), "{part:?} is needed by {with} pictures");
    }
}

/// What is clear has a tree of its own, beside that of the rest.
#[test]
fn two_trees_are_more_than_one() {
    let mut scene = shipped("glass.toml");
    scene.spheres.clear();
    scene.planes.clear();
    let opaque = scene.materials.iter().position(|material| !material.is_clear());
    let mut other = scene.instances[0].clone();
    (other.mesh, other.material) = (scene.meshes.len(), opaque);
    other.to_world.translation += glam::Vec3A::new(0.3, 0.2, 0.5);
    scene.meshes.push(scene.meshes[0].clone());
    scene.instances.push(other);
    let settings = Settings { depth: 0, lights: 0, ..Settings::new([50, 37]) };
    let needs = |stage: &Stage| Renderer::new(stage).facts().needs(&settings);
    let both = stage::<MollerTrumbore>(scene.clone());
    assert_eq!(both.trees().count(), 2, "some is clear, some is not");
    assert!(needs(&both).has(Part::Shapes));
    for material in &mut scene.materials {
        material.transmission = glam::Vec3::ZERO;
    }
    let one = stage::<MollerTrumbore>(scene);
    assert!(!needs(&one).has(Part::Shapes));
    // Each is opaque to the camera, which sees the nearer of the two.
    assert_eq!(bits(&render(&both, &settings)), bits(&render(&one, &settings)));
}

#[test]
fn another_seed_is_another_picture() {
    let stage = stage::<MollerTrumbore>(shipped("textures.toml"));
    let settings = Settings { sampling: Sampling::Jittered(2), ..Settings::new([50, 37]) };
    let other = Settings { seed: 2, ..settings.clone() };
    let [one, two] = [settings, other].map(|settings| render(&stage, &settings));
    assert_ne!(bits(&one), bits(&two));
    assert!(one.difference(&two).0 < 0.08);
}

#[test]
fn pictures_hardly_depend_on_the_method() {
    for (name, settings) in pictures() {
        let one = render(&stage::<MollerTrumbore>(shipped(name)), &settings);
        let others = [
            render(&stage::<Watertight>(shipped(name)), &settings),
            render(&stage::<Wald>(shipped(name)), &settings),
        ];
        for other in others {
            let (root, share) = one.difference(&other);
            // Paths that part at an edge stay apart.
            assert!(root < 0.03 && share < 0.01, "{name}: {root} {share}");
        }
    }
}
