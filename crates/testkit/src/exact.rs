//! A number that never rounds.

use core::cell::RefCell;
use core::cmp::Ordering;
use core::ops::{Add, Div, Mul, Neg, Sub};

use dashu::base::Abs;
use dashu::rational::RBig;
use trisect_core::{Lanes, Number, Scalar};

thread_local! {
    /// The values behind the handles of this thread.
    static VALUES: RefCell<Vec<RBig>> = const { RefCell::new(Vec::new()) };
}

/// A rational, as a handle that copies. Quotients by zero are undefined, and so is whatever is
/// computed from them; comparisons with them are false.
///
/// Handles belong to the thread and to the [`scope`] that made them.
#[derive(Clone, Copy, Debug)]
pub struct Exact(Option<u32>);

/// Runs `f` and lets go of the numbers made in it.
pub fn scope<R>(f: impl FnOnce() -> R) -> R {
    let kept = VALUES.with_borrow(Vec::len);
    let result = f();
    VALUES.with_borrow_mut(|values| values.truncate(kept));
    result
}

impl Exact {
    /// A handle to `value`.
    ///
    /// # Panics
    /// When the scope holds 2³² numbers already.
    pub fn new(value: RBig) -> Self {
        VALUES.with_borrow_mut(|values| {
            let handle = u32::try_from(values.len()).expect("a scope makes fewer numbers");
            values.push(value);
            Self(Some(handle))
        })
    }

    /// The number, where it is defined.
    pub fn value(self) -> Option<RBig> {
        self.0.map(|handle| VALUES.with_borrow(|values| values[handle as usize].clone()))
    }

    fn with(self, other: Self, f: impl FnOnce(RBig, RBig) -> Option<RBig>) -> Self {
        match (self.value(), other.value()) {
            (Some(a), Some(b)) => f(a, b).map_or(Self(None), Self::new),
            _ => Self(None),
        }
    }
}

impl Add for Exact {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| Some(a + b))
    }
}
impl Sub for Exact {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.with(other, |a, b| Some(a - b))
    }
}
impl Mul for Exact {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.with(other, |a, b| Some(a * b))
    }
}
impl Div for Exact {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self.with(other, |a, b| (b != RBig::ZERO).then(|| a / b))
    }
}
impl Neg for Exact {
    type Output = Self;
    fn neg(self) -> Self {
        self.value().map_or(self, |x| Self::new(-x))
    }
}

impl PartialEq for Exact {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}
impl PartialOrd for Exact {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.value()?.cmp(&other.value()?))
    }
}

impl Number for Exact {
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }
    fn mul_sub(self, b: Self, c: Self) -> Self {
        self * b - c
    }
}

impl Lanes for Exact {
    type Elem = Self;
    type Mask = bool;
    type Token = ();
    const FUSED: bool = false;
    const N: usize = 1;

    fn splat((): (), x: Self) -> Self {
        x
    }
    fn load((): (), xs: &[Self]) -> Self {
        xs[0]
    }
    fn store(self, xs: &mut [Self]) {
        xs[0] = self;
    }
    fn token(self) {}
    fn reciprocal_estimate(self) -> Self {
        Self::from_f64(1.0) / self
    }
    fn lt(self, b: Self) -> bool {
        self < b
    }
    fn le(self, b: Self) -> bool {
        self <= b
    }
    fn xor_sign(self, s: Self) -> Self {
        if s < Self::from_f64(0.0) { -self } else { self }
    }
    fn select(m: bool, a: Self, b: Self) -> Self {
        if m { a } else { b }
    }
    fn any(m: bool) -> bool {
        m
    }
    fn bits(m: bool) -> u64 {
        u64::from(m)
    }
}

impl Scalar for Exact {
    /// Undefined where `x` is not finite.
    fn from_f64(x: f64) -> Self {
        RBig::try_from(x).map_or(Self(None), Self::new)
    }
    fn to_f64(self) -> f64 {
        self.value().map_or(f64::NAN, |x| x.to_f64().value())
    }
    fn abs(self) -> Self {
        self.value().map_or(self, |x| Self::new(x.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_times_three_is_one() {
        let number = Exact::from_f64;
        assert_eq!(number(1.0) / number(3.0) * number(3.0), number(1.0));
    }

    #[test]
    fn a_quotient_by_zero_compares_false_with_everything() {
        let undefined = Exact::from_f64(1.0) / Exact::from_f64(0.0);
        assert!(!undefined.le(undefined) && !undefined.lt(Exact::from_f64(0.0)));
        assert_eq!((undefined + undefined).value(), None);
    }

    #[test]
    fn a_scope_lets_go_of_its_numbers() {
        let before = VALUES.with_borrow(Vec::len);
        scope(|| Exact::from_f64(1.0) + Exact::from_f64(2.0));
        assert_eq!(VALUES.with_borrow(Vec::len), before);
    }
}
