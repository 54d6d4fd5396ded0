//! A number that counts what is done to it.

use core::cell::Cell;
use core::cmp::Ordering;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use trisect_core::Scalar;

/// How often each operation was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ops {
    /// Products; a multiply-add is one product and one sum.
    pub multiplies: u32,
    /// Sums and differences.
    pub adds: u32,
    /// Quotients.
    pub divisions: u32,
    /// Comparisons.
    pub comparisons: u32,
    /// Negations, absolute values and copied signs: one bit operation each.
    pub signs: u32,
}

impl Ops {
    const ZERO: Self = Self { multiplies: 0, adds: 0, divisions: 0, comparisons: 0, signs: 0 };
    const MULTIPLY: Self = Self { multiplies: 1, ..Self::ZERO };
    const ADD: Self = Self { adds: 1, ..Self::ZERO };
    const DIVIDE: Self = Self { divisions: 1, ..Self::ZERO };
    const COMPARE: Self = Self { comparisons: 1, ..Self::ZERO };
    const SIGN: Self = Self { signs: 1, ..Self::ZERO };

    fn zip(self, other: Self, f: impl Fn(u32, u32) -> u32) -> Self {
        Self {
            multiplies: f(self.multiplies, other.multiplies),
            adds: f(self.adds, other.adds),
            divisions: f(self.divisions, other.divisions),
            comparisons: f(self.comparisons, other.comparisons),
            signs: f(self.signs, other.signs),
        }
    }
}

impl Add for Ops {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl AddAssign for Ops {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Ops {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

thread_local! {
    static DONE: Cell<Ops> = const { Cell::new(Ops::ZERO) };
}

fn count(ops: Ops) {
    DONE.with(|done| done.set(done.get() + ops));
}

/// What `f` did to [`Counting`] numbers on this thread.
pub fn counted<R>(f: impl FnOnce() -> R) -> (Ops, R) {
    let before = DONE.with(Cell::get);
    let result = f();
    (DONE.with(Cell::get) - before, result)
}

/// An f64 that counts its own operations; see [`counted`].
///
/// A product with the constant 1, which a formula gets from
/// [`Scalar::from_f64`], is none: the compiler leaves it out.
/// Numbers that are data come from [`Counting::data`].
#[derive(Clone, Copy, Debug)]
pub struct Counting {
    value: f64,
    is_constant_one: bool,
}

impl Counting {
    /// A number that is not known before the formula runs.
    pub const fn data(value: f64) -> Self {
        Self { value, is_constant_one: false }
    }

    /// The same number, stored and read again: not known before the formula runs.
    pub const fn into_data(self) -> Self {
        Self::data(self.value)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $ops:expr) => {
        impl $trait for Counting {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                count($ops);
                Self::data($trait::$method(self.value, other.value))
            }
        }
    };
}
operator!(Add, add, Ops::ADD);
operator!(Sub, sub, Ops::ADD);
operator!(Div, div, Ops::DIVIDE);

impl Mul for Counting {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        if self.is_constant_one {
            return other;
        }
        if other.is_constant_one {
            return self;
        }
        count(Ops::MULTIPLY);
        Self::data(self.value * other.value)
    }
}

impl Neg for Counting {
    type Output = Self;
    fn neg(self) -> Self {
        count(Ops::SIGN);
        Self::data(-self.value)
    }
}

impl PartialEq for Counting {
    fn eq(&self, other: &Self) -> bool {
        count(Ops::COMPARE);
        self.value == other.value
    }
}

impl PartialOrd for Counting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        count(Ops::COMPARE);
        self.value.partial_cmp(&other.value)
    }
}

trisect_core::single_lane!(Counting {
    fn reciprocal_estimate(self) -> Self {
        Self::data(1.0) / self
    }
    fn xor_sign(self, s: Self) -> Self {
        count(Ops::SIGN);
        Self::data(self.value.xor_sign(s.value))
    }
});

impl Scalar for Counting {
    fn from_f64(value: f64) -> Self {
        Self { value, is_constant_one: value == 1.0 }
    }
    fn to_f64(self) -> f64 {
        self.value
    }
    fn abs(self) -> Self {
        count(Ops::SIGN);
        Self::data(self.value.abs())
    }
}

#[cfg(test)]
mod tests {
    use trisect_core::{Lanes, Number as _};

    use super::*;

    #[test]
    fn a_multiply_add_is_a_product_and_a_sum() {
        let x = Counting::data(2.0);
        let (ops, y) = counted(|| x.mul_add(x, -x));
        assert_eq!(y.value, 2.0);
        assert_eq!(ops, Ops { multiplies: 1, adds: 1, signs: 1, ..Ops::default() });
    }

    #[test]
    fn comparisons_and_quotients_are_counted_once() {
        let x = Counting::data(2.0);
        let (ops, _) = counted(|| Lanes::ge(x / x, x));
        assert_eq!(ops, Ops { divisions: 1, comparisons: 1, ..Ops::default() });
    }

    #[test]
    fn a_product_with_the_constant_one_is_free() {
        let x = Counting::data(2.0);
        let (ops, y) = counted(|| x * Counting::from_f64(1.0) + Counting::data(1.0) * x);
        assert_eq!(y.value, 4.0);
        assert_eq!(ops, Ops { multiplies: 1, adds: 1, ..Ops::default() });
    }

    #[test]
    fn a_product_with_a_stored_one_is_counted() {
        let x = Counting::data(2.0);
        let (ops, y) = counted(|| x * Counting::from_f64(1.0).into_data());
        assert_eq!(y.value, 2.0);
        assert_eq!(ops, Ops { multiplies: 1, ..Ops::default() });
    }
}
