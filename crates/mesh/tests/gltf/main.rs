//! glTF: what the specification says of triangles, and what departs from it.
#![allow(missing_docs, reason = "tests")]

mod document;
mod files;

use std::path::{Path, PathBuf};

use document::{Corners, Document, O, POSITIONS, STRICT, X, Y, Z, corners, positions};
use trisect_mesh::Mesh;

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf").join(file)
}

const TETRAHEDRON: [Corners; 4] = [[O, Y, X], [O, X, Z], [O, Z, Y], [X, Y, Z]];

#[test]
fn the_files_give_their_tetrahedron_strictly_too() {
    for (file, notes) in [
        ("morph-weight1", 0),
        ("quantized", 0),
        ("skinned-node-moved", 0),
        ("sparse", 0),
        ("two-scenes", 0),
        ("with-lines", 1),
    ] {
        let mesh = Mesh::load(data(&format!("{file}.gltf"))).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(corners(&mesh), TETRAHEDRON, "{file}");
        assert_eq!(mesh.notes.len(), notes, "{file}");
        let strict = Mesh::load_with(data(&format!("{file}.gltf")), &STRICT);
        assert_eq!(strict.unwrap_or_else(|e| panic!("{e}")).triangles, mesh.triangles);
    }
    let strip = Mesh::load(data("strip.gltf")).expect("it is sound");
    assert_eq!(corners(&strip), [[O, Y, X], [Y, Z, X]]);
    let zeros = Mesh::load(data("noview.gltf")).expect("it is sound");
    assert_eq!((corners(&zeros), zeros.degenerate), (vec![[O; 3]; 4], 4));
    let lines = Mesh::load(data("with-lines.gltf")).expect("it is sound");
    assert_eq!(lines.notes[0].what, "lines, left out");
    assert_eq!((lines.notes[0].count, &*lines.notes[0].first), (1, "mesh 0 primitive 1"));
}

#[test]
fn what_is_refused_is_named() {
    for (file, expected) in [
        (
            "draco",
            "KHR_draco_mesh_compression, which the document requires, is not supported; export it \
             without compression",
        ),
        ("gltf1", "glTF 1.0 is not supported; convert it to glTF 2.0"),
    ] {
        let error = Mesh::load(data(&format!("{file}.gltf"))).expect_err(file);
        assert_eq!(error.problem.to_string(), expected);
    }
}

fn scaled(triangle: Corners, by: f32) -> Corners {
    triangle.map(|corner| corner.map(|x| x * by))
}

fn moved(triangle: Corners, [x, y, z]: [f32; 3]) -> Corners {
    triangle.map(|corner| [corner[0] + x, corner[1] + y, corner[2] + z])
}

#[test]
fn integers_are_positions_normalised_or_not() {
    // Three corners, each filled up to a multiple of 4 bytes.
    let u8s = [0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0];
    let i8s = [0, 0, 0, 0, 127, 0, 0, 0, 0x80, 129, 0, 0];
    let i16s: Vec<u8> = [0_i16, 0, 0, 0, 32767, 0, 0, 0, -32768, 0, 0, 0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let cases: [(&[u8], u32, &str, bool, Corners); 6] = [
        (&u8s, 5121, r#", "byteStride": 4"#, true, [O, X, Y]),
        (&u8s, 5121, r#", "byteStride": 4"#, false, scaled([O, X, Y], 255.0)),
        // The two lowest of a signed type are −1 both.
        (&i8s, 5120, r#", "byteStride": 4"#, true, [O, X, [-1.0, -1.0, 0.0]]),
        (&i8s, 5120, r#", "byteStride": 4"#, false, [O, [127.0, 0.0, 0.0], [-128.0, -127.0, 0.0]]),
        (&i16s, 5122, r#", "byteStride": 8"#, true, [O, X, [-1.0, 0.0, 0.0]]),
        (
            &i16s,
            5122,
            r#", "byteStride": 8"#,
            false,
            [O, [32767.0, 0.0, 0.0], [-32768.0, 0.0, 0.0]],
        ),
    ];
    for (bytes, component, stride, normalized, expected) in cases {
        let mut document = Document::new(&[bytes]);
        document.views[1].2 = stride;
        document.accessors = positions(&format!(
            r#""bufferView": 1, "componentType": {component}, "normalized": {normalized}"#
        ));
        let more = document.more.clone();
        document.more = format!(r#"{more}, "extensionsUsed": ["KHR_mesh_quantization"]"#);
        assert!(document.gives(&[expected]).notes.is_empty() && document.is_standard());
        // Without the extension it means the same, but is not in the standard.
        document.more = more;
        document.gives(&[expected]);
        assert!(!document.is_standard());
    }
}

#[test]
fn indices_of_every_type_make_lists_strips_and_fans() {
    let four: Vec<u8> = [O, X, Y, Z].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let indices = [3_u32, 2, 1, 0, 1];
    let types: [(u32, Vec<u8>); 3] = [
        (5121, indices.iter().map(|&i| u8::try_from(i).expect("small")).collect()),
        (
            5123,
            indices.iter().flat_map(|&i| u16::try_from(i).expect("small").to_le_bytes()).collect(),
        ),
        (5125, indices.iter().flat_map(|i| i.to_le_bytes()).collect()),
    ];
    for (component, bytes) in types {
        for (mode, expected) in [
            // Each three after another, every second one turned.
            (5, vec![[Z, Y, X], [Y, O, X], [X, O, X]]),
            // Two after another, and the first.
            (6, vec![[Y, X, Z], [X, O, Z], [O, X, Z]]),
        ] {
            let mut document = Document::new(&[&four, &bytes]);
            document.accessors = format!(
                r#"{{"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": [0, 0, 0], "max": [1, 1, 1]}},
                {{"bufferView": 2, "componentType": {component}, "count": 5, "type": "SCALAR"}}"#
            );
            document.primitive =
                format!(r#""attributes": {{"POSITION": 0}}, "indices": 1, "mode": {mode}"#);
            document.gives(&expected);
            assert!(document.is_standard());
            document.primitive = r#""attributes": {"POSITION": 0}, "indices": 1"#.to_owned();
            document.is_refused("mesh 0 primitive 0: 5 corners are not a multiple of three");
        }
    }
    // In the order of the vertices where there are no indices.
    let mut document = Document::new(&[]);
    document.gives(&[[O, X, Y]]);
    for (mode, what) in [(0, "points, left out"), (1, "lines, left out"), (3, "lines, left out")] {
        document.primitive = format!(
            r#""attributes": {{"POSITION": 0}}}}, {{"attributes": {{"POSITION": 0}}, "mode": {mode}"#
        );
        assert_eq!(document.gives(&[[O, X, Y]]).notes[0].what, what);
        document.primitive = format!(r#""attributes": {{"POSITION": 0}}, "mode": {mode}"#);
        document.is_refused("the mesh has no triangles");
    }
    document.primitive =
        r#""attributes": {"POSITION": 0}}, {"attributes": {"NORMAL": 0}"#.to_owned();
    let notes = document.gives(&[[O, X, Y]]).notes;
    assert_eq!(notes[0].what, "triangles without positions, left out");
}

#[test]
fn sparse_accessors_replace_items_of_data_or_of_zeros() {
    let one: Vec<u8> = [5.0_f32, 6.0, 7.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    for (component, index) in [(5121, vec![1]), (5123, vec![1, 0]), (5125, vec![1, 0, 0, 0])] {
        let mut document = Document::new(&[&index, &one]);
        let sparse = format!(
            r#""componentType": 5126, "sparse": {{"count": 1, "indices":
            {{"bufferView": 1, "componentType": {component}}}, "values": {{"bufferView": 2}}}}"#
        );
        document.accessors = positions(&sparse);
        document.gives(&[[O, [5.0, 6.0, 7.0], O]]);
        document.accessors = positions(&format!(r#""bufferView": 0, {sparse}"#));
        document.gives(&[[O, [5.0, 6.0, 7.0], Y]]);
        assert!(document.is_standard());
    }
    let mut document = Document::new(&[&[3], &one]);
    document.accessors = positions(
        r#""componentType": 5126, "sparse": {"count": 1, "indices":
        {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 2}}"#,
    );
    document.is_refused("accessor 0 replaces item 3, it has 3");
}

#[test]
fn a_count_without_data_takes_no_memory() {
    for count in ["1000000000", "18446744073709551615"] {
        let mut document = Document::new(&[]);
        document.accessors =
            format!(r#"{{"componentType": 5126, "count": {count}, "type": "VEC3"}}"#);
        let message = document.load().expect_err("too many").to_string();
        let known = ["items and no data", "--max-memory"];
        assert!(known.iter().any(|known| message.contains(known)), "{message}");
    }
}

#[test]
fn strides_offsets_and_types_are_kept_to() {
    let mut bytes = vec![0; 4];
    for corner in [O, X, Y] {
        bytes.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([9; 4]);
    }
    let mut document = Document::new(&[&bytes]);
    document.views[1].2 = r#", "byteStride": 16"#;
    document.accessors = positions(r#""bufferView": 1, "byteOffset": 4, "componentType": 5126"#);
    document.gives(&[[O, X, Y]]);
    for (from, to, expected) in [
        (r#""byteOffset": 4"#, r#""byteOffset": 12"#, "accessor 0 reaches beyond its buffer view"),
        (r#""bufferView": 1"#, r#""bufferView": 2"#, "bufferView 2 is out of range"),
        ("5126", "5127", "componentType 5127 is none"),
        ("VEC3", "VEC2", "accessor 0 is VEC2, not VEC3"),
        (r#""byteOffset": 4"#, r#""byteOffset": 18446744073709551615"#, "reaches beyond"),
    ] {
        let sound = document.accessors.clone();
        document.accessors = sound.replacen(from, to, 1);
        document.is_refused(expected);
        document.accessors = sound;
    }
    document.views[1].2 = r#", "byteStride": 8"#;
    document.is_refused("accessor 0 reaches beyond its buffer view");
    document.views[1] = (36, 1000, "");
    document.is_refused("bufferView 1 reaches beyond its buffer");
}

#[test]
fn nodes_carry_by_matrix_or_by_parts() {
    let mut document = Document::new(&[]);
    let root = |node: &str| format!(r#"{{"mesh": 0, {node}}}"#);
    // A quarter turn about z, after a scale of 2.
    let parts = r#""translation": [1, 2, 3], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476],
        "scale": [2, 2, 2]"#;
    let matrix = r#""matrix": [0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1]"#;
    let expected = [[1.0, 2.0, 3.0], [1.0, 4.0, 3.0], [-1.0, 2.0, 3.0]];
    for node in [parts, matrix] {
        document.nodes = root(node);
        document.gives(&[expected]);
    }
    // Of half the length it is the same turn.
    document.nodes =
        root(&parts.replace("[0, 0, 0.7071067811865476, 0.7071067811865476]", "[0, 0, 0.5, 0.5]"));
    document.gives(&[expected]);
    assert!(!document.is_standard());
    document.nodes = root(r#""rotation": [0, 0, 0, 0]"#);
    document.is_refused("node 0: its rotation has no direction");
    document.nodes = root(r#""matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]"#);
    document.is_refused("node 0: its matrix is not affine");
    // A mirror turns the corners' order, and what is flat is without area.
    document.nodes = root(r#""scale": [-1, 1, 1]"#);
    document.gives(&[[O, Y, [-1.0, 0.0, 0.0]]]);
    document.nodes = root(r#""scale": [0, 1, 1]"#);
    assert_eq!(document.gives(&[[O, O, Y]]).degenerate, 1);
    // Parents first; numbers are f64 until the end.
    document.nodes = r#"{"translation": [16777216, 0, 0], "children": [1]},
        {"mesh": 0, "translation": [-16777215, 0, 0]}"#
        .to_owned();
    document.gives(&[moved([O, X, Y], X)]);
    document.nodes = root(r#""scale": [1e300, 1, 1]"#);
    document.is_refused("vertex 1 at [1.0, 0.0, 0.0] is not finite in f32 in its place");
}

#[test]
fn the_scene_that_is_named_is_shown() {
    let mut document = Document::new(&[]);
    document.nodes = r#"{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0], "children": [2]},
        {"mesh": 0, "translation": [0, 5, 0]}"#
        .to_owned();
    let [first, second, third] =
        [[O, X, Y], moved([O, X, Y], [5.0, 0.0, 0.0]), moved([O, X, Y], [5.0, 5.0, 0.0])];
    let none = "no scenes: all nodes are shown";
    let several = "several scenes, and none of them named to be shown: the first is";
    let parent =
        "a node that is listed in the scene and has a parent, shown once where its parents put it";
    for (more, expected, note) in [
        (r#""scene": 0, "scenes": [{"nodes": [0]}, {"nodes": [1]}]"#, vec![first], None),
        (r#""scene": 1, "scenes": [{"nodes": [0]}, {"nodes": [1]}]"#, vec![second, third], None),
        (r#""scenes": [{"nodes": [1, 0]}]"#, vec![second, third, first], None),
        (r#""scenes": [{"nodes": [0]}, {"nodes": [1]}]"#, vec![first], Some(several)),
        (r#""extensionsUsed": []"#, vec![first, second, third], Some(none)),
        (r#""scenes": [{"nodes": [2, 0, 0]}]"#, vec![third, first], Some(parent)),
        (r#""scenes": [{"nodes": [2, 1]}]"#, vec![third, second], Some(parent)),
    ] {
        document.more = more.to_owned();
        let notes = document.gives(&expected).notes;
        assert_eq!(notes.first().map(|note| note.what.as_str()), note, "{more}");
        assert_eq!(document.is_standard(), note != Some(parent));
    }
    for (more, expected) in [
        (r#""scene": 1, "scenes": [{"nodes": [0]}]"#, "scene: scene 1 is out of range"),
        (r#""scene": 0, "scenes": [{"nodes": [7]}]"#, "scene 0: node 7 is out of range"),
        (r#""scene": 0, "scenes": [{}]"#, "the mesh has no triangles"),
    ] {
        document.more = more.to_owned();
        document.is_refused(expected);
    }
    document.more = r#""scene": 0, "scenes": [{"nodes": [0]}]"#.to_owned();
    document.nodes = r#"{"children": [1, 2]}, {"children": [2]}, {"mesh": 0}"#.to_owned();
    document.is_refused("node 1: its child 2 is one of node 0 too");
    document.nodes = r#"{"mesh": 0}, {"children": [2]}, {"children": [1]}"#.to_owned();
    document.is_refused("nodes: some are their own ancestors");
}

#[test]
fn morph_targets_are_added_by_their_weights() {
    let shifts = |by: f32| -> Vec<u8> {
        [[by, 0.0, 0.0]; 3].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
    };
    let mut document = Document::new(&[&shifts(1.0), &shifts(10.0)]);
    let view =
        |number: u32| positions(&format!(r#""bufferView": {number}, "componentType": 5126"#));
    document.accessors = [view(0), view(1), view(2)].join(",");
    document.primitive = r#""attributes": {"POSITION": 0},
        "targets": [{"POSITION": 1}, {"POSITION": 2}, {}]"#
        .to_owned();
    document.gives(&[[O, X, Y]]);
    document.mesh = r#", "weights": [0.5, 0.25, 1]"#;
    document.gives(&[moved([O, X, Y], [3.0, 0.0, 0.0])]);
    document.nodes = r#"{"mesh": 0, "weights": [2, 0, 0]}"#.to_owned();
    document.gives(&[moved([O, X, Y], [2.0, 0.0, 0.0])]);
    assert!(document.is_standard());
    document.nodes = r#"{"mesh": 0, "weights": [2]}"#.to_owned();
    document.is_refused("mesh 0 primitive 0: it has 3 morph targets and 1 weights");
}

#[test]
fn joints_carry_skinned_vertices() {
    // Vertex 0 hangs on joint 0, vertex 1 on joint 1, vertex 2 on both.
    let joints = [0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0];
    let weights = [255, 0, 0, 0, 255, 0, 0, 0, 51, 204, 0, 0];
    let inverse: Vec<u8> = [[0.0_f32, 0.0, 0.0], [-1.0, 0.0, 0.0]]
        .iter()
        .flat_map(|&[x, y, z]| {
            [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0]
        })
        .flat_map(f32::to_le_bytes)
        .collect();
    let mut document = Document::new(&[&joints, &weights, &inverse]);
    let skin = r#"{"bufferView": 1, "componentType": 5121, "count": 3, "type": "VEC4"},
        {"bufferView": 2, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4"},
        {"bufferView": 3, "componentType": 5126, "count": 2, "type": "MAT4"}"#;
    document.accessors = format!("{POSITIONS}, {skin}");
    document.primitive =
        r#""attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}"#.to_owned();
    // The joints: one where it was bound, one at (1, 0, 0) turned by a quarter about z and moved up by 10.
    // The node's own place, and its parent's, are without effect.
    document.nodes = r#"{"translation": [50, 60, 70], "children": [1]},
        {"mesh": 0, "skin": 0, "translation": [9, 9, 9]}, {"children": [3]},
        {"translation": [1, 10, 0], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]}"#
        .to_owned();
    let more = r#""scene": 0, "scenes": [{"nodes": [0, 2]}], "skins": [{"joints": [2, 3],
        "inverseBindMatrices": 3}]"#;
    document.more = more.to_owned();
    // Vertex 2 at (0, 1, 0) is carried by joint 1 to (0, 9, 0), and a fifth of it stays.
    let expected = [O, [1.0, 10.0, 0.0], [0.0, 0.2 + 0.8 * 9.0, 0.0]];
    let mesh = document.load().unwrap_or_else(|error| panic!("{error}"));
    for (found, expected) in corners(&mesh)[0].as_flattened().iter().zip(expected.as_flattened()) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
    assert!(mesh.notes.is_empty() && document.is_standard());
    for (from, to, expected) in [
        (r#""joints": [2, 3]"#, r#""joints": [2]"#, "joint 1 is out of range"),
        (r#""joints": [2, 3]"#, r#""joints": [2, 8]"#, "skin 0: node 8 is out of range"),
        (r#""joints": [2, 3]"#, r#""joints": [2, 3, 2]"#, "it has 3 joints and 2 matrices"),
    ] {
        document.more = more.replacen(from, to, 1);
        document.is_refused(expected);
    }
    document.more = more.to_owned();
    document.bytes[36 + 12] = 100;
    document.is_refused("vertex 0: its joints' weights add up to 0.39");
}

#[test]
fn a_shared_mesh_is_read_once_and_told_once() {
    let mut document = Document::new(&[]);
    document.primitive += r#"}, {"attributes": {"POSITION": 0}, "mode": 1"#;
    document.nodes = r#"{"mesh": 0}, {"mesh": 0, "translation": [1, 0, 0]}"#.to_owned();
    document.more = r#""scene": 0, "scenes": [{"nodes": [0, 1]}]"#.to_owned();
    let mesh = document.gives(&[[O, X, Y], moved([O, X, Y], X)]);
    assert_eq!(mesh.notes[0].count, 1);
}
