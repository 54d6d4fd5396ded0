//! The study of pictures: its summary, figures and page.

mod figures;
pub(crate) mod markdown;
mod summary;

use std::path::Path;

use trisect_harness::record::{FrameSeries, Frames, Records};

pub use summary::{PictureSummary, Technique, TimedFrame, picture_summary};

use crate::page::{PICTURES_PAGE, Page, PageError, Study, Titled, write_study};
use crate::stats::median;
use crate::view::View;

/// Pictures of a series, in the record's order.
fn series<'a>(view: &View<'a>, series: FrameSeries) -> impl Iterator<Item = &'a Frames> {
    view.frames.iter().copied().filter(move |frames| frames.series == series)
}

/// Frames per second: of the median time.
fn speed(frames: &Frames) -> Option<f64> {
    let samples: Vec<f64> = frames.samples_ns.iter().map(|&ns| ns as f64).collect();
    median(&samples).filter(|&ns| ns > 0.0).map(|ns| 1e9 / ns)
}

/// Draws the page of the study of pictures and its figures into a folder, beside the other pages of the
/// report: it leads there, and they lead here when they are drawn again.
///
/// # Errors
/// As [`write_page`](crate::write_page).
pub fn write_pictures_page(records: &Records, folder: &Path) -> Result<Page, PageError> {
    let view = View::new(records);
    let study = Study {
        page: PICTURES_PAGE,
        title: "Pictures, and what they cost",
        heading: "Pictures",
        findings: markdown::all_findings(&view),
        pictures: view.pictures.iter().copied().cloned().collect(),
        tables: vec![
            Titled::new(
                "techniques",
                "What each technique gains",
                markdown::techniques_say(&view),
                markdown::techniques(&view),
            ),
            Titled::new("sizes", "Sizes and levels", markdown::SIZES, markdown::sizes(&view)),
            Titled::new(
                "series",
                "One thing at a time",
                markdown::one_at_a_time_says(&view),
                markdown::one_at_a_time(&view),
            ),
        ],
    };
    write_study(&view, folder, figures::all(&view), study)
}
