#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod bounds;
mod build;
mod bvh;
mod dispatch;
mod single;
mod stream;
mod traveller;

pub use build::{Builder, Leaves, RefitError, UnknownBuilder};
pub use bvh::{Bvh, Statistics};
pub use dispatch::{Tracing, Tree};
pub use traveller::TriangleHit;
