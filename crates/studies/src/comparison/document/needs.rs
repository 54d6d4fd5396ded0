//! What kernels gain by leaving out what is not asked for, from the comparison alone.

use crate::record::Variant;
use trisect_core::FloatFormat::F32;
use trisect_core::MultiplyAdd::Fused;
use trisect_kernels::Arrangement::OneRay;
use trisect_method::{Form, Output, ReciprocalKind};

use super::view::View;
use trisect_report::document::{Section, Shown};
use trisect_report::format::ratio;
use trisect_report::table::Table;

const PART: &str = "omissions";

/// Of every method, what is gained where only whether there is a hit is asked for, and what follows.
pub(super) fn sections(view: &View) -> Vec<Section> {
    let lanes = view.throughput.keys().filter(|v| v.precision == F32 && v.arithmetic == Fused);
    let width = lanes.map(|v| v.width).max().unwrap_or(1);
    let is_timed = |name: &&str| view.throughput.keys().any(|v| v.method == *name);
    let names = view.facts.iter().map(|facts| facts.name.as_str()).filter(is_timed);
    let rows: Vec<(&str, [Times; 3])> = names
        .map(|name| {
            let forms = [Some(Form::Deferred), Some(Form::Early), None];
            (name, forms.map(|division| Times::of(view, name, width, division)))
        })
        .collect();
    let mut gains: Vec<f64> =
        rows.iter().filter_map(|(_, [deferred, ..])| deferred.gain()).collect();
    gains.sort_by(f64::total_cmp);
    let divides = |[deferred, early, _]: &[Times; 3]| {
        deferred.hit.zip(early.hit).is_some_and(|(deferred, early)| early < deferred)
    };
    let says = gains.first().zip(gains.last()).map_or_else(String::new, |(least, most)| {
        format!(
            "Without a division and without values a test is {} to {} as fast as in full, in the same form, \
             over {} methods. In {} of those that have both forms dividing first is faster all the same: the \
             products that numerators take cost more than the division.",
            ratio(*least),
            ratio(*most),
            gains.len(),
            rows.iter().filter(|(_, times)| divides(times)).count(),
        )
    });
    let table = Table::of(&rows)
        .name("method", |(name, _)| *name)
        .number("numerators", ratio, |(_, [deferred, ..])| deferred.gain())
        .number("quotients", ratio, |(_, [_, early, _])| early.gain())
        .number("fastest", ratio, |(.., [.., either])| either.gain())
        .done();
    let columns = "numerators, quotients: nanoseconds of the fullest hit over those of whether there is one, \
                   both in the deferred form, which decides a hit without a division, and in the early one, \
                   which divides first; a dash where the method does not have that form. fastest: the same \
                   over the fastest of each.";
    [Section::prose(says), Section::table("", "", columns, table)]
        .map(|section| section.part(PART).shown(Shown::Part))
        .into()
}

/// Nanoseconds of a method's tests without early-out, in one form or the fastest, on the widest fused f32
/// lanes.
struct Times {
    hit: Option<f64>,
    full: Option<f64>,
}

impl Times {
    fn of(view: &View, method: &str, width: usize, division: Option<Form>) -> Self {
        let of = |asked: Output| {
            let keep = |v: &Variant| {
                (v.method.as_ref(), v.precision, v.width) == (method, F32, width)
                    && v.arithmetic == Fused
                    && v.arrangement == OneRay
                    && v.reciprocal == ReciprocalKind::True
                    && !v.early_out
                    && division.is_none_or(|division| v.division == division)
                    && v.needs == asked
            };
            view.fastest(keep).map(|(_, ns)| ns)
        };
        let full = of(Output::Barycentrics).or_else(|| of(Output::T));
        Self { hit: of(Output::Occlusion), full }
    }

    /// How much longer the fullest hit takes.
    fn gain(&self) -> Option<f64> {
        Some(self.full? / self.hit?)
    }
}
