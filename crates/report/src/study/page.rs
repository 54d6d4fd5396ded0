//! The page of the tracer's study.

use super::{figures, findings, markdown};
use crate::chapter::{Link, PageError};
use crate::page::{Drawn, Study, Titled, draw_study};
use crate::view::View;

/// Draws the page and its figures.
pub(crate) fn draw(view: &View, links: Vec<Link>) -> Result<Drawn, PageError> {
    let study = Study {
        title: "Ray–triangle intersection in a ray tracer",
        heading: "In a ray tracer",
        findings: findings::findings(view),
        tables: vec![
            Titled::new("methods", "All methods", markdown::METHODS, markdown::methods(view)),
            Titled::new(
                "trees",
                "Builders, leaves, lanes, calls",
                markdown::TREES,
                markdown::trees(view),
            ),
            Titled::new("threads", "Threads", markdown::THREADS, markdown::threads(view)),
        ],
        pictures: Vec::new(),
    };
    draw_study(view, links, figures::all(view), study)
}
