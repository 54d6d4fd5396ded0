//! What the report says and draws, from records that were never measured.

mod synthetic;

use std::collections::BTreeMap;
use std::path::Path;

use trisect_harness::record::{Quantiles, Record, Records};
use trisect_report::{Filter, compare, rank, stats, summary, write_page};

/// Draws into a folder that lasts as long as the test binary's target folder, to be looked at.
fn page(records: &Records, name: &str) -> String {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let page = write_page(records, &folder).expect("the page is written");
    std::fs::read_to_string(page.index).expect("the page is there")
}

#[test]
fn draw() {
    page(&synthetic::records(4), "page");
}
