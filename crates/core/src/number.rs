//! What every number a formula is written over can do.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// The arithmetic that formulas use: floats, vectors of floats, exact rationals, and numbers
/// that record what is done to them.
///
/// Whether [`mul_add`](Number::mul_add) rounds once or twice is the policy of the number type,
/// never of the formula.
pub trait Number:
    Copy
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// `self · b + c`.
    #[must_use]
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `self · b − c`.
    #[must_use]
    fn mul_sub(self, b: Self, c: Self) -> Self;
}
