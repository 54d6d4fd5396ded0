//! Files as programs write them: what is unambiguous is read, what is lost is noted, and a strict
//! reading refuses what the format's standard does not have.
#![allow(missing_docs, reason = "tests")]

use std::fs;
use std::path::{Path, PathBuf};

use trisect_core::Triangle;
use trisect_mesh::{Mesh, ReadOptions};

type Corners = [[f32; 3]; 3];

const O: [f32; 3] = [0.0; 3];
const X: [f32; 3] = [1.0, 0.0, 0.0];
const Y: [f32; 3] = [0.0, 1.0, 0.0];
const Z: [f32; 3] = [0.0, 0.0, 1.0];
/// The faces of the tetrahedron that nearly all files here hold.
const TETRAHEDRON: [Corners; 4] = [[O, Y, X], [O, X, Z], [O, Z, Y], [X, Y, Z]];

fn of(corners: &[Corners]) -> Vec<Triangle<f32>> {
    corners.iter().map(|[a, b, c]| Triangle::new(*a, *b, *c)).collect()
}

fn load(path: &Path, strict: bool) -> Result<Mesh, String> {
    let options = ReadOptions { strict, ..ReadOptions::default() };
    Mesh::load_with(path, &options).map_err(|error| error.to_string())
}

/// Writes a file, and reads it.
fn read(name: &str, bytes: &[u8], strict: bool) -> Result<Mesh, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("it is written");
    let prefix = format!("{}/", folder.path().display());
    load(&path, strict).map_err(|message| message.replace(&prefix, ""))
}

fn notes(mesh: &Mesh) -> Vec<String> {
    let note =
        |note: &trisect_mesh::Note| format!("{} × {} ({})", note.count, note.what, note.first);
    mesh.notes.iter().map(note).collect()
}

fn ordinary(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/ordinary").join(name)
}

/// Each with its note, where something is lost, and whether a strict reading takes it.
#[test]
fn ordinary_files_are_read() {
    let square: [Corners; 2] = [[O, Y, [1.0, 1.0, 0.0]], [O, [1.0, 1.0, 0.0], X]];
    let with_square: Vec<Corners> = square.into_iter().chain(TETRAHEDRON).collect();
    let tail = "1 × bytes after the last triangle are left out (10 bytes)";
    for (file, expected, note, strict) in [
        ("backslash.obj", &TETRAHEDRON[..], "", true),
        ("bom.obj", &[[O, X, Y]], "", false),
        ("latin1-comment.obj", &TETRAHEDRON, "", false),
        ("quad.obj", &with_square, "", true),
        ("ascii-cloudcompare-name.ply", &TETRAHEDRON, "", true),
        ("ascii-dots.ply", &TETRAHEDRON, "", true),
        ("ascii-nan-extra.ply", &TETRAHEDRON, "", true),
        ("le-cr-header.ply", &TETRAHEDRON, "", true),
        ("ascii-end-loop.stl", &TETRAHEDRON, "", false),
        ("ascii-end-solid.stl", &TETRAHEDRON, "", false),
        ("ascii-latin1.stl", &TETRAHEDRON, "", false),
        ("ascii-upper.stl", &TETRAHEDRON, "", false),
        ("bin-tail.stl", &TETRAHEDRON, tail, false),
    ] {
        let mesh = load(&ordinary(file), false).expect(file);
        assert_eq!(*mesh.triangles, of(expected), "{file}");
        assert_eq!(notes(&mesh).join("; "), note, "{file}");
        assert_eq!(load(&ordinary(file), true).is_ok(), strict, "{file}");
    }
}

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const STL: &str = "solid x\n facet normal 0 0 0\n  outer loop\n   vertex 0 0 0\n   vertex 0 1 0\n   \
                   vertex 1 0 0\n  endloop\n endfacet\nendsolid x\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                   property float z\nelement face 4\nproperty list uchar int vertex_indices\n\
                   end_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// Whether a change of a sound file is standard, whether it loses something, and that it changes no
/// triangle.
#[test]
fn changes_that_change_no_triangle() {
    let utf16 = |text: &str| -> Vec<u8> {
        format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect()
    };
    for (name, sound) in [("m.obj", OBJ), ("m.stl", STL), ("m.ply", PLY)] {
        let whole: Vec<Triangle<f32>> =
            read(name, sound.as_bytes(), true).expect(name).triangles.to_vec();
        let variants: [(&str, Vec<u8>, bool); 7] = [
            ("CR LF", sound.replace('\n', "\r\n").into(), true),
            ("CR", sound.replace('\n', "\r").into(), true),
            ("tabs", sound.replace(' ', "\t").replace("end\t", "end ").into(), true),
            ("spaces", sound.replace('\n', "  \n").into(), true),
            ("no last end", sound.trim_end().into(), true),
            ("a mark", [b"\xef\xbb\xbf", sound.as_bytes()].concat(), false),
            ("upper case", sound.to_ascii_uppercase().into(), false),
        ];
        for (what, bytes, strict) in variants {
            let mesh = read(name, &bytes, false).unwrap_or_else(|error| panic!("{what}: {error}"));
            assert_eq!(*mesh.triangles, whole, "{name} {what}");
            assert!(mesh.notes.is_empty(), "{name} {what}");
            assert_eq!(read(name, &bytes, true).is_ok(), strict, "{name} {what}");
        }
        if name != "m.ply" {
            let mesh = read(name, &utf16(sound), false).expect("it has a mark");
            assert_eq!(*mesh.triangles, whole, "{name}");
        }
    }
}

/// What is replaced by what; the notes, and whether a strict reading takes it.
const OBJ_CHANGES: &[(&str, &str, &str, bool)] = &[
    // Nothing is lost.
    ("f 1 3 2", "f 1 3 \\\n2", "", true),
    ("f 1 3 2", "f 1\\\r\n3\\\r\n2", "", true),
    ("f 1 3 2", "vt 0 0\nf 1/\\\n1 3\\\n/1 2", "", true),
    ("f 2 3 4\n", "f 2 3 4 \\", "", true),
    ("f 1 3 2", "# path\\\nf 1 3 2", "", true),
    ("f 1 3 2", "o C:\\models\\\nf 1 3 2", "", true),
    ("f 1 3 2", "g a \\\n b\nf 1 3 2", "", true),
    ("f 1 3 2", "f 1 3 2 # 4", "", true),
    ("f 1 3 2", "f 1 3 2#4", "", true),
    ("f 1 3 2", "f -4 -2 -3", "", true),
    ("f 1 3 2", "f +1 3 -3", "", true),
    ("f 1 3 2", "fo 1 3 2", "", true),
    ("v 1 0 0", "v 1. .0 -0e5", "", true),
    ("v 1 0 0", "v 1 0 0 1.0", "", true),
    ("f 1 3 2", "s off\nmg 0\nusemtl wood#1\nlod 3\nf 1 3 2", "", true),
    ("f 1 3 2", "vn 0 0 1\nvt 1\nvt 1 2 3\nf 1/1/1 3//1 2/2", "", true),
    ("f 1 3 2", "vt 0 0\nf 1/1/ 3/1/ 2/", "", false),
    ("f 1 3 2", "v 0 nan inf\nf 1 3 2", "", false),
    // What the standard has, and triangles cannot say.
    (
        "f 1 3 2",
        "p 1 2\nf 1 3 2\nl 1 2",
        "2 × points and lines are left out: no ray can hit them (line 5)",
        true,
    ),
    (
        "f 1 3 2",
        "cstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1\nend\nf 1 3 2",
        "1 × free-form curves and surfaces are left out; export them as polygons (line 7)",
        true,
    ),
    (
        "f 1 3 2",
        "call x.obj\nf 1 3 2",
        "1 × `call` and `csh` are not followed; what they bring is left out (line 5)",
        true,
    ),
    (
        "v 1 0 0",
        "v 1 0 0 0.5",
        "1 × a vertex's weight is left out: it is for free-form curves and surfaces (line 2)",
        true,
    ),
    // What the standard does not have.
    ("v 1 0 0", "v 1 0 0 .5 1 0", "1 × a vertex's colour is left out (line 2)", false),
    (
        "v 1 0 0",
        "v 1 0 0 red",
        "1 × what a vertex has after its coordinates is left out (line 2)",
        false,
    ),
    (
        "f 1 3 2",
        "f 1 3 2\nf 1 2\nf 4\nf",
        "3 × a face of fewer than three corners has no area and is left out (face 1 (line 6))",
        false,
    ),
    (
        "f 1 3 2",
        "colour 3\nf 1 3 2",
        "1 × a statement that OBJ does not have is left out (line 5: `colour`)",
        false,
    ),
    (
        "f 1 3 2",
        "f 1///7 3 2",
        "1 × what a corner has after its third number is left out (line 5)",
        false,
    ),
    (
        "f 1 3 2",
        "vt one\nf 1/1 3 2",
        "1 × texture coordinates that are not finite numbers are left out (line 5)",
        false,
    ),
    (
        "f 1 3 2",
        "vn 0 inf 0\nf 1 3 2",
        "1 × a normal that is not three finite numbers is left out (line 5)",
        false,
    ),
    (
        "f 1 3 2",
        "vt 0 0\nf 1/9 3/x/-1 2/0",
        "4 × texture coordinates and normals that the file does not have are left out (line 6)",
        false,
    ),
];

#[test]
fn obj_says_more_than_triangles() {
    for (from, to, note, strict) in OBJ_CHANGES {
        let text = OBJ.replacen(from, to, 1);
        let mesh = read("m.obj", text.as_bytes(), false).expect(to);
        assert_eq!(*mesh.triangles, of(&TETRAHEDRON), "{to}");
        assert_eq!(notes(&mesh).join("; "), *note, "{to}");
        assert_eq!(read("m.obj", text.as_bytes(), true).is_ok(), *strict, "{to}");
    }
    for (from, to, expected) in [
        ("v 1 0 0", "v 1,0 0 0", "line 2: x is `1,0`, not a number; "),
        ("v 1 0 0", "v 1 0 1d3", "line 2: z is `1d3`, not a number; "),
        ("f 1 3 2", "f 1.0 3 2", "line 5: corner `1.0` is not an index; "),
        ("f 1 3 2", "f /1 3 2", "line 5: corner `/1` is not an index; "),
        ("f 1 3 2", "f 1 3 2 0", "face 0 (line 5): index 0 is out of range, "),
        ("v 1 0 0", "v 1\0 0 0", "line 2: is no text; "),
    ] {
        let message = read("m.obj", OBJ.replacen(from, to, 1).as_bytes(), false).expect_err(to);
        assert!(message.starts_with(&format!("m.obj: {expected}")), "{message}");
    }
}

#[test]
fn stl_is_written_in_many_ways() {
    let cases: &[(&str, &str, &str, bool)] = &[
        ("solid x", "solid facet outer loop", "", true),
        ("facet normal 0 0 0", "facet normal nan -1.#IND nan", "", true),
        ("facet normal 0 0 0\n  outer loop\n", "facet normal 0 0 0 outer loop ", "", true),
        ("vertex 0 1 0", "vertex 0.\n1e0 .0", "", true),
        ("endsolid x", "endsolid", "", true),
        ("endsolid x", "endsolid x\nsolid empty\nendsolid empty", "", true),
        ("endfacet", "end facet", "", false),
        ("endsolid x", "END SOLID x", "", false),
        ("solid x", "Solid", "", false),
        (" facet", " color 1 0 0\n facet", "1 × a colour is left out (line 2)", false),
        (
            "endsolid x",
            "endsolid x\n\u{1a} end",
            "1 × text after the last solid is left out (line 10)",
            false,
        ),
    ];
    for (from, to, note, strict) in cases {
        let text = STL.replacen(from, to, 1);
        assert!(text != STL, "{from}");
        let mesh = read("m.stl", text.as_bytes(), false).expect(to);
        assert_eq!(*mesh.triangles, of(&TETRAHEDRON[..1]), "{to}");
        assert_eq!(notes(&mesh).join("; "), *note, "{to}");
        assert_eq!(read("m.stl", text.as_bytes(), true).is_ok(), *strict, "{to}");
    }
    let four = STL.replacen("vertex 1 0 0", "vertex 1 1 0\nvertex 1 0 0", 1);
    let mesh = read("m.stl", four.as_bytes(), false).expect("a square");
    assert_eq!(*mesh.triangles, of(&[[O, Y, [1.0, 1.0, 0.0]], [O, [1.0, 1.0, 0.0], X]]));
    assert_eq!(mesh.notes.len(), 1);
    assert!(read("m.stl", four.as_bytes(), true).is_err());
    for (from, to, expected) in [
        ("vertex 1 0 0\n", "", "face 0 (line 2) has 2 corners; "),
        ("outer loop", "", "line 4: `vertex` does not belong here; "),
        ("endsolid x", "", "truncated: `endsolid` is missing; "),
        ("vertex 1 0 0", "vertex 1 nan 0", "face 0 (line 2): vertex 2 (line 6): y is NaN; "),
        ("vertex 1 0 0", "vertex 1 0", "line 6: z is `endloop`, not a number; "),
    ] {
        let message = read("m.stl", STL.replacen(from, to, 1).as_bytes(), false).expect_err(from);
        assert!(message.starts_with(&format!("m.stl: {expected}")), "{message}");
    }
}

/// A binary STL of the tetrahedron whose header begins so, that counts so many.
fn binary_stl(header: &[u8], count: u32) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(count.to_le_bytes());
    for corners in TETRAHEDRON {
        bytes.extend([0; 12]);
        bytes.extend(corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
        // Some programs keep a colour here.
        bytes.extend([0x1f, 0x80]);
    }
    bytes
}

#[test]
fn binary_stl_is_told_from_ascii() {
    for header in [&b"solid x"[..], b"SOLID facet normal", b"", b"\xef\xbb\xbfsolid"] {
        for tail in [&b""[..], b"\n", b"notes of a program"] {
            let bytes = [&binary_stl(header, 4), tail].concat();
            let mesh = read("m.stl", &bytes, false).expect("sound");
            assert_eq!(*mesh.triangles, of(&TETRAHEDRON));
            assert_eq!(mesh.notes.len(), usize::from(!tail.is_empty()));
        }
    }
    // Triangles that the count misses are no notes of a program.
    for (count, expected) in [
        (0, "0 triangles need 84 bytes, the file has 284: bytes after the last element; "),
        (3, "3 triangles need 234 bytes, the file has 284: bytes after the last element; "),
        (5, "truncated: 5 triangles need 334 bytes, the file has 284; "),
    ] {
        let message = read("m.stl", &binary_stl(b"", count), false).expect_err(expected);
        assert!(message.starts_with(&format!("m.stl: {expected}")), "{message}");
    }
}

#[test]
fn ply_headers_are_written_in_many_ways() {
    let comment = "1 × a line of the header that is no statement is taken as a comment (line 3)";
    let cases: &[(&str, &str, &str, bool)] = &[
        ("element vertex", "comment x\nobj_info num_cols 3\nelement vertex", "", true),
        ("float x", "float32 x", "", true),
        ("float x", "float64 x", "", true),
        ("uchar int", "uint8 int32", "", true),
        ("uchar int", "int uint", "", true),
        ("vertex_indices", "vertex_index", "", true),
        ("0 0 0\n1 0 0", "0 0 0\n\n1 0 0", "", true),
        ("float x", "float X", "", true),
        ("element vertex", "\nelement vertex", "", false),
        ("ascii 1.0", "ascii 1", "", false),
        ("3 0 2 1", "3 0.0 2.0 1.0", "", false),
        (
            "element vertex",
            "Created by Blender3D 2.43, source file: x\nelement vertex",
            comment,
            false,
        ),
    ];
    for (from, to, note, strict) in cases {
        let text = PLY.replacen(from, to, 1);
        assert!(text != PLY, "{from}");
        let mesh = read("m.ply", text.as_bytes(), false).expect(to);
        assert_eq!(*mesh.triangles, of(&TETRAHEDRON), "{to}");
        assert_eq!(notes(&mesh).join("; "), *note, "{to}");
        assert_eq!(read("m.ply", text.as_bytes(), true).is_ok(), *strict, "{to}");
    }
    for (from, to, expected) in [
        ("ply\n", "mesh\n", "line 1: it is not `ply`, with which a PLY file begins; "),
        ("format ascii 1.0\n", "", "no format in the header; "),
        ("ascii", "text", "line 2: `text` is no encoding of PLY; "),
        (
            "property float x",
            "proprty float x",
            "line 4: `proprty float x` is no sound statement; ",
        ),
        ("property float x", "property real x", "line 4: `property real x` is no sound property; "),
        ("element face 4", "elemnt face 4", "line 7: `elemnt face 4` is no sound statement; "),
        ("element face 4", "element face -4", "line 7: `element face -4` has no sound count; "),
        ("element face", "element vertex", "line 7: element `vertex` is there twice; "),
        ("float z", "float x", "line 6: property `x` is there twice; "),
        ("3 0 2 1", "-3 0 2 1", "line 14: `vertex_indices` has -3 entries, not a count; "),
        ("3 0 2 1", "4000000000 0 2 1", "line 14: `vertex_indices` is incomplete; "),
        ("3 0 2 1", "3 0 2.5 1", "line 14: `vertex_indices` is `2.5`, not an index; "),
    ] {
        let text = PLY.replacen(from, to, 1);
        assert!(text != PLY, "{from}");
        let message = read("m.ply", text.as_bytes(), false).expect_err(to);
        assert!(message.starts_with(&format!("m.ply: {expected}")), "{message}");
    }
}

#[test]
fn coordinates_have_the_precision_that_the_header_says() {
    let read = |text: &str| read("m.ply", text.as_bytes(), true).expect("sound");
    let third = PLY.replacen("1 0 0", "0.1 0 0", 1);
    let mesh = read(&third);
    assert_eq!((mesh.rounding(), mesh.triangles_f64()[0].c.x), (0.0, f64::from(0.1_f32)));
    let mesh = read(&third.replace("float x", "double x"));
    assert!(mesh.rounding() > 0.0 && mesh.triangles_f64()[0].c.x == 0.1);
}

#[test]
fn rounding_can_take_an_areas_all() {
    let far =
        PLY.replace("float", "double").replace("1 0 0", "1e9 1 1").replace("0 1 0", "1e9 1 2");
    let far = far.replace("0 0 1\n", "1e9 1 3\n").replace("0 0 0", "1e9 2 1");
    let mesh =
        read("m.ply", far.replace("1e9 1 2", "1000000001 1 2").as_bytes(), true).expect("sound");
    assert_eq!((mesh.degenerate, mesh.degenerate_f64()), (1, 0));
}

/// Scalars of PLY under both of their names, with their sizes.
const SCALARS: [(&str, &str, usize); 8] = [
    ("char", "int8", 1),
    ("uchar", "uint8", 1),
    ("short", "int16", 2),
    ("ushort", "uint16", 2),
    ("int", "int32", 4),
    ("uint", "uint32", 4),
    ("float", "float32", 4),
    ("double", "float64", 8),
];

/// The words of one element, written as the types say.
fn write(bytes: &mut Vec<u8>, encoding: &str, values: &[(usize, i16)]) {
    for &(scalar, value) in values {
        let little = match scalar {
            6 => f32::from(value).to_le_bytes().to_vec(),
            7 => f64::from(value).to_le_bytes().to_vec(),
            _ => i64::from(value).to_le_bytes()[..SCALARS[scalar].2].to_vec(),
        };
        match encoding {
            "ascii" => bytes.extend(format!("{value} ").bytes()),
            "binary_little_endian" => bytes.extend(little),
            _ => bytes.extend(little.iter().rev()),
        }
    }
    if encoding == "ascii" {
        bytes.push(b'\n');
    }
}

/// Every type of coordinates, counts and indices, among properties and elements of every type that nobody
/// reads, faces before vertices and after them.
#[test]
fn ply_of_every_type_and_encoding_is_the_same_mesh() {
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for (number, (name, alias, _)) in SCALARS.iter().enumerate() {
            let (integer, count) = (number % 6, (number + 1) % 6);
            let (integer_name, count_name) = (SCALARS[integer].0, SCALARS[count].1);
            let other = (number + 3) % 8;
            let vertices = format!(
                "element vertex 4\nproperty {} a\nproperty {name} x\nproperty {alias} y\n\
                 property list {count_name} {} b\nproperty {name} z\nproperty {} c\n",
                SCALARS[other].0, SCALARS[other].1, SCALARS[other].1
            );
            let faces = format!(
                "element face 4\nproperty list {count_name} {} texcoord\n\
                 property list {count_name} {integer_name} vertex_indices\nproperty {alias} flags\n",
                SCALARS[other].0
            );
            let spare = format!("element edge 2\nproperty {name} q\n");
            let mut data = [Vec::new(), Vec::new(), Vec::new()];
            for at in [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]] {
                let list = [(count, 2), (other, 10), (other, 11)];
                let head = [(other, 13), (number, at[0]), (number, at[1])];
                let values = [&head[..], &list, &[(number, at[2]), (other, 10)]].concat();
                write(&mut data[0], encoding, &values);
            }
            for [a, b, c] in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
                let head = [(count, 1), (other, 10), (count, 3)];
                let indices = [a, b, c].map(|index| (integer, index));
                write(&mut data[1], encoding, &[&head[..], &indices, &[(number, 13)]].concat());
            }
            for _ in 0..2 {
                write(&mut data[2], encoding, &[(number, 10)]);
            }
            for order in [[0, 1, 2], [1, 0, 2], [2, 1, 0]] {
                for end in ["\n", "\r\n", "\r"] {
                    let elements = order.map(|i| [&vertices, &faces, &spare][i].as_str()).concat();
                    let header = format!("ply\nformat {encoding} 1.0\n{elements}end_header\n");
                    let mut bytes = header.replace('\n', end).into_bytes();
                    bytes.extend(order.iter().flat_map(|&i| &data[i]));
                    let mesh = read("m.ply", &bytes, true).unwrap_or_else(|error| {
                        panic!("{encoding} {name} {order:?} {end:?}: {error}");
                    });
                    assert_eq!(
                        *mesh.triangles,
                        of(&TETRAHEDRON),
                        "{encoding} {name} {order:?} {end:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn strips_of_range_scans_are_triangles() {
    // Two strips, the second of them with a corner twice, as where strips are joined.
    let strips = PLY
        .replace("element face 4", "element tristrips 1")
        .replace("3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n", "11 1 0 2 3 -1 0 1 3 3 2 1\n");
    let mesh = read("m.ply", strips.as_bytes(), true).expect("sound");
    assert_eq!(*mesh.triangles, of(&[[X, O, Y], [Y, O, Z], [O, X, Z], [Y, Z, X]]));
    let wrong = strips.replace("2 3 -1", "2 4 -1");
    let message = read("m.ply", wrong.as_bytes(), false).expect_err("no such vertex");
    assert!(message.starts_with("m.ply: face 1 (line 14): index 4 is out of range"), "{message}");
}

/// What a header promises is believed when the bytes are there.
#[test]
fn counts_that_the_bytes_do_not_bear_out_are_refused() {
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n\
                  property float y\nproperty float z\nelement face 1\n\
                  property list uint int vertex_indices\nend_header\n";
    let huge = [header.as_bytes(), &[0; 12], &u32::MAX.to_le_bytes(), &[0; 64]].concat();
    let message = read("m.ply", &huge, false).expect_err("too long a list");
    assert!(message.contains("truncated: the header promises 1 of element `face`"), "{message}");
    let negative = header.replace("list uint", "list int");
    let negative = [negative.as_bytes(), &[0; 12], &(-3_i32).to_le_bytes(), &[0; 64]].concat();
    let message = read("m.ply", &negative, false).expect_err("a negative length");
    assert!(message.contains("face 0: `vertex_indices` has -3 entries"), "{message}");
    for count in [20, u64::MAX] {
        let many = header.replace("vertex 1", &format!("vertex {count}"));
        let message =
            read("m.ply", &[many.as_bytes(), &[0; 64]].concat(), false).expect_err("too many");
        assert!(
            message.contains(&format!("the header promises {count} of element `vertex`, but 64 "))
        );
    }
}

#[test]
fn memory_is_limited_for_what_is_decoded_too() {
    let text = OBJ.repeat(2000);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.obj");
    fs::write(&path, &text).expect("it is written");
    let load =
        |max_memory| Mesh::load_with(&path, &ReadOptions { max_memory, ..ReadOptions::default() });
    assert!(load(text.len() as u64 * 40).is_ok());
    let message = load(text.len() as u64 * 2).expect_err("it is more when decoded").to_string();
    assert!(message.ends_with("that --max-memory allows; raise it"), "{message}");
}

/// A line of a file may be long, and hold anything.
#[test]
fn messages_quote_the_head_of_what_is_wrong() {
    let long = "\u{1b}".repeat(5000);
    for (name, sound, from) in [
        ("m.obj", OBJ, "v 1 0 0"),
        ("m.obj", OBJ, "f 1 3 2"),
        ("m.stl", STL, "vertex 1 0 0"),
        ("m.stl", STL, "outer"),
        ("m.ply", PLY, "ply"),
        ("m.ply", PLY, "ascii"),
        ("m.ply", PLY, "element vertex 4"),
        ("m.ply", PLY, "property float x"),
        ("m.ply", PLY, "1 0 0"),
        ("m.ply", PLY, "3 0 2 1"),
        ("m.ply", PLY, "0 2 1"),
    ] {
        let at = sound.find(from).expect("it is there") + from.len() - 1;
        let text = format!("{}{long}{}", &sound[..at], &sound[at..]);
        let message = read(name, text.as_bytes(), false).expect_err(from);
        assert!(
            message.len() < 600 && !message.contains('\u{1b}'),
            "{from}: {} {message}",
            message.len()
        );
    }
    let text = format!("{OBJ}{long} 1\n");
    let mesh = read("m.obj", text.as_bytes(), false).expect("one statement is left out");
    assert!(notes(&mesh)[0].len() < 600 && !notes(&mesh)[0].contains('\u{1b}'));
}
