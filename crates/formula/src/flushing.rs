//! A number that flushes subnormal numbers to zero, as processors do that are told to.

use core::cmp::Ordering;
use core::ops::{Add, Div, Mul, Neg, Sub};

use trisect_core::Scalar;

/// An f32 as a processor computes with it in the modes "flush to zero" and "denormals are zero"
/// (Intel 64 and IA-32 Architectures Software Developer's Manual, volume 1, sections 10.2.3.3 and
/// 10.2.3.4): subnormal operands count as zeros of their sign, and so do subnormal results.
///
/// Programs that hold a host in that mode, as audio hosts and Embree's advice have it, get these
/// answers from the kernels. The mode itself cannot be set in sound Rust; a formula over this number
/// shows what it does, on every machine.
#[derive(Clone, Copy, Debug)]
pub struct Flushing(f32);

/// The number itself, a zero of its sign where it is subnormal.
#[inline(always)]
fn flushed(x: f32) -> f32 {
    if x.is_subnormal() { 0.0_f32.copysign(x) } else { x }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl $trait for Flushing {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(flushed($trait::$method(flushed(self.0), flushed(other.0))))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl Neg for Flushing {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl PartialEq for Flushing {
    #[inline(always)]
    fn eq(&self, other: &Self) -> bool {
        flushed(self.0) == flushed(other.0)
    }
}

impl PartialOrd for Flushing {
    #[inline(always)]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        flushed(self.0).partial_cmp(&flushed(other.0))
    }
}

trisect_core::single_lane!(Flushing {
    #[inline(always)]
    fn reciprocal_estimate(self) -> Self {
        Self(1.0) / self
    }
    #[inline(always)]
    fn xor_sign(self, s: Self) -> Self {
        Self(self.0.xor_sign(s.0))
    }
});

impl Scalar for Flushing {
    #[allow(clippy::cast_possible_truncation, reason = "the nearest f32 is what it stands for")]
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self(x as f32)
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self.0)
    }
    #[inline(always)]
    fn largest_t() -> Self {
        Self(f32::largest_t())
    }
    #[inline(always)]
    fn smallest_det() -> Self {
        Self(f32::smallest_det())
    }
    fn are_collinear(points: [[Self; 3]; 3]) -> bool {
        f32::are_collinear(points.map(|point| point.map(|x| flushed(x.0))))
    }
    #[inline(always)]
    fn unit_roundoff() -> Self {
        Self(f32::unit_roundoff())
    }
    #[inline(always)]
    fn splitter() -> Self {
        Self(f32::splitter())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subnormal_operands_and_results_are_zeros_of_their_sign() {
        let (smallest, tiny) = (Flushing(f32::MIN_POSITIVE), Flushing(-1e-40));
        assert_eq!((smallest * Flushing(0.5)).0.to_bits(), 0);
        assert_eq!((smallest * Flushing(-0.5)).0.to_bits(), (-0.0_f32).to_bits());
        assert_eq!((tiny * Flushing(1e30)).0.to_bits(), (-0.0_f32).to_bits());
        assert_eq!((Flushing(1.0) / tiny).0, f32::NEG_INFINITY);
        assert_eq!(tiny.partial_cmp(&Flushing(0.0)), Some(Ordering::Equal));
        assert_eq!((smallest + smallest).0, 2.0 * f32::MIN_POSITIVE);
        // A number that is only handed on keeps its bits.
        assert_eq!((-tiny).0, 1e-40);
    }
}
