#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod cost;
mod counting;
mod flushing;

pub use cost::{Cost, cost};
pub use counting::{Counting, Ops, counted};
pub use flushing::Flushing;
