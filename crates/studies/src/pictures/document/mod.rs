//! The study of pictures: its summary, figures and document.

mod figures;
mod sections;
mod select;
mod summary;

pub(crate) use sections::document;
pub use summary::{PictureSummary, Technique, TimedFrame, picture_summary};
