//! The study of pictures: its summary, figures and page.

mod figures;
pub(crate) mod markdown;
mod summary;

use trisect_harness::record::{FrameSeries, Frames};

pub use summary::{PictureSummary, Technique, TimedFrame, picture_summary};

use crate::chapter::{Link, PageError};
use crate::page::{Drawn, Study, Titled, draw_study};
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

/// Draws the page and its figures.
pub(crate) fn draw(view: &View, links: Vec<Link>) -> Result<Drawn, PageError> {
    let study = Study {
        title: "Pictures, and what they cost",
        heading: "Pictures",
        findings: markdown::all_findings(view),
        pictures: view.pictures.iter().copied().cloned().collect(),
        tables: vec![
            Titled::new(
                "techniques",
                "What each technique gains",
                markdown::techniques_say(view),
                markdown::techniques(view),
            ),
            Titled::new("sizes", "Sizes and levels", markdown::SIZES, markdown::sizes(view)),
            Titled::new(
                "series",
                "One thing at a time",
                markdown::one_at_a_time_says(view),
                markdown::one_at_a_time(view),
            ),
        ],
    };
    draw_study(view, links, figures::all(view), study)
}
