//! An index over records: what every table and figure asks of them, answered once.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::figures::fastest_methods;
use crate::comparison::record::{
    Cracks, Decisions, Error, Family, MethodFacts, Preparation, Quantiles, Refusal, Throughput,
    Workload,
};
use crate::lines::distinct;
use crate::record::{LineKind, Records, Variant};
use trisect_core::{FloatFormat, MultiplyAdd};
use trisect_method::{Output, ReciprocalKind};

use trisect_report::figure::Look;
use trisect_report::stats::{geometric_mean, median, ns_per_test};

/// The need that figures show, of those that were timed: the fullest that most methods give.
const MAIN_NEEDS: [Output; 3] = [Output::Barycentrics, Output::T, Output::Occlusion];
/// The reference of errors that every figure uses.
pub(crate) const ORACLE: &str = "oracle";
/// The method that every other is compared with.
pub(crate) const BASELINE: &str = "moller-trumbore";

/// How a need reads in a sentence.
pub(crate) fn need_in_prose(need: Output) -> &'static str {
    match need {
        Output::Occlusion => "only whether the ray hits",
        Output::T => "the distance t",
        Output::Barycentrics => "the distance with barycentrics",
        Output::Point => "the point",
        Output::Normal => "the distance with the normal",
    }
}

/// `f32×8 avx2 fused`: precision, lanes and instruction set.
pub(crate) fn lanes_label(v: &Variant) -> String {
    let fused = if v.arithmetic == MultiplyAdd::Fused { " fused" } else { "" };
    if v.width == 1 {
        format!("{} scalar{fused}", v.precision)
    } else {
        format!("{}×{} {}{fused}", v.precision, v.width, v.instruction_set)
    }
}

/// What sets apart variants of the same method and lanes.
pub(crate) fn finish_label(v: &Variant) -> String {
    let newton = if v.reciprocal == ReciprocalKind::Newton { ", Newton reciprocal" } else { "" };
    let exit = if v.early_out { "early-out" } else { "no early-out" };
    format!("{}, {}{newton}, {exit}", v.arrangement, v.division)
}

/// A variant with everything that sets it apart.
pub(crate) fn label(v: &Variant) -> String {
    format!("{} {}, {}, {}", v.method, lanes_label(v), v.needs, finish_label(v))
}

/// Variants on the workloads that all of them ran.
pub(crate) struct Comparable<'a> {
    pub(crate) workloads: Vec<&'a str>,
    /// Each variant with its ns per test on each of the workloads.
    pub(crate) entries: Vec<(&'a Variant, Vec<f64>)>,
    /// Variants that ran none of the workloads.
    pub(crate) left_out: usize,
}

impl<'a> Comparable<'a> {
    /// Variants with the geometric mean of their ns per test, fastest first.
    pub(crate) fn scores(&self) -> Vec<(&'a Variant, f64)> {
        let mut scores: Vec<_> = self
            .entries
            .iter()
            .filter_map(|(v, ns)| Some((*v, geometric_mean(ns.iter().copied())?)))
            .collect();
        scores.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(b.0)));
        scores
    }
}

/// The index.
pub(crate) struct View<'a> {
    pub(crate) records: &'a Records,
    pub(crate) workloads: BTreeMap<&'a str, &'a Workload>,
    /// By year, then name.
    pub(crate) facts: Vec<&'a MethodFacts>,
    pub(crate) throughput: BTreeMap<&'a Variant, BTreeMap<&'a str, &'a Throughput>>,
    /// Errors against the oracle on main workloads, by method, precision and quantity.
    against_oracle: HashMap<(&'a str, FloatFormat, &'a str), Vec<&'a Error>>,
    /// By method and precision.
    decisions: HashMap<(&'a str, FloatFormat), Vec<&'a Decisions>>,
    /// Names of all methods that any record names, by year, then name.
    methods: Vec<&'a str>,
    /// Needs that were timed, cheapest first.
    needs: Vec<Output>,
    /// Methods in the order of their looks: those that are told apart come first.
    looks: Vec<&'a str>,
}

impl<'a> View<'a> {
    pub(crate) fn new(records: &'a Records) -> Self {
        let mut facts: Vec<&MethodFacts> = records.all().collect();
        facts.sort_by(|a, b| a.year.cmp(&b.year).then(a.name.cmp(&b.name)));
        facts.dedup_by(|a, b| a.name == b.name);
        let mut view = Self {
            records,
            workloads: records.all().map(|w: &Workload| (w.name.as_str(), w)).collect(),
            facts,
            throughput: BTreeMap::new(),
            against_oracle: HashMap::new(),
            decisions: HashMap::new(),
            methods: Vec::new(),
            needs: Vec::new(),
            looks: Vec::new(),
        };
        for t in records.all::<Throughput>() {
            if ns_per_test(&t.samples_ns, t.tests).is_some() {
                view.throughput.entry(&t.variant).or_default().insert(&t.workload, t);
            }
        }
        for d in records.all::<Decisions>() {
            let key = (d.variant.method.as_ref(), d.variant.precision);
            view.decisions.entry(key).or_default().push(d);
        }
        for e in records.all::<Error>().filter(|e| e.reference == ORACLE && e.count > 0) {
            if view.is_main(&e.workload) {
                let v = &e.variant;
                let key = (v.method.as_ref(), v.precision, e.quantity.as_str());
                view.against_oracle.entry(key).or_default().push(e);
            }
        }
        view.methods = view.all_methods();
        let timed: BTreeSet<Output> = view.throughput.keys().map(|v| v.needs).collect();
        view.needs = timed.into_iter().collect();
        let told = fastest_methods(&view).into_iter();
        view.looks = distinct(told.chain(view.methods.iter().copied()));
        view
    }

    /// All lines of one kind, in order.
    pub(crate) fn all<K: LineKind>(&self) -> impl Iterator<Item = &'a K> + use<'a, K> {
        self.records.all()
    }

    /// Names of all methods that any record names, by year, then name.
    pub(crate) fn methods(&self) -> &[&'a str] {
        &self.methods
    }

    fn all_methods(&self) -> Vec<&'a str> {
        let mut names: Vec<&str> = self.facts.iter().map(|m| m.name.as_str()).collect();
        let measured: BTreeSet<&str> = self
            .throughput
            .keys()
            .map(|v| v.method.as_ref())
            .chain(self.all::<Error>().map(|e| e.variant.method.as_ref()))
            .chain(self.decisions.keys().map(|(method, _)| *method))
            .chain(self.all::<Preparation>().map(|p| p.method.as_str()))
            .collect();
        let known: BTreeSet<&str> = names.iter().copied().collect();
        names.extend(measured.difference(&known));
        names
    }

    /// A method's facts, if recorded.
    pub(crate) fn fact(&self, method: &str) -> Option<&'a MethodFacts> {
        self.facts.iter().find(|m| m.name == method).copied()
    }

    /// A method's name in prose.
    pub(crate) fn title(&self, method: &str) -> String {
        self.fact(method).map_or_else(|| method.to_string(), |m| m.title.clone())
    }

    /// Precisions of any record, single before double.
    pub(crate) fn precisions(&self) -> Vec<FloatFormat> {
        let all: BTreeSet<FloatFormat> = self
            .throughput
            .keys()
            .map(|v| v.precision)
            .chain(self.all::<Error>().map(|e| e.variant.precision))
            .collect();
        all.into_iter().collect()
    }

    /// Needs that were timed, cheapest first.
    pub(crate) fn needs(&self) -> &[Output] {
        &self.needs
    }

    /// The need that figures show: the fullest that was timed.
    pub(crate) fn main_need(&self) -> Option<Output> {
        MAIN_NEEDS.into_iter().find(|n| self.needs.contains(n))
    }

    /// Whether a workload stands for itself instead of being a step of a series.
    fn is_main(&self, workload: &str) -> bool {
        self.workloads
            .get(workload)
            .is_none_or(|w| matches!(w.family, Family::Random | Family::Mesh))
    }

    /// Names of the workloads of one family, in order.
    pub(crate) fn family(&self, family: Family) -> Vec<&'a Workload> {
        self.workloads.values().filter(|w| w.family == family).copied().collect()
    }

    /// The variants that `keep` lets pass, on the main workloads that all of them ran.
    pub(crate) fn comparable(&self, keep: impl Fn(&Variant) -> bool) -> Comparable<'a> {
        let on_main = self.comparable_on(&keep, |w| self.is_main(w));
        if on_main.entries.is_empty() { self.comparable_on(&keep, |_| true) } else { on_main }
    }

    /// The same, on the workloads that `on` lets pass. Where the variants have none in common,
    /// the workload that most of them ran stands in, and the others are left out and counted.
    pub(crate) fn comparable_on(
        &self,
        keep: impl Fn(&Variant) -> bool,
        on: impl Fn(&str) -> bool,
    ) -> Comparable<'a> {
        let asked: Vec<&'a Variant> = self.throughput.keys().copied().filter(|v| keep(v)).collect();
        let ran: Vec<(&'a Variant, BTreeSet<&'a str>)> = asked
            .iter()
            .map(|v| (*v, self.throughput[v].keys().copied().filter(|w| on(w)).collect()))
            .filter(|(_, w): &(_, BTreeSet<&str>)| !w.is_empty())
            .collect();
        let mut common = ran
            .iter()
            .map(|(_, w)| w.clone())
            .reduce(|a, b| a.intersection(&b).copied().collect())
            .unwrap_or_default();
        if common.is_empty() {
            let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
            for w in ran.iter().flat_map(|(_, w)| w) {
                *counts.entry(w).or_default() += 1;
            }
            common.extend(counts.into_iter().rev().max_by_key(|&(_, n)| n).map(|(w, _)| w));
        }
        let workloads: Vec<&str> = common.into_iter().collect();
        let entries: Vec<_> = ran
            .iter()
            .filter_map(|(v, _)| {
                let ns = workloads.iter().map(|w| self.ns(v, w)).collect::<Option<Vec<_>>>()?;
                (!ns.is_empty()).then_some((*v, ns))
            })
            .collect();
        let left_out = asked.len() - entries.len();
        Comparable { workloads, entries, left_out }
    }

    /// Whether the variant's method does not take some workload.
    pub(crate) fn is_refused(&self, v: &Variant) -> bool {
        let mut refusals = self.all::<Refusal>();
        refusals.any(|r| r.method == v.method && r.precision == v.precision)
    }

    /// Nanoseconds per test of one variant on one workload.
    pub(crate) fn ns(&self, variant: &Variant, workload: &str) -> Option<f64> {
        let t = self.throughput.get(variant)?.get(workload)?;
        ns_per_test(&t.samples_ns, t.tests)
    }

    /// The error of a variant against the oracle: over the main workloads, the median of the
    /// medians, means and 99th percentiles, and the largest maximum.
    ///
    /// Needs, arrangement and early-out do not change values; neither does the width, so where
    /// only one width was verified it stands for all.
    pub(crate) fn error(&self, variant: &Variant, quantity: &str) -> Option<Quantiles> {
        let of = (variant.method.as_ref(), variant.precision);
        self.pooled_error(of, quantity, |v| v.computes_like(variant))
            .or_else(|| self.pooled_error(of, quantity, |v| v.rounds_like(variant)))
    }

    /// The same of the errors over their condition numbers times the unit roundoff.
    pub(crate) fn over_condition(&self, variant: &Variant, quantity: &str) -> Option<Quantiles> {
        let of = (variant.method.as_ref(), variant.precision);
        let over = |e: &Error| e.over_condition;
        self.pooled(of, quantity, over, |v| v.computes_like(variant))
            .or_else(|| self.pooled(of, quantity, over, |v| v.rounds_like(variant)))
    }

    /// The same over the variants of a method and precision that `keep` lets pass.
    pub(crate) fn pooled_error(
        &self,
        of: (&str, FloatFormat),
        quantity: &str,
        keep: impl Fn(&Variant) -> bool,
    ) -> Option<Quantiles> {
        self.pooled(of, quantity, |e| Some(e.relative), keep)
    }

    fn pooled(
        &self,
        (method, precision): (&str, FloatFormat),
        quantity: &str,
        error: fn(&Error) -> Option<Quantiles>,
        keep: impl Fn(&Variant) -> bool,
    ) -> Option<Quantiles> {
        let found: Vec<Quantiles> = self
            .against_oracle
            .get(&(method, precision, quantity))?
            .iter()
            .filter(|e| keep(&e.variant))
            .filter_map(|e| error(e))
            .collect();
        let of = |get: fn(&Quantiles) -> f64| {
            let values: Vec<f64> = found.iter().map(get).collect();
            median(&values)
        };
        Some(Quantiles {
            mean: of(|q| q.mean)?,
            median: of(|q| q.median)?,
            p99: of(|q| q.p99)?,
            max: found.iter().map(|q| q.max).fold(0.0, f64::max),
        })
    }

    /// False hits and false misses per million pairs, over the decisions of the variants of a
    /// method and precision that `keep` lets pass.
    pub(crate) fn wrong_per_million(
        &self,
        of: (&str, FloatFormat),
        keep: impl Fn(&Variant) -> bool,
    ) -> Option<f64> {
        let (mut wrong, mut pairs) = (0u64, 0u64);
        let decisions = self.decisions.get(&of)?.iter().filter(|d| keep(&d.variant));
        for class in decisions.flat_map(|d| d.classes.iter()) {
            wrong += if class.is_hit { class.called_miss } else { class.called_hit };
            pairs += class.called_hit + class.called_miss;
        }
        (pairs > 0).then(|| wrong as f64 * 1e6 / pairs as f64)
    }

    /// Rays per million that a method lets out of a closed surface, in plain arithmetic and the form
    /// of the division that lets out fewest.
    pub(crate) fn cracks_per_million(&self, method: &str) -> Option<f64> {
        self.fewest_cracks(|v| v.method == method && v.arithmetic == MultiplyAdd::Plain)
    }

    /// The same of the variants that `keep` lets pass.
    pub(crate) fn fewest_cracks(&self, keep: impl Fn(&Variant) -> bool) -> Option<f64> {
        self.all::<Cracks>()
            .filter(|c| keep(&c.variant))
            .map(|c| c.no_hit as f64 * 1e6 / c.rays.max(1) as f64)
            .min_by(f64::total_cmp)
    }

    /// Bytes that one triangle takes, as timed, or else as stored.
    pub(crate) fn bytes(&self, method: &str, precision: FloatFormat) -> Option<usize> {
        let timed = self
            .throughput
            .iter()
            .filter(|(v, _)| v.method == method && v.precision == precision)
            .find_map(|(_, on)| on.values().next().map(|t| t.bytes_per_triangle));
        timed.or_else(|| {
            let size = if precision == FloatFormat::F64 { 8 } else { 4 };
            Some(self.fact(method)?.stored_numbers * size)
        })
    }

    /// Nanoseconds to prepare one triangle: the median over workloads.
    pub(crate) fn preparation(&self, method: &str, precision: FloatFormat) -> Option<f64> {
        let ns: Vec<f64> = self
            .all::<Preparation>()
            .filter(|p| p.method == method && p.precision == precision)
            .filter_map(|p| ns_per_test(&p.samples_ns, p.triangles as u64))
            .collect();
        median(&ns)
    }

    /// Nanoseconds per test of the fastest variant that `keep` lets pass, over the main workloads.
    pub(crate) fn fastest(&self, keep: impl Fn(&Variant) -> bool) -> Option<(&'a Variant, f64)> {
        self.comparable(keep).scores().first().copied()
    }

    /// The look that a method has in every figure of lines.
    pub(crate) fn look(&self, method: &str) -> Look {
        Look::of(self.looks.iter().position(|other| *other == method).unwrap_or(0))
    }
}
