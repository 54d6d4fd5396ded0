//! The command line.

mod values;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use trisect_catalog::Builder;
use trisect_core::FloatFormat;
use trisect_formula::Language;
use trisect_method::{Form, Output};
use trisect_render::Sampling;
use trisect_studies::input::{Reading, Subjects};
use trisect_studies::{Choice, Shard, comparison};

pub(crate) use values::{Cull, Light, Primary, Shade, Textures, Width};
use values::{builders, named, positive};

use crate::studies::Published;

/// Compares ray–triangle intersection methods on this machine: error against run time.
///
/// Without a verb: measures every method on random triangles and on the Stanford bunny, says which to
/// use, and writes a page to reports/latest/.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub verb: Option<Verb>,
    #[command(flatten)]
    pub compare: Compare,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// List methods, widths and instruction sets on this processor
    List(List),
    /// Measure and write records
    Measure(Measure),
    /// Merge the shards of a record into that of one run
    Merge(Merge),
    /// Rank the variants of a record by speed
    Rank(Rank),
    /// Compare two records: two machines, or two commits
    Cmp(Cmp),
    /// Draw the page and its figures from a record, and print its summary
    Report(Report),
    /// Check every method against the exact oracle
    Verify(Verify),
    #[command(flatten)]
    Study(Choice<Published>),
    /// Trace rays through a mesh in a tree, and say how fast
    Trace(Trace),
    /// Intersect rays with a mesh
    Query(Query),
    /// Render a scene to a picture
    Render(Render),
    /// Recommend methods for a mesh and its rays
    Recommend(Recommend),
    /// Explain what a scene needs, what is left out for it, and what that gains
    Explain(Explain),
    /// Write a method's kernel as C, WGSL, GLSL or Rust
    Emit(Emit),
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page of the command, or of one of its commands, in roff
    Man {
        /// One of its commands
        command: Option<String>,
    },
}

#[derive(Debug, Args)]
#[command(mut_arg("output", |output| output.help("Folder for the page, its figures and the record")))]
pub(crate) struct Compare {
    #[command(flatten)]
    pub settings: comparison::Settings,
    #[command(flatten)]
    pub published: Published,
}

#[derive(Debug, Args)]
pub(crate) struct Measure {
    #[command(flatten)]
    pub settings: comparison::Settings,
    /// File for the record; standard output if left out
    #[arg(long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Only share I of N, from 1; `trisect merge` makes the record of one run of all
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
}

/// Merge the shards of a record, which several machines have taken with --shard, into that of one run: the same lines,
/// but for times.
#[derive(Debug, Args)]
pub(crate) struct Merge {
    /// All shards, in any order
    #[arg(value_name = "SHARD", required = true)]
    pub shards: Vec<PathBuf>,
    /// File for the record; standard output if left out
    #[arg(long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct List {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Rank {
    /// The record
    #[arg(value_name = "FILE")]
    pub record: PathBuf,
    /// What is asked of a hit; all if left out
    #[arg(long, value_parser = named::<Output>())]
    pub needs: Option<Output>,
    /// Only this workload
    #[arg(long, value_name = "NAME")]
    pub workload: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Cmp {
    /// The record that ratios are relative to
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// The other record
    #[arg(value_name = "B")]
    pub b: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Report {
    /// The record
    #[arg(value_name = "FILE")]
    pub record: PathBuf,
    /// Folder for the page and its figures
    #[arg(long, value_name = "FOLDER", default_value = "reports/latest")]
    pub output: PathBuf,
    /// Make the parts of this Markdown file anew that stand between markers, instead of a page; any
    /// number of times
    #[arg(long, value_name = "FILE", conflicts_with_all = ["output", "json"])]
    pub splice: Vec<PathBuf>,
    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(mut_arg("mesh", |mesh| mesh.help(
    "Mesh (PLY, OBJ, STL or glTF), any number of times; random triangles if left out"
)))]
pub(crate) struct Verify {
    #[command(flatten)]
    pub subjects: Subjects,
    /// Rays for the meshes, CSV or .rays; made from the mesh if left out
    #[arg(long, value_name = "FILE", requires = "mesh")]
    pub rays: Option<PathBuf>,
    /// Print the records as JSON lines
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Trace {
    /// Mesh: PLY, OBJ, STL or glTF
    #[arg(long, value_name = "FILE")]
    pub mesh: PathBuf,
    /// Rays: CSV, binary .rays, or - for CSV from standard input
    #[arg(long, value_name = "FILE")]
    pub rays: PathBuf,
    /// A method of `trisect list`
    #[arg(long, value_name = "NAME", default_value = "moller-trumbore")]
    pub method: String,
    /// How the tree is built: the quickest to build, or the fastest to trace
    #[arg(long, value_name = "NAME", default_value_t, value_parser = builders())]
    pub builder: Builder,
    /// Any hit instead of the closest
    #[arg(long)]
    pub any: bool,
    /// Threads; all processors if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How often the rays are traced
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeat: u32,
    /// File for the hits: per ray t (f32, infinite for a miss) and triangle (u32), little-endian
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub reading: Reading,
}

#[derive(Debug, Args)]
#[allow(clippy::struct_excessive_bools, reason = "each is an option of its own")]
pub(crate) struct Query {
    /// Mesh: PLY, OBJ, STL or glTF
    #[arg(long, value_name = "FILE")]
    pub mesh: PathBuf,
    /// Rays: CSV with the header ox,oy,oz,dx,dy,dz and optionally tmin,tmax; binary .rays; or -
    /// for CSV from standard input
    #[arg(long, value_name = "FILE", required_unless_present = "contains")]
    pub rays: Option<PathBuf>,
    /// A method of `trisect list`, or `oracle` for the exact truth, rounded once
    #[arg(long, value_name = "NAME")]
    pub method: String,
    /// Floats that answers are computed in; what files hold in f64 is rounded for f32, and kept for f64
    #[arg(long, default_value = "f32", value_parser = named::<FloatFormat>())]
    pub precision: FloatFormat,
    /// Lanes; a width stands for the instruction set that it is native to, native for the widest
    #[arg(long, default_value = "native")]
    pub width: Width,
    /// When to divide [default: deferred where the method has that, else early]
    #[arg(long, value_parser = named::<Form>())]
    pub division: Option<Form>,
    /// Faces not to see
    #[arg(long, default_value = "none")]
    pub cull: Cull,
    /// Any hit instead of the closest: print no more than whether there is one
    #[arg(long, conflicts_with_all = ["all", "count", "contains"])]
    pub any: bool,
    /// All hits in order instead of the closest
    #[arg(long, conflicts_with_all = ["count", "contains"])]
    pub all: bool,
    /// How many hits there are, instead of the closest
    #[arg(long, conflicts_with = "contains")]
    pub count: bool,
    /// With --all and --count: of the triangles that share the edge or the corner that a ray meets, one owner instead
    /// of all; by --method exact alone
    #[arg(long, conflicts_with = "contains")]
    pub owned: bool,
    /// Instead of rays, points: whether each is inside, on or outside the closed surface of the mesh; CSV with
    /// the header x,y,z, or - for standard input; by --method exact alone
    #[arg(long, value_name = "POINTS", conflicts_with_all = ["rays", "cull"])]
    pub contains: Option<PathBuf>,
    /// Test every triangle instead of those that a tree leaves; --division always does, and f64 unless the method is
    /// exact, moller-trumbore or watertight
    #[arg(long)]
    pub brute_force: bool,
    #[command(flatten)]
    pub reading: Reading,
}

/// Explain what a scene's picture needs, what is left out of the code that draws it, and how much longer it
/// takes with each of that put back, in turn on this machine.
#[derive(Debug, Args)]
pub(crate) struct Explain {
    /// Scene: TOML, glTF, OBJ with its materials, or a mesh alone (PLY, STL)
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Pixels across
    #[arg(long, value_name = "N", default_value_t = 320, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub width: u32,
    /// Pixels down
    #[arg(long, value_name = "N", default_value_t = 240, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub height: u32,
    /// How often a ray may be reflected or refracted
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(..=1000))]
    pub depth: u32,
    /// The first so many lights of the scene; all if left out
    #[arg(long, value_name = "N")]
    pub lights: Option<u16>,
    /// A method of `trisect list`
    #[arg(long, value_name = "NAME", default_value = "moller-trumbore")]
    pub method: String,
    /// How trees are built: the quickest to build, or the fastest to trace
    #[arg(long, value_name = "NAME", default_value_t, value_parser = builders())]
    pub builder: Builder,
    /// Pictures of each kind
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: u32,
    /// Seed of the order of pictures
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Threads
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub reading: Reading,
}

/// Recommend methods for your own mesh and rays: the fastest, one without cracks and one that is never wrong, in a
/// tree and where every triangle is tested, with the lines of Rust that use them.
///
/// Methods in trees are those that are compiled into the loop, in turn on one thread. Their answers are held to
/// exact arithmetic on your rays, and to rays aimed at the mesh's edges. What decides anything wrongly is
/// not called never wrong, and what does not take the mesh is named.
#[derive(Debug, Args)]
pub(crate) struct Recommend {
    /// Mesh: PLY, OBJ, STL or glTF
    #[arg(long, value_name = "FILE")]
    pub mesh: PathBuf,
    /// Rays: CSV, binary .rays, or - for CSV from standard input; a camera's, random and diffusely
    /// scattered ones, and shadow rays if left out
    #[arg(long, value_name = "FILE")]
    pub rays: Option<PathBuf>,
    /// Samples of everything that is timed
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: u32,
    /// Seed of every random choice
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub reading: Reading,
}

/// Write a method's kernel as a program of its own: C, WGSL, GLSL or Rust.
///
/// Preparation and test, with their source, what they promise and how to compile them, on standard output. C and Rust
/// give the bits of this project's own kernels; docs/EMIT.md shows how they are used.
#[derive(Debug, Args)]
pub(crate) struct Emit {
    /// A method of `trisect list`
    #[arg(long, value_name = "NAME")]
    pub method: String,
    /// The language
    #[arg(long, value_parser = named::<Language>())]
    pub language: Language,
    /// When to divide [default: deferred where the method has that, else early]
    #[arg(long, value_parser = named::<Form>())]
    pub division: Option<Form>,
    /// What is asked of a hit [default: barycentrics where the method gives them, else t; occlusion of exact]
    #[arg(long, value_parser = named::<Output>())]
    pub needs: Option<Output>,
    /// Floats; shaders have f32 alone
    #[arg(long, default_value = "f32", value_parser = named::<FloatFormat>())]
    pub precision: FloatFormat,
    /// What every name begins with; the method's name if left out
    #[arg(long, value_name = "NAME")]
    pub prefix: Option<String>,
}

/// Render a scene to a picture: after Whitted, with ambient occlusion, or by tracing paths.
///
/// The same scene, seed and settings give the same picture to the bit, for any number of threads and
/// size of tiles.
#[derive(Debug, Args)]
pub(crate) struct Render {
    /// Scene: TOML, glTF, OBJ with its materials, or a mesh alone (PLY, STL)
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// File for the picture: .png, or .exr for linear floats
    #[arg(short, long, value_name = "FILE")]
    pub out: PathBuf,
    /// Pixels across; the scene says it if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub width: Option<u32>,
    /// Pixels down; the scene says it if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub height: Option<u32>,
    /// Camera of the scene, by its name or its number from 1
    #[arg(long, value_name = "NAME", default_value = "1")]
    pub camera: String,
    /// How light is followed
    #[arg(long, default_value = "whitted")]
    pub mode: Light,
    /// How it is found what the camera sees
    #[arg(long, value_name = "WAY", default_value = "cast")]
    pub primary: Primary,
    /// Paint triangle by triangle, without trees: lights without shadows, no mirrors and no glass
    #[arg(long, conflicts_with_all = ["primary", "mode", "sampling", "occlusion", "method", "builder"])]
    pub raster: bool,
    /// How surfaces are lit, with --raster
    #[arg(long, value_name = "WAY", default_value = "phong", requires = "raster")]
    pub shade: Shade,
    /// How textures lie on triangles, with --raster
    #[arg(long, value_name = "WAY", default_value = "perspective", requires = "raster")]
    pub textures: Textures,
    /// Samples of a pixel: grid:N, jittered:N and adaptive:N for N by N, circle:N for N
    /// [default: adaptive:4; of paths jittered:8]
    #[arg(long, value_name = "KIND:N")]
    pub sampling: Option<Sampling>,
    /// How often a ray may be reflected, refracted or scattered
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(..=1000))]
    pub depth: u32,
    /// What a ray must be able to add to be followed
    #[arg(long, value_name = "X", default_value_t = 1.0 / 1024.0, value_parser = positive)]
    pub cutoff: f32,
    /// The first so many lights of the scene; all if left out
    #[arg(long, value_name = "N")]
    pub lights: Option<u16>,
    /// Rays for ambient occlusion from each point; none if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub occlusion: Option<u32>,
    /// What is farther away shuts out no ambient light
    #[arg(long, value_name = "X", default_value_t = f32::INFINITY, value_parser = positive, requires = "occlusion")]
    pub occlusion_distance: f32,
    /// A method of `trisect list`
    #[arg(long, value_name = "NAME", default_value = "moller-trumbore")]
    pub method: String,
    /// How trees are built: the quickest to build, or the fastest to trace
    #[arg(long, value_name = "NAME", default_value_t, value_parser = builders())]
    pub builder: Builder,
    /// Seed of every random choice
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u32,
    /// Pixels across and down of what one thread takes at a time
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub tile: u32,
    /// Threads; all processors if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub reading: Reading,
}
