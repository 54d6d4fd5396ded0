//! Every variant in order of speed.

use crate::record::{Records, Variant};
use serde::Serialize;
use trisect_method::Output;

use super::view::{View, label};
use trisect_report::document::{Content, Document, Section};
use trisect_report::format::{mtests, number, ratio};
use trisect_report::stats::geometric_mean;

/// Which variants and workloads to rank; `None` asks for all.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Filter {
    /// `occlusion`, `t` or `barycentrics`.
    pub needs: Option<Output>,
    /// A workload, or the part of its name before a slash: `bunny` stands for `bunny/primary`
    /// and the like. Without it, the workloads that are no step of a series.
    pub workload: Option<String>,
}

/// Every variant in order of speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranking {
    /// What was asked.
    pub filter: Filter,
    /// The workloads that all ranked variants ran.
    pub workloads: Vec<String>,
    /// Best first.
    pub entries: Vec<Ranked>,
    /// Variants left out because they ran none of the workloads.
    pub left_out: usize,
}

/// One variant's place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranked {
    /// The variant.
    pub variant: Variant,
    /// Geometric mean over the workloads of the time over the best time; 1 is best everywhere.
    pub ratio: f64,
    /// Million tests per second: geometric mean over the workloads.
    pub million_tests_per_second: f64,
}

/// Ranks every variant by the geometric mean, over the workloads that all of them ran, of its
/// time over the best time on that workload.
pub fn rank(records: &Records, filter: &Filter) -> Ranking {
    let view = View::new(records);
    let keep = |v: &Variant| filter.needs.is_none_or(|needs| v.needs == needs);
    let comparable = match &filter.workload {
        None => view.comparable(keep),
        Some(asked) => view.comparable_on(keep, |w| {
            w.strip_prefix(asked.as_str())
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        }),
    };
    let best: Vec<f64> = (0..comparable.workloads.len())
        .map(|w| comparable.entries.iter().map(|(_, ns)| ns[w]).fold(f64::INFINITY, f64::min))
        .collect();
    let mut entries: Vec<Ranked> = comparable
        .entries
        .iter()
        .filter_map(|(variant, ns)| {
            Some(Ranked {
                variant: (*variant).clone(),
                ratio: geometric_mean(ns.iter().zip(&best).map(|(ns, best)| ns / best))?,
                million_tests_per_second: mtests(geometric_mean(ns.iter().copied())?),
            })
        })
        .collect();
    entries.sort_by(|a, b| a.ratio.total_cmp(&b.ratio).then(a.variant.cmp(&b.variant)));
    Ranking {
        filter: filter.clone(),
        workloads: comparable.workloads.iter().map(ToString::to_string).collect(),
        entries,
        left_out: comparable.left_out,
    }
}

impl Ranking {
    /// The ranking as text of at most `width` columns, for 40 columns or more.
    pub fn to_text(&self, width: usize) -> String {
        if self.entries.is_empty() {
            return "No variant matches.\n".into();
        }
        let left_out = match self.left_out {
            0 => String::new(),
            count => format!(" Left out, for want of a workload in common: {count}."),
        };
        let on = self.workloads.join(", ");
        let says = format!("Geometric mean of time over best time, on {on}.{left_out}");
        let item = |(place, e): (usize, &Ranked)| {
            let (times, speed) = (ratio(e.ratio), number(e.million_tests_per_second));
            (format!("{:>4} {times:>6} {speed:>6} M/s  ", place + 1), label(&e.variant))
        };
        let items = self.entries.iter().enumerate().map(item).collect();
        Document::text([Section::prose(says), Section::new("", "", Content::List(items))], width)
    }
}
