//! Pictures against what optics says.
#![allow(missing_docs, reason = "tests")]

#[allow(dead_code, reason = "each test asks for a part")]
mod common;

use std::f32::consts::PI;

use common::{at, render, scene, stage};
use trisect_core::Triangle;
use trisect_moller_trumbore::MollerTrumbore;
use trisect_render::{Image, Mode, Occlusion, Sampling, Settings};
use trisect_scene::{Affine3A, Instance, Mesh, Scene, Vec3};
use trisect_tracer::Tracing;

fn square(pixels: u32) -> Settings {
    Settings { tracing: Tracing::Plain, ..Settings::new([pixels, pixels]) }
}

fn picture(text: &str, settings: &Settings) -> Image {
    render(&stage::<MollerTrumbore>(scene(text)), settings)
}

const WALL: &str = "[material.white]\ndiffuse = [1, 1, 1]\n\
                    [[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"white\"\n";

#[test]
fn lambert_returns_what_a_light_sends_over_pi() {
    let image = picture(
        &format!(
            "{WALL}[[light]]\nkind = \"point\"\nposition = [0, 0, 2]\nintensity = [8, 4, 0]\n"
        ),
        &square(101),
    );
    // Below the light at distance 2: 8 / 2² / π.
    assert!((at(&image, 0.0, 0.0) - Vec3::new(2.0, 1.0, 0.0) / PI).length() < 1e-3);
    // Beside, at √(4 + 0.49): the cosine and the square of the distance.
    let squared = 4.0 + 0.49;
    let expected = 8.0 / squared * (2.0 / f32::sqrt(squared)) / PI;
    let pixel = at(&image, 0.7, 0.0).x;
    assert!((pixel - expected).abs() < 0.01, "{pixel} {expected}");
}

#[test]
fn lights_add_up_and_as_many_count_as_asked() {
    let light =
        "[[light]]\nkind = \"directional\"\ndirection = [0, 0, -1]\nirradiance = [1, 1, 1]\n";
    let text = format!("{WALL}{}", light.repeat(3));
    for lights in [0, 1, 2, 3, usize::MAX] {
        let image = picture(&text, &Settings { lights, ..square(8) });
        let expected = lights.min(3) as f32 / PI;
        assert!((at(&image, 0.0, 0.0).x - expected).abs() < 1e-5, "{lights}");
    }
}

#[test]
fn a_spot_ends_at_its_angle() {
    let image = picture(
        &format!(
            "{WALL}[[light]]\nkind = \"spot\"\nposition = [0, 0, 1]\ndirection = [0, 0, -1]\n\
             intensity = [4, 4, 4]\ninner = 20\nouter = 30\n"
        ),
        &square(400),
    );
    let (inner, outer) = (20.0_f32.to_radians().tan(), 30.0_f32.to_radians().tan());
    let cube = |x: f32| 4.0 / PI * (1.0 + x * x).powf(-1.5);
    assert!((at(&image, inner - 0.01, 0.0).x - cube(inner - 0.01)).abs() < 0.01);
    assert!(at(&image, outer - 0.02, 0.0).x > 0.0);
    assert_eq!(at(&image, outer + 0.01, 0.0), Vec3::ZERO);
}

/// The light's share of a row of pixels: 1 where it is as bright as without anything in its way.
fn shadow_edge(image: &Image, y: f32) -> f32 {
    let width = image.size[0] as f32;
    let lit = at(image, -0.99, y).x;
    let row = (0..image.size[0]).map(|x| (x as f32 + 0.5) / width * 2.0 - 1.0);
    // From the left, how far the light goes.
    row.map(|x| (at(image, x, y).x / lit).min(1.0)).sum::<f32>() / width * 2.0 - 1.0
}

#[test]
fn a_shadow_ends_where_its_ray_falls() {
    // Half of a mesh, half of a sphere's flank: a curtain's edge at x = 0 and z = 1, light from x = −1
    // and z = 2 per unit of depth: the edge falls on x = 0.5.
    let light =
        "[[light]]\nkind = \"directional\"\ndirection = [0.5, 0, -1]\nirradiance = [3, 3, 3]\n";
    let text = format!("{WALL}{light}[mesh.curtain]\nmodel = \"chair\"\n");
    let mut with_curtain = scene(&text);
    let corners = [[0.0, -9.0, 1.0], [9.0, -9.0, 1.0], [9.0, 9.0, 1.0], [0.0, 9.0, 1.0]];
    let [a, b, c, d] = corners;
    let triangles = vec![Triangle::new(a, b, c), Triangle::new(a, c, d)];
    with_curtain.meshes =
        vec![Mesh { materials: vec![0; 2], ..Mesh::of_triangles("curtain", triangles) }];
    with_curtain.instances.push(Instance {
        mesh: 0,
        to_world: Affine3A::IDENTITY,
        material: None,
        smooth: false,
    });
    // From the side, under the curtain: the camera sees the wall and its shadow, not the curtain.
    with_curtain.cameras[0].eye.z = 0.5;
    let stage = stage::<MollerTrumbore>(with_curtain);
    for (sampling, precision) in [(Sampling::ONE, 1.0), (Sampling::Grid(8), 1.0 / 8.0)] {
        let settings = Settings { sampling, ..square(90) };
        let edge = shadow_edge(&render(&stage, &settings), 0.3);
        let pixel = 2.0 / 90.0;
        assert!((edge - 0.5).abs() <= precision * pixel, "{sampling}: {edge}");
    }
}

#[test]
fn a_mirror_shows_what_is_behind_the_camera() {
    let image = picture(
        "[picture]\nbackground = [0, 0, 0]\n[material.mirror]\nreflection = [0.5, 0.5, 0.5]\n\
         [material.lamp]\nemission = [4, 2, 0]\n\
         [[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"mirror\"\n\
         [[sphere]]\ncenter = [0, 0, 20]\nradius = 0.5\nmaterial = \"lamp\"\n",
        &square(100),
    );
    assert_eq!(at(&image, 0.0, 0.0), Vec3::new(2.0, 1.0, 0.0));
    assert_eq!(at(&image, 0.48, 0.0), Vec3::new(2.0, 1.0, 0.0));
    assert_eq!(at(&image, 0.52, 0.0), Vec3::ZERO);
    let settings = Settings { depth: 0, ..square(100) };
    let text = "[material.mirror]\nreflection = [0.5, 0.5, 0.5]\n[picture]\nbackground = [9, 9, 9]\n\
                [[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"mirror\"\n";
    assert_eq!(at(&picture(text, &settings), 0.0, 0.0), Vec3::ZERO);
}

/// Two mirrors face each other, and an unlimited depth would never end.
#[test]
fn depth_and_cutoff_end_reflections() {
    let between = |reflection: f32| {
        format!(
            "[picture]\nbackground = [1, 1, 1]\n\
             [material.mirror]\nreflection = [{reflection}, 0, 0]\nemission = [1, 1, 1]\n\
             [[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"mirror\"\n\
             [[plane]]\npoint = [0, 0, 20]\nnormal = [0, 0, -1]\nmaterial = \"mirror\"\n"
        )
    };
    // Each adds its own light: 1 + 1/2 + 1/4 … up to the depth.
    for depth in [0, 1, 5] {
        let settings = Settings { depth, cutoff: 0.0, ..square(4) };
        let expected = 2.0 - 0.5_f32.powi(depth.cast_signed());
        let red = at(&picture(&between(0.5), &settings), 0.0, 0.0).x;
        assert!((red - expected).abs() < 1e-5, "{depth}: {red}");
    }
    // A cut-off of a tenth leaves 1/2, 1/4 and 1/8.
    let settings = Settings { depth: 1000, cutoff: 0.1, ..square(4) };
    let red = at(&picture(&between(0.5), &settings), 0.0, 0.0).x;
    assert!((red - 1.875).abs() < 1e-5, "{red}");
}

/// A slab of glass, 2 thick and turned by an angle, before a lamp of radius 1/4 at x = 0.
fn slab(index: f32, angle: f32) -> Scene {
    let (sin, cos) = angle.to_radians().sin_cos();
    scene(&format!(
        "[material.glass]\ntransmission = [1, 1, 1]\nindex_of_refraction = {index}\n\
         [material.lamp]\nemission = [1, 1, 1]\n\
         [[sphere]]\ncenter = [0, 0, -30]\nradius = 0.25\nmaterial = \"lamp\"\n\
         [[plane]]\npoint = [{}, 0, {}]\nnormal = [{sin}, 0, {cos}]\nmaterial = \"glass\"\n\
         [[plane]]\npoint = [{}, 0, {}]\nnormal = [{}, 0, {}]\nmaterial = \"glass\"\n",
        sin, cos, -sin, -cos, -sin, -cos
    ))
}

#[test]
fn a_slab_of_glass_shifts_a_ray_by_as_much_as_snell_says() {
    // Parallel sides leave the direction as it is and shift the ray by t · sin(a − b) / cos b.
    for (index, degrees) in [(1.5_f32, 45.0_f32), (1.33, 30.0), (2.4, 30.0)] {
        let image = render(&stage::<MollerTrumbore>(slab(index, degrees)), &square(800));
        let row: Vec<f32> = (0..800)
            .map(|x| (x as f32 + 0.5) / 400.0 - 1.0)
            .filter(|&x| at(&image, x, 0.0).x > 0.3)
            .collect();
        let middle = (row[0] + row[row.len() - 1]) * 0.5;
        let inside = (degrees.to_radians().sin() / index).asin();
        let shift = 2.0 * (degrees.to_radians() - inside).sin() / inside.cos();
        assert!((middle.abs() - shift).abs() < 0.005, "{index} {degrees}: {middle} {shift}");
    }
}

#[test]
fn light_through_clear_things_is_coloured_by_each_surface() {
    const CLEAR: Vec3 = Vec3::new(0.5, 0.25, 1.0);
    const GLASS: &str = "[material.glass]\ntransmission = [0.5, 0.25, 1]\n[material.stone]\n";
    let lamp = |z: f32| {
        format!("[[light]]\nkind = \"point\"\nposition = [3, 0, {z}]\nintensity = [99, 99, 99]\n")
    };
    let ball = |z: f32, material: &str| {
        format!("[[sphere]]\ncenter = [1.5, 0, {z}]\nradius = 0.4\nmaterial = \"{material}\"\n")
    };
    let pane = |z: f32| {
        format!("[[plane]]\npoint = [0, 0, {z}]\nnormal = [0, 0, 1]\nmaterial = \"glass\"\n")
    };
    let middle = |scene: Scene, mode| {
        let settings = Settings { mode, sampling: Sampling::ONE, depth: 0, ..square(101) };
        at(&render(&stage::<MollerTrumbore>(scene), &settings), 0.0, 0.0)
    };
    // A wall of triangles across the light's way, which the camera looks past. The light crosses the edge
    // between them, in each of its instances.
    let wall = |instances: u8| {
        let mut scene = scene(&format!("{WALL}{GLASS}{}", lamp(3.0)));
        let [a, b, c, d] = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
        let triangle = |corners: [[f32; 2]; 3]| {
            let [a, b, c] = corners.map(|[y, z]| [1.0, y, z]);
            Triangle::new(a, b, c)
        };
        let triangles = vec![triangle([a, b, c]), triangle([a, c, d])];
        let glass = scene.materials.iter().position(|material| material.name == "glass");
        let materials = vec![glass.expect("it is there"); 2];
        scene.meshes.push(Mesh { materials, ..Mesh::of_triangles("wall", triangles) });
        for number in 0..instances {
            let along = f32::from(number) * 0.25;
            let to_world = Affine3A::from_translation(Vec3::new(along, -1.0 - along, 0.0));
            scene.instances.push(Instance { mesh: 0, to_world, material: None, smooth: false });
        }
        scene
    };
    for mode in [Mode::Whitted { occlusion: None }, Mode::Paths] {
        let lit = |text: &str| middle(scene(&format!("{WALL}{GLASS}{}{text}", lamp(3.0))), mode);
        let full = lit("");
        assert!(full.min_element() > 0.5, "{full}");
        let is = |found: Vec3, surfaces: i32| {
            let expected = full * CLEAR.map(|x| x.powi(surfaces));
            assert!((found - expected).length() < 1e-5, "{surfaces}: {found} {expected}");
        };
        is(lit(&ball(1.5, "glass")), 2);
        is(lit(&ball(8.0, "glass")), 0);
        is(lit(&format!("{}{}", ball(1.5, "glass"), ball(1.4, "glass"))), 4);
        assert_eq!(lit(&format!("{}{}", ball(1.5, "glass"), ball(1.4, "stone"))), Vec3::ZERO);
        for instances in [1, 2, 3] {
            is(middle(wall(instances), mode), instances.into());
        }
    }
    // From above the pane; the light's way from the wall below it is what it is without.
    let text = format!("{WALL}{GLASS}{}{}", lamp(3.0), pane(4.0));
    let settings = Settings { depth: 1, ..square(101) };
    let through = at(&picture(&text, &settings), 0.0, 0.0);
    let text = format!("{WALL}{GLASS}{}{}", lamp(3.0), pane(2.0));
    let under = at(&picture(&text, &settings), 0.0, 0.0);
    assert!(through.x > 0.1 && (under - through * CLEAR).length() < 1e-5, "{through} {under}");
}

#[test]
fn glass_looked_into_beyond_the_critical_angle_is_a_mirror() {
    // From inside glass of index 1.5 onto its surface, at 41° and at 43°: the critical angle is 41.8°.
    for (degrees, is_mirror) in [(41.0_f32, false), (43.0, true)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let glass = scene(&format!(
            "[picture]\nbackground = [0, 1, 0]\n\
             [material.glass]\ntransmission = [1, 1, 1]\nindex_of_refraction = 1.5\n\
             [material.lamp]\nemission = [1, 0, 0]\n\
             [[plane]]\npoint = [0, 0, 0]\nnormal = [{sin}, 0, {}]\nmaterial = \"glass\"\n\
             [[sphere]]\ncenter = [{}, 0, {}]\nradius = 3\nmaterial = \"lamp\"\n",
            -cos,
            // Where the mirrored ray goes: twice the angle off.
            -20.0 * (2.0 * degrees).to_radians().sin(),
            20.0 * (2.0 * degrees).to_radians().cos(),
        ));
        let pixel = at(&render(&stage::<MollerTrumbore>(glass), &square(50)), 0.0, 0.0);
        if is_mirror {
            assert_eq!(pixel, Vec3::new(1.0, 0.0, 0.0));
        } else {
            assert!(pixel.y > 0.5 && pixel.x + pixel.y > 0.999, "{pixel}");
        }
    }
}

#[test]
fn a_corner_takes_away_the_share_of_the_sky_that_it_hides() {
    // Over the edge of a floor and an endless wall half of the cosine-weighted sky is hidden.
    let text = "[picture]\nambient = [1, 1, 1]\n[material.white]\ndiffuse = [1, 1, 1]\n\
                [material.black]\ndiffuse = [0, 0, 0]\n\
                [[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"white\"\n\
                [[plane]]\npoint = [1.001, 0, 0]\nnormal = [-1, 0, 0]\nmaterial = \"black\"\n";
    let occlusion = Some(Occlusion { rays: 64, distance: f32::INFINITY });
    let settings = Settings { mode: Mode::Whitted { occlusion }, cutoff: 0.0, ..square(32) };
    let image = picture(text, &settings);
    let mean = image.pixels.iter().map(|color| color.x).sum::<f32>() / image.pixels.len() as f32;
    assert!((mean - 0.5).abs() < 0.01, "{mean}");
    // What is farther than 1 hides nothing from the picture's other side.
    let occlusion = Some(Occlusion { rays: 64, distance: 1.0 });
    let settings = Settings { mode: Mode::Whitted { occlusion }, ..settings };
    assert!((at(&picture(text, &settings), -0.5, 0.0).x - 1.0).abs() < 1e-4);
}

#[test]
fn paths_find_all_light_in_a_furnace() {
    // Inside a closed sphere that gives off 1 and returns a half, radiance is 2 everywhere.
    let text = "[material.wall]\ndiffuse = [0.5, 0.5, 0.5]\nemission = [1, 1, 1]\n\
                [[sphere]]\ncenter = [0, 0, 0]\nradius = 50\nmaterial = \"wall\"\n";
    let settings = Settings {
        mode: Mode::Paths,
        sampling: Sampling::Jittered(8),
        depth: 40,
        cutoff: 0.0,
        ..square(16)
    };
    let image = picture(text, &settings);
    let mean = image.pixels.iter().map(|color| color.x).sum::<f32>() / image.pixels.len() as f32;
    assert!((mean - 2.0).abs() < 0.02, "{mean}");
}

#[test]
fn paths_and_whitted_agree_where_light_comes_straight() {
    let text = format!(
        "{WALL}[material.gloss]\nspecular = [0.5, 0.5, 0.5]\nshininess = 10\n\
         [[sphere]]\ncenter = [0, 0, 0]\nradius = 0.5\nmaterial = \"gloss\"\n\
         [[light]]\nkind = \"point\"\nposition = [1, 2, 5]\nintensity = [60, 60, 60]\n"
    );
    let whitted = Settings { depth: 0, sampling: Sampling::Grid(4), ..square(64) };
    let paths = Settings { mode: Mode::Paths, sampling: Sampling::Grid(8), ..whitted.clone() };
    let (root, share) = picture(&text, &whitted).difference(&picture(&text, &paths));
    assert!(root < 0.02 && share < 0.05, "{root} {share}");
}

#[test]
fn instances_look_like_the_meshes_that_they_stand_for() {
    let ball = "[material.red]\ndiffuse = [0.8, 0.2, 0.1]\nspecular = [0.2, 0.2, 0.2]\n\
                [mesh.chair]\nmodel = \"chair\"\n\
                [[light]]\nkind = \"point\"\nposition = [3, 4, 5]\nintensity = [90, 90, 90]\n";
    let place = "material = \"red\"\nscale = [1.5, -1.2, 0.9]\nrotate = [20, 40, 60]\n";
    let one = format!("{ball}[[instance]]\nmesh = \"chair\"\n{place}");
    // The second is far outside the picture, so that the first is carried.
    let far = "[[instance]]\nmesh = \"chair\"\nmaterial = \"red\"\ntranslate = [500, 0, 0]\n";
    let two = format!("{one}{far}");
    let settings = Settings { sampling: Sampling::Grid(2), ..square(128) };
    let [one, two] = [one, two].map(|text| picture(&text, &settings));
    assert!(one.pixels.iter().filter(|color| color.x > 0.05).count() > 500);
    let (root, share) = one.difference(&two);
    assert!(root < 0.005 && share < 0.001, "{root} {share}");
}
