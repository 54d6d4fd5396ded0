//! A picture allocates nothing, once there is room for it.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use trisect_raster::{
    Bare, Blocks, Filtered, Gouraud, NoCulling, Object, Painter, Perspective, PerspectiveCulling,
    Phong, Rasteriser, Scenery, Shading,
};
use trisect_scene::{Camera, Lens, PixelRays, Scene};

/// On this thread alone, whose allocations are counted.
fn alone<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(work)
}

#[test]
fn a_picture_allocates_nothing() {
    alone(|| {
        let bunny = trisect_workloads::bunny();
        let (at, size) = (Vec3::from(bunny.bounds.center()), bunny.bounds.diagonal());
        let mesh = Arc::new(Blocks::new(&bunny.triangles));
        let mut objects =
            [Object::new(Arc::clone(&mesh)), Object::placed(mesh, Affine3A::IDENTITY)];
        let lens = Lens::Pinhole { field_of_view: 0.7 };
        let camera = Camera::looking(at + Vec3::new(0.3, 0.2, 1.2) * size, at, Vec3::Y, lens);
        let rays = PixelRays::new(camera.expect("a direction"), [200, 150]);
        let mut exact = Rasteriser::<NoCulling, Filtered>::new();
        let mut bare = Rasteriser::<PerspectiveCulling, Bare>::new();
        let mut draw = |z: f32| {
            objects[1].move_to(Affine3A::from_translation(Vec3::new(0.1, 0.0, z) * size));
            assert!(exact.draw(&objects, &rays) && bare.draw(&objects, &rays));
        };
        draw(0.0);
        draw(0.01);
        let counted = allocation_counter::measure(|| draw(0.0));
        assert_eq!(counted.count_total, 0);
        let pixels = || (0..150).flat_map(|y| (0..200).map(move |x| [x, y]));
        assert!(pixels().filter(|&pixel| exact.seen(pixel).is_some()).count() > 2000);
        assert!(exact.judged() > 0);
    });
}

fn paint<S: Shading>() {
    let scene = Scene::shipped("scenes/teapots.toml").expect("it is shipped");
    let scenery = Scenery::new(&scene, 2);
    let rays = scenery.rays(0, [160, 120]);
    let mut painter = Painter::<S, Perspective>::default();
    assert!(painter.paint(&scenery, &rays));
    let first = painter.pixels();
    let counted = allocation_counter::measure(|| assert!(painter.paint(&scenery, &rays)));
    assert_eq!(counted.count_total, 0);
    assert!(painter.pixels() == first);
    assert!(first.iter().any(|pixel| *pixel != first[0]));
}

#[test]
fn a_painted_picture_allocates_nothing() {
    alone(|| {
        paint::<Phong>();
        paint::<Gouraud>();
        // The count counts.
        let counted = allocation_counter::measure(|| drop(std::hint::black_box(Box::new(1))));
        assert_eq!(counted.count_total, 1);
    });
}
