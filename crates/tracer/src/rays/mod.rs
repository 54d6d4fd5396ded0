//! Rays, many at a time.

pub(crate) mod batch;
pub(crate) mod packet_bounds;
pub(crate) mod reorder;
pub(crate) mod slabs;
