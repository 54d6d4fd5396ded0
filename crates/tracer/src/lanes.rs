//! Which lanes rays are traced on: chosen once for a batch.

use trisect_core::{Fused, InstructionSet, Lanes, Plain, Token, Vector};

use crate::called::On;

/// Something to do on lanes of choice.
pub(crate) trait Job {
    type Output;
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) -> Self::Output;
}

/// A choice of lanes, as a type.
pub(crate) trait OnLanes {
    /// Its name.
    const ON: On;

    /// Runs a job on them.
    fn run<J: Job>(job: J) -> J::Output;
}

/// The lanes that are fast, where the processor [has](has_fast_lanes) them.
pub(crate) struct OnFast;

impl OnLanes for OnFast {
    const ON: On = On::Fast;

    #[inline(always)]
    fn run<J: Job>(job: J) -> J::Output {
        on_fast_lanes(job).unwrap_or_else(|| unreachable!("they are asked for where they are"))
    }
}

/// Plain arithmetic, which gives the same bits everywhere: on one instruction set that nearly all processors
/// have, as each takes its time to compile for every method.
pub(crate) struct OnPlain;

impl OnLanes for OnPlain {
    const ON: On = On::Plain;

    #[inline(always)]
    fn run<J: Job>(job: J) -> J::Output {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        if let Some(token) = fearless_simd::x86::Sse4_2::detect() {
            use fearless_simd::x86::Sse4_2;
            return job.run::<Vector<Sse4_2, fearless_simd::f32x4<Sse4_2>, Plain>>(token);
        }
        job.run::<f32>(())
    }
}

/// One number at a time, likewise.
pub(crate) struct OnOne;

impl OnLanes for OnOne {
    const ON: On = On::One;

    #[inline(always)]
    fn run<J: Job>(job: J) -> J::Output {
        job.run::<f32>(())
    }
}

/// Runs a job on the lanes that are fast; none where the processor has none.
#[inline(always)]
fn on_fast_lanes<J: Job>(job: J) -> Option<J::Output> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        use fearless_simd::f32x8;
        use fearless_simd::x86::{Avx2, Avx512};
        if let Some(token) = Avx512::detect() {
            return Some(job.run::<Vector<Avx512, f32x8<Avx512>, Fused>>(token));
        }
        if let Some(token) = Avx2::detect() {
            return Some(job.run::<Vector<Avx2, f32x8<Avx2>, Fused>>(token));
        }
    }
    #[cfg(target_arch = "aarch64")]
    if let Some(token) = fearless_simd::aarch64::Neon::detect() {
        use fearless_simd::aarch64::Neon;
        return Some(job.run::<Vector<Neon, fearless_simd::f32x4<Neon>, Fused>>(token));
    }
    None
}

/// The instruction set of lanes, and how many they are.
struct Which;

impl Job for Which {
    type Output = (InstructionSet, usize);
    fn run<L: Lanes<Elem = f32>>(self, _token: L::Token) -> Self::Output {
        (L::Token::INSTRUCTION_SET, L::N)
    }
}

/// Whether the processor has lanes that are fast.
pub(crate) fn has_fast_lanes() -> bool {
    on_fast_lanes(Which).is_some()
}

/// The instruction set and the number of lanes that triangles are tested on here, unless plainly.
pub fn fast_lanes() -> (InstructionSet, usize) {
    on_fast_lanes(Which).unwrap_or_else(|| OnPlain::run(Which))
}
