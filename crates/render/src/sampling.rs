//! Where in a pixel rays go through.

use std::f32::consts::TAU;
use std::fmt;
use std::str::FromStr;

use glam::Vec2;

use crate::random::Random;

/// Which points of a pixel are sampled. All count alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// The middles of so many cells by so many.
    Grid(u32),
    /// So many points, evenly spaced on a circle about the middle; one is the middle itself.
    Circle(u32),
    /// One random point in each of so many cells by so many.
    Jittered(u32),
    /// Two by two jittered points, and as many more by so many where those differ.
    Adaptive(u32),
}

/// The circle's radius, in pixels: half its points' squared distances from the middle are those of points
/// that are evenly spread over the pixel, so that edges are as soft.
const RADIUS: f32 = 0.408_248_3;

/// How much samples of a pixel may differ, in any colour, as the eye sees them (the square root), before
/// more are taken.
pub(crate) const CONTRAST: f32 = 0.04;

impl Sampling {
    /// The name of each kind, with what stands for it.
    pub const NAMES: [&'static str; 4] = ["grid", "circle", "jittered", "adaptive"];

    /// One sample in the middle.
    pub const ONE: Self = Self::Grid(1);

    /// Whether every pixel gets one sample, in its middle.
    pub(crate) fn is_middle(self) -> bool {
        matches!(self, Self::Grid(1) | Self::Circle(1))
    }

    /// How many samples every pixel gets.
    pub fn count(self) -> u32 {
        match self {
            Self::Grid(side) | Self::Jittered(side) => side * side,
            Self::Circle(count) => count,
            Self::Adaptive(_) => 4,
        }
    }

    /// How many more samples the pixels get whose first ones differ.
    pub(crate) fn more(self) -> u32 {
        if let Self::Adaptive(side) = self { side * side } else { 0 }
    }

    /// Where on a thin lens a sample goes through, from 0 to 1: each in a cell of its own, where they are
    /// a square number, in an order that has nothing to do with that in the pixel.
    pub(crate) fn on_lens(self, random: Random) -> Vec2 {
        let [u, v, ..] = random.four(1);
        let (side, sample) = match self {
            Self::Grid(side) | Self::Jittered(side) => (side, random.sample),
            Self::Adaptive(_) if random.sample < 4 => (2, random.sample),
            Self::Adaptive(side) => (side, random.sample - 4),
            Self::Circle(_) => return Vec2::new(u, v),
        };
        // The same for all samples of a pixel; an odd step and a shift reach every cell once, where the
        // count is a power of two, and nearly so elsewhere.
        let [shift, step, ..] = Random { sample: u32::MAX, ..random }.four(1);
        let count = side * side;
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "below the count"
        )]
        let [shift, step] = [shift, step].map(|x| (x * count as f32) as u32);
        let cell = (sample.wrapping_mul(step | 1).wrapping_add(shift)) % count;
        (Vec2::new((cell % side) as f32, (cell / side) as f32) + Vec2::new(u, v)) / side as f32
    }

    /// The point of a sample, from 0 to 1 in the pixel.
    #[inline]
    pub(crate) fn point(self, random: Random) -> Vec2 {
        let sample = random.sample;
        let cell =
            |side: u32, sample: u32| Vec2::new((sample % side) as f32, (sample / side) as f32);
        let jitter = |side: u32, sample: u32| {
            let [u, v, ..] = random.four(0);
            (cell(side, sample) + Vec2::new(u, v)) / side as f32
        };
        match self {
            // One sample, as is mostly asked for first, takes no divisions.
            one if one.is_middle() => Vec2::splat(0.5),
            Self::Grid(side) => (cell(side, sample) + Vec2::splat(0.5)) / side as f32,
            Self::Circle(count) => {
                // Turned by an eighth, so that no two points share a row or a column.
                let (sin, cos) = (TAU * ((sample as f32 + 0.125) / count as f32)).sin_cos();
                Vec2::splat(0.5) + Vec2::new(cos, sin) * RADIUS
            }
            Self::Jittered(side) => jitter(side, sample),
            Self::Adaptive(_) if sample < 4 => jitter(2, sample),
            Self::Adaptive(side) => jitter(side, sample - 4),
        }
    }
}

impl fmt::Display for Sampling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Grid(n) => write!(f, "grid:{n}"),
            Self::Circle(n) => write!(f, "circle:{n}"),
            Self::Jittered(n) => write!(f, "jittered:{n}"),
            Self::Adaptive(n) => write!(f, "adaptive:{n}"),
        }
    }
}

/// No sampling is called so.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no sampling; write grid:N, jittered:N or adaptive:N for N by N samples, circle:N for N, \
     with N from 1 to 64"
)]
pub struct UnknownSampling(String);

impl FromStr for Sampling {
    type Err = UnknownSampling;

    fn from_str(text: &str) -> Result<Self, UnknownSampling> {
        let unknown = || UnknownSampling(text.to_owned());
        let (name, number) = text.split_once(':').ok_or_else(unknown)?;
        let number = number.parse().ok().filter(|n| (1..=64).contains(n)).ok_or_else(unknown)?;
        Ok(match name {
            "grid" => Self::Grid(number),
            "circle" => Self::Circle(number),
            "jittered" => Self::Jittered(number),
            "adaptive" => Self::Adaptive(number),
            _ => return Err(unknown()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(sampling: Sampling) -> Vec<Vec2> {
        (0..sampling.count() + sampling.more())
            .map(|sample| sampling.point(Random { seed: 1, pixel: 7, sample }))
            .collect()
    }

    #[test]
    fn every_cell_has_one_point() {
        for sampling in [Sampling::Grid(5), Sampling::Jittered(5)] {
            let mut seen = [false; 25];
            for point in points(sampling) {
                let cell = (point * 5.0).floor();
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cells")]
                let place = (cell.x + 5.0 * cell.y) as usize;
                assert!(!std::mem::replace(&mut seen[place], true), "{sampling} {point}");
            }
        }
    }

    #[test]
    fn points_on_a_circle_are_equally_far_from_the_middle_and_spread_as_those_of_a_pixel() {
        assert_eq!(points(Sampling::Circle(1)), [Vec2::splat(0.5)]);
        let points = points(Sampling::Circle(8));
        for point in &points {
            assert!(((point - Vec2::splat(0.5)).length() - RADIUS).abs() < 1e-6);
        }
        let spread: f32 = points.iter().map(|point| (point.x - 0.5).powi(2)).sum::<f32>() / 8.0;
        assert!((spread - 1.0 / 12.0).abs() < 1e-6);
    }

    #[test]
    fn samplings_are_read_as_they_are_written() {
        for sampling in
            [Sampling::Grid(1), Sampling::Circle(3), Sampling::Jittered(4), Sampling::Adaptive(64)]
        {
            assert_eq!(sampling.to_string().parse(), Ok(sampling));
        }
        for text in ["grid", "grid:0", "grid:65", "grid:x", "star:3", "circle:-1"] {
            assert!(text.parse::<Sampling>().is_err(), "{text}");
        }
    }
}
