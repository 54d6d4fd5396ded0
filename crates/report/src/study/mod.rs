//! The study of the tracer: its summary, figures and page.

mod figures;
mod findings;
pub(crate) mod markdown;
pub(crate) mod page;
mod summary;

pub use summary::{StudyRow, StudySummary, study_summary};

use trisect_core::Output;
use trisect_harness::record::{Contest, Traced, TreeBuilt};

use crate::markdown::fastest;
use crate::stats::{geometric_mean, median};
use crate::view::{BASELINE, View};

/// The median of times.
fn middle(samples_ns: &[u64]) -> Option<f64> {
    let samples: Vec<f64> = samples_ns.iter().map(|&ns| ns as f64).collect();
    median(&samples).filter(|&ns| ns > 0.0)
}

/// Million rays per second.
fn speed(traced: &Traced) -> Option<f64> {
    Some(traced.rays as f64 * 1e3 / middle(&traced.samples_ns)?)
}

/// How much faster than what went in turn with it: the median over the rounds of the ratio in each.
fn faster(traced: &[u64], beside: &[u64]) -> Option<f64> {
    let pairs = beside.iter().zip(traced).filter(|(_, mine)| **mine > 0);
    let ratios: Vec<f64> = pairs.map(|(beside, mine)| *beside as f64 / *mine as f64).collect();
    median(&ratios).filter(|&ratio| ratio > 0.0)
}

/// What was traced of a contest.
fn traced<'a>(view: &View<'a>, contest: Contest) -> impl Iterator<Item = &'a Traced> {
    view.traced.iter().copied().filter(move |traced| traced.contest == contest)
}

/// The trees of a contest.
fn trees<'a>(view: &View<'a>, contest: Contest) -> impl Iterator<Item = &'a TreeBuilt> {
    view.trees.iter().copied().filter(move |tree| tree.contest == contest)
}

/// What of a list is different, in its order.
fn distinct<'a>(all: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for name in all {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Classes of rays, in the record's order.
fn classes<'a>(view: &View<'a>) -> Vec<&'a str> {
    distinct(view.traced.iter().map(|traced| traced.class.as_str()))
}

/// Scenes, in the record's order.
fn scenes<'a>(view: &View<'a>) -> Vec<&'a str> {
    distinct(view.traced.iter().map(|traced| traced.scene.as_str()))
}

/// Nanoseconds of a test in a method's kernel that is as the tracer's, asked for any hit or for the
/// fullest one.
fn kernel_ns(view: &View, method: &str, any: bool) -> Option<f64> {
    let of = |need: Output| {
        fastest(view, |v| v.method == method && v.is_as_in_a_tracer() && v.needs == need)
    };
    let found = if any {
        of(Output::Occlusion)
    } else {
        of(Output::Barycentrics).or_else(|| of(Output::T))
    };
    found.map(|(_, ns)| ns)
}

/// How much faster a method's kernel is than that of the method that all are compared with.
fn kernel_gain(view: &View, method: &str, any: bool) -> Option<f64> {
    Some(kernel_ns(view, BASELINE, any)? / kernel_ns(view, method, any)?)
}

/// How much faster a method traces than the one that all are compared with, both in the same way:
/// geometric mean over the scenes and classes that are asked for.
fn tracer_gain(
    view: &View,
    method: &str,
    tracing: &str,
    keep: impl Fn(&Traced) -> bool,
) -> Option<f64> {
    let mine = traced(view, Contest::Methods)
        .filter(|t| t.method == method && t.tracing == tracing && keep(t));
    let gains: Vec<f64> = mine.filter_map(|t| faster(&t.samples_ns, &t.baseline_ns)).collect();
    geometric_mean(gains)
}
