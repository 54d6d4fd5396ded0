//! The tracer against the published ones: the same rays, in one run, in turn, on one thread.
#![deny(unsafe_code)]

mod contender;
mod crates;
#[cfg(feature = "embree")]
#[allow(unsafe_code, reason = "Embree's interface is C")]
mod embree;
mod ours;
mod report;
mod settle;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context as _, Result, ensure};
use clap::Parser;
use rand::SeedableRng as _;
use rand_pcg::Pcg64;
use trisect_catalog::Tracing;
use trisect_core::{Culling, Ray};
use trisect_workloads::{
    Light, Mesh, diffuse_bounce, occlusion, primary, random_through_box, read_rays,
};

use crate::contender::{Entrant, Resident, build, race};
use crate::report::{Class, Report};
use crate::settle::settle;

/// Races this project's tracer against obvhs, parry3d, bvh and, with the feature `embree`, Embree 4.
///
/// All trees are resident; rays are dealt in slices, and who comes next is drawn by lot. Tracing is on
/// one thread. Answers are compared ray by ray; the exact oracle settles the differences.
#[derive(Parser)]
#[command(max_term_width = 100)]
struct Arguments {
    /// Mesh: PLY, OBJ, STL or glTF; may be given several times
    #[arg(long, value_name = "FILE", required = true)]
    mesh: Vec<PathBuf>,
    /// Rays: CSV or .rays; if left out, four classes of rays are made for each mesh: primary,
    /// random, diffuse and occlusion
    #[arg(long, value_name = "FILE")]
    rays: Option<PathBuf>,
    /// Any hit instead of the closest, for rays from a file
    #[arg(long, requires = "rays")]
    any: bool,
    /// How often the rays are traced
    #[arg(long, value_name = "N", default_value_t = 11, value_parser = clap::value_parser!(u16).range(1..))]
    repeat: u16,
    /// How often the trees are built
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    builds: u16,
    /// Threads that build; all processors if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Methods of `trisect list` that the tracer takes part with
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_values_t = ours::DEFAULT.map(str::to_owned))]
    methods: Vec<String>,
    /// Only these contenders
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    only: Vec<String>,
    /// Classes of rays that are made
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_values_t = CLASSES.map(str::to_owned))]
    classes: Vec<String>,
    /// Side, in pixels, of the pictures that rays are made from
    #[arg(long, value_name = "PIXELS", default_value_t = 512, value_parser = clap::value_parser!(u16).range(1..=4096))]
    pixels: u16,
    /// Seed of the rays and of the order
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Embree's library
    #[cfg(feature = "embree")]
    #[arg(long, value_name = "FILE", default_value = "target/embree/libembree4.so")]
    embree: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The classes of rays that are made of a mesh.
const CLASSES: [&str; 4] = ["primary", "random", "diffuse", "occlusion"];

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let entrants = entrants(arguments)?;
    let threads = match arguments.threads {
        Some(threads) => usize::from(threads),
        None => {
            std::thread::available_parallelism().context("the processors cannot be counted")?.get()
        }
    };
    let mut report = Report::new(threads, usize::from(arguments.repeat));
    for path in &arguments.mesh {
        let mesh = Mesh::load(path)?;
        ensure!(!mesh.triangles.is_empty(), "{}: no triangles; name another mesh", path.display());
        eprintln!("{}: {} triangles", mesh.name, mesh.triangles.len());
        let classes = match &arguments.rays {
            Some(file) => {
                let rays = read_rays(file)?.rays_f32;
                ensure!(!rays.is_empty(), "{}: no rays; name another file", file.display());
                vec![("rays".to_owned(), rays, arguments.any)]
            }
            None => {
                let mut made = classes(&mesh, usize::from(arguments.pixels), arguments.seed)?;
                made.retain(|(name, ..)| arguments.classes.contains(name));
                made
            }
        };
        let mut random = Pcg64::seed_from_u64(arguments.seed);
        let mut residents =
            build(&entrants, &mesh.triangles, threads, usize::from(arguments.builds), &mut random)?;
        report.built(&mesh, &residents);
        // One thread, whatever a contender's own pool would be.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        for (name, rays, any) in classes {
            eprintln!("{}: {name}, {} rays", mesh.name, rays.len());
            let times = pool.install(|| {
                race(&mut residents, &rays, any, usize::from(arguments.repeat), &mut random)
            });
            let answers: Vec<_> = residents
                .iter()
                .map(|resident: &Resident| resident.contender.answers(any))
                .collect();
            let settlement = settle(&rays, &mesh.triangles, &answers);
            report.raced(
                Class { name, any, rays: rays.len() },
                &residents,
                &times,
                &answers,
                settlement,
            );
        }
    }
    report.print(arguments.json)
}

fn entrants(arguments: &Arguments) -> Result<Vec<Entrant>> {
    let mut entrants = Vec::new();
    for method in &arguments.methods {
        entrants.extend(ours::entrants(method)?);
    }
    #[cfg(feature = "embree")]
    entrants.extend(embree::entrants(&arguments.embree)?);
    entrants.extend(crates::entrants());
    if !arguments.only.is_empty() {
        entrants.retain(|entrant| arguments.only.contains(&entrant.name));
        ensure!(!entrants.is_empty(), "--only {}: no such contender", arguments.only.join(","));
    }
    Ok(entrants)
}

/// Rays of four classes: camera rays, rays between random points, bounces and shadows.
fn classes(mesh: &Mesh, pixels: usize, seed: u64) -> Result<Vec<(String, Vec<Ray<f32>>, bool)>> {
    let tree = ours::tree(mesh)?;
    let mut closest = |ray: &Ray<f32>| {
        let mut found = [None];
        tree.closest(Tracing::Plain, Culling::None, std::slice::from_ref(ray), &mut found);
        found[0].map(|found| (found.triangle as usize, found.hit))
    };
    let light = Light::above(&mesh.bounds);
    let diffuse = diffuse_bounce(seed, mesh, pixels, pixels, &mut closest);
    let occlusion = occlusion(seed, mesh, &light, pixels, pixels, &mut closest);
    Ok([
        ("primary", primary(mesh, pixels, pixels), false),
        ("random", random_through_box(seed, mesh, pixels * pixels), false),
        ("diffuse", diffuse, false),
        ("occlusion", occlusion, true),
    ]
    .into_iter()
    .filter(|(_, workload, _)| !workload.rays.is_empty())
    .map(|(name, workload, any)| (name.to_owned(), workload.rays, any))
    .collect())
}
