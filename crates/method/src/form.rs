//! When and how a test divides, as values. The types that stand for the same at compile time are
//! [`Division`](crate::Division)s.

use trisect_core::named;

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
