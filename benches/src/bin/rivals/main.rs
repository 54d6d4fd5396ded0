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

use std::collections::BTreeSet;
use std::io::{ErrorKind, IsTerminal as _};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context as _, Result, bail, ensure};
use clap::Parser;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rand::SeedableRng as _;
use rand_pcg::Pcg64;
use trisect_studies::tracer::ClassOfRays;
use trisect_workloads::{Mesh, RayClass, crowd, read_rays};

use crate::contender::{Entrant, Resident, build, quiet_guarded_panics, race};
use crate::report::{Class, Report};
use crate::settle::settle;

/// Races this project's tracer against obvhs, parry3d, bvh and, with the feature `embree`, Embree
/// 4.
///
/// All trees are resident; rays are dealt in slices, and who comes next is drawn by lot. Tracing is
/// on one thread. Answers are compared ray by ray; the exact oracle settles the differences.
#[derive(Parser)]
#[command(max_term_width = 100, after_long_help = WORDS)]
struct Arguments {
    /// Mesh: PLY, OBJ, STL or glTF; may be given several times
    #[arg(long, value_name = "FILE", required = true)]
    mesh: Vec<PathBuf>,
    /// Copies of each mesh, turned, side by side: scenes of millions of triangles
    #[arg(long, value_name = "N", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=4096))]
    copies: u16,
    /// Rays: CSV or .rays; if left out, rays of several classes are made for each mesh
    #[arg(long, value_name = "FILE", conflicts_with_all = ["classes", "pixels"])]
    rays: Option<PathBuf>,
    /// Any hit instead of the closest, for rays from a file
    #[arg(long, requires = "rays")]
    any: bool,
    /// How often the rays are traced
    #[arg(long, value_name = "N", default_value_t = 11)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    repeat: u16,
    /// How often the trees are built
    #[arg(long, value_name = "N", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    builds: u16,
    /// Threads that build; all processors if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Methods of `trisect list` that the tracer takes part with
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    #[arg(default_values_t = ours::DEFAULT.map(str::to_owned))]
    methods: Vec<String>,
    /// Only these contenders
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    only: Vec<String>,
    /// Classes of rays that are made
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    #[arg(default_values_t = RayClass::ALL, value_parser = classes_of_rays())]
    classes: Vec<RayClass>,
    /// Side, in pixels, of the pictures that rays are made from
    #[arg(long, value_name = "PIXELS", default_value_t = 512)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=4096))]
    pixels: u16,
    /// Seed of the rays and of the order
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Embree's library; that which benches/install-embree.sh fetches if left out
    #[cfg(feature = "embree")]
    #[arg(long, value_name = "FILE")]
    embree: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const WORDS: &str = "\
What the exact oracle says of an answer that others differ from, and of some that they do not:
  right   the closest triangle, one exactly as close, or nothing where there is nothing
  close   a triangle that is hit, at the t of the closest one but for rounding
  beside  a triangle that is passed by no more than rounding explains, or, at the t of the
          closest one, by less than a hundredth of it
  missed  nothing, where a triangle is hit
  wrong   anything else: a triangle behind the closest one (JSON: farther), one that is not hit
          (elsewhere), or one where nothing is hit (invented)";

/// Lists the classes of rays in help.
fn classes_of_rays() -> impl TypedValueParser<Value = RayClass> {
    let named = |class: RayClass| PossibleValue::new(class.name()).help(class.says());
    PossibleValuesParser::new(RayClass::ALL.map(named)).map(|name| {
        let is_named = |class: &RayClass| class.name() == name;
        RayClass::ALL.into_iter().find(is_named).expect("it is listed")
    })
}

fn main() -> ExitCode {
    quiet_guarded_panics();
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rivals: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// Whether the reader of our output went away: no failure of ours.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let of_json =
            cause.downcast_ref::<serde_json::Error>().and_then(serde_json::Error::io_error_kind);
        let of_text = cause.downcast_ref::<std::io::Error>().map(std::io::Error::kind);
        of_json.or(of_text) == Some(ErrorKind::BrokenPipe)
    })
}

/// Says on a terminal what is being done.
fn say(what: &str) {
    if std::io::stderr().is_terminal() {
        eprintln!("{what}");
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let entrants = entrants(arguments)?;
    let is_wanted =
        |resident: &Resident| arguments.only.is_empty() || arguments.only.contains(&resident.name);
    let threads = match arguments.threads {
        Some(threads) => usize::from(threads),
        None => {
            std::thread::available_parallelism().context("the processors cannot be counted")?.get()
        }
    };
    let meshes = meshes(arguments)?;
    let from_file = arguments.rays.as_ref().map(read_rays).transpose()?;
    if let (Some(read), Some(file)) = (&from_file, &arguments.rays) {
        ensure!(!read.rays_f32.is_empty(), "{}: no rays; name another file", file.display());
    }
    let mut report = Report::new(threads, usize::from(arguments.repeat));
    for mesh in meshes {
        let classes = match &from_file {
            Some(read) => {
                let rays = read.rays_f32.clone();
                vec![ClassOfRays { name: "rays", any: arguments.any, rays }]
            }
            None => classes(&mesh, arguments)?,
        };
        say(&format!("{}: building over {} triangles", mesh.name, mesh.triangles.len()));
        let mut random = Pcg64::seed_from_u64(arguments.seed);
        let (trees, mut residents) =
            build(&entrants, &mesh.triangles, threads, usize::from(arguments.builds), &mut random)?;
        residents.retain(is_wanted);
        report.built(&mesh, &trees);
        // One thread, whatever a contender's own pool would be.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        for ClassOfRays { name, any, rays } in classes {
            say(&format!("{}: tracing {} rays, {name}", mesh.name, rays.len()));
            let times = pool.install(|| {
                race(&mut residents, &rays, any, usize::from(arguments.repeat), &mut random)
            })?;
            let answers: Vec<_> =
                residents.iter().map(|resident| resident.contender.answers(any)).collect();
            say(&format!("{}: settling differences", mesh.name));
            let settlement = settle(&rays, &mesh.triangles, &answers);
            report.raced(
                Class { name: name.to_owned(), any, rays: rays.len() },
                &residents,
                &times,
                &answers,
                settlement,
            );
        }
    }
    report.print(arguments.json)
}

/// All meshes, before anything takes its time.
fn meshes(arguments: &Arguments) -> Result<Vec<Mesh>> {
    let mut names = BTreeSet::new();
    let load = |path: &PathBuf| {
        let mesh = Mesh::load(path)?;
        ensure!(!mesh.triangles.is_empty(), "{}: no triangles; name another mesh", path.display());
        // They are told apart by their names.
        ensure!(
            names.insert(mesh.name.clone()),
            "{}: a mesh named `{}` is given already; rename one of the files",
            path.display(),
            mesh.name
        );
        Ok(if arguments.copies == 1 { mesh } else { crowd(&mesh, arguments.copies)? })
    };
    arguments.mesh.iter().map(load).collect()
}

/// The trees that are built: all, or those that the named contenders trace with.
fn entrants(arguments: &Arguments) -> Result<Vec<Entrant>> {
    let mut entrants = Vec::new();
    let mut methods = BTreeSet::new();
    for method in &arguments.methods {
        ensure!(methods.insert(method), "method `{method}` is named twice; name each once");
        entrants.extend(ours::entrants(method)?);
    }
    #[cfg(feature = "embree")]
    entrants.extend(embree::entrants(arguments.embree.as_deref()));
    entrants.extend(crates::entrants());
    if arguments.only.is_empty() {
        return Ok(entrants);
    }
    let names: Vec<&String> = entrants.iter().flat_map(|entrant| &entrant.contenders).collect();
    if let Some(unknown) = arguments.only.iter().find(|only| !names.contains(only)) {
        let names: Vec<&str> = names.into_iter().map(String::as_str).collect();
        bail!("--only: no contender `{unknown}`; there are {}", names.join(", "));
    }
    entrants.retain(|entrant| entrant.contenders.iter().any(|name| arguments.only.contains(name)));
    Ok(entrants)
}

/// Rays of the classes that are asked for.
fn classes(mesh: &Mesh, arguments: &Arguments) -> Result<Vec<ClassOfRays>> {
    say(&format!("{}: making rays", mesh.name));
    let mut asked = RayClass::ALL.to_vec();
    asked.retain(|class| arguments.classes.contains(class));
    let made = trisect_studies::tracer::classes_of_rays(
        mesh,
        arguments.pixels.into(),
        arguments.seed,
        &asked,
    );
    // Without what the camera sees there are no rays from it.
    ensure!(
        !made.is_empty(),
        "{}: the camera sees nothing to trace from; name another class or mesh",
        mesh.name
    );
    Ok(made)
}
