//! The compiled half of the Python package `trisect`: scenes in either precision, whose batches run on threads without
//! Python's lock and can be interrupted. The other half, in `python/trisect`, checks and shapes arrays, and is what
//! users see.

mod ask;
mod queries;
mod run;
mod scene;

use pyo3::prelude::*;

/// The compiled half of the package.
#[pymodule]
mod _trisect {
    #[pymodule_export]
    use crate::scene::RawScene;

    /// The version of the package.
    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "Python's name for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
