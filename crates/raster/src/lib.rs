#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod bins;
mod blocks;
mod frame;
pub mod hostile;
mod judge;
mod light;
mod model;
mod options;
mod paint;
mod scan;
mod setup;
mod tile;
mod view;

pub use blocks::{Blocks, Object};
pub use frame::Rasteriser;
pub use model::Scenery;
pub use options::{
    Affine, Bare, CullBy, Culls, Edges, Filtered, Flat, Gouraud, Identity, MapBy, NoCulling,
    NoTexture, Perspective, PerspectiveCulling, Phong, RoughCulling, ShadeBy, Shading, Texturing,
    Unlit,
};
pub use paint::{Painter, Pixel, Srgb};
pub use scan::{Scan, clip};
pub use view::View;
