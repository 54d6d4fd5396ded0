//! Records that hold part of a study, or numbers that no machine measures: every page, summary and
//! document is made of what there is. The records of the repository are the examples.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read as _;
use std::path::Path;

use flate2::read::MultiGzDecoder;
use serde_json::Value;
use trisect_studies::Chapter;
use trisect_studies::chapter_of;
use trisect_studies::chapters;
use trisect_studies::comparison::Comparison;
use trisect_studies::comparison::{Filter, compare_records, rank};
use trisect_studies::record::Records;
use trisect_studies::splice;
use trisect_studies::stress::exactness_summary;

/// Lines of a kind that are looked at, those of methods aside.
const LINES: usize = 16;

/// The lines of a record by kind, some of each.
struct Excerpt {
    name: String,
    header: String,
    kinds: BTreeMap<String, Vec<String>>,
}

/// Of every record in the repository.
fn excerpts() -> Vec<Excerpt> {
    let reports = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../reports");
    let mut excerpts = Vec::new();
    for report in fs::read_dir(reports).expect("the reports are in the repository") {
        let report = report.expect("it can be read").path();
        for chapter in chapters() {
            let path = report.join(format!("{}.gz", chapter.about.record));
            let Ok(file) = fs::File::open(&path) else { continue };
            let mut text = String::new();
            MultiGzDecoder::new(file).read_to_string(&mut text).expect("it is compressed");
            let (header, lines) = text.split_once('\n').expect("a record has lines");
            let mut kinds: BTreeMap<String, Vec<String>> = BTreeMap::new();
            for line in lines.lines() {
                let kind = line.split('"').nth(3).expect("a line begins with its kind");
                kinds.entry(kind.to_owned()).or_default().push(line.to_owned());
            }
            for (kind, lines) in &mut kinds {
                // From all over the record.
                let step = if kind == "method" { 1 } else { lines.len().div_ceil(LINES) };
                *lines = std::mem::take(lines).into_iter().step_by(step).collect();
            }
            let name = report.join(chapter.about.record).display().to_string();
            excerpts.push(Excerpt { name, header: header.to_owned(), kinds });
        }
    }
    assert!(excerpts.len() >= 6, "every chapter has a record");
    excerpts
}

impl Excerpt {
    fn records(&self, take: impl Fn(&str) -> usize) -> Records {
        let lines = self.kinds.iter().flat_map(|(kind, lines)| lines.iter().take(take(kind)));
        let lines: Vec<&str> = lines.map(String::as_str).collect();
        parse(&self.header, &lines).unwrap_or_else(|| panic!("{}: a record", self.name))
    }
}

fn parse(header: &str, lines: &[&str]) -> Option<Records> {
    let text = [&[header], lines].concat().join("\n");
    trisect_studies::read(text.as_bytes()).ok()
}

/// A document with every marker there is.
fn document(records: &Records) -> String {
    let names = splice("", records).expect_err("there is no marker").to_string();
    let (_, names) = names.rsplit_once("one of: ").expect("the names are listed");
    let marked = |name| format!("<!-- trisect:{name} -->\nold\n<!-- end of trisect:{name} -->\n");
    names.split(", ").map(marked).collect()
}

/// Makes a page of each of some chapters, and everything else that is made of records.
fn draw(records: &Records, chapters: &[Chapter], what: &str) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for chapter in chapters {
        let page = chapter.publish(records, folder.path());
        let page = page.unwrap_or_else(|error| panic!("{what}: {error}"));
        let html = fs::read_to_string(page.index).expect("just written");
        let shown = html.split("<script>").next().expect("it has a beginning");
        // The stability study speaks of both.
        let is_clean = [">NaN", "\"NaN", "inf<"].iter().all(|said| !shown.contains(said));
        assert!(is_clean || chapter.about.name == "stress", "{what}: {}", chapter.about.name);
    }
    let texts = chapters.iter().flat_map(|chapter| {
        let document = chapter.document(records);
        [40, 80].map(|width| document.to_text(width))
    });
    for text in texts {
        assert!(!text.contains("NaN"), "{what}: {text}");
    }
    for width in [40, 80] {
        let filter = Filter::default();
        for text in [
            exactness_summary(records).to_text(width),
            rank(records, &filter).to_text(width),
            compare_records(records, records).to_text(width),
        ] {
            assert!(!text.contains("NaN"), "{what}: {text}");
        }
    }
    splice(&document(records), records).unwrap_or_else(|error| panic!("{what}: {error}"));
}

#[test]
fn every_part_of_a_record_is_drawn() {
    for excerpt in excerpts() {
        let name = &excerpt.name;
        draw(&excerpt.records(|_| 0), chapters(), &format!("{name}: the header alone"));
        for kind in excerpt.kinds.keys() {
            let only = |count: usize| move |other: &str| if other == kind { count } else { 0 };
            let but = |count: usize| move |other: &str| if other == kind { count } else { LINES };
            draw(&excerpt.records(only(1)), chapters(), &format!("{name}: one {kind}"));
            draw(&excerpt.records(only(LINES)), chapters(), &format!("{name}: {kind} alone"));
            let one = std::slice::from_ref(chapter_of(&excerpt.records(|_| LINES)));
            draw(&excerpt.records(but(0)), one, &format!("{name}: all but {kind}"));
            draw(&excerpt.records(but(1)), one, &format!("{name}: little {kind}"));
        }
    }
}

/// A record belongs to a study if any of its lines does.
#[test]
fn a_part_of_a_study_is_of_that_study() {
    for excerpt in excerpts() {
        let of_all = chapter_of(&excerpt.records(|_| LINES));
        assert!(excerpt.name.ends_with(of_all.about.record), "{}", excerpt.name);
        for kind in excerpt.kinds.keys() {
            let of_kind = chapter_of(&excerpt.records(|other| usize::from(other == kind)));
            let is_compared = [
                "agreement",
                "cracks",
                "decisions",
                "error",
                "method",
                "preparation",
                "refusal",
                "throughput",
                "workload",
            ]
            .contains(&kind.as_str());
            let expected = if is_compared { &Chapter::of::<Comparison>() } else { of_all };
            assert_eq!(of_kind.about.name, expected.about.name, "{}: {kind}", excerpt.name);
        }
    }
}

/// The places of numbers in a line, those of one list being one.
fn places(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) if !found.iter().any(|other| other == path) => found.push(path.to_owned()),
        Value::Array(values) => {
            for value in values {
                places(value, &format!("{path}/*"), found);
            }
        }
        Value::Object(fields) => {
            for (name, value) in fields {
                places(value, &format!("{path}/{name}"), found);
            }
        }
        _ => {}
    }
}

fn set(value: &mut Value, path: &str, number: &Value) {
    let Some(rest) = path.strip_prefix('/') else {
        *value = number.clone();
        return;
    };
    let (first, rest) = rest.find('/').map_or((rest, ""), |at| rest.split_at(at));
    match value {
        Value::Array(values) => values.iter_mut().for_each(|value| set(value, rest, number)),
        Value::Object(fields) => {
            if let Some(value) = fields.get_mut(first) {
                set(value, rest, number);
            }
        }
        // Another line has no list there.
        _ => {}
    }
}

#[test]
fn numbers_that_no_machine_measures_are_drawn() {
    let extremes = ["0", "1", "9007199254740992", "-1.5", "1e308", "5e-324"];
    for excerpt in excerpts() {
        let chapter = chapter_of(&excerpt.records(|_| LINES));
        for (kind, lines) in &excerpt.kinds {
            let lines: Vec<Value> = lines
                .iter()
                .take(LINES)
                .map(|line| serde_json::from_str(line).expect("a record is JSON"))
                .collect();
            let mut found = Vec::new();
            for line in &lines {
                places(line, "", &mut found);
            }
            for (place, number) in found.iter().flat_map(|p| extremes.map(|e| (p, e))) {
                let number = serde_json::from_str(number).expect("it is one");
                let changed = lines.iter().map(|line| {
                    let mut line = line.clone();
                    set(&mut line, place, &number);
                    line.to_string()
                });
                let changed: Vec<String> = changed.collect();
                let others = excerpt.kinds.iter().filter(|(other, _)| *other != kind);
                let others = others.flat_map(|(_, lines)| lines.iter().take(LINES));
                let all: Vec<&str> = others.chain(&changed).map(String::as_str).collect();
                // Where a count must be whole, others are refused.
                let Some(records) = parse(&excerpt.header, &all) else { continue };
                draw(
                    &records,
                    std::slice::from_ref(chapter),
                    &format!("{}: {kind}{place} {number}", excerpt.name),
                );
            }
        }
    }
}
