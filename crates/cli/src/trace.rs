//! `trisect trace`: rays through a tree, and how fast.

use std::io::Write;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, anyhow};
use serde::Serialize;
use trisect_catalog::{Statistics, Tracing, Tree, TriangleHit};
use trisect_core::Ray;
use trisect_method::Culling;
use trisect_studies::{file, input, nanoseconds};

use crate::arguments::Trace;
use crate::studies::say;
use crate::{output, reading};

/// What is printed as JSON.
#[derive(Serialize)]
struct Report {
    mesh: String,
    triangles: usize,
    method: String,
    threads: usize,
    builder: &'static str,
    build_ns: u64,
    nodes: usize,
    blocks: usize,
    /// Triangles in leaves: more than the mesh has where space was split.
    references: usize,
    depth: usize,
    bytes: usize,
    /// Expected tests of a node or a block for a ray that meets the root.
    sah_cost: f64,
    rays: usize,
    any: bool,
    hits: usize,
    /// Over the closest hits; 0 where any hit is asked for.
    sum_t: f64,
    /// Of each repetition.
    samples_ns: Vec<u64>,
    million_rays_per_second: Vec<f64>,
}

/// What the rays found.
enum Found {
    Closest(Vec<Option<TriangleHit>>),
    Any(Vec<bool>),
}

pub(crate) fn run(arguments: &Trace) -> Result<()> {
    let entry = input::method(&arguments.method)?;
    if let Some(file) = &arguments.out {
        output::check_file_for(file, "--out")?;
    }
    let mesh = input::load_mesh(&arguments.mesh, &arguments.reading, &say)?;
    input::say_rounding(&arguments.mesh, mesh.rounding(), input::MOVE, &say);
    let rays = reading::load_rays(&arguments.rays, &arguments.reading)?.rays_f32;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads.map_or(0, usize::from))
        .build()
        .context("the system gives no threads; ask for fewer with --threads")?;
    let (tree, build) = pool.install(|| {
        let start = Instant::now();
        let tree = entry.tree(&mesh.triangles, arguments.builder);
        (tree, start.elapsed())
    });
    let tree = tree.map_err(|unsuitable| anyhow!("{}: {unsuitable}", arguments.mesh.display()))?;
    let mut found = if arguments.any {
        Found::Any(vec![false; rays.len()])
    } else {
        Found::Closest(vec![None; rays.len()])
    };
    let samples: Vec<Duration> =
        (0..arguments.repeat).map(|_| pool.install(|| sample(&*tree, &rays, &mut found))).collect();

    let Statistics { builder, nodes, blocks, references, depth, bytes, cost } = tree.statistics();
    let report = Report {
        mesh: mesh.name,
        triangles: mesh.triangles.len(),
        method: arguments.method.clone(),
        threads: pool.current_num_threads(),
        builder: builder.name(),
        build_ns: nanoseconds(build),
        nodes,
        blocks,
        references,
        depth,
        bytes,
        sah_cost: cost,
        rays: rays.len(),
        any: arguments.any,
        hits: found.hits(),
        sum_t: found.sum_t(),
        samples_ns: samples.iter().copied().map(nanoseconds).collect(),
        million_rays_per_second: samples
            .iter()
            .map(|time| rays.len() as f64 / time.as_secs_f64() / 1e6)
            .collect(),
    };
    if let Some(file) = &arguments.out {
        file::replace(file, |out| found.write(out))?;
    }
    output::print_as(arguments.json, &report, |out| report.print(out))
}

fn sample(tree: &dyn Tree, rays: &[Ray<f32>], found: &mut Found) -> Duration {
    let start = Instant::now();
    match found {
        Found::Closest(found) => tree.closest(Tracing::Single, Culling::None, rays, found),
        Found::Any(found) => tree.any(Tracing::Single, Culling::None, rays, found),
    }
    start.elapsed()
}

impl Found {
    fn hits(&self) -> usize {
        match self {
            Self::Closest(found) => found.iter().flatten().count(),
            Self::Any(found) => found.iter().filter(|hit| **hit).count(),
        }
    }

    fn sum_t(&self) -> f64 {
        match self {
            Self::Closest(found) => found.iter().flatten().map(|hit| f64::from(hit.hit.t)).sum(),
            Self::Any(_) => 0.0,
        }
    }

    /// Per ray `t` and triangle; of any hit, which has neither, 0 and the largest number.
    fn write(&self, out: &mut dyn Write) -> std::io::Result<()> {
        let mut pair = |t: f32, triangle: u32| {
            out.write_all(&t.to_le_bytes())?;
            out.write_all(&triangle.to_le_bytes())
        };
        let miss = (f32::INFINITY, u32::MAX);
        match self {
            Self::Closest(found) => found.iter().try_for_each(|found| {
                let (t, triangle) = found.map_or(miss, |found| (found.hit.t, found.triangle));
                pair(t, triangle)
            }),
            Self::Any(found) => {
                found.iter().try_for_each(|hit| pair(if *hit { 0.0 } else { miss.0 }, u32::MAX))
            }
        }
    }
}

impl Report {
    fn print(&self, out: &mut dyn Write) -> std::io::Result<()> {
        let mut speeds = self.million_rays_per_second.clone();
        speeds.sort_by(f64::total_cmp);
        let speed = |place: usize| speeds.get(place).copied().unwrap_or_default();
        writeln!(
            out,
            "{}: {} triangles, {} on {} thread(s)\n\
             tree   {} nodes, depth {}, {} bytes\n\
             leaves {} references in {} blocks of 8\n\
             built  {:.1} ms by the {} builder, SAH cost {:.2}\n\
             hits   {} of {} rays, sum of t {}\n\
             traced {:.2} million rays/s, median of {} ({:.2} to {:.2})",
            self.mesh,
            self.triangles,
            self.method,
            self.threads,
            self.nodes,
            self.depth,
            self.bytes,
            self.references,
            self.blocks,
            self.build_ns as f64 / 1e6,
            self.builder,
            self.sah_cost,
            self.hits,
            self.rays,
            self.sum_t,
            speed(speeds.len() / 2),
            speeds.len(),
            speed(0),
            speed(speeds.len().saturating_sub(1)),
        )
    }
}
