#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod class;
mod exact;
mod exact_number;
mod fast;
mod oracle;

pub use class::Class;
pub use dashu::rational::RBig;
pub use exact_number::Exact;
pub use oracle::{Answer, Condition, Oracle, Truth, compare_t, exact_class, exact_rationals};
