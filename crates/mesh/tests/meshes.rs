//! Meshes: the same box in every format, and every way in which a file can be wrong.

use std::path::{Path, PathBuf};

use trisect_core::Triangle;
use trisect_mesh::{Mesh, MeshFormat};

const BOXES: [&str; 8] = [
    "box.ascii.ply",
    "box.little.ply",
    "box.big.ply",
    "box.obj",
    "box.ascii.stl",
    "box.binary.stl",
    "box.gltf",
    "box.glb",
];

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file)
}

fn read(file: &str) -> (MeshFormat, Vec<u8>) {
    let path = data(file);
    (MeshFormat::of(&path).expect("known"), std::fs::read(path).expect("there"))
}

#[test]
fn every_format_gives_the_same_box() {
    let first = Mesh::load(data(BOXES[0])).expect("sound");
    assert_eq!(first.name, "box.ascii");
    assert_eq!((first.triangles.len(), first.degenerate), (12, 0));
    assert_eq!(first.bounds.min.to_array(), [-0.25, 0.0, -1.0]);
    assert_eq!(first.bounds.max.to_array(), [0.25, 1.5, 1.0]);
    assert_eq!(first.bounds.center().to_array(), [0.0, 0.75, 0.0]);
    for file in BOXES {
        let mesh = Mesh::load(data(file)).expect("sound");
        assert_eq!(mesh.triangles, first.triangles, "{file}");
    }
}

#[test]
fn the_libraries_read_the_same_box() {
    let ours = Mesh::load(data("box.obj")).expect("sound").triangles;
    let (models, _) =
        tobj::load_obj(data("box.obj"), &tobj::LoadOptions::default()).expect("sound");
    let mesh = &models[0].mesh;
    let corner = |&i: &u32| {
        let at = 3 * i as usize;
        [mesh.positions[at], mesh.positions[at + 1], mesh.positions[at + 2]]
    };
    let theirs: Vec<_> = mesh
        .indices
        .chunks_exact(3)
        .map(|t| Triangle::new(corner(&t[0]), corner(&t[1]), corner(&t[2])))
        .collect();
    assert_eq!(*ours, theirs);

    // The binary file is not among them: its header says `solid`, and the library believes it.
    let (_, bytes) = read("box.ascii.stl");
    let stl = stl_io::read_stl(&mut std::io::Cursor::new(bytes)).expect("sound");
    let theirs: Vec<_> = stl
        .faces
        .iter()
        .map(|face| {
            let [a, b, c] = face.vertices.map(|i| {
                let v = stl.vertices[i];
                [v[0], v[1], v[2]]
            });
            Triangle::new(a, b, c)
        })
        .collect();
    assert_eq!(*ours, theirs);
}

#[test]
fn the_shipped_meshes_are_as_their_table_says() {
    let meshes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/meshes");
    for (name, triangles) in [("bunny", 69_451), ("teapot", 6_320)] {
        let mesh = Mesh::load(meshes.join(name).with_extension("ply")).expect("it is sound");
        assert_eq!((mesh.name.as_str(), mesh.triangles.len()), (name, triangles));
    }
}

#[test]
fn triangles_without_area_are_kept_and_counted() {
    // Collinear in one projection or two is not enough; 0.1, 0.2, 0.3 are not collinear in f32.
    let obj = "v 0 0 0\nv 1 1 1\nv 3 3 3\nv 1 1 2\nv .1 .1 .1\nv .2 .2 .2\nv .1 .2 .3\n\
               v .3 .6 .9\nf 1 2 3\nf 1 2 4\nf 1 1 2\nf 1 5 6\nf 1 7 8\nf 4 4 4\n";
    let mesh = Mesh::from_bytes("lines.obj", MeshFormat::Obj, obj.as_bytes()).expect("sound");
    assert_eq!((mesh.triangles.len(), mesh.degenerate), (6, 4));
}

/// A PLY file with these vertices and faces.
fn ply(vertices: &[&str], faces: &[&str]) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_index\nend_header\n\
         {}\n{}\n",
        vertices.len(),
        faces.len(),
        vertices.join("\n"),
        faces.join("\n")
    )
}

const CORNERS: [&str; 4] = ["0 0 0", "1 0 0", "0 1 0", "1 1 0"];

#[test]
#[allow(clippy::too_many_lines, reason = "a table of cases")]
fn wrong_text_files_say_what_where_and_what_mends_it() {
    use MeshFormat::{Obj, Ply, Stl};
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let header = "ply\nformat ascii 1.0\nelement vertex 1\n";
    let cases: Vec<(MeshFormat, String, &str)> = vec![
        (
            Ply,
            ply(&CORNERS, &["3 0 1 2", "3 0 1 99999"]),
            "face 1 (line 15): index 99999 is out of range, the mesh has 4 vertices; re-export \
             the mesh",
        ),
        (
            Ply,
            ply(&CORNERS, &["3 0 1 -1"]),
            "face 0 (line 14): index -1 is out of range, the mesh has 4 vertices; re-export the \
             mesh",
        ),
        (Ply, ply(&CORNERS, &["2 0 1"]), "the mesh has no triangles; export it with its faces"),
        (Ply, ply(&CORNERS, &[]), "the mesh has no triangles; export it with its faces"),
        (
            Ply,
            ply(&["0 0 nan", "1 0 0", "0 1 0"], &["3 0 1 2"]),
            "face 0 (line 13): vertex 0 (line 10): z is NaN; every coordinate must be a finite f32",
        ),
        (
            Ply,
            ply(&["0 0 1e39", "1 0 0", "0 1 0"], &["3 0 1 2"]),
            "face 0 (line 13): vertex 0 (line 10): z is inf; every coordinate must be a finite f32",
        ),
        (
            Ply,
            ply(&["0 zero 0", "1 0 0", "0 1 0"], &["3 0 1 2"]),
            "line 10: `y` is `zero`, not a number; re-export the mesh",
        ),
        (
            Ply,
            ply(&["0 0", "1 0 0", "0 1 0"], &["3 0 1 2"]),
            "line 10: `z` is incomplete; re-export the mesh",
        ),
        (
            Ply,
            ply(&CORNERS, &["3 0 1 2 3"]),
            "line 14: `3` after the last property; re-export the mesh",
        ),
        (
            Ply,
            ply(&CORNERS, &["3 0 1 2"]) + "3 0 1 2\n",
            "8 bytes after the last element; re-export the mesh",
        ),
        (
            Ply,
            ply(&CORNERS, &["3 0 1 2"]).replace("face 1", "face 2"),
            "truncated: the header promises 2 of element `face`, the file ends at 1; copy or \
             export the file again",
        ),
        (
            Ply,
            ply(&CORNERS, &["3 0 1 2"]).replace("face 1", "face 4000000000"),
            "truncated: the header promises 4000000000 of element `face`, but 32 bytes follow; \
             copy or export the file again",
        ),
        (
            Ply,
            ply(&CORNERS, &["3 0 1 2"]).replace("property float z\n", ""),
            "no property `z` of element `vertex` in the header; re-export the mesh with it",
        ),
        (
            Ply,
            ply(&CORNERS, &["3 0 1 2"]).replace("vertex_index", "corners"),
            "no property `vertex_indices` or `vertex_index` of element `face` in the header; \
             re-export the mesh with it",
        ),
        (
            Ply,
            ply(&CORNERS, &["3 0 1 2"]).replace("uchar int", "uchar float"),
            "header: property `vertex_index` is not a list of integers; re-export the mesh",
        ),
        (
            Ply,
            format!(
                "{header}property float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n"
            ),
            "no element `face` in the header; re-export the mesh with it",
        ),
        (
            Ply,
            header.to_owned(),
            "truncated: the header has no `end_header`; copy or export the file again",
        ),
        (
            Obj,
            format!("{v}f 1 2 3\nf 1 2 7\n"),
            "face 1 (line 5): index 7 is out of range, the mesh has 3 vertices; re-export the \
             mesh",
        ),
        (
            Obj,
            format!("{v}f 1 2 0\n"),
            "face 0 (line 4): index 0 is out of range, the mesh has 3 vertices; re-export the \
             mesh",
        ),
        (
            Obj,
            format!("{v}f 1 2 -4\n"),
            "face 0 (line 4): index -4 is out of range, the mesh has 3 vertices; re-export the \
             mesh",
        ),
        (Obj, format!("{v}f 1 2 x\n"), "line 4: corner `x` is not an index; re-export the mesh"),
        (
            Obj,
            format!("{v}v 0 nan 0\nf 1 2 3\nf 1 2 4\n"),
            "face 1 (line 6): vertex 3 (line 4): y is NaN; every coordinate must be a finite f32",
        ),
        (Obj, format!("{v}v 0 0\nf 1 2 3\n"), "line 4: z is missing; re-export the mesh"),
        (
            Obj,
            format!("{v}v 0 0 0,5\nf 1 2 3\n"),
            "line 4: z is `0,5`, not a number; re-export the mesh",
        ),
        (Obj, v.to_owned(), "the mesh has no triangles; export it with its faces"),
        (Obj, String::new(), "the mesh has no triangles; export it with its faces"),
        (
            Stl,
            "solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n\
             endfacet\nendsolid\n"
                .to_owned(),
            "face 0 (line 2) has 2 corners; export the mesh again",
        ),
        (
            Stl,
            "solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 inf\nvertex 1 0 0\n\
             vertex 1 0 0\nendloop\nendfacet\nendsolid\n"
                .to_owned(),
            "face 0 (line 2): vertex 0 (line 4): z is inf; every coordinate must be a finite f32",
        ),
        (
            Stl,
            "solid\nfacet normal 0 0 0\nvertex 0 0 0\n".to_owned(),
            "line 3: `vertex` does not belong here; re-export the mesh",
        ),
        (
            Stl,
            "solid\nfacet normal 0 0 0\n".to_owned(),
            "truncated: `endsolid` is missing; copy or export the file again",
        ),
        (
            Stl,
            "hello".to_owned(),
            "truncated: the header needs 84 bytes, the file has 5; copy or export the file again",
        ),
        (
            Stl,
            "solid\nendsolid\n".to_owned(),
            "the mesh has no triangles; export it with its faces",
        ),
    ];
    for (format, content, expected) in cases {
        let error = Mesh::from_bytes("m", format, content.as_bytes()).expect_err(expected);
        assert_eq!(error.to_string(), format!("m: {expected}"), "{content}");
    }
}

#[test]
fn wrong_binary_files_say_what_where_and_what_mends_it() {
    let check = |file: &str, change: &dyn Fn(&mut Vec<u8>), expected: &str| {
        let (format, mut bytes) = read(file);
        change(&mut bytes);
        let error = Mesh::from_bytes(file, format, &bytes).expect_err(expected);
        assert_eq!(error.to_string(), format!("{file}: {expected}"));
    };
    let nan = f32::NAN.to_le_bytes();
    check(
        "box.little.ply",
        &|bytes| {
            let at = bytes.len() - 4;
            bytes[at..].copy_from_slice(&8_i32.to_le_bytes());
        },
        "face 11: index 8 is out of range, the mesh has 8 vertices; re-export the mesh",
    );
    check(
        "box.big.ply",
        &|bytes| {
            let at = bytes.len() - 4;
            bytes[at..].copy_from_slice(&(-2_i32).to_be_bytes());
        },
        "face 11: index -2 is out of range, the mesh has 8 vertices; re-export the mesh",
    );
    check(
        "box.little.ply",
        &|bytes| {
            let at = bytes.len() - 12 * 13 - 8;
            bytes[at..at + 4].copy_from_slice(&nan);
        },
        "face 2: vertex 7: y is NaN; every coordinate must be a finite f32",
    );
    check(
        "box.little.ply",
        &|bytes| bytes.truncate(bytes.len() - 1),
        "truncated: the header promises 12 of element `face`, the file ends at 11; copy or \
         export the file again",
    );
    check(
        "box.little.ply",
        &|bytes| bytes.push(7),
        "1 bytes after the last element; re-export the mesh",
    );
    check(
        "box.binary.stl",
        &|bytes| bytes[96..100].copy_from_slice(&nan),
        "face 0: vertex 0: x is NaN; every coordinate must be a finite f32",
    );
    check(
        "box.binary.stl",
        &|bytes| {
            bytes[0] = b'S';
            bytes.truncate(600);
        },
        "truncated: 12 triangles need 684 bytes, the file has 600; copy or export the file again",
    );
    check(
        "box.binary.stl",
        &|bytes| {
            bytes.extend([0; 50]);
        },
        "12 triangles need 684 bytes, the file has 734: bytes after the last element; re-export \
         the mesh",
    );
    check(
        "box.glb",
        &|bytes| bytes.truncate(700),
        "truncated: the header promises 780 bytes, the file has 700; copy or export the file \
         again",
    );
    check(
        "box.glb",
        &|bytes| {
            let at = bytes.len() - 2;
            bytes[at..].copy_from_slice(&[9, 0]);
        },
        "mesh 0 primitive 0: index 9 is out of range, it has 8 vertices; re-export the mesh",
    );
    check(
        "box.glb",
        &|bytes| {
            let at = bytes.len() - 72 - 96;
            bytes[at..at + 4].copy_from_slice(&nan);
        },
        "mesh 0 primitive 0: vertex 0 at [NaN, 0.0, -2.0] is not finite in f32 in its place; re-export \
         the mesh",
    );
}

#[test]
fn wrong_gltf_documents_say_what_where_and_what_mends_it() {
    let (_, bytes) = read("box.gltf");
    let sound = String::from_utf8(bytes).expect("text");
    let uri = sound.split("\"uri\": \"").nth(1).and_then(|rest| rest.split('"').next());
    let uri = uri.expect("embedded");
    let cases = [
        (
            "\"indices\": 1".to_owned(),
            "\"indices\": 1, \"mode\": 7".to_owned(),
            "mesh 0 primitive 0: mode 7 is none; re-export the mesh",
        ),
        (
            uri.to_owned(),
            "box.bin".to_owned(),
            "buffer 0: a buffer in another file is, for a mesh in memory, not supported; embed \
             the buffers (.glb)",
        ),
        (
            uri.to_owned(),
            "data:application/octet-stream;base64,AAAA".to_owned(),
            "truncated: buffer 0 needs 168 bytes, it has 3; copy or export the file again",
        ),
        (uri.to_owned(), "%ff.bin".to_owned(), "buffer 0: its path is no text; re-export the mesh"),
        (
            "\"POSITION\": 0".to_owned(),
            "\"POSITION\": 9".to_owned(),
            "mesh 0 primitive 0: accessor 9 is out of range, the document has 2; re-export the \
             mesh",
        ),
        (
            "\"count\": 36".to_owned(),
            "\"count\": 37".to_owned(),
            "mesh 0 primitive 0: accessor 1 reaches beyond its buffer view; re-export the mesh",
        ),
        (
            "\"count\": 36".to_owned(),
            "\"count\": 35".to_owned(),
            "mesh 0 primitive 0: 35 corners are not a multiple of three; re-export the mesh",
        ),
        (
            "\"count\": 36".to_owned(),
            "\"count\": 0".to_owned(),
            "the mesh has no triangles; export it with its faces",
        ),
    ];
    for (from, to, expected) in cases {
        assert!(sound.contains(&from), "{from}");
        let content = sound.replace(&from, &to);
        let error =
            Mesh::from_bytes("m", MeshFormat::Gltf, content.as_bytes()).expect_err(expected);
        assert_eq!(error.to_string(), format!("m: {expected}"));
    }

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.gltf");
    std::fs::write(&path, sound.replace(uri, "gone.bin")).expect("written");
    let message = Mesh::load(&path).expect_err("no buffer").to_string();
    assert!(message.contains("no data for buffer 0"), "{message}");
}

#[test]
fn a_mirror_turns_the_corners() {
    let (_, bytes) = read("box.gltf");
    let sound = String::from_utf8(bytes).expect("text");
    let at = sound.find("0.5").expect("the scale");
    let mirrored = format!("{}-0.5{}", &sound[..at], &sound[at + 3..]);
    let mirrored =
        Mesh::from_bytes("m", MeshFormat::Gltf, mirrored.as_bytes()).expect("sound").triangles;
    let plain = Mesh::load(data("box.gltf")).expect("sound").triangles;
    for (m, p) in mirrored.iter().zip(plain.iter()) {
        assert_eq!([m.a.x, m.b.x, m.c.x], [-p.a.x, -p.c.x, -p.b.x]);
        assert_eq!([m.a.y, m.b.y, m.c.y], [p.a.y, p.c.y, p.b.y]);
    }
}

#[test]
fn a_cycle_of_nodes_is_refused() {
    let (_, bytes) = read("box.gltf");
    let sound = String::from_utf8(bytes).expect("text");
    let content = sound.replace("\"mesh\": 0", "\"mesh\": 0, \"children\": [0]");
    let error = Mesh::from_bytes("m", MeshFormat::Gltf, content.as_bytes()).expect_err("a cycle");
    assert_eq!(error.to_string(), "m: nodes: some are their own ancestors; re-export the mesh");
}

#[test]
fn files_that_cannot_be_used_are_named() {
    let message = Mesh::load("nowhere/none.ply").expect_err("missing").to_string();
    assert!(message.starts_with("nowhere/none.ply: cannot be read ("), "{message}");
    assert!(message.ends_with("); check the path"), "{message}");
    for file in ["scene.fbx", "scene"] {
        let message = Mesh::load(file).expect_err("unknown").to_string();
        let expected = "unknown file type; known are .ply, .obj, .stl, .gltf and .glb";
        assert_eq!(message, format!("{file}: {expected}"));
    }
}

#[test]
fn a_file_cut_anywhere_is_refused_or_shorter() {
    for file in BOXES {
        let (format, bytes) = read(file);
        for length in 0..bytes.len() {
            let cut = &bytes[..length];
            if let Ok(mesh) = Mesh::from_bytes(file, format, cut) {
                let only_space = bytes[length..].trim_ascii().is_empty();
                assert!(mesh.triangles.len() < 12 || only_space, "{file} cut at {length}");
                // Of all formats OBJ alone does not say how much it holds.
                assert!(only_space || format == MeshFormat::Obj, "{file} cut at {length}");
            }
        }
    }
}

#[test]
fn a_changed_byte_never_panics() {
    for file in BOXES {
        let (format, mut bytes) = read(file);
        for at in 0..bytes.len() {
            let sound = bytes[at];
            for change in [0, 1, 7, 9, 10, b' ', b'-', b'0', b'9', b'f', 0x7f, 0x80, 0xff] {
                bytes[at] = change;
                if let Ok(mesh) = Mesh::from_bytes(file, format, &bytes) {
                    assert!(mesh.triangles.iter().all(|triangle| {
                        triangle.corners().iter().all(|p| p.dot(*p).abs() >= 0.0)
                    }));
                }
            }
            bytes[at] = sound;
        }
    }
}
