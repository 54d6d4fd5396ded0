//! What of a record is traced, and how fast.

use crate::tracer::record::{Contest, Traced, TreeBuilt};
use trisect_method::Output;

use crate::comparison::document::view::{BASELINE, View};
use crate::lines::distinct;
use trisect_report::stats::{geometric_mean, median};

/// The median of times.
pub(super) fn middle(samples_ns: &[u64]) -> Option<f64> {
    let samples: Vec<f64> = samples_ns.iter().map(|&ns| ns as f64).collect();
    median(&samples).filter(|&ns| ns > 0.0)
}

/// Million rays per second.
pub(super) fn speed(traced: &Traced) -> Option<f64> {
    Some(traced.rays as f64 * 1e3 / middle(&traced.samples_ns)?)
}

/// How much faster than what went in turn with it: the median over the rounds of the ratio in each.
pub(super) fn faster(traced: &[u64], beside: &[u64]) -> Option<f64> {
    let pairs = beside.iter().zip(traced).filter(|(_, mine)| **mine > 0);
    let ratios: Vec<f64> = pairs.map(|(beside, mine)| *beside as f64 / *mine as f64).collect();
    median(&ratios).filter(|&ratio| ratio > 0.0)
}

/// Whether rays went through such a tree.
pub(super) fn is_through(traced: &Traced, tree: &TreeBuilt) -> bool {
    traced.scene == tree.scene && traced.builder == tree.builder && traced.leaves == tree.leaves
}

/// What was traced of a contest.
pub(super) fn traced<'a>(view: &View<'a>, contest: Contest) -> impl Iterator<Item = &'a Traced> {
    view.all::<Traced>().filter(move |traced| traced.contest == contest)
}

/// The trees of a contest.
pub(super) fn trees<'a>(view: &View<'a>, contest: Contest) -> impl Iterator<Item = &'a TreeBuilt> {
    view.all::<TreeBuilt>().filter(move |tree| tree.contest == contest)
}

/// Whether rays went singly, in one call for all.
pub(super) fn is_single(traced: &Traced) -> bool {
    traced.tracing == "single" && traced.calls == "batch"
}

/// Geometric mean, over scenes and classes of the trees' contest, of the speed of lines over that of the
/// default tree's single rays in one call, round by round.
pub(super) fn against_default(view: &View, keep: impl Fn(&Traced) -> bool) -> Option<f64> {
    let all = || traced(view, Contest::Trees);
    let ratios = all().filter(|t| keep(t)).filter_map(|mine| {
        let is_default = |t: &&Traced| {
            t.scene == mine.scene
                && t.class == mine.class
                && t.builder == "spatial"
                && t.leaves == "cheapest"
                && is_single(t)
        };
        faster(&mine.samples_ns, &all().find(is_default)?.samples_ns)
    });
    geometric_mean(ratios)
}

/// Classes of rays, in the record's order.
pub(super) fn classes<'a>(view: &View<'a>) -> Vec<&'a str> {
    distinct(view.all::<Traced>().map(|traced| traced.class.as_str()))
}

/// Scenes, in the record's order.
pub(super) fn scenes<'a>(view: &View<'a>) -> Vec<&'a str> {
    distinct(view.all::<Traced>().map(|traced| traced.scene.as_str()))
}

/// Nanoseconds of a test in a method's kernel that is as the tracer's, asked for any hit or for the
/// fullest one.
pub(super) fn kernel_ns(view: &View, method: &str, any: bool) -> Option<f64> {
    let of = |need: Output| {
        view.fastest(|v| v.method == method && v.is_as_in_a_tracer() && v.needs == need)
    };
    let found = if any {
        of(Output::Occlusion)
    } else {
        of(Output::Barycentrics).or_else(|| of(Output::T))
    };
    found.map(|(_, ns)| ns)
}

/// How much faster a method's kernel is than that of the method that all are compared with.
pub(super) fn kernel_gain(view: &View, method: &str, any: bool) -> Option<f64> {
    Some(kernel_ns(view, BASELINE, any)? / kernel_ns(view, method, any)?)
}

/// How much faster a method traces than what it is in turn with in a contest, both in the same way:
/// geometric mean over the scenes and classes that are asked for.
pub(super) fn tracer_gain(
    view: &View,
    contest: Contest,
    method: &str,
    tracing: &str,
    keep: impl Fn(&Traced) -> bool,
) -> Option<f64> {
    let mine =
        traced(view, contest).filter(|t| t.method == method && t.tracing == tracing && keep(t));
    let gains: Vec<f64> = mine.filter_map(|t| faster(&t.samples_ns, &t.baseline_ns)).collect();
    geometric_mean(gains)
}
