#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod builder;
mod coq;
mod cost;
mod emit;
mod flushing;
mod formula;
mod graph;
mod ops;
mod symbol;

pub use cost::{Cost, cost};
pub use emit::{EmitError, Language, Request, emit};
pub use flushing::Flushing;
pub use formula::{Axis, Formula, Test};
pub use graph::{Constant, Graph, Latencies, Node, Op, Tree, Value};
pub use ops::Ops;
