//! A document that has everything, and every single change of its JSON: none panics, none takes memory that
//! its bytes do not justify, and meshes and scenes accept the same ones.

use std::fs;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use serde_json::{Value, json};
use trisect_mesh::{Mesh, ReadOptions};
use trisect_scene::Scene;

/// Everything that is read: skins, targets, sparse and quantised accessors, cameras, lights, textures.
fn rich() -> Value {
    let floats =
        |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let identity = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    let parts: [Vec<u8>; 8] = [
        floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.]),
        vec![0, 0, 2, 0, 1, 0, 0, 0, 1, 0, 3, 0],
        vec![0, 0, 255, 0, 0, 255, 9, 9],
        vec![0; 16],
        [[255, 0, 0, 0]; 4].concat(),
        floats(&identity),
        vec![1, 0, 0, 0],
        floats(&[2., 0., 0.]),
    ];
    let mut bytes = Vec::new();
    let mut views = Vec::new();
    for part in parts {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": part.len()}));
        bytes.extend(part);
    }
    views[2]["byteStride"] = json!(2);
    let picture = BASE64.encode(include_bytes!("../data/red.png"));
    json!({
        "asset": {"version": "2.0", "minVersion": "2.0"},
        "extensionsUsed": ["KHR_mesh_quantization", "KHR_lights_punctual", "X_any"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scene": 0,
        "scenes": [{"nodes": [0, 3]}, {"nodes": [2]}],
        "nodes": [
            {"mesh": 0, "skin": 0, "children": [1], "name": "skinned"},
            {"translation": [1, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 2, 1], "children": [4]},
            {"mesh": 0},
            {"mesh": 0, "weights": [0.5], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]},
            {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}, "children": [5, 6]},
            {"mesh": 1, "camera": 1, "extensions": {"KHR_lights_punctual": {"light": 1}}},
            {"mesh": 1, "scale": [0, 1, 1]}
        ],
        "skins": [{"joints": [1], "inverseBindMatrices": 5, "skeleton": 1}],
        "meshes": [
            {"weights": [0], "primitives": [{
                "attributes": {"POSITION": 0, "NORMAL": 0, "TEXCOORD_1": 2, "JOINTS_0": 3, "WEIGHTS_0": 4},
                "indices": 1, "material": 0, "mode": 4, "targets": [{"POSITION": 6, "NORMAL": 6}]
            }]},
            {"primitives": [
                {"attributes": {"POSITION": 6}, "indices": 7, "mode": 5},
                {"attributes": {"POSITION": 0}, "mode": 6, "material": 1},
                {"attributes": {"POSITION": 0}, "mode": 1}
            ]}
        ],
        "materials": [
            {"name": "red", "pbrMetallicRoughness": {
                "baseColorFactor": [1, 0.5, 0.5, 1], "metallicFactor": 0.5, "roughnessFactor": 0.5,
                "baseColorTexture": {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform":
                    {"offset": [0.5, 0], "rotation": 1, "scale": [2, 2], "texCoord": 1}}}},
             "emissiveFactor": [1, 1, 1], "alphaMode": "OPAQUE", "normalTexture": {"index": 0},
             "extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_transmission":
                {"transmissionFactor": 0.5}, "KHR_materials_emissive_strength": {"emissiveStrength": 2}}},
            {}
        ],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 10497, "wrapT": 33071}],
        "images": [{"uri": format!("data:image/png;base64,{picture}")}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}},
            {"type": "orthographic", "orthographic": {"ymag": 2, "xmag": 2}}],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "color": [1, 1, 1], "intensity": 10},
            {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}]}},
        "animations": [{}],
        "buffers": [{"byteLength": bytes.len(), "uri": format!("data:;base64,{}", BASE64.encode(&bytes))}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": 0, "byteOffset": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC2", "normalized": true},
            {"bufferView": 3, "componentType": 5121, "count": 4, "type": "VEC4"},
            {"bufferView": 4, "componentType": 5121, "count": 4, "type": "VEC4", "normalized": true},
            {"bufferView": 5, "componentType": 5126, "count": 1, "type": "MAT4"},
            {"componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [2, 0, 0],
                "sparse": {"count": 1, "indices": {"bufferView": 6, "byteOffset": 0, "componentType": 5121},
                    "values": {"bufferView": 7, "byteOffset": 0}}},
            {"bufferView": 1, "componentType": 5123, "count": 4, "type": "SCALAR"}
        ]
    })
}

/// The places of all values below one.
fn places(value: &Value, at: &str, into: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                let at = format!("{at}/{key}");
                places(value, &at, into);
                into.push(at);
            }
        }
        Value::Array(list) => {
            for (number, value) in list.iter().enumerate() {
                let at = format!("{at}/{number}");
                places(value, &at, into);
                into.push(at);
            }
        }
        _ => {}
    }
}

/// What a value is replaced by.
fn changes(value: &Value) -> Vec<Value> {
    let mut changes = vec![Value::Null, json!({}), json!([]), json!(""), json!(true)];
    if value.is_number() {
        changes.extend([json!(0), json!(-1), json!(1), json!(7), json!(5125), json!(0.5)]);
        changes.extend([
            json!(u32::MAX),
            json!(u64::MAX),
            json!(1e38),
            json!(1e300),
            json!(-1e300),
        ]);
    }
    if value.is_string() {
        let strings =
            ["data:", "data:;base64,", "..", "\\", "%", "%ff", "/dev/zero", "SCALAR", "MAT4"];
        changes.extend(strings.map(Value::from));
    }
    changes
}

#[test]
fn no_change_of_a_document_panics_and_meshes_and_scenes_agree() {
    let options = ReadOptions { max_memory: 64 << 20, ..ReadOptions::default() };
    let strict = ReadOptions { strict: true, ..options.clone() };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mutant.gltf");
    let rich = rich();
    let mut all = Vec::new();
    places(&rich, "", &mut all);
    let mut counts = [0, 0];
    let mut check = |mutant: &Value, change: &str| {
        fs::write(&path, mutant.to_string()).expect("it is written");
        let (mesh, scene) = (Mesh::load_with(&path, &options), Scene::load_with(&path, &options));
        match (&mesh, &scene) {
            (Ok(mesh), Ok(scene)) => {
                let count = |i: &trisect_scene::Instance| scene.meshes[i.mesh].triangles.len();
                let shown: usize = scene.instances.iter().map(count).sum();
                assert_eq!(mesh.triangles.len(), shown, "{change}");
                counts[0] += 1;
            }
            (Err(mesh), Err(scene)) => {
                assert_eq!(mesh.to_string(), scene.to_string(), "{change}");
                assert!(!mesh.to_string().contains('\n'), "{mesh}");
                counts[1] += 1;
            }
            (mesh, scene) => panic!("{change}: {mesh:?} {scene:?}"),
        }
    };
    check(&rich, "none");
    for place in all {
        let (parent, key) = place.rsplit_once('/').expect("it has a parent");
        let mut without = rich.clone();
        match without.pointer_mut(parent) {
            Some(Value::Object(map)) => drop(map.remove(key)),
            Some(Value::Array(list)) => drop(list.remove(key.parse().expect("a number"))),
            _ => unreachable!("a value has a parent"),
        }
        check(&without, &format!("{place} removed"));
        for change in changes(rich.pointer(&place).expect("it is there")) {
            let mut mutant = rich.clone();
            *mutant.pointer_mut(&place).expect("it is there") = change.clone();
            check(&mutant, &format!("{place} = {change}"));
        }
    }
    // Neither side is empty, and the document itself is sound.
    assert!(counts[0] > 500 && counts[1] > 500, "{counts:?}");
    fs::write(&path, rich.to_string()).expect("it is written");
    Mesh::load_with(&path, &strict).unwrap_or_else(|error| panic!("{error}"));
    Scene::load_with(&path, &strict).unwrap_or_else(|error| panic!("{error}"));
}
