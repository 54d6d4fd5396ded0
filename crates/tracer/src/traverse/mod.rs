//! Rays on their way through the nodes of a tree.

pub(crate) mod inspect;
mod packet;
mod single;
mod stack;
pub(crate) mod target;
pub(crate) mod trace;
pub(crate) mod walk;
