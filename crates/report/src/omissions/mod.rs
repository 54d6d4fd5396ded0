//! What is gained by leaving out what nobody asks for: from the comparison of kernels, and from the study.

mod figures;
pub(crate) mod kernels;
pub(crate) mod markdown;
mod summary;

use trisect_harness::record::{Layer, Omission};

pub use summary::{OmissionKind, OmissionSummary, TimedOmission, omission_summary};

use crate::chapter::{Link, PageError};
use crate::page::{Drawn, Study, Titled, draw_study};
use crate::stats::geometric_mean;
use crate::view::View;

/// Where things are left out, and how that is called.
const LAYERS: [(Layer, &str); 3] =
    [(Layer::Kernel, "kernels"), (Layer::Tracer, "tracer"), (Layer::Picture, "pictures")];

/// What was left out in one place, in the record's order.
fn of_layer<'a>(view: &View<'a>, layer: Layer) -> impl Iterator<Item = &'a Omission> {
    view.omissions.iter().copied().filter(move |omission| omission.layer == layer)
}

/// All parts together, which stand behind each of them.
const EVERYTHING: &str = "everything";

/// What some things have in common, each once, in the order in which they come.
fn distinct<'a>(
    omissions: impl Iterator<Item = &'a Omission>,
    of: fn(&Omission) -> &str,
) -> Vec<&'a str> {
    let mut all = Vec::new();
    for name in omissions.map(of) {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all.sort_by_key(|name| *name == EVERYTHING);
    all
}

/// What kernels are asked for in each form of the division.
const VALUES: &str = "values";

/// The part, or for the values of kernels, which are left out in each form of the division, the form.
fn kind(omission: &Omission) -> &str {
    if omission.layer == Layer::Kernel && omission.part == VALUES {
        &omission.of
    } else {
        &omission.part
    }
}

/// Of each kind that is left out in a place, how many times as long it takes with it: every one, and their
/// geometric mean.
fn ratios<'a>(view: &View<'a>, layer: Layer) -> Vec<(&'a str, Vec<f64>, f64)> {
    let kinds = distinct(of_layer(view, layer), kind);
    let of_kind = |name| {
        let mine = of_layer(view, layer).filter(|omission| kind(omission) == name);
        let ratios: Vec<f64> = mine.filter_map(|omission| Some(omission.ratio()?.0)).collect();
        let mean = geometric_mean(ratios.iter().copied())?;
        Some((name, ratios, mean))
    };
    kinds.into_iter().filter_map(of_kind).collect()
}

/// Draws the page and its figures.
pub(crate) fn draw(view: &View, links: Vec<Link>) -> Result<Drawn, PageError> {
    let study = Study {
        title: "What is gained by leaving out what nobody asks for",
        heading: "What is left out",
        findings: markdown::all_findings(view),
        tables: vec![
            Titled::new("kernels", "Kernels", markdown::KERNELS, markdown::kernels(view)),
            Titled::new("tracer", "Tracer", markdown::TRACER, markdown::tracer(view)),
            Titled::new("pictures", "Pictures", markdown::PICTURES, markdown::pictures(view)),
        ],
        pictures: Vec::new(),
    };
    draw_study(view, links, figures::all(view), study)
}
