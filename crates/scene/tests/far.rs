//! Scenes far from 0 are those near it, and scenes of any size have the same proportions.
#![allow(missing_docs, reason = "tests")]

use std::fs;
use std::path::Path;

use trisect_scene::{DVec3, Light, Scene, Vec3};

/// Corners of a mesh, of few bits.
const CORNERS: [[f64; 3]; 4] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.25], [0.375, 1.0, 0.0], [0.0, 0.625, 1.5]];

fn obj(at: DVec3, size: f64) -> String {
    let vertex = |corner: [f64; 3]| {
        let [x, y, z] = ((DVec3::from(corner) + at) * size).to_array();
        format!("v {x:?} {y:?} {z:?}\n")
    };
    CORNERS.map(vertex).concat() + "f 1 2 3\nf 1 3 4\n"
}

/// A scene as far away as `at`, with a mesh as far from its own 0 as `own`; all lengths times `size`.
fn scene(at: DVec3, own: DVec3, size: f64) -> Scene {
    let place = |x: f64, y: f64, z: f64| {
        let [x, y, z] = ((DVec3::new(x, y, z) + at) * size).to_array();
        format!("[{x:?}, {y:?}, {z:?}]")
    };
    let DVec3 { x, y, z } = DVec3::new(0.125, 0.25, -0.5) - own;
    let text = format!(
        "[[camera]]\nkind = 'pinhole'\neye = {}\nlook_at = {}\nfield_of_view = 40\n\
         [[light]]\nkind = 'point'\nposition = {}\nintensity = [1, 1, 1]\n\
         [material.a]\n[mesh.m]\nfile = 'm.obj'\n\
         [[instance]]\nmesh = 'm'\nmaterial = 'a'\ntranslate = {}\n\
         [[sphere]]\ncenter = {}\nradius = {:?}\nmaterial = 'a'\n\
         [[plane]]\npoint = {}\nnormal = [0, 1, 0]\nmaterial = 'a'\n",
        place(0.5, 1.25, 5.0),
        place(0.25, 0.0, 0.0),
        place(2.0, 3.0, 1.0),
        place(x, y, z),
        place(-1.0, 0.5, 0.0),
        0.5 * size,
        place(0.0, -1.0, 0.0),
    );
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("m.obj"), obj(own, size)).expect("it is written");
    Scene::from_toml("s.toml", &text, Some(folder.path())).unwrap_or_else(|error| panic!("{error}"))
}

/// Where everything of a scene is, in one order.
fn positions(scene: &Scene) -> Vec<Vec3> {
    let Light::Point { position, .. } = scene.lights[0] else { panic!("a point") };
    let camera = scene.cameras[0].eye;
    let mut all = vec![camera, position, scene.spheres[0].center, scene.planes[0].point];
    for instance in &scene.instances {
        for triangle in &scene.meshes[instance.mesh].triangles {
            let corners = triangle.corners().map(Vec3::from);
            all.extend(corners.map(|corner| instance.to_world.transform_point3(corner)));
        }
    }
    all
}

#[test]
fn a_scene_far_away_is_the_one_nearby() {
    let near = scene(DVec3::ZERO, DVec3::ZERO, 1.0);
    assert_eq!(
        (near.origin, near.meshes[0].origin, near.rounding),
        (DVec3::ZERO, DVec3::ZERO, 0.0)
    );
    let far_away = [
        DVec3::new(1e6, -4e5, 3e5),
        DVec3::new(0.0, 0.0, 7e6),
        DVec3::new(-1e9, 1e9, 1e9),
        DVec3::new(500_000.0, 5_400_000.0, 300.0),
    ];
    for at in far_away {
        for own in [DVec3::ZERO, at] {
            let far = scene(at, own, 1.0);
            let shift = (at - far.origin).as_vec3();
            assert!(shift.length() < 16.0, "{}", far.origin);
            let expected: Vec<Vec3> = positions(&near).iter().map(|&p| p + shift).collect();
            assert_eq!(positions(&far), expected, "{at} {own}");
            assert_eq!(far.cameras[0].forward, near.cameras[0].forward);
            assert_eq!(
                (far.meshes[0].origin != DVec3::ZERO, far.rounding),
                (own != DVec3::ZERO, 0.0)
            );
        }
    }
    // Not far: a few sizes away every bit stays.
    let at = DVec3::new(48.0, 0.0, -16.0);
    let scene = scene(at, DVec3::ZERO, 1.0);
    assert_eq!((scene.origin, scene.cameras[0].eye), (DVec3::ZERO, Vec3::new(48.5, 1.25, -11.0)));
}

#[test]
fn a_plane_may_be_given_by_a_point_far_away() {
    let text = |texture: &str| {
        format!(
            "[[camera]]\nkind = 'pinhole'\neye = [1e6, 0, 3]\nlook_at = [1e6, 0, 0]\nfield_of_view = 40\n\
             [texture.t]\nchecker = [[0, 0, 0], [1, 1, 1]]\nscale = [0.75, 0.3]\n[material.a]\n{texture}\n\
             [[sphere]]\ncenter = [1e6, 0, 0]\nradius = 1\nmaterial = 'a'\n\
             [[plane]]\npoint = [0, 1, 0.5]\nnormal = [0.3, 1, 0.2]\nmaterial = 'a'\n"
        )
    };
    for texture in ["", "texture = 't'"] {
        let scene = Scene::from_toml("s.toml", &text(texture), None).expect("it is sound");
        let plane = &scene.planes[0];
        let was = DVec3::new(0.0, 1.0, 0.5) - scene.origin;
        let by = plane.point.as_dvec3() - was;
        // In the plane as exactly as f32 allows at its distance, and as near as can be.
        let height = was.dot(plane.normal.as_dvec3());
        assert!((plane.point.as_dvec3().dot(plane.normal.as_dvec3()) - height).abs() < 0.05);
        assert!(f64::from(plane.point.length()) - height.abs() < 5.0, "{}", plane.point);
        if !texture.is_empty() {
            // By whole repeats of the texture.
            for (axis, scale) in plane.axes().into_iter().zip([0.75_f32, 0.3_f32]) {
                let repeats = by.dot(axis.as_dvec3()) * f64::from(scale);
                assert!((repeats - repeats.round()).abs() < 0.01, "{repeats}");
            }
        }
    }
}

#[test]
fn a_scene_of_another_size_has_the_same_proportions() {
    for (at, own) in [(DVec3::ZERO, DVec3::ZERO), (DVec3::splat(1e6), DVec3::new(0.0, 3e5, 0.0))] {
        let whole = scene(at, own, 1.0);
        for exponent in [-60, -20, 14, 40] {
            let (scale, size) = (2.0_f32.powi(exponent), 2.0_f64.powi(exponent));
            let scaled = scene(at, own, size);
            let expected: Vec<Vec3> = positions(&whole).iter().map(|&p| p * scale).collect();
            assert_eq!(positions(&scaled), expected, "{exponent}");
            assert_eq!(scaled.origin, whole.origin * size);
            let [camera, of_whole] = [&scaled.cameras[0], &whole.cameras[0]];
            assert_eq!((camera.forward, camera.up), (of_whole.forward, of_whole.up));
        }
    }
}

#[test]
fn the_camera_and_the_light_that_are_added_follow_the_size() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.obj");
    let load = |exponent: i32| {
        fs::write(&path, obj(DVec3::ZERO, 2.0_f64.powi(exponent))).expect("it is written");
        Scene::load(&path).unwrap_or_else(|error| panic!("{error}"))
    };
    let whole = load(0);
    for exponent in [-100, -60, -20, 40, 100] {
        let scaled = load(exponent);
        assert_eq!(scaled.cameras[0].eye, whole.cameras[0].eye * 2.0_f32.powi(exponent));
        assert_eq!(scaled.cameras[0].forward, whole.cameras[0].forward);
        assert_eq!(scaled.lights, whole.lights);
    }
}

#[test]
fn what_rounding_moves_is_told() {
    // Two sizes from 0, where f32 has steps of 2⁻²², 0.1 moves by less than half of one.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.obj");
    fs::write(&path, "v 2.1 0 0\nv 3 0 0\nv 2 1 0\nf 1 2 3\n").expect("it is written");
    let rounding = Scene::load(&path).expect("it is sound").rounding;
    let moved = (2.1_f64 - f64::from(2.1_f32)).abs() / 2.0_f64.sqrt();
    assert!((rounding - moved).abs() < 1e-12 && moved > 0.0, "{rounding} {moved}");
}

#[test]
fn the_shipped_scenes_stay_where_they_are() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes");
    for entry in fs::read_dir(shipped).expect("the folder is there") {
        let path = entry.expect("it can be read").path();
        if path.extension().is_some_and(|ending| ending == "toml" || ending == "obj") {
            let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(scene.origin, DVec3::ZERO, "{}", path.display());
            assert!(scene.meshes.iter().all(|mesh| mesh.origin == DVec3::ZERO));
        }
    }
}

#[test]
fn normals_follow_no_size() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.obj");
    let load = |exponent: i32| {
        fs::write(&path, obj(DVec3::ZERO, 2.0_f64.powi(exponent))).expect("it is written");
        Scene::load(&path).unwrap_or_else(|error| panic!("{error}"))
    };
    let text = |exponent: i32| {
        fs::write(&path, obj(DVec3::ZERO, 2.0_f64.powi(exponent))).expect("it is written");
        let text = "[[camera]]\nkind = 'pinhole'\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\n\
                    field_of_view = 40\n[mesh.m]\nfile = 'm.obj'\n";
        Scene::from_toml("s.toml", text, Some(folder.path())).expect("it is sound")
    };
    let whole = load(0).meshes[0].clone().with_smooth_normals().normals;
    assert!(whole.iter().flatten().all(|normal| (normal.length() - 1.0).abs() < 1e-6));
    for exponent in [-100, -60, 40, 100] {
        assert_eq!(load(exponent).meshes[0].clone().with_smooth_normals().normals, whole);
        assert_eq!(text(exponent).meshes[0].clone().with_smooth_normals().normals, whole);
    }
}

#[test]
fn what_is_too_large_to_be_looked_at_is_refused_in_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.obj");
    fs::write(&path, "v 3e38 0 0\nv -3e38 0 0\nv 0 3e38 0\nf 1 2 3\n").expect("it is written");
    let error = Scene::load(&path).expect_err("no camera").to_string();
    let expected =
        "scene: camera: the scene is too large to be looked at; make it smaller, or add a camera";
    assert!(error.ends_with(expected), "{error}");
    // With one it is a scene like others.
    fs::write(&path, "v 3e37 0 0\nv -3e37 0 0\nv 0 3e37 0\nf 1 2 3\n").expect("it is written");
    assert!(Scene::load(&path).expect("it is in range").cameras[0].eye.is_finite());
}
