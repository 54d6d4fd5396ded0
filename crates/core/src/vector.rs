//! Lanes over the vectors of `fearless_simd`, whose arithmetic is part of their type: [`Plain`] gives the same
//! bits on every width and instruction set, [`Fused`] uses fused multiply-add where the instruction set has it.

use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::{Add, Div, Mul, Neg, Sub};

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use crate::instruction_set::Token;
use crate::lanes::{Float, Lanes, Scalar as _};
use crate::number::Number;

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
    V::Bits: SimdBase<S, Mask = V::Mask>,
{
    type Elem = V::Element;
    type Mask = V::Mask;
    type Token = S;
    const FUSED: bool = A::FUSED;
    const ONE_ROUNDING: bool = A::FUSED && S::INSTRUCTION_SET.has_fused_multiply_add();
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
    // As whole numbers, what is below the least wraps around to beyond the most, as do negative numbers and NaN.
    #[inline(always)]
    fn is_within(self, least: V::Element, most: V::Element) -> V::Mask {
        let bits = |x| -> V::Bits { V::splat(self.token(), x).bitcast() };
        let lanes: V::Bits = self.lanes.bitcast();
        (lanes - bits(least)).simd_le(bits(most) - bits(least))
    }
    #[inline(always)]
    fn xor_sign(self, s: Self) -> Self {
        // Not by `to_bits` and `from_bits`, which may stay calls.
        let (bits, signs): (V::Bits, V::Bits) = (self.lanes.bitcast(), s.lanes.bitcast());
        Self::new((bits ^ (signs & <V::Element as Float>::SIGN)).bitcast())
    }
    #[inline(always)]
    fn negative_unless_alike<const K: usize>(self, all: [Self; K]) -> Self {
        let first: V::Bits = all[0].lanes.bitcast();
        // Nothing yet.
        let mut differ: V::Bits = self.constant(V::Element::from_f64(0.0)).lanes.bitcast();
        for x in all {
            let x: V::Bits = x.lanes.bitcast();
            differ |= first ^ x;
        }
        self.magnitude().xor_sign(Self::new(differ.bitcast()))
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
    use crate::lanes::Scalar;

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
