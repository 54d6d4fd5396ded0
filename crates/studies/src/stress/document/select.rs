//! What of a record stands for a method, and how levels are written.

use crate::record::Variant;
use crate::stress::record::{StressFamily, StressLevel};
use trisect_core::{FloatFormat, MultiplyAdd};
use trisect_method::Form;

use crate::comparison::document::view::View;
use crate::lines::distinct;
use trisect_report::format::tick;

/// Families whose levels ask for something that the numbers given cannot hold, so that no method is
/// to blame: what is true of them is shown, but counts for no row.
pub(super) const BEYOND: [&str; 1] = ["random-bits"];

/// Whether a variant stands for its method in tables: plain arithmetic, deferred where the method has
/// that, in the precision asked for.
pub(super) fn stands_for(
    view: &View,
    variant: &Variant,
    method: &str,
    precision: FloatFormat,
) -> bool {
    variant.method == method
        && variant.precision == precision
        && variant.arithmetic == MultiplyAdd::Plain
        && variant.division == division(view, method)
}

/// The deferred form where the method has it, else the early one.
pub(super) fn division(view: &View, method: &str) -> Form {
    let deferred = view.fact(method).is_some_and(|fact| fact.divisions.contains(&Form::Deferred));
    if deferred { Form::Deferred } else { Form::Early }
}

/// The families of the variant that stands for a method, subnormal numbers kept.
pub(super) fn families<'a>(
    view: &View<'a>,
    method: &str,
    precision: FloatFormat,
) -> impl Iterator<Item = &'a StressFamily> {
    view.all::<StressFamily>()
        .filter(move |s| !s.flush_to_zero && stands_for(view, &s.variant, method, precision))
}

/// Names of the families that the record holds, in its order, with their knobs.
pub(super) fn family_names<'a>(view: &View<'a>) -> Vec<(&'a str, &'a str)> {
    let all = view.all::<StressFamily>();
    distinct(all.map(|family| (family.family.as_str(), family.knob.as_str())))
}

pub(super) fn pairs(level: &StressLevel) -> u64 {
    level.classes.values().flatten().sum()
}

/// The first level at which any answer is wrong by more than a thousandth, with its place among the
/// levels.
pub(super) fn first_failure(family: &StressFamily) -> Option<(usize, &StressLevel)> {
    family.levels.iter().enumerate().find(|(_, level)| level.wrong > 0)
}

/// A level, short.
pub(super) fn level_text(level: f64) -> String {
    if level == 0.0 || (1.0..1000.0).contains(&level) { tick(level) } else { magnitude(level) }
}

/// An order of magnitude, rounded down in digits that fit a narrow column.
pub(super) fn magnitude(x: f64) -> String {
    format!("{x:.0e}")
}

/// Beyond this a distance or an offset has no end: triangles are points before.
pub(super) const ENDLESS: f64 = 1e30;

/// A distance or an offset.
pub(super) fn far(x: f64) -> String {
    if x < ENDLESS { magnitude(x) } else { "any".to_owned() }
}
