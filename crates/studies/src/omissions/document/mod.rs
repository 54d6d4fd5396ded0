//! The study of what is gained by leaving out what nobody asks for: its summary and document.

mod sections;
mod select;
mod summary;

pub(crate) use sections::document;
pub use summary::{OmissionKind, OmissionSummary, TimedOmission, omission_summary};
