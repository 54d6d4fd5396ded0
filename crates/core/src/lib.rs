#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod block;
mod division;
mod geometry;
mod kernel;
mod lanes;
mod method;
mod needs;
mod number;
mod plane_first;
mod record;
mod single;
mod tier;

pub use block::{BLOCK, PADDING, Packet, PreparedTriangles};
pub use division::{
    Culling, Deferred, Division, Early, Interval, Newton, Reciprocal, TrueDivision,
};
pub use geometry::{Hit, Ray, Triangle, Vec3};
pub use kernel::{one_ray, one_triangle};
pub use lanes::{Arithmetic, Float, Fused, Lanes, Plain, Scalar, Vector};
pub use method::{Homogeneous, Method, MethodInfo, MethodVisitor};
pub use needs::{Barycentrics, Distance, Needs, Occlusion};
pub use number::Number;
pub use plane_first::PlaneFirst;
pub use record::{Of, Record, field};
pub use single::{intersect, intersect_with};
pub use tier::{InstructionSet, LanesVisitor, Precision, Token};
