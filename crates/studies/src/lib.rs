#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod comparison;
pub mod forms;
pub mod omissions;
pub mod pictures;
pub mod raster;
pub mod recommend;
pub mod stress;
pub mod tracer;

mod answers;
pub mod file;
pub mod input;
mod kernels;
mod lines;
mod publish;
pub mod record;
mod registry;
mod shard;
mod statement;
mod study;
mod subject;
mod surface;
mod timing;

pub use kernels::REFERENCE;
pub use publish::{Page, PublishError, splice};
pub use registry::{Choice, StudyVisitor, chapter_of, chapters, load, read};
pub use shard::{MergeError, Shard, merge};
pub use study::{About, Chapter, Progress, Run, Silent, Study, StudyError, Taken};
pub use subject::{Inputs, Unrounded};
pub use surface::open_edges;
pub use timing::{WrongAnswer, nanoseconds};
pub use trisect_machine::{facts as machine, noise};
