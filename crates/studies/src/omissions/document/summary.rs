//! The study of omissions in numbers, for a program to read.

use crate::omissions::record::{Code, Layer, Omission};
use crate::record::{Header, Records};
use serde::Serialize;

use super::select::{LAYERS, ratios};

/// The study of omissions in a screenful.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OmissionSummary {
    /// Who studied, where and how.
    pub header: Header,
    /// What was left out, by its kind.
    pub kinds: Vec<OmissionKind>,
    /// All of it, in the record's order.
    pub omissions: Vec<TimedOmission>,
    /// Code that is compiled several times.
    pub code: Vec<Code>,
}

/// What is left out in one place, over methods or scenes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OmissionKind {
    /// Where it is left out: `kernels`, `tracer` or `pictures`.
    pub layer: &'static str,
    /// What; of kernels, which leave out values, the form of the division.
    pub kind: String,
    /// How many times as long it takes with it: the geometric mean over methods or scenes.
    pub mean: f64,
    /// Where it costs the least.
    pub least: f64,
    /// Where it costs the most.
    pub most: f64,
}

/// Something that is left out, and what it would take.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimedOmission {
    /// Where it is left out.
    pub layer: Layer,
    /// What.
    pub part: String,
    /// Name of the scene or workload.
    pub scene: String,
    /// What is done with it.
    pub of: String,
    /// Name of the method.
    pub method: String,
    /// How many times as long it takes with it: the median over pairs that were timed in the same round.
    pub ratio: f64,
    /// The quartiles of these pairs.
    pub quartiles: [f64; 2],
}

/// Sums up what was studied.
pub fn omission_summary(records: &Records) -> OmissionSummary {
    let timed = |omission: &Omission| {
        let (ratio, quartiles) = omission.ratio()?;
        let Omission { layer, part, scene, of, method, .. } = omission.clone();
        Some(TimedOmission { layer, part, scene, of, method, ratio, quartiles })
    };
    let kinds = LAYERS.into_iter().flat_map(|(layer, name)| {
        ratios(records, layer).into_iter().map(move |(kind, all, mean)| OmissionKind {
            layer: name,
            kind: kind.to_owned(),
            mean,
            least: all.iter().copied().fold(f64::INFINITY, f64::min),
            most: all.iter().copied().fold(0.0, f64::max),
        })
    });
    OmissionSummary {
        kinds: kinds.collect(),
        header: records.header.clone(),
        omissions: records.all().filter_map(timed).collect(),
        code: records.all().cloned().collect(),
    }
}
