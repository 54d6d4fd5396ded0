//! From rays to answers, and from a measurement to a page.

mod common;

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _};

use common::{CSV, Folder};
use trisect_testkit::process;

const QUERY: &str = "query --mesh mesh.obj --method moller-trumbore --rays";

#[test]
fn csv_binary_and_standard_input_give_the_same_answers() {
    let folder = Folder::new();
    let rays = trisect_workloads::read_rays_csv("rays", CSV.as_bytes()).expect("sound");
    let mut binary = Vec::new();
    trisect_workloads::write_rays_binary(&mut binary, &rays.rays_f32).expect("into memory");
    folder.write("rays.rays", &binary);
    let from_csv = folder.trisect(&format!("{QUERY} rays.csv"), b"");
    assert_eq!((from_csv.code, from_csv.stderr.as_str()), (Some(0), ""));
    assert_eq!(
        from_csv.stdout,
        "{\"ray\":0,\"hit\":true,\"triangle\":0,\"t\":3.0,\"beta\":0.25,\"gamma\":0.5}\n\
         {\"ray\":1,\"hit\":false}\n"
    );
    let from_binary = folder.trisect(&format!("{QUERY} rays.rays"), b"");
    assert_eq!(from_binary.stdout, from_csv.stdout);
    let from_stdin = folder.trisect(&format!("{QUERY} -"), CSV.as_bytes());
    assert_eq!(from_stdin.stdout, from_csv.stdout);
}

#[test]
fn a_tree_answers_as_testing_every_triangle_does() {
    let folder = Folder::new();
    for options in ["", " --any", " --cull back", " --cull front"] {
        let in_tree = folder.trisect(&format!("{QUERY} rays.csv{options}"), b"");
        let all = folder.trisect(&format!("{QUERY} rays.csv --brute-force{options}"), b"");
        assert_eq!((in_tree.code, in_tree.stdout), (all.code, all.stdout), "{options}");
    }
}

#[test]
fn rays_are_traced_and_their_hits_are_written() {
    let folder = Folder::new();
    let trace = "trace --mesh mesh.obj --rays rays.csv --threads 1 --repeat 3";
    let run = folder.trisect(&format!("{trace} --json --out hits"), b"");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let report: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(
        (&report["hits"], &report["rays"], &report["sum_t"]),
        (&1.into(), &2.into(), &3.0.into())
    );
    assert_eq!((&report["threads"], &report["triangles"]), (&1.into(), &2.into()));
    assert_eq!(
        (&report["builder"], &report["references"], &report["nodes"]),
        (&"spatial".into(), &2.into(), &1.into())
    );
    assert_eq!(report["samples_ns"].as_array().map(Vec::len), Some(3));
    // t and triangle of the hit; infinity and no triangle for the miss.
    let mut expected = Vec::new();
    expected.extend(3.0_f32.to_le_bytes());
    expected.extend(0_u32.to_le_bytes());
    expected.extend(f32::INFINITY.to_le_bytes());
    expected.extend(u32::MAX.to_le_bytes());
    assert_eq!(fs::read(folder.path().join("hits")).expect("just written"), expected);

    let any = folder.trisect(&format!("{trace} --any --builder linear"), b"");
    assert_eq!((any.code, any.stderr.as_str()), (Some(0), ""));
    assert!(any.stdout.contains("hits   1 of 2 rays"), "{}", any.stdout);
    assert!(any.stdout.contains("by the linear builder"), "{}", any.stdout);
    assert!(any.stdout.lines().all(|line| line.chars().count() <= 80), "{}", any.stdout);
}

/// Whatever wins: both answers are there, unless the machine is too busy, and what is never wrong is always among
/// the methods in a tree.
#[test]
fn methods_are_recommended_in_a_tree_and_for_every_triangle() {
    let folder = Folder::new();
    let bunny = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/meshes/bunny.ply");
    let recommend = format!("recommend --mesh {bunny} --rounds 3");
    let run = folder.trisect(&format!("{recommend} --json"), b"");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let found: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert!(found["noise"]["drift"].is_f64(), "{}", found["noise"]);
    assert_eq!(found["answers"]["scenes"], serde_json::json!([["bunny", 69_451]]));
    let checked = &found["answers"]["checked"];
    assert!(checked[0].as_u64() > Some(1000) && checked[1].as_u64() > Some(1000), "{checked}");
    let answers = |of: &str| found["answers"][of].as_array().expect("a list").clone();
    if answers("trees").is_empty() {
        // Other tests run at the same time.
        assert!(answers("loops").is_empty());
    } else {
        for (of, speeds) in
            [("trees", ["closest", "any", "one"]), ("loops", ["occlusion", "t", "barycentrics"])]
        {
            let asked: Vec<_> = answers(of).iter().map(|answer| answer["asked"].clone()).collect();
            assert!(asked.contains(&"fastest".into()) && asked.contains(&"never wrong".into()));
            for answer in answers(of) {
                for speed in speeds {
                    let speed = &answer["speeds"][speed]["million_per_second"];
                    assert!(speed.as_f64() > Some(0.0), "{answer}");
                }
                if answer["asked"] == "never wrong" {
                    assert_eq!(
                        (&answer["method"], &answer["wrong_per_million"]),
                        (&"exact".into(), &0.0.into())
                    );
                }
            }
        }
    }
    // What a mesh is refused by is no answer, and is said.
    let refused: Vec<_> = found["refused"].as_array().expect("a list").iter().collect();
    assert!(refused.iter().any(|refused| refused["method"] == "wald-fixed-axis"), "{refused:?}");
    let of_all = [answers("trees"), answers("loops")].concat();
    assert!(of_all.iter().all(|answer| refused.iter().all(|r| r["method"] != answer["method"])));
    let rust = found["rust"].as_str().expect("lines of Rust");
    assert!(rust.lines().count() == 6 && rust.contains("Scene::options()."), "{rust}");

    let text = folder.trisect(&recommend, b"").stdout;
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(text.starts_with("trisect "), "{text}");
    let head = text.split("\n\n").next().unwrap_or_default();
    let verdicts = ["quiet (", "noisy (", "unusable ("];
    assert!(verdicts.iter().any(|verdict| head.contains(verdict)), "{text}");
}

#[test]
fn what_a_scene_does_not_need_is_explained() {
    let folder = Folder::new();
    let explain = "explain mesh.obj --rounds 2 --width 16 --height 16 --lights 0";
    let run = folder.trisect(&format!("{explain} --json"), b"");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let found: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    let omissions = found["omissions"].as_array().expect("a list");
    let parts: Vec<_> = omissions.iter().filter_map(|o| o["part"].as_str()).collect();
    let compiled = ["shapes", "varying", "shadows", "onward"];
    assert_eq!(parts, [&compiled[..], &["samples", "transparency", "everything"]].concat());
    assert!(omissions.iter().all(|o| o["left_out"] == true && o["gain"].is_f64()), "{omissions:?}");

    // Mirrors are needed once they are followed.
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/mirror.toml");
    for (depth, left_out) in [(0, true), (1, false)] {
        let explain = format!("explain {scene} --rounds 1 --width 16 --height 16 --depth {depth}");
        let run = folder.trisect(&format!("{explain} --json"), b"");
        let found: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
        assert_eq!(found["omissions"][3]["part"], "onward");
        assert_eq!(found["omissions"][3]["left_out"], left_out, "{depth}");
    }
    let text = folder.trisect(explain, b"").stdout;
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn no_rays_have_no_answers() {
    let folder = Folder::new();
    folder.write("none.rays", &[0; 4]);
    for method in ["wald", "oracle"] {
        for rays in ["-", "none.rays"] {
            let arguments = format!("query --mesh mesh.obj --method {method} --rays {rays}");
            let run = folder.trisect(&arguments, b"ox,oy,oz,dx,dy,dz\n");
            assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (Some(0), "", ""));
        }
    }
}

#[test]
fn a_closed_pipe_is_no_failure() {
    let folder = Folder::new();
    // More than a pipe holds.
    let rays = format!("ox,oy,oz,dx,dy,dz\n{}", "0.25,0.5,-3,0,0,1\n".repeat(20_000));
    folder.write("many.csv", rays.as_bytes());
    let many = format!("{QUERY} many.csv");
    for arguments in [many.as_str(), "list", "completions bash", "verify --json"] {
        let mut child = folder.command(arguments).spawn().expect("just built");
        let mut first = String::new();
        let mut stdout = BufReader::new(child.stdout.take().expect("it is piped"));
        if arguments == many {
            stdout.read_line(&mut first).expect("it answers");
            assert!(first.starts_with("{\"ray\":0"), "{first}");
        }
        drop(stdout);
        let mut stderr = String::new();
        child
            .stderr
            .take()
            .expect("it is piped")
            .read_to_string(&mut stderr)
            .expect("trisect prints UTF-8");
        let status = process::ended(&mut child);
        assert_eq!((status.code(), stderr.as_str()), (Some(0), ""), "{arguments}");
    }
}

/// A record without what the clock says.
fn timeless(record: &str) -> Vec<serde_json::Value> {
    let mut lines: Vec<serde_json::Value> = record
        .lines()
        .map(|line| serde_json::from_str(line).expect("a record is JSON lines"))
        .collect();
    lines[0]["started"].take();
    lines[0]["machine"]["core_ghz"].take();
    assert!(lines[0].get("noise").is_none(), "nothing was timed");
    // How many processors the process may use is what the threads are counted by.
    lines
}

#[test]
fn answers_do_not_depend_on_the_number_of_threads() {
    let folder = Folder::new();
    let run = |threads: &str| {
        let mut command = folder.command("verify --json --seed 3 --mesh mesh.obj");
        command.env("RAYON_NUM_THREADS", threads);
        let run = folder.run(command, b"");
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        timeless(&run.stdout)
    };
    let one = run("1");
    assert!(one.len() > 100, "{} lines show little", one.len());
    assert_eq!(one, run("2"));
    let other = timeless(&folder.trisect("verify --json --seed 4 --mesh mesh.obj", b"").stdout);
    assert_ne!(one[1..], other[1..], "the seed plays no part");
}

/// Whether a first screen names the one method that was measured, or says that the machine is too busy for it,
/// as other tests make it.
fn is_answer(text: &str) -> bool {
    text.contains("moller-trumbore") != text.contains("No winner is named")
}

/// Holds a folder to be a whole page: every figure it names is there and is XML.
fn is_a_page(folder: &Folder, name: &str) {
    let path = folder.path().join(name);
    let page = fs::read_to_string(path.join("index.html")).expect("a page has an index");
    assert!(page.starts_with("<!DOCTYPE html>"), "{}", &page[..60.min(page.len())]);
    assert!(page.trim_end().ends_with("</html>"));
    for tag in ["table", "figure", "section", "svg", "pre"] {
        let opened =
            page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "<{tag}>");
    }
    let figures: Vec<_> = fs::read_dir(path.join("figures"))
        .expect("a page has figures")
        .map(|figure| figure.expect("just written").path())
        .collect();
    assert!(!figures.is_empty());
    for figure in figures {
        let text = fs::read_to_string(&figure).expect("a figure is text");
        let document = roxmltree::Document::parse(&text).expect("a figure is XML");
        assert!(document.root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg")));
    }
}

/// One test, as the measurement is what takes its time.
#[test]
fn a_measurement_becomes_a_record_a_ranking_a_comparison_and_a_page() {
    let folder = Folder::new();
    let what = "--methods moller-trumbore --rounds 1 --mesh mesh.obj";
    let before = folder.listing();
    let run = folder.trisect(&format!("measure {what} --output made/record.jsonl"), b"");
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (Some(0), "", ""));
    let mut expected = before;
    expected.extend(["made".to_owned(), "made/record.jsonl".to_owned()]);
    assert_eq!(folder.listing(), expected);

    let ranking = folder.trisect("rank made/record.jsonl", b"");
    assert_eq!((ranking.code, ranking.stderr.as_str()), (Some(0), ""));
    assert!(ranking.stdout.contains("\n   1  1.00× ") || ranking.stdout.contains("\n   1  1."));
    assert!(ranking.stdout.lines().all(|line| line.chars().count() <= 80), "{}", ranking.stdout);
    let json = folder.trisect("rank made/record.jsonl --json --needs t --workload random", b"");
    let json: serde_json::Value = serde_json::from_str(&json.stdout).expect("JSON");
    assert_eq!(json["workloads"], serde_json::json!(["random"]));
    let entries = json["entries"].as_array().expect("a list");
    assert!(!entries.is_empty());
    assert!(entries.iter().all(|entry| entry["variant"]["needs"] == "t"));
    let none = folder.trisect("rank made/record.jsonl --workload teapot", b"");
    assert_eq!((none.code, none.stdout.as_str()), (Some(2), ""));
    assert!(
        none.stderr.starts_with(
            "trisect: made/record.jsonl: nothing is timed on workload `teapot`; timed are "
        ) && none.stderr.contains("mesh/primary"),
        "{}",
        none.stderr
    );

    let same = folder.trisect("cmp made/record.jsonl made/record.jsonl --json", b"");
    assert_eq!((same.code, same.stderr.as_str()), (Some(0), ""));
    let same: serde_json::Value = serde_json::from_str(&same.stdout).expect("JSON");
    assert_eq!(same["geometric_mean"], 1.0);
    assert_eq!(same["errors_that_differ"], serde_json::json!([]));

    let report = folder.trisect("report made/record.jsonl --output page", b"");
    assert_eq!((report.code, report.stderr.trim()), (Some(0), "page    page/index.html"));
    is_a_page(&folder, "page");
    assert!(is_answer(&report.stdout), "{}", report.stdout);
    assert!(report.stdout.lines().all(|line| line.chars().count() <= 80), "{}", report.stdout);
    assert!(!folder.path().join("reports").exists(), "nobody asked for it");
    let report = folder.trisect("report made/record.jsonl", b"");
    assert_eq!(report.code, Some(0), "{}", report.stderr);
    is_a_page(&folder, "reports/latest");
}

/// One test, as the study is what takes its time.
#[test]
fn a_study_adds_its_page_and_its_record_to_a_report() {
    let folder = Folder::new();
    let report = "--methods moller-trumbore --rounds 1 --mesh mesh.obj --output here";
    assert_eq!(folder.trisect(report, b"").code, Some(0));
    let index = || fs::read_to_string(folder.path().join("here/index.html")).expect("it is there");
    assert!(!index().contains("stress.html"));

    let study = "stress --quick --methods watertight --fuzz 1e6 --output here";
    let run = folder.trisect(study, b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let written = ["page    here/stress.html", "record  here/stress.jsonl"];
    assert_eq!(run.stderr.trim().lines().collect::<Vec<_>>(), written);
    assert!(run.stdout.contains("\nwatertight "), "{}", run.stdout);
    assert!(run.stdout.contains(" tests of hostile input over all kernels, 0 violations."));
    assert!(run.stdout.lines().all(|line| line.chars().count() <= 80), "{}", run.stdout);
    assert!(index().contains("<a href=\"stress.html\">"), "the comparison leads to the study");

    // The page of the record is the same, and its summary can be read by a program.
    let page = fs::read(folder.path().join("here/stress.html")).expect("it is there");
    let again = folder.trisect("report here/stress.jsonl --json --output here", b"");
    assert_eq!((again.code, again.stderr.trim()), (Some(0), "page    here/stress.html"));
    assert_eq!(fs::read(folder.path().join("here/stress.html")).expect("it is there"), page);
    let summary: serde_json::Value = serde_json::from_str(&again.stdout).expect("JSON");
    assert_eq!(summary["contract_violations"], 0);
    assert_eq!(summary["rows"][0]["method"], "watertight");
    assert_eq!(summary["rows"][0]["edge_cracks"], 0.0);
}

/// One test, as the study is what takes its time.
#[test]
fn a_study_of_the_tracer_adds_its_page_and_its_record_to_a_report() {
    let folder = Folder::new();
    let report = "--methods moller-trumbore --rounds 1 --mesh mesh.obj --output here";
    assert_eq!(folder.trisect(report, b"").code, Some(0));

    let study = "study --quick --methods watertight --mesh mesh.obj --threads 2 --output here";
    let run = folder.trisect(study, b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let written = ["page    here/study.html", "record  here/study.jsonl"];
    assert_eq!(run.stderr.trim().lines().collect::<Vec<_>>(), written);
    for method in ["moller-trumbore", "watertight"] {
        assert!(run.stdout.contains(&format!("\n{method} ")), "{}", run.stdout);
    }
    assert!(run.stdout.lines().all(|line| line.chars().count() <= 80), "{}", run.stdout);
    let index = fs::read_to_string(folder.path().join("here/index.html")).expect("it is there");
    assert!(index.contains("<a href=\"study.html\">"), "the comparison leads to the study");

    // The page of the record is the same, and its summary can be read by a program.
    let page = fs::read(folder.path().join("here/study.html")).expect("it is there");
    let again = folder.trisect("report here/study.jsonl --json --output here", b"");
    assert_eq!((again.code, again.stderr.trim()), (Some(0), "page    here/study.html"));
    assert_eq!(fs::read(folder.path().join("here/study.html")).expect("it is there"), page);
    let summary: serde_json::Value = serde_json::from_str(&again.stdout).expect("JSON");
    assert_eq!(summary["rows"][1]["method"], "watertight");
    assert!(summary["rows"][1]["single_gain"].as_f64().is_some_and(|gain| gain > 0.0));
}

/// One test, as the study is what takes its time.
#[test]
fn a_study_of_pictures_adds_its_page_and_its_record_to_a_report() {
    let folder = Folder::new();
    let report = "--methods moller-trumbore --rounds 1 --mesh mesh.obj --output here";
    assert_eq!(folder.trisect(report, b"").code, Some(0));

    let study = "pictures --quick --shrink 10 --methods watertight --threads 2 --seed 3 --output";
    let run = folder.trisect(&format!("{study} here"), b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let written = ["page    here/pictures.html", "record  here/pictures.jsonl"];
    assert_eq!(run.stderr.trim().lines().collect::<Vec<_>>(), written);
    assert!(run.stdout.contains("The mirror scene at 64 by 48, one sample"), "{}", run.stdout);
    assert!(run.stdout.lines().all(|line| line.chars().count() <= 80), "{}", run.stdout);
    let index = fs::read_to_string(folder.path().join("here/index.html")).expect("it is there");
    assert!(index.contains("<a href=\"pictures.html\">"), "the comparison leads to the study");

    // The page of the record is the same, and its summary can be read by a program.
    let page = fs::read(folder.path().join("here/pictures.html")).expect("it is there");
    let again = folder.trisect("report here/pictures.jsonl --json --output here", b"");
    assert_eq!((again.code, again.stderr.trim()), (Some(0), "page    here/pictures.html"));
    assert_eq!(fs::read(folder.path().join("here/pictures.html")).expect("it is there"), page);
    let text = String::from_utf8(page).expect("it is text");
    assert!(text.contains("The mirror scene at 16 by 12, one sample, one light, depth 16, from"));
    assert!(text.matches("data:image/png;base64,").count() >= 14, "a picture of each feature");
    let summary: serde_json::Value = serde_json::from_str(&again.stdout).expect("JSON");
    // Two sizes at four levels.
    assert_eq!(summary["sizes"].as_array().map(Vec::len), Some(8));
    assert_eq!(summary["techniques"][4]["method"], "watertight");
    assert!(summary["goal"]["frames_per_second"].as_f64().is_some_and(|frames| frames > 0.0));

    // With the same seed the same pictures, rays and order; only times differ.
    let run = folder.trisect(&format!("{study} there"), b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let record = |name: &str| {
        let text = fs::read_to_string(folder.path().join(name)).expect("it is there");
        // The first line says when.
        let lines = text.lines().skip(1).map(|line| {
            let mut line: serde_json::Value = serde_json::from_str(line).expect("JSON");
            let times = line.get_mut("samples_ns").and_then(serde_json::Value::as_array_mut);
            if let Some(times) = times {
                assert_eq!(times.len(), 3, "{line}");
                times.clear();
            }
            line
        });
        lines.collect::<Vec<_>>()
    };
    let lines = record("here/pictures.jsonl");
    for kind in ["frames", "picture"] {
        assert!(lines.iter().filter(|line| line["kind"] == kind).count() >= 14, "{kind}");
    }
    assert_eq!(record("there/pictures.jsonl"), lines);
}

/// One test, as the study is what takes its time.
#[test]
fn a_study_of_omissions_adds_its_page_and_its_record_to_a_report() {
    let folder = Folder::new();
    let study = "omissions --quick --shrink 16 --methods wald,perpendicular-planes --output here";
    let run = folder.trisect(study, b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let written = ["page    here/omissions.html", "record  here/omissions.jsonl"];
    assert_eq!(run.stderr.trim().lines().collect::<Vec<_>>(), written);
    assert!(run.stdout.lines().all(|line| line.chars().count() <= 80), "{}", run.stdout);
    for told in ["kernels: deferred", "tracer: robust-boxes", "pictures: everything"] {
        assert!(run.stdout.contains(told), "{told}: {}", run.stdout);
    }
    let record = fs::read_to_string(folder.path().join("here/omissions.jsonl")).expect("there");
    let lines: Vec<serde_json::Value> = record
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .filter(|line: &serde_json::Value| line["kind"] == "omission")
        .collect();
    let of = |layer: &str| lines.iter().filter(|line| line["layer"] == layer).count();
    // The second method has one published form, and decides by numerators where no value is asked for:
    // that is no other form of the same. Each is timed in double precision once.
    assert_eq!(of("kernel"), 3 + 2);
    // Six things for each of four classes of rays through two scenes.
    assert_eq!(of("tracer"), 6 * 4 * 2);
    // No scene needs everything in ambient light.
    assert!(of("picture") >= 2 * 7, "{record}");
    assert!(lines.iter().all(|line| line["with_ns"].as_array().is_some_and(|ns| ns.len() == 11)));

    let page = fs::read(folder.path().join("here/omissions.html")).expect("it is there");
    let again = folder.trisect("report here/omissions.jsonl --json --output here", b"");
    assert_eq!((again.code, again.stderr.trim()), (Some(0), "page    here/omissions.html"));
    assert_eq!(fs::read(folder.path().join("here/omissions.html")).expect("it is there"), page);
    let summary: serde_json::Value = serde_json::from_str(&again.stdout).expect("JSON");
    assert_eq!(summary["omissions"].as_array().map(Vec::len), Some(lines.len()));
}

#[test]
fn a_study_of_the_rasteriser_adds_its_page_and_its_record_to_a_report() {
    let folder = Folder::new();
    let run = folder.trisect("raster --shrink 24 --threads 1 --output here", b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let written = ["page    here/raster.html", "record  here/raster.jsonl"];
    assert_eq!(run.stderr.trim().lines().collect::<Vec<_>>(), written);
    for told in ["The triangles below which", "Two lights and three", "built for 10 pictures"] {
        assert!(run.stdout.contains(told), "{told}: {}", run.stdout);
    }
    let again = folder.trisect("report here/raster.jsonl --json --output here", b"");
    let summary: serde_json::Value = serde_json::from_str(&again.stdout).expect("JSON");
    let ways = summary["ways"].as_array().expect("a list");
    let filtered = |way: &&serde_json::Value| way["way"] == "rasterised, filtered";
    assert!(ways.iter().filter(filtered).count() >= 12);
    assert!(ways.iter().filter(filtered).all(|way| way["different"] == 0), "{ways:?}");
}

#[test]
fn without_a_verb_everything_is_written_where_it_is_asked_for() {
    let folder = Folder::new();
    let what = "--methods moller-trumbore --rounds 1 --mesh mesh.obj --output here";
    let run = folder.trisect(what, b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let written = ["page    here/index.html", "record  here/record.jsonl"];
    assert_eq!(run.stderr.trim().lines().collect::<Vec<_>>(), written);
    assert!(is_answer(&run.stdout), "{}", run.stdout);
    assert!(run.stdout.lines().all(|line| line.chars().count() <= 80), "{}", run.stdout);
    is_a_page(&folder, "here");
    assert!(!folder.path().join("reports").exists(), "nobody asked for it");
    let ranking = folder.trisect("rank here/record.jsonl --json", b"");
    assert_eq!(ranking.code, Some(0), "{}", ranking.stderr);
}
