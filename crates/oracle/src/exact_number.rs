//! An exact number that runs the generic formulas.

use core::cell::RefCell;
use core::cmp::Ordering;
use core::fmt;
use core::ops::{Add, Div, Mul, Neg, Sub};

use dashu_ratio::RBig;
use trisect_core::Scalar;

thread_local! {
    static ARENA: RefCell<Vec<RBig>> = const { RefCell::new(Vec::new()) };
}

/// A rational number that is `Copy`, so that a formula written over
/// [`Lanes`](trisect_core::Lanes) runs in exact arithmetic.
///
/// It is a handle into an arena of its thread, made and cleared by [`Exact::scope`]. A handle is
/// good on the thread that made it until the scope in which it was made ends; used elsewhere it
/// names another number or panics, but is never unsound.
///
/// ```
/// use trisect_oracle::Exact;
/// use trisect_core::Scalar;
///
/// Exact::scope(|| {
///     let third = Exact::from_f64(1.0) / Exact::from_f64(3.0);
///     assert_eq!(third + third + third, Exact::from_f64(1.0));
/// });
/// ```
#[derive(Clone, Copy)]
pub struct Exact(u32);

/// Forgets the numbers of a scope when it ends, by panic too.
struct Scope {
    start: usize,
}

impl Drop for Scope {
    fn drop(&mut self) {
        ARENA.with_borrow_mut(|arena| arena.truncate(self.start));
    }
}

impl Exact {
    /// Runs `f` and then forgets every number made in it. Scopes nest.
    ///
    /// What leaves the scope must leave as [`to_rational`](Exact::to_rational) or
    /// [`to_f64`](Scalar::to_f64).
    pub fn scope<R>(f: impl FnOnce() -> R) -> R {
        let _scope = Scope { start: ARENA.with_borrow(Vec::len) };
        f()
    }

    /// The number equal to `x`.
    ///
    /// # Panics
    /// When the arena holds 2³² numbers.
    pub fn from_rational(x: RBig) -> Self {
        ARENA.with_borrow_mut(|arena| {
            let index = u32::try_from(arena.len()).expect("fewer than 2^32 numbers in a scope");
            arena.push(x);
            Self(index)
        })
    }

    /// The rational it stands for.
    ///
    /// # Panics
    /// When its scope has ended and no other number has taken its place.
    pub fn to_rational(self) -> RBig {
        ARENA.with_borrow(|arena| arena[self.0 as usize].clone())
    }

    fn with2<R>(self, other: Self, f: impl FnOnce(&RBig, &RBig) -> R) -> R {
        ARENA.with_borrow(|arena| f(&arena[self.0 as usize], &arena[other.0 as usize]))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $($doc:literal)*) => {
        $(#[doc = $doc])*
        impl $trait for Exact {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self::from_rational(self.with2(other, |a, b| $trait::$method(a, b)))
            }
        }
    };
}
operator!(Add, add,);
operator!(Sub, sub,);
operator!(Mul, mul,);
operator!(Div, div, "Panics when the divisor is zero.");

impl Neg for Exact {
    type Output = Self;
    fn neg(self) -> Self {
        Self::from_rational(-self.to_rational())
    }
}

impl PartialEq for Exact {
    fn eq(&self, other: &Self) -> bool {
        self.with2(*other, |a, b| a == b)
    }
}

impl PartialOrd for Exact {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.with2(*other, Ord::cmp))
    }
}

impl fmt::Debug for Exact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.to_rational())
    }
}

trisect_core::single_lane!(Exact {
    /// The true reciprocal. Panics when `self` is zero.
    fn reciprocal_estimate(self) -> Self {
        Self::from_rational(RBig::ONE) / self
    }
    /// Flips the sign where `s < 0`; a rational zero has no sign.
    fn xor_sign(self, s: Self) -> Self {
        if s < Self::from_rational(RBig::ZERO) { -self } else { self }
    }
});

impl Scalar for Exact {
    /// The number equal to `x`. Panics when `x` is NaN or infinite.
    fn from_f64(x: f64) -> Self {
        Self::from_rational(RBig::try_from(x).expect("a rational is finite"))
    }
    fn to_f64(self) -> f64 {
        self.to_rational().to_f64().value()
    }
}

#[cfg(test)]
mod tests {
    use trisect_core::{Lanes as _, Number as _};

    use super::*;

    #[test]
    fn arithmetic_is_exact() {
        Exact::scope(|| {
            let x = Exact::from_f64(0.1);
            let y = Exact::from_f64(1e-300);
            assert_eq!((x + y) - x, y);
            assert_eq!(x.mul_add(y, x) - x, x * y);
            assert_eq!(x.mul_sub(y, x) + x, x * y);
            assert_eq!((x / y) * y, x);
            assert_eq!(x.reciprocal_estimate() * x, Exact::from_f64(1.0));
            assert_eq!((-x).abs(), x);
            assert!(y.lt(x) && x.gt(y) && x.le(x) && x.ge(y) && !x.lt(y));
            assert_eq!((x + y).to_f64(), 0.1);
        });
    }

    #[test]
    fn signs_flip_below_zero_only() {
        Exact::scope(|| {
            let [minus, zero, one] = [-1.0, -0.0, 1.0].map(Exact::from_f64);
            assert_eq!(one.xor_sign(minus), minus);
            assert_eq!(one.xor_sign(zero), one);
            assert_eq!(one.xor_sign(one), one);
        });
    }

    #[test]
    fn scopes_nest_and_clear() {
        let length = || ARENA.with_borrow(Vec::len);
        Exact::scope(|| {
            let x = Exact::from_f64(2.0);
            let squared = Exact::scope(|| (x * x).to_rational());
            assert_eq!(length(), 1);
            assert_eq!(Exact::from_rational(squared), x + x);
        });
        assert_eq!(length(), 0);
        assert!(std::panic::catch_unwind(|| Exact::scope(|| Exact::from_f64(f64::NAN))).is_err());
        assert_eq!(length(), 0);
    }

    #[test]
    #[should_panic(expected = "must not be zero")]
    fn division_by_zero_panics() {
        Exact::scope(|| {
            let _ = Exact::from_f64(1.0) / Exact::from_f64(0.0);
        });
    }
}
