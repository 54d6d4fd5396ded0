//! The filtered rasteriser sees what the exact caster sees, on every pixel.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use trisect_core::{Ray, Triangle};
use trisect_exact::ExactInTrees;
use trisect_method::Culling;
use trisect_raster::{
    Bare, Blocks, CullBy, Culls, Filtered, NoCulling, Object, PerspectiveCulling, Rasteriser, Scan,
    clip, hostile,
};
use trisect_scene::{Camera, Lens, PixelRays};
use trisect_tracer::{Builder, Bvh, Instances, Tracing, Transform, Tree, TriangleHit};

fn tree(triangles: &[Triangle<f32>]) -> Box<dyn Tree> {
    Box::new(Bvh::<ExactInTrees>::build(triangles, Builder::Spatial).expect("it takes every mesh"))
}

/// What a tree's rays hit, row by row.
fn cast(tree: &dyn Tree, culling: Culling, rays: &PixelRays) -> Vec<Option<TriangleHit>> {
    let [width, height] = rays.size();
    let rays: Vec<Ray<f32>> = (0..height)
        .flat_map(|y| (0..width).map(move |x| [x, y]))
        .map(|pixel| {
            let (o, d) = rays.ray(pixel);
            Ray::new(o, d)
        })
        .collect();
    let mut found = vec![None; rays.len()];
    tree.closest(Tracing::Single, culling, &rays, &mut found);
    found
}

/// Draws objects and holds what is seen, with its values, to a tree's answers. How many pixels see anything.
fn agree<C: Culls>(name: &str, objects: &[Object], tree: &dyn Tree, rays: &PixelRays) -> usize {
    let culling = if C::BY == CullBy::Nothing { Culling::None } else { Culling::Back };
    let mut raster = Rasteriser::<C, Filtered>::new();
    assert!(raster.draw(objects, rays));
    let (seen, cast) = (raster.hits(objects, rays), cast(tree, culling, rays));
    let wrong = seen.iter().zip(&cast).filter(|(seen, cast)| seen != cast).count();
    assert_eq!(wrong, 0, "{name} at {:?} through {:?}", rays.size(), rays.camera().lens);
    seen.iter().flatten().count()
}

/// The bunny's triangles, its middle and its size.
fn bunny() -> (Vec<Triangle<f32>>, Vec3, f32) {
    let bunny = trisect_workloads::bunny();
    let (middle, size) = (bunny.bounds.center(), bunny.bounds.diagonal());
    (bunny.triangles.to_vec(), middle.into(), size)
}

fn object(triangles: &[Triangle<f32>]) -> [Object; 1] {
    [Object::new(Arc::new(Blocks::new(triangles)))]
}

#[test]
fn hostile_scenes_are_seen_exactly() {
    for size in [[1, 1], [33, 17], [96, 64], [130, 70]] {
        let mut seen = 0;
        for scene in hostile::scenes(size) {
            let rays = PixelRays::new(scene.camera.clone(), size);
            let (objects, tree) = (object(&scene.triangles), tree(&scene.triangles));
            seen += agree::<NoCulling>(scene.name, &objects, &*tree, &rays);
            agree::<PerspectiveCulling>(scene.name, &objects, &*tree, &rays);
        }
        assert!(seen > 0);
    }
}

fn cameras(at: Vec3, size: f32) -> Vec<Camera> {
    let lenses = [
        Lens::Pinhole { field_of_view: 0.7 },
        Lens::Pinhole { field_of_view: 2.0 },
        Lens::Orthographic { height: size },
    ];
    let from = [Vec3::new(0.3, 0.2, 1.2), Vec3::new(0.01, 0.02, 0.1)];
    let pairs = lenses.into_iter().flat_map(|lens| from.map(|from| (lens, from)));
    pairs
        .map(|(lens, from)| {
            Camera::looking(at + from * size, at, Vec3::Y, lens).expect("a direction")
        })
        .collect()
}

#[test]
fn the_bunny_is_seen_exactly_from_outside_and_inside() {
    let (bunny, middle, size) = bunny();
    let (objects, tree) = (object(&bunny), tree(&bunny));
    for camera in cameras(middle, size) {
        let rays = PixelRays::new(camera, [160, 120]);
        assert!(agree::<NoCulling>("the bunny", &objects, &*tree, &rays) > 100);
        agree::<PerspectiveCulling>("the bunny", &objects, &*tree, &rays);
    }
}

#[test]
fn instances_are_seen_as_rays_are_carried_to_them() {
    let (bunny, middle, size) = bunny();
    let mesh = Arc::new(Blocks::new(&bunny));
    let shared: Arc<Box<dyn Tree>> = Arc::new(tree(&bunny));
    let places: Vec<Affine3A> = (0..9_u8)
        .map(|i| {
            let i = f32::from(i);
            Affine3A::from_scale_rotation_translation(
                Vec3::new(1.0 + 0.3 * i, 2.0 - 0.2 * i, if i > 4.0 { -1.0 } else { 1.5 }),
                Quat::from_rotation_y(i) * Quat::from_rotation_x(0.3 * i),
                Vec3::new(0.5 * (i % 3.0), 0.4 * (i / 3.0).floor(), 0.1 * i) * size,
            )
        })
        // Twice in the same place: the first instance is seen.
        .chain([Affine3A::IDENTITY, Affine3A::IDENTITY])
        .collect();
    let all = Instances::new(places.iter().map(|&place| (Arc::clone(&shared), place)))
        .expect("they can be placed");
    let objects: Vec<Object> = places
        .iter()
        .map(|&place| {
            Object::carried(Arc::clone(&mesh), Transform::new(place).expect("it has an inverse"))
        })
        .collect();
    for camera in cameras(middle, 2.0 * size) {
        let rays = PixelRays::new(camera, [120, 90]);
        assert!(agree::<NoCulling>("instances", &objects, &all, &rays) > 1000);
    }
}

#[test]
fn corners_in_the_world_are_computed_when_an_object_moves() {
    let (bunny, ..) = bunny();
    let place = |x: f32| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0));
    let mut object = Object::placed(Arc::new(Blocks::new(&bunny)), place(1.0));
    let at = |object: &Object| Vec3::from(object.triangles().triangle(12).a);
    let own = Vec3::from(bunny[12].a);
    assert_eq!(at(&object), own + Vec3::X);
    assert!(!object.move_to(place(1.0)));
    assert!(object.move_to(place(2.0)));
    assert_eq!(at(&object), own + Vec3::X * 2.0);
    assert_eq!(object.triangles().len(), bunny.len());
    // What rays are carried to stays.
    let transform = Transform::new(place(1.0)).expect("it has an inverse");
    let mut carried = Object::carried(Arc::new(Blocks::new(&bunny)), transform);
    assert!(!carried.move_to(place(2.0)));
    assert_eq!(at(&carried), own);
}

#[test]
fn what_is_seen_does_not_depend_on_threads() {
    let (bunny, middle, size) = bunny();
    let objects = object(&bunny);
    let camera = cameras(middle, size).remove(0);
    let rays = PixelRays::new(camera, [320, 200]);
    let drawn = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut raster = Rasteriser::<NoCulling, Filtered>::new();
            assert!(raster.draw(&objects, &rays));
            raster.hits(&objects, &rays)
        })
    };
    let one = drawn(1);
    assert_eq!(one, drawn(3));
    assert_eq!(one, drawn(2));
}

#[test]
fn the_bare_one_and_spans_are_nearly_right() {
    let (bunny, middle, size) = bunny();
    let objects = object(&bunny);
    let camera = cameras(middle, size).remove(0);
    let rays = PixelRays::new(camera, [320, 240]);
    let mut exact = Rasteriser::<NoCulling, Filtered>::new();
    let (mut bare, mut spans) = (Rasteriser::<NoCulling, Bare>::new(), Scan::default());
    assert!(
        exact.draw(&objects, &rays) && bare.draw(&objects, &rays) && spans.draw(&objects, &rays)
    );
    let pixels = || (0..240).flat_map(|y| (0..320).map(move |x| [x, y]));
    let differ = |other: &dyn Fn([u32; 2]) -> Option<u32>| {
        pixels().filter(|&pixel| exact.seen(pixel) != other(pixel)).count()
    };
    assert!(pixels().filter(|&pixel| exact.seen(pixel).is_some()).count() > 5000);
    assert!(differ(&|pixel| bare.seen(pixel)) < 40);
    assert!(differ(&|pixel| spans.seen(pixel)) < 400);
    assert!(exact.judged() > 0 && bare.judged() == 0);
}

#[test]
fn a_plane_leaves_none_one_or_two_triangles() {
    let corners = |z: [f32; 3]| [0, 1, 2].map(|i| Vec3::new(i as f32, (i * i) as f32, z[i]));
    let count = |z| clip(corners(z), 1.0).1;
    assert_eq!(count([0.0, 0.5, 0.9]), 0);
    assert_eq!(count([2.0, 0.5, 0.9]), 1);
    assert_eq!(count([2.0, 0.5, 1.0]), 2);
    assert_eq!(count([1.0, 1.0, 1.0]), 1);
    // What is left has the area that it has.
    let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length();
    let whole = corners([0.0, 2.0, 3.0]);
    let (parts, count) = clip(whole, 1.0);
    let (others, rest) = clip(whole.map(|corner| corner.with_z(-corner.z)), -1.0);
    let total: f32 = parts[..count].iter().chain(&others[..rest]).map(|&part| area(part)).sum();
    assert!((total - area(whole)).abs() < 1e-5, "{total}");
}
