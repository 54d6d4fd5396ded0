//! The intrinsics of AVX2 with fused multiply-add, and of AVX-512, by one name each.
#![allow(
    unsafe_code,
    reason = "intrinsics, loads through pointers, and calls of functions with features"
)]

#[allow(clippy::wildcard_imports, reason = "intrinsics have names of their own")]
use std::arch::x86_64::*;

/// Instructions that the processor has, and what a loop is written in.
pub(crate) trait Isa: Copy + 'static {
    /// A vector of f32.
    type V: Copy;
    /// One truth value per lane.
    type M: Copy;
    /// Lanes of a vector.
    const N: usize;
    /// Their name in tables.
    const NAME: &'static str;

    /// The proof, where the processor has them.
    fn detect() -> Option<Self>;
    /// Runs `f` with the instructions; what `f` calls must be inlined into it.
    fn run<R>(self, f: impl FnOnce() -> R) -> R;

    fn splat(self, x: f32) -> Self::V;
    /// The first lanes of `xs`, which are aligned to the vector.
    fn load(self, xs: &[f32; 16], start: usize) -> Self::V;
    fn store(self, a: Self::V) -> [f32; 16];
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    /// `a·b + c`
    fn fma(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// `a·b − c`
    fn fms(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// `c − a·b`
    fn fnma(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    fn neg(self, a: Self::V) -> Self::V;
    fn abs(self, a: Self::V) -> Self::V;
    /// `a` with its sign flipped where that of `s` is set.
    fn flip(self, a: Self::V, s: Self::V) -> Self::V;
    /// `a ≤ b`
    fn le(self, a: Self::V, b: Self::V) -> Self::M;
    /// `m`, where also `a ≤ b`.
    fn and_le(self, m: Self::M, a: Self::V, b: Self::V) -> Self::M;
    /// Its sign bit is set where the five have not all the same.
    fn differ(self, five: [Self::V; 5]) -> Self::V;
    /// `a` with the sign bit of `s` for its own.
    fn with_sign(self, a: Self::V, s: Self::V) -> Self::V;
    /// Where the sign bit is not set.
    fn positive(self, a: Self::V) -> Self::M;
    fn bits(self, m: Self::M) -> u32;
    /// `a`, and where `m` holds `a + b`.
    fn add_where(self, m: Self::M, a: Self::V, b: Self::V) -> Self::V;
}

/// A safe function of one intrinsic each.
macro_rules! safe {
    ($($name:ident($($a:ident: $type:ty),*) -> $result:ty = $body:expr;)+) => {
        $(
            #[inline(always)]
            fn $name(self, $($a: $type),*) -> $result {
                // SAFETY: a value of this type exists where the processor has the instructions.
                unsafe { $body }
            }
        )+
    };
}

/// Proof of AVX2 and fused multiply-add.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(());

impl Isa for Avx2 {
    type V = __m256;
    type M = __m256;
    const N: usize = 8;
    const NAME: &'static str = "f32×8 avx2";

    fn detect() -> Option<Self> {
        let has = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("popcnt");
        has.then_some(Self(()))
    }
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        #[target_feature(enable = "avx2,fma,popcnt")]
        fn with<R>(f: impl FnOnce() -> R) -> R {
            f()
        }
        // SAFETY: as for each of its intrinsics.
        unsafe { with(f) }
    }
    #[inline(always)]
    fn load(self, xs: &[f32; 16], start: usize) -> __m256 {
        let xs = &xs[start & 8..][..8];
        // SAFETY: eight numbers; the instructions are there, and ask for no alignment.
        unsafe { _mm256_loadu_ps(xs.as_ptr()) }
    }
    #[inline(always)]
    fn store(self, a: __m256) -> [f32; 16] {
        let mut to = [0.0; 16];
        // SAFETY: there is room for sixteen numbers, and the instructions ask for no alignment.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), a) };
        to
    }
    safe! {
        splat(x: f32) -> __m256 = _mm256_set1_ps(x);
        add(a: __m256, b: __m256) -> __m256 = _mm256_add_ps(a, b);
        sub(a: __m256, b: __m256) -> __m256 = _mm256_sub_ps(a, b);
        mul(a: __m256, b: __m256) -> __m256 = _mm256_mul_ps(a, b);
        div(a: __m256, b: __m256) -> __m256 = _mm256_div_ps(a, b);
        fma(a: __m256, b: __m256, c: __m256) -> __m256 = _mm256_fmadd_ps(a, b, c);
        fms(a: __m256, b: __m256, c: __m256) -> __m256 = _mm256_fmsub_ps(a, b, c);
        fnma(a: __m256, b: __m256, c: __m256) -> __m256 = _mm256_fnmadd_ps(a, b, c);
        neg(a: __m256) -> __m256 = _mm256_xor_ps(a, _mm256_set1_ps(-0.0));
        abs(a: __m256) -> __m256 = _mm256_andnot_ps(_mm256_set1_ps(-0.0), a);
        flip(a: __m256, s: __m256) -> __m256 =
            _mm256_xor_ps(a, _mm256_and_ps(s, _mm256_set1_ps(-0.0)));
        le(a: __m256, b: __m256) -> __m256 = _mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
        and_le(m: __m256, a: __m256, b: __m256) -> __m256 =
            _mm256_and_ps(m, _mm256_cmp_ps::<_CMP_LE_OQ>(a, b));
        differ(v: [__m256; 5]) -> __m256 = {
            let differ = |a| _mm256_xor_ps(v[0], a);
            let inside = _mm256_or_ps(differ(v[1]), differ(v[2]));
            _mm256_or_ps(inside, _mm256_or_ps(differ(v[3]), differ(v[4])))
        };
        with_sign(a: __m256, s: __m256) -> __m256 = {
            let sign = _mm256_set1_ps(-0.0);
            _mm256_or_ps(_mm256_andnot_ps(sign, a), _mm256_and_ps(sign, s))
        };
        // The sign bits alone are read of a mask.
        positive(a: __m256) -> __m256 = _mm256_xor_ps(a, _mm256_set1_ps(-0.0));
        bits(m: __m256) -> u32 = _mm256_movemask_ps(m).cast_unsigned();
        add_where(m: __m256, a: __m256, b: __m256) -> __m256 =
            _mm256_add_ps(a, _mm256_blendv_ps(_mm256_setzero_ps(), b, m));
    }
}

/// Proof of AVX-512.
#[derive(Clone, Copy)]
pub(crate) struct Avx512(());

impl Isa for Avx512 {
    type V = __m512;
    type M = __mmask16;
    const N: usize = 16;
    const NAME: &'static str = "f32×16 avx512";

    fn detect() -> Option<Self> {
        let has = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("popcnt");
        has.then_some(Self(()))
    }
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        #[target_feature(enable = "avx512f,avx512dq,popcnt")]
        fn with<R>(f: impl FnOnce() -> R) -> R {
            f()
        }
        // SAFETY: as for each of its intrinsics.
        unsafe { with(f) }
    }
    #[inline(always)]
    fn bits(self, m: __mmask16) -> u32 {
        m.into()
    }
    #[inline(always)]
    fn load(self, xs: &[f32; 16], _start: usize) -> __m512 {
        // SAFETY: sixteen numbers; the instructions are there, and ask for no alignment.
        unsafe { _mm512_loadu_ps(xs.as_ptr()) }
    }
    #[inline(always)]
    fn store(self, a: __m512) -> [f32; 16] {
        let mut to = [0.0; 16];
        // SAFETY: there is room for sixteen numbers, and the instructions ask for no alignment.
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), a) };
        to
    }
    safe! {
        splat(x: f32) -> __m512 = _mm512_set1_ps(x);
        add(a: __m512, b: __m512) -> __m512 = _mm512_add_ps(a, b);
        sub(a: __m512, b: __m512) -> __m512 = _mm512_sub_ps(a, b);
        mul(a: __m512, b: __m512) -> __m512 = _mm512_mul_ps(a, b);
        div(a: __m512, b: __m512) -> __m512 = _mm512_div_ps(a, b);
        fma(a: __m512, b: __m512, c: __m512) -> __m512 = _mm512_fmadd_ps(a, b, c);
        fms(a: __m512, b: __m512, c: __m512) -> __m512 = _mm512_fmsub_ps(a, b, c);
        fnma(a: __m512, b: __m512, c: __m512) -> __m512 = _mm512_fnmadd_ps(a, b, c);
        neg(a: __m512) -> __m512 = _mm512_xor_ps(a, _mm512_set1_ps(-0.0));
        abs(a: __m512) -> __m512 = _mm512_abs_ps(a);
        flip(a: __m512, s: __m512) -> __m512 = {
            // a ^ (s & sign)
            let (a, s) = (_mm512_castps_si512(a), _mm512_castps_si512(s));
            let sign = _mm512_set1_epi32(i32::MIN);
            _mm512_castsi512_ps(_mm512_ternarylogic_epi32::<0x78>(a, s, sign))
        };
        le(a: __m512, b: __m512) -> __mmask16 = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b);
        and_le(m: __mmask16, a: __m512, b: __m512) -> __mmask16 =
            _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(m, a, b);
        differ(v: [__m512; 5]) -> __m512 = {
            let [a, b, c, d, e] = v.map(|v| _mm512_castps_si512(v));
            // Not all three alike; then the other two, each against the first.
            let differ = _mm512_ternarylogic_epi32::<0x7e>(a, b, c);
            let differ = _mm512_ternarylogic_epi32::<0xf6>(differ, a, d);
            _mm512_castsi512_ps(_mm512_ternarylogic_epi32::<0xf6>(differ, a, e))
        };
        with_sign(a: __m512, s: __m512) -> __m512 = {
            // sign ? s : a
            let (a, s) = (_mm512_castps_si512(a), _mm512_castps_si512(s));
            let sign = _mm512_set1_epi32(i32::MIN);
            _mm512_castsi512_ps(_mm512_ternarylogic_epi32::<0xca>(sign, s, a))
        };
        positive(a: __m512) -> __mmask16 = !_mm512_movepi32_mask(_mm512_castps_si512(a));
        add_where(m: __mmask16, a: __m512, b: __m512) -> __m512 = _mm512_mask_add_ps(a, m, a, b);
    }
}
