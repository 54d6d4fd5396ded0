//! The comparison in numbers, for a program to read.

use std::collections::HashSet;

use crate::record::{Header, Records, Variant};
use serde::Serialize;
use trisect_kernels::Arrangement;

use super::answers::Answers;
use super::view::View;
use trisect_report::stats::pareto_front;

/// The outcome of a measurement in a screenful.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Who measured, where and how.
    pub header: Header,
    /// Which method to use.
    pub answers: Answers,
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
    /// Relative error of t against the oracle, 99th percentile.
    pub error: f64,
}

/// A point for each variant that computes values of its own, fastest first, and the workloads of all: of
/// variants that differ only in arrangement and early-out, the fastest; none of what does not take every
/// workload.
pub(crate) fn plane<'a>(view: &View<'a>) -> (Vec<FrontPoint>, Vec<&'a str>) {
    let Some(need) = view.main_need() else { return (Vec::new(), Vec::new()) };
    let comparable = view.comparable(|v| v.needs == need && !view.is_refused(v));
    let mut seen = HashSet::new();
    let fastest = comparable.scores().into_iter().filter(|(v, _)| {
        let values = Variant { arrangement: Arrangement::OneRay, early_out: false, ..(*v).clone() };
        seen.insert(values)
    });
    let points = fastest.filter_map(|(v, ns_per_test)| {
        let error = view.error(v, "t")?.p99;
        Some(FrontPoint { variant: v.clone(), ns_per_test, error })
    });
    (points.collect(), comparable.workloads)
}

/// Sums up what was measured.
pub fn summary(records: &Records) -> Summary {
    let view = View::new(records);
    let (points, _) = plane(&view);
    let at: Vec<(f64, f64)> = points.iter().map(|p| (p.ns_per_test, p.error)).collect();
    Summary {
        header: records.header.clone(),
        answers: Answers::of(&view),
        front: pareto_front(&at).into_iter().map(|place| points[place].clone()).collect(),
    }
}
