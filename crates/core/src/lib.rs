#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod collinear;
mod cost;
mod counting;
mod decode;
mod division;
mod flushing;
mod frame;
mod geometry;
mod info;
mod input;
mod kernel;
mod lanes;
mod method;
mod named;
mod needs;
mod number;
mod planes;
mod prepared;
mod record;
mod single;
mod tier;
mod variant;
mod weights;

pub use cost::{Cost, cost};
pub use counting::{Counting, Ops, counted};
pub use decode::decode;
pub use division::{
    Culling, DecisionOnly, Deferred, Division, Early, Interval, Newton, Reciprocal, TrueDivision,
    seen,
};
pub use flushing::Flushing;
pub use frame::{Anchor, Constants, Corner, Frame, Function, Start, Vertex, World};
pub use geometry::{Hit, Ray, Triangle, Vec3};
pub use info::{Claims, Forms, Input, MethodInfo, Output};
pub use input::Corners;
pub use kernel::{
    CommonDirection, CommonOrigin, Shared, Tested, one_ray, one_ray_until, one_triangle,
    shared_packets,
};
pub use lanes::{Arithmetic, Float, Fused, Lanes, Plain, Scalar, Vector};
pub use method::{
    ExactMethod, Homogeneous, Method, MethodVisitor, Quotients, RayParts, Refine, Screened,
    UnsuitableMesh,
};
pub use named::Named;
pub use needs::{Barycentrics, Distance, Needs, Normal, Occlusion, Point};
pub use number::Number;
pub use planes::{Functions, MappedRay, PlaneFirst, Slopes, ThreePlanes};
pub use prepared::{BLOCK, Common, PADDING, Packets, PreparedTriangles};
pub use record::{Of, Record, Value, field, rows};
pub use single::{PreparedPair, intersect, intersect_with};
pub use tier::{InstructionSet, LanesVisitor, Precision, Token};
pub use variant::{Arrangement, FloatFormat, Form, MultiplyAdd, ReciprocalKind};
pub use weights::{Alpha, Given, Implied};
