//! The lane types of a precision, one for each width and instruction set.

use crate::lanes::{Float, Lanes};

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
        $($visitor.visit::<crate::vector::Vector<
            $token,
            fearless_simd::$vector<$token>,
            crate::vector::$arithmetic,
        >>();)+
    };
}
precision!(f32, [f32x4, f32x8, f32x16]);
precision!(f64, [f64x2, f64x4, f64x8]);
