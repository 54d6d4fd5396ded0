//! The study of omissions as text, page and documents, from records that were never measured.

#[allow(dead_code, reason = "each test file uses some of it")]
mod synthetic;

use trisect_studies::Chapter;
use trisect_studies::comparison::Comparison;
use trisect_studies::omissions::Omissions;
use trisect_studies::omissions::omission_summary;
use trisect_studies::omissions::{Code, Layer, Omission};
use trisect_studies::record::{Line, Records};
use trisect_studies::splice;

fn omission(layer: Layer, [part, scene, of, method]: [&str; 4], times: u64) -> Line {
    Line::from(Omission {
        layer,
        part: part.into(),
        scene: scene.into(),
        of: of.into(),
        method: method.into(),
        // The machine slows down, which happens to both.
        without_ns: vec![1000, 2000, 4000],
        with_ns: vec![10 * times, 20 * times, 44 * times],
    })
}

fn study() -> Records {
    let mut records = synthetic::records(1);
    records.lines.clear();
    let kernel =
        |of, method, times| omission(Layer::Kernel, ["values", "random", of, method], times);
    let traced = |part, scene, of, times| {
        omission(Layer::Tracer, [part, scene, of, "moller-trumbore"], times)
    };
    let drawn = |part, scene, of, times| {
        omission(Layer::Picture, [part, scene, of, "moller-trumbore"], times)
    };
    records.lines.extend([
        kernel("deferred", "wald", 120),
        kernel("deferred", "plucker", 99),
        kernel("early", "wald", 101),
        traced("values", "bunny", "primary", 200),
        traced("values", "hall", "primary", 100),
        traced("same-bits", "bunny", "primary", 150),
        drawn("onward", "glass.toml", "depth 0, lights 0", 110),
        drawn("everything", "glass.toml", "depth 0, lights 0", 125),
        drawn("everything", "room.toml", "depth 16, lights 1", 105),
        Line::from(Code {
            of: "renderer".into(),
            instances: 17,
            bytes: 150_000,
            of_bytes: 30_000_000,
        }),
    ]);
    records
}

#[test]
fn ratios_are_those_of_rounds() {
    let summary = omission_summary(&study());
    assert_eq!((summary.omissions[0].ratio, summary.omissions[0].quartiles), (1.2, [1.2, 1.26]));
    let kinds: Vec<_> = summary.kinds.iter().map(|kind| (kind.layer, kind.kind.as_str())).collect();
    assert_eq!(
        kinds,
        [
            ("kernels", "deferred"),
            ("kernels", "early"),
            ("tracer", "values"),
            ("tracer", "same-bits"),
            ("pictures", "onward"),
            ("pictures", "everything"),
        ]
    );
    let values = &summary.kinds[2];
    assert!((values.mean - 2.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!((values.least, values.most), (1.0, 2.0));
    assert_eq!(summary.code[0].instances, 17);
}

#[test]
fn summary_as_text() {
    insta::assert_snapshot!(Chapter::of::<Omissions>().document(&study()).to_text(80));
}

#[test]
fn a_page_shows_figure_and_tables_and_leads_to_the_others() {
    let folder = tempfile::tempdir().expect("a folder");
    Chapter::of::<Comparison>().publish(&study(), folder.path()).expect("it is written");
    let page = Chapter::of::<Omissions>().publish(&study(), folder.path()).expect("it is written");
    assert_eq!(page.figures.len(), 2, "one figure, wide and narrow");
    let html = std::fs::read_to_string(&page.index).expect("it is there");
    for part in [
        "href=\"index.html\"",
        "id=\"omissions-costs\"",
        "1 of them are faster without",
        "from 0.99× (plucker) to 1.20× (wald)",
        "17 of the renderer",
        "146 KiB of machine code",
        "1.25× (1.25–1.31)",
        "needed",
    ] {
        assert!(html.contains(part), "{part}");
    }
}

#[test]
fn every_part_of_a_document_is_made_of_its_own_record() {
    let parts = ["-findings", "-kernels", "-tracer", "-pictures"].map(|part| {
        format!("<!-- trisect:omissions{part} -->\n<!-- end of trisect:omissions{part} -->\n\n")
    });
    let empty = parts.concat();
    let of_study = splice(&empty, &study()).expect("its markers are sound");
    assert!(of_study.contains("| `plucker` | 0.99× (0.99–1.04) | – |"), "{of_study}");
    assert!(of_study.contains("| `hall, primary` | 1.00× (1.00–1.05) | – |"), "{of_study}");
    assert!(
        of_study.contains("| `room.toml, depth 16, lights 1` | needed | 1.05× (1.05–1.10) |"),
        "{of_study}"
    );
    assert_eq!(splice(&of_study, &study()).expect("still"), of_study);
    let none = splice(&of_study, &synthetic::records(1)).expect_err("a comparison has other parts");
    assert!(none.to_string().contains("methods"), "{none}");
}
