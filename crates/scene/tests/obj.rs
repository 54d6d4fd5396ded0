//! What OBJ files and their material libraries become, and what is said of those that are out of the
//! ordinary.
#![allow(missing_docs, reason = "tests")]

use std::fs;

use trisect_scene::{Material, Scene, Vec2, Vec3};

fn in_folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("in the folder")).expect("it is made");
        fs::write(path, content).expect("it is written");
    }
    folder
}

/// Loads `m.obj` of a folder, and returns its notes without the folder's path.
fn load(files: &[(&str, &[u8])], strict: bool) -> Result<(Scene, Vec<String>), String> {
    let folder = in_folder(files);
    let prefix = format!("{}/", folder.path().display());
    let options = trisect_mesh::ReadOptions { strict, ..Default::default() };
    let scene = Scene::load_with(folder.path().join("m.obj"), &options);
    let scene = scene.map_err(|error| error.to_string().replace(&prefix, ""))?;
    let notes = scene.notes.iter().map(|note| note.to_string().replace(&prefix, "")).collect();
    Ok((scene, notes))
}

/// A picture of one red pixel.
fn red() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&[255, 0, 0]).expect("a pixel");
    writer.finish().expect("an end");
    bytes
}

const SQUARE: &str = "mtllib square.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\n\
                      vt 1 1\nvt 0 1\nvn 0 0 1\nusemtl pane\nf 1/1/1 2/2/1 3/3/1 4/4/1\n\
                      usemtl tin\nf 1/1/1 2/2/1 3/3/1\n";
const MATERIALS: &str = "newmtl tin\nKd 0.1 0.2 0.3\nKs 0.8 0.8 0.9\nNs 50\nillum 3\n\n\
                         newmtl pane\nKd 0.5 0.5 0.5\nd 0.2\nNi 1.33\n";

#[test]
fn obj_brings_materials_normals_and_coordinates() {
    let library = MATERIALS.to_owned() + "Ke 1 2 3\n";
    let files = [("m.obj", SQUARE.as_bytes()), ("square.mtl", library.as_bytes())];
    let (scene, notes) = load(&files, false).expect("it is sound");
    assert_eq!(notes, [""; 0]);
    let mesh = &scene.meshes[0];
    let names: Vec<&str> =
        mesh.materials.iter().map(|&material| scene.materials[material].name.as_str()).collect();
    // The face of four corners is two triangles.
    assert_eq!(names, ["pane", "pane", "tin"]);
    assert_eq!(mesh.normals, [[Vec3::Z; 3]; 3]);
    assert_eq!(mesh.coordinates[0], [Vec2::ZERO, Vec2::X, Vec2::ONE]);
    assert_eq!(mesh.coordinates[1], [Vec2::ZERO, Vec2::ONE, Vec2::Y]);
    let find = |name| scene.materials.iter().find(|m| m.name == name).expect("it is there");
    assert_eq!(find("tin").reflection, Vec3::new(0.8, 0.8, 0.9));
    let pane = find("pane");
    assert_eq!((pane.index_of_refraction, pane.emission), (1.33, Vec3::new(1.0, 2.0, 3.0)));
    assert!((pane.transmission.x - 0.8).abs() < 1e-6 && (pane.diffuse.x - 0.1).abs() < 1e-6);
    assert_eq!((scene.cameras.len(), scene.lights.len()), (1, 1));
}

#[test]
fn wrong_triangles_are_refused_by_line() {
    for (from, to, expected) in [
        ("v 1 1 0", "v 1 x 0", "line 4: y is `x`, not a number; "),
        ("v 1 1 0", "v 1 nan 0", "face 0 (line 12): vertex 2 (line 4): y is NaN; "),
        ("f 1/1/1 2/2/1 3/3/1\n", "f 1 2 9\n", "face 1 (line 14): index 9 is "),
        ("f 1/1/1 2/2/1 3/3/1\n", "f 0 1 2\n", "face 1 (line 14): index 0 is "),
    ] {
        let text = SQUARE.replacen(from, to, 1);
        assert!(text != SQUARE, "{from}");
        let error = load(&[("m.obj", text.as_bytes())], false).map(drop).expect_err(to);
        assert!(error.starts_with(&format!("m.obj: {expected}")), "{error}");
    }
}

/// What is lost beside the triangles, as a note; a strict reading refuses it.
#[test]
fn faults_beside_the_triangles_are_noted_by_line() {
    let sound = [("m.obj", SQUARE.as_bytes()), ("square.mtl", MATERIALS.as_bytes())];
    assert_eq!(load(&sound, true).expect("it is standard").1, [""; 0]);
    for (from, to, expected) in [
        (
            "vt 1 1",
            "vt one",
            "m.obj: texture coordinates that are not finite numbers are left out (line 8)",
        ),
        (
            "f 1/1/1 2/2/1 3/3/1\n",
            "f 1/9/1 2/2/1 3/3/1\n",
            "m.obj: texture coordinates and normals that the file does not have are left out (line 14)",
        ),
        (
            "usemtl tin",
            "usemtl lead",
            "m.obj: a material that no library has is taken as grey (line 13: `lead`)",
        ),
        (
            "mtllib square.mtl",
            "mtllib round.mtl",
            "m.obj: a material library that cannot be read is left out (line 1: `round.mtl`: cannot be ",
        ),
        (
            "newmtl tin",
            "Kd 1 1 1\nnewmtl tin",
            "square.mtl: a statement before the first material is left out (line 1: Kd)",
        ),
        (
            "newmtl pane",
            "newmtl tin\nnewmtl pane",
            "square.mtl: a material of a name that is there already replaces it (line 7: newmtl)",
        ),
        (
            "Kd 0.5 0.5 0.5",
            "map_Kd no.png",
            "square.mtl: a picture that cannot be used is left out (line 8: map_Kd: `no.png`: cannot be ",
        ),
        (
            "Kd 0.5 0.5 0.5",
            "map_Kd square.mtl",
            "square.mtl: a picture that cannot be used is left out (line 8: map_Kd: `square.mtl`: ",
        ),
        ("Ns 50", "Ns shiny", "square.mtl: what is not a number from 0 is left out (line 4: Ns)"),
        (
            "Ni 1.33",
            "Ni 0",
            "square.mtl: what is not a number from 0.001 is left out (line 10: Ni)",
        ),
        ("d 0.2", "d -1", "square.mtl: what is not a number from 0 is left out (line 9: d)"),
        (
            "illum 3",
            "illum 11",
            "square.mtl: a model of illumination other than 0 to 10 is left out (line 5: illum)",
        ),
        (
            "Ni 1.33",
            "Ks 1 2",
            "square.mtl: a colour that is not one or three numbers from 0 is left out (line 10: Ks)",
        ),
        (
            "Kd 0.1 0.2 0.3",
            "Kd 0.1 nan 0.3",
            "square.mtl: a colour that is not one or three numbers from 0 is left out (line 2: Kd)",
        ),
        ("Ns 50", "map_Kd", "square.mtl: a map without a file is left out (line 4: map_Kd)"),
    ] {
        let (obj, mtl) = (SQUARE.replacen(from, to, 1), MATERIALS.replacen(from, to, 1));
        assert!(obj != SQUARE || mtl != MATERIALS, "{from}");
        let files = [("m.obj", obj.as_bytes()), ("square.mtl", mtl.as_bytes())];
        let (scene, notes) = load(&files, false).unwrap_or_else(|error| panic!("{to}: {error}"));
        assert_eq!(scene.meshes[0].triangles.len(), 3, "{to}");
        assert!(notes.len() == 1 && notes[0].starts_with(expected), "{to}: {notes:?}");
        assert!(load(&files, true).is_err(), "{to}");
    }
}

const FACE: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";

/// The material of the first triangle of a file with this line before it, and these files beside it.
fn first(line: &str, files: &[(&str, &[u8])]) -> (Material, Scene, Vec<String>) {
    let text = format!("{line}\n{FACE}");
    let files = [files, &[("m.obj", text.as_bytes())]].concat();
    let (scene, notes) = load(&files, false).unwrap_or_else(|error| panic!("{line}: {error}"));
    (scene.materials[scene.meshes[0].materials[0]].clone(), scene, notes)
}

/// The same with `m.mtl` beside it, of one material.
fn of(library: &str) -> (Material, Scene, Vec<String>) {
    let (png, library) = (red(), format!("newmtl a\n{library}"));
    let names = ["red.png", "my tex.png", "textures/wood.png", "wood#1.png"];
    let mut files: Vec<(&str, &[u8])> = names.iter().map(|name| (*name, &*png)).collect();
    files.push(("m.mtl", library.as_bytes()));
    first("mtllib m.mtl", &files)
}

#[test]
fn libraries_are_found_however_they_are_named() {
    let (one, two) = (&b"newmtl a\nKd 1 0 0\n"[..], &b"newmtl b\nKd 0 1 0\n"[..]);
    for (line, name) in [
        ("mtllib one.mtl two.mtl", "one.mtl"),
        ("mtllib two.mtl one.mtl", "one.mtl"),
        ("mtllib \"one.mtl\"", "one.mtl"),
        ("mtllib my lib.mtl", "my lib.mtl"),
        ("mtllib two.mtl my lib.mtl", "my lib.mtl"),
        ("mtllib \"my lib.mtl\" two.mtl", "my lib.mtl"),
        ("mtllib\tmy lib.MTL two.mtl", "my lib.MTL"),
        ("mtllib lib#1.mtl # the first", "lib#1.mtl"),
        ("mtllib folder\\one.mtl", "folder/one.mtl"),
        ("mtllib materials", "materials"),
        ("mtllib my materials", "my materials"),
        ("mtllib two.mtl\nmtllib one.mtl\nmtllib two.mtl", "one.mtl"),
        ("MTLLIB one.mtl", "one.mtl"),
    ] {
        let (material, _, notes) = first(line, &[(name, one), ("two.mtl", two)]);
        assert_eq!((material.name.as_str(), material.diffuse), ("a", Vec3::X), "{line}");
        assert_eq!(notes, [""; 0], "{line}");
    }
    let (material, _, notes) = first("mtllib none.mtl", &[]);
    assert_eq!((material.diffuse, notes.len()), (Material::default().diffuse, 1));
    let note = "m.obj: a material library that cannot be read is left out (line 1: `none.mtl`: ";
    assert!(notes[0].starts_with(note), "{notes:?}");
}

#[test]
fn names_are_compared_as_they_are() {
    let library = "\u{feff}newmtl wood#1\r\nKd 1 0 0\r\nnewmtl \"wood#2\" # dark\r\nKd 0 1 0\r\n\
                   newmtl K\u{f6}rper alt\nKd 0 0 1\nnewmtl\nKd 1\n";
    let latin1: Vec<u8> = library
        .trim_start_matches('\u{feff}')
        .chars()
        .map(|c| u8::try_from(u32::from(c)).expect("Latin-1"))
        .collect();
    let text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl wood#1\nf 1 2 3\nusemtl wood#2\n\
                f 1 2 3\nusemtl K\u{f6}rper alt\nf 1 2 3\nusemtl\nf 1 2 3\n";
    for library in [library.as_bytes(), &latin1] {
        let (scene, notes) =
            load(&[("m.obj", text.as_bytes()), ("m.mtl", library)], false).expect("it is sound");
        let materials =
            scene.meshes[0].materials.iter().map(|&material| &scene.materials[material]);
        let colors: Vec<Vec3> = materials.map(|material| material.diffuse).collect();
        assert_eq!(colors, [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE]);
        assert_eq!(notes, [""; 0]);
    }
}

#[test]
fn materials_that_are_not_there_are_noted_where_faces_use_them() {
    let library = ("m.mtl", &b"newmtl a\nKd 1 0 0\n"[..]);
    let (material, _, notes) = first("mtllib m.mtl\nusemtl zzz", &[library]);
    assert_eq!((material.name.as_str(), notes.len()), ("a", 0));
    let (_, scene, notes) =
        first("mtllib m.mtl\nusemtl zzz\nf 1 2 3\nusemtl yyy\nf 1 2 4", &[library]);
    let grey = &scene.materials[scene.meshes[0].materials[0]];
    assert_eq!((grey.name.as_str(), grey.diffuse), ("", Material::default().diffuse));
    let note =
        "m.obj: a material that no library has is taken as grey (2 times, first line 2: `zzz`)";
    assert_eq!(notes, [note]);
}

#[test]
fn colours_are_one_number_or_three() {
    for (line, expected) in [
        ("Kd 0.5", Vec3::splat(0.5)),
        ("Kd .5 1. +0", Vec3::new(0.5, 1.0, 0.0)),
        ("kd\t0 1 0 # green", Vec3::Y),
        ("Kd 0 1 0#green", Vec3::Y),
    ] {
        let (material, _, notes) = of(line);
        assert_eq!((material.diffuse, notes.len()), (expected, 0), "{line}");
    }
    for line in ["Kd spectral file.rfl 1", "Kd xyz 0.4 0.3 0.2"] {
        let (material, _, notes) = of(line);
        assert_eq!(material.diffuse, Material::default().diffuse);
        assert_eq!(notes, ["m.mtl: a colour as a spectrum or in XYZ is left out (line 2: Kd)"]);
    }
}

/// What is clear, by what it says; Maya and 3ds Max write models that refract, and `Tf 1 1 1`, for all
/// that is opaque, and Cinema 4D the first of the two.
#[test]
fn glass_is_what_says_that_it_is_clear() {
    for (lines, transmission, diffuse) in [
        ("illum 7", 0.0, 0.8),
        ("illum 4\nTf 1 1 1", 0.0, 0.8),
        ("illum 9\nd 1\nTr 0", 0.0, 0.8),
        ("illum 6\nTf 1", 0.0, 0.8),
        ("Tf 0.5 0.5 0.5", 0.0, 0.8),
        ("Tr 1", 0.0, 0.8),
        ("d 1\nTr 1", 0.0, 0.8),
        ("d 0.25", 0.75, 0.2),
        ("d 0.25\nTr 0.25", 0.75, 0.2),
        ("d -halo 0.25", 0.75, 0.2),
        ("Tr 0.75", 0.75, 0.2),
        ("illum 7\nd 0.25", 0.75, 0.2),
        ("illum 4\nTf 0.75 0.75 0.75", 0.75, 0.2),
        ("illum 6\nTr 1", 1.0, 0.0),
        ("d 0", 1.0, 0.0),
    ] {
        let (material, ..) = of(&format!("Kd 0.8\n{lines}"));
        assert_eq!(material.transmission, Vec3::splat(transmission), "{lines}");
        assert!((material.diffuse - Vec3::splat(diffuse)).abs().max_element() < 1e-6, "{lines}");
    }
    let (red, ..) = of("Kd 1\nillum 4\nTf 1 0 0");
    assert_eq!((red.transmission, red.diffuse), (Vec3::X, Vec3::new(0.0, 1.0, 1.0)));
    let (.., notes) = of("Tr 1");
    assert_eq!(
        notes,
        ["m.mtl: Tr 1 without d is taken as opaque, as programs write it that mean d (line 2)"]
    );
}

#[test]
fn maps_are_found_however_they_are_named() {
    for line in [
        "map_Kd red.png",
        "map_kd\tred.png",
        "map_Kd \"red.png\"",
        "map_Kd my tex.png",
        "map_Kd \"my tex.png\"",
        "map_Kd textures\\wood.png",
        "map_Kd .\\textures\\wood.png",
        "map_Kd wood#1.png # dark",
        "map_Kd -blendu on -blendv off -texres 512 -bm 1.5 -imfchan r red.png",
        "map_Kd -o 0 0 0 -mm 0 1 -t 0 -clamp off red.png",
        "map_Kd -s 1 1 1 my tex.png",
    ] {
        let (material, scene, notes) = of(line);
        assert_eq!(scene.textures.len(), 1, "{line} {notes:?}");
        assert_eq!(scene.textures[0].scale, Vec2::new(1.0, -1.0), "{line}");
        assert_eq!(notes, [""; 0], "{line}");
        // Without `Kd` the picture is shown as it is.
        assert_eq!((material.texture, material.diffuse), (Some(0), Vec3::ONE), "{line}");
    }
    for (line, scale, lost) in [
        ("map_Kd -s 2 3 4 red.png", [2.0, -3.0], ""),
        ("map_Kd -s 2 red.png", [2.0, -1.0], ""),
        ("map_Kd -o 0.5 red.png", [1.0, -1.0], "-o"),
        ("map_Kd -o 0.5 0.5 -s 2 2 red.png", [2.0, -2.0], "-o"),
        ("map_Kd -mm 0.1 0.5 red.png", [1.0, -1.0], "-mm"),
        ("map_Kd -clamp on red.png", [1.0, -1.0], "-clamp"),
    ] {
        let (_, scene, notes) = of(line);
        assert_eq!(scene.textures[0].scale, Vec2::from(scale), "{line}");
        let note = format!("m.mtl: the option {lost} of map_Kd is left out (line 2: map_Kd)");
        assert_eq!(notes.join(""), if lost.is_empty() { String::new() } else { note }, "{line}");
    }
    // One picture is one texture, whoever uses it.
    let (_, scene, _) =
        of("map_Kd red.png\nnewmtl b\nmap_Kd red.png\nnewmtl c\nmap_Kd -s 2 2 red.png");
    assert_eq!(scene.textures.len(), 2);
    let (.., notes) = of("map_Ks red.png\nmap_Bump red.png\nmap_Ka red.png");
    assert_eq!(
        notes,
        ["m.mtl: maps other than map_Kd are left out (2 times, first line 2: map_Ks)"]
    );
}

#[test]
fn what_mtl_does_not_have_is_passed_over_unless_strict() {
    let library = "newmtl a\nKa 1\nPr 0.5\naniso 0\nKd 1 0 0\n";
    let text = format!("mtllib m.mtl\n{FACE}");
    let files = [("m.obj", text.as_bytes()), ("m.mtl", library.as_bytes())];
    assert_eq!(load(&files, false).expect("it is read").1, [""; 0]);
    let error = load(&files, true).map(drop).expect_err("it is not standard");
    assert!(
        error.starts_with("m.mtl: line 3: Pr: a statement that MTL does not have, "),
        "{error}"
    );
}

/// A scene and a mesh read a file through the same code.
#[test]
fn scenes_and_meshes_have_the_same_triangles() {
    let concave = "v 0 -1 0\nv 2 0 0\nv 0 0.5 0\nv -2 0 0\nv 2 2 0\nv 0 0 0\nv -2 2 0\nf 2 3 4 1\nf 5 3 7 6\n\
                   l 1 2\nf 1 2\n";
    let folder = in_folder(&[("m.obj", concave.as_bytes())]);
    let path = folder.path().join("m.obj");
    let (scene, mesh) =
        (Scene::load(&path).expect("sound"), trisect_mesh::Mesh::load(&path).expect("sound"));
    assert_eq!(scene.meshes[0].triangles, *mesh.triangles);
    assert_eq!(scene.notes, mesh.notes);
    assert_eq!((mesh.triangles.len(), mesh.notes.len()), (4, 2));
}

#[test]
fn the_sandbox_holds_for_libraries_and_pictures() {
    let folder = in_folder(&[
        ("in/m.obj", b"mtllib ../m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("in/n.obj", b"mtllib n.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("in/n.mtl", b"newmtl a\nmap_Kd ../red.png\n"),
        ("m.mtl", b"newmtl a\n"),
        ("red.png", &red()),
    ]);
    for name in ["in/m.obj", "in/n.obj"] {
        let path = folder.path().join(name);
        let options = trisect_mesh::ReadOptions { sandbox: true, ..Default::default() };
        assert!(Scene::load(&path).is_ok());
        let error = Scene::load_with(&path, &options).expect_err("outside").to_string();
        assert!(error.contains("which --sandbox keeps to"), "{error}");
    }
}

/// Polygons that are convex stay the fans that pictures were made of.
#[test]
fn the_shipped_block_is_made_of_fans() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes/block.obj");
    let text = fs::read_to_string(&path).expect("it is there");
    let lines =
        |keyword: &'static str| text.lines().filter_map(move |line| line.strip_prefix(keyword));
    let numbers =
        |line: &str| line.split(' ').map(|x| x.parse().expect("a number")).collect::<Vec<f32>>();
    let vertices: Vec<[f32; 3]> =
        lines("v ").map(|line| numbers(line).try_into().expect("three")).collect();
    let mut fans = Vec::new();
    for face in lines("f ") {
        let place = |corner: &str| corner.split('/').next().and_then(|n| n.parse::<usize>().ok());
        let corners: Vec<_> =
            face.split(' ').map(|corner| vertices[place(corner).expect("a number") - 1]).collect();
        fans.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
    }
    let scene = Scene::load(&path).expect("it is sound");
    let found =
        scene.meshes[0].triangles.iter().map(|t| t.corners().map(trisect_core::Vec3::to_array));
    assert_eq!((fans.len(), found.collect::<Vec<_>>()), (12, fans));
}
