//! What of a record is left out, by kind.

use crate::omissions::record::{Layer, Omission};
use crate::record::Records;

use crate::lines::distinct;
use trisect_report::stats::geometric_mean;

/// Where things are left out, and how that is called.
pub(super) const LAYERS: [(Layer, &str); 3] =
    [(Layer::Kernel, "kernels"), (Layer::Tracer, "tracer"), (Layer::Picture, "pictures")];

/// What was left out in one place, in the record's order.
pub(super) fn of_layer(records: &Records, layer: Layer) -> impl Iterator<Item = &Omission> {
    records.all::<Omission>().filter(move |omission| omission.layer == layer)
}

/// All parts together, which stand behind each of them.
const EVERYTHING: &str = "everything";

/// What some things have in common, everything last.
pub(super) fn names<'a>(all: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names = distinct(all);
    names.sort_by_key(|name| *name == EVERYTHING);
    names
}

/// What kernels are asked for in each form of the division.
const VALUES: &str = "values";

/// The part, or for the values of kernels, which are left out in each form of the division, the form.
pub(super) fn kind(omission: &Omission) -> &str {
    if omission.layer == Layer::Kernel && omission.part == VALUES {
        &omission.of
    } else {
        &omission.part
    }
}

/// Of each kind that is left out in a place, how many times as long it takes with it: every one, and their
/// geometric mean.
pub(super) fn ratios(records: &Records, layer: Layer) -> Vec<(&str, Vec<f64>, f64)> {
    let of_kind = |name| {
        let mine = of_layer(records, layer).filter(|omission| kind(omission) == name);
        let ratios: Vec<f64> = mine.filter_map(|omission| Some(omission.ratio()?.0)).collect();
        let mean = geometric_mean(ratios.iter().copied())?;
        Some((name, ratios, mean))
    };
    names(of_layer(records, layer).map(kind)).into_iter().filter_map(of_kind).collect()
}
