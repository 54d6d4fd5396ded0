//! Measures time and error of every method and writes records; never draws.
#![forbid(unsafe_code)]

mod answers;
mod code;
mod explain;
pub mod file;
pub mod machine;
mod measure;
mod omissions;
mod pictures;
mod recommend;
pub mod record;
mod shipped;
pub mod stats;
mod stress;
mod study;
mod subject;
mod surface;
mod timing;

pub use explain::{Explanation, Omission, explain};
pub use measure::{Progress, REFERENCE, Settings, Task, measure};
pub use omissions::{OmissionSettings, omissions};
pub use pictures::{PictureSettings, pictures};
pub use recommend::{
    Candidate, Decided, Exhaustive, RecommendError, RecommendSettings, Recommendation, Wrong,
    recommend,
};
pub use stress::{NotExact, StressSettings, stress};
pub use study::{ClassOfRays, StudyError, StudySettings, classes_of_rays, keep_for_study, study};
pub use subject::{Inputs, Unrounded};
pub use surface::open_edges;
pub use timing::{WrongAnswer, nanoseconds};
