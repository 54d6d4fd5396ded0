#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod collinear;
mod decode;
mod format;
mod geometry;
mod instruction_set;
mod lanes;
mod named;
mod number;
mod precision;
mod vector;

pub use decode::decode;
pub use format::{FloatFormat, MultiplyAdd};
pub use geometry::{Hit, Ray, Triangle, Vec3};
pub use instruction_set::{InstructionSet, Token};
pub use lanes::{Float, Lanes, Scalar};
pub use named::Named;
pub use number::Number;
pub use precision::{LanesVisitor, Precision};
/// For [`named!`].
#[doc(hidden)]
pub use serde_core;
pub use vector::{Arithmetic, Fused, Plain, Vector};
