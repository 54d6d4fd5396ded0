//! What a user's files hold: coordinates of f64, rays from far away, limits on reading.

mod common;

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use common::Folder;
use serde_json::Value;

/// A triangle in the coordinates of a map (UTM: metres from a point hundreds of kilometres away), as
/// surveys hand them out, 0.4 m across; f32 has steps of 0.03 m there to the east and of 0.5 m to the north.
const MAP: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
                   property double z\nelement face 1\nproperty list uchar int vertex_indices\n\
                   end_header\n448250.05 5411940.05 120.05\n448250.45 5411940.05 120.05\n\
                   448250.05 5411940.45 120.05\n3 0 1 2\n";

/// From 10 m above, at a quarter of both edges.
const ABOVE: &str = "ox,oy,oz,dx,dy,dz\n448250.14999999997,5411940.149999999,130.05,0,0,-1\n";

const MOVED: &str = "map.ply: rounded to f32 its corners move by up to ";

fn map() -> Folder {
    let folder = Folder::new();
    folder.write("map.ply", MAP.as_bytes());
    folder.write("above.csv", ABOVE.as_bytes());
    folder
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn coordinates_of_f64_are_kept_where_f64_is_asked_for() {
    let folder = map();
    let query = "query --mesh map.ply --rays above.csv";
    for method in ["oracle", "exact", "moller-trumbore", "watertight", "wald-relative"] {
        let run = folder.trisect(&format!("{query} --method {method} --precision f64"), b"");
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{method}");
        let answer = json(&run.stdout);
        for (name, true_value) in [("t", 10.0), ("beta", 0.25), ("gamma", 0.25)] {
            let value = answer[name].as_f64().unwrap_or_else(|| panic!("{method}: {answer}"));
            assert!((value - true_value).abs() < 1e-8, "{method}: {name} {value}");
        }
    }
    let [oracle, exact] = ["oracle", "exact"].map(|method| {
        folder.trisect(&format!("{query} --method {method} --precision f64"), b"").stdout
    });
    assert_eq!(oracle, exact);
}

#[test]
fn rounding_that_moves_a_mesh_is_said_once() {
    let folder = map();
    let keeps = "--precision f64 keeps them where they are\n";
    let both = "kernels in f32 are judged by where they move to\n";
    let moves = "f32 is finest at the origin: move it there before it is written\n";
    for (arguments, mend) in [
        ("query --mesh map.ply --rays above.csv --method exact", keeps),
        ("query --mesh map.ply --rays above.csv --method oracle", keeps),
        ("trace --mesh map.ply --rays above.csv --repeat 1", moves),
        ("verify --mesh map.ply --rays above.csv --methods wald", both),
        ("recommend --mesh map.ply --rays above.csv --rounds 1", moves),
    ] {
        let run = folder.trisect(arguments, b"");
        assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
        let by = run.stderr.strip_prefix(MOVED).and_then(|rest| rest.split_once(" of its size; "));
        let Some((by, rest)) = by else { panic!("{arguments}: {}", run.stderr) };
        // By 0.05 m to the north, of a triangle that is 0.6 m across.
        assert!(by.parse().is_ok_and(|by: f64| (0.05..0.1).contains(&by)), "{arguments}: {by}");
        assert_eq!(rest, mend, "{arguments}");
        // The same at the origin needs no word.
        let near = arguments.replace("map.ply", "mesh.obj");
        assert_eq!(folder.trisect(&near, b"").stderr, "", "{near}");
    }
}

#[test]
fn each_precision_is_verified_by_the_numbers_that_it_gets() {
    let folder = map();
    let verify = "verify --mesh map.ply --rays above.csv --methods exact,moller-trumbore --json";
    let run = folder.trisect(verify, b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let lines: Vec<Value> = run.stdout.lines().map(json).collect();
    let decisions: Vec<&Value> = lines.iter().filter(|line| line["kind"] == "decisions").collect();
    assert!(decisions.iter().any(|line| line["precision"] == "f64"));
    for line in decisions.iter().filter(|line| line["method"] == "exact") {
        for class in line["classes"].as_array().expect("a list") {
            let wrong = if class["is_hit"] == true { "called_miss" } else { "called_hit" };
            assert_eq!(class[wrong], 0, "{line}");
        }
    }
    let errors = lines.iter().filter(|line| {
        line["kind"] == "error" && line["precision"] == "f64" && line["reference"] == "oracle"
    });
    let worst = errors.map(|line| {
        assert_eq!(line["count"], 1, "{line}");
        line["relative"]["max"].as_f64().expect("a number")
    });
    assert!(worst.fold(0.0, f64::max) < 1e-8);
}

/// A ball of radius 1, and rays from a hundred thousand radii away to all over it.
fn far() -> Folder {
    let (mut ball, mut rays) = (String::new(), "ox,oy,oz,dx,dy,dz\n".to_owned());
    let point =
        |across: f64, down: f64| [down.sin() * across.cos(), down.cos(), down.sin() * across.sin()];
    let (columns, rows) = (24, 12);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let at = |row, column| {
            point(
                f64::from(column) * TAU / f64::from(columns),
                f64::from(row) * PI / f64::from(rows),
            )
        };
        for [x, y, z] in
            [at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)]
        {
            // Writing to a string cannot fail.
            let _ = writeln!(ball, "v {x:.6} {y:.6} {z:.6}");
        }
        if row > 0 {
            ball += "f -4 -3 -2\n";
        }
        if row + 1 < rows {
            ball += "f -4 -2 -1\n";
        }
    }
    for number in 0..200 {
        let golden = f64::from(number) * 2.399_963;
        let [from, to] = [
            point(golden, (1.0 - f64::from(number) / 100.0).acos()),
            point(1.7 * golden, (1.0 - f64::from(number) / 100.0).acos()),
        ];
        let far = 1e5;
        let o = from.map(|x| x * far);
        let d: Vec<f64> = (0..3).map(|axis| to[axis] * 0.9 - o[axis]).map(|x| x / far).collect();
        let _ = writeln!(rays, "{:.4},{:.4},{:.4},{},{},{}", o[0], o[1], o[2], d[0], d[1], d[2]);
    }
    let folder = Folder::new();
    folder.write("ball.obj", ball.as_bytes());
    folder.write("far.csv", rays.as_bytes());
    folder
}

#[test]
fn who_decides_wrongly_is_not_called_never_wrong() {
    let run = far().trisect("recommend --mesh ball.obj --rays far.csv --rounds 2 --json", b"");
    // Its decimals are no f32.
    let said =
        run.stderr.strip_prefix("ball.obj: rounded to f32 ").map(|rest| rest.lines().count());
    assert_eq!((run.code, said), (Some(0), Some(1)), "{}", run.stderr);
    let found = json(&run.stdout);
    assert_eq!(found["answers"]["checked"][0], 200);
    for of in ["trees", "loops"] {
        // None where the machine is too busy.
        for answer in found["answers"][of].as_array().expect("a list") {
            let wrong = answer["wrong_per_million"].as_f64().expect("it was checked");
            match answer["method"].as_str() {
                Some("exact") => assert_eq!(wrong, 0.0, "{answer}"),
                Some("moller-trumbore") => assert!(wrong > 0.0, "{answer}"),
                _ => assert_ne!(answer["asked"], "never wrong"),
            }
        }
    }
    assert!(found["rust"].as_str().is_some_and(|rust| rust.contains(".exact()")));
}

/// Every verb that reads a user's mesh, scene or rays.
const READS: [&str; 9] = [
    "--mesh FILE",
    "measure --mesh FILE",
    "verify --mesh FILE",
    "study --mesh FILE",
    "trace --mesh FILE --rays rays.csv",
    "query --mesh FILE --rays rays.csv --method wald",
    "recommend --mesh FILE",
    "render FILE -o p.png",
    "explain FILE",
];

#[test]
fn every_verb_keeps_to_the_limits_on_reading() {
    let folder = Folder::new();
    let buffer = std::iter::repeat_n(0_u8, 36).collect::<Vec<u8>>();
    folder.write("buffer.bin", &buffer);
    let gltf = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"../buffer.bin","byteLength":36}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
            "min":[0,0,0],"max":[0,0,0]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#;
    folder.write("inside/outer.gltf", gltf.as_bytes());
    let before = folder.listing();
    for verb in READS {
        let refused = |file: &str, option: &str| {
            let command = format!("{} {option}", verb.replace("FILE", file));
            let run = folder.trisect(&command, b"");
            assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{command}: {}", run.stderr);
            assert_eq!(folder.listing(), before, "{command}");
            run.stderr
        };
        let memory = refused("mesh.obj", "--max-memory 20");
        let says =
            "trisect: mesh.obj: needs more than the 20 bytes that --max-memory allows; raise it\n";
        assert_eq!(memory, says, "{verb}");
        let sandbox = refused("inside/outer.gltf", "--sandbox");
        assert!(sandbox.contains("which --sandbox keeps to"), "{verb}: {sandbox}");
        assert_eq!(sandbox.lines().count(), 1, "{verb}: {sandbox}");
        assert!(refused("mesh.obj", "--max-memory much").contains("'--max-memory <SIZE>'"));
    }
    let many = format!("ox,oy,oz,dx,dy,dz\n{}", "0.25,0.5,-3,0,0,1\n".repeat(1000));
    folder.write("many.csv", many.as_bytes());
    for rays in ["many.csv", "-"] {
        // Room for the text, and not for what it becomes.
        let command = format!("query --mesh mesh.obj --rays {rays} --method wald --max-memory 32K");
        let run = folder.trisect(&command, many.as_bytes());
        assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{command}");
        let says = "needs more than the 32768 bytes that --max-memory allows; raise it\n";
        assert!(run.stderr.ends_with(says), "{}", run.stderr);
    }
}

/// A byte order mark before the first line, as editors and spreadsheets write it.
#[test]
fn a_byte_order_mark_is_no_part_of_the_first_line() {
    let folder = Folder::new();
    let marked = |name: &str, text: &str| folder.write(name, format!("\u{feff}{text}").as_bytes());
    // Without its first line the face would be another, 3.5 away from the ray's origin.
    marked("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 5\nf 1 2 3\n");
    marked("r.csv", "ox,oy,oz,dx,dy,dz\n0.25,0.25,-1,0,0,1\n");
    for method in ["oracle", "exact"] {
        let query = format!("query --mesh m.obj --rays r.csv --method {method}");
        let run = folder.trisect(&query, b"");
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{method}");
        let hit =
            "{\"ray\":0,\"hit\":true,\"triangle\":0,\"t\":1.0,\"beta\":0.25,\"gamma\":0.25}\n";
        assert_eq!(run.stdout, hit, "{method}");
    }
}

/// What a reader passes over is said once, with a count, and beside the answers; a strict one refuses it.
#[test]
fn what_is_passed_over_is_said_once() {
    let folder = Folder::new();
    // A face of two corners, twice: no triangle.
    folder.write("m.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\nf 2 3\n");
    let query = "query --mesh m.obj --rays rays.csv --method wald";
    let run = folder.trisect(query, b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    assert!(run.stderr.starts_with("m.obj: "), "{}", run.stderr);
    assert!(run.stderr.contains("2 times, first "), "{}", run.stderr);
    assert!(run.stdout.lines().all(|line| json(line)["ray"].is_u64()), "{}", run.stdout);
    let run = folder.trisect(&format!("{query} --strict"), b"");
    assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{}", run.stderr);
    assert!(run.stderr.contains("leave out --strict"), "{}", run.stderr);
}
