//! Shipped scenes: what the rasteriser sees is what the exact caster sees, and so is the picture made of it.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use trisect_core::Ray;
use trisect_exact::ExactInTrees;
use trisect_raster::{Blocks, NoCulling, Object, Rasteriser};
use trisect_render::{Renderer, Settings, Stage, Watch};
use trisect_scene::{Lens, SHIPPED, Scene};
use trisect_tracer::{Builder, Bvh, Tracing, Tree, TriangleHit};

/// A scene in trees of the exact method, and its places as objects.
fn staged(name: &str) -> (Stage, Vec<Object>) {
    let blocks = RefCell::new(Vec::new());
    let scene = Scene::shipped(name).expect("it is shipped");
    let stage = Stage::new(scene, |triangles| {
        blocks.borrow_mut().push(Arc::new(Blocks::new(triangles)));
        Ok(Box::new(Bvh::<ExactInTrees>::build(triangles, Builder::Spatial)?) as Box<dyn Tree>)
    })
    .expect("it takes every mesh");
    let blocks = blocks.into_inner();
    let objects = stage
        .placed()
        .map(|(number, place)| Object::carried(Arc::clone(&blocks[number]), *place))
        .collect();
    (stage, objects)
}

/// What the rasteriser sees, once it is held to the caster.
fn seen(
    name: &str,
    (stage, objects): (&Stage, &[Object]),
    settings: &Settings,
) -> Vec<Option<TriangleHit>> {
    let mut rays = stage.pixel_rays(settings);
    if let Lens::Thin { field_of_view, .. } = rays.camera().lens {
        rays = rays.with_lens(Lens::Pinhole { field_of_view });
    }
    let mut raster = Rasteriser::<NoCulling>::new();
    assert!(raster.draw(objects, &rays));
    let [width, height] = settings.size;
    let list: Vec<Ray<f32>> = (0..height)
        .flat_map(|y| (0..width).map(move |x| [x, y]))
        .map(|pixel| {
            let (o, d) = rays.ray(pixel);
            Ray::new(o, d)
        })
        .collect();
    let mut found = vec![None; list.len()];
    stage.closest(Tracing::Single, &list, &mut found);
    let seen = raster.hits(objects, &rays);
    let different = seen.iter().zip(&found).filter(|(a, b)| a != b).count();
    let (covered, judged) = (seen.iter().flatten().count(), raster.judged());
    println!("{name} {:?}: {covered} seen, {judged} judged, {different} different", settings.size);
    assert_eq!(different, 0, "{name}");
    seen
}

#[test]
fn every_shipped_scene_is_seen_exactly() {
    // By `TRISECT_FULL=1` at all sizes of `trisect raster --check`.
    let sizes: &[[u32; 2]] = if std::env::var_os("TRISECT_FULL").is_some() {
        &[[160, 120], [320, 240], [640, 480], [1024, 768], [1920, 1080]]
    } else {
        &[[64, 48], [150, 85]]
    };
    for (path, _) in SHIPPED {
        if [".toml", ".obj", ".ply"].iter().any(|ending| path.ends_with(ending)) {
            let (stage, objects) = staged(path);
            for camera in 0..stage.scene().cameras.len() {
                for &size in sizes {
                    let settings = Settings { camera, ..Settings::new(size) };
                    seen(path, (&stage, &objects), &settings);
                }
            }
        }
    }
}

#[test]
fn a_picture_of_what_is_rasterised_is_the_same_to_the_bit() {
    let mut covered = 0;
    for path in ["scenes/teapots.toml", "scenes/glass.toml", "meshes/teapot.ply"] {
        let (stage, objects) = staged(path);
        let settings = Settings::new([96, 72]);
        let seen = seen(path, (&stage, &objects), &settings);
        covered += seen.iter().flatten().count();
        let watch = Watch { stop: &AtomicBool::new(false), tile: &|| () };
        let cast = Renderer::new(&stage).render(&settings, &watch).expect("nobody stops it");
        let rasterised = Renderer::new(&stage).seeing(&seen).render(&settings, &watch);
        assert!(rasterised.expect("nobody stops it") == cast, "{path}");
        // What is handed in is what is shown.
        let nothing = vec![None; seen.len()];
        let empty = Renderer::new(&stage).seeing(&nothing).render(&settings, &watch);
        assert!(empty.expect("nobody stops it") != cast, "{path}");
    }
    assert!(covered > 3000);
}
