//! Axes: how values become places, and which of them are marked.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged};

use crate::format::times_power_of_ten;

/// How values become places.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// In proportion.
    Linear,
    /// Decades, or 1-2-5 steps where there are few. Zeros lie on a floor line below all values.
    Log,
    /// Powers of two, for sizes in memory.
    Binary,
}

/// The largest end of an axis: the last decade of floats.
const LARGEST: f64 = 1e308;

/// An axis: its name, scale and ends.
#[derive(Clone)]
pub struct Axis {
    pub(crate) name: String,
    scale: Scale,
    low: f64,
    high: f64,
    /// Whether `low` stands for zero.
    floor: bool,
    /// Ends of a stretch without values that is drawn short, with a break in the axis.
    pub(crate) gap: Option<(f64, f64)>,
    write: fn(f64) -> String,
}

impl Axis {
    /// An axis that holds all values. A linear axis starts at the smallest value given, so pass
    /// a 0 where lengths are read.
    pub fn over(
        name: &str,
        scale: Scale,
        values: impl IntoIterator<Item = f64>,
        write: fn(f64) -> String,
    ) -> Self {
        let (mut low, mut high, mut zeros) = (f64::INFINITY, f64::NEG_INFINITY, false);
        for value in values.into_iter().filter(|x| x.is_finite()) {
            high = high.max(value);
            if scale == Scale::Linear || value > 0.0 {
                low = low.min(value);
            } else {
                zeros = true;
            }
        }
        if !low.is_finite() {
            (low, high) = if scale == Scale::Linear { (0.0, 1.0) } else { (0.1, 1.0) };
        }
        let (low, high) = match scale {
            Scale::Linear if low == high => (low - 0.5, high + 0.5),
            Scale::Linear => (low, high),
            // A little air tells a point from the frame; zeros need a decade of their own.
            Scale::Log if high / low > 30.0 || zeros => {
                (low / if zeros { 14.0 } else { 1.4 }, high * 1.4)
            }
            Scale::Log => (low / 1.15, high * 1.15),
            Scale::Binary => (low / 1.3, high * 1.3),
        };
        let high = high.min(LARGEST);
        Self { name: name.into(), scale, low, high, floor: zeros, gap: None, write }
    }

    /// The same logarithmic axis, broken where its values leave more than three decades empty,
    /// so that what differs little within a cluster does not vanish.
    #[must_use]
    pub fn broken(mut self, values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> =
            values.into_iter().filter(|x| *x > 0.0 && x.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let pairs = sorted.windows(2).map(|w| (w[0], w[1]));
        let widest = pairs.max_by(|a, b| (a.1 / a.0).total_cmp(&(b.1 / b.0)));
        if let (Some((below, above)), false) = (widest, self.floor)
            && above / below > 1e3
        {
            self.low = sorted[0] / 1.6;
            self.high = (sorted[sorted.len() - 1] * 1.6).min(LARGEST);
            self.gap = Some((below * 1.6, above / 1.6));
        }
        self
    }

    /// Whether a stretch of it is drawn short.
    pub fn is_broken(&self) -> bool {
        self.gap.is_some()
    }

    /// The same linear axis with air on both sides.
    #[must_use]
    pub fn with_margin(mut self) -> Self {
        let air = (self.high - self.low) * 0.06;
        self.low -= air;
        self.high += air;
        self
    }

    /// The same axis with room on the right for text.
    pub(crate) fn with_room(mut self, share: f64) -> Self {
        match self.scale {
            Scale::Linear => self.high += (self.high - self.low) * share,
            Scale::Log | Scale::Binary => self.high *= (self.high / self.low).powf(share),
        }
        self.high = self.high.min(LARGEST);
        self
    }

    /// Where a value lies between the places of both ends.
    fn place(&self, x: f64) -> f64 {
        let x = x.max(self.low).min(self.high);
        if self.scale == Scale::Linear {
            return x;
        }
        let x = x.log10();
        let Some((from, to)) = self.gap.map(|(a, b)| (a.log10(), b.log10())) else {
            return x;
        };
        // The break takes a tenth of what the values take.
        let short = (self.high.log10() - self.low.log10() - (to - from)) / 10.0;
        if x <= from {
            x
        } else if x < to {
            from + (x - from) / (to - from) * short
        } else {
            x - (to - from) + short
        }
    }

    /// Whether its ticks are few enough to be written in full.
    fn is_short(&self) -> bool {
        self.high / self.low <= 300.0 && !self.floor && self.gap.is_none()
    }

    /// What stands beside a tick.
    pub(crate) fn label(&self, tick: f64) -> String {
        match self.scale {
            Scale::Log if self.floor && tick <= self.low => "0".into(),
            Scale::Log if !self.is_short() => times_power_of_ten(tick),
            _ => (self.write)(tick),
        }
    }

    /// At most `count` values, smallest first.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "exponents of finite floats, and steps of at least 1"
    )]
    pub(crate) fn ticks(&self, count: usize) -> Vec<f64> {
        let count = count.max(2) as f64;
        let inside =
            |x: &f64| *x >= self.low * (1.0 - 1e-9) - 1e-300 && *x <= self.high * (1.0 + 1e-9);
        match self.scale {
            Scale::Linear => {
                let raw = (self.high - self.low) / count;
                if !raw.is_normal() {
                    return Vec::new();
                }
                let ten = 10f64.powf(raw.log10().floor());
                let step =
                    [1.0, 2.0, 2.5, 5.0, 10.0].map(|m| m * ten).into_iter().find(|s| *s >= raw);
                let step = step.unwrap_or(raw);
                let first = (self.low / step - 1e-9).ceil() as i64;
                let last = (self.high / step + 1e-9).floor() as i64;
                (first..=last).map(|i| i as f64 * step).collect()
            }
            Scale::Log => {
                let (first, last) = (self.low.log10().floor(), self.high.log10().ceil());
                let stepped = |steps: &'static [f64]| {
                    (first as i32..=last as i32)
                        .flat_map(|e| steps.iter().map(move |s| s * 10f64.powi(e)))
                        .filter(inside)
                };
                if let Some((from, to)) = self.gap {
                    let decades = self.high.log10() - self.low.log10() - (to / from).log10();
                    let steps: &[f64] =
                        if decades * 3.0 < count { &[1.0, 2.0, 5.0] } else { &[1.0] };
                    return stepped(steps).filter(|x| *x <= from || *x >= to).collect();
                }
                if self.is_short() {
                    let few: &[f64] = &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0];
                    let is_few = self.high / self.low < 6.0;
                    return stepped(if is_few { few } else { &[1.0, 2.0, 5.0] }).collect();
                }
                let (first, last) = (self.low.log10().ceil(), self.high.log10().floor());
                let step = ((last - first) / count).ceil().max(1.0) as usize;
                let decades = (first as i32..=last as i32).rev().step_by(step);
                let mut ticks: Vec<f64> = decades
                    .map(|e| 10f64.powi(e))
                    .filter(|x| inside(x) && (!self.floor || *x > self.low * 5.0))
                    .collect();
                if self.floor {
                    ticks.push(self.low);
                }
                ticks.reverse();
                ticks
            }
            Scale::Binary => {
                let (first, last) = (self.low.log2().ceil(), self.high.log2().floor());
                let step = ((last - first) / count).ceil().max(1.0) as i32;
                // Aligned to the step, so that KiB and MiB fall on ticks.
                ((first as i32).div_euclid(step)..=(last as i32).div_euclid(step))
                    .map(|i| 2f64.powi(i * step))
                    .filter(inside)
                    .collect()
            }
        }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let (low, high) = (self.place(self.low), self.place(self.high));
        let share = (self.place(*value) - low) / (high - low);
        let pixels = f64::from(to - from) * share;
        #[expect(clippy::cast_possible_truncation, reason = "pixels of a drawing")]
        let pixels =
            if to > from { (pixels + 1e-3).floor() } else { (pixels - 1e-3).ceil() } as i32;
        from + pixels
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        self.ticks(hint.max_num_points())
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}
