//! The comparison in numbers, for a program to read.

use std::collections::HashSet;

use crate::record::{Header, Records, Variant};
use serde::Serialize;
use trisect_kernels::Arrangement;

use super::answers::Answers;
use super::view::View;
use crate::comparison::record::Error;
use trisect_report::stats::pareto_front;

/// The outcome of a measurement in a screenful.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Who measured, where and how.
    pub header: Header,
    /// Which method to use.
    pub answers: Answers,
    /// What the errors of the front are.
    pub error_measure: ErrorMeasure,
    /// Variants that no other beats in both error and time, fastest first.
    pub front: Vec<FrontPoint>,
}

/// A variant's place in the plane of error and time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrontPoint {
    /// The variant.
    pub variant: Variant,
    /// Nanoseconds per test: geometric mean over the workloads that all variants ran.
    pub ns_per_test: f64,
    /// Error of t against the oracle, as `error_measure` says.
    pub error: f64,
}

/// What the error is that stands against run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorMeasure {
    /// The largest, over the condition number times the unit roundoff: small where a method errs no more than
    /// its input allows.
    OverCondition,
    /// The 99th percentile, relative: what records older than condition numbers have.
    Relative,
}

/// A point for each variant that computes values of its own, fastest first, and the workloads of all: of
/// variants that differ only in arrangement and early-out, the fastest; none of what does not take every
/// workload.
pub(crate) fn plane<'a>(view: &View<'a>) -> (Vec<FrontPoint>, ErrorMeasure, Vec<&'a str>) {
    let measured = view.all::<Error>().any(|error| error.over_condition.is_some());
    let measure = if measured { ErrorMeasure::OverCondition } else { ErrorMeasure::Relative };
    let Some(need) = view.main_need() else { return (Vec::new(), measure, Vec::new()) };
    let comparable = view.comparable(|v| v.needs == need && !view.is_refused(v));
    let mut seen = HashSet::new();
    let fastest = comparable.scores().into_iter().filter(|(v, _)| {
        let values = Variant { arrangement: Arrangement::OneRay, early_out: false, ..(*v).clone() };
        seen.insert(values)
    });
    let points = fastest.filter_map(|(v, ns_per_test)| {
        let error = match measure {
            ErrorMeasure::OverCondition => view.over_condition(v, "t")?.max,
            ErrorMeasure::Relative => view.error(v, "t")?.p99,
        };
        Some(FrontPoint { variant: v.clone(), ns_per_test, error })
    });
    (points.collect(), measure, comparable.workloads)
}

/// Sums up what was measured.
pub fn summary(records: &Records) -> Summary {
    let view = View::new(records);
    let (points, error_measure, _) = plane(&view);
    let at: Vec<(f64, f64)> = points.iter().map(|p| (p.ns_per_test, p.error)).collect();
    Summary {
        header: records.header.clone(),
        answers: Answers::of(&view),
        error_measure,
        front: pareto_front(&at).into_iter().map(|place| points[place].clone()).collect(),
    }
}
