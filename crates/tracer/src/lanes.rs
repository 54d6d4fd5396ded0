//! Which lanes rays are traced on: chosen once for a batch.

use trisect_core::{InstructionSet, Lanes, Token};

/// Something to do on lanes of choice.
pub trait Job {
    /// What comes of it.
    type Output;
    /// Does it. What is to be compiled for the instruction set has to be inlined into [`Token::run`].
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) -> Self::Output;
}

/// Runs a job on the [fast lanes](fast_lanes) of the processor, or on those that nearly all processors have.
///
/// # Panics
/// Never: it is known which there are.
pub fn on_lanes<J: Job>(job: J) -> J::Output {
    if has_fast_lanes() {
        on_fast_lanes(job).expect("the processor has fast lanes")
    } else {
        PlainLanes::Vector.run(job)
    }
}

/// The lanes that give the same bits on every processor.
#[derive(Clone, Copy)]
pub(crate) enum PlainLanes {
    /// Four, where the processor has them.
    Vector,
    /// One.
    Scalar,
}

impl PlainLanes {
    /// Runs a job in plain arithmetic: on one instruction set that nearly all processors have, as each takes time
    /// to compile for every method.
    #[inline(always)]
    pub(crate) fn run<J: Job>(self, job: J) -> J::Output {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        if let (Self::Vector, Some(token)) = (self, fearless_simd::x86::Sse4_2::detect()) {
            use fearless_simd::x86::Sse4_2;
            use trisect_core::{Plain, Vector};
            return job.run::<Vector<Sse4_2, fearless_simd::f32x4<Sse4_2>, Plain>>(token);
        }
        job.run::<f32>(())
    }
}

/// Runs a job on the fastest lanes of the processor, which fuse multiply-add; `None` where it has none.
#[inline(always)]
pub(crate) fn on_fast_lanes<J: Job>(job: J) -> Option<J::Output> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        use fearless_simd::f32x8;
        use fearless_simd::x86::{Avx2, Avx512};
        use trisect_core::{Fused, Vector};
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
        use trisect_core::{Fused, Vector};
        return Some(job.run::<Vector<Neon, fearless_simd::f32x4<Neon>, Fused>>(token));
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = job;
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

/// Whether the processor has [fast lanes](on_fast_lanes).
pub(crate) fn has_fast_lanes() -> bool {
    on_fast_lanes(Which).is_some()
}

/// The instruction set and the number of lanes that triangles are tested on here, except in
/// [`Tracing::Plain`](crate::Tracing::Plain).
pub fn fast_lanes() -> (InstructionSet, usize) {
    on_fast_lanes(Which).unwrap_or_else(|| PlainLanes::Vector.run(Which))
}
