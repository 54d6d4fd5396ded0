//! `rivals` from end to end: everybody answers the same rays, and bad input is refused.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;
use trisect_core::Ray;
use trisect_workloads::write_rays_binary;

/// Two triangles at right angles.
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";

/// The contenders that need nothing to be installed.
const CONTENDERS: [&str; 14] = [
    "moller-trumbore",
    "moller-trumbore packets",
    "moller-trumbore calls",
    "moller-trumbore binned",
    "moller-trumbore linear",
    "watertight",
    "watertight packets",
    "watertight calls",
    "watertight binned",
    "watertight linear",
    "obvhs bvh2",
    "obvhs cwbvh",
    "parry3d",
    "bvh",
];
/// How many of them are ours: the first ones.
const OURS: usize = 10;

/// Asks for them alone, as Embree may not be there.
fn all() -> String {
    CONTENDERS.join(",")
}

/// A folder with `mesh.obj`, and `rays.rays`: a hit of either triangle and a miss.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("the system has a folder for temporaries");
    let rays = [
        Ray::<f32>::new([0.25, 0.5, -3.0], [0.0, 0.0, 1.0]),
        Ray::<f32>::new([0.25, 3.0, 0.5], [0.0, -1.0, 0.0]),
        Ray::<f32>::new([5.0, 5.0, -3.0], [0.0, 0.0, 1.0]),
    ];
    let mut binary = Vec::new();
    write_rays_binary(&mut binary, &rays).expect("into memory");
    for (name, content) in [("mesh.obj", OBJ.as_bytes()), ("rays.rays", &binary[..])] {
        fs::write(folder.path().join(name), content).expect("a temporary folder can be written");
    }
    folder
}

fn rivals(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rivals"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program runs")
}

/// What it prints as JSON, and nothing else anywhere.
fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = rivals(folder, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), &*stderr), (Some(0), ""), "{arguments:?}");
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn names(of: &Value) -> Vec<&str> {
    list(of).iter().map(|one| one["name"].as_str().expect("a name")).collect()
}

/// Nobody's times are asserted, but that there are some.
fn check_times(race: &Value, repeat: usize) {
    for contender in list(&race["contenders"]) {
        let samples = list(&contender["samples_ns"]);
        assert_eq!(samples.len(), repeat);
        assert!(samples.iter().all(|ns| ns.as_u64() > Some(0)), "{contender}");
        assert_eq!(list(&contender["times"]).len(), list(&race["contenders"]).len());
    }
}

#[test]
fn everybody_hits_what_the_oracle_hits_on_the_teapot() {
    let teapot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/meshes/teapot.ply");
    let teapot = teapot.to_str().expect("a path of this workspace");
    let small = ["--pixels", "32", "--repeat", "2", "--threads", "2", "--json"];
    let report =
        json(Path::new("."), &[&["--mesh", teapot, "--only", &all()][..], &small].concat());
    let built = &report["builds"][0];
    assert_eq!((&report["threads"], &report["repeat"]), (&2.into(), &2.into()));
    // Packets and calls share the tree of single rays.
    let shares = |name: &&str| name.ends_with("packets") || name.ends_with("calls");
    let trees = CONTENDERS.into_iter().filter(|name| !shares(name));
    assert_eq!(names(&built["trees"]), trees.collect::<Vec<_>>());
    for tree in list(&built["trees"]) {
        assert!(tree["samples_ns"][0].as_u64() > Some(0), "{tree}");
        assert!(tree["bytes"].is_null() || tree["bytes"].as_u64() > Some(0), "{tree}");
    }
    let races = list(&report["races"]);
    assert_eq!(names(&report["races"]), ["primary", "random", "diffuse", "occlusion"]);
    for race in races {
        check_times(race, 2);
        assert_eq!(names(&race["contenders"]), CONTENDERS);
        assert_eq!(race["any"], race["name"] == "occlusion");
        let settled = race["settled"].as_u64().expect("a count");
        let sampled = race["sampled"].as_u64().expect("a count");
        assert!(sampled > 0 && settled == race["differing"], "{race}");
        let contenders = list(&race["contenders"]);
        for contender in &contenders[..OURS] {
            let verdict = &contender["verdict"];
            let count = |word: &str| verdict[word].as_u64().expect("a count");
            for word in ["missed", "invented", "farther", "elsewhere"] {
                assert_eq!(count(word), 0, "{word}, {}: {contender}", race["name"]);
            }
            assert_eq!(count("right") + count("close") + count("beside"), settled + sampled);
            let error = verdict["largest_error_of_t"].as_f64().expect("a number");
            assert!(error < 1e-3, "{contender}");
        }
        let hits = |place: usize| contenders[place]["hits"].as_u64().expect("a count");
        assert!(hits(0) > 0);
        // Single rays, packets and calls are asked the same of the same tree.
        for ours in [0, 5] {
            assert_eq!((hits(ours), hits(ours)), (hits(ours + 1), hits(ours + 2)));
        }
        // Others may lose rays between triangles, but not many.
        let rays = race["rays"].as_u64().expect("a count");
        for place in OURS..contenders.len() {
            assert!(hits(0).abs_diff(hits(place)) <= rays / 100, "{race}");
        }
    }
}

#[test]
fn rays_of_a_file_are_traced_by_all() {
    let folder = folder();
    let all = all();
    let arguments = ["--mesh", "mesh.obj", "--rays", "rays.rays", "--repeat", "1", "--json"];
    for any in [false, true] {
        let mut arguments = [&arguments[..], &["--only", &all]].concat();
        arguments.extend(any.then_some("--any"));
        let report = json(folder.path(), &arguments);
        let race = &report["races"][0];
        assert_eq!((&race["mesh"], &race["name"]), (&"mesh".into(), &"rays".into()));
        assert_eq!((&race["rays"], &race["any"]), (&3.into(), &any.into()));
        assert_eq!((&race["differing"], &race["sampled"]), (&0.into(), &3.into()));
        assert_eq!(names(&race["contenders"]), CONTENDERS);
        check_times(race, 1);
        for contender in list(&race["contenders"]) {
            assert_eq!(contender["hits"], 2, "{contender}");
            assert_eq!(contender["verdict"]["right"], 3, "{contender}");
            let sum_of_t = contender["sum_t"].as_f64().expect("a number");
            let expected = if any { 0.0 } else { 3.0 + 3.0 };
            assert!((sum_of_t - expected).abs() < 1e-5, "{contender}");
        }
    }
}

#[test]
fn only_those_named_take_part() {
    let folder = folder();
    let rays = ["--mesh", "mesh.obj", "--rays", "rays.rays", "--repeat", "1", "--builds", "3"];
    let some = ["--json", "--methods", "wald", "--only", "parry3d,wald packets"];
    let report = json(folder.path(), &[&rays[..], &some].concat());
    assert_eq!(names(&report["races"][0]["contenders"]), ["wald packets", "parry3d"]);
    let trees = &report["builds"][0]["trees"];
    assert_eq!(names(trees), ["wald", "parry3d"]);
    assert_eq!(list(&trees[0]["samples_ns"]).len(), 3);
}

#[test]
fn tables_fit_a_terminal() {
    let folder = folder();
    let rays = ["--mesh", "mesh.obj", "--rays", "rays.rays", "--repeat", "1"];
    let output = rivals(folder.path(), &[&rays[..], &["--only", &all()]].concat());
    let table = String::from_utf8(output.stdout).expect("text");
    for name in CONTENDERS {
        assert!(table.lines().any(|line| line.starts_with(name)), "{name} is not in\n{table}");
    }
    // The first line is as long as a processor's name.
    assert!(table.lines().skip(1).all(|line| line.chars().count() <= 80), "{table}");
}

#[test]
fn odd_meshes_are_raced_over() {
    let folder = folder();
    // In a debug build obvhs finds the last of its trees too deep.
    let all = all().replace("obvhs cwbvh,", "");
    let one = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let degenerate = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
    let copies = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 3\n".repeat(1000));
    for (name, mesh, hits) in [("one", one, 1), ("line", degenerate, 0), ("copies", &copies, 1)] {
        let file = format!("{name}.obj");
        fs::write(folder.path().join(&file), mesh).expect("a temporary folder can be written");
        let rays = ["--mesh", &file, "--rays", "rays.rays", "--repeat", "1", "--json"];
        let report = json(folder.path(), &[&rays[..], &["--only", &all]].concat());
        for contender in list(&report["races"][0]["contenders"]) {
            assert_eq!(contender["hits"], hits, "{name}: {contender}");
            let verdict = &contender["verdict"];
            assert_eq!(verdict["right"], 3, "{name}: {contender}");
        }
    }
    let mesh = ["--mesh", "copies.obj", "--rays", "rays.rays", "--repeat", "1"];
    let output = rivals(folder.path(), &[&mesh[..], &["--only", "obvhs cwbvh"]].concat());
    if !output.status.success() {
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), stderr.lines().count()), (Some(2), 1), "{stderr}");
        assert!(stderr.starts_with("rivals: obvhs cwbvh panics over this mesh ("), "{stderr}");
    }
}

#[test]
fn bad_input_is_refused_in_a_line() {
    let folder = folder();
    let write = |name: &str, content: &[u8]| {
        fs::write(folder.path().join(name), content).expect("a temporary folder can be written");
    };
    write("empty.obj", b"");
    write("none.rays", &[0; 4]);
    write("short.rays", &[1, 0, 0, 0, 5]);
    let no_embree = ["--only", "bvh"];
    for (arguments, says) in [
        ("--mesh gone.obj --rays rays.rays", "gone.obj: cannot be read"),
        ("--mesh empty.obj --rays rays.rays", "empty.obj: "),
        ("--mesh rays.rays --rays rays.rays", "rays.rays: unknown file type"),
        ("--mesh mesh.obj --rays gone.rays", "gone.rays: "),
        ("--mesh mesh.obj --rays none.rays", "none.rays: no rays"),
        ("--mesh mesh.obj --rays short.rays", "short.rays: "),
        ("--mesh mesh.obj --mesh ./mesh.obj", "a mesh named `mesh` is given already"),
        ("--mesh mesh.obj --methods havel", "unknown method `havel`"),
        ("--mesh mesh.obj --methods wald,wald", "method `wald` is named twice"),
        ("--mesh mesh.obj --only bvh,optix", "--only: no contender `optix`; there are moller-"),
    ] {
        let mut all: Vec<&str> = arguments.split(' ').collect();
        if !arguments.contains("--only") {
            all.extend(no_embree);
        }
        let output = rivals(folder.path(), &all);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), &output.stdout[..]), (Some(2), &b""[..]), "{stderr}");
        assert!(stderr.starts_with("rivals: ") && stderr.contains(says), "{arguments}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
    }
}

#[test]
fn clap_refuses_what_it_does_not_know() {
    for (arguments, says) in [
        ("--rays rays.rays", "--mesh <FILE>"),
        ("--mesh mesh.obj --any", "--rays <FILE>"),
        ("--mesh mesh.obj --classes glossy", "primary, random, diffuse, occlusion"),
        ("--mesh mesh.obj --rays rays.rays --classes random", "cannot be used with"),
        ("--mesh mesh.obj --rays rays.rays --pixels 8", "cannot be used with"),
        ("--mesh mesh.obj --repeat 0", "'--repeat <N>'"),
        ("--mesh mesh.obj --threads 0", "'--threads <N>'"),
        ("--mesh mesh.obj --pixels 0", "'--pixels <PIXELS>'"),
    ] {
        let folder = folder();
        let output = rivals(folder.path(), &arguments.split(' ').collect::<Vec<_>>());
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), &output.stdout[..]), (Some(2), &b""[..]), "{stderr}");
        assert!(stderr.contains(says), "{arguments}: {stderr}");
    }
}
