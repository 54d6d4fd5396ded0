//! What is measured: methods, meshes and rays, as the arguments name them.

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use trisect_catalog::{Entry, entries, find};
use trisect_core::{Culling, Hit, Ray};
use trisect_harness::record::Family;
use trisect_harness::{Inputs, Task};
use trisect_mesh::Note;
use trisect_scene::Scene;
use trisect_workloads::{Light, Mesh, RaysFile, Share, Workload};

use crate::arguments::{Measurement, Reading, Subjects};
use crate::output;

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

/// The methods named, or all.
pub(crate) fn methods(names: &[String]) -> Result<Vec<&'static Entry>> {
    if names.is_empty() {
        return Ok(entries().iter().collect());
    }
    let mut methods: Vec<&'static Entry> = Vec::new();
    for name in names {
        let entry = method(name)?;
        if methods.iter().any(|other| other.info.name == entry.info.name) {
            bail!("method `{name}` is named twice; name each once with --methods");
        }
        methods.push(entry);
    }
    Ok(methods)
}

/// The method of that name.
pub(crate) fn method(name: &str) -> Result<&'static Entry> {
    find(name).ok_or_else(|| anyhow!("unknown method `{name}`; `trisect list` shows what there is"))
}

/// The meshes named, or those that stand in.
pub(crate) fn meshes(subjects: &Subjects, others: fn() -> Vec<Mesh>) -> Result<Vec<Mesh>> {
    if subjects.mesh.is_empty() {
        return Ok(others());
    }
    let mut meshes: Vec<Mesh> = Vec::new();
    for path in &subjects.mesh {
        let mesh = load_mesh(path, &subjects.reading)?;
        // Workloads are told apart by the mesh's name.
        if meshes.iter().any(|other| other.name == mesh.name) {
            bail!(
                "{}: a mesh named `{}` is given already; rename one of the files",
                path.display(),
                mesh.name
            );
        }
        meshes.push(mesh);
    }
    Ok(meshes)
}

/// Loads a mesh for f32, and says what its reader passed over and how many triangles are degenerate.
pub(crate) fn load_mesh(path: &Path, reading: &Reading) -> Result<Mesh> {
    let mesh = read_mesh(path, reading)?;
    say_degenerate(path, mesh.degenerate, &mesh);
    Ok(mesh)
}

/// Loads a mesh, and says what its reader passed over.
pub(crate) fn read_mesh(path: &Path, reading: &Reading) -> Result<Mesh> {
    let mesh = Mesh::load_with(path, &reading.into())?;
    say_notes(&mesh.notes);
    Ok(mesh)
}

/// Loads a scene, and says what its readers passed over.
pub(crate) fn load_scene(path: &Path, reading: &Reading) -> Result<Scene> {
    let scene = Scene::load_with(path, &reading.into())?;
    say_notes(&scene.notes);
    // Less than this is no part of a pixel.
    if scene.rounding > f64::from(f32::EPSILON) {
        say_rounding(path, scene.rounding, MOVE);
    }
    Ok(scene)
}

/// Says how many triangles of a mesh are degenerate in the precision that is asked for.
pub(crate) fn say_degenerate(path: &Path, degenerate: usize, mesh: &Mesh) {
    if degenerate > 0 {
        let (path, all) = (path.display(), mesh.triangles.len());
        let says = "triangles are degenerate and never hit";
        output::say(format_args!("{path}: {degenerate} of {all} {says}"));
    }
}

/// Says what readers passed over.
fn say_notes(notes: &[Note]) {
    for note in notes {
        output::say(note);
    }
}

/// Says by how much rounding to f32 moves a mesh or a scene, relative to its size, where a corner moves at
/// all. `mend` says what to do.
pub(crate) fn say_rounding(path: &Path, rounding: f64, mend: &str) {
    if rounding > 0.0 {
        output::say(format_args!(
            "{}: rounded to f32 its corners move by up to {rounding:.1e} of its size; {mend}",
            path.display()
        ));
    }
}

/// The same of all meshes that were read, where everything is in f32.
pub(crate) fn say_all_rounding(subjects: &Subjects, meshes: &[Mesh]) {
    for (path, mesh) in subjects.mesh.iter().zip(meshes) {
        say_rounding(path, mesh.rounding(), MOVE);
    }
}

/// What to do about rounding where everything is in f32.
pub(crate) const MOVE: &str = "f32 is finest at the origin: move it there before it is written";

/// Reads rays from a file, or from standard input for `-`.
pub(crate) fn load_rays(path: &Path, reading: &Reading) -> Result<RaysFile> {
    let options = reading.into();
    if path.as_os_str() == "-" {
        let input = std::io::stdin().lock();
        return Ok(trisect_workloads::read_rays_csv_with("standard input", input, &options)?);
    }
    Ok(trisect_workloads::read_rays_with(path, &options)?)
}

/// The workloads of a comparison: random, each mesh with its four sets of rays, the two series,
/// packets, and rays aimed at edges. They are made when they are asked for, and dropped when they are done with.
pub(crate) fn comparison(
    measurement: &Measurement,
    meshes: Vec<Mesh>,
) -> impl Iterator<Item = Task> {
    let size = if measurement.full { FULL } else { QUICK };
    let seed = measurement.subjects.seed;
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
pub(crate) fn verification(
    subjects: &Subjects,
    meshes: &[Mesh],
    rays: Option<&RaysFile>,
) -> Vec<Task> {
    let seed = subjects.seed;
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
        }],
        None => mesh_workloads(seed, mesh, QUICK.picture)
            .map(|Workload { name, description, rays, .. }| Task {
                name,
                description,
                family: Family::Mesh,
                inputs: inputs_of(rays, mesh),
                timed_rays: 0,
            })
            .into(),
    });
    tasks.collect()
}

fn task(workload: Workload, family: Family, timed_rays: usize) -> Task {
    let Workload { name, description, rays, triangles } = workload;
    let inputs = Inputs::new(rays, triangles.to_vec());
    Task { name, description, family, inputs, timed_rays }
}

/// Rays and a mesh as their files hold them, for the kernels of either precision.
pub(crate) fn inputs(rays: RaysFile, mesh: &Mesh) -> Inputs {
    let RaysFile { rays, rays_f32 } = rays;
    let rounded = (rays_f32, mesh.triangles.to_vec());
    Inputs::rounded(rounded, (rays, mesh.triangles_f64().to_vec()), mesh.rounding())
}

/// The same of rays that are made in f32.
pub(crate) fn inputs_of(rays_f32: Vec<Ray<f32>>, mesh: &Mesh) -> Inputs {
    let rays = rays_f32.iter().map(|&ray| ray.into()).collect();
    inputs(RaysFile { rays, rays_f32 }, mesh)
}

/// Rays that a renderer sends through a mesh: a camera's, scattered and shadow rays.
pub(crate) fn usual_rays(seed: u64, mesh: &Mesh) -> Vec<Ray<f32>> {
    let [primary, _random, bounce, occlusion] = mesh_workloads(seed, mesh, QUICK.picture * 2);
    [primary, bounce, occlusion].into_iter().flat_map(|workload| workload.rays).collect()
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
    let narrow = |x: f64| trisect_core::Scalar::from_f64(x);
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

/// Refuses an empty list of rays where there is nothing to do without.
pub(crate) fn some_rays(rays: &RaysFile, path: &Path) -> Result<()> {
    if rays.rays.is_empty() {
        bail!("{}: no rays; give at least one", path.display());
    }
    Ok(())
}
