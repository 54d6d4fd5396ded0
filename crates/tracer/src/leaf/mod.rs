//! A method's triangles in leaves, and what they do to rays.

pub(crate) mod blocks;
pub(crate) mod erased;
pub(crate) mod exact;
mod packet;
mod pairs;
pub(crate) mod query;
pub(crate) mod report;
pub(crate) mod single;
