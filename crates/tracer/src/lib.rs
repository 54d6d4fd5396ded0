#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod abreast;
mod bounds;
mod build;
mod bvh;
mod dispatch;
mod envelope;
mod exactly;
mod hit;
mod leaf;
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
pub use dispatch::{Tracing, Tree, fast_lanes};
pub use hit::TriangleHit;
pub use scalar::{EveryTriangle, ScalarBvh};
pub use walk::Counted;
