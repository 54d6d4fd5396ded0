//! Scenes of scenes: what is hit, where, and what memory and motion cost.

use std::sync::Arc;

use trisect::{
    Culling, Hit, InstanceError, Place, Ray, Scene, Transform, Triangle, Update, UpdateError, Vec3,
    Verdict,
};
use trisect_workloads::{Placement, Surface, bunny, random_through_box};

const HERE: Transform = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Stretched along the axes, mirrored where a number is negative, and moved.
fn stretched([x, y, z]: [f32; 3], [to_x, to_y, to_z]: [f32; 3]) -> Transform {
    [[x, 0.0, 0.0, to_x], [0.0, y, 0.0, to_y], [0.0, 0.0, z, to_z]]
}

/// Of radius 1, its fronts outside.
fn ball() -> Arc<Scene> {
    let onto = |corner: Vec3<f32>| corner.scale(1.0 / corner.dot(corner).sqrt());
    let outwards = |triangle: Triangle| {
        let [a, b, c] = triangle.corners().map(onto);
        let is_outwards = Triangle { a, b, c }.normal().dot(a) > 0.0;
        if is_outwards { Triangle { a, b, c } } else { Triangle { a, b: c, c: b } }
    };
    let triangles = Surface::sphere(3).triangles(&Placement::HERE).into_iter();
    let triangles: Vec<Triangle> = triangles.map(outwards).collect();
    Arc::new(Scene::from_triangles(&triangles).expect("it takes all"))
}

/// How far two points are apart.
fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
}

#[test]
fn hits_are_where_they_are_in_the_world() {
    let ball = ball();
    let count = ball.triangles().len();
    // An ellipsoid, the same mirrored, and both in a scene that is mirrored and stretched again.
    let pair = Arc::new(
        Scene::instances(&[
            (Arc::clone(&ball), stretched([1.0, 2.0, 0.5], [0.0; 3])),
            (ball, stretched([-1.0, 2.0, 0.5], [5.0, 0.0, 0.0])),
        ])
        .expect("they are sound"),
    );
    let scene = Scene::instances(&[
        (Arc::clone(&pair), HERE),
        (pair, stretched([1.0, 1.0, -3.0], [0.0, 10.0, 0.0])),
    ])
    .expect("they are sound");
    let mut hits = 0;
    for (instance, y, high) in [(0, 0.0, 0.5), (1, 10.0, 1.5)] {
        for (inner, x) in [(0, 0.0), (1, 5.0)] {
            for off in [[0.1, 0.2], [-0.3, 0.7], [0.6, -0.8]] {
                let [p, q] = [x + off[0], y + off[1]];
                let ray = Ray::new([p, q, 20.0], [0.0, 0.0, -1.0]);
                let hit = scene.first(&ray).expect("it is above a ball");
                hits += 1;
                assert_eq!(hit.path(&scene).collect::<Vec<_>>(), [instance, inner]);
                let (mesh, triangle) = hit.in_mesh(&scene);
                assert_eq!(mesh.triangles().len(), count);
                assert_eq!(
                    hit.triangle as usize,
                    (2 * instance + inner) * count + triangle as usize
                );
                let point = hit.point(&scene);
                assert!(apart(point, ray.at(hit.t).to_array()) < 1e-5, "{point:?}");
                // The normal of an ellipsoid, up to the size of triangles: outwards, mirrored or not.
                let expected = [off[0], off[1] / 4.0, point[2] / (high * high)];
                let length = apart(expected, [0.0; 3]);
                let normal = hit.normal(&scene);
                assert!(apart(normal, expected.map(|x| x / length)) < 0.2, "{normal:?}");
                assert!((apart(normal, [0.0; 3]) - 1.0).abs() < 1e-6);
                // From outside every front is seen, and no back.
                assert_eq!(scene.seen(Culling::Back).first(&ray), Some(hit));
                let back = scene.seen(Culling::Front).first(&ray).expect("the other side");
                assert!(back.t > hit.t && back.normal(&scene)[2] < 0.0);
                // `t` counts lengths of a direction that is not made of unit length.
                let longer = Ray::new([p, q, 20.0], [0.0, 0.0, -4.0]);
                let same = scene.first(&longer).expect("it is the same");
                assert_eq!((same.triangle, same.t * 4.0), (hit.triangle, hit.t));
            }
        }
    }
    assert_eq!(hits, 12);
}

#[test]
fn every_query_sees_every_instance() {
    let ball = ball();
    let placed: Vec<(Arc<Scene>, Transform)> = (0..20_u8)
        .map(|k| (Arc::clone(&ball), stretched([1.0; 3], [3.0 * f32::from(k), 0.0, 0.0])))
        .collect();
    let scene = Scene::instances(&placed).expect("they are sound");
    let along = Ray::new([-5.0, 0.03, 0.05], [1.0, 0.0, 0.0]);
    let mut hits = vec![];
    scene.all(&along, &mut hits);
    assert_eq!((hits.len(), scene.count(&along)), (40, 40));
    let path = |hit: &Hit| hit.path(&scene).next();
    assert!(hits.iter().map(path).eq((0..20).flat_map(|k| [Some(k); 2])));
    assert_eq!(scene.first(&along), Some(hits[0]));
    assert_eq!(scene.first_but(&along, hits[0].triangle), Some(hits[1]));
    let third = scene.filtered(&along, |hit| match path(hit) {
        Some(2) => Verdict::Accept,
        _ => Verdict::Ignore,
    });
    assert_eq!(third, Some(hits[4]));
    assert!(!scene.any(&along.with_interval(0.0, 3.5)) && scene.any(&along));
    let rays = [along, Ray::new([0.0, 0.0, 9.0], [0.0, 1.0, 0.0])];
    let (mut firsts, mut anys, mut counts) = ([None; 2], [false; 2], [9; 2]);
    scene.first_of(&rays, &mut firsts);
    scene.any_of(&rays, &mut anys);
    scene.count_of(&rays, &mut counts);
    assert_eq!((firsts, anys, counts), ([Some(hits[0]), None], [true, false], [40, 0]));
    assert!(scene.all_of(&rays).of(0).eq(hits));
    let places = scene.contains_of(&[[57.0, 0.0, 0.0], [55.5, 0.0, 0.0], [0.0, 0.0, -2.0]]);
    assert_eq!(places, Ok(vec![Place::Inside, Place::Outside, Place::Outside]));
    // One mesh is in memory, however often it is placed.
    let bytes = scene.statistics().bytes - ball.statistics().bytes;
    assert!(bytes < 20 * 400, "{bytes}");
}

#[test]
fn single_rays_allocate_nothing() {
    // Without lanes that fuse, rays take the way of batches.
    if trisect_tracer::fast_lanes().0 < trisect_core::InstructionSet::Avx2 {
        println!("skipped: this processor has no fast lanes");
        return;
    }
    let bunny = bunny();
    let rays = random_through_box(1, &bunny, 300).rays;
    for options in [Scene::options(), Scene::options().fast()] {
        let mesh = Arc::new(options.from_triangles(&bunny.triangles).expect("it takes all"));
        let by = bunny.bounds.diagonal() * 0.1;
        let pair = [HERE, stretched([-1.0, 1.1, 0.9], [by, 0.0, by])];
        let pair = Scene::instances(&pair.map(|at| (Arc::clone(&mesh), at))).expect("sound");
        let pair = Arc::new(pair);
        let scene = Scene::instances(&[
            (Arc::clone(&pair), HERE),
            (pair, stretched([1.0, 1.0, -1.0], [0.0, by, 0.0])),
            (mesh, stretched([0.5; 3], [by; 3])),
        ])
        .expect("they are sound");
        let mut all = vec![];
        let mut ask = || {
            let mut hits = 0;
            for ray in &rays {
                let hit = scene.first(ray);
                assert_eq!(hit.is_some(), scene.any(ray));
                scene.all(ray, &mut all);
                assert_eq!(scene.count(ray) as usize, all.len());
                assert_eq!(scene.filtered(ray, |_| Verdict::Accept).is_some(), hit.is_some());
                if let Some(hit) = hit {
                    hits += 1;
                    scene.first_but(ray, hit.triangle);
                    assert!(hit.path(&scene).count() > 0);
                    assert!(apart(hit.point(&scene), hit.normal(&scene)) > 0.0);
                }
            }
            hits
        };
        // The first time makes room for what is gathered.
        let mut hits = ask();
        let counted = allocation_counter::measure(|| hits += ask());
        assert_eq!(counted.count_total, 0);
        assert!(hits > 100);
    }
}

#[test]
fn what_cannot_be_placed_is_an_error_that_names_it() {
    let ball = ball();
    let flat = stretched([1.0, 0.0, 1.0], [0.0; 3]);
    let error = Scene::instances(&[(Arc::clone(&ball), HERE), (Arc::clone(&ball), flat)]);
    let error = error.err().expect("it is singular").to_string();
    assert!(error.starts_with("the transform of instance 1 is singular"), "{error}");
    let mut scene = Scene::instances(&[(Arc::clone(&ball), HERE)]).expect("it is sound");
    let nowhere = stretched([1.0; 3], [f32::NAN, 0.0, 0.0]);
    let error = scene.set_transform(0, &nowhere).expect_err("not finite").to_string();
    assert!(error.starts_with("the transform of instance 0 is not finite"), "{error}");
    let error = scene.set_transform(3, &HERE).expect_err("there is one").to_string();
    assert_eq!(error, "there is no instance 3: there are 1, numbered from 0");
    assert_eq!(scene.set_transforms(&[]), Err(InstanceError::Count { instances: 1, given: 0 }));
    assert!(matches!(scene.update(&[]), Err(UpdateError::Instances)));
    // A mesh has none to be moved.
    let mut mesh = Scene::from_triangles(ball.triangles()).expect("it takes all");
    assert!(mesh.set_transform(0, &HERE).is_err() && mesh.set_transforms(&[HERE]).is_err());
    // And a scene of nothing is hit by nothing.
    let nothing = Scene::instances(&[]).expect("there may be none");
    let ray = Ray::new([0.0; 3], [1.0, 0.0, 0.0]);
    assert!(nothing.first(&ray).is_none() && !nothing.any(&ray) && nothing.count(&ray) == 0);
}

/// The mesh twisted about the last axis.
fn twisted(triangles: &[Triangle], by: f32) -> Vec<[f32; 3]> {
    let corners = triangles.iter().flat_map(|triangle| triangle.corners());
    let turned = corners.map(|corner| {
        let (sin, cos) = (by * corner.z).sin_cos();
        [cos * corner.x - sin * corner.y, sin * corner.x + cos * corner.y, corner.z]
    });
    turned.collect()
}

#[test]
fn a_mesh_that_moves_is_fitted_until_that_is_worn() {
    let bunny = bunny();
    let triangles = &bunny.triangles;
    let still: Vec<[f32; 3]> =
        triangles.iter().flat_map(|t| t.corners()).map(Vec3::to_array).collect();
    let mut scene = Scene::options().moving().from_triangles(triangles).expect("it takes all");
    let built = scene.statistics().cost;
    let update = scene.update(&still).expect("as many");
    assert!(matches!(update, Update::Refitted { cost } if (cost - 1.0).abs() < 1e-3), "{update:?}");
    let size = bunny.bounds.diagonal();
    let update = scene.update(&twisted(triangles, 0.05 / size)).expect("as many");
    assert!(matches!(update, Update::Refitted { .. }), "{update:?}");
    let moved = twisted(triangles, 60.0 / size);
    let update = scene.update(&moved).expect("as many");
    assert_eq!(update, Update::Rebuilt);
    let new = Scene::options().moving().from_triangles(scene.triangles()).expect("it takes all");
    assert_eq!(scene.statistics(), new.statistics());
    assert!(built > 0.0);
    for ray in random_through_box(5, &bunny, 300).rays {
        assert_eq!(scene.first(&ray), new.first(&ray));
    }
    // A triangle that had no area is built in when it has one.
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut scene = Scene::new(&[corners[0]; 3], &[[0, 1, 2]]).expect("it is sound");
    assert_eq!(scene.update(&corners).expect("as many"), Update::Rebuilt);
    assert!(scene.any(&Ray::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0])));
}

#[test]
fn instances_that_move_refit_the_top_alone() {
    let ball = ball();
    let row = |by: f32| -> Vec<Transform> {
        (0..50_u8).map(|k| stretched([1.0; 3], [3.0 * f32::from(k) + by, 0.0, 0.0])).collect()
    };
    let placed: Vec<(Arc<Scene>, Transform)> =
        row(0.0).into_iter().map(|at| (Arc::clone(&ball), at)).collect();
    let mut scene = Scene::instances(&placed).expect("they are sound");
    let nodes = scene.statistics().nodes;
    let update = scene.set_transforms(&row(0.5)).expect("they are sound");
    assert!(matches!(update, Update::Refitted { cost } if cost < 1.01), "{update:?}");
    assert_eq!(scene.statistics().nodes, nodes);
    let down = |x: f32| Ray::new([x, 0.1, 5.0], [0.0, 0.0, -1.0]);
    let first =
        |scene: &Scene, x: f32| scene.first(&down(x)).and_then(|hit| hit.path(scene).next());
    assert_eq!((first(&scene, 30.5), first(&scene, 29.0)), (Some(10), None));
    // All change places, again and again: the order of the tree is worth nothing then.
    let in_order = row(0.0);
    let shuffled: Vec<Transform> = (0..50).map(|k| in_order[k * 37 % 50]).collect();
    assert_eq!(scene.set_transforms(&shuffled).expect("they are sound"), Update::Rebuilt);
    let at = shuffled.iter().position(|at| at[0][3] == 30.0);
    assert_eq!(first(&scene, 30.0), at);
}
