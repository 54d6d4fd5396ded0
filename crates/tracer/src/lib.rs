#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod abreast;
mod bounds;
mod build;
mod bvh;
mod called;
mod dispatch;
mod envelope;
mod erased;
mod exactly;
mod hit;
mod lanes;
mod leaf;
mod leaves;
mod order;
mod packet;
mod parallel;
mod rows;
mod scalar;
mod single;
mod slabs;
mod waiting;
mod walk;

pub use build::{Builder, Leaves, RefitError, UnknownBuilder};
pub use bvh::{Bvh, Statistics};
pub use dispatch::{Tracing, Tree};
pub use erased::ErasedBvh;
pub use hit::TriangleHit;
pub use lanes::fast_lanes;
pub use scalar::{EveryTriangle, ScalarBvh};
pub use slabs::meets_box;
pub use walk::Counted;
