//! How numbers are stored and how they round, as values. The types that stand for the same at compile time
//! are [`Float`](crate::Float) and [`Arithmetic`](crate::Arithmetic).

use crate::named;

named! {
    /// A floating-point format.
    pub enum FloatFormat {
        /// IEEE 754 binary32.
        F32 = "f32",
        /// IEEE 754 binary64.
        F64 = "f64",
    }
}

named! {
    /// How `a·b + c` is rounded.
    pub enum MultiplyAdd {
        /// Twice, after each operation: the same bits on every width and instruction set.
        Plain = "plain",
        /// Once, where the instruction set has a fused multiply-add.
        Fused = "fused",
    }
}
