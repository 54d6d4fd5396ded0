//! Every page in a real browser, as wide as a phone and as a desk's screen. Skipped, which is said in one line,
//! where there is no Chromium; `crates/report/install-chromium.sh` installs it.
#![cfg(unix)]

mod chromium;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use chromium::Browser;
use serde_json::{Value, json};

/// The pages of the records that the project ships.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../reports");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser");
    let mut pages = Vec::new();
    for report in ["2026-11-28-zen5", "2026-12-01-sapphire-rapids"] {
        let records = std::fs::read_dir(root.join(report)).expect("the project ships records");
        let paths = records.map(|entry| entry.expect("it can be listed").path());
        pages.extend(paths.filter(|path| path.extension().is_some_and(|e| e == "gz")).map(
            |path| {
                let records = trisect_studies::load(&path).expect("it is a record");
                let chapter = trisect_studies::chapter_of(&records);
                chapter.publish(&records, &folder.join(report)).expect("the page is written").index
            },
        ));
    }
    pages
}

/// All texts of a list.
fn texts(list: &Value) -> Vec<&str> {
    list.as_array().expect("a list").iter().filter_map(Value::as_str).collect()
}

#[test]
fn pages_work_in_a_browser() {
    let Some(program) = chromium::installed() else {
        // Past the test harness, which keeps what `eprintln` says to itself.
        let _ = writeln!(std::io::stderr(), "skipped: pages in a browser, as there is no Chromium");
        return;
    };
    let pages = pages();
    assert_eq!(pages.len(), 4 + 3, "a page for each record: {pages:?}");
    let mut browser = Browser::start(&program);
    for page in &pages {
        let bytes = std::fs::metadata(page).expect("it was written").len();
        assert!(bytes < 1_500_000, "{}: {bytes} bytes", page.display());
        for width in [390, 1280] {
            let at = format!("{} at {width} px", page.display());
            assert_eq!(browser.open(page, width), [""; 0], "{at}");
            let widths = browser.value(
                "[innerWidth, document.documentElement.scrollWidth, document.documentElement.clientWidth]",
            );
            assert_eq!(widths[0], width, "{at}");
            assert!(widths[1].as_u64() <= widths[2].as_u64(), "{at}: scrolls sideways: {widths}");
            has_text_alternatives(&mut browser, &at);
            // First of all, as the tabulator starts where something had the focus last.
            has_contents(&mut browser, &at, width < 1000);
            lights_up(&mut browser, &at);
            assert_eq!(browser.complaints(), [""; 0], "{at}");
        }
    }
}

/// Each figure has a name and a description, and each picture a name.
fn has_text_alternatives(browser: &mut Browser, at: &str) {
    let nameless = browser.value(
        r#"Array.from(document.querySelectorAll("figure svg, img")).filter((figure) => {
            if (figure.tagName === "IMG") return !figure.alt;
            const ids = (figure.getAttribute("aria-labelledby") || "").split(" ");
            const is_named = ids.length === 2 && ids.every((id) => document.getElementById(id)?.textContent);
            return !is_named || !["img", "group"].includes(figure.getAttribute("role"));
        }).map((figure) => figure.outerHTML.slice(0, 200))"#,
    );
    assert_eq!(texts(&nameless), [""; 0], "{at}: without a text alternative");
}

/// From the top of the page on, the tabulator goes through the contents, and each of them leads somewhere.
fn has_contents(browser: &mut Browser, at: &str, is_folded: bool) {
    browser.press("Tab");
    if is_folded {
        assert_eq!(browser.value("document.activeElement.tagName"), "SUMMARY", "{at}");
        browser.press("Enter");
        browser.press("Tab");
    }
    let places = browser.value(
        r#"Array.from(document.querySelectorAll("nav ol a")).map((link) => link.getAttribute("href"))"#,
    );
    let places = texts(&places);
    assert!(places.len() > 3, "{at}: {places:?}");
    for place in &places {
        let focused = browser.value(
            r#"(({ activeElement: a }) => [a.getAttribute("href"), a.getClientRects().length > 0])(document)"#,
        );
        assert_eq!(focused, json!([place, true]), "{at}: contents by keyboard");
        assert_ne!(
            browser.value(&format!("document.querySelector('{place}')")),
            Value::Null,
            "{at}"
        );
        browser.press("Tab");
    }
    let last = places.last().expect("there are some");
    browser.value(&format!("document.querySelector('nav a[href=\"{last}\"]').focus()"));
    browser.press("Enter");
    let top = browser.value(&format!(
        "[location.hash, document.querySelector('{last}').getBoundingClientRect().top < innerHeight]"
    ));
    assert_eq!(top, json!([last, true]), "{at}: Enter leads there");
}

/// A method that the pointer or the keyboard is on is lit in every figure, and all others are grey.
fn lights_up(browser: &mut Browser, at: &str) {
    const STATE: &str = r#"(() => {
        const all = Array.from(document.querySelectorAll("figure [data-method]"));
        const lit = all.filter((mark) => getComputedStyle(mark).opacity === "1");
        const methods = new Set(lit.map((mark) => mark.dataset.method));
        const method = methods.size === 1 ? methods.values().next().value : "";
        const figures = (marks) => new Set(marks.map((mark) => mark.closest("figure"))).size;
        const is_all = figures(lit) === figures(all.filter((mark) => mark.dataset.method === method));
        return { method, is_all, says: document.querySelector("output").textContent };
    })()"#;
    let first = browser.value(
        r#"(() => {
            const marks = Array.from(document.querySelectorAll("figure [data-method]"));
            const mark = marks.find((mark) => mark.getClientRects().length && mark.querySelector("circle, polygon"));
            if (!mark) return null;
            const point = mark.querySelector("circle, polygon");
            point.scrollIntoView({ block: "center" });
            const { x, y, width, height } = point.getBoundingClientRect();
            return { at: [x + width / 2, y + height / 2] };
        })()"#,
    );
    if first.is_null() {
        return;
    }
    let place = [0, 1].map(|i| first["at"][i].as_f64().expect("a place"));
    browser.point_at(place);
    let hovered = browser.value(STATE);
    let method = hovered["method"].as_str().unwrap_or_default().to_owned();
    assert!(!method.is_empty() && hovered["is_all"] == true, "{at}: hovered: {hovered}");
    assert!(
        hovered["says"].as_str().is_some_and(|says| says.starts_with(&method)),
        "{at}: {hovered}"
    );
    browser.point_at([1.0, 1.0]);
    assert_eq!(browser.value(STATE)["method"], "", "{at}: left again");

    browser.value(
        r#"Array.from(document.querySelectorAll("[data-method][tabindex='0']"))
            .find((mark) => mark.getClientRects().length).focus()"#,
    );
    let focused = browser.value(STATE);
    assert!(focused["method"] != "" && focused["is_all"] == true, "{at}: focused: {focused}");
    let last = browser.value("document.activeElement.dataset.method");
    for _ in 0..40 {
        browser.press("ArrowRight");
        if browser.value("document.activeElement.dataset.method") != last {
            break;
        }
    }
    let next = browser.value(STATE);
    assert!(next["method"] != last && next["method"] != "", "{at}: the next by an arrow: {next}");
    browser.press("Escape");
    assert_eq!(browser.value(STATE)["method"], "", "{at}: dark again");
}
