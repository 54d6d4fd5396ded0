//! Two records beside each other.

use std::collections::{BTreeMap, HashMap};

use crate::comparison::record::Error;
use crate::record::{Header, Records, Variant};
use serde::Serialize;

use super::view::{View, label, lanes_label};
use trisect_report::document::{Content, Document, Section};
use trisect_report::format::{ratio, scientific};
use trisect_report::stats::geometric_mean;

/// Two records beside each other: `b` measured against `a`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordComparison {
    /// The header of the first record.
    pub a: Header,
    /// The header of the second.
    pub b: Header,
    /// Whether processor, compiler and build are the same, so that ratios speak of the code.
    pub same_machine: bool,
    /// Geometric mean of all ratios; `None` where nothing was timed in both.
    pub geometric_mean: Option<f64>,
    /// Variants timed in both, by growing ratio.
    pub variants: Vec<ComparedVariant>,
    /// Variants timed in the first record only.
    pub only_in_a: usize,
    /// Variants timed in the second record only.
    pub only_in_b: usize,
    /// Errors recorded in both.
    pub errors_compared: usize,
    /// Those that differ.
    pub errors_that_differ: Vec<ErrorDifference>,
}

/// One variant in two records.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedVariant {
    /// The variant.
    pub variant: Variant,
    /// Per workload in both, the median throughput in `b` over that in `a`; above 1, `b` is
    /// the faster.
    pub ratios: BTreeMap<String, f64>,
    /// Their geometric mean.
    pub geometric_mean: f64,
}

/// An error that is not the same in two records.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorDifference {
    /// The variant.
    pub variant: Variant,
    /// The workload.
    pub workload: String,
    /// What the error is measured against.
    pub reference: String,
    /// `t`, `beta` or `gamma`.
    pub quantity: String,
    /// Median and largest relative error in the first record.
    pub a: [f64; 2],
    /// The same in the second.
    pub b: [f64; 2],
}

/// Compares what two records have in common.
pub fn compare_records(a: &Records, b: &Records) -> RecordComparison {
    let (first, second) = (View::new(a), View::new(b));
    let mut variants: Vec<ComparedVariant> = first
        .throughput
        .iter()
        .filter_map(|(variant, workloads)| {
            let ratios: BTreeMap<String, f64> = workloads
                .keys()
                .filter_map(|w| Some(((*w).into(), first.ns(variant, w)? / second.ns(variant, w)?)))
                .collect();
            let geometric_mean = geometric_mean(ratios.values().copied())?;
            Some(ComparedVariant { variant: (*variant).clone(), ratios, geometric_mean })
        })
        .collect();
    variants.sort_by(|x, y| {
        x.geometric_mean.total_cmp(&y.geometric_mean).then(x.variant.cmp(&y.variant))
    });
    let only =
        |x: &View, y: &View| x.throughput.keys().filter(|v| !y.throughput.contains_key(*v)).count();

    let key = |e: &Error| {
        (e.variant.clone(), e.workload.clone(), e.reference.clone(), e.quantity.clone())
    };
    let theirs: HashMap<_, _> = b.all().map(|e: &Error| (key(e), e)).collect();
    let mut errors_compared = 0;
    let mut errors_that_differ = Vec::new();
    for e in a.all::<Error>() {
        let Some(other) = theirs.get(&key(e)) else { continue };
        errors_compared += 1;
        if e.relative != other.relative || e.ulps != other.ulps || e.count != other.count {
            errors_that_differ.push(ErrorDifference {
                variant: e.variant.clone(),
                workload: e.workload.clone(),
                reference: e.reference.clone(),
                quantity: e.quantity.clone(),
                a: [e.relative.median, e.relative.max],
                b: [other.relative.median, other.relative.max],
            });
        }
    }
    let (ma, mb) = (&a.header.machine, &b.header.machine);
    RecordComparison {
        a: a.header.clone(),
        b: b.header.clone(),
        same_machine: (&ma.cpu, &ma.compiler, &ma.build) == (&mb.cpu, &mb.compiler, &mb.build),
        geometric_mean: geometric_mean(variants.iter().flat_map(|v| v.ratios.values().copied())),
        only_in_a: only(&first, &second),
        only_in_b: only(&second, &first),
        variants,
        errors_compared,
        errors_that_differ,
    }
}

impl RecordComparison {
    /// The comparison as text of at most `width` columns, for 40 columns or more.
    pub fn to_text(&self, width: usize) -> String {
        let list = |items| Section::new("", "", Content::List(items));
        let head = |name: &str, h: &Header| {
            let m = &h.machine;
            let says = format!(
                "trisect {}, {}, {}, {}, {}",
                h.trisect, h.started, m.cpu, m.compiler, m.build
            );
            (format!("{name}: "), says)
        };
        let heads = list(vec![head("a", &self.a), head("b", &self.b)]);
        let mut says = Vec::new();
        if !self.same_machine {
            says.push(
                "Processor, compiler or build differ: the ratios compare those too.".to_owned(),
            );
        }
        says.push(self.geometric_mean.map_or_else(
            || "No variant was timed in both.".to_owned(),
            |mean| {
                let (count, mean) = (self.variants.len(), ratio(mean));
                format!("Throughput b/a, geometric mean over {count} variants: {mean}.")
            },
        ));
        if self.only_in_a + self.only_in_b > 0 {
            let (a, b) = (self.only_in_a, self.only_in_b);
            says.push(format!("Variants only in a: {a}; only in b: {b}."));
        }
        let variant =
            |v: &ComparedVariant| (format!("{:>6} ", ratio(v.geometric_mean)), label(&v.variant));
        let (both, differ) = (self.errors_compared, self.errors_that_differ.len());
        let error = |e: &ErrorDifference| {
            let says = format!(
                "{} {}, {} division, {} on {} against {}: median {} → {}, max {} → {}",
                e.variant.method,
                lanes_label(&e.variant),
                e.variant.division,
                e.quantity,
                e.workload,
                e.reference,
                scientific(e.a[0]),
                scientific(e.b[0]),
                scientific(e.a[1]),
                scientific(e.b[1])
            );
            ("  ".to_owned(), says)
        };
        let sections = [
            heads,
            Section::prose(says.join(" ")),
            list(self.variants.iter().map(variant).collect()),
            Section::prose(format!("Errors in both: {both}; different: {differ}.")),
            list(self.errors_that_differ.iter().map(error).collect()),
        ];
        Document::text(sections, width)
    }
}
