#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod points;
pub mod rays;

mod bunny;
mod classes;
mod crowd;
mod generate;
mod hall;
mod stream;
mod stress;
mod surface;

pub use bunny::bunny;
pub use classes::RayClass;
pub use crowd::crowd;
pub use generate::{
    Closest, Light, OFFSET, Share, Workload, diffuse_bounce, edge_aimed, hit_rate, occlusion,
    primary, random, random_sharing, random_through_box, working_set,
};
pub use hall::hall;
pub use points::{PointsFile, read_points};
pub use rays::{
    RaysError, RaysFile, RaysProblem, read_rays, read_rays_binary, read_rays_csv,
    read_rays_csv_with, read_rays_with, write_rays_binary, write_rays_csv,
};
pub use stream::Stream;
pub use stress::{Pair, Stress};
pub use surface::{Aim, Feature, Placement, Surface};
pub use trisect_mesh::{Bounds, Mesh};
