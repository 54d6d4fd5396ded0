#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod box_tree;
mod bvh;
mod dispatch;
mod every;
mod hit;
mod hits;
mod instances;
mod lanes;
mod leaf;
mod parallel;
mod precision;
mod query;
mod rays;
mod traced;
mod traced_f64;
mod traverse;
mod tree;
mod vectors;

pub use box_tree::BoxTree;
pub use bvh::builders::settings::{Builder, Leaves, UnknownBuilder};
pub use bvh::builders::{RefitError, is_worn};
pub use bvh::wide::Statistics;
pub use dispatch::Tracing;
pub use every::EveryTriangle;
pub use hit::{MaybeHit, TriangleHit};
pub use hits::{AllHits, Crossings, NotExact, Verdict};
pub use instances::{
    BadTransform, Extent, HasTree, Instance, InstanceError, Instances, Transform, Update,
};
pub use lanes::{Job, fast_lanes, on_lanes};
pub use precision::Precision;
pub use rays::slabs::meets_box;
pub use traverse::inspect::Counted;
pub use tree::{Bvh, ErasedBvh, ScalarBvh, Tree};
