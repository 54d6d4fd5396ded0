//! What a terminal prints after the study of omissions.

use serde::Serialize;
use trisect_harness::record::{Code, Header, Layer, Omission, Records};

use super::{LAYERS, ratios};
use crate::format::ratio;
use crate::text::{Table, wrap};
use crate::view::View;

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
    let view = View::new(records);
    let timed = |omission: &&Omission| {
        let (ratio, quartiles) = omission.ratio()?;
        let Omission { layer, part, scene, of, method, .. } = (*omission).clone();
        Some(TimedOmission { layer, part, scene, of, method, ratio, quartiles })
    };
    let kinds = LAYERS.into_iter().flat_map(|(layer, name)| {
        ratios(&view, layer).into_iter().map(move |(kind, all, mean)| OmissionKind {
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
        omissions: view.omissions.iter().filter_map(timed).collect(),
        code: view.code.iter().copied().cloned().collect(),
    }
}

impl OmissionSummary {
    /// The summary as text of at most `width` columns, for 40 columns or more.
    pub fn to_text(&self, width: usize) -> String {
        let h = &self.header;
        let machine = format!("trisect {} on {}, {}", h.trisect, h.machine.cpu, h.machine.compiler);
        let mut out = wrap(&machine, width, "  ");
        out.push('\n');
        let mut table = Table::new(&["with what is left out", "times", "least", "most"]);
        for OmissionKind { layer, kind, mean, least, most } in &self.kinds {
            let cells = [*mean, *least, *most].map(ratio);
            table.rows.push([vec![format!("{layer}: {kind}")], cells.into()].concat());
        }
        out.push_str(&table.render(width));
        for code in &self.code {
            out.push('\n');
            let says = super::markdown::code_says(code);
            let Code { of, instances, .. } = code;
            out.push_str(&wrap(&format!("Instances of the {of}: {instances}, {says}"), width, ""));
        }
        out
    }
}
