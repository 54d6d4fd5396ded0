//! The page of the tracer's study.

use std::path::Path;

use trisect_harness::record::Records;

use super::{figures, findings, markdown};
use crate::page::{Page, PageError, STUDY_PAGE, Study, Titled, write_study};
use crate::view::View;

/// Draws the page of the tracer's study and its figures into a folder, beside the other pages of the
/// report: it leads there, and they lead here when they are drawn again.
///
/// # Errors
/// As [`write_page`](crate::write_page).
pub fn write_study_page(records: &Records, folder: &Path) -> Result<Page, PageError> {
    let view = View::new(records);
    let study = Study {
        page: STUDY_PAGE,
        title: "Ray–triangle intersection in a ray tracer",
        heading: "In a ray tracer",
        findings: findings::findings(&view),
        tables: vec![
            Titled::new("methods", "All methods", markdown::METHODS, markdown::methods(&view)),
            Titled::new(
                "trees",
                "Builders, leaves, lanes, calls",
                markdown::TREES,
                markdown::trees(&view),
            ),
            Titled::new("threads", "Threads", markdown::THREADS, markdown::threads(&view)),
        ],
        pictures: Vec::new(),
    };
    write_study(&view, folder, figures::all(&view), study)
}
