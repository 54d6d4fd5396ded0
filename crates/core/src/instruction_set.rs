//! Instruction sets, chosen at run time.

use fearless_simd::Level;

use crate::lanes::Lanes;
use crate::named;

named! {
    /// The instructions that a kernel is compiled for, weakest first.
    pub enum InstructionSet {
        /// One number at a time, with the instructions that every processor of the target has.
        Scalar = "scalar",
        /// x86 baseline, 128 bits.
        Sse2 = "sse2",
        /// x86-64-v2, 128 bits.
        Sse42 = "sse4.2",
        /// x86-64-v3: AVX2 and fused multiply-add, 256 bits.
        Avx2 = "avx2",
        /// AVX-512 as of Ice Lake, 512 bits.
        Avx512 = "avx512",
        /// Arm, 128 bits.
        Neon = "neon",
    }
}

impl InstructionSet {
    /// Whether it has fused multiply-add.
    pub const fn has_fused_multiply_add(self) -> bool {
        matches!(self, Self::Avx2 | Self::Avx512 | Self::Neon)
    }

    /// Whether this processor has the instructions.
    pub fn is_available(self) -> bool {
        let level = Level::new();
        match self {
            Self::Scalar => true,
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Sse2 => level.as_sse2().is_some(),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Sse42 => level.as_sse4_2().is_some(),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx2 => level.as_avx2().is_some(),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx512 => level.as_avx512().is_some(),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => level.as_neon().is_some(),
            #[allow(unreachable_patterns, reason = "which arms exist depends on the target")]
            _ => {
                let _ = level;
                false
            }
        }
    }
}

/// Proof that the processor has an instruction set.
pub trait Token: Copy + Send + Sync + 'static {
    /// Which.
    const INSTRUCTION_SET: InstructionSet;
    /// Its own lanes of f64: as many as it has, fused where it fuses multiply-add.
    type Doubles: Lanes<Elem = f64, Token = Self>;
    /// The proof, where the processor has it.
    fn detect() -> Option<Self>;
    /// Runs `f` compiled for the instruction set; what `f` calls must be inlined into it.
    fn run<R>(self, f: impl FnOnce() -> R) -> R;
}

impl Token for () {
    const INSTRUCTION_SET: InstructionSet = InstructionSet::Scalar;
    type Doubles = f64;
    fn detect() -> Option<Self> {
        Some(())
    }
    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64", target_arch = "aarch64"))]
macro_rules! token {
    ($token:ty, $set:ident, $as:ident, $doubles:ident, $arithmetic:ident) => {
        impl Token for $token {
            const INSTRUCTION_SET: InstructionSet = InstructionSet::$set;
            type Doubles = crate::vector::Vector<
                $token,
                fearless_simd::$doubles<$token>,
                crate::vector::$arithmetic,
            >;
            #[inline]
            fn detect() -> Option<Self> {
                Level::new().$as()
            }
            #[inline(always)]
            fn run<R>(self, f: impl FnOnce() -> R) -> R {
                fearless_simd::Simd::vectorize(self, f)
            }
        }
    };
}
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    use super::{InstructionSet, Level, Token};
    use fearless_simd::x86::{Avx2, Avx512, Sse2, Sse4_2};
    token!(Sse2, Sse2, as_sse2, f64x2, Plain);
    token!(Sse4_2, Sse42, as_sse4_2, f64x2, Plain);
    token!(Avx2, Avx2, as_avx2, f64x4, Fused);
    token!(Avx512, Avx512, as_avx512, f64x8, Fused);
}
#[cfg(target_arch = "aarch64")]
token!(fearless_simd::aarch64::Neon, Neon, as_neon, f64x2, Fused);
