#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod mesh;
pub mod rays;

mod generate;
mod stream;

pub use generate::{
    Closest, Light, OFFSET, Workload, diffuse_bounce, hit_rate, occlusion, primary, random,
    random_through_box, working_set,
};
pub use mesh::{Bounds, Mesh, MeshError, MeshFormat, MeshProblem};
pub use rays::{
    RaysError, RaysFile, RaysProblem, read_rays, read_rays_binary, read_rays_csv,
    write_rays_binary, write_rays_csv,
};
