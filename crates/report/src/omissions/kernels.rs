//! What kernels gain by leaving out what is not asked for.

use std::fmt::Write as _;

use trisect_core::{Arrangement, FloatFormat, Form, MultiplyAdd, Output, ReciprocalKind};
use trisect_harness::record::Variant;

use crate::format::{or_dash, ratio};
use crate::markdown::{self, Table, fastest};
use crate::view::View;

/// What stands below the table.
const SAYS: &str = "numerators, quotients: nanoseconds of the fullest hit over those of whether there is \
    one, both in the deferred form, which decides a hit without a division, and in the early one, which \
    divides first; a dash where the method has not that form. fastest: the same over the fastest of each.";

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
                (v.method.as_ref(), v.precision, v.width) == (method, FloatFormat::F32, width)
                    && v.arithmetic == MultiplyAdd::Fused
                    && v.arrangement == Arrangement::OneRay
                    && v.reciprocal == ReciprocalKind::True
                    && !v.early_out
                    && division.is_none_or(|division| v.division == division)
                    && v.needs == asked
            };
            fastest(view, keep).map(|(_, ns)| ns)
        };
        let full = of(Output::Barycentrics).or_else(|| of(Output::T));
        Self { hit: of(Output::Occlusion), full }
    }

    /// How much longer the fullest hit takes.
    fn gain(&self) -> Option<f64> {
        Some(self.full? / self.hit?)
    }
}

/// Of every method, what is gained where only whether there is a hit is asked for, and what follows; nothing
/// where no method was timed.
pub(crate) fn page(view: &View) -> String {
    let lanes = view
        .throughput
        .keys()
        .filter(|v| v.precision == FloatFormat::F32 && v.arithmetic == MultiplyAdd::Fused);
    let width = lanes.map(|v| v.width).max().unwrap_or(1);
    let mut table = Table::new(&["method", "numerators", "quotients", "fastest"]);
    let (mut gains, mut divide) = (Vec::new(), 0);
    let is_timed = |name: &&str| view.throughput.keys().any(|v| v.method == *name);
    for name in view.facts.iter().map(|facts| facts.name.as_str()).filter(is_timed) {
        let [deferred, early, either] = [Some(Form::Deferred), Some(Form::Early), None]
            .map(|division| Times::of(view, name, width, division));
        let columns = [&deferred, &early, &either].map(|times| or_dash(times.gain(), ratio));
        table.rows.push([vec![name.to_owned()], columns.into()].concat());
        gains.extend(deferred.gain());
        divide += usize::from(deferred.hit.zip(early.hit).is_some_and(|(d, e)| e < d));
    }
    gains.sort_by(f64::total_cmp);
    let mut text = String::new();
    if table.rows.is_empty() {
        return text;
    }
    if let (Some(least), Some(most)) = (gains.first(), gains.last()) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "Without a division and without values a test is {} to {} as fast as in full, in the same \
             form, over {} methods. In {divide} of those that have both forms dividing first is faster all \
             the same: the products that numerators take cost more than the division.\n",
            ratio(*least),
            ratio(*most),
            gains.len(),
        );
    }
    text + &markdown::part(view, &table, SAYS)
}
