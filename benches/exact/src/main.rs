//! What exactness costs: the exact kernel against plain Plücker volumes from the ray's origin, decisions
//! alone and the first hit, over lanes of f32; and inside the tracer against the methods that claim to be
//! watertight. Samples are taken in rounds, in random order, and compared round by round.

mod kernels;

use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use serde::Serialize;
use trisect_core::{Fused, Lanes, Ray, Token, Vector};
use trisect_exact::{Exact, ExactInTrees};
use trisect_kernels::PreparedTriangles;
use trisect_method::{Culling, Method};
use trisect_plucker_translated::PluckerTranslated;
use trisect_tracer::{Builder, Bvh, Tracing, Tree, TriangleHit};
use trisect_watertight::{OnePrecision, ShearFirst, Watertight};
use trisect_workloads::{Mesh, diffuse_bounce, primary, random};

use kernels::Scene;

/// The contenders, with their own parameters as they are by default.
type Exactly = Exact;
type Plain = PluckerTranslated;

/// Pairs of a sample of kernels, about.
const PAIRS: usize = 10_000_000;

/// Pixels along either side of the picture that rays through the tree come from.
const PIXELS: usize = 512;

/// What exactness costs, in times of a plain method.
#[derive(Parser)]
struct Arguments {
    /// Meshes to time on besides random triangles; the bunny where there is none.
    #[arg(long)]
    mesh: Vec<PathBuf>,
    /// Samples of each contender, one per round.
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Something that is timed on a workload.
struct Contender<'a> {
    name: String,
    run: Box<dyn Fn() -> u64 + 'a>,
}

/// The median over the rounds of the time of the exact method over that of another.
#[derive(Serialize)]
struct Ratio {
    workload: String,
    /// `decision`, `closest` or `tracer`
    asked: &'static str,
    lanes: String,
    against: String,
    exact_ns: f64,
    other_ns: f64,
    time: f64,
}

/// Times the first contender, which is the exact one, against each of the others.
fn race(
    (workload, asked, lanes): (&str, &'static str, &str),
    contenders: &[Contender<'_>],
    tests: usize,
    rounds: u16,
) -> Result<Vec<Ratio>> {
    let mut random = Pcg64::seed_from_u64(1);
    let mut order: Vec<usize> = (0..contenders.len()).collect();
    let mut samples = vec![Vec::new(); contenders.len()];
    let mut hits = vec![0; contenders.len()];
    for round in 0..=rounds {
        order.shuffle(&mut random);
        for &at in &order {
            let start = Instant::now();
            hits[at] = black_box((contenders[at].run)());
            let time = start.elapsed().as_secs_f64() * 1e9 / tests as f64;
            // The first round warms up.
            if round > 0 {
                samples[at].push(time);
            }
        }
    }
    for (contender, &count) in contenders.iter().zip(&hits) {
        // They differ at edges alone.
        let differ = hits[0].abs_diff(count);
        ensure!(
            differ * 1000 <= hits[0].max(1000),
            "{workload}: {} finds {count} hits where {} finds {}",
            contender.name,
            contenders[0].name,
            hits[0]
        );
    }
    let ratio = |at: usize| {
        let ratios = samples[0].iter().zip(&samples[at]).map(|(exact, other)| exact / other);
        Ratio {
            workload: workload.to_owned(),
            asked,
            lanes: lanes.to_owned(),
            against: contenders[at].name.clone(),
            exact_ns: median(samples[0].clone()),
            other_ns: median(samples[at].clone()),
            time: median(ratios.collect()),
        }
    };
    Ok((1..contenders.len()).map(ratio).collect())
}

fn median(mut samples: Vec<f64>) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

/// Rays, and what they meet.
struct Workload<'a> {
    name: String,
    rays: Vec<Ray<f32>>,
    triangles: &'a [trisect_core::Triangle<f32>],
}

/// The two races of kernels on lanes of one kind.
fn over_lanes<L: Lanes<Elem = f32>>(
    workload: &Workload<'_>,
    rounds: u16,
    ratios: &mut Vec<Ratio>,
) -> Result<()> {
    let Some(token) = L::Token::detect() else { return Ok(()) };
    let Workload { name, rays, triangles } = workload;
    // Every so many of the rays, so that a sample is of that many pairs.
    let step = (rays.len() * triangles.len()).div_ceil(PAIRS).max(1);
    let rays: Vec<Ray<f32>> = rays.iter().copied().step_by(step).collect();
    let tests = rays.len() * triangles.len();
    let rays = &rays[..];
    let exact = Scene::<Exactly> { rays, triangles, prepared: PreparedTriangles::new(triangles)? };
    let plain = Scene::<Plain> { rays, triangles, prepared: PreparedTriangles::new(triangles)? };
    let lanes = format!("f32×{} {}", L::N, L::Token::INSTRUCTION_SET.name());
    let exactly = |run| Contender { name: Exactly::INFO.name.to_owned(), run };
    let plainly = |run| Contender { name: Plain::INFO.name.to_owned(), run };
    let decisions = [
        exactly(Box::new(|| exact.decide::<L>(token)) as Box<dyn Fn() -> u64>),
        plainly(Box::new(|| plain.decide::<L>(token)) as Box<dyn Fn() -> u64>),
    ];
    ratios.extend(race((name, "decision", &lanes), &decisions, tests, rounds)?);
    let closest = [
        exactly(Box::new(|| exact.closest_exactly::<L>(token)) as Box<dyn Fn() -> u64>),
        plainly(Box::new(|| plain.closest::<L>(token)) as Box<dyn Fn() -> u64>),
    ];
    ratios.extend(race((name, "closest", &lanes), &closest, tests, rounds)?);
    Ok(())
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn kernels(workload: &Workload<'_>, rounds: u16, ratios: &mut Vec<Ratio>) -> Result<()> {
    use fearless_simd::x86::{Avx2, Avx512};
    use fearless_simd::{f32x8, f32x16};
    over_lanes::<Vector<Avx2, f32x8<Avx2>, Fused>>(workload, rounds, ratios)?;
    over_lanes::<Vector<Avx512, f32x16<Avx512>, Fused>>(workload, rounds, ratios)
}

#[cfg(target_arch = "aarch64")]
fn kernels(workload: &Workload<'_>, rounds: u16, ratios: &mut Vec<Ratio>) -> Result<()> {
    use fearless_simd::{aarch64::Neon, f32x4};
    over_lanes::<Vector<Neon, f32x4<Neon>, Fused>>(workload, rounds, ratios)
}

/// The race inside the tracer: first hits of rays that go singly, on this thread's pool.
fn tracer(workload: &Workload<'_>, rounds: u16, ratios: &mut Vec<Ratio>) -> Result<()> {
    fn contender<'a, M: Method>(workload: &'a Workload<'_>) -> Result<Contender<'a>> {
        let tree = Bvh::<M>::build(workload.triangles, Builder::Spatial)?;
        let run = move || {
            let mut found: Vec<Option<TriangleHit>> = vec![None; workload.rays.len()];
            tree.closest(Tracing::Single, Culling::None, &workload.rays, &mut found);
            found.iter().flatten().count() as u64
        };
        Ok(Contender { name: M::INFO.name.to_owned(), run: Box::new(run) })
    }
    let contenders = [
        contender::<ExactInTrees>(workload)?,
        contender::<Watertight>(workload)?,
        contender::<Watertight<OnePrecision>>(workload)?,
        contender::<Watertight<OnePrecision, ShearFirst>>(workload)?,
        contender::<Plain>(workload)?,
    ];
    let rays = workload.rays.len();
    ratios.extend(race((&workload.name, "tracer", "singly"), &contenders, rays, rounds)?);
    Ok(())
}

/// Camera rays of a mesh and the diffuse rays from where they hit.
fn of_mesh(mesh: &Mesh) -> Result<[Workload<'_>; 2]> {
    let tree = Bvh::<ExactInTrees>::build(&mesh.triangles, Builder::Spatial)?;
    let mut closest = |ray: &Ray<f32>| {
        let mut found = [None];
        tree.closest(Tracing::Single, Culling::None, &[*ray], &mut found);
        found[0].map(|TriangleHit { triangle, hit }| (triangle as usize, hit))
    };
    let camera = primary(mesh, PIXELS, PIXELS);
    let diffuse = diffuse_bounce(1, mesh, PIXELS, PIXELS, &mut closest);
    Ok([("camera", camera), ("diffuse", diffuse)].map(|(class, workload)| Workload {
        name: format!("{} {class}", mesh.name),
        rays: workload.rays,
        triangles: &mesh.triangles,
    }))
}

fn main() -> Result<()> {
    let Arguments { mesh, rounds, json } = Arguments::parse();
    let meshes: Vec<Mesh> = if mesh.is_empty() {
        vec![trisect_workloads::bunny()]
    } else {
        let load = |path: &PathBuf| {
            Mesh::load(path).with_context(|| format!("cannot read {}", path.display()))
        };
        mesh.iter().map(load).collect::<Result<_>>()?
    };
    let mut ratios = Vec::new();
    let workload = random(1, 2000, 2000);
    let workload =
        Workload { name: workload.name, rays: workload.rays, triangles: &workload.triangles };
    kernels(&workload, rounds, &mut ratios)?;
    for mesh in &meshes {
        for workload in of_mesh(mesh)? {
            eprintln!("{}", workload.name);
            kernels(&workload, rounds, &mut ratios)?;
            tracer(&workload, rounds, &mut ratios)?;
        }
    }
    if json {
        println!("{}", serde_json::to_string_pretty(&ratios)?);
        return Ok(());
    }
    print(&ratios);
    Ok(())
}

fn print(ratios: &[Ratio]) {
    println!("ns of exact, of another, and their ratio: a test of a kernel, a ray of the tracer");
    for Ratio { workload, asked, lanes, against, exact_ns, other_ns, time } in ratios {
        println!(
            "{workload:24} {asked:9} {lanes:14} {exact_ns:9.3} {other_ns:9.3} {time:6.3}  {against}"
        );
    }
    let mut kinds: Vec<(&str, &str, &str)> = Vec::new();
    for ratio in ratios {
        let kind = (ratio.asked, &*ratio.lanes, &*ratio.against);
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    for (asked, lanes, against) in kinds {
        let of_kind = ratios
            .iter()
            .filter(|r| (r.asked, &*r.lanes, &*r.against) == (asked, lanes, against))
            .map(|r| r.time);
        let (count, sum) = of_kind.clone().fold((0, 0.0), |(n, sum), x| (n + 1, sum + x.ln()));
        let mean = (sum / f64::from(count)).exp();
        let most = of_kind.fold(0.0, f64::max);
        let name = format!("geometric mean of {count}");
        println!("{name:24} {asked:9} {lanes:14} {mean:19.3}, at most {most:.3}  {against}");
    }
}
