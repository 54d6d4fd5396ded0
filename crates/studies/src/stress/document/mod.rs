//! The stability study: its summary, figures, findings and document.

mod exact;
mod figures;
mod findings;
mod sections;
mod select;
mod summary;
mod tables;

pub use exact::{ExactnessRow, ExactnessSummary, exactness_summary};
pub(crate) use sections::document;
pub use summary::{StressRow, StressSummary, stress_summary};
