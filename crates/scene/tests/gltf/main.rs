//! glTF scenes: what is shown of them, what is said to be lost, and that meshes are read the same way.
#![allow(missing_docs, reason = "tests")]

mod mutants;

use std::fs;
use std::path::{Path, PathBuf};

use trisect_mesh::ReadOptions;
use trisect_scene::{Lens, Light, Pixels, Scene, Vec2, Vec3};

const STRICT: ReadOptions =
    ReadOptions { strict: true, sandbox: false, max_memory: ReadOptions::MAX_MEMORY };

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file)
}

fn load(file: &str) -> Scene {
    Scene::load(data(file)).unwrap_or_else(|error| panic!("{error}"))
}

/// A document with one part replaced, beside the pictures that it names.
fn changed(file: &str, from: &str, to: &str) -> (tempfile::TempDir, PathBuf) {
    let text = fs::read_to_string(data(file)).expect("it is there");
    assert!(text.contains(from), "{from}");
    let folder = tempfile::tempdir().expect("a folder");
    for picture in ["red.png", "my tex.png"] {
        fs::copy(data(picture), folder.path().join(picture)).expect("it is copied");
    }
    let path = folder.path().join("scene.gltf");
    fs::write(&path, text.replacen(from, to, 1)).expect("it is written");
    (folder, path)
}

fn notes(scene: &Scene) -> Vec<&str> {
    scene.notes.iter().map(|note| note.what.as_str()).collect()
}

/// The colour that a scene's triangle has from its texture at the coordinates of a corner.
fn at_corner(scene: &Scene, corner: usize) -> Vec3 {
    let material = &scene.materials[scene.meshes[0].materials[0]];
    let texture = &scene.textures[material.texture.expect("it has a texture")];
    material.diffuse * texture.at(scene.meshes[0].coordinates[0][corner])
}

#[test]
fn pictures_are_found_in_all_their_places() {
    for file in ["datauri", "percent", "texcoord1", "uv-u8", "missing-normal-map", "lines-beside"] {
        let scene = load(&format!("{file}.gltf"));
        assert_eq!(scene.meshes[0].coordinates, [[Vec2::ZERO, Vec2::X, Vec2::Y]], "{file}");
        assert_eq!(at_corner(&scene, 0), Vec3::X, "{file}");
        Scene::load_with(data(&format!("{file}.gltf")), &STRICT)
            .unwrap_or_else(|error| panic!("{error}"));
    }
    assert_eq!(notes(&load("lines-beside.gltf")), ["lines, left out"]);
    let others = "textures of other than the base colour are not read";
    assert_eq!(notes(&load("missing-normal-map.gltf")), [others]);
    assert!(load("unused-lines-mesh.gltf").notes.is_empty());
}

#[test]
fn coordinates_are_of_the_set_that_the_texture_uses_and_carried_as_it_says() {
    let scene = load("texture-transform.gltf");
    assert_eq!(scene.meshes[0].coordinates, [[Vec2::ZERO, Vec2::X * 4.0, Vec2::Y * 4.0]]);
    // By the sample model of the extension a turn of an eighth of π brings what lies at (0.42, 1.016), on the
    // ray at 67.5°, to the diagonal: v grows downwards, and the turn is from v towards u.
    let transform = r#"{"rotation": 0.39269908169872414, "offset": [1, 2], "scale": [2, 3]}"#;
    let (_folder, path) = changed("texture-transform.gltf", r#"{"scale": [4, 4]}"#, transform);
    let scene = Scene::load(path).expect("it is sound");
    let (sin, cos) = std::f32::consts::FRAC_PI_8.sin_cos();
    let offset = Vec2::new(1.0, 2.0);
    let expected =
        [offset, offset + Vec2::new(cos, -sin) * 2.0, offset + Vec2::new(sin, cos) * 3.0];
    for (found, expected) in scene.meshes[0].coordinates[0].into_iter().zip(expected) {
        assert!((found - expected).length() < 1e-6, "{found} {expected}");
    }
    // The transform may name another set.
    let (_folder, path) = changed("texture-transform.gltf", "[4, 4]", r#"[4, 4], "texCoord": 1"#);
    let scene = Scene::load(&path).expect("it is sound");
    let missing = "no coordinates of the set that the texture uses: one colour of it is shown";
    assert_eq!(notes(&scene), [missing]);
    assert!(Scene::load_with(&path, &STRICT).is_err());
    // What is no transform is none.
    let (_folder, path) = changed("texture-transform.gltf", r#"{"scale": [4, 4]}"#, r#""none""#);
    let scene = Scene::load(path).expect("it is sound");
    assert_eq!(scene.meshes[0].coordinates, [[Vec2::ZERO, Vec2::X, Vec2::Y]]);
}

#[test]
fn without_its_picture_a_surface_has_its_factor() {
    for (file, from, to, what) in [
        ("datauri.gltf", "iVBORw0K", "AAAAAAAA", "picture: PNG or JPEG: "),
        ("percent.gltf", "my%20tex.png", "gone.png", "cannot be read (No such file"),
        ("percent.gltf", "my%20tex.png", "..", "is not a regular file"),
        ("percent.gltf", r#"{"uri": "my%20tex.png"}"#, "{}", "it has neither uri nor bufferView"),
        (
            "percent.gltf",
            r#"{"uri": "my%20tex.png"}"#,
            r#"{"bufferView": 9}"#,
            "bufferView 9 is out",
        ),
        ("percent.gltf", r#"{"source": 0}"#, "{}", "image: source: there is none"),
        ("percent.gltf", r#"{"source": 0}"#, r#"{"source": 7}"#, "image 7 is out of range"),
    ] {
        let (_folder, path) = changed(file, from, to);
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let note = &scene.notes[0];
        assert_eq!(
            (notes(&scene)[0], note.count),
            ("a picture that cannot be used is left out", 1)
        );
        assert!(note.first.starts_with("texture 0: ") && note.first.contains(what), "{note}");
        assert_eq!(scene.materials[0].texture, None);
        assert_eq!(scene.materials[0].diffuse, Vec3::ONE);
        assert!(Scene::load_with(&path, &STRICT).is_err(), "{to}");
    }
    // Not even opened where no triangle that is shown has the material.
    let (_folder, path) =
        changed("percent.gltf", r#""my%20tex.png"}"#, r#""my%20tex.png"}, {"uri": "gone.png"}"#);
    let text = fs::read_to_string(&path).expect("it is there");
    let text = text.replace(r#""textures": ["#, r#""textures": [{"source": 1}, "#);
    let text = text.replace(r#""index": 0"#, r#""index": 1"#).replace(
        r#""materials": ["#,
        r#""materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, "#,
    );
    fs::write(&path, text.replace(r#""material": 0"#, r#""material": 1"#)).expect("it is written");
    let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    assert!(scene.notes.is_empty() && at_corner(&scene, 0) == Vec3::X, "{:?}", scene.notes);
}

#[test]
fn the_sandbox_and_the_limit_on_memory_hold_for_pictures() {
    let sandbox = ReadOptions { sandbox: true, ..ReadOptions::default() };
    let (folder, _) = changed("percent.gltf", "my%20tex.png", "../red.png");
    let inside = folder.path().join("inside");
    fs::create_dir(&inside).expect("it is made");
    let path = inside.join("scene.gltf");
    fs::copy(folder.path().join("scene.gltf"), &path).expect("it is copied");
    assert_eq!(at_corner(&Scene::load(&path).expect("without a sandbox"), 0), Vec3::X);
    let error = Scene::load_with(&path, &sandbox).expect_err("it lies outside").to_string();
    assert!(error.contains("--sandbox keeps to"), "{error}");
    let small = ReadOptions { max_memory: 1000, ..ReadOptions::default() };
    let error = Scene::load_with(data("percent.gltf"), &small).expect_err("too little").to_string();
    assert!(error.contains("the 1000 bytes that --max-memory allows"), "{error}");
}

#[test]
fn pictures_that_promise_too_much_are_refused_at_once() {
    for (file, size) in [("big2.png", "100000 × 100000"), ("j16384.jpg", "16384 × 16384")] {
        let text = format!(
            "[[camera]]\nkind = 'pinhole'\neye = [0, 1, 5]\nlook_at = [0, 0, 0]\nfield_of_view = 40\n\
             [texture.t]\nfile = '{file}'\n[material.r]\ntexture = 't'\n\
             [[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = 'r'\n"
        );
        let error = Scene::from_toml("s.toml", &text, Some(&data(""))).expect_err(file).to_string();
        assert!(
            error.starts_with(&format!("s.toml: line 7: file: `{file}`: picture: ")),
            "{error}"
        );
        assert!(error.contains(&format!("cut off: its header promises {size}")), "{error}");
    }
}

#[test]
fn nothing_to_see_is_refused() {
    let error = Scene::load(data("min-image.gltf")).expect_err("nothing is shown").to_string();
    assert!(error.ends_with("the mesh has no triangles; export it with its faces"), "{error}");
}

#[test]
fn nodes_are_shown_as_the_specification_says() {
    let corners = |scene: &Scene, instance: usize| {
        let instance = &scene.instances[instance];
        let mesh = &scene.meshes[instance.mesh];
        mesh.triangles[0].corners().map(|corner| instance.to_world.transform_point3(corner.into()))
    };
    for file in ["two-scenes.gltf", "skin.gltf"] {
        let scene = load(file);
        assert_eq!(scene.instances.len(), 1);
        assert_eq!(corners(&scene, 0), [Vec3::ZERO, Vec3::X, Vec3::Y], "{file}");
    }
    let told = "vertices of a skinned mesh without joints, left where the mesh has them";
    assert_eq!(notes(&load("skin.gltf")), [told]);
    // What is flattened has no space of its own.
    let scene = load("zero-scale.gltf");
    assert_eq!(scene.instances.len(), 2);
    assert_eq!(corners(&scene, 1), [Vec3::ZERO, Vec3::ZERO, Vec3::Y]);
    let (_folder, path) =
        changed("zero-scale.gltf", r#""scale": [0, 1, 1]"#, r#""scale": [2, 0, 1e-30]"#);
    let scene = Scene::load(path).expect("it is sound");
    assert_eq!(corners(&scene, 1), [Vec3::ZERO, Vec3::X * 2.0, Vec3::ZERO]);
}

#[test]
fn faulty_cameras_lights_and_factors_are_left_out_and_told() {
    let nodes = r#""nodes": [{"mesh": 0}, {"camera": 0}, {"camera": 1}, {"camera": 2}, {"camera": 3},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"extensions": {"KHR_lights_punctual": {"light": 1}}},
        {"extensions": {"KHR_lights_punctual": {"light": 2}}},
        {"extensions": {"KHR_lights_punctual": {"light": 3}}},
        {"extensions": {"KHR_lights_punctual": 5}}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 683},
            {"type": "laser"}, {"type": "spot", "spot": {"innerConeAngle": 1, "outerConeAngle": 0.5}}]}},
        "cameras": [{"perspective": {"yfov": 1}}, {"perspective": {"yfov": 0}},
            {"orthographic": {"ymag": -1}}]"#;
    let (_folder, path) = changed("datauri.gltf", r#""nodes": [{"mesh": 0}]"#, nodes);
    let text = fs::read_to_string(&path).expect("it is there");
    let shown = r#""scenes": [{"nodes": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]}]"#;
    let text = text.replace(r#""scenes": [{"nodes": [0]}]"#, shown).replace(
        r#""metallicFactor": 0}"#,
        r#""metallicFactor": -1}, "emissiveFactor": [-1, 0, 0],
            "extensions": {"KHR_materials_ior": {"ior": 0}}"#,
    );
    fs::write(&path, text).expect("it is written");
    let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.cameras.len(), 1);
    assert_eq!(scene.cameras[0].lens, Lens::Pinhole { field_of_view: 1.0 });
    assert_eq!(scene.lights, [Light::Point { position: Vec3::ZERO, intensity: Vec3::ONE }]);
    let material = &scene.materials[0];
    assert_eq!((material.diffuse, material.emission), (Vec3::ONE, Vec3::ZERO));
    assert_eq!(material.index_of_refraction, 1.5);
    let counts: Vec<(usize, &str)> =
        scene.notes.iter().map(|note| (note.count, note.first.as_str())).collect();
    let expected =
        [(1, "material 0"), (1, "material 0"), (1, "material 0"), (3, "node 2"), (3, "node 6")];
    assert_eq!(counts, expected, "{:?}", scene.notes);
    assert!(Scene::load_with(&path, &STRICT).is_err());
}

#[test]
fn texels_are_those_of_the_picture() {
    let scene = load("percent.gltf");
    let red = Pixels::Picture { width: 2, height: 2, texels: vec![[255, 0, 0]; 4] };
    assert_eq!(scene.textures[0].pixels, red);
}
