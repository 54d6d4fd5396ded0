#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod axis;
pub mod document;
pub mod figure;
pub mod format;
pub mod html;
mod inline;
pub mod markdown;
pub mod stats;
mod svg;
pub mod table;
pub mod terminal;

pub use svg::DrawError;
