#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod arrangement;
mod loops;
mod prepared;
mod single;

pub use arrangement::Arrangement;
pub use loops::{
    CommonDirection, CommonOrigin, Tested, one_ray, one_ray_until, one_triangle, shared_packets,
};
pub use prepared::{BLOCK, Common, PADDING, Packets, PreparedTriangles};
pub use single::{PreparedPair, intersect, intersect_with};
