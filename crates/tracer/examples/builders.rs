//! Builds trees over meshes with every builder and traces rays through them: time, memory, the expected
//! cost, and speed.
//!
//! `cargo run --release -p trisect-tracer --example builders -- [BUILDER...] FILE...`

use std::time::Instant;

use trisect_core::Ray;
use trisect_method::Culling;
use trisect_moller_trumbore::MollerTrumbore;
use trisect_tracer::{Builder, Bvh, Statistics, Tracing, Tree};
use trisect_workloads::Mesh;

/// Each is built and traced so many times; the median counts.
const TIMES: usize = 7;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "{:<16} {:>9} {:<8} {:>9} {:>7} {:>10} {:>7} {:>10} {:>6} {:>8} {:>8}",
        "mesh",
        "triangles",
        "builder",
        "build ms",
        "refit",
        "references",
        "nodes",
        "bytes",
        "cost",
        "primary",
        "random",
    );
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (builders, files): (Vec<_>, Vec<_>) = arguments
        .iter()
        .map(|word| (word.parse::<Builder>().ok(), word))
        .partition(|x| x.0.is_some());
    let mut builders: Vec<Builder> = builders.into_iter().filter_map(|x| x.0).collect();
    if builders.is_empty() {
        builders.extend(Builder::ALL);
    }
    for (_, file) in files {
        let mesh = Mesh::load(file)?;
        let primary = trisect_workloads::primary(&mesh, 512, 512).rays;
        let random = trisect_workloads::random_through_box(1, &mesh, 200_000).rays;
        for &builder in &builders {
            let mut built = None;
            let build = median(|| {
                built = None;
                let start = Instant::now();
                built = Bvh::<MollerTrumbore>::build(&mesh.triangles, builder).ok();
                start.elapsed().as_secs_f64()
            });
            let mut tree = built.expect("the method takes every mesh");
            let speed = |rays: &[Ray<f32>]| {
                let mut found = vec![None; rays.len()];
                let time = median(|| {
                    let start = Instant::now();
                    tree.closest(Tracing::Single, Culling::None, rays, &mut found);
                    start.elapsed().as_secs_f64()
                });
                rays.len() as f64 / time / 1e6
            };
            let (primary, random) = (speed(&primary), speed(&random));
            let Statistics { references, nodes, bytes, cost, .. } = tree.statistics();
            let refit = median(|| {
                let start = Instant::now();
                tree.refit(&mesh.triangles).expect("it is the same mesh");
                start.elapsed().as_secs_f64()
            });
            println!(
                "{:<16} {:>9} {builder:<8} {:>9.2} {:>7.2} {references:>10} {nodes:>7} {bytes:>10} \
                 {cost:>6.2} {primary:>8.2} {random:>8.2}",
                mesh.name,
                mesh.triangles.len(),
                build * 1e3,
                refit * 1e3,
            );
        }
    }
    Ok(())
}

fn median(mut time: impl FnMut() -> f64) -> f64 {
    let mut times: Vec<f64> = (0..TIMES).map(|_| time()).collect();
    times.sort_by(f64::total_cmp);
    times[TIMES / 2]
}
