//! The weight of corner `A`: computed, or implied by the two others.

use trisect_core::{Lanes, Scalar};

/// How a method knows the weight of corner `A`, and so whether a point is inside.
pub trait Alpha<L: Lanes>: Copy {
    /// `alpha · factor`
    #[must_use]
    fn scale(self, factor: L) -> Self;
    /// `alpha` with its sign flipped where `s` is negative.
    #[must_use]
    fn xor_sign(self, s: L) -> Self;
    /// The weight itself, `whole` being the sum of all.
    fn weight(self, beta: L, gamma: L, whole: L) -> L;
    /// Where all weights are at least zero, `whole` being their sum.
    fn inside(self, beta: L, gamma: L, whole: L) -> L::Mask;
}

/// `alpha` is what `beta` and `gamma` leave of the whole: `beta + gamma ≤ whole` is the test.
#[derive(Clone, Copy, Debug)]
pub struct Implied;

impl<L: Lanes> Alpha<L> for Implied {
    #[inline(always)]
    fn scale(self, _factor: L) -> Self {
        self
    }
    #[inline(always)]
    fn xor_sign(self, _s: L) -> Self {
        self
    }
    #[inline(always)]
    fn weight(self, beta: L, gamma: L, whole: L) -> L {
        whole - beta - gamma
    }
    #[inline(always)]
    fn inside(self, beta: L, gamma: L, whole: L) -> L::Mask {
        let zero = whole.constant(L::Elem::from_f64(0.0));
        // One comparison less; a NaN that the lesser of the two loses is in their sum.
        beta.min(gamma).ge(zero) & (beta + gamma).le(whole)
    }
}

/// `alpha` is computed as the others are, from its own edge: three signs decide, and neighbours
/// that compute the same number for a shared edge decide alike.
#[derive(Clone, Copy, Debug)]
pub struct Given<L>(pub L);

impl<L: Lanes> Alpha<L> for Given<L> {
    #[inline(always)]
    fn scale(self, factor: L) -> Self {
        Self(self.0 * factor)
    }
    #[inline(always)]
    fn xor_sign(self, s: L) -> Self {
        Self(self.0.xor_sign(s))
    }
    #[inline(always)]
    fn weight(self, _beta: L, _gamma: L, _whole: L) -> L {
        self.0
    }
    #[inline(always)]
    fn inside(self, beta: L, gamma: L, whole: L) -> L::Mask {
        let zero = whole.constant(L::Elem::from_f64(0.0));
        self.0.ge(zero) & beta.ge(zero) & gamma.ge(zero)
    }
}
