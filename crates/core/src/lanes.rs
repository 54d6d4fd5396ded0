//! N numbers that move in step: the type every kernel is written against.
//!
//! Two implementations: the scalars `f32` and `f64` (N = 1), and [`Vector`] over the vectors of
//! `fearless_simd`. A [`Vector`] carries its [`Arithmetic`]: [`Plain`] gives the same bits on
//! every width and instruction set, [`Fused`] uses fused multiply-add where the instruction set
//! has it.

use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, SimdFloatElement};

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
    /// Whether the lanes were asked to round `a · b + c` once; see [`Fused`].
    const FUSED: bool;
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
    /// `self` with its sign flipped where `s` is negative (sign bit set): `|s|` is
    /// `s.xor_sign(s)`.
    #[must_use]
    fn xor_sign(self, s: Self) -> Self;
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
/// floats here, exact and counting numbers elsewhere. The braces hold what is its own:
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

/// How `a · b + c` rounds.
pub trait Arithmetic: Copy + Debug + Send + Sync + 'static {
    /// Whether it asks for a single rounding.
    const FUSED: bool;
    /// `a · b + c`
    fn mul_add<S: Simd, V: SimdFloat<S>>(a: V, b: V, c: V) -> V;
    /// `a · b − c`
    fn mul_sub<S: Simd, V: SimdFloat<S>>(a: V, b: V, c: V) -> V;
}

/// Rounds the product, then the sum: the same bits everywhere.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

impl Arithmetic for Plain {
    const FUSED: bool = false;
    #[inline(always)]
    fn mul_add<S: Simd, V: SimdFloat<S>>(a: V, b: V, c: V) -> V {
        a * b + c
    }
    #[inline(always)]
    fn mul_sub<S: Simd, V: SimdFloat<S>>(a: V, b: V, c: V) -> V {
        a * b - c
    }
}

/// Rounds once where the instruction set has fused multiply-add (AVX2, AVX-512, Neon), else as
/// [`Plain`].
#[derive(Clone, Copy, Debug)]
pub struct Fused;

impl Arithmetic for Fused {
    const FUSED: bool = true;
    #[inline(always)]
    fn mul_add<S: Simd, V: SimdFloat<S>>(a: V, b: V, c: V) -> V {
        a.mul_add(b, c)
    }
    #[inline(always)]
    fn mul_sub<S: Simd, V: SimdFloat<S>>(a: V, b: V, c: V) -> V {
        a.mul_sub(b, c)
    }
}

/// The lanes of one vector `V` of `fearless_simd`, on instruction set `S`, in arithmetic `A`.
#[derive(Debug)]
pub struct Vector<S, V, A> {
    lanes: V,
    kind: PhantomData<(S, A)>,
}

impl<S, V: Copy, A> Clone for Vector<S, V, A> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}
impl<S, V: Copy, A> Copy for Vector<S, V, A> {}

impl<S: Simd, V: SimdFloat<S>, A> Vector<S, V, A> {
    #[inline(always)]
    fn new(lanes: V) -> Self {
        Self { lanes, kind: PhantomData }
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<S: Simd, V: SimdFloat<S>, A> $trait for Vector<S, V, A> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::new($trait::$method(self.lanes, other.lanes))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl<S: Simd, V: SimdFloat<S>, A> Neg for Vector<S, V, A> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.lanes)
    }
}

impl<S: Simd, V: SimdFloat<S>, A: Arithmetic> Number for Vector<S, V, A> {
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self::new(A::mul_add::<S, V>(self.lanes, b.lanes, c.lanes))
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        Self::new(A::mul_sub::<S, V>(self.lanes, b.lanes, c.lanes))
    }
}

impl<S: Simd + Token, V: SimdFloat<S>, A: Arithmetic> Lanes for Vector<S, V, A>
where
    V::Element: Float,
{
    type Elem = V::Element;
    type Mask = V::Mask;
    type Token = S;
    const FUSED: bool = A::FUSED;
    const N: usize = V::LEN;

    #[inline(always)]
    fn splat(token: S, x: V::Element) -> Self {
        Self::new(V::splat(token, x))
    }
    #[inline(always)]
    fn load(token: S, xs: &[V::Element]) -> Self {
        Self::new(V::from_slice(token, &xs[..V::LEN]))
    }
    #[inline(always)]
    fn store(self, xs: &mut [V::Element]) {
        self.lanes.store_slice(&mut xs[..V::LEN]);
    }
    #[inline(always)]
    fn token(self) -> S {
        self.lanes.token()
    }
    #[inline(always)]
    fn reciprocal_estimate(self) -> Self {
        Self::new(self.lanes.approximate_recip())
    }
    #[inline(always)]
    fn lt(self, b: Self) -> V::Mask {
        self.lanes.simd_lt(b.lanes)
    }
    #[inline(always)]
    fn le(self, b: Self) -> V::Mask {
        self.lanes.simd_le(b.lanes)
    }
    #[inline(always)]
    fn xor_sign(self, s: Self) -> Self {
        // Not by `to_bits` and `from_bits`, which may stay calls.
        let (bits, signs): (V::Bits, V::Bits) = (self.lanes.bitcast(), s.lanes.bitcast());
        Self::new((bits ^ (signs & <V::Element as Float>::SIGN)).bitcast())
    }
    // The instruction of x86 gives the second operand where either is NaN; that of other processors
    // does not.
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        if cfg!(any(target_arch = "x86", target_arch = "x86_64")) {
            Self::new(self.lanes.min(b.lanes))
        } else {
            Self::select(self.lt(b), self, b)
        }
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        if cfg!(any(target_arch = "x86", target_arch = "x86_64")) {
            Self::new(self.lanes.max(b.lanes))
        } else {
            Self::select(self.gt(b), self, b)
        }
    }
    #[inline(always)]
    fn max_bits(self, b: Self) -> Self {
        let (bits, others): (V::Bits, V::Bits) = (self.lanes.bitcast(), b.lanes.bitcast());
        Self::new(bits.max(others).bitcast())
    }
    #[inline(always)]
    fn min_bits(self, b: Self) -> Self {
        let (bits, others): (V::Bits, V::Bits) = (self.lanes.bitcast(), b.lanes.bitcast());
        Self::new(bits.min(others).bitcast())
    }
    #[inline(always)]
    fn select(m: V::Mask, a: Self, b: Self) -> Self {
        Self::new(m.select(a.lanes, b.lanes))
    }
    #[inline(always)]
    fn interleave(self, b: Self) -> (Self, Self) {
        let (first, second) = self.lanes.interleave(b.lanes);
        (Self::new(first), Self::new(second))
    }
    #[inline(always)]
    fn any(m: V::Mask) -> bool {
        m.any_true()
    }
    #[inline(always)]
    fn bits(m: V::Mask) -> u64 {
        m.to_bitmask()
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{f32x4, f32x8, f64x4};

    use super::*;

    /// Numbers in pairs, NaN on either side.
    const PAIRS: [(f32, f32); 8] = [
        (-1.0, 2.0),
        (-1.0, -2.0),
        (1.0, 2.0),
        (2.0, 1.0),
        (f32::NAN, 1.0),
        (1.0, f32::NAN),
        (f32::NEG_INFINITY, -1.0),
        (f32::INFINITY, f32::NAN),
    ];

    fn least_and_largest<L: Lanes>() {
        let Some(token) = L::Token::detect() else { return };
        for (a, b) in PAIRS {
            let lanes = |x: f32| L::splat(token, L::Elem::from_f64(f64::from(x)));
            let first = |lanes: L| {
                let mut all = [L::Elem::from_f64(0.0); 16];
                lanes.store(&mut all);
                all[0].to_f64()
            };
            let (least, largest) = (first(lanes(a).min(lanes(b))), first(lanes(a).max(lanes(b))));
            if a.is_nan() || b.is_nan() {
                let expected = f64::from(b).to_bits();
                let bits = [least, largest].map(f64::to_bits);
                assert!(bits == [expected; 2] || b.is_nan() && least.is_nan() && largest.is_nan());
            } else {
                assert_eq!([least, largest], [a.min(b), a.max(b)].map(f64::from));
                let (x, y) = if a.to_bits() < b.to_bits() { (a, b) } else { (b, a) };
                let by_bits =
                    [first(lanes(a).min_bits(lanes(b))), first(lanes(a).max_bits(lanes(b)))];
                assert_eq!(by_bits, [x, y].map(f64::from));
            }
        }
    }

    fn interleaved<L: Lanes<Elem = f32>>() {
        let Some(token) = L::Token::detect() else { return };
        let numbers: Vec<f32> = (0_u8..32).map(f32::from).collect();
        let (first, second) = L::load(token, &numbers).interleave(L::load(token, &numbers[L::N..]));
        let mut all = [0.0; 32];
        first.store(&mut all);
        second.store(&mut all[L::N..]);
        let expected = (0..L::N).flat_map(|lane| [numbers[lane], numbers[L::N + lane]]);
        assert!(expected.eq(all[..2 * L::N].iter().copied()), "{all:?}");
    }

    #[test]
    fn lanes_of_both_take_turns() {
        interleaved::<f32>();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            use fearless_simd::x86::{Avx2, Avx512, Sse4_2};
            interleaved::<Vector<Sse4_2, f32x4<Sse4_2>, Plain>>();
            interleaved::<Vector<Avx2, f32x8<Avx2>, Plain>>();
            interleaved::<Vector<Avx512, f32x8<Avx512>, Plain>>();
        }
        #[cfg(target_arch = "aarch64")]
        interleaved::<
            Vector<fearless_simd::aarch64::Neon, f32x4<fearless_simd::aarch64::Neon>, Plain>,
        >();
    }

    #[test]
    fn the_second_is_taken_where_either_is_nan() {
        least_and_largest::<f32>();
        least_and_largest::<f64>();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            use fearless_simd::x86::{Avx2, Avx512, Sse4_2};
            least_and_largest::<Vector<Sse4_2, f32x4<Sse4_2>, Plain>>();
            least_and_largest::<Vector<Avx2, f32x8<Avx2>, Plain>>();
            least_and_largest::<Vector<Avx2, f64x4<Avx2>, Plain>>();
            least_and_largest::<Vector<Avx512, f32x8<Avx512>, Plain>>();
        }
        #[cfg(target_arch = "aarch64")]
        {
            use fearless_simd::aarch64::Neon;
            least_and_largest::<Vector<Neon, f32x4<Neon>, Plain>>();
            least_and_largest::<Vector<Neon, f32x8<Neon>, Plain>>();
            least_and_largest::<Vector<Neon, f64x4<Neon>, Plain>>();
        }
    }
}
