//! The study of pictures as text, page and documents, from records that were never measured.

#[allow(dead_code, reason = "each test file uses some of it")]
mod synthetic;

use trisect_studies::Chapter;
use trisect_studies::comparison::Comparison;
use trisect_studies::pictures::Pictures;
use trisect_studies::pictures::picture_summary;
use trisect_studies::pictures::{FrameSeries, Frames, Picture};
use trisect_studies::record::{Line, Records};
use trisect_studies::splice;

fn frames(series: FrameSeries, name: &str, ms: u64) -> Frames {
    Frames {
        series,
        name: name.into(),
        scene: "mirror".into(),
        method: "moller-trumbore".into(),
        width: 640,
        height: 480,
        samples: 1,
        depth: 16,
        lights: 1,
        threads: 2,
        tile: 64,
        leaves: "cheapest".into(),
        triangles: 10_817,
        rays: 600_000,
        // The median counts, not the mean.
        samples_ns: vec![ms * 1_000_000, ms * 900_000, ms * 9_000_000],
    }
}

fn study() -> Records {
    let mut records = synthetic::records(1);
    let mut add = |frames| records.lines.push(Line::from(frames));
    add(frames(FrameSeries::Goal, "goal", 25));
    for (width, height) in [(512, 512), (1920, 1080)] {
        for (place, level) in (1..).zip(["low", "middle", "hard", "very hard"]) {
            let ms = u64::from(width * height) / 10_000 * place;
            add(Frames { width, height, ..frames(FrameSeries::Sizes, level, ms) });
        }
    }
    for (name, ms) in [("1", 50), ("2", 25)] {
        add(frames(FrameSeries::Threads, name, ms));
        add(frames(FrameSeries::Depth, name, ms / 5));
    }
    for (name, ms) in [("cheapest", 25), ("16", 26), ("32", 40)] {
        add(frames(FrameSeries::Leaves, name, ms));
    }
    for (name, ms, threads) in [
        ("every triangle, scalar, one thread", 8000, 1),
        ("tree", 40, 1),
        ("SIMD", 8, 1),
        ("threads", 4, 2),
    ] {
        add(Frames { threads, ..frames(FrameSeries::Techniques, name, ms) });
    }
    add(Frames { method: "wald".into(), ..frames(FrameSeries::Techniques, "kernel", 2) });
    records.lines.push(Line::from(Picture {
        name: "Mirrors".into(),
        says: "A ball & a chair.".into(),
        width: 320,
        height: 240,
        png: "iVBORw0KGgo=".into(),
    }));
    records
}

#[test]
fn gains_are_multiplied_up() {
    let summary = picture_summary(&study());
    let gains: Vec<f64> = summary.techniques.iter().map(|technique| technique.gain).collect();
    assert_eq!(gains, [1.0, 200.0, 5.0, 2.0, 2.0]);
    assert!((summary.techniques[4].together - 4000.0).abs() < 1e-6);
    assert_eq!(summary.goal.expect("it is there").frames_per_second, 40.0);
}

#[test]
fn summary_as_text() {
    insta::assert_snapshot!(Chapter::of::<Pictures>().document(&study()).to_text(80));
}

#[test]
fn a_page_shows_figures_tables_and_pictures_and_leads_to_the_others() {
    let folder = tempfile::tempdir().expect("a folder");
    Chapter::of::<Comparison>().publish(&study(), folder.path()).expect("it is written");
    let page = Chapter::of::<Pictures>().publish(&study(), folder.path()).expect("it is written");
    assert_eq!(page.figures.len(), 4, "two figures, wide and narrow");
    let html = std::fs::read_to_string(&page.index).expect("it is there");
    for part in [
        "data:image/png;base64,iVBORw0KGgo=",
        "A ball &amp; a chair.",
        "40.0 frames per second",
        "4,000 times as fast as the plain tracer",
        "href=\"index.html\"",
        "id=\"pictures-series\"",
    ] {
        assert!(html.contains(part), "{part}");
    }
}

#[test]
fn tables_go_into_documents() {
    let document = "<!-- trisect:pictures-techniques -->\n<!-- end of trisect:pictures-techniques -->\n\
                    <!-- trisect:pictures-sizes -->\n<!-- end of trisect:pictures-sizes -->\n\
                    <!-- trisect:pictures-findings -->\n<!-- end of trisect:pictures-findings -->\n";
    let spliced = splice(document, &study()).expect("its markers are sound");
    assert!(
        spliced.contains("| `kernel` | wald | 2 |") || spliced.contains("| kernel | wald | 2 |"),
        "{spliced}"
    );
    assert!(spliced.contains("very hard 1/16/1"), "{spliced}");
    assert_eq!(splice(&spliced, &study()).expect("still"), spliced);
}
