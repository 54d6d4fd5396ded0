//! N numbers that move in step: the type every kernel is written against.
//!
//! Two implementations: the scalars `f32` and `f64` (N = 1), which are here, and [`Vector`](crate::Vector).

use core::fmt::Debug;
use core::ops::{BitAnd, BitOr};

use fearless_simd::SimdFloatElement;

use crate::collinear;
use crate::format::FloatFormat;
use crate::instruction_set::Token;
use crate::number::Number;

/// N numbers that move in step; N = 1 is the scalar.
///
/// Comparisons with NaN are false in every lane that holds one.
pub trait Lanes: Number {
    /// One lane's number.
    type Elem: Scalar;
    /// One truth value per lane.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;
    /// Proof that the processor has the instructions; `()` for scalars.
    type Token: Token;
    /// Whether the lanes were asked to round `a · b + c` once; see [`Fused`](crate::Fused).
    const FUSED: bool;
    /// Whether `a · b + c` is rounded once, so that no product in it overflows.
    const ONE_ROUNDING: bool = false;
    /// How many lanes.
    const N: usize;

    /// `x` in every lane.
    fn splat(token: Self::Token, x: Self::Elem) -> Self;
    /// The first N elements of `xs`.
    ///
    /// # Panics
    /// When `xs` has fewer than N elements.
    fn load(token: Self::Token, xs: &[Self::Elem]) -> Self;
    /// Writes the lanes to the first N elements of `xs`.
    ///
    /// # Panics
    /// When `xs` has fewer than N elements.
    fn store(self, xs: &mut [Self::Elem]);
    /// The token these lanes were made with.
    fn token(self) -> Self::Token;
    /// `x` in every lane, with this value's token.
    #[inline(always)]
    #[must_use]
    fn constant(self, x: Self::Elem) -> Self {
        Self::splat(self.token(), x)
    }
    /// An estimate of `1 / self`: at least eleven bits where the instruction set has one for the
    /// precision, the true quotient elsewhere.
    #[must_use]
    fn reciprocal_estimate(self) -> Self;
    /// `self < b`
    fn lt(self, b: Self) -> Self::Mask;
    /// `self ≤ b`
    fn le(self, b: Self) -> Self::Mask;
    /// `self > b`
    #[inline(always)]
    fn gt(self, b: Self) -> Self::Mask {
        b.lt(self)
    }
    /// `self ≥ b`
    #[inline(always)]
    fn ge(self, b: Self) -> Self::Mask {
        b.le(self)
    }
    /// Where `least ≤ self ≤ most`, both of which are positive.
    #[inline(always)]
    fn is_within(self, least: Self::Elem, most: Self::Elem) -> Self::Mask {
        self.ge(self.constant(least)) & self.le(self.constant(most))
    }
    /// `self` with its sign flipped where `s` is negative (sign bit set): `|s|` is
    /// `s.xor_sign(s)`.
    #[must_use]
    fn xor_sign(self, s: Self) -> Self;
    /// The magnitude of `self`, negative where the sign bits of `all` are not the same.
    #[inline(always)]
    #[must_use]
    fn negative_unless_alike<const K: usize>(self, all: [Self; K]) -> Self {
        let (size, zero) = (self.magnitude(), self.constant(Self::Elem::from_f64(0.0)));
        let one = self.constant(Self::Elem::from_f64(1.0));
        all.into_iter().fold(size, |signed, x| {
            Self::select(one.xor_sign(all[0]).xor_sign(x).lt(zero), -size, signed)
        })
    }
    /// Where `self` is zero, of either sign.
    #[inline(always)]
    fn is_zero(self) -> Self::Mask {
        let zero = self.constant(Self::Elem::from_f64(0.0));
        self.le(zero) & self.ge(zero)
    }
    /// The number itself, or NaN where it is infinite: what is divided by it then never hits.
    #[allow(clippy::eq_op, reason = "x − x is NaN where x is infinite")]
    #[inline(always)]
    #[must_use]
    fn or_nan(self) -> Self {
        self + (self - self)
    }
    /// The magnitude.
    #[inline(always)]
    #[must_use]
    fn magnitude(self) -> Self {
        self.xor_sign(self)
    }
    /// The smaller of two; `b` where either is NaN.
    #[inline(always)]
    #[must_use]
    fn min(self, b: Self) -> Self {
        Self::select(self.lt(b), self, b)
    }
    /// The larger of two; `b` where either is NaN.
    #[inline(always)]
    #[must_use]
    fn max(self, b: Self) -> Self {
        Self::select(self.gt(b), self, b)
    }
    /// The one of two whose bits are the larger whole number: the smaller one where any is negative, and otherwise
    /// the larger. Of zeros of either sign any. Quicker than [`max`](Lanes::max).
    #[inline(always)]
    #[must_use]
    fn max_bits(self, b: Self) -> Self {
        let (least, most) = (Self::min(self, b), Self::max(self, b));
        Self::select(least.lt(self.constant(Self::Elem::from_f64(0.0))), least, most)
    }
    /// The one of two whose bits are the smaller whole number: the other one than of [`max_bits`](Lanes::max_bits).
    #[inline(always)]
    #[must_use]
    fn min_bits(self, b: Self) -> Self {
        let (least, most) = (Self::min(self, b), Self::max(self, b));
        Self::select(least.lt(self.constant(Self::Elem::from_f64(0.0))), most, least)
    }
    /// `a` where `m` holds, else `b`.
    #[must_use]
    fn select(m: Self::Mask, a: Self, b: Self) -> Self;
    /// The lanes of both in turn, `a₀ b₀ a₁ b₁ …`: the first half of them, and the second.
    #[must_use]
    fn interleave(self, b: Self) -> (Self, Self);
    /// Whether any lane holds.
    fn any(m: Self::Mask) -> bool;
    /// Lane i in bit i.
    fn bits(m: Self::Mask) -> u64;
}

/// A single number: what triangles are prepared in.
pub trait Scalar:
    Lanes<Elem = Self, Mask = bool, Token = ()> + PartialOrd + Debug + Send + Sync + 'static
{
    /// The nearest number to `x`.
    fn from_f64(x: f64) -> Self;
    /// The nearest f64.
    fn to_f64(self) -> f64;
    /// The largest `t` that counts as a hit, whatever `tmax` says: half the largest finite
    /// number, so that no quotient near it rounds to infinity.
    #[inline(always)]
    fn largest_t() -> Self {
        Self::from_f64(f64::MAX / 2.0)
    }
    /// The smallest denominator that is divided by: the smallest normal number. The reciprocal of
    /// a smaller one may be infinite.
    #[inline(always)]
    fn smallest_det() -> Self {
        Self::from_f64(f64::MIN_POSITIVE)
    }
    /// Whether three points, by their coordinates, lie on one line; see
    /// [`Triangle::is_degenerate`](crate::Triangle::is_degenerate). This is the answer of the number's own
    /// arithmetic, for numbers that do not round.
    fn are_collinear([a, b, c]: [[Self; 3]; 3]) -> bool {
        let edge = |to: [Self; 3]| [0, 1, 2].map(|axis| to[axis] - a[axis]);
        let (p, q) = (edge(b), edge(c));
        [(1, 2), (2, 0), (0, 1)].into_iter().all(|(u, v)| p[u] * q[v] == p[v] * q[u])
    }
    /// The unit roundoff of the precision: half the distance from 1 to the next number.
    #[inline(always)]
    fn unit_roundoff() -> Self {
        Self::from_f64(f64::EPSILON / 2.0)
    }
    /// `2^s + 1` for Veltkamp's splitting of a number of `p` significant bits into halves of
    /// `p − s` and `s − 1` bits, `s = ⌈p/2⌉`.
    #[inline(always)]
    fn splitter() -> Self {
        Self::from_f64(f64::from((1_u32 << 27) + 1))
    }
    /// `|self|`
    #[must_use]
    #[inline(always)]
    fn abs(self) -> Self {
        if self < Self::from_f64(0.0) { -self } else { self }
    }
}

/// A machine float: `f32` or `f64`.
pub trait Float: Scalar + SimdFloatElement {
    /// The format that the type has.
    const FORMAT: FloatFormat;
    /// The sign bit alone.
    const SIGN: <Self as SimdFloatElement>::Bits;
    /// Bits of the significand: 24 or 53.
    const SIGNIFICANT_BITS: i32;
    /// Unit roundoff: 2⁻²⁴ or 2⁻⁵³.
    const UNIT_ROUNDOFF: f64;
    /// The bits of the number, widened.
    fn bits64(self) -> u64;
    /// The number with these bits; those beyond its own are dropped.
    fn from_bits64(bits: u64) -> Self;
    /// The number whose bits are the uppermost of these: a random one, of 64 random bits.
    #[inline(always)]
    fn from_upper_bits(bits: u64) -> Self {
        Self::from_bits64(bits >> (64 - 8 * size_of::<Self>()))
    }
}

/// Implements [`Number`] and [`Lanes`] for a number of width 1 with operators and `PartialOrd`:
/// floats here, exact numbers and others elsewhere. The braces hold what is its own:
/// `reciprocal_estimate` and `xor_sign`.
///
/// Arithmetic is plain: a fused multiply-add outside the instructions that have it is a library
/// call.
#[macro_export]
macro_rules! single_lane {
    ($number:ty { $($own:tt)* }) => {
        impl $crate::Number for $number {
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                self * b + c
            }
            #[inline(always)]
            fn mul_sub(self, b: Self, c: Self) -> Self {
                self * b - c
            }
        }

        impl $crate::Lanes for $number {
            type Elem = Self;
            type Mask = bool;
            type Token = ();
            const FUSED: bool = false;
            const N: usize = 1;

            #[inline(always)]
            fn splat((): (), x: Self) -> Self {
                x
            }
            #[inline(always)]
            fn load((): (), xs: &[Self]) -> Self {
                xs[0]
            }
            #[inline(always)]
            fn store(self, xs: &mut [Self]) {
                xs[0] = self;
            }
            #[inline(always)]
            fn token(self) {}
            #[inline(always)]
            fn lt(self, b: Self) -> bool {
                self < b
            }
            #[inline(always)]
            fn le(self, b: Self) -> bool {
                self <= b
            }
            #[inline(always)]
            fn select(m: bool, a: Self, b: Self) -> Self {
                if m { a } else { b }
            }
            #[inline(always)]
            fn interleave(self, b: Self) -> (Self, Self) {
                (self, b)
            }
            #[inline(always)]
            fn any(m: bool) -> bool {
                m
            }
            #[inline(always)]
            fn bits(m: bool) -> u64 {
                u64::from(m)
            }
            $($own)*
        }
    };
}

macro_rules! scalar {
    ($float:ident, $format:ident, $bits:ident, $splitter:literal) => {
        single_lane!($float {
            #[inline(always)]
            fn reciprocal_estimate(self) -> Self {
                1.0 / self
            }
            #[inline(always)]
            fn xor_sign(self, s: Self) -> Self {
                Self::from_bits(self.to_bits() ^ (s.to_bits() & <Self as Float>::SIGN))
            }
            #[inline(always)]
            fn negative_unless_alike<const K: usize>(self, all: [Self; K]) -> Self {
                let mut differ = 0;
                for x in all {
                    differ |= x.to_bits() ^ all[0].to_bits();
                }
                self.abs().xor_sign(Self::from_bits(differ))
            }
        });

        impl Scalar for $float {
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_lossless,
                reason = "rounding to the nearest is what the function promises"
            )]
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as Self
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn largest_t() -> Self {
                $float::MAX / 2.0
            }
            #[inline(always)]
            fn smallest_det() -> Self {
                $float::MIN_POSITIVE
            }
            fn are_collinear(points: [[Self; 3]; 3]) -> bool {
                collinear::are_collinear(points)
            }
            #[inline(always)]
            fn unit_roundoff() -> Self {
                $float::EPSILON / 2.0
            }
            #[inline(always)]
            fn splitter() -> Self {
                $splitter
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $float::abs(self)
            }
        }

        impl Float for $float {
            const FORMAT: FloatFormat = FloatFormat::$format;
            const SIGN: $bits = 1 << ($bits::BITS - 1);
            const SIGNIFICANT_BITS: i32 = $float::MANTISSA_DIGITS.cast_signed();
            const UNIT_ROUNDOFF: f64 = $float::EPSILON as f64 / 2.0;
            #[inline(always)]
            fn bits64(self) -> u64 {
                u64::from(self.to_bits())
            }
            #[allow(
                clippy::cast_possible_truncation,
                clippy::unnecessary_cast,
                reason = "what is beyond is dropped"
            )]
            #[inline(always)]
            fn from_bits64(bits: u64) -> Self {
                Self::from_bits(bits as $bits)
            }
        }
    };
}
scalar!(f32, F32, u32, 4_097.0);
scalar!(f64, F64, u64, 134_217_729.0);
