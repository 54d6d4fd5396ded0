#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod camera;
mod chair;
mod draft;
mod error;
mod files;
mod gltf_scene;
mod load;
mod mesh;
mod model;
mod mtl;
mod obj;
mod scale;
mod texture;
mod toml_file;

pub use camera::{Camera, Lens, PixelRays};
pub use error::{SceneError, SceneProblem, UnknownCamera};
pub use glam::{Affine3A, DVec3, Vec2, Vec3};
pub use load::SHIPPED;
pub use mesh::Mesh;
pub use model::{Color, Instance, Light, Material, Plane, Scene, Sphere, luminance};
pub use scale::Frame;
pub use texture::{Pixels, Texture};
