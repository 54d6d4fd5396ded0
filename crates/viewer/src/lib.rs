#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod controls;
mod frame;
mod heat;
mod judge;
mod view;
mod viewer;

pub use frame::{Frame, Rgb};
pub use judge::{Cost, Triangles, Verdict, cost, judge};
pub use view::{UnknownView, View};
pub use viewer::{Action, Viewer};
