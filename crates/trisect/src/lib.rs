#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod error;
mod hit;
mod instances;
mod options;
mod precision;
mod rounded;
mod scene;
pub mod trees;

pub use error::{SceneError, UpdateError};
pub use hit::{AllHits, Hit};
pub use instances::Transform;
pub use options::SceneOptions;
pub use precision::Precision;
pub use scene::{Scene, View};

/// A ray: its origin `o`, its direction `d`, which need not be of unit length, and the interval of `t` that counts,
/// from 0 to infinity in [`Ray::new`].
pub type Ray<P = f32> = trisect_core::Ray<P>;
/// Three points.
pub type Triangle<P = f32> = trisect_core::Triangle<P>;

pub use trisect_core::Vec3;
pub use trisect_mesh::{MeshError, Note};
pub use trisect_method::{Culling, Method, Place, UnsuitableMesh};
pub use trisect_tracer::{
    Builder, Crossings, InstanceError, NotExact, RefitError, Statistics, Update, Verdict,
};

/// What a method of one's own is written with: numbers and lanes.
pub use trisect_core as core;
/// What a method of one's own is written against: the trait and what families of methods share.
pub use trisect_method as method;
