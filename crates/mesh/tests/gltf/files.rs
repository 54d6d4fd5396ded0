//! What documents come in, and what departs from the specification without doubt.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use trisect_mesh::{Mesh, MeshFormat, ReadOptions};

use crate::document::{Document, O, STRICT, X, Y, corners, positions};

#[test]
fn compressed_meshes_are_read_where_the_plain_data_are_there() {
    let mut document = Document::new(&[]);
    document.more +=
        r#", "extensionsUsed": ["KHR_draco_mesh_compression", "EXT_meshopt_compression"]"#;
    let draco =
        r#", "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}}"#;
    document.primitive += draco;
    assert_eq!(document.gives(&[[O, X, Y]]).notes.len(), 1);
    document.accessors = positions(r#""componentType": 5126"#);
    document.is_refused(
        "mesh 0 primitive 0: KHR_draco_mesh_compression without uncompressed data is not supported; \
         export it without compression",
    );
    let mut document = Document::new(&[]);
    document.views[0].2 = r#", "extensions": {"EXT_meshopt_compression": {}}"#;
    document.gives(&[[O, X, Y]]);
    let text = document.text();
    let uri = &text[text.find(r#", "uri""#).expect("it is there")..];
    let uri = &uri[..uri.find('}').expect("it ends")];
    let text = text.replace(uri, "");
    let error = Mesh::from_bytes("m", MeshFormat::Gltf, text.as_bytes()).expect_err("no data");
    assert!(error.to_string().contains("EXT_meshopt_compression without"), "{error}");
    for name in ["EXT_meshopt_compression", "KHR_texture_basisu", "X_other"] {
        let mut document = Document::new(&[]);
        document.more = format!(r#"{}, "extensionsRequired": ["{name}", "X_more"]"#, document.more);
        document.is_refused(&format!("m: {name}, which the document requires, is not supported; "));
    }
}

#[test]
fn data_uris_are_read_in_all_their_forms() {
    let document = Document::new(&[]);
    let (text, data) = (document.text(), BASE64.encode(&document.bytes));
    let percent: Vec<String> = document.bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
    let percent = percent.concat();
    let padded = format!("{data}AAA");
    for uri in [
        format!("data:application/octet-stream;base64,{data}"),
        format!("DATA:text/plain;charset=utf-8;Base64,{data}"),
        format!("data:,{percent}"),
        format!("data:;base64,{}", data.replace('A', "%41")),
        format!("data:;base64,{}\\n{}", &data[..8], &data[8..]),
        format!("data:;base64,{padded}"),
    ] {
        let text = text.replace(&format!("data:;base64,{data}"), &uri);
        let mesh = Mesh::from_bytes("m", MeshFormat::Gltf, text.as_bytes());
        assert_eq!(corners(&mesh.unwrap_or_else(|error| panic!("{uri}: {error}"))), [[O, X, Y]]);
    }
}

#[test]
fn buffers_are_found_by_percent_encoded_and_other_paths_and_the_sandbox_holds() {
    let document = Document::new(&[]);
    let text = document.text();
    let uri = format!("data:;base64,{}", BASE64.encode(&document.bytes));
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("scene");
    std::fs::create_dir_all(scene.join("my data")).expect("it is made");
    std::fs::write(scene.join("my data/a b.bin"), &document.bytes).expect("it is written");
    std::fs::write(folder.path().join("outside.bin"), &document.bytes).expect("it is written");
    let path = scene.join("m.gltf");
    let write = |to: &str| std::fs::write(&path, text.replace(&uri, to)).expect("it is written");
    let sandbox = ReadOptions { sandbox: true, ..ReadOptions::default() };
    for (to, is_inside) in [
        ("my%20data/a%20b.bin", true),
        ("my data/a b.bin", true),
        (r"my data\\a b.bin", true),
        ("../outside.bin", false),
    ] {
        write(to);
        assert_eq!(corners(&Mesh::load(&path).unwrap_or_else(|e| panic!("{e}"))), [[O, X, Y]]);
        let kept = Mesh::load_with(&path, &sandbox);
        assert_eq!(kept.is_ok(), is_inside, "{to}");
        if let Err(error) = kept {
            assert!(error.to_string().contains("--sandbox keeps to"), "{error}");
        }
    }
    // A buffer that nothing needs may be missing.
    write(&format!("{uri}\"}}, {{\"byteLength\": 9, \"uri\": \"gone.bin"));
    assert_eq!(corners(&Mesh::load(&path).expect("sound")), [[O, X, Y]]);
}

/// The binary form of a document.
fn glb(json: &str, chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    let json = format!("{json:0$}", json.len().next_multiple_of(4));
    for (kind, data) in [(b"JSON", json.as_bytes())].iter().chain(chunks) {
        let length = data.len().next_multiple_of(4);
        body.extend(u32::try_from(length).expect("small").to_le_bytes());
        body.extend(*kind);
        body.extend(*data);
        body.resize(body.len().next_multiple_of(4), 0);
    }
    let length = u32::try_from(12 + body.len()).expect("small");
    [b"glTF".as_slice(), &2_u32.to_le_bytes(), &length.to_le_bytes(), &body].concat()
}

#[test]
fn binary_files_are_read_by_their_chunks() {
    let document = Document::new(&[]);
    let uri = format!(r#", "uri": "data:;base64,{}""#, BASE64.encode(&document.bytes));
    let json = document.text().replace(&uri, "");
    let load = |bytes: &[u8]| Mesh::from_bytes("m", MeshFormat::Gltf, bytes);
    let sound = glb(&json, &[(b"ABCD", b"unknown"), (b"BIN\0", &document.bytes)]);
    assert_eq!(corners(&load(&sound).expect("it is sound")), [[O, X, Y]]);
    let longer = [sound.as_slice(), b"more"].concat();
    assert_eq!(corners(&load(&longer).expect("what follows says nothing")), [[O, X, Y]]);
    let zeros = glb(&format!("{json}\0\0"), &[(b"BIN\0", &document.bytes)]);
    assert_eq!(corners(&load(&zeros).expect("zeros for spaces")), [[O, X, Y]]);
    let mut old = sound.clone();
    old[4] = 1;
    let message = load(&old).expect_err("of the first version").to_string();
    assert_eq!(message, "m: glTF 1.0 is not supported; convert it to glTF 2.0");
    let mut first = sound.clone();
    first[16..20].copy_from_slice(b"BIN\0");
    assert!(load(&first).is_err());
    let mut long = sound;
    long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    let message = load(&long).expect_err("beyond the file").to_string();
    assert!(
        message.starts_with("m: truncated: the chunk at byte 12 needs 4294967295"),
        "{message}"
    );
}

#[test]
fn what_departs_without_doubt_is_read_unless_strictly() {
    let document = Document::new(&[]);
    let text = document.text();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.gltf");
    for text in [
        format!("\u{feff}{text}"),
        text.replace(r#", "max": [1, 1, 0]"#, "")
            .replace("\n    \"min\": [0, 0, 0],", "\n")
            .replace(r#""min": [0, 0, 0], "max": [1, 1, 0]"#, r#""name": "no limits""#),
        text.replace(r#""asset": {"version": "2.0"}"#, r#""asset": {}"#),
        text.replace(r#"{"version": "2.0"}"#, r#"{"version": 2.0}"#),
    ] {
        std::fs::write(&path, &text).expect("it is written");
        let mesh = Mesh::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert!(corners(&mesh) == [[O, X, Y]] && mesh.notes.is_empty(), "{:?}", mesh.notes);
        let message = Mesh::load_with(&path, &STRICT).expect_err(&text).to_string();
        assert!(message.ends_with("leave out --strict"), "{message}");
    }
    for (version, expected) in [
        (r#"{"version": "2.7"}"#, None),
        (r#"{"version": "2.7", "minVersion": "2.1"}"#, Some("m: glTF 2.1 is not supported; ")),
        (r#"{"version": "3.0"}"#, Some("m: glTF 3.0 is not supported; ")),
        (r#"{"version": "1.1"}"#, Some("m: glTF 1.0 is not supported; ")),
        (r#"{"version": 1}"#, Some("m: glTF 1.0 is not supported; ")),
    ] {
        let text = text.replace(r#"{"version": "2.0"}"#, version);
        match (Mesh::from_bytes("m", MeshFormat::Gltf, text.as_bytes()), expected) {
            (Ok(mesh), None) => assert_eq!(corners(&mesh), [[O, X, Y]]),
            (Err(error), Some(expected)) => {
                assert!(error.to_string().starts_with(expected), "{error}");
            }
            (found, _) => panic!("{version}: {found:?}"),
        }
    }
}

#[test]
fn deep_nesting_is_passed_over_or_refused() {
    let deep = format!("{}{}", "[".repeat(1_000_000), "]".repeat(1_000_000));
    for (text, expected) in [
        (format!(r#"{{"extras": {deep}}}"#), "the mesh has no triangles"),
        (format!(r#"{{"extensions": {{"KHR_lights_punctual": {deep}}}}}"#), "recursion limit"),
        (format!(r#"{{"nodes": {deep}}}"#), "document: invalid type"),
    ] {
        let error = Mesh::from_bytes("m", MeshFormat::Gltf, text.as_bytes()).expect_err(expected);
        assert!(error.to_string().contains(expected), "{error}");
    }
    // Nodes may nest as deep as they will.
    let mut document = Document::new(&[]);
    let chain: Vec<String> = (1..50_000).map(|i| format!(r#"{{"children": [{i}]}}"#)).collect();
    document.nodes = format!(r#"{}, {{"mesh": 0}}"#, chain.join(","));
    document.gives(&[[O, X, Y]]);
}
