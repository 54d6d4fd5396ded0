//! A scene's unit makes no difference to its picture, and neither does where it lies.
#![allow(missing_docs, reason = "tests")]

#[allow(dead_code, reason = "each test asks for a part")]
mod common;
#[path = "common/moved.rs"]
mod moved;

use std::f32::consts::PI;
use std::fmt::Write as _;

use common::{render, shipped, stage};
use moved::{Grows, moved, power_of_two, scaled};
use trisect_core::Triangle;
use trisect_method::Method;
use trisect_moller_trumbore::MollerTrumbore;
use trisect_render::{Image, Mode, Occlusion, Sampling, Settings};
use trisect_scene::{Affine3A, Camera, Instance, Lens, Light, Material, Mesh, Scene, Vec3};
use trisect_tracer::Tracing;
use trisect_wald::Wald;
use trisect_watertight::Watertight;

fn bits(image: &Image) -> Vec<u32> {
    image.pixels.iter().flat_map(|color| color.to_array().map(f32::to_bits)).collect()
}

/// A box that floats above a floor, in the sun and under a spot.
fn floating_box() -> Scene {
    let text = r#"
        [picture]
        background = [0.1, 0.2, 0.4]
        ambient = [0.1, 0.1, 0.1]
        [[camera]]
        kind = "pinhole"
        eye = [5, 6, 9]
        look_at = [0, 0.6, 0]
        field_of_view = 45
        [[light]]
        kind = "directional"
        direction = [-0.4, -1, -0.3]
        irradiance = [2, 2, 2]
        [[light]]
        kind = "spot"
        position = [2, 5, 1]
        direction = [-0.4, -1, -0.2]
        intensity = [9, 8, 7]
        outer = 20
        [material.m]
        diffuse = [0.7, 0.6, 0.5]
    "#;
    let mut scene = Scene::from_toml("box", text, None).unwrap_or_else(|error| panic!("{error}"));
    let mut triangles = Vec::new();
    let mut quad = |a: Vec3, u: Vec3, v: Vec3| {
        triangles.push(Triangle::new(a, a + u, a + u + v));
        triangles.push(Triangle::new(a, a + u + v, a + v));
    };
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z];
    quad(Vec3::new(-4.0, 0.0, -4.0), z * 8.0, x * 8.0);
    let (low, high) = (Vec3::new(-1.0, 0.5, -1.0), Vec3::new(1.0, 2.0, 1.0));
    for (u, v) in [(x * 2.0, y * 1.5), (y * 1.5, z * 2.0), (z * 2.0, x * 2.0)] {
        quad(low, v, u);
        quad(high, -u, -v);
    }
    let materials = vec![0; triangles.len()];
    let mesh = Mesh { materials, ..Mesh::of_triangles("box", triangles) };
    let to_world = Affine3A::IDENTITY;
    scene.meshes.push(mesh);
    scene.instances.push(Instance { mesh: 0, to_world, material: None, smooth: false });
    scene
}

/// Every feature.
fn pictures() -> Vec<(&'static str, Scene, Settings)> {
    let small = Settings::new([40, 30]);
    let occlusion = Some(Occlusion { rays: 4, distance: 0.75 });
    let occluded = Mode::Whitted { occlusion };
    let paths = Settings { mode: Mode::Paths, sampling: Sampling::Circle(2), ..small.clone() };
    let plan = Settings { camera: 1, ..small.clone() };
    vec![
        ("box", floating_box(), small.clone()),
        ("box, occluded", floating_box(), Settings { mode: occluded, ..small.clone() }),
        ("mirror", shipped("mirror.toml"), small.clone()),
        ("glass", shipped("glass.toml"), Settings { sampling: Sampling::Grid(2), ..small.clone() }),
        ("teapots", shipped("teapots.toml"), small.clone()),
        ("teapots, from above", shipped("teapots.toml"), plan),
        ("teapots, paths", shipped("teapots.toml"), paths.clone()),
        ("textures", shipped("textures.toml"), small.clone()),
        ("lens", shipped("lens.toml"), Settings { sampling: Sampling::Jittered(2), ..small }),
        ("room, paths", shipped("room.toml"), paths),
    ]
}

/// The settings of a scene that is larger by a power of two.
fn as_scaled(settings: &Settings, exponent: i32) -> Settings {
    let mode = match settings.mode {
        Mode::Whitted { occlusion } => Mode::Whitted {
            occlusion: occlusion.map(|occlusion| Occlusion {
                distance: occlusion.distance * power_of_two(exponent),
                ..occlusion
            }),
        },
        Mode::Paths => Mode::Paths,
    };
    Settings { mode, ..settings.clone() }
}

#[test]
fn a_scene_of_any_unit_has_the_same_picture() {
    fn check<M: Method>(name: &str, scene: &Scene, settings: &Settings) {
        let first = bits(&render(&stage::<M>(scene.clone()), settings));
        assert!(first.iter().any(|bits| *bits != first[0]), "{name} is not empty");
        for exponent in [-60, -30, -14, 20, 40] {
            for grows in [Grows::Instances, Grows::Meshes] {
                let scaled = stage::<M>(scaled(scene, exponent, grows));
                let image = bits(&render(&scaled, &as_scaled(settings, exponent)));
                let what = format!("{name} of {}, 2^{exponent}, {grows:?}", M::INFO.name);
                assert!(image == first, "{what}");
            }
        }
    }
    for (name, scene, settings) in pictures() {
        check::<MollerTrumbore>(name, &scene, &settings);
    }
    let settings = Settings { tracing: Tracing::Plain, ..Settings::new([40, 30]) };
    for (name, scene) in [("box", floating_box()), ("teapots", shipped("teapots.toml"))] {
        check::<Watertight>(name, &scene, &settings);
        check::<Wald>(name, &scene, &settings);
    }
}

/// From files, whose numbers are written with as many digits as they have: with smooth normals, which the reader
/// makes, and a camera, whose direction it finds.
#[test]
fn a_file_in_any_unit_has_the_same_picture() {
    let mesh = &floating_box().meshes[0];
    let folder = std::env::temp_dir().join(format!("trisect-scale-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("there is room");
    let picture = |exponent: i32| {
        let at = |x: f32, y: f32, z: f32| [x, y, z].map(|x| x * power_of_two(exponent));
        let mut obj = String::new();
        for triangle in &mesh.triangles {
            for corner in triangle.corners() {
                let [x, y, z] = at(corner.x, corner.y, corner.z);
                writeln!(obj, "v {x} {y} {z}").expect("a string takes all");
            }
            obj += "f -3 -2 -1\n";
        }
        std::fs::write(folder.join("box.obj"), obj).expect("there is room");
        let text = format!(
            "[picture]\nbackground = [0.1, 0.2, 0.4]\n[[camera]]\nkind = \"pinhole\"\n\
             eye = {:?}\nlook_at = {:?}\nfield_of_view = 45\n\
             [[light]]\nkind = \"directional\"\ndirection = [-0.4, -1, -0.3]\n\
             irradiance = [2, 2, 2]\n[material.m]\ndiffuse = [0.7, 0.6, 0.5]\n\
             [mesh.m]\nfile = \"box.obj\"\n[[instance]]\nmesh = \"m\"\nmaterial = \"m\"\n",
            at(5.0, 6.0, 9.0),
            at(0.0, 0.6, 0.0),
        );
        let path = folder.join("box.toml");
        std::fs::write(&path, text).expect("there is room");
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        bits(&render(&stage::<MollerTrumbore>(scene), &Settings::new([48, 36])))
    };
    let first = picture(0);
    for exponent in [-60, -30, -20, -14, 20, 40] {
        assert!(picture(exponent) == first, "2^{exponent}");
    }
    std::fs::remove_dir_all(folder).expect("it is ours");
}

/// Pixels that differ visibly.
fn different(image: &Image, other: &Image) -> usize {
    image.pixels.iter().zip(&other.pixels).filter(|(a, b)| (**a - **b).length() > 0.02).count()
}

#[test]
fn a_scene_keeps_its_picture_however_far_it_is_moved() {
    for (name, scene, settings) in pictures() {
        if settings.mode == Mode::Paths {
            // A ray that comes out otherwise by chance is followed elsewhere.
            continue;
        }
        // The scenes are about 8 in size: 1,000 times and, where so few digits are left that only the
        // box is what it was, a million times as far.
        let distances = [8192.0, 8_000_000.0];
        let count = if name.starts_with("box") { 2 } else { 1 };
        for along in [Vec3::X, Vec3::NEG_Y, Vec3::new(-1.0, 1.0, 1.0)] {
            for away in &distances[..count] {
                let far = moved(&scene, along * *away);
                // The same numbers near the origin, to which they are brought without rounding.
                let near = moved(&far, along * -*away);
                let settings = Settings { size: [64, 48], ..settings.clone() };
                let near = render(&stage::<MollerTrumbore>(near), &settings);
                let far = render(&stage::<MollerTrumbore>(far), &settings);
                let count = different(&near, &far);
                assert!(count <= 3, "{name}, {along} {away}: {count}");
            }
        }
    }
}

/// A mesh far from its own origin, which its transform brings back or leaves there.
#[test]
fn a_mesh_far_from_its_origin_keeps_its_shadows() {
    let scene = floating_box();
    let settings = Settings::new([40, 30]);
    let near = render(&stage::<MollerTrumbore>(scene.clone()), &settings);
    for by in [Vec3::new(8e6, 0.0, -4e6), Vec3::new(0.0, -6e5, 5e3)] {
        let mut far = scene.clone();
        for triangle in &mut far.meshes[0].triangles {
            let [a, b, c] = triangle.corners().map(|corner| Vec3::from(corner) + by);
            *triangle = Triangle::new(a, b, c);
        }
        far.instances[0].to_world.translation -= glam::Vec3A::from(by);
        let brought_back = render(&stage::<MollerTrumbore>(far.clone()), &settings);
        let another = far.instances[0].clone();
        far.instances.push(another);
        far.instances[1].to_world.translation.y -= 1e3;
        let carried = render(&stage::<MollerTrumbore>(far), &settings);
        for image in [brought_back, carried] {
            let count = different(&near, &image);
            assert!(count * 200 <= near.pixels.len(), "{by}: {count}");
        }
    }
}

/// One triangle, seen from its front and lit by the sun from the same side, in a scene that begins at the
/// origin.
fn lonely(corners: [Vec3; 3], light: Vec3, copies: &[Affine3A], far: Option<Vec3>) -> Scene {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize();
    let middle = (a + b + c) / 3.0;
    let size = (b - a).length().max((c - a).length());
    let mut scene = floating_box();
    scene.background = Vec3::new(0.0, 0.0, 5.0);
    scene.ambient = Vec3::ZERO;
    (scene.zenith, scene.lights) = (scene.background, Vec::new());
    scene.lights.push(Light::Directional { direction: -light, irradiance: Vec3::splat(PI) });
    let mut triangles = vec![Triangle::new(a, b, c)];
    // Something small far off: then what is seen is not near the origin of the scene's frame.
    triangles.extend(far.map(|far| Triangle::new(far, far + Vec3::X * 1e-3, far + Vec3::Y * 1e-3)));
    scene.materials = vec![Material { diffuse: Vec3::ONE, ..Material::default() }];
    let materials = vec![0; triangles.len()];
    scene.meshes = vec![Mesh { materials, ..Mesh::of_triangles("triangle", triangles) }];
    let instance = scene.instances[0].clone();
    scene.instances = copies
        .iter()
        .map(|&to_world| Instance { to_world, smooth: false, ..instance.clone() })
        .collect();
    let up = if normal.y.abs() > 0.9 { Vec3::X } else { Vec3::Y };
    let seen = |point| copies[0].transform_point3(point);
    let camera = Camera::looking(
        seen(middle + normal * size + (b - a) * 0.2),
        seen(middle),
        up,
        Lens::Pinhole { field_of_view: 0.8 },
    );
    scene.cameras = vec![camera.expect("it looks down the normal")];
    scene
}

/// Numbers that are the same everywhere.
struct Draw(u64);

impl Draw {
    /// In `[−1, 1)`.
    fn number(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 40) as f32 / 8_388_608.0 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    fn turn(&mut self) -> glam::Quat {
        glam::Quat::from_axis_angle(self.vector().normalize(), self.number() * PI)
    }
}

/// No triangle casts a shadow on itself, whatever its shape, place and transform; of every kernel.
#[test]
fn nothing_shadows_itself() {
    fn check<M: Method>(scenes: &[Scene], of: &str) {
        let mut lit = 0;
        for (number, scene) in scenes.iter().enumerate() {
            let image = render(&stage::<M>(scene.clone()), &Settings::new([24, 24]));
            for color in &image.pixels {
                assert!(color.max_element() > 0.0, "{of} {number} of {}: {color}", M::INFO.name);
                lit += usize::from(color.x > 0.0);
            }
        }
        assert!(lit > scenes.len() * 30, "{of}: {lit}");
    }
    let mut draw = Draw(1);
    let (mut alone, mut carried) = (Vec::new(), Vec::new());
    while alone.len() < 120 {
        let away = draw.vector() * [0.0, 10.0, 1000.0][alone.len() % 3];
        let mut corners = [draw.vector(), draw.vector(), draw.vector()];
        if alone.len() % 4 == 0 {
            // On a floor.
            for corner in &mut corners {
                corner.y = 0.25;
            }
        }
        let [a, b, c] = corners.map(|corner| corner + away);
        let normal = (b - a).cross(c - a);
        let light = draw.vector().normalize();
        let is_needle =
            normal.length() < 0.02 * (b - a).length_squared().max((c - a).length_squared());
        if is_needle || light.dot(normal.normalize()) < 0.05 {
            continue;
        }
        let far = (alone.len() % 2 == 1).then(|| away + draw.vector() * 1e4);
        alone.push(lonely([a, b, c], light, &[Affine3A::IDENTITY], far));
        // Turned and made larger or smaller; its copy is out of sight.
        let turn = draw.turn();
        let size = 10.0_f32.powf(draw.number() * 3.0);
        let place = draw.vector() * 100.0;
        let to_world = Affine3A::from_scale_rotation_translation(Vec3::splat(size), turn, place);
        let mut copy = to_world;
        copy.translation += glam::Vec3A::from(turn * normal.normalize()) * -1e4 * size;
        let towards = turn * light;
        carried.push(lonely([a, b, c], towards, &[to_world, copy], None));
    }
    check::<MollerTrumbore>(&alone, "alone");
    check::<Watertight>(&alone, "alone");
    check::<Wald>(&alone, "alone");
    check::<MollerTrumbore>(&carried, "carried");
    check::<Watertight>(&carried, "carried");
}

/// A thin card on a large floor keeps its shadow up to where it touches it, and so does a thinner one.
#[test]
fn thin_things_in_contact_keep_their_shadows() {
    for (thickness, floor) in [(1e-2, 10.0), (1e-3, 10.0), (1e-4, 10.0), (1e-2, 1e3)] {
        for slope in [Vec3::Y, Vec3::new(0.3, 1.0, -0.2).normalize()] {
            let text = "[material.m]\ndiffuse = [1, 1, 1]\n";
            let mut scene = common::scene(text);
            // The floor's own axes, and the card's edge along one of them through the origin.
            let right = slope.any_orthonormal_vector();
            let along = slope.cross(right);
            let mut triangles = Vec::new();
            let mut quad = |a: Vec3, u: Vec3, v: Vec3| {
                triangles.push(Triangle::new(a, a + u, a + u + v));
                triangles.push(Triangle::new(a, a + u + v, a + v));
            };
            quad((right + along) * (-floor * 0.43), right * floor, along * floor);
            quad(along * -0.4, along * 0.8, slope * thickness);
            let materials = vec![0; triangles.len()];
            scene.meshes = vec![Mesh { materials, ..Mesh::of_triangles("card", triangles) }];
            let to_world = Affine3A::IDENTITY;
            scene.instances = vec![Instance { mesh: 0, to_world, material: None, smooth: false }];
            // From the card's other side: its shadow is as wide as it is high.
            let direction = (right - slope).normalize();
            scene.lights = vec![Light::Directional { direction, irradiance: Vec3::splat(PI) }];
            let lens = Lens::Orthographic { height: 2.0 * thickness };
            let eye = slope * 3.0;
            scene.cameras =
                vec![Camera::looking(eye, Vec3::ZERO, along, lens).expect("it looks down")];
            let image = render(&stage::<MollerTrumbore>(scene), &Settings::new([64, 8]));
            let dark = image.pixels.iter().filter(|color| color.x == 0.0).count();
            let share = dark as f32 / image.pixels.len() as f32;
            // The picture is 8 times as wide as high: from −8 to 8 thicknesses, one of which is dark.
            let (expected, pixel) = (1.0 / 16.0, 1.0 / 64.0);
            assert!((share - expected).abs() <= pixel, "{thickness} {floor} {slope}: {share}");
        }
    }
}
