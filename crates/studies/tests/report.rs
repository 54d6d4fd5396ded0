//! What the report says and draws, from records that were never measured.

mod synthetic;

use std::collections::BTreeMap;
use std::path::Path;

use trisect_core::FloatFormat;
use trisect_kernels::Arrangement;
use trisect_method::{Form, Input, Output};
use trisect_report::stats;
use trisect_studies::Chapter;
use trisect_studies::comparison::Comparison;
use trisect_studies::comparison::Quantiles;
use trisect_studies::comparison::{
    Answer, Answers, Decisions, Error, Filter, MethodFacts, Preparation, Refusal, Throughput,
    compare_records, rank, summary,
};
use trisect_studies::noise::Noise;
use trisect_studies::record::{Line, Records};
use trisect_studies::stress::Stability;
use trisect_studies::tracer::{TreeBuilt, TreeChecked};

/// Draws into a folder that lasts as long as the test binary's target folder, to be looked at.
fn page(records: &Records, name: &str) -> String {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let page = Chapter::of::<Comparison>().publish(records, &folder).expect("the page is written");
    std::fs::read_to_string(page.index).expect("the page is there")
}

/// A page without figures, style and script, and with few rows.
fn skeleton(html: &str) -> String {
    let mut out = String::new();
    let mut rest = html;
    while let Some((before, found)) =
        ["<svg", "<style>", "<script>"].iter().filter_map(|t| Some((rest.find(t)?, *t))).min()
    {
        let close = format!("</{}>", found.trim_matches(['<', '>']));
        out.push_str(&rest[..before]);
        let end = rest[before..].find(&close).expect("the element ends") + before + close.len();
        out.push_str(found.trim_end_matches('>'));
        out.push_str("/>");
        rest = &rest[end..];
    }
    out.push_str(rest);
    let (mut kept, mut rows) = (String::new(), 0);
    for line in out.lines().filter(|l| !l.trim().is_empty()) {
        rows = if line.starts_with("<tr>") { rows + 1 } else { 0 };
        if rows <= 3 {
            kept.push_str(line.trim_end());
            kept.push('\n');
        }
    }
    kept
}

fn widest(text: &str) -> usize {
    text.lines().map(|l| l.chars().count()).max().unwrap_or(0)
}

/// A page to look at with as many methods as a full study has: figures grow, nothing breaks.
#[test]
fn thirty_methods() {
    let mut records = synthetic::records(1);
    let one = std::mem::take(&mut records.lines);
    for i in 0..30 {
        let rename = |method: &mut String| *method = format!("method-{i}");
        for mut line in one.iter().cloned() {
            line.edit(|m: &mut MethodFacts| {
                rename(&mut m.name);
                m.title = format!("Method {i} of Somebody and Somebody Else");
            });
            line.edit(|t: &mut Throughput| {
                rename(t.variant.method.to_mut());
                t.samples_ns.iter_mut().for_each(|ns| *ns = *ns * (40 + i) / 50);
            });
            line.edit(|e: &mut Error| {
                rename(e.variant.method.to_mut());
                e.relative.median *= 50.0 / (i as f64 * 1.5 + 40.0);
            });
            line.edit(|d: &mut Decisions| rename(d.variant.method.to_mut()));
            line.edit(|p: &mut Preparation| rename(&mut p.method));
            if i == 0 || !["workload", "agreement"].contains(&line.kind()) {
                records.lines.push(line);
            }
        }
    }
    page(&records, "thirty");
    well_formed("thirty");
}

/// Small records for snapshots: two methods, one need.
fn small() -> Records {
    let mut records = synthetic::records(2);
    records.lines.retain(|line| {
        line.get().is_none_or(|t: &Throughput| {
            t.variant.needs == Output::T && t.variant.arrangement == Arrangement::OneRay
        })
    });
    records
}

#[test]
fn summary_as_text() {
    let text = Chapter::of::<Comparison>().document(&synthetic::records(4)).to_text(80);
    assert!(widest(&text) <= 80, "{text}");
    insta::assert_snapshot!(text);
}

#[test]
fn summary_of_one_method() {
    insta::assert_snapshot!(
        Chapter::of::<Comparison>().document(&synthetic::records(1)).to_text(60)
    );
}

#[test]
fn ranking_as_text() {
    let filter = Filter { needs: Some(Output::T), workload: Some("bunny".into()) };
    let text = rank(&small(), &filter).to_text(80);
    assert!(widest(&text) <= 80, "{text}");
    insta::assert_snapshot!(text);
}

#[test]
fn comparison_as_text() {
    let a = small();
    let mut b = a.clone();
    b.header.machine.compiler = "rustc 1.96.0".into();
    for (i, line) in b.lines.iter_mut().enumerate() {
        line.edit(|t: &mut Throughput| {
            if t.variant.method == "moller-trumbore" {
                t.samples_ns.iter_mut().for_each(|ns| *ns = *ns * 10 / 11);
            }
        });
        line.edit(|e: &mut Error| {
            if i % 97 == 0 {
                e.relative.median *= 2.0;
            }
        });
    }
    let compared = compare_records(&a, &b);
    assert!(!compared.same_machine);
    let text = compared.to_text(80);
    assert!(widest(&text) <= 80, "{text}");
    insta::assert_snapshot!(text);
}

#[test]
fn comparing_a_record_with_itself_finds_nothing() {
    let records = small();
    let compared = compare_records(&records, &records);
    assert!((compared.geometric_mean.expect("something is timed") - 1.0).abs() < 1e-12);
    assert!(compared.errors_compared > 0);
    assert!(compared.errors_that_differ.is_empty() && compared.same_machine);
}

#[test]
fn texts_fit_narrow_terminals() {
    let records = small();
    for width in [40, 60, 100] {
        for text in [
            Chapter::of::<Comparison>().document(&records).to_text(width),
            rank(&records, &Filter::default()).to_text(width),
            compare_records(&records, &records).to_text(width),
        ] {
            assert!(widest(&text) <= width, "{width}: {text}");
        }
    }
}

#[test]
fn page_skeleton() {
    insta::assert_snapshot!(skeleton(&page(&synthetic::records(4), "page")));
}

/// A header and nothing else: every part says what lacks, and no number is made up.
#[test]
fn empty_record() {
    let records = Records { header: synthetic::header(), lines: Vec::new() };
    let html = page(&records, "empty");
    assert_eq!(html.matches("<figure").count(), 0);
    assert_eq!(html.matches("Left out:").count(), 10);
    let body = skeleton(&html);
    let facts = body.find("<dl").expect("facts")..body.find("</dl>").expect("facts end");
    let said: String = body[body.find("<main>").expect("main")..]
        .replace(&body[facts], "")
        .replace("quiet (0.3 % stolen, drift 1.1 %, spread 0.8 %)", "")
        .replace("h1>", "")
        .replace("<h2", "")
        .replace("</h2>", "");
    assert!(!said.contains(|c: char| c.is_ascii_digit()), "{said}");
    assert!(
        Chapter::of::<Comparison>().document(&records).to_text(80).contains("Nothing was timed")
    );
    assert!(rank(&records, &Filter::default()).entries.is_empty());
    assert_eq!(compare_records(&records, &records).geometric_mean, None);
}

/// Each kind of record may lack; what needs it goes, the rest stays.
#[test]
fn each_kind_of_record_may_lack() {
    let kinds =
        ["method", "workload", "throughput", "error", "decisions", "preparation", "agreement"];
    for kind in kinds {
        let mut records = small();
        let all = records.lines.len();
        records.lines.retain(|line| line.kind() != kind);
        assert!(records.lines.len() < all, "{kind}");
        let html = page(&records, &format!("lacks-{kind}"));
        let body = skeleton(&html);
        assert!(!body.contains("NaN") && !body.contains("inf<"), "{kind}");
        // Nothing is drawn without times.
        if kind == "throughput" {
            assert!(!body.contains("<figure"));
        } else {
            well_formed(&format!("lacks-{kind}"));
        }
    }
}

/// One method, one sample, errors of 0, and samples that lasted no time.
#[test]
fn degenerate_numbers() {
    let mut records = synthetic::records(1);
    for (i, line) in records.lines.iter_mut().enumerate() {
        line.edit(|t: &mut Throughput| t.samples_ns.truncate(usize::from(i % 50 != 0)));
        line.edit(|e: &mut Error| {
            if e.variant.division == Form::Deferred {
                e.relative = Quantiles::default();
            }
        });
    }
    let html = page(&records, "degenerate");
    let body = skeleton(&html);
    assert!(!body.contains("NaN") && !body.contains("inf<"));
    well_formed("degenerate");
    let svg = std::fs::read_to_string(
        Path::new(env!("CARGO_TARGET_TMPDIR")).join("degenerate/figures/error-against-time.svg"),
    )
    .expect("the figure is there");
    let tree = roxmltree::Document::parse(&svg).expect("well-formed");
    let zero = |n: roxmltree::Node<'_, '_>| n.text().is_some_and(|t| t.trim() == "0");
    assert!(tree.descendants().any(|n| n.has_tag_name("text") && zero(n)), "a line marked 0");
}

/// Every figure of a page is XML, has a name for those who cannot see it, and loads nothing.
fn well_formed(name: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name).join("figures");
    for file in std::fs::read_dir(folder).expect("the folder is there") {
        let path = file.expect("an entry").path();
        let svg = std::fs::read_to_string(&path).expect("text");
        let name = path.display();
        let tree = roxmltree::Document::parse(&svg).unwrap_or_else(|e| panic!("{name}: {e}"));
        let root = tree.root_element();
        assert_eq!(root.attribute("role"), Some("img"));
        for id in root.attribute("aria-labelledby").expect("a label").split(' ') {
            let named = tree.descendants().find(|n| n.attribute("id") == Some(id));
            assert!(named.and_then(|n| n.text()).is_some_and(|t| !t.is_empty()), "{name} {id}");
        }
        // The namespace is the only address; and a colour without a class would not follow the
        // reader's theme.
        assert_eq!(svg.matches("://").count(), 1, "{name}");
        for node in tree.descendants().filter(|n| n.attribute("fill").is_some_and(|f| f != "none"))
        {
            assert!(node.attribute("class").is_some(), "{name}: {node:?}");
        }
        let view: Vec<f64> = root
            .attribute("viewBox")
            .expect("a view box")
            .split(' ')
            .map(|x| x.parse().expect("a number"))
            .collect();
        for text in tree.descendants().filter(|n| n.has_tag_name("text")) {
            // What a text does not say it has of the whole drawing.
            let said = |a: &str| text.attribute(a).or_else(|| root.attribute(a));
            let at = |a: &str| said(a).expect("a place").parse::<f64>().expect("a number");
            assert!((0.0..=view[2]).contains(&at("x")) && (0.0..=view[3]).contains(&at("y")));
            assert!(at("font-size") >= 12.0, "{name}: {text:?}");
        }
    }
}

#[test]
fn figures_are_well_formed() {
    page(&synthetic::records(4), "figures");
    well_formed("figures");
}

#[test]
fn page_loads_nothing() {
    let html = page(&synthetic::records(4), "loads");
    let addresses: Vec<&str> =
        html.match_indices("://").map(|(i, _)| &html[i - 5..i + 24]).collect();
    assert!(
        addresses
            .iter()
            .all(|a| a.starts_with("=\"http://www.w3.org/2000/svg")
                || a.contains("www.w3.org/2000/svg")),
        "{addresses:?}"
    );
    for loads in ["src=", "@import", "url(", "fetch(", "<iframe", "<object"] {
        assert!(!html.contains(loads), "{loads}");
    }
    // What records say is text, never markup.
    assert!(html.contains("&lt;to escape&gt;") && !html.contains("<to escape>"));
}

/// The numbers of the table of variants, worked out again from the lines of the record.
#[test]
fn numbers_come_from_the_records() {
    let records = small();
    let html = page(&records, "numbers");
    let mains = ["random", "bunny/primary", "bunny/random", "bunny/diffuse", "bunny/occlusion"];
    let mut ns: BTreeMap<_, Vec<f64>> = BTreeMap::new();
    for t in records.all::<Throughput>() {
        if mains.contains(&t.workload.as_str()) {
            let mut sorted = t.samples_ns.clone();
            sorted.sort_unstable();
            let median = sorted[sorted.len() / 2] as f64 / t.tests as f64;
            ns.entry(&t.variant).or_default().push(median);
        }
    }
    let mut shown: Vec<f64> = html
        .lines()
        .filter(|l| l.starts_with("<tr>") && l.contains("<td>t</td>"))
        .map(|l| {
            let value = l.split("data-v=\"").nth(1).and_then(|v| v.split('"').next());
            value.expect("a speed").parse().expect("a number")
        })
        .collect();
    // Of each method and kind of lanes the fastest.
    let mut best: BTreeMap<_, f64> = BTreeMap::new();
    for (variant, ns) in &ns {
        let speed = 1e3 / (ns.iter().map(|x| x.ln()).sum::<f64>() / ns.len() as f64).exp();
        let lane = variant.lane();
        let of = (&variant.method, lane.precision.name(), lane.width, lane.arithmetic.name());
        let best = best.entry(of).or_default();
        *best = best.max(speed);
    }
    let mut expected: Vec<f64> = best.into_values().collect();
    shown.sort_by(f64::total_cmp);
    expected.sort_by(f64::total_cmp);
    assert_eq!(shown.len(), expected.len());
    for (a, b) in shown.iter().zip(&expected) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }

    // Twice the time on every line is half the speed everywhere.
    let mut slow = records.clone();
    for line in &mut slow.lines {
        line.edit(|t: &mut Throughput| t.samples_ns.iter_mut().for_each(|ns| *ns *= 2));
    }
    let [fast, slow] = [&records, &slow].map(|records| summary(records).answers.loops);
    assert!(!fast.is_empty());
    for (fast, slow) in fast.iter().zip(&slow) {
        assert_eq!(fast.method, slow.method);
        let ratio = fast.speeds["t"].million_per_second / slow.speeds["t"].million_per_second;
        assert!((ratio - 2.0).abs() < 1e-9);
    }
}

/// The first screen of a record with trees.
fn with_trees() -> Records {
    let mut records = synthetic::records(4);
    // The synthetic methods promise nothing.
    for line in &mut records.lines {
        line.edit(|facts: &mut MethodFacts| match facts.name.as_str() {
            "wald" => facts.claims = vec!["watertight".into()],
            "perpendicular-planes" => facts.claims = vec!["exact".into()],
            _ => facts.input = Some(Input::Points),
        });
    }
    let methods = [
        ("moller-trumbore", 3, 40),
        ("kensler-shirley", 2, 30),
        ("wald", 1, 0),
        ("perpendicular-planes", 0, 0),
    ];
    records.lines.extend(synthetic::trees(&methods, 69_451));
    records
}

#[test]
fn the_first_screen_answers() {
    let records = with_trees();
    let Answers { trees, loops, .. } = summary(&records).answers;
    let named = |answers: &[Answer]| -> Vec<_> {
        answers.iter().map(|answer| (answer.asked, answer.method.clone())).collect()
    };
    assert_eq!(
        named(&trees),
        [
            ("fastest", "moller-trumbore"),
            ("no cracks", "wald"),
            ("never wrong", "perpendicular-planes")
        ]
        .map(|(asked, method)| (asked, method.to_owned()))
    );
    let behind = |answer: &Answer| answer.speeds["closest"].behind;
    assert_eq!(behind(&trees[0]), None);
    assert!(behind(&trees[1]).is_some_and(|share| (share - 0.1 / 1.1).abs() < 1e-3), "{trees:?}");
    assert_eq!(
        (trees[0].wrong_per_million, trees[0].cracks_per_million),
        (Some(300.0), Some(2000.0))
    );
    // The synthetic records find what claims to be exact wrong about pairs.
    let asked: Vec<_> = loops.iter().map(|answer| answer.asked).collect();
    assert_eq!(asked, ["fastest", "from points", "no cracks"]);
    let text = Chapter::of::<Comparison>().document(&records).to_text(80);
    let first: Vec<&str> = text.lines().take(30).collect();
    assert!(first[0].contains("Synthetic Processor"), "{text}");
    assert!(first[1].contains("quiet (0.3 % stolen, drift 1.1 %, spread 0.8 %)"), "{text}");
    for (row, count) in [("fastest ", 2), ("no cracks ", 2), ("never wrong ", 1)] {
        let rows = first.iter().filter(|line| line.starts_with(row));
        assert_eq!(rows.count(), count, "{row}: {text}");
    }
    assert!(widest(&text) <= 80, "{text}");
    insta::assert_snapshot!(first.join("\n"));

    // Few triangles are tested all.
    let mut few = records;
    for line in &mut few.lines {
        line.edit(|tree: &mut TreeBuilt| tree.triangles = 12);
    }
    let text = Chapter::of::<Comparison>().document(&few).to_text(80);
    assert!(text.find("A few triangles") < text.find("Rays against a mesh"), "{text}");
}

/// Neither by its own name nor by that of whoever else is the fastest by noise.
#[test]
fn no_winner_is_named_where_the_machine_is_busy() {
    let mut records = with_trees();
    records.header.noise = Some(Noise { stolen: Some(0.4), drift: 0.01, spread: 0.01 });
    let Answers { trees, loops, .. } = summary(&records).answers;
    assert!(trees.is_empty() && loops.is_empty());
    let text = Chapter::of::<Comparison>().document(&records).to_text(80);
    let head: Vec<&str> = text.split("\n\n").take(2).collect();
    assert!(head[0].contains("unusable (40 % stolen"), "{text}");
    assert!(head[1].starts_with("No winner is named"), "{text}");
    assert!(!text.contains("fastest  "), "{text}");
    assert!(page(&records, "busy").contains("The machine was unusable (40 % stolen"));
    // A noisy machine names one, and tells small differences not apart.
    records.header.noise = Some(Noise { stolen: None, drift: 0.01, spread: 0.12 });
    let Answers { trees, .. } = summary(&records).answers;
    assert!(
        trees
            .iter()
            .flat_map(|answer| answer.speeds.values())
            .filter_map(|s| s.behind)
            .all(|b| b > 0.12)
    );
    let text = Chapter::of::<Comparison>().document(&records).to_text(80);
    let noisy = "noisy (drift 1 %, spread 12 %): differences under 12 % are not";
    assert!(text.contains(noisy), "{text}");
}

#[test]
fn what_one_workload_refuses_does_not_win() {
    let mut records = with_trees();
    let fastest = summary(&records).answers.loops[0].method.clone();
    assert_ne!(fastest, "moller-trumbore");
    records.lines.push(Line::from(Refusal {
        method: fastest.clone(),
        precision: FloatFormat::F32,
        workload: "bunny/primary".into(),
        reason: "an axis is wrong".into(),
    }));
    let answers = summary(&records).answers;
    assert!(answers.loops.iter().all(|answer| answer.method != fastest), "{answers:?}");
    // Nor does what breaks its promise here keep it.
    for line in &mut records.lines {
        line.edit(|check: &mut TreeChecked| check.passed += 1);
    }
    let answers = summary(&records).answers;
    assert!(answers.trees.iter().all(|answer| answer.asked != "no cracks"), "{answers:?}");
}

/// Nothing half-written stays behind, and a second page replaces the first.
#[test]
fn pages_replace_each_other() {
    let folder = tempfile::tempdir().expect("a folder");
    for count in [4, 1] {
        Chapter::of::<Comparison>()
            .publish(&synthetic::records(count), folder.path())
            .expect("the page is written");
    }
    let left: Vec<_> = std::fs::read_dir(folder.path())
        .expect("the folder")
        .map(|e| e.expect("an entry").file_name())
        .collect();
    assert_eq!(left.len(), 2, "{left:?}");
    let html = std::fs::read_to_string(folder.path().join("index.html")).expect("the page");
    assert!(!html.contains("Wald"));
    let blocked = folder.path().join("index.html");
    let error = Chapter::of::<Comparison>()
        .publish(&synthetic::records(1), &blocked)
        .map(drop)
        .expect_err("a file is no folder");
    assert!(error.to_string().contains("index.html"), "{error}");
}

/// The pages of a folder lead to each other; where one cannot, nothing is written.
#[test]
fn what_lies_beside_a_page_leads_there_or_stops_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let read = |name: &str| std::fs::read_to_string(path(name)).expect("it is there");
    let records = synthetic::records(1);
    Chapter::of::<Stability>().keep(&records, folder.path()).expect("it is published");
    let (page, record) = (read("stress.html"), read("stress.jsonl"));
    assert!(!page.contains("href=\"index.html\""));

    std::fs::write(path("stress.jsonl"), "notes\n").expect("written");
    let says = "stress.jsonl: line 1 is not a record header; make a record with `trisect measure \
                --output FILE`";
    for failed in [
        Chapter::of::<Comparison>().check(folder.path()),
        Chapter::of::<Comparison>().keep(&records, folder.path()).map(drop),
    ] {
        let error = failed.expect_err("it is no record").to_string();
        assert!(error.ends_with(says), "{error}");
    }
    assert_eq!(read("stress.html"), page);
    assert!(!path("index.html").exists() && !path("record.jsonl").exists());

    std::fs::write(path("stress.jsonl"), record).expect("written");
    Chapter::of::<Comparison>().check(folder.path()).expect("it is a record again");
    Chapter::of::<Comparison>().keep(&records, folder.path()).expect("it is published");
    assert!(read("stress.html").contains("href=\"index.html\""));
    assert!(read("index.html").contains("href=\"stress.html\""));
    assert!(path("record.jsonl").exists());
}

#[test]
fn summary_serialises() {
    let json = serde_json::to_value(summary(&small())).expect("serialises");
    assert_eq!(json["header"]["seed"], 7);
    assert!(json["answers"]["loops"][0]["speeds"]["t"]["within"].as_f64().is_some_and(|x| x > 0.0));
    assert!(serde_json::to_value(rank(&small(), &Filter::default())).is_ok());
    assert!(serde_json::to_value(compare_records(&small(), &small())).is_ok());
}

mod statistics {
    use super::stats::{geometric_mean, line, mad, median, ns_per_test, pareto_front, quartiles};
    use proptest::prelude::*;

    #[test]
    fn of_lines() {
        let (slope, correlation) = line(&[(0.0, 1.0), (2.0, 2.0), (4.0, 3.0)]).expect("a line");
        assert!((slope - 0.5).abs() < 1e-12 && (correlation - 1.0).abs() < 1e-12);
        let (slope, correlation) =
            line(&[(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]).expect("no line");
        assert_eq!((slope, correlation), (0.0, 0.0));
        assert_eq!(line(&[]), None);
        assert_eq!(line(&[(1.0, 1.0), (1.0, 2.0)]), None, "upright");
    }

    #[test]
    fn of_short_lists() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(quartiles(&[1.0, 2.0, 3.0, 4.0, 5.0]), Some((2.0, 4.0)));
        assert_eq!(mad(&[1.0, 1.0, 2.0, 9.0]), Some(0.5));
        assert_eq!(median(&[f64::NAN]), None);
        assert!((geometric_mean([2.0, 8.0]).expect("positive") - 4.0).abs() < 1e-12);
        assert_eq!(geometric_mean([]), None);
        assert_eq!(geometric_mean([1.0, 0.0]), None);
        assert_eq!(ns_per_test(&[300, 100, 200], 100), Some(2.0));
        assert_eq!(ns_per_test(&[], 1), None);
        assert_eq!(ns_per_test(&[5], 0), None);
    }

    proptest! {
        /// No point of the front is beaten, every other point is, and the front falls.
        #[test]
        fn the_front_is_what_nothing_beats(
            points in prop::collection::vec((0u8..20, 0u8..20), 0..40)
        ) {
            let points: Vec<(f64, f64)> =
                points.into_iter().map(|(x, y)| (x.into(), y.into())).collect();
            let front = pareto_front(&points);
            let no_worse = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1;
            for (i, &p) in points.iter().enumerate() {
                let beaten = points.iter().any(|&q| q != p && no_worse(q, p));
                if front.contains(&i) {
                    prop_assert!(!beaten);
                } else {
                    prop_assert!(front.iter().any(|&f| no_worse(points[f], p)));
                }
            }
            for pair in front.windows(2) {
                let (a, b) = (points[pair[0]], points[pair[1]]);
                prop_assert!(a.0 < b.0 && a.1 > b.1);
            }
        }
    }
}
