//! Every variant in order of speed.

use std::fmt::Write as _;

use serde::Serialize;
use trisect_core::Output;
use trisect_harness::record::{Records, Variant};

use crate::format::{mtests, number, ratio};
use crate::stats::geometric_mean;
use crate::text::{hang, wrap};
use crate::view::{View, finish_label, lanes_label};

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
        let mut out = wrap(
            &format!("Geometric mean of time over best time, on {}.", self.workloads.join(", ")),
            width,
            "  ",
        );
        if self.left_out > 0 {
            let _ = writeln!(out, "Left out, for want of a workload in common: {}.", self.left_out);
        }
        out.push('\n');
        for (place, e) in self.entries.iter().enumerate() {
            let head = format!(
                "{:>4} {:>6} {:>6} M/s  ",
                place + 1,
                ratio(e.ratio),
                number(e.million_tests_per_second)
            );
            let line = format!(
                "{} {}, {}, {}",
                e.variant.method,
                lanes_label(&e.variant),
                e.variant.needs,
                finish_label(&e.variant)
            );
            out.push_str(&hang(&head, &line, width, "       "));
        }
        out
    }
}
