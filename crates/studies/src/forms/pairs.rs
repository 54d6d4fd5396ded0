//! Forms in pairs that differ in one thing: ratios of times that were taken in the same round.

use serde::Serialize;
use trisect_core::InstructionSet;
use trisect_kernels::Arrangement;
use trisect_machine::forms::{FormTime, FormVariant, TestForm};
use trisect_method::ReciprocalKind;
use trisect_report::format::ratio;
use trisect_report::stats::{geometric_mean, median_interval};

use crate::noise::Verdict;
use crate::record::{Header, Records};

/// Where most tests hit, where hardly any does, and between.
pub(super) const WORKLOADS: [(&str, &str); 3] =
    [("random", "10 % hit"), ("hit-rate/2", "2 % hit"), ("hit-rate/90", "90 % hit")];

/// The forms of a test in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FormsSummary {
    /// Who measured, where and how.
    pub header: Header,
    /// Each form over the early one, all else equal.
    pub over_early: Vec<FormRatio>,
}

/// The speed of a form over that of the early one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FormRatio {
    /// The form.
    #[serde(flatten)]
    pub variant: FormVariant,
    /// Name of the workload.
    pub workload: String,
    /// The median over rounds, between the ends of its 95 % interval.
    pub speed: [f64; 3],
}

/// Sums up the forms, as the project's settings compile them.
pub fn forms_summary(records: &Records) -> FormsSummary {
    let forms = Forms::new(records);
    let over_early = forms.times.iter().filter(|time| time.variant.form != TestForm::Early);
    let over_early = over_early.filter_map(|time| {
        let early = FormVariant { form: TestForm::Early, ..time.variant.clone() };
        let speed = speed(time, forms.find(&early, &time.workload)?)?;
        Some(FormRatio { variant: time.variant.clone(), workload: time.workload.clone(), speed })
    });
    FormsSummary { header: records.header.clone(), over_early: over_early.collect() }
}

/// How much faster `time` is than `other`: of each round, then the median between the ends of its interval.
fn speed(time: &FormTime, other: &FormTime) -> Option<[f64; 3]> {
    if other.tests == 0 {
        return None;
    }
    let tests = time.tests as f64 / other.tests as f64;
    let rounds = time.samples_ns.iter().zip(&other.samples_ns);
    let ratios: Vec<f64> =
        rounds.map(|(&ns, &other)| tests * other as f64 / ns.max(1) as f64).collect();
    median_interval(&ratios)
}

/// What is compared: which forms, and what is changed of them.
pub(super) struct Change {
    pub from: TestForm,
    pub to: TestForm,
    pub early_out: bool,
    pub arrangement: Arrangement,
}

/// The times of a record, as the project's settings compile the forms.
pub(super) struct Forms<'a> {
    pub(super) times: Vec<&'a FormTime>,
    is_usable: bool,
}

impl<'a> Forms<'a> {
    pub(super) fn new(records: &'a Records) -> Self {
        let times = records.all::<FormTime>().filter(|time| time.compiler.is_empty()).collect();
        let noise = records.header.noise;
        Self { times, is_usable: noise.is_none_or(|noise| noise.verdict() != Verdict::Unusable) }
    }

    pub(super) fn find(&self, variant: &FormVariant, workload: &str) -> Option<&'a FormTime> {
        let is_it = |time: &&FormTime| time.variant == *variant && time.workload == workload;
        self.times.iter().copied().find(is_it)
    }

    /// Widths with their instruction sets, the scalar first.
    pub(super) fn lanes(&self) -> Vec<(usize, InstructionSet)> {
        let lanes = |time: &&FormTime| (time.variant.width, time.variant.instruction_set);
        let mut all: Vec<_> = self.times.iter().map(lanes).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The speed of each method with `change` over that without, on lanes of a width.
    pub(super) fn changed(
        &self,
        width: usize,
        workload: &str,
        keep: impl Fn(&FormVariant) -> bool,
        change: impl Fn(&mut FormVariant),
    ) -> Pairs {
        let of_width = self.times.iter().filter(|time| {
            time.variant.width == width && time.workload == workload && keep(&time.variant)
        });
        let pairs = of_width.filter_map(|time| {
            let mut variant = time.variant.clone();
            change(&mut variant);
            let other = self.find(&variant, workload)?;
            Some((variant.method.clone(), speed(other, time)?))
        });
        Pairs { of: pairs.collect(), is_usable: self.is_usable }
    }

    /// The same of one form over another, which divide truly.
    pub(super) fn form(&self, width: usize, workload: &str, asked: &Change) -> Pairs {
        let keep = |v: &FormVariant| {
            v.form == asked.from
                && v.early_out == asked.early_out
                && v.arrangement == asked.arrangement
                && v.reciprocal == ReciprocalKind::True
        };
        self.changed(width, workload, keep, |v| v.form = asked.to)
    }
}

/// Methods, each with how much faster a change makes it.
pub(super) struct Pairs {
    of: Vec<(String, [f64; 3])>,
    is_usable: bool,
}

impl Pairs {
    /// Whether a change gains: of all methods, of none, or of some. Differences of 3 % are none.
    pub(super) fn gains(&self) -> &'static str {
        self.holds(|[low, ..]| low > 1.03)
    }

    /// Whether it costs nothing.
    pub(super) fn costs_nothing(&self) -> &'static str {
        self.holds(|[.., high]| high > 0.97)
    }

    fn holds(&self, of: impl Fn([f64; 3]) -> bool) -> &'static str {
        let count = self.of.iter().filter(|(_, speed)| of(*speed)).count();
        match count {
            _ if self.of.is_empty() => "Not measured.",
            _ if !self.is_usable => "Not settled: the machine was not steady.",
            0 => "Not here.",
            all if all == self.of.len() => "Holds here.",
            _ => "Holds for some methods here.",
        }
    }

    /// The mean alone.
    pub(super) fn mean(&self) -> String {
        let mean = geometric_mean(self.of.iter().map(|(_, [_, middle, _])| *middle));
        mean.map_or_else(|| "not measured".to_owned(), ratio)
    }

    /// The mean, then each method with its interval.
    pub(super) fn each(&self) -> String {
        let each = self.of.iter().map(|(method, [low, middle, high])| {
            format!("`{method}` {} ({low:.2} to {high:.2})", ratio(*middle))
        });
        let each = each.collect::<Vec<_>>().join(", ");
        if each.is_empty() { self.mean() } else { format!("{}: {each}", self.mean()) }
    }
}
