//! The study of the tracer in numbers, for a program to read.

use std::collections::BTreeMap;

use crate::record::{Header, Records};
use crate::tracer::record::Contest;
use serde::Serialize;

use super::select::{classes, kernel_gain, kernel_ns, middle, speed, traced, tracer_gain, trees};
use crate::comparison::document::view::View;
use trisect_report::format::mtests;
use trisect_report::stats::{geometric_mean, line};

/// The study of the tracer in a screenful.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudySummary {
    /// Who studied, where and how.
    pub header: Header,
    /// A row per method, by year.
    pub rows: Vec<StudyRow>,
    /// What part of a kernel's gain, as a power, is left in single rays for their closest hits: 1 where
    /// a tracer gains as much as its kernel does, 0 where it gains nothing.
    pub survives: Option<f64>,
    /// The correlation of both gains' logarithms over methods.
    pub correlation: Option<f64>,
}

/// What was found about one method, on one thread.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyRow {
    /// Name in the catalogue.
    pub method: String,
    /// Million tests per second of the kernel alone, asked for the fullest hit.
    pub kernel_million_tests_per_second: Option<f64>,
    /// Its speed over that of Möller–Trumbore's.
    pub kernel_gain: Option<f64>,
    /// Million single rays per second by class, geometric mean over scenes.
    pub single: BTreeMap<String, f64>,
    /// The same of rays in packets.
    pub packets: BTreeMap<String, f64>,
    /// Speed of single rays over that of Möller–Trumbore's, geometric mean over scenes and classes.
    pub single_gain: Option<f64>,
    /// The same of rays in packets.
    pub packet_gain: Option<f64>,
    /// Speed of single rays with the test inside the traversal loop over that with a call for each leaf,
    /// for the methods that are compiled both ways.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inline_single: Option<f64>,
    /// The same of rays in packets.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inline_packets: Option<f64>,
    /// Milliseconds to build the trees of all scenes.
    pub build_ms: Option<f64>,
    /// Bytes of the trees of all scenes per triangle.
    pub bytes_per_triangle: Option<f64>,
    /// Rays per million, over scenes, classes and ways to trace, whose decision differs from the same
    /// method's in plain arithmetic.
    pub differ_per_million: f64,
}

/// Sums up what was studied.
pub fn study_summary(records: &Records) -> StudySummary {
    of_view(&View::new(records))
}

pub(super) fn of_view(view: &View) -> StudySummary {
    let took_part = |method: &str| traced(view, Contest::Methods).any(|t| t.method == method);
    let methods = view.methods().iter().filter(|method| took_part(method));
    let rows: Vec<StudyRow> = methods.map(|method| row(view, method)).collect();
    let (survives, correlation) = survival(view, "single", false).unzip();
    StudySummary { header: view.records.header.clone(), rows, survives, correlation }
}

fn row(view: &View, method: &str) -> StudyRow {
    let by_class = |tracing: &str| {
        let of = |class: &str| {
            let mine = traced(view, Contest::Methods)
                .filter(|t| t.method == method && t.tracing == tracing && t.class == class);
            geometric_mean(mine.filter_map(speed))
        };
        let classes = classes(view).into_iter();
        classes.filter_map(|class| Some((class.to_owned(), of(class)?))).collect()
    };
    let mine = || trees(view, Contest::Methods).filter(|tree| tree.method == method);
    let build: Option<f64> = mine().map(|tree| middle(&tree.samples_ns)).sum();
    let (bytes, triangles) =
        mine().fold((0, 0), |sum, tree| (sum.0 + tree.bytes, sum.1 + tree.triangles));
    let (rays, differ) = traced(view, Contest::Methods)
        .filter(|t| t.method == method)
        .fold((0, 0), |sum, t| (sum.0 + t.rays, sum.1 + t.differ));
    let gain = |contest, tracing| tracer_gain(view, contest, method, tracing, |_| true);
    StudyRow {
        method: method.to_owned(),
        kernel_million_tests_per_second: kernel_ns(view, method, false).map(mtests),
        kernel_gain: kernel_gain(view, method, false),
        single: by_class("single"),
        packets: by_class("packets"),
        single_gain: gain(Contest::Methods, "single"),
        packet_gain: gain(Contest::Methods, "packets"),
        inline_single: gain(Contest::Inline, "single"),
        inline_packets: gain(Contest::Inline, "packets"),
        build_ms: build.filter(|_| triangles > 0).map(|ns| ns / 1e6),
        bytes_per_triangle: (triangles > 0).then(|| bytes as f64 / triangles as f64),
        differ_per_million: differ as f64 * 1e6 / rays.max(1) as f64,
    }
}

/// The gain of each method's kernel and that of its tracer.
pub(super) fn gains<'a>(view: &View<'a>, tracing: &str, any: bool) -> Vec<(&'a str, (f64, f64))> {
    let both = |method: &'a str| {
        let kernel = kernel_gain(view, method, any)?;
        Some((
            method,
            (kernel, tracer_gain(view, Contest::Methods, method, tracing, |t| t.any == any)?),
        ))
    };
    view.methods().iter().filter_map(|&method| both(method)).collect()
}

/// The slope of the tracer's gain over the kernel's, both as logarithms, and their correlation.
pub(super) fn survival(view: &View, tracing: &str, any: bool) -> Option<(f64, f64)> {
    let logs: Vec<(f64, f64)> =
        gains(view, tracing, any).into_iter().map(|(_, (x, y))| (x.ln(), y.ln())).collect();
    // Through two points there is always a line.
    (logs.len() > 2).then(|| line(&logs)).flatten()
}
