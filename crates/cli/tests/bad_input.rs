//! What cannot be used is refused: one line on standard error that names the place and the mend,
//! exit code 2, nothing on standard output, nothing written.

mod common;

use common::{CSV, Folder, OBJ};
use trisect_studies::record::SCHEMA;

/// A command that must be refused.
struct Case {
    /// Files beside `mesh.obj` and `rays.csv`, which are sound.
    files: Vec<(&'static str, Vec<u8>)>,
    arguments: &'static str,
    stdin: &'static str,
    /// The whole line, without `trisect: `; `…` stands for what a system or a version says.
    says: &'static str,
}

fn case(arguments: &'static str, says: &'static str) -> Case {
    Case { files: Vec::new(), arguments, stdin: "", says }
}

impl Case {
    fn file(mut self, name: &'static str, content: impl Into<Vec<u8>>) -> Self {
        self.files.push((name, content.into()));
        self
    }

    fn stdin(mut self, stdin: &'static str) -> Self {
        self.stdin = stdin;
        self
    }
}

/// Whether `text` is `pattern`, in which each `…` stands for anything.
fn matches(text: &str, pattern: &str) -> bool {
    match pattern.split_once('…') {
        None => text == pattern,
        Some((head, rest)) => text.strip_prefix(head).is_some_and(|text| {
            text.char_indices().any(|(i, _)| matches(&text[i..], rest)) || matches("", rest)
        }),
    }
}

fn refused(cases: Vec<Case>) {
    for Case { files, arguments, stdin, says } in cases {
        let folder = Folder::new();
        for (name, content) in &files {
            folder.write(name, content);
        }
        let before = folder.listing();
        let run = folder.trisect(arguments, stdin.as_bytes());
        let place = format!("trisect {arguments}\n{}", run.stderr);
        assert_eq!(run.code, Some(2), "{place}");
        assert_eq!(run.stdout, "", "{place}");
        let line = run.stderr.strip_suffix('\n').and_then(|line| line.strip_prefix("trisect: "));
        let line = line.unwrap_or_else(|| panic!("not one line of trisect's: {place}"));
        assert!(!line.contains('\n'), "more than a line: {place}");
        assert!(matches(line, says), "{place}instead of\ntrisect: {says}");
        assert_eq!(folder.listing(), before, "{place}");
    }
}

/// `trisect query` with a mesh of that name.
macro_rules! query {
    ($mesh:literal) => {
        query!($mesh, "rays.csv")
    };
    ($mesh:literal, $rays:literal) => {
        concat!("query --mesh ", $mesh, " --rays ", $rays, " --method wald")
    };
}

#[test]
fn meshes() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_index\n\
               end_header\n0 0 0\n1 0 0\n0 1 0\n";
    let mut stl = vec![0; 80];
    stl.extend(2_u32.to_le_bytes());
    stl.extend([0; 50]);
    refused(vec![
        case(query!("none.obj"), "none.obj: cannot be read (…); check the path"),
        case(
            "query --mesh a\u{1b}b.obj --rays rays.csv --method wald",
            "a\\u{1b}b.obj: cannot be read (…); check the path",
        ),
        case(query!("."), ".: unknown file type; known are .ply, .obj, .stl, .gltf and .glb"),
        case(
            query!("mesh.fbx"),
            "mesh.fbx: unknown file type; known are .ply, .obj, .stl, .gltf and .glb",
        )
        .file("mesh.fbx", OBJ),
        case(query!("m.obj"), "m.obj: the mesh has no triangles; export it with its faces")
            .file("m.obj", v),
        case(query!("m.obj"), "m.obj: the mesh has no triangles; export it with its faces")
            .file("m.obj", ""),
        case(query!("m.ply"), "m.ply: truncated: the header has no `end_header`; copy or export the file again").file("m.ply", ""),
        case(
            query!("m.obj"),
            "m.obj: face 0 (line 4): index 4 is out of range, the mesh has 3 vertices; re-export \
             the mesh",
        )
        .file("m.obj", format!("{v}f 1 2 4\n")),
        case(
            query!("m.obj"),
            "m.obj: face 0 (line 4): vertex 1 (line 2): y is NaN; every coordinate must be a finite f32",
        )
        .file("m.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n"),
        case(
            query!("m.obj"),
            "m.obj: face 0 (line 4): vertex 2 (line 3): z is 1e39; every coordinate must be a finite f32",
        )
        .file("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1e39\nf 1 2 3\n"),
        case(query!("m.ply"), "m.ply: truncated: …; copy or export the file again")
            .file("m.ply", ply),
        case(query!("m.stl"), "m.stl: truncated: …; copy or export the file again")
            .file("m.stl", stl),
        case(query!("m.gltf"), "m.gltf: truncated: …; copy or export the file again").file("m.gltf", "{"),
        case(query!("m.glb"), "m.glb: truncated: the header promises 12 bytes, the file has 4; copy or export the file again").file("m.glb", "glTF"),
        // Every verb that takes a mesh reads it before it does anything.
        case(
            "--mesh m.obj --rounds 1",
            "m.obj: the mesh has no triangles; export it with its faces",
        )
        .file("m.obj", v),
        case(
            "measure --mesh m.obj --output new/record.jsonl",
            "m.obj: the mesh has no triangles; export it with its faces",
        )
        .file("m.obj", v),
        case("verify --mesh m.obj", "m.obj: the mesh has no triangles; export it with its faces")
            .file("m.obj", v),
        case(
            "measure --mesh mesh.obj --mesh folder/mesh.obj --output record.jsonl",
            "folder/mesh.obj: a mesh named `mesh` is given already; rename one of the files",
        )
        .file("folder/mesh.obj", OBJ),
    ]);
}

#[test]
fn rays() {
    let header = "line 1: the header is `…`; write `ox,oy,oz,dx,dy,dz`, and `tmin`, `tmax` after \
                  it where they are wanted";
    let leak = |text: String| -> &'static str { text.leak() };
    let csv = |content: &str, says: &str| {
        case(query!("mesh.obj", "r.csv"), leak(format!("r.csv: {says}")))
            .file("r.csv", content.as_bytes())
    };
    let line = |line: &str, says: &str| csv(&format!("ox,oy,oz,dx,dy,dz\n{line}\n"), says);
    refused(vec![
        case(query!("mesh.obj", "none.csv"), "none.csv: cannot be read (…); check the path"),
        case(query!("mesh.obj", "r.txt"), "r.txt: unknown file type; known are .csv and .rays")
            .file("r.txt", CSV),
        csv("", header),
        csv("0,0,0,0,0,1\n", header),
        csv("ox,oy,oz,dx,dy\n0,0,0,0,0\n", header),
        csv(
            "\"ox\noy\",oz\n",
            "line 1: the header is `ox\\noy,oz`; write `ox,oy,oz,dx,dy,dz`, and `tmin`, `tmax` \
             after it where they are wanted",
        ),
        csv("ox,oy,oz,dx,dy,dz,time\n0,0,0,0,0,1,0\n", header),
        csv("ox,oy,oz,dx,dz,dy\n0,0,0,0,0,1\n", header),
        line("0,0,0,0,0", "line 2: 5 fields, the header names 6; write one for each column"),
        line("0,0,0,0,0,1,2", "line 2: 7 fields, the header names 6; write one for each column"),
        line("0,0,0,0,0,one", "line 2, dz: `one` is not a number; write a finite decimal number"),
        line("0,nan,0,0,0,1", "line 2, oy: `nan` is not a number; write a finite decimal number"),
        line(
            "0,0,0,inf,0,1",
            "line 2, dx: `inf` is not finite in f32; write a finite decimal number",
        ),
        line(
            "0,0,0,1e39,0,1",
            "line 2, dx: `1e39` is not finite in f32; write a finite decimal number",
        ),
        line(
            "0,0,0,0,0,1\n0,0,,0,0,1",
            "line 3, oz: `` is not a number; write a finite decimal number",
        ),
        csv(
            "ox,oy,oz,dx,dy,dz,tmin,tmax\n0,0,0,0,0,1,0,nan\n",
            "line 2, tmax: `nan` is not a number; write a decimal number or `inf`",
        ),
        case(
            query!("mesh.obj", "-"),
            "standard input: line 2, ox: `x` is not a number; write a finite decimal number",
        )
        .stdin("ox,oy,oz,dx,dy,dz\nx,0,0,0,0,1\n"),
        case(
            query!("mesh.obj", "r.csv"),
            "r.csv: line 2, ox: `ÿ` is not a number; write a finite decimal number",
        )
        .file("r.csv", b"ox,oy,oz,dx,dy,dz\n\xff,0,0,0,0,1\n"),
        case(
            query!("mesh.obj", "r.rays"),
            "r.rays: 2 rays need 68 bytes, the file has 36; copy or write the file again",
        )
        .file("r.rays", [vec![2, 0, 0, 0], vec![0; 32]].concat()),
        case(
            query!("mesh.obj", "r.rays"),
            "r.rays: 0 rays need 4 bytes, the file has 0; copy or write the file again",
        )
        .file("r.rays", ""),
        case(
            query!("mesh.obj", "r.rays"),
            "r.rays: ray 0, oz: NaN is not a number; write a finite decimal number",
        )
        .file(
            "r.rays",
            [1.0, 1.0, f32::NAN, 0.0, 0.0, 0.0, 1.0, 9.0]
                .iter()
                .fold(vec![1, 0, 0, 0], |bytes, x| [bytes, x.to_le_bytes().to_vec()].concat()),
        ),
        case("verify --mesh mesh.obj --rays r.csv", "r.csv: no rays; give at least one")
            .file("r.csv", "ox,oy,oz,dx,dy,dz\n"),
    ]);
}

#[test]
fn points() {
    let contains = "query --mesh mesh.obj --contains p.csv --method exact";
    let csv = |content: &str, says| case(contains, says).file("p.csv", content.as_bytes());
    refused(vec![
        case(contains, "p.csv: cannot be read (…); check the path"),
        csv("x,y\n", "p.csv: line 1: the header is `x,y`; write `x,y,z`"),
        csv(
            "x,y,z\n0,0\n",
            "p.csv: line 2: 2 fields, the header names 3; write one for each column",
        ),
        csv(
            "x,y,z\n0,0,inf\n",
            "p.csv: line 2, z: `inf` is not finite in f32; write a finite decimal number",
        ),
    ]);
}

#[test]
fn more_than_the_nearest_hit() {
    refused(vec![
        case(
            "query --mesh mesh.obj --rays rays.csv --method wald --all --precision f64",
            "wald has no tree in f64, and --all takes one; use --method exact or moller-trumbore or \
             watertight, or leave --precision out",
        ),
        case(
            "query --mesh mesh.obj --rays rays.csv --method wald --count --brute-force",
            "--count is answered by a tree; leave --brute-force out",
        ),
        case(
            "query --mesh mesh.obj --rays rays.csv --method wald --all --division early",
            "--all divides as the tree does; leave --division out",
        ),
        case(
            "query --mesh mesh.obj --rays rays.csv --method oracle --all",
            "--all is not answered by the oracle; use --method exact, which decides alike",
        ),
        case(
            "query --mesh mesh.obj --rays rays.csv --method wald --all --owned",
            "wald rounds, and --owned takes exact decisions; use --method exact",
        ),
        case(
            "query --mesh mesh.obj --contains rays.csv --method wald",
            "wald rounds, and --contains takes exact decisions; use --method exact",
        ),
        case(
            "query --mesh mesh.obj --rays rays.csv --method exact --owned",
            "--owned says which hits count; use it with --all or --count",
        ),
    ]);
}

#[test]
fn arguments() {
    refused(vec![
        case(
            "query --mesh mesh.obj --rays rays.csv --method embree",
            "unknown method `embree`; `trisect list` shows what there is",
        ),
        case(
            "query --mesh mesh.obj --rays rays.csv --method havel-herout --division early",
            "havel-herout has no early division; leave --division out or use deferred",
        ),
        case(
            "--methods wald,embree",
            "unknown method `embree`; `trisect list` shows what there is",
        ),
        case(
            "measure --methods wald,wald --output new/record.jsonl",
            "method `wald` is named twice; name each once with --methods",
        ),
        case(
            "query --mesh mesh.obj --rays rays.csv --method wald --precision f64 --width 16",
            "f64 has no width 16; use --width native or one of 1…",
        ),
        case(
            "query --mesh mesh.obj --rays rays.csv --method wald --width 2",
            "f32 has no width 2; use --width native or one of 1…",
        ),
        case(
            "--output rays.csv/page",
            "rays.csv/page: cannot write to this folder (…); name another with --output",
        ),
        case(
            "measure --output rays.csv/record.jsonl",
            "rays.csv: cannot write to this folder (…); name another with --output",
        ),
        case(
            "trace --mesh mesh.obj --rays rays.csv --method embree",
            "unknown method `embree`; `trisect list` shows what there is",
        ),
        case(
            "trace --mesh mesh.obj --rays rays.csv --out folder",
            "folder: is a folder; name a file with --out",
        )
        .file("folder/something", ""),
        case(
            "trace --mesh mesh.obj --rays rays.csv --out rays.csv/hits",
            "rays.csv: cannot write to this folder (…); name another with --out",
        ),
        case(
            "stress --quick --methods embree",
            "unknown method `embree`; `trisect list` shows what there is",
        ),
        case(
            "stress --quick --methods wald --output rays.csv",
            "rays.csv: cannot write to this folder (…); name another with --output",
        ),
        case(
            "study --quick --methods embree",
            "unknown method `embree`; `trisect list` shows what there is",
        ),
        case("study --quick --methods wald --mesh nowhere.ply", "nowhere.ply: …"),
        case(
            "study --quick --methods wald --output rays.csv",
            "rays.csv: cannot write to this folder (…); name another with --output",
        ),
        case(
            "pictures --quick --methods embree",
            "unknown method `embree`; `trisect list` shows what there is",
        ),
        case(
            "pictures --quick --methods wald --output rays.csv",
            "rays.csv: cannot write to this folder (…); name another with --output",
        ),
        case("measure --output folder", "folder: is a folder; name a file with --output")
            .file("folder/something", ""),
    ]);
}

#[test]
fn kernels_that_cannot_be_written() {
    refused(vec![
        case(
            "emit --method chirkov --language c --division early",
            "chirkov has no early division: leave out --division, or ask for deferred",
        ),
        case(
            "emit --method wald --language c --needs normal",
            "wald does not give normal: ask for one of occlusion, t, barycentrics, point",
        ),
        case(
            "emit --method exact --language wgsl --needs t",
            "exact decides by a formula, but its values are computed beyond it: ask for occlusion, and for values \
             use the library",
        ),
        case(
            "emit --method wald --language wgsl --precision f64",
            "wgsl has no f64 that is sure to be there: ask for f32",
        ),
        case(
            "emit --method wald --language c --prefix my-wald",
            "--prefix my-wald: no name in every language: use letters, digits and single underscores, a letter first",
        ),
    ]);
}

#[test]
fn nothing_to_recommend() {
    refused(vec![
        case("explain none.toml", "none.toml: cannot be read (…); check the path"),
        case("recommend --mesh none.obj", "none.obj: cannot be read (…); check the path"),
        case("recommend --mesh mesh.obj --rays r.csv", "r.csv: no rays; give at least one")
            .file("r.csv", "ox,oy,oz,dx,dy,dz\n"),
    ]);
}

#[test]
fn clap_refuses_what_it_does_not_know() {
    let query = "query --mesh mesh.obj --rays rays.csv";
    let cases = [
        (format!("{query} --method wald --precision f16"), "'--precision <PRECISION>'"),
        (format!("{query} --method wald --width 3"), "'--width <WIDTH>'"),
        (format!("{query} --method wald --division late"), "'--division <DIVISION>'"),
        (format!("{query} --method wald --cull both"), "'--cull <CULL>'"),
        (query.to_owned(), "--method <NAME>"),
        ("measure --rounds 0".to_owned(), "'--rounds <N>'"),
        ("measure --seed -1".to_owned(), "'-1'"),
        ("trace --mesh mesh.obj --rays rays.csv --threads 0".to_owned(), "'--threads <N>'"),
        ("recommend --mesh mesh.obj --rounds 0".to_owned(), "'--rounds <N>'"),
        (
            "trace --mesh mesh.obj --rays rays.csv --builder best".to_owned(),
            "[possible values: linear, binned, spatial]",
        ),
        ("trace --mesh mesh.obj --rays rays.csv --repeat 0".to_owned(), "'--repeat <N>'"),
        ("stress --fuzz 1.5".to_owned(), "not a whole number from 0 to 1e15"),
        ("stress --fuzz many".to_owned(), "not a number; give a count, as 1e9"),
        ("stress --fuzz -1".to_owned(), "'-1'"),
        ("study --threads 0".to_owned(), "'--threads <N>'"),
        ("pictures --threads 0".to_owned(), "'--threads <N>'"),
        ("pictures --shrink 0".to_owned(), "'--shrink <N>'"),
        ("verify --rays rays.csv".to_owned(), "--mesh <FILE>"),
        ("rank record.jsonl --needs everything".to_owned(), "'--needs <NEEDS>'"),
        ("--rounds 1 list".to_owned(), "list"),
        ("intersect".to_owned(), "'intersect'"),
    ];
    let folder = Folder::new();
    let before = folder.listing();
    for (arguments, names) in cases {
        let run = folder.trisect(&arguments, b"");
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{arguments}");
        assert!(run.stderr.starts_with("error: "), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(names), "{arguments}: {}", run.stderr);
        assert_eq!(folder.listing(), before, "{arguments}");
    }
}

#[test]
fn a_width_whose_instructions_the_processor_lacks() {
    let folder = Folder::new();
    for (precision, width) in [("f32", 16), ("f64", 8), ("f32", 8), ("f64", 4)] {
        let run = folder.trisect(
            &format!(
                "query --mesh mesh.obj --rays rays.csv --method wald --precision {precision} \
                 --width {width}"
            ),
            b"",
        );
        let widths = folder.trisect("list", b"").stdout;
        let widths = widths
            .lines()
            .find_map(|line| line.strip_prefix(&format!("{precision} widths")))
            .expect("`list` shows the widths");
        if widths.split_whitespace().any(|here| here == width.to_string()) {
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            assert_eq!(run.stdout.lines().count(), 2);
        } else {
            assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""));
            let says = if cfg!(any(target_arch = "x86", target_arch = "x86_64")) {
                format!(
                    "trisect: {precision} width {width} stands for …, which this processor lacks; \
                     use --width native or one of 1…\n"
                )
            } else {
                format!("trisect: {precision} has no width {width}; use --width native or …\n")
            };
            assert!(matches(&run.stderr, &says), "{}", run.stderr);
        }
    }
}

#[test]
fn records() {
    let sound = Folder::new().trisect("verify --mesh mesh.obj --methods wald --json", b"");
    assert_eq!(sound.code, Some(0), "{}", sound.stderr);
    let sound = sound.stdout;
    let (header, rest) = sound.split_once('\n').expect("a record has lines");
    let schema = |version: u32| format!("\"schema\":{version}");
    let other = sound.replacen(&schema(SCHEMA), &schema(SCHEMA + 1), 1);
    assert_ne!(other, sound, "the header names its schema");
    let cut = &sound[..header.len() + 30];
    let damaged = [
        ("", "the record is empty; make one with `trisect measure --output FILE`"),
        (
            "# notes\n",
            "line 1 is not a record header; make a record with `trisect measure --output FILE`",
        ),
        (rest, "line 1 is not a record header; make a record with `trisect measure --output FILE`"),
        (
            other.as_str(),
            "line 1: the record has schema 10, this trisect reads schema 9; measure again with \
             this version",
        ),
        (cut, "line 2: …; the file is damaged, measure again"),
        ("{\"kind\":\"header\",\"schema\":1}\n", "line 1: …; the file is damaged, measure again"),
    ];
    let verbs = [
        "rank r.jsonl",
        "cmp r.jsonl sound.jsonl",
        "cmp sound.jsonl r.jsonl",
        "report r.jsonl --output page",
    ];
    for verb in verbs {
        let cases = damaged.iter().map(|(content, says)| {
            case(verb, format!("r.jsonl: {says}").leak())
                .file("r.jsonl", content.as_bytes())
                .file("sound.jsonl", sound.as_bytes())
        });
        refused(cases.collect());
    }
    refused(vec![
        case("rank r.jsonl", "r.jsonl: cannot be read as a record: …")
            .file("r.jsonl", b"\xff\xfe\n"),
        case("rank none.jsonl", "none.jsonl: cannot be read (…); check the path"),
        case("report none.jsonl", "none.jsonl: cannot be read (…); check the path"),
        case("cmp none.jsonl none.jsonl", "none.jsonl: cannot be read (…); check the path"),
        case(
            "rank r.jsonl",
            "r.jsonl: nothing in this record is timed; make one with `trisect measure --output \
             FILE`",
        )
        .file("r.jsonl", sound.as_bytes()),
        case(
            "report r.jsonl --output rays.csv/page",
            "rays.csv/page: cannot write to this folder (…); name another with --output",
        )
        .file("r.jsonl", sound.as_bytes()),
    ]);
}

#[test]
fn degenerate_triangles_are_counted_and_never_hit() {
    let folder = Folder::new();
    folder.write("m.obj", format!("{OBJ}f 1 1 2\nf 2 2 2\n").as_bytes());
    let run = folder.trisect(query!("m.obj"), b"");
    assert_eq!(run.code, Some(0));
    assert_eq!(run.stderr, "m.obj: 2 of 4 triangles are degenerate and never hit\n");
    assert_eq!(run.stdout, folder.trisect(query!("mesh.obj"), b"").stdout);
}
