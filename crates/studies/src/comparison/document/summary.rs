//! The comparison in numbers, for a program to read.

use crate::comparison::record::Quantiles;
use crate::record::{Header, Records, Variant};
use serde::Serialize;
use trisect_core::FloatFormat;
use trisect_kernels::Arrangement;

use super::answers::Answers;
use super::view::View;
use trisect_report::format::mtests;
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
    /// One row per method, by year.
    pub methods: Vec<MethodRow>,
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

/// What was found about one method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodRow {
    /// Name in the catalogue.
    pub method: String,
    /// Year of publication, where recorded.
    pub year: Option<u16>,
    /// Per precision, single before double.
    pub precisions: Vec<PrecisionRow>,
}

/// What was found about one method in one precision.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PrecisionRow {
    /// `f32` or `f64`.
    pub precision: FloatFormat,
    /// Bytes of prepared data per triangle.
    pub bytes_per_triangle: Option<usize>,
    /// The fastest variant for the fullest need that was timed.
    pub fastest: Option<Variant>,
    /// Its million tests per second.
    pub million_tests_per_second: Option<f64>,
    /// Relative error of t against the oracle: medians over variants and workloads, and the
    /// largest maximum.
    pub error_of_t: Option<Quantiles>,
    /// False hits and false misses per million pairs.
    pub wrong_per_million: Option<f64>,
    /// Nanoseconds to prepare one triangle.
    pub preparation_ns: Option<f64>,
}

/// The variants in the plane of error and time, and which of them are on the front.
pub(crate) struct Plane {
    pub(crate) points: Vec<FrontPoint>,
    /// Indices into `points`, fastest first.
    pub(crate) front: Vec<usize>,
    pub(crate) workloads: Vec<String>,
}

/// A point for each variant that computes values of its own: of variants that differ only in
/// arrangement and early-out, the fastest.
pub(crate) fn plane(view: &View) -> Plane {
    let Some(need) = view.main_need() else {
        return Plane { points: Vec::new(), front: Vec::new(), workloads: Vec::new() };
    };
    let comparable = view.comparable(|v| v.needs == need);
    let mut seen = std::collections::HashSet::new();
    let points: Vec<FrontPoint> = comparable
        .scores()
        .into_iter()
        .filter(|(v, _)| {
            let mut values = (*v).clone();
            values.arrangement = Arrangement::OneRay;
            values.early_out = false;
            seen.insert(values)
        })
        .filter_map(|(v, ns)| {
            let error = view.error(v, "t")?.p99;
            Some(FrontPoint { variant: v.clone(), ns_per_test: ns, error })
        })
        .collect();
    let at: Vec<(f64, f64)> = points.iter().map(|p| (p.ns_per_test, p.error)).collect();
    let front = pareto_front(&at);
    let workloads = comparable.workloads.iter().map(ToString::to_string).collect();
    Plane { points, front, workloads }
}

/// Sums up what was measured.
pub fn summary(records: &Records) -> Summary {
    of_view(&View::new(records))
}

pub(crate) fn of_view(view: &View) -> Summary {
    let plane = plane(view);
    let main = view.main_need().map(|need| view.comparable(|v| v.needs == need).scores());
    let scores = main.unwrap_or_default();
    let methods = view
        .methods()
        .iter()
        .map(|&method| MethodRow {
            method: method.into(),
            year: view.fact(method).map(|m| m.year),
            precisions: view
                .precisions()
                .into_iter()
                .map(|precision| precision_row(view, &scores, method, precision))
                .collect(),
        })
        .collect();
    Summary {
        header: view.records.header.clone(),
        answers: Answers::of(view),
        front: plane.front.iter().map(|&i| plane.points[i].clone()).collect(),
        methods,
    }
}

fn precision_row(
    view: &View,
    scores: &[(&Variant, f64)],
    method: &str,
    precision: FloatFormat,
) -> PrecisionRow {
    let mine = |v: &Variant| v.method == method && v.precision == precision;
    let fastest = scores.iter().find(|(v, _)| mine(v));
    PrecisionRow {
        precision,
        bytes_per_triangle: view.bytes(method, precision),
        fastest: fastest.map(|(v, _)| (*v).clone()),
        million_tests_per_second: fastest.map(|&(_, ns)| mtests(ns)),
        error_of_t: view.pooled_error((method, precision), "t", |_| true),
        wrong_per_million: view.wrong_per_million((method, precision), |_| true),
        preparation_ns: view.preparation(method, precision),
    }
}
