//! What the compiled variants of a method differ in, as values. The types that stand for the same at
//! compile time are [`Lanes`](crate::Lanes) and [`Division`](crate::Division).

use crate::named::named;
use crate::prepared::Common;

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

named! {
    /// When a test divides.
    pub enum Form {
        /// Before the decision; see [`Early`](crate::Early).
        Early = "early",
        /// After the decision, for hits alone; see [`Deferred`](crate::Deferred).
        Deferred = "deferred",
    }
}

named! {
    /// How `1 / x` is computed.
    pub enum ReciprocalKind {
        /// The processor's division; see [`TrueDivision`](crate::TrueDivision).
        True = "true",
        /// The processor's estimate and Newton steps; see [`Newton`](crate::Newton).
        Newton = "newton",
    }
}

named! {
    /// What the lanes hold.
    pub enum Arrangement {
        /// N triangles, against one ray at a time.
        OneRay = "one-ray",
        /// N rays, against one triangle at a time.
        OneTriangle = "one-triangle",
        /// N rays with a common origin, against one triangle at a time.
        CommonOrigin = "common-origin",
        /// N rays with a common direction, against one triangle at a time.
        CommonDirection = "common-direction",
    }
}

impl Arrangement {
    /// Whether it serves rays that have that much in common.
    pub const fn serves(self, common: Common) -> bool {
        match self {
            Self::OneRay | Self::OneTriangle => true,
            Self::CommonOrigin => common.origin,
            Self::CommonDirection => common.direction,
        }
    }
}
