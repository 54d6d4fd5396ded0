#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod buffer;
mod commit;
mod geometry;
mod graph;
mod launch;
mod leaves;
mod place;
mod primitive;
mod programs;
pub mod random;
mod scene;
mod selector;
mod shapes;
mod variables;
mod waves;

pub use buffer::Buffer;
pub use commit::{CommitError, Uncommitted};
pub use geometry::{BuildTree, Change, Geometry, ReshapeError};
pub use graph::{GeometryId, Graph, GraphError, MaterialId, NodeId};
pub use launch::{Launch, Launched};
pub use leaves::Leaves;
pub use place::{Place, Surface};
pub use primitive::{Primitive, ShapeTree};
pub use programs::{Entry, Exception, On, RayType, Traces};
pub use scene::Scene;
pub use selector::Visit;
pub use shapes::{Disc, Parallelogram, Shell, ShellSide, Sphere};
pub use trisect_tracer::{Builder, Tracing, Update, Verdict};
pub use variables::{Scope, Value, Variable};
pub use waves::{Flow, Holds, Queue, RayTypes};
