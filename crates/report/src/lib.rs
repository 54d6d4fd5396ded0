#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod chapter;
mod chart;
mod compare;
mod figures;
mod format;
mod havel;
mod markdown;
mod omissions;
mod page;
mod pictures;
mod rank;
mod recommendation;
pub mod stats;
mod stress;
mod study;
mod summary;
mod text;
mod theme;
mod view;

pub use chapter::{Chapter, Page, PageError};
pub use chart::DrawError;
pub use compare::{ComparedVariant, Comparison, ErrorDifference, compare};
pub use markdown::{SpliceError, splice};
pub use omissions::{OmissionKind, OmissionSummary, TimedOmission, omission_summary};
pub use pictures::{PictureSummary, Technique, TimedFrame, picture_summary};
pub use rank::{Filter, Ranked, Ranking, rank};
pub use recommendation::recommendation_text;
pub use stress::{
    ExactnessRow, ExactnessSummary, StressRow, StressSummary, exactness_summary, stress_summary,
};
pub use study::{StudyRow, StudySummary, study_summary};
pub use summary::{FrontPoint, MethodRow, PrecisionRow, Summary, Winner, summary};
