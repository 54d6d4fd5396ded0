//! The comparison of methods: its index over records, summary, figures, ranking and document.

pub(crate) mod answers;
mod compare;
pub(crate) mod figures;
mod havel;
mod rank;
mod sections;
pub(crate) mod summary;
pub(crate) mod view;

pub use answers::{Answer, Answers, Speed};
pub use compare::{ComparedVariant, ErrorDifference, RecordComparison, compare_records};
pub use rank::{Filter, Ranked, Ranking, rank};
pub use summary::{FrontPoint, Summary, summary};

pub(crate) use sections::document;
