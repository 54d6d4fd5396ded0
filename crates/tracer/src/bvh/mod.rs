//! The tree: nodes of eight children over blocks of eight triangles, whatever the method.

pub(crate) mod bounds;
pub(crate) mod builders;
pub(crate) mod frame;
pub(crate) mod node;
pub(crate) mod wide;
