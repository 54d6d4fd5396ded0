//! Instruction sets, chosen at run time, and the lane types that stand for them.

use fearless_simd::{Level, Simd};

use crate::lanes::{Float, Lanes};
use crate::named::named;

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
    /// The proof, where the processor has it.
    fn detect() -> Option<Self>;
    /// Runs `f` compiled for the instruction set; what `f` calls must be inlined into it.
    fn run<R>(self, f: impl FnOnce() -> R) -> R;
}

impl Token for () {
    const INSTRUCTION_SET: InstructionSet = InstructionSet::Scalar;
    fn detect() -> Option<Self> {
        Some(())
    }
    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }
}

macro_rules! token {
    ($token:ty, $set:ident, $as:ident) => {
        impl Token for $token {
            const INSTRUCTION_SET: InstructionSet = InstructionSet::$set;
            fn detect() -> Option<Self> {
                Level::new().$as()
            }
            #[inline(always)]
            fn run<R>(self, f: impl FnOnce() -> R) -> R {
                self.vectorize(f)
            }
        }
    };
}
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    use super::{InstructionSet, Level, Simd, Token};
    use fearless_simd::x86::{Avx2, Avx512, Sse2, Sse4_2};
    token!(Sse2, Sse2, as_sse2);
    token!(Sse4_2, Sse42, as_sse4_2);
    token!(Avx2, Avx2, as_avx2);
    token!(Avx512, Avx512, as_avx512);
}
#[cfg(target_arch = "aarch64")]
token!(fearless_simd::aarch64::Neon, Neon, as_neon);

/// Something to do for each of a list of lane types.
pub trait LanesVisitor {
    /// One lane type.
    fn visit<L: Lanes<Elem: Precision>>(&mut self);
}

/// A precision: the float and its lane types.
pub trait Precision: Float {
    /// Visits the lane types that stand for their tiers, narrowest first: the scalar, then per
    /// instruction set the width native to it, plain, and fused where it has fused multiply-add.
    fn visit_native(visitor: &mut impl LanesVisitor);
    /// Visits every width on every instruction set of the target, plain and fused.
    fn visit_all(visitor: &mut impl LanesVisitor);
}

macro_rules! precision {
    ($float:ty, [$($narrow:ident)?, $($middle:ident)?, $($wide:ident)?]) => {
        impl Precision for $float {
            fn visit_native(visitor: &mut impl LanesVisitor) {
                visitor.visit::<$float>();
                #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
                {
                    use fearless_simd::x86::{Avx2, Avx512, Sse4_2};
                    precision!(@visit visitor $($narrow)?, Sse4_2, Plain);
                    precision!(@visit visitor $($middle)?, Avx2, Plain Fused);
                    precision!(@visit visitor $($wide)?, Avx512, Plain Fused);
                }
                #[cfg(target_arch = "aarch64")]
                {
                    use fearless_simd::aarch64::Neon;
                    precision!(@visit visitor $($narrow)?, Neon, Plain Fused);
                }
            }
            fn visit_all(visitor: &mut impl LanesVisitor) {
                visitor.visit::<$float>();
                #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
                {
                    use fearless_simd::x86::{Avx2, Avx512, Sse2, Sse4_2};
                    precision!(@widths visitor [$($narrow)? $($middle)? $($wide)?] Sse2);
                    precision!(@widths visitor [$($narrow)? $($middle)? $($wide)?] Sse4_2);
                    precision!(@widths visitor [$($narrow)? $($middle)? $($wide)?] Avx2);
                    precision!(@widths visitor [$($narrow)? $($middle)? $($wide)?] Avx512);
                }
                #[cfg(target_arch = "aarch64")]
                {
                    use fearless_simd::aarch64::Neon;
                    precision!(@widths visitor [$($narrow)? $($middle)? $($wide)?] Neon);
                }
            }
        }
    };
    (@widths $visitor:ident [$($vector:ident)+] $token:ident) => {
        $(precision!(@visit $visitor $vector, $token, Plain Fused);)+
    };
    (@visit $visitor:ident $vector:ident, $token:ident, $($arithmetic:ident)+) => {
        $($visitor.visit::<crate::lanes::Vector<
            $token,
            fearless_simd::$vector<$token>,
            crate::lanes::$arithmetic,
        >>();)+
    };
}
precision!(f32, [f32x4, f32x8, f32x16]);
precision!(f64, [f64x2, f64x4, f64x8]);
