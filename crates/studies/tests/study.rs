//! The study of the tracer as text, page and documents, from records that were never measured.

mod synthetic;

use trisect_studies::Chapter;
use trisect_studies::comparison::Comparison;
use trisect_studies::comparison::MethodFacts;
use trisect_studies::record::{Line, Records};
use trisect_studies::splice;
use trisect_studies::tracer::Tracer;
use trisect_studies::tracer::study_summary;
use trisect_studies::tracer::{Contest, Traced, TreeBuilt};

const CLASSES: [&str; 4] = ["primary", "random", "diffuse", "occlusion"];
/// A kernel's gain is its part of a tracer's, whose time is this for the first method.
const NS: u64 = 200_000_000;

fn tree(contest: Contest, method: &str, builder: &str, leaves: &str, threads: usize) -> TreeBuilt {
    let ns = match builder {
        "linear" => 10_000_000,
        "binned" => 40_000_000,
        _ => 100_000_000,
    } / threads as u64;
    let nodes = if leaves == "32" { 3000 } else { 6000 };
    TreeBuilt {
        contest,
        method: method.into(),
        scene: "bunny".into(),
        triangles: 70_000,
        builder: builder.into(),
        leaves: leaves.into(),
        threads,
        samples_ns: vec![ns, ns + 1000, ns + 2000],
        nodes,
        blocks: 2 * nodes,
        references: 80_000,
        depth: 9,
        bytes: nodes * 600,
        cost: 12.5,
    }
}

fn traced(tree: &TreeBuilt, class: &str, (tracing, calls): (&str, &str), ns: u64) -> Traced {
    Traced {
        contest: tree.contest,
        method: tree.method.clone(),
        scene: tree.scene.clone(),
        builder: tree.builder.clone(),
        leaves: tree.leaves.clone(),
        class: class.into(),
        any: class == "occlusion",
        tracing: tracing.into(),
        calls: calls.into(),
        threads: tree.threads,
        rays: 1_000_000,
        hits: 400_000,
        differ: if tracing == "plain" { 0 } else { 3 },
        samples_ns: vec![ns, ns + 2000, ns + 1000],
        baseline_ns: Vec::new(),
    }
}

/// The study of the synthetic methods: each is as much faster in the tracer as its place says.
fn study(count: usize) -> Records {
    let mut records = synthetic::records(count);
    let names: Vec<String> = records.all().map(|facts: &MethodFacts| facts.name.clone()).collect();
    for (place, name) in (0..).zip(&names) {
        let tree = tree(Contest::Methods, name, "spatial", "cheapest", 1);
        records.lines.push(Line::from(tree.clone()));
        for class in CLASSES {
            for (tracing, faster) in [("single", 1), ("packets", 2)] {
                let baseline = NS / faster;
                let mine = traced(&tree, class, (tracing, "batch"), baseline * 10 / (10 + place));
                let baseline_ns = vec![baseline, baseline + 2000, baseline + 1000];
                records.lines.push(Line::from(Traced { baseline_ns, ..mine }));
            }
        }
    }
    let kinds = [
        ("linear", "cheapest", 300),
        ("binned", "cheapest", 220),
        ("spatial", "cheapest", 200),
        ("spatial", "16", 210),
        ("spatial", "32", 250),
    ];
    for (builder, leaves, ms) in kinds {
        let tree = tree(Contest::Trees, "moller-trumbore", builder, leaves, 1);
        records.lines.push(Line::from(tree.clone()));
        for class in CLASSES {
            let mut ways = vec![(("single", "batch"), ms)];
            if (builder, leaves) == ("spatial", "cheapest") {
                ways.extend([(("plain", "batch"), 400), (("single", "ray"), 300)]);
            }
            for (way, ms) in ways {
                records.lines.push(Line::from(traced(&tree, class, way, ms * 1_000_000)));
            }
        }
    }
    for threads in [1, 2, 4] {
        for builder in ["linear", "binned", "spatial"] {
            let tree = tree(Contest::Threads, "moller-trumbore", builder, "cheapest", threads);
            records.lines.push(Line::from(tree.clone()));
            if builder == "spatial" {
                let of_class =
                    |class| traced(&tree, class, ("single", "batch"), NS / threads as u64);
                records.lines.extend(CLASSES.map(|class| Line::from(of_class(class))));
            }
        }
    }
    records
}

#[test]
fn the_summary_adds_up() {
    let summary = study_summary(&study(3));
    assert_eq!(summary.rows.len(), 3);
    let [first, second, third] = &summary.rows[..] else { panic!("three methods") };
    assert_eq!(first.method, "moller-trumbore");
    assert_eq!((first.single_gain, first.kernel_gain), (Some(1.0), Some(1.0)));
    assert!((first.single["primary"] - 5.0).abs() < 1e-3, "a million rays in 0.2 s");
    assert!((first.packets["primary"] - 10.0).abs() < 1e-3);
    let gain = |row: &trisect_studies::tracer::StudyRow| row.single_gain.expect("it was traced");
    // By year: the third of the record is older than the second.
    assert!((gain(second) - 1.2).abs() < 1e-3 && (gain(third) - 1.1).abs() < 1e-3);
    assert!(second.kernel_gain.is_some_and(|gain| gain > 1.2));
    assert!(summary.survives.is_some_and(|part| 0.0 < part && part < 1.0), "{summary:?}");
    assert!(summary.correlation.is_some_and(|c| (-1.0..=1.0).contains(&c)));
    assert_eq!(first.differ_per_million, 3.0);
}

#[test]
fn summary_as_text() {
    let text = Chapter::of::<Tracer>().document(&study(4)).to_text(80);
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    insta::assert_snapshot!(text);
}

#[test]
fn the_pages_of_a_report_lead_to_each_other() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let read = |path: &std::path::Path| std::fs::read_to_string(path).expect("just written");
    let alone = Chapter::of::<Tracer>().publish(&study(4), folder.path()).expect("it is written");
    assert!(!read(&alone.index).contains("index.html"));
    let index = Chapter::of::<Comparison>()
        .publish(&synthetic::records(4), folder.path())
        .expect("it is written");
    assert!(read(&index.index).contains("<a href=\"study.html\">"));
    let page = Chapter::of::<Tracer>().publish(&study(4), folder.path()).expect("it is written");
    let text = read(&page.index);
    assert!(text.contains("<a href=\"index.html\">") && !text.contains("stress.html"));
    assert!(!text.contains("Left out"), "the record holds everything");
    // Three figures, wide and narrow.
    assert_eq!(page.figures.len(), 6);
    for figure in &page.figures {
        roxmltree::Document::parse(&read(figure)).expect("a figure is XML");
    }
    assert_eq!(text.matches("<section").count(), text.matches("</section>").count());
    assert_eq!(text.matches("<table>").count(), text.matches("</table>").count());
}

#[test]
fn without_a_study_the_page_says_what_is_missing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = Chapter::of::<Tracer>()
        .publish(&synthetic::records(2), folder.path())
        .expect("it is written");
    let text = std::fs::read_to_string(page.index).expect("just written");
    assert!(text.contains("Left out: the record holds no study of the tracer"));
}

#[test]
fn every_part_of_a_document_is_made_anew_once() {
    let parts = ["study-findings", "study-methods", "study-trees", "study-threads"];
    let marked =
        parts.map(|part| format!("<!-- trisect:{part} -->\nold\n<!-- end of trisect:{part} -->\n"));
    let document = marked.concat();
    let once = splice(&document, &study(4)).expect("there are markers");
    assert!(!once.contains("\nold\n"));
    assert_eq!(splice(&once, &study(4)).expect("there are markers"), once);
    insta::assert_snapshot!(once);
}
