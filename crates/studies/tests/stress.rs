//! The stability study as text, page and documents, from records that were never measured.

mod synthetic;

use std::collections::BTreeMap;

use trisect_core::{FloatFormat, InstructionSet, MultiplyAdd};
use trisect_kernels::Arrangement;
use trisect_method::{Form, Output, ReciprocalKind};
use trisect_studies::Chapter;
use trisect_studies::comparison::Comparison;
use trisect_studies::comparison::MethodFacts;
use trisect_studies::record::{Line, Records, Variant};
use trisect_studies::splice;
use trisect_studies::stress::Stability;
use trisect_studies::stress::exactness_summary;
use trisect_studies::stress::stress_summary;
use trisect_studies::stress::{
    Bin, ByCondition, Clause, Contract, Errors, ExactCounts, Exactness, FusedDifference, Limits,
    Outcome, Site, SpecialValues, Spread, Stages, StressFamily, StressLevel, SurfaceCracks,
};

fn variant(
    method: &str,
    precision: FloatFormat,
    division: Form,
    arithmetic: MultiplyAdd,
) -> Variant {
    Variant {
        method: method.to_owned().into(),
        precision,
        width: 8,
        instruction_set: InstructionSet::Avx2,
        arithmetic,
        arrangement: Arrangement::OneRay,
        division,
        reciprocal: ReciprocalKind::True,
        early_out: true,
        needs: Output::Barycentrics,
    }
}

/// A level of 100 pairs, half of which hit.
fn level(level: f64, wrong: u64) -> StressLevel {
    let spread = Spread(1e-7, 1e-6);
    let errors = Errors {
        relative: spread,
        absolute: spread,
        ulps: Spread(1.0, 9.0),
        over_condition: spread,
    };
    let classes = [("interior", [50 - wrong, wrong]), ("miss", [wrong, 50 - wrong])];
    StressLevel {
        level,
        classes: classes.map(|(name, counts)| (name.to_owned(), counts)).into(),
        false_hits: wrong,
        false_misses: wrong,
        wrong: 2 * wrong,
        t: errors,
        beta: Some(errors),
        gamma: Some(errors),
        point_along_ray: spread,
        point_by_weights: Some(spread),
    }
}

/// The study of the first two synthetic methods: the second is watertight, and right everywhere.
fn study() -> Records {
    let mut records = synthetic::records(2);
    let mut names = Vec::new();
    for line in &mut records.lines {
        line.edit(|facts: &mut MethodFacts| {
            if !names.is_empty() {
                facts.claims.push("watertight".into());
            }
            names.push(facts.name.clone());
        });
    }
    for (place, name) in names.iter().enumerate() {
        let bad = u64::from(place == 0);
        for precision in [FloatFormat::F32, FloatFormat::F64] {
            for division in [Form::Early, Form::Deferred] {
                let plain = variant(name, precision, division, MultiplyAdd::Plain);
                records.lines.extend(of_variant(&plain, bad));
                let fused = variant(name, precision, division, MultiplyAdd::Fused);
                records.lines.push(Line::from(FusedDifference {
                    variant: fused,
                    inputs: precision,
                    pairs: 1000,
                    decisions: 50,
                    t: Spread(0.1, 2.0),
                    beta: None,
                    gamma: None,
                }));
            }
        }
    }
    records
}

fn of_variant(variant: &Variant, bad: u64) -> Vec<Line> {
    let mut lines = Vec::new();
    for (family, knob) in [("sliver", "aspect"), ("far-mesh", "offset"), ("scale", "size")] {
        let levels = [1.0, 1e2, 1e4, 1e6].into_iter().zip(0..);
        lines.push(Line::from(StressFamily {
            variant: variant.clone(),
            family: family.into(),
            knob: knob.into(),
            inputs: variant.precision,
            flush_to_zero: false,
            levels: levels.map(|(at, hard)| level(at, bad * hard)).collect(),
        }));
        lines.push(Line::from(Limits {
            variant: variant.clone(),
            family: family.into(),
            smallest: 1e-14,
            largest: if bad > 0 { 5e12 } else { 1.7e38 },
        }));
    }
    let bin = |from: f64, to: f64| Bin {
        from,
        to,
        count: 10,
        error: Spread(1e-7, 1e-6),
        over_condition: Spread(0.5, if bad > 0 { 3e5 } else { 2.0 }),
    };
    // Of the f64 kernels the errors on the numbers of f32 as well.
    for inputs in [FloatFormat::F32, FloatFormat::F64] {
        lines.push(Line::from(ByCondition {
            variant: variant.clone(),
            inputs,
            quantity: "t".into(),
            decades: vec![bin(1.0, 10.0), bin(10.0, 100.0), bin(1e6, 1e7)],
            strata: vec![bin(0.0, 1e2), bin(1e2, 1e6), bin(1e6, f64::MAX)],
        }));
    }
    let sites = ["edges", "vertices"].into_iter().flat_map(|aim| {
        [(0.0, 1.0), (1e3, 1.0), (0.0, 1e6)].map(|(offset, scale)| Site {
            surface: "sphere".into(),
            aim: aim.into(),
            offset,
            scale,
            rays: 2000,
            no_hit: if bad > 0 { 100 } else { 0 },
            many_hits: 7,
        })
    });
    lines.push(Line::from(SurfaceCracks { variant: variant.clone(), sites: sites.collect() }));
    let clauses = [(Clause::FiniteHits, [4096, 0]), (Clause::SameDecisions, [8192, bad])];
    lines.push(Line::from(Contract { variant: variant.clone(), clauses: BTreeMap::from(clauses) }));
    for flush_to_zero in [false, true] {
        lines.push(Line::from(SpecialValues {
            variant: variant.clone(),
            flush_to_zero,
            outcomes: vec![Outcome {
                value: "NaN".into(),
                place: "origin".into(),
                tests: 48,
                hits: 0,
                false_hits: 0,
                false_misses: 0,
            }],
        }));
    }
    lines
}

#[test]
fn the_summary_adds_up() {
    let summary = stress_summary(&study());
    assert_eq!(summary.rows.len(), 4, "two methods, two precisions");
    let bad = &summary.rows[0];
    assert_eq!((bad.division, bad.pairs), (Form::Deferred, 1200));
    // Three families of levels with 0, 1, 2 and 3 on either side.
    assert_eq!((bad.false_hits, bad.false_misses, bad.wrong), (18, 18, 36));
    assert_eq!(bad.error_over_condition, Some(f64::from(3e5_f32)));
    assert_eq!((bad.edge_cracks, bad.far_cracks), (Some(50_000.0), Some(50_000.0)));
    assert_eq!((bad.scale, bad.offset), (Some([1e-14, 5e12]), Some(5e12)));
    // Of both forms.
    assert_eq!(bad.violations, 2);
    // Two methods, two precisions, two forms.
    assert_eq!(summary.contract_tests, 8 * (4096 + 8192));
    assert_eq!(summary.contract_violations, 4);
    let good = &summary.rows[2];
    assert_eq!((good.wrong, good.edge_cracks), (0, Some(0.0)));
}

#[test]
fn summary_as_text() {
    let text = Chapter::of::<Stability>().document(&study()).to_text(80);
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    insta::assert_snapshot!(text);
}

#[test]
fn the_page_leads_to_the_comparison_and_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let records = study();
    let read = |path: &std::path::Path| std::fs::read_to_string(path).expect("just written");
    let alone = Chapter::of::<Stability>().publish(&records, folder.path()).expect("it is written");
    assert!(!read(&alone.index).contains("index.html"));
    let index = Chapter::of::<Comparison>()
        .publish(&synthetic::records(2), folder.path())
        .expect("it is written");
    assert!(read(&index.index).contains("<a href=\"stress.html\">"));
    let stress =
        Chapter::of::<Stability>().publish(&records, folder.path()).expect("it is written");
    let page = read(&stress.index);
    assert!(page.contains("<a href=\"index.html\">"));
    assert!(!page.contains("Left out"), "the record holds everything");
    // Five figures, wide and narrow.
    assert_eq!(stress.figures.len(), 10);
    for figure in &stress.figures {
        let svg = read(figure);
        roxmltree::Document::parse(&svg).expect("a figure is XML");
    }
    // An SVG in HTML has no declaration of its namespace's prefixes, so only the balance is checked.
    assert_eq!(page.matches("<section").count(), page.matches("</section>").count());
    assert_eq!(page.matches("<table>").count(), page.matches("</table>").count());
}

#[test]
fn without_a_study_the_page_says_what_is_missing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = Chapter::of::<Stability>()
        .publish(&synthetic::records(2), folder.path())
        .expect("it is written");
    let text = std::fs::read_to_string(page.index).expect("just written");
    assert!(text.contains("Left out: the record holds no stability study"));
}

#[test]
fn every_part_of_a_document_is_made_anew_once() {
    let parts = [
        "stress-findings",
        "stress-f32",
        "stress-f64",
        "stress-watertight",
        "stress-contract",
        "stress-special",
        "stress-arithmetic",
    ];
    let marked =
        parts.map(|part| format!("<!-- trisect:{part} -->\nold\n<!-- end of trisect:{part} -->\n"));
    let document = marked.concat();
    let once = splice(&document, &study()).expect("there are markers");
    assert!(!once.contains("\nold\n"), "{once}");
    assert_eq!(splice(&once, &study()).expect("there are markers"), once);
    insta::assert_snapshot!(once);
}

/// The study of a method that claims to be exact as well: eight wrong answers of three kinds.
fn exact_study() -> Records {
    let mut records = study();
    let counts = ExactCounts { tests: 1024, wrong: 2, wrong_values: 1, rays: 64, wrong_closest: 1 };
    for way in ["f32x8 avx2 plain one-ray", "tree single"] {
        records.lines.push(Line::from(Exactness {
            method: "exact".to_owned(),
            precision: FloatFormat::F32,
            way: way.to_owned(),
            kinds: [("near-edge".to_owned(), counts)].into(),
            first_wrong: Some("this ray".to_owned()),
        }));
    }
    records.lines.push(Line::from(Stages {
        method: "exact".to_owned(),
        precision: FloatFormat::F32,
        source: "near-edge".to_owned(),
        stages: ["miss", "filter", "f64", "whole"].map(str::to_owned).into(),
        pairs: vec![500, 400, 99, 1],
    }));
    records
}

#[test]
fn exactness_is_summed_up() {
    let records = exact_study();
    let summary = exactness_summary(&records);
    assert_eq!((summary.ways, summary.rows.len()), (2, 1));
    assert_eq!((summary.total().tests, summary.total().all_wrong()), (2048, 8));
    assert_eq!(summary.first_wrong.as_deref(), Some("exact, f32x8 avx2 plain one-ray: this ray"));
    let says = "2,048 tests in 2 ways: 4 wrong decisions, 2 wrong values";
    for text in [summary.to_text(100), Chapter::of::<Stability>().document(&records).to_text(100)] {
        assert!(text.contains(says), "{text}");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = Chapter::of::<Stability>().publish(&records, folder.path()).expect("it is written");
    let page = std::fs::read_to_string(page.index).expect("just written");
    assert!(page.contains("Exactness") && page.contains("Stages"));
    let marked = |part| format!("<!-- trisect:{part} -->\n<!-- end of trisect:{part} -->\n");
    let document = marked("stress-exact") + &marked("stress-stages");
    let document = splice(&document, &records).expect("there are markers");
    assert!(document.contains("| `near-edge` | f32 | 2,048 | 4 | 2 | 128 | 2 |"), "{document}");
    let shares = "| `near-edge` | exact | f32 | 1,000 | 50.000 | 40.000 | 9.900 | 0.100 |";
    assert!(document.contains(shares), "{document}");
}
