//! The stability study: its summary, figures and page.

pub(crate) mod exact;
pub(crate) mod figures;
pub(crate) mod findings;
pub(crate) mod markdown;
pub(crate) mod page;
mod summary;

pub use exact::{ExactnessRow, ExactnessSummary, exactness_summary};
pub use summary::{StressRow, StressSummary, stress_summary};

use trisect_core::{FloatFormat, Form, MultiplyAdd};
use trisect_harness::record::{StressFamily, StressLevel, Variant};

use crate::view::View;

/// Families whose levels ask for something that the numbers given cannot hold, so that no method is
/// to blame: what is true of them is shown, but counts for no row.
const BEYOND: [&str; 1] = ["random-bits"];

/// Whether a variant stands for its method in tables: plain arithmetic, deferred where the method has
/// that, in the precision asked for.
fn stands_for(view: &View, variant: &Variant, method: &str, precision: FloatFormat) -> bool {
    variant.method == method
        && variant.precision == precision
        && variant.arithmetic == MultiplyAdd::Plain
        && variant.division == division(view, method)
}

/// The deferred form where the method has it, else the early one.
fn division(view: &View, method: &str) -> Form {
    let deferred = view.fact(method).is_some_and(|fact| fact.divisions.contains(&Form::Deferred));
    if deferred { Form::Deferred } else { Form::Early }
}

/// The families of the variant that stands for a method, subnormal numbers kept.
fn families<'a>(
    view: &View<'a>,
    method: &str,
    precision: FloatFormat,
) -> impl Iterator<Item = &'a StressFamily> {
    view.stress
        .iter()
        .copied()
        .filter(move |s| !s.flush_to_zero && stands_for(view, &s.variant, method, precision))
}

/// Names of the families that the record holds, in its order, with their knobs.
fn family_names<'a>(view: &View<'a>) -> Vec<(&'a str, &'a str)> {
    let mut names: Vec<(&str, &str)> = Vec::new();
    for family in &view.stress {
        if names.iter().all(|(name, _)| *name != family.family) {
            names.push((&family.family, &family.knob));
        }
    }
    names
}

fn pairs(level: &StressLevel) -> u64 {
    level.classes.values().flatten().sum()
}

/// The first level at which any answer is wrong by more than a thousandth, with its place among the
/// levels.
fn first_failure(family: &StressFamily) -> Option<(usize, &StressLevel)> {
    family.levels.iter().enumerate().find(|(_, level)| level.wrong > 0)
}
