//! What every ray–triangle method of trisect is written against.
#![forbid(unsafe_code)]

mod geometry;
mod lanes;
mod number;

pub use geometry::{Hit, Ray, Triangle, Vec3};
pub use lanes::{Arithmetic, Float, Fused, Lanes, Plain, Scalar, Vector};
pub use number::Number;
