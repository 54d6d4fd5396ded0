//! What files become, and what is said of those that are faulty.
#![allow(missing_docs, reason = "tests")]

use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use trisect_mesh::ReadOptions;
use trisect_scene::{Lens, Light, Pixels, Scene, Vec3};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes").join(name)
}

/// A sound file with a place for one more line, or another in place of one of its own.
const SOUND: &str = r#"
[picture]
width = 64
height = 48

[[camera]]
kind = "pinhole"
eye = [0, 1, 5]
look_at = [0, 1, 0]
field_of_view = 40

[[light]]
kind = "point"
position = [1, 2, 3]
intensity = [4, 5, 6]

[texture.squares]
checker = [[0, 0, 0], [1, 1, 1]]

[material.red]
diffuse = [0.8, 0.1, 0.1]
texture = "squares"

[mesh.chair]
model = "chair"

[[instance]]
mesh = "chair"
material = "red"
scale = [1, 2, 1]

[[sphere]]
center = [0, 1, 0]
radius = 1
material = "red"

[[plane]]
point = [0, 0, 0]
normal = [0, 2, 0]
material = "red"
"#;

#[test]
fn every_shipped_scene_loads() {
    let mut count = 0;
    for entry in fs::read_dir(shipped("")).expect("the folder is there") {
        let path = entry.expect("it can be read").path();
        if path.extension().is_some_and(|ending| ending == "toml") {
            let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
            assert!(!scene.lights.is_empty() && !scene.cameras.is_empty(), "{}", path.display());
            count += 1;
        }
    }
    assert!(count >= 6, "{count}");
}

#[test]
fn the_mirror_scene_has_its_ball_and_its_chair() {
    let scene = Scene::load(shipped("mirror.toml")).expect("it is sound");
    assert_eq!(scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>(), 10_817);
    assert_eq!((scene.instances.len(), scene.spheres.len(), scene.lights.len()), (1, 1, 4));
    for material in [scene.instances[0].material.expect("it is given"), scene.spheres[0].material] {
        assert!(scene.materials[material].reflection.min_element() > 0.4);
    }
}

#[test]
fn a_file_becomes_what_it_says() {
    let scene = Scene::from_toml("sound.toml", SOUND, None).expect("it is sound");
    assert_eq!(scene.size, [64, 48]);
    let position = Vec3::new(1.0, 2.0, 3.0);
    assert_eq!(scene.lights, [Light::Point { position, intensity: Vec3::new(4.0, 5.0, 6.0) }]);
    assert_eq!(scene.planes[0].normal, Vec3::Y);
    assert_eq!(scene.textures[0].pixels, Pixels::Checker([Vec3::ZERO, Vec3::ONE]));
    let height = scene.instances[0].to_world.transform_point3(Vec3::Y).y;
    assert_eq!(height, 2.0);
    assert!(matches!(scene.cameras[0].lens, Lens::Pinhole { .. }));
}

#[test]
fn turns_are_about_x_then_y_then_z() {
    let text = SOUND.replace("scale = [1, 2, 1]", "rotate = [90, 90, 0]");
    let scene = Scene::from_toml("sound.toml", &text, None).expect("it is sound");
    // About x: y becomes z; about y: z becomes x.
    let turned = scene.instances[0].to_world.transform_vector3(Vec3::Y);
    assert!((turned - Vec3::X).length() < 1e-6, "{turned}");
}

/// A faulty file: what is replaced by what, and the line, field and mend that the message has.
const FAULTS: &[(&str, &str, &str)] = &[
    ("width = 64", "width = 0", "line 3: width: is 0; write 1 to 65536"),
    ("width = 64", "widht = 64", "line 3: widht: unknown field"),
    ("width = 64", "width = \"64\"", "line 3: width: invalid type: string"),
    ("width = 64", "width 64", "line 3: "),
    ("height = 48", "height = 48\nheight = 48", "line 5: height: "),
    (
        "kind = \"pinhole\"",
        "kind = \"fisheye\"",
        "line 7: kind: `fisheye` is not known; write pinhole",
    ),
    ("kind = \"pinhole\"", "kind = \"orthographic\"", "line 7: height: is missing where kind is"),
    ("eye = [0, 1, 5]", "eye = [0, 1]", "line 8: eye: invalid length 2"),
    ("eye = [0, 1, 5]", "eye = [0, 1, nan]", "line 8: eye: is not finite; write three"),
    ("eye = [0, 1, 5]", "", "line 6: eye: missing field `eye`; add it to this table"),
    ("look_at = [0, 1, 0]", "look_at = [0, 9, 5]", "line 9: look_at: gives no direction"),
    ("field_of_view = 40", "field_of_view = 180", "line 10: field_of_view: is 180; write degrees"),
    ("kind = \"point\"", "kind = \"spot\"", "line 13: outer: is missing where kind is `spot`"),
    ("intensity = [4, 5, 6]", "intensity = [4, -5, 6]", "line 15: intensity: is below 0"),
    ("checker = [[0, 0, 0], [1, 1, 1]]", "checker = [[0, 0, 0], [1, 1, 2]]", "line 18: checker: "),
    ("checker = [[0, 0, 0], [1, 1, 1]]", "", "line 17: texture: has no file and no checker"),
    ("checker = [[0, 0, 0], [1, 1, 1]]", "file = \"no.png\"", "line 18: file: `no.png`: cannot be"),
    ("diffuse = [0.8, 0.1, 0.1]", "diffuse = [8, 1, 1]", "line 21: diffuse: is above 1"),
    (
        "texture = \"squares\"",
        "texture = \"dots\"",
        "line 22: texture: `dots` is not in this file; there are squares",
    ),
    ("model = \"chair\"", "model = \"table\"", "line 25: model: `table` is not known; write chair"),
    (
        "mesh = \"chair\"",
        "mesh = \"table\"",
        "line 28: mesh: `table` is not in this file; there are chair",
    ),
    ("material = \"red\"\nscale", "scale", "line 28: material: is missing, and the mesh has none"),
    (
        "scale = [1, 2, 1]",
        "scale = [1, 0, 1]",
        "line 30: scale: is 0; write numbers that are not 0",
    ),
    ("scale = [1, 2, 1]", "normals = \"round\"", "line 30: normals: `round` is not known"),
    ("radius = 1", "radius = -1", "line 34: radius: is -1; write a finite number above 0"),
    ("radius = 1", "radius = inf", "line 34: radius: is inf; write a finite number above 0"),
    ("normal = [0, 2, 0]", "normal = [0, 0, 0]", "line 39: normal: has no direction"),
];

#[test]
fn faults_are_told_by_line_field_and_mend() {
    for (from, to, expected) in FAULTS {
        assert!(SOUND.contains(from), "{from}");
        let text = SOUND.replacen(from, to, 1);
        let message = match Scene::from_toml("faulty.toml", &text, None) {
            Ok(_) => panic!("accepted: {to}"),
            Err(error) => error.to_string(),
        };
        assert!(message.starts_with(&format!("faulty.toml: {expected}")), "{message}");
        assert!(!message.contains('\n') && message.contains("; "), "{message}");
    }
}

#[test]
fn a_scene_without_a_camera_is_refused() {
    let error = Scene::from_toml("empty.toml", "", None).expect_err("nothing to look through");
    assert_eq!(
        error.to_string(),
        "empty.toml: line 1: camera: there is none; add a table [[camera]]"
    );
}

#[test]
fn files_that_are_not_there_or_no_scenes_are_refused() {
    let error = Scene::load("no/scene.toml").expect_err("it is not there");
    assert!(error.to_string().starts_with("no/scene.toml: cannot be read ("), "{error}");
    let error = Scene::load("scene.blend").expect_err("it is not known");
    assert!(error.to_string().starts_with("scene.blend: unknown file type; scenes are"), "{error}");
}

fn in_folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in files {
        fs::write(folder.path().join(name), content).expect("it is written");
    }
    folder
}

/// One triangle, seen twice, with a camera, lights and a material.
fn gltf(material: &str) -> String {
    let mut bytes = Vec::new();
    for number in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(number.to_le_bytes());
    }
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!(
        r#"{{
        "asset": {{ "version": "2.0" }}, "scene": 0, "scenes": [{{ "nodes": [0, 1, 2, 3, 5] }}],
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_transmission", "KHR_materials_ior"],
        "extensions": {{ "KHR_lights_punctual": {{ "lights": [
            {{ "type": "point", "intensity": 683, "color": [1, 0.5, 0] }},
            {{ "type": "directional", "intensity": 1366 }} ] }} }},
        "nodes": [
            {{ "mesh": 0 }},
            {{ "mesh": 0, "translation": [0, 0, -2], "scale": [3, 3, 3] }},
            {{ "camera": 0, "translation": [0, 0, 5], "name": "front" }},
            {{ "translation": [0, 4, 0], "children": [4] }},
            {{ "extensions": {{ "KHR_lights_punctual": {{ "light": 0 }} }}, "translation": [1, 0, 0] }},
            {{ "extensions": {{ "KHR_lights_punctual": {{ "light": 1 }} }} }}
        ],
        "cameras": [{{ "type": "perspective", "perspective": {{ "yfov": 0.7, "znear": 0.1 }} }}],
        "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "material": 0 }}] }}],
        "materials": [{material}],
        "buffers": [{{ "byteLength": 36, "uri": "data:application/octet-stream;base64,{data}" }}],
        "bufferViews": [{{ "buffer": 0, "byteLength": 36 }}],
        "accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                        "min": [0, 0, 0], "max": [1, 1, 0] }}]
    }}"#
    )
}

#[test]
fn gltf_brings_nodes_cameras_lights_and_materials() {
    let glass = r#"{ "name": "glass", "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 0.75 },
        "KHR_materials_ior": { "ior": 1.4 } } }"#;
    let folder = in_folder(&[("scene.gltf", gltf(glass).as_bytes())]);
    let scene = Scene::load(folder.path().join("scene.gltf")).expect("it is sound");
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    let corner = scene.instances[1].to_world.transform_point3(Vec3::Y);
    assert_eq!(corner, Vec3::new(0.0, 3.0, -2.0));
    let camera = &scene.cameras[0];
    assert_eq!(
        (camera.name.as_str(), camera.eye, camera.forward),
        ("front", Vec3::Z * 5.0, Vec3::NEG_Z)
    );
    assert_eq!(camera.lens, Lens::Pinhole { field_of_view: 0.7 });
    let position = Vec3::new(1.0, 4.0, 0.0);
    assert_eq!(scene.lights[0], Light::Point { position, intensity: Vec3::new(1.0, 0.5, 0.0) });
    let direction = Vec3::NEG_Z;
    assert_eq!(scene.lights[1], Light::Directional { direction, irradiance: Vec3::splat(2.0) });
    let glass = &scene.materials[0];
    assert_eq!((glass.transmission, glass.index_of_refraction), (Vec3::splat(0.75), 1.4));
    assert_eq!((glass.diffuse, glass.reflection), (Vec3::splat(0.25), Vec3::ZERO));
}

#[test]
fn a_smooth_metal_is_a_mirror() {
    let metal = r#"{ "pbrMetallicRoughness": {
        "metallicFactor": 1, "roughnessFactor": 0, "baseColorFactor": [0.9, 0.6, 0.3, 1] } }"#;
    let folder = in_folder(&[("scene.gltf", gltf(metal).as_bytes())]);
    let scene = Scene::load(folder.path().join("scene.gltf")).expect("it is sound");
    let metal = &scene.materials[0];
    assert_eq!((metal.reflection, metal.diffuse), (Vec3::new(0.9, 0.6, 0.3), Vec3::ZERO));
}

#[test]
fn faulty_gltf_files_are_told_by_element() {
    let sound = gltf("{}");
    for (from, to, expected) in [
        ("\"byteLength\": 36, \"uri\"", "\"byteLength\": 37, \"uri\"", "truncated: buffer 0"),
        ("\"count\": 3", "\"count\": 4", "mesh 0 primitive 0: accessor 0 reaches beyond"),
    ] {
        assert!(sound.contains(from), "{from}");
        let folder = in_folder(&[("scene.gltf", sound.replacen(from, to, 1).as_bytes())]);
        let error = Scene::load(folder.path().join("scene.gltf")).expect_err(to).to_string();
        assert!(error.contains(&format!("scene.gltf: {expected}")), "{error}");
    }
}

#[test]
fn meshes_alone_get_a_camera_and_a_light() {
    let scene = Scene::load(shipped("../meshes/teapot.ply")).expect("it is sound");
    assert_eq!((scene.cameras.len(), scene.lights.len(), scene.instances.len()), (1, 1, 1));
    let [low, high] = scene.bounds().expect("it is not empty");
    let towards = (low + high) * 0.5 - scene.cameras[0].eye;
    assert!(towards.normalize().dot(scene.cameras[0].forward) > 0.999);
}

#[test]
fn text_of_any_encoding_and_line_ends_is_the_same() {
    let strict = ReadOptions { strict: true, ..ReadOptions::default() };
    let commented = SOUND.replace("[picture]", "# caf\u{e9}\n[picture]");
    let latin: Vec<u8> = commented.chars().map(|c| u8::try_from(c).expect("Latin-1")).collect();
    for (bytes, is_standard) in [
        (commented.clone().into_bytes(), true),
        (commented.replace('\n', "\r\n").into_bytes(), true),
        (commented.replace('\n', "\r").into_bytes(), false),
        (format!("\u{feff}{commented}").into_bytes(), false),
        (latin, false),
    ] {
        let folder = in_folder(&[("s.toml", &bytes)]);
        let path = folder.path().join("s.toml");
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((scene.size, scene.spheres.len()), ([64, 48], 1));
        assert_eq!(Scene::load_with(&path, &strict).is_ok(), is_standard);
    }
    let text = SOUND.replace("width = 64", "width = 0").replace('\n', "\r");
    let folder = in_folder(&[("s.toml", text.as_bytes())]);
    let error = Scene::load(folder.path().join("s.toml")).expect_err("it is 0").to_string();
    assert!(error.ends_with("s.toml: line 3: width: is 0; write 1 to 65536"), "{error}");
}

#[test]
fn nesting_is_bounded() {
    let deep = 100_000;
    for text in [
        format!("camera = {}{}", "[".repeat(deep), "]".repeat(deep)),
        format!("camera = {}1{}", "{a = ".repeat(deep), "}".repeat(deep)),
        format!("{}camera = 1", "a.".repeat(deep)),
        format!("[{}a]", "a.".repeat(deep)),
    ] {
        let error = Scene::from_toml("deep.toml", &text, None).expect_err("too deep").to_string();
        assert!(error.len() < 1000 && !error.contains('\n'), "{error}");
    }
}
