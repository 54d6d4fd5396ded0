//! The figure of the study of omissions.

use super::{LAYERS, ratios};
use crate::chart::{Axis, Drawing, Group, Look, Mark, Panel, Row, Rows, Scale, Shape};
use crate::figures::Figure;
use crate::format::ratio;
use crate::view::View;

/// All figures, in the order of the page.
pub(super) fn all(view: &View) -> Vec<Figure> {
    vec![costs(view)]
}

/// A row for each kind of what is left out, a point for each method, or scene and what is done with it.
fn costs(view: &View) -> Figure {
    let panels: Vec<Panel> = LAYERS
        .into_iter()
        .enumerate()
        .filter_map(|(number, (layer, name))| {
            let kinds = ratios(view, layer);
            let values = kinds.iter().flat_map(|(_, all, _)| all).copied().chain([1.0]);
            let axis = Axis::over("times as long with it", Scale::Log, values, ratio);
            let as_row = |(kind, all, mean): &(&str, Vec<f64>, f64)| Row {
                label: (*kind).to_owned(),
                ink: Look::of(number).ink,
                marks: all
                    .iter()
                    .map(|&at| Mark::Point { at, shape: Shape::Circle, filled: false })
                    .chain([Mark::Point { at: *mean, shape: Shape::Diamond, filled: true }])
                    .collect(),
                note: ratio(*mean),
            };
            let rows: Vec<Row> = kinds.iter().map(as_row).collect();
            let group = Group { heading: String::new(), rows };
            let is_empty = kinds.is_empty();
            (!is_empty).then(|| Panel::Rows(Rows::new(name, axis, Some(1.0), vec![group])))
        })
        .collect();
    Figure {
        name: "omissions-costs",
        title: "What it takes to keep what nobody asks for",
        caption: "Time with it over time without, each the median over rounds in which both were timed. \
                  Hollow: of kernels a method each, in the tracer a class of rays through a scene, of \
                  pictures a scene. Filled, with its number: their geometric mean. On the line it costs \
                  nothing."
            .into(),
        drawing: if panels.is_empty() {
            Err("Left out: the record holds no omissions; make one with `trisect omissions`.".into())
        } else {
            Ok(Drawing { panels, ..Drawing::default() })
        },
    }
}
