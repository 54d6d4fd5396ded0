#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod image;
mod needs;
mod offset;
mod paths;
mod render;
mod sampling;
mod settings;
mod sight;
mod stage;
mod surface;
mod wave;
mod whitted;

use trisect_pipeline::random;

pub use image::{Image, ImageError, ImageFormat};
pub use needs::{Facts, Part, Parts};
pub use render::{Interrupted, Renderer, Watch};
pub use sampling::Sampling;
pub use settings::{Mode, Occlusion, Settings};
pub use sight::Sight;
pub use stage::{Stage, StageError};
pub use wave::Counts;
