//! What is measured on: random rays, meshes, series and packets.

use trisect_catalog::entries;
use trisect_core::{Hit, Ray, Scalar as _};
use trisect_mesh::Mesh;
use trisect_method::Culling;
use trisect_workloads::{Light, RaysFile, Share, Workload};

use super::record::Family;
use crate::subject::Inputs;

/// Which kernels are timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timed {
    /// All that the figures of a comparison show.
    All,
    /// Those that answer which method is the fastest where every triangle is tested: one ray at a time in
    /// single precision, on lanes as wide as the processor has them. Nothing is asked in double precision.
    Single,
}

/// Rays and triangles to measure on.
pub struct Task {
    /// Unique name.
    pub name: String,
    /// One sentence for a reader.
    pub description: String,
    /// What it is for: decides what is measured on it.
    pub family: Family,
    /// The rays and triangles.
    pub inputs: Inputs,
    /// How many of the rays, from the first, are timed, and then again from the first; all of them answer.
    pub timed_rays: usize,
    /// With which kernels.
    pub timed: Timed,
}

/// How much is measured.
struct Size {
    /// Rays, and triangles, of the random workload.
    random: usize,
    /// Side, in pixels, of the picture whose rays meet a mesh.
    picture: usize,
    /// Rays that are timed against a mesh.
    timed_rays: usize,
    /// Rays, and triangles, of each step of the share of hits.
    hit_rate: usize,
    /// Triangles of the largest working set, as a power of two.
    working_set: u32,
    /// Rays aimed at edges.
    edges: usize,
}

/// The closed sphere has 20·4^n triangles.
const SPHERE: u32 = 3;

const QUICK: Size =
    Size { random: 512, picture: 8, timed_rays: 16, hit_rate: 400, working_set: 18, edges: 10_000 };
const FULL: Size = Size {
    random: 1024,
    picture: 24,
    timed_rays: 64,
    hit_rate: 1000,
    working_set: 20,
    edges: 100_000,
};

/// The workloads of a comparison: random, each mesh with its four sets of rays, the two series,
/// packets, and rays aimed at edges. They are made when they are asked for, and dropped when they are done with.
pub(super) fn comparison(seed: u64, full: bool, meshes: Vec<Mesh>) -> impl Iterator<Item = Task> {
    let size = if full { FULL } else { QUICK };
    let random = std::iter::once_with(move || {
        task(trisect_workloads::random(seed, size.random, size.random), Family::Random, size.random)
    });
    let meshes = meshes.into_iter().flat_map(move |mesh| {
        mesh_workloads(seed, &mesh, size.picture).into_iter().enumerate().map(
            // The first set is timed; all of them answer.
            move |(i, workload)| {
                task(workload, Family::Mesh, if i == 0 { size.timed_rays } else { 0 })
            },
        )
    });
    let hit_rates = (0..=100).step_by(10).map(move |percent| {
        let workload = trisect_workloads::hit_rate(seed, percent, size.hit_rate, size.hit_rate);
        let rays = workload.rays.len();
        task(workload, Family::HitRate, rays)
    });
    let working_sets = (8..=size.working_set).map(move |power| {
        // As many tests in each, but for the largest: a sample of a millisecond or more.
        let rays = (1 << 20 >> power).max(1);
        task(trisect_workloads::working_set(seed, rays, 1 << power), Family::WorkingSet, rays)
    });
    let packets = [Share::Origin, Share::Direction].into_iter().map(move |share| {
        let workload = trisect_workloads::random_sharing(seed, share, size.random, size.random);
        task(workload, Family::Packets, size.random)
    });
    let edges = std::iter::once_with(move || edges(seed, size.edges));
    random.chain(meshes).chain(hit_rates).chain(working_sets).chain(packets).chain(edges)
}

/// Random rays and triangles that a study times the kernels on.
pub(crate) fn timing(seed: u64) -> Task {
    const TIMED: usize = 512;
    task(trisect_workloads::random(seed, TIMED, TIMED), Family::Random, TIMED)
}

fn edges(seed: u64, rays: usize) -> Task {
    task(trisect_workloads::edge_aimed(seed, rays, SPHERE), Family::Edges, 0)
}

/// The workloads of a verification: random rays and rays aimed at edges, unless there are meshes;
/// each mesh with `rays`, or with its four sets.
pub fn verification(seed: u64, meshes: &[Mesh], rays: Option<&RaysFile>) -> Vec<Task> {
    if meshes.is_empty() {
        let workload = trisect_workloads::random(seed, QUICK.random, QUICK.random);
        return vec![task(workload, Family::Random, 0), edges(seed, QUICK.edges)];
    }
    let tasks = meshes.iter().flat_map(|mesh| match rays {
        Some(rays) => vec![Task {
            name: format!("{}/rays", mesh.name),
            description: format!("the rays given, against {}", mesh.name),
            family: Family::Mesh,
            inputs: inputs(rays.clone(), mesh),
            timed_rays: 0,
            timed: Timed::All,
        }],
        None => mesh_workloads(seed, mesh, QUICK.picture)
            .map(|Workload { name, description, rays, .. }| Task {
                name,
                description,
                family: Family::Mesh,
                inputs: inputs_of(rays, mesh),
                timed_rays: 0,
                timed: Timed::All,
            })
            .into(),
    });
    tasks.collect()
}

fn task(workload: Workload, family: Family, timed_rays: usize) -> Task {
    let Workload { name, description, rays, triangles } = workload;
    let inputs = Inputs::new(rays, triangles.to_vec());
    Task { name, description, family, inputs, timed_rays, timed: Timed::All }
}

/// Rays and a mesh as their files hold them, for the kernels of either precision.
fn inputs(rays: RaysFile, mesh: &Mesh) -> Inputs {
    let RaysFile { rays, rays_f32 } = rays;
    let rounded = (rays_f32, mesh.triangles.to_vec());
    Inputs::rounded(rounded, (rays, mesh.triangles_f64().to_vec()), mesh.rounding())
}

/// The same of rays that are made in f32.
fn inputs_of(rays_f32: Vec<Ray<f32>>, mesh: &Mesh) -> Inputs {
    let rays = rays_f32.iter().map(|&ray| ray.into()).collect();
    inputs(RaysFile { rays, rays_f32 }, mesh)
}

/// Primary, random, diffuse and occlusion rays against a mesh.
fn mesh_workloads(seed: u64, mesh: &Mesh, picture: usize) -> [Workload; 4] {
    let primary = trisect_workloads::primary(mesh, picture, picture);
    let closest = closest(&primary.rays, mesh);
    let mut next = closest.iter();
    let mut look_up = |_: &Ray<f32>| next.next().copied().flatten();
    let bounce = trisect_workloads::diffuse_bounce(seed, mesh, picture, picture, &mut look_up);
    let mut next = closest.iter();
    let mut look_up = |_: &Ray<f32>| next.next().copied().flatten();
    let light = Light::above(&mesh.bounds);
    let occlusion =
        trisect_workloads::occlusion(seed, mesh, &light, picture, picture, &mut look_up);
    let random = trisect_workloads::random_through_box(seed, mesh, picture * picture);
    [primary, random, bounce, occlusion]
}

/// The closest hit of each ray, by the first method of the catalogue.
fn closest(rays: &[Ray<f32>], mesh: &Mesh) -> Vec<Option<(usize, Hit<f32>)>> {
    let kernels = &entries()[0].f32;
    let scene = (kernels.prepare)(&mesh.triangles, rays)
        .expect("the first method of the catalogue takes every mesh");
    let finder =
        kernels.plain_finder(None, None).expect("a plain finder is compiled for every processor");
    let narrow = f32::from_f64;
    finder
        .closest(&scene, Culling::None, rays.len())
        .into_iter()
        .map(|closest| {
            closest.map(|(number, hit)| {
                let hit =
                    Hit { t: narrow(hit.t), beta: narrow(hit.beta), gamma: narrow(hit.gamma) };
                (number as usize, hit)
            })
        })
        .collect()
}
