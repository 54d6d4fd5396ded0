//! What a scene answers, however it is asked.

use std::thread;

use trisect::{
    Crossings, Culling, Hit, Place, Precision, Ray, Scene, SceneError, SceneOptions, Triangle,
    UpdateError, Vec3, Verdict,
};
use trisect_workloads::{Aim, Placement, Stress, Surface, bunny, primary, random_through_box};

/// The same mesh by every method.
fn scenes<P: Precision>(triangles: &[Triangle<P>]) -> [Scene<P>; 3] {
    let options: [fn(SceneOptions<P>) -> SceneOptions<P>; 3] =
        [SceneOptions::exact, SceneOptions::fast, SceneOptions::watertight];
    options.map(|of| of(Scene::options()).from_triangles(triangles).expect("it takes all"))
}

/// Bits of all numbers, so that NaN and zeros of both signs are told apart.
fn bits<P: Precision>(hit: Option<Hit<P>>) -> Option<[u64; 4]> {
    let number = P::bits64;
    hit.map(|Hit { triangle, t, beta, gamma }| {
        [triangle.into(), number(t), number(beta), number(gamma)]
    })
}

fn agree_in<P: Precision>(triangles: &[Triangle<P>], rays: &[Ray<P>]) {
    for scene in scenes(triangles) {
        for culling in [Culling::None, Culling::Back, Culling::Front] {
            let view = scene.seen(culling);
            let (mut firsts, mut anys) = (vec![None; rays.len()], vec![false; rays.len()]);
            view.first_of(rays, &mut firsts);
            view.any_of(rays, &mut anys);
            for ((ray, first), any) in rays.iter().zip(firsts).zip(anys) {
                assert_eq!(bits(view.first(ray)), bits(first), "{culling:?} {ray:?}");
                assert_eq!(view.any(ray), any, "{culling:?} {ray:?}");
                assert_eq!(first.is_some(), any, "{culling:?} {ray:?}");
            }
        }
    }
}

/// In both precisions, between which the exact method decides alike.
fn agree(triangles: &[Triangle], rays: &[Ray]) {
    agree_in(triangles, rays);
    let (wide, wide_rays) = widened(triangles, rays);
    agree_in(&wide, &wide_rays);
    let narrow = Scene::from_triangles(triangles).expect("it takes all");
    let wide = Scene::from_triangles(&wide).expect("it takes all");
    for (ray, wide_ray) in rays.iter().zip(&wide_rays) {
        // No `t` that counts in f32 is beyond half its largest number.
        let most = f64::from(f32::MAX / 2.0);
        let tmax = if wide_ray.tmax > most { most } else { wide_ray.tmax };
        let tmin = if wide_ray.tmin < -most { -most } else { wide_ray.tmin };
        let wide_hit = wide.first(&wide_ray.with_interval(tmin, tmax));
        let hit = narrow.first(ray);
        assert_eq!(hit.map(|hit| hit.triangle), wide_hit.map(|hit| hit.triangle), "{ray:?}");
        #[allow(clippy::cast_possible_truncation, reason = "rounds")]
        if let (Some(hit), Some(wide_hit)) = (hit, wide_hit) {
            let off = (f64::from(hit.t) - wide_hit.t).abs();
            let size =
                f64::from(hit.t.abs()) * f64::from(f32::EPSILON) + f64::from(f32::MIN_POSITIVE);
            assert!(off <= size, "{ray:?}");
        }
    }
}

fn widened(triangles: &[Triangle], rays: &[Ray]) -> (Vec<Triangle<f64>>, Vec<Ray<f64>>) {
    let triangles = triangles.iter().map(|&triangle| triangle.into()).collect();
    (triangles, rays.iter().map(|&ray| ray.into()).collect())
}

#[test]
fn single_rays_and_batches_agree_on_meshes() {
    let bunny = bunny();
    let mut rays = primary(&bunny, 24, 24).rays;
    rays.extend(random_through_box(1, &bunny, 500).rays);
    agree(&bunny.triangles, &rays);
}

#[test]
fn single_rays_and_batches_agree_at_edges_and_vertices() {
    let placement = Placement::HERE;
    for surface in [Surface::sphere(2), Surface::cube(3), Surface::square(4)] {
        let aimed = [Aim::Edges, Aim::Vertices].map(|aim| {
            let features = surface.features(aim);
            let rays = features
                .iter()
                .step_by(3)
                .flat_map(|feature| surface.aimed::<f32>(feature, &placement, 1, 4));
            rays.collect::<Vec<Ray>>()
        });
        agree(&surface.triangles(&placement), &aimed.concat());
    }
}

/// Rays of random bits, along axes, behind the origin, with empty intervals, and not finite.
#[test]
fn single_rays_and_batches_agree_on_rays_of_all_kinds() {
    let sphere = Surface::sphere(2).triangles::<f32>(&Placement::HERE);
    let random = Stress::RandomBits.pairs::<f32>(1, 0.0, 1000);
    let mut rays: Vec<Ray> = random.into_iter().map(|(ray, _)| ray).collect();
    let inside = Ray::new([0.1, 0.2, 0.3], [1.0, 0.0, -0.0]);
    rays.extend([
        inside,
        inside.with_interval(f32::NEG_INFINITY, 0.0),
        inside.with_interval(-3.0, f32::INFINITY),
        inside.with_interval(2.0, 1.0),
        inside.with_interval(f32::NAN, 1.0),
        inside.with_interval(0.0, f32::NAN),
        Ray { d: [0.0, 0.0, 0.0].into(), ..inside },
        Ray { d: [-0.0, 1e-40, 0.0].into(), ..inside },
        Ray { o: [f32::NAN, 0.0, 0.0].into(), ..inside },
        Ray { d: [f32::INFINITY, 0.0, 0.0].into(), ..inside },
    ]);
    agree(&sphere, &rays);
    agree(&[], &rays);
    for scene in scenes(&sphere) {
        for nothing in &rays[rays.len() - 7..] {
            let is_tiny = nothing.d.y == 1e-40;
            assert!(is_tiny || scene.first(nothing).is_none(), "{nothing:?}");
        }
        assert!(scene.first(&inside).is_some_and(|hit| hit.t > 0.0));
        let behind = inside.with_interval(f32::NEG_INFINITY, 0.0);
        assert!(scene.first(&behind).is_some_and(|hit| hit.t < 0.0));
    }
}

#[test]
fn many_threads_ask_one_scene() {
    let bunny = bunny();
    let rays = random_through_box(3, &bunny, 2000).rays;
    for scene in scenes(&bunny.triangles) {
        let alone: Vec<_> = rays.iter().map(|ray| bits(scene.first(ray))).collect();
        let ask = || {
            assert!(rays.iter().map(|ray| bits(scene.first(ray))).eq(alone.iter().copied()));
        };
        thread::scope(|threads| {
            for _ in 0..4 {
                threads.spawn(ask);
            }
        });
    }
}

#[test]
fn hits_say_where_they_are() {
    let bunny = bunny();
    let scene = Scene::from_triangles(&bunny.triangles).expect("it takes all");
    let mut hits = 0;
    for ray in random_through_box(2, &bunny, 500).rays {
        let Some(hit) = scene.first(&ray) else { continue };
        hits += 1;
        let sum = f64::from(hit.alpha()) + f64::from(hit.beta) + f64::from(hit.gamma);
        assert!((sum - 1.0).abs() < 1e-6 && hit.alpha() >= 0.0, "{hit:?}");
        let (point, along) = (hit.point(&scene), ray.at(hit.t).to_array());
        let off = point.iter().zip(along).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5 * bunny.bounds.diagonal(), "{off}: {hit:?}");
        let normal = hit.normal(&scene);
        let length = normal.iter().map(|x| x * x).sum::<f32>();
        assert!((length - 1.0).abs() < 1e-6, "{normal:?}");
        let facing: f32 = normal.iter().zip(ray.d.to_array()).map(|(n, d)| n * d).sum();
        // The side that is seen says which way the normal points.
        let seen = if facing < 0.0 { Culling::Back } else { Culling::Front };
        assert_eq!(scene.seen(seen).first(&ray), Some(hit), "{ray:?}");
    }
    assert!(hits > 100);
}

#[test]
fn what_cannot_be_used_is_said() {
    let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, f32::NAN, 0.0], [0.0, 1.0, 0.0]];
    let of =
        |faces: &[[u32; 3]]| Scene::new(&vertices, faces).map(|_| ()).map_err(|e| e.to_string());
    assert_eq!(of(&[[0, 1, 3]]), Ok(()));
    assert_eq!(of(&[]), Ok(()));
    let there_is_not = "face 1 names vertex 4, but there are 4, numbered from 0";
    assert_eq!(of(&[[0, 1, 3], [0, 4, 1]]), Err(there_is_not.to_owned()));
    let not_finite = "vertex 2, a corner of face 0, is not finite: [0.0, NaN, 0.0]";
    assert_eq!(of(&[[0, 1, 2]]), Err(not_finite.to_owned()));
    let error = Scene::open("nowhere.obj").err().expect("there is no such file");
    assert!(matches!(error, SceneError::File(_)) && error.to_string().contains("nowhere.obj"));
}

#[test]
fn a_scene_is_read_from_a_file() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/block.obj");
    let scene = Scene::open(path).expect("it is shipped");
    assert_eq!(scene.triangles().len(), 12);
    assert_eq!(scene.statistics().references, 12);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("line.obj");
    std::fs::write(&file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n").expect("it is writable");
    let scene = Scene::options().fast().open(file).expect("a sound file");
    assert!(scene.notes()[0].to_string().contains("lines are left out"));
}

#[test]
fn a_scene_that_moves_answers_as_a_new_one() {
    let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0, 5.0, 5.0]];
    let faces = [[0, 1, 2], [0, 2, 3]];
    let moved = vertices.map(|[x, y, z]| [x + 10.0, y, z - 0.25 * x]);
    let mut scene = Scene::options().moving().build(&vertices, &faces).expect("sound");
    scene.update(&moved).expect("as many");
    let new = Scene::new(&moved, &faces).expect("sound");
    assert_eq!(scene.triangles(), new.triangles());
    for x in [0.25, 10.25] {
        let ray = Ray::new([x, 0.25, 9.0], [0.0, 0.0, -1.0]);
        assert_eq!(scene.first(&ray), new.first(&ray));
        assert_eq!(scene.first(&ray).is_some(), x > 1.0);
    }
    let error = scene.update(&moved[1..]).expect_err("one is missing");
    assert!(matches!(error, UpdateError::Count { made: 4, given: 3 }), "{error}");
    let mut broken = moved;
    broken[3][0] = f32::INFINITY;
    let error = scene.update(&broken).expect_err("infinite").to_string();
    assert_eq!(error, "vertex 3, a corner of face 1, is not finite: [inf, 5.0, 3.75]");
    // As before where it fails.
    assert_eq!(scene.triangles(), new.triangles());
    // Without faces the vertices are corners in order.
    let mut scene = Scene::from_triangles(new.triangles()).expect("sound");
    let corners: Vec<[f32; 3]> =
        new.triangles().iter().flat_map(|t| t.corners()).map(Vec3::to_array).collect();
    scene.update(&corners).expect("as many");
    assert_eq!(scene.triangles(), new.triangles());
}

#[test]
fn queries_agree_on_what_is_hit() {
    let bunny = bunny();
    let rays = random_through_box(4, &bunny, 500).rays;
    queries_agree(&bunny.triangles, &rays);
    let (triangles, rays) = widened(&bunny.triangles, &rays);
    queries_agree(&triangles, &rays);
}

fn queries_agree<P: Precision>(triangles: &[Triangle<P>], rays: &[Ray<P>]) {
    for (number, scene) in scenes(triangles).iter().enumerate() {
        for view in [scene.seen(Culling::None), scene.seen(Culling::Back)] {
            let (all_of, mut counts) = (view.all_of(rays), vec![0; rays.len()]);
            view.count_of(rays, &mut counts);
            let (mut hits, mut several) = (vec![], 0);
            for (place, ray) in rays.iter().enumerate() {
                view.all(ray, &mut hits);
                assert!(all_of.of(place).eq(hits.iter().copied()), "{ray:?}");
                assert_eq!(view.count(ray) as usize, hits.len(), "{ray:?}");
                assert_eq!(counts[place], view.count(ray), "{ray:?}");
                assert!(hits.is_sorted_by(|a, b| a.t <= b.t), "{hits:?}");
                let first = view.filtered(ray, |_| Verdict::Accept);
                assert_eq!(first, hits.first().copied(), "{ray:?}");
                let Some(first) = first else { continue };
                assert_eq!(view.first_but(ray, first.triangle), hits.get(1).copied(), "{ray:?}");
                several += usize::from(hits.len() > 1);
                // Only an exact method promises as much: the others may round apart in other loops.
                assert!(number > 0 || view.first(ray) == Some(first), "{ray:?}");
            }
            assert_eq!(all_of.hits().len(), *all_of.ends().last().expect("there are rays"));
            assert!(several > 50 || view.count(&rays[0]) < 2);
        }
    }
}

#[test]
fn a_point_is_inside_on_or_outside() {
    // One sphere within another: between them is inside, within both is a cavity.
    let of = |scale: f32| {
        let triangles = Surface::sphere(2).triangles::<f32>(&Placement::HERE);
        triangles.into_iter().map(move |triangle| triangle.map(|x| x * scale))
    };
    let triangles: Vec<Triangle> = of(1.0).chain(of(0.5)).collect();
    let scene = Scene::from_triangles(&triangles).expect("sound");
    let corner = triangles[0].corners()[0].to_array();
    let scaled = |by: f32| corner.map(|x| x * by);
    let places = [
        (scaled(1.0), Place::On),
        (scaled(0.75), Place::Inside),
        (scaled(0.5), Place::On),
        (scaled(0.25), Place::Outside),
        ([0.0; 3], Place::Outside),
        (scaled(1.5), Place::Outside),
        ([f32::NAN; 3], Place::Outside),
    ];
    let points = places.map(|(point, _)| point);
    assert_eq!(scene.contains_of(&points), Ok(places.map(|(_, place)| place).to_vec()));
    for (point, place) in places {
        assert_eq!(scene.contains(point), Ok(place), "{point:?}");
        // What a ray upwards says, but for points that lie on the surface.
        let crossings = scene.crossings(Crossings::Owned).count(&Ray::new(point, [0.0, 0.0, 1.0]));
        assert!(place == Place::On || (crossings % 2 == 1) == (place == Place::Inside));
    }
    let fast = Scene::options().fast().from_triangles(&triangles).expect("sound");
    let error = fast.contains([0.0; 3]).expect_err("it rounds");
    assert!(error.to_string().contains("exact"), "{error}");
}

/// A square of meters far from zero, in coordinates that f32 does not hold.
fn far_square() -> ([[f64; 3]; 4], [[u32; 3]; 2]) {
    let (x, y) = (448_262.125, 5_411_932.687_5);
    let vertices = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    (vertices.map(|[u, v]| [x + u, y + v, 320.1]), [[0, 1, 2], [0, 2, 3]])
}

#[test]
fn a_scene_of_f64_is_far_from_zero() {
    let (vertices, faces) = far_square();
    let scene = Scene::<f64>::new(&vertices, &faces).expect("sound");
    let fast = Scene::<f64>::options().fast().build(&vertices, &faces).expect("sound");
    let rounded = Scene::<f32>::options().build_rounded(&vertices, &faces).expect("sound");
    let down = |u: f64, v: f64| {
        Ray::new([vertices[0][0] + u, vertices[0][1] + v, 330.1], [0.0, 0.0, -2.0])
    };
    for scene in [&scene, &fast, &rounded] {
        let hit = scene.first(&down(0.75, 0.25)).expect("it is above the first triangle");
        assert_eq!(hit.triangle, 0);
        for (found, expected) in
            [(hit.t, 5.0), (hit.alpha(), 0.25), (hit.beta, 0.5), (hit.gamma, 0.25)]
        {
            assert!((found - expected).abs() < 1e-6, "{hit:?}");
        }
        let [x, y, z] = hit.point(scene);
        let off = [x - vertices[0][0] - 0.75, y - vertices[0][1] - 0.25, z - 320.1];
        assert!(off.iter().all(|off| off.abs() < 1e-6), "{off:?}");
        assert_eq!(hit.normal(scene), [0.0, 0.0, 1.0]);
        assert!(scene.any(&down(0.25, 0.75)) && !scene.any(&down(1.001, 0.5)));
        let (mut all, ray) = (vec![], down(0.5, 0.25));
        scene.all(&ray, &mut all);
        assert_eq!((all.len(), scene.count(&ray)), (1, 1));
        assert_eq!(scene.filtered(&ray, |_| Verdict::Accept), scene.first(&ray));
        assert_eq!(scene.first_but(&ray, 0), None);
        let (mut firsts, mut anys) = ([None; 2], [false; 2]);
        let rays = [ray, down(-0.001, 0.5)];
        scene.first_of(&rays, &mut firsts);
        scene.any_of(&rays, &mut anys);
        assert_eq!((firsts, anys), ([scene.first(&ray), None], [true, false]));
    }
    // Along the diagonal both are hit, and one owns the crossing.
    for scene in [&scene, &rounded] {
        let ray = down(0.5, 0.5);
        assert_eq!(scene.count(&ray), 2);
        assert_eq!(scene.crossings(Crossings::Owned).count(&ray), 1);
    }
}

#[test]
fn a_scene_of_f64_moves() {
    let (vertices, faces) = far_square();
    let moved = vertices.map(|[x, y, z]| [x + 1e3, y, z + 0.125 * (x - 448_262.0)]);
    let fresh = Scene::<f64>::new(&moved, &faces).expect("sound");
    let exact = Scene::<f64>::options().moving().build(&vertices, &faces).expect("sound");
    let rounded = Scene::<f32>::options().moving().build_rounded(&vertices, &faces).expect("sound");
    for mut scene in [exact, rounded] {
        scene.update(&moved).expect("as many");
        let ray = Ray::new([moved[0][0] + 0.25, moved[0][1] + 0.5, 400.0], [0.0, 0.0, -1.0]);
        let (found, expected) = (scene.first(&ray).expect("a hit"), fresh.first(&ray));
        let expected = expected.expect("a hit");
        assert_eq!(found.triangle, expected.triangle);
        assert!((found.t - expected.t).abs() < 1e-4, "{found:?} {expected:?}");
        let error = scene.update(&moved[1..]).expect_err("one is missing");
        assert!(matches!(error, UpdateError::Count { made: 4, given: 3 }), "{error}");
    }
}

#[test]
fn files_keep_their_f64() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("far.obj");
    let (vertices, _) = far_square();
    let lines = vertices.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    std::fs::write(&file, lines + "f 1 2 3\nf 1 3 4\n").expect("it is writable");
    let scene = Scene::open_f64(&file).expect("a sound file");
    let corners: Vec<[f64; 3]> =
        scene.triangles()[0].corners().into_iter().map(Vec3::to_array).collect();
    assert_eq!(corners, vertices[..3]);
    assert_eq!(Scene::open(&file).expect("a sound file").triangles().len(), 2);
}
