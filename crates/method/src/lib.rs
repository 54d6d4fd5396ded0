#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod corners;
mod division;
mod form;
mod frame;
mod info;
mod method;
mod needs;
mod place;
mod planes;
mod record;
mod weights;

pub use corners::Corners;
pub use division::{
    BySigns, Culling, DecisionOnly, Deferred, Division, Early, Interval, Newton, Reciprocal,
    TrueDivision, seen,
};
pub use form::{Form, ReciprocalKind};
pub use frame::{Anchor, Constants, Corner, Frame, Function, Start, Vertex, World};
pub use info::{Claims, Forms, Input, MethodInfo, Output};
pub use method::{
    ExactMethod, Homogeneous, Method, MethodVisitor, Quotients, RayParts, Refine, Screened,
    UnsuitableMesh,
};
pub use needs::{Barycentrics, Distance, Needs, Normal, Occlusion, Point};
pub use place::Place;
pub use planes::{Functions, MappedRay, PlaneFirst, Slopes, ThreePlanes};
pub use record::{Of, Record, Value, field, rows};
/// For [`record!`].
#[doc(hidden)]
pub use trisect_core as core;
pub use weights::{Alpha, Given, Implied};
