//! The study of the tracer: its summary, figures, findings and document.

mod figures;
mod findings;
mod sections;
mod select;
mod summary;

pub(crate) use sections::document;
pub use summary::{StudyRow, StudySummary, study_summary};
