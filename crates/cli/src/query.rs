//! `trisect query`: rays against a mesh.

use std::io::{self, Write};
use std::sync::Arc;

use anyhow::{Context as _, Result, anyhow, bail};
use rayon::prelude::*;
use serde::Serialize;
use trisect_catalog::{
    Builder, Entry, Finder, Kernels, TREES_F64, Tracing, Tree, TriangleHit, Variant,
};
use trisect_core::{FloatFormat, Hit, Precision, Ray, Scalar as _, Triangle, Vec3};
use trisect_method::{Culling, Output, Place, UnsuitableMesh};
use trisect_oracle::{Exact, Oracle};
use trisect_studies::input;
use trisect_tracer::{AllHits, Crossings};
use trisect_workloads::{Mesh, PointsFile, RaysFile, read_points};

use crate::arguments::Query;
use crate::studies::say;
use crate::{list, output, reading};

/// The name that stands for the exact truth.
const ORACLE: &str = "oracle";

/// One ray's answer.
enum Answer<E> {
    Miss,
    /// Some hit, no matter which.
    Any,
    Closest(u32, Hit<E>),
    /// The closest, of a method that gives no barycentrics.
    Bare(u32, E),
}

/// One hit of several.
#[derive(Serialize)]
struct OneHit<E> {
    triangle: u32,
    t: E,
    /// Not of a method that gives none.
    #[serde(flatten)]
    weights: Option<Weights<E>>,
}

#[derive(Serialize)]
struct Weights<E> {
    beta: E,
    gamma: E,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Line<E> {
    Flag {
        ray: usize,
        hit: bool,
    },
    Closest {
        ray: usize,
        hit: bool,
        triangle: u32,
        t: E,
        beta: E,
        gamma: E,
    },
    /// Of a method that gives no barycentrics.
    Bare {
        ray: usize,
        hit: bool,
        triangle: u32,
        t: E,
    },
}

#[derive(Serialize)]
struct AllLine<E> {
    ray: usize,
    hits: Vec<OneHit<E>>,
}

#[derive(Serialize)]
struct CountLine {
    ray: usize,
    count: u32,
}

#[derive(Serialize)]
struct PlaceLine {
    point: usize,
    place: &'static str,
}

pub(crate) fn run(arguments: &Query) -> Result<()> {
    if arguments.owned && !(arguments.all || arguments.count) {
        bail!("--owned says which hits count; use it with --all or --count");
    }
    match (beyond_the_nearest(arguments), arguments.precision) {
        (Some(option), FloatFormat::F32) => many::<f32>(arguments, option),
        (Some(option), FloatFormat::F64) => many::<f64>(arguments, option),
        (None, FloatFormat::F32) => answer::<f32>(arguments),
        (None, FloatFormat::F64) => answer::<f64>(arguments),
    }
}

/// What is asked about in a precision, and by what.
trait Asked: Precision + trisect_tracer::Precision + Serialize {
    fn kernels(entry: &'static Entry) -> &'static Kernels<Self>;

    fn rays(file: RaysFile) -> Vec<Ray<Self>>;

    fn points(file: PointsFile) -> Vec<Vec3<Self>>;

    /// The triangles; what is lost by rounding is said, with what `mend`s it.
    fn triangles(arguments: &Query, mesh: &Mesh, mend: &str) -> Arc<[Triangle<Self>]>;

    /// Whether a method has a tree.
    fn has_tree(entry: &Entry) -> bool;

    /// Its tree, if it has one: quick to build, as it is used once.
    fn tree(entry: &Entry, triangles: &[Triangle<Self>]) -> Option<Built<Self>>;
}

/// A tree.
type Built<E> = Result<Box<dyn Tree<E>>, UnsuitableMesh>;

impl Asked for f32 {
    fn kernels(entry: &'static Entry) -> &'static Kernels<f32> {
        &entry.f32
    }

    fn rays(file: RaysFile) -> Vec<Ray<f32>> {
        file.rays_f32
    }

    fn points(file: PointsFile) -> Vec<Vec3<f32>> {
        file.points_f32
    }

    fn triangles(arguments: &Query, mesh: &Mesh, mend: &str) -> Arc<[Triangle<f32>]> {
        input::say_degenerate(&arguments.mesh, mesh.degenerate, mesh, &say);
        input::say_rounding(&arguments.mesh, mesh.rounding(), mend, &say);
        Arc::clone(&mesh.triangles)
    }

    fn has_tree(_: &Entry) -> bool {
        true
    }

    fn tree(entry: &Entry, triangles: &[Triangle<f32>]) -> Option<Built<f32>> {
        Some(entry.tree(triangles, Builder::Binned))
    }
}

impl Asked for f64 {
    fn kernels(entry: &'static Entry) -> &'static Kernels<f64> {
        &entry.f64
    }

    fn rays(file: RaysFile) -> Vec<Ray<f64>> {
        file.rays
    }

    fn points(file: PointsFile) -> Vec<Vec3<f64>> {
        file.points
    }

    fn triangles(arguments: &Query, mesh: &Mesh, _: &str) -> Arc<[Triangle<f64>]> {
        input::say_degenerate(&arguments.mesh, mesh.degenerate_f64(), mesh, &say);
        mesh.triangles_f64()
    }

    fn has_tree(entry: &Entry) -> bool {
        TREES_F64.contains(&entry.info.name)
    }

    fn tree(entry: &Entry, triangles: &[Triangle<f64>]) -> Option<Built<f64>> {
        entry.tree_f64(triangles, Builder::Binned)
    }
}

/// Where coordinates stay as they are in the file.
const KEEPS: &str = "--precision f64 keeps them where they are";

fn answer<E: Asked>(arguments: &Query) -> Result<()> {
    // What is typed is checked before what is read.
    let finder = if arguments.method == ORACLE {
        None
    } else {
        let entry = input::method(&arguments.method)?;
        let kernels = E::kernels(entry);
        Some((entry, kernels, choose(arguments, entry, kernels)?))
    };
    let mesh = input::read_mesh(&arguments.mesh, &arguments.reading, &say)?;
    let triangles = E::triangles(arguments, &mesh, KEEPS);
    let rays = E::rays(load_rays(arguments)?);
    let unsuitable = |error| anyhow!("{}: {error}", arguments.mesh.display());
    // The tree decides as the form does that decides without quotients.
    let in_tree = !arguments.brute_force && arguments.division.is_none();
    let tree = match finder {
        Some((entry, ..)) if in_tree => {
            E::tree(entry, &triangles).transpose().map_err(unsuitable)?
        }
        _ => None,
    };
    let culling = arguments.cull.into();
    let answers = match (finder, tree) {
        (None, _) => truth(&rays, &triangles, culling, arguments.any),
        (Some((entry, ..)), Some(tree)) => in_tree_of(&*tree, entry, arguments, &rays, culling),
        (Some((entry, kernels, finder)), None) => {
            let weighs = entry.info.gives(Output::Barycentrics);
            let scene = (kernels.prepare)(&triangles, &rays).map_err(unsuitable)?;
            if arguments.any {
                let any = finder.any(&scene, culling, rays.len());
                any.into_iter().map(Answer::any).collect()
            } else {
                let closest = finder.closest(&scene, culling, rays.len());
                closest.into_iter().map(|closest| Answer::widened(closest, weighs)).collect()
            }
        }
    };
    output::print(|out| {
        for (ray, answer) in answers.into_iter().enumerate() {
            answer.print(ray, out)?;
        }
        Ok(())
    })
}

/// The rays that are asked about.
fn load_rays(arguments: &Query) -> Result<RaysFile> {
    let rays = arguments.rays.as_deref().context("no rays; name a file with --rays")?;
    reading::load_rays(rays, &arguments.reading)
}

/// The option that asks for more than the nearest hit.
fn beyond_the_nearest(arguments: &Query) -> Option<&'static str> {
    let options = [
        ("--all", arguments.all),
        ("--count", arguments.count),
        ("--contains", arguments.contains.is_some()),
    ];
    options.into_iter().find_map(|(option, is_given)| is_given.then_some(option))
}

/// Answers what takes a tree.
fn many<E: Asked>(arguments: &Query, option: &str) -> Result<()> {
    if arguments.brute_force {
        bail!("{option} is answered by a tree; leave --brute-force out");
    }
    if arguments.division.is_some() {
        bail!("{option} divides as the tree does; leave --division out");
    }
    if arguments.method == ORACLE {
        bail!("{option} is not answered by the oracle; use --method exact, which decides alike");
    }
    let entry = input::method(&arguments.method)?;
    if !entry.info.claims.exact && (arguments.owned || arguments.contains.is_some()) {
        let option = if arguments.owned { "--owned" } else { option };
        bail!(
            "{} rounds, and {option} takes exact decisions; use --method exact",
            arguments.method
        );
    }
    if !E::has_tree(entry) {
        bail!(
            "{} has no tree in f64, and {option} takes one; use --method {}, or leave --precision out",
            arguments.method,
            TREES_F64.join(" or ")
        );
    }
    choose(arguments, entry, E::kernels(entry))?;
    let mesh = input::read_mesh(&arguments.mesh, &arguments.reading, &say)?;
    let mend = if TREES_F64.contains(&entry.info.name) { KEEPS } else { input::MOVE };
    let triangles = E::triangles(arguments, &mesh, mend);
    let build = || {
        let tree = E::tree(entry, &triangles).context("it was asked for before")?;
        tree.map_err(|unsuitable| anyhow!("{}: {unsuitable}", arguments.mesh.display()))
    };
    if let Some(points) = &arguments.contains {
        let points = E::points(read_points(points, &(&arguments.reading).into())?);
        let mut places = vec![Place::Outside; points.len()];
        build()?.contains_of(&points, &mut places)?;
        let name = |place| match place {
            Place::Inside => "inside",
            Place::On => "on",
            Place::Outside => "outside",
        };
        let lines = places.into_iter().enumerate();
        return print(lines.map(|(point, place)| PlaceLine { point, place: name(place) }));
    }
    let rays = E::rays(load_rays(arguments)?);
    let (tracing, culling) = (Tracing::Plain, arguments.cull.into());
    let crossings = if arguments.owned { Crossings::Owned } else { Crossings::Every };
    if arguments.count {
        let mut counts = vec![0; rays.len()];
        build()?.count_of(tracing, culling, crossings, &rays, &mut counts);
        return print(counts.into_iter().enumerate().map(|(ray, count)| CountLine { ray, count }));
    }
    let mut all = AllHits::default();
    build()?.all_of(tracing, culling, crossings, &rays, &mut all);
    let weighs = entry.info.gives(Output::Barycentrics);
    let one = |&TriangleHit { triangle, hit: Hit { t, beta, gamma } }: &TriangleHit<E>| OneHit {
        triangle,
        t,
        weights: weighs.then_some(Weights { beta, gamma }),
    };
    print((0..rays.len()).map(|ray| AllLine { ray, hits: all.of(ray).iter().map(one).collect() }))
}

/// Prints lines of JSON.
fn print(lines: impl Iterator<Item = impl Serialize>) -> Result<()> {
    output::print(|out| {
        for line in lines {
            serde_json::to_writer(&mut *out, &line)?;
            out.write_all(b"\n")?;
        }
        Ok(())
    })
}

/// Answers from a tree.
fn in_tree_of<E: Asked>(
    tree: &dyn Tree<E>,
    entry: &Entry,
    arguments: &Query,
    rays: &[Ray<E>],
    culling: Culling,
) -> Vec<Answer<E>> {
    if arguments.any {
        let mut any = vec![false; rays.len()];
        tree.any(Tracing::Plain, culling, rays, &mut any);
        return any.into_iter().map(Answer::any).collect();
    }
    let weighs = entry.info.gives(Output::Barycentrics);
    let mut found = vec![None; rays.len()];
    tree.closest(Tracing::Plain, culling, rays, &mut found);
    let answer = |TriangleHit { triangle, hit }: TriangleHit<E>| {
        if weighs { Answer::Closest(triangle, hit) } else { Answer::Bare(triangle, hit.t) }
    };
    found.into_iter().map(|found| found.map_or(Answer::Miss, answer)).collect()
}

/// The finder of the width and division asked for.
fn choose<E: Precision>(
    arguments: &Query,
    entry: &Entry,
    kernels: &'static Kernels<E>,
) -> Result<&'static Finder> {
    let here = list::widths(kernels.finders.iter().map(|finder| &finder.variant));
    let here = here.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    let precision = arguments.precision;
    let width = arguments.width.lanes();
    let forms = entry.info.forms.list();
    if let Some(division) = arguments.division
        && !forms.contains(&division)
    {
        let other: Vec<_> = forms.iter().map(|form| form.name()).collect();
        bail!(
            "{} has no {division} division; leave --division out or use {}",
            arguments.method,
            other.join(", ")
        );
    }
    let Some(finder) = kernels.plain_finder(width, arguments.division) else {
        let width = width.map_or("native".to_owned(), |width| width.to_string());
        bail!("{precision} queries have no width {width}; use --width native or one of {here}");
    };
    let Variant { width, instruction_set, .. } = &finder.variant;
    if !instruction_set.is_available() {
        bail!(
            "{precision} width {width} stands for {instruction_set}, which this processor lacks; \
             use --width native or one of {here}"
        );
    }
    Ok(finder)
}

/// The oracle's answers, on all processors.
fn truth<E: Precision>(
    rays: &[Ray<E>],
    triangles: &[Triangle<E>],
    culling: Culling,
    any: bool,
) -> Vec<Answer<E>> {
    let answer = |ray: &Ray<E>| {
        let mut oracle = Oracle::default();
        if culling == Culling::None && !any {
            return oracle.closest(ray, triangles).into();
        }
        let mut seen = (0_u32..).zip(triangles).filter(|(_, triangle)| {
            oracle.classify(ray, triangle).is_hit() && is_seen(ray, triangle, culling)
        });
        if any {
            return Answer::any(seen.next().is_some());
        }
        let (numbers, seen): (Vec<u32>, Vec<Triangle<E>>) = seen.unzip();
        match oracle.closest(ray, &seen).into() {
            Answer::Closest(place, hit) => Answer::Closest(numbers[place as usize], hit),
            other => other,
        }
    };
    rays.par_iter().map(answer).collect()
}

/// Whether culling leaves the face that the ray meets; decided exactly.
fn is_seen<E: Precision>(ray: &Ray<E>, triangle: &Triangle<E>, culling: Culling) -> bool {
    if culling == Culling::None {
        return true;
    }
    Exact::scope(|| {
        let exact = |v: Vec3<E>| v.map(|x| Exact::from_f64(x.to_f64()));
        let [a, b, c] = triangle.corners().map(exact);
        let along_normal = exact(ray.d).dot((b - a).cross(c - a));
        let zero = Exact::from_f64(0.0);
        match culling {
            Culling::Back => along_normal < zero,
            _ => along_normal > zero,
        }
    })
}

impl<E: Precision> Answer<E> {
    /// Of whether there is a hit.
    fn any(hit: bool) -> Self {
        if hit { Self::Any } else { Self::Miss }
    }

    /// From a finder, whose numbers were widened exactly.
    fn widened(closest: Option<(u32, Hit<f64>)>, weighs: bool) -> Self {
        closest.map_or(Self::Miss, |(number, Hit { t, beta, gamma })| {
            let [t, beta, gamma] = [t, beta, gamma].map(E::from_f64);
            if weighs {
                Self::Closest(number, Hit { t, beta, gamma })
            } else {
                Self::Bare(number, t)
            }
        })
    }
}

impl<E> From<Option<(usize, trisect_oracle::Answer<E>)>> for Answer<E> {
    fn from(closest: Option<(usize, trisect_oracle::Answer<E>)>) -> Self {
        closest
            .and_then(|(number, answer)| {
                Some(Self::Closest(u32::try_from(number).ok()?, answer.hit?))
            })
            .unwrap_or(Self::Miss)
    }
}

impl<E: Serialize> Answer<E> {
    fn print(self, ray: usize, out: &mut dyn Write) -> io::Result<()> {
        let line = match self {
            Self::Miss => Line::Flag { ray, hit: false },
            Self::Any => Line::Flag { ray, hit: true },
            Self::Closest(triangle, Hit { t, beta, gamma }) => {
                Line::Closest { ray, hit: true, triangle, t, beta, gamma }
            }
            Self::Bare(triangle, t) => Line::Bare { ray, hit: true, triangle, t },
        };
        serde_json::to_writer(&mut *out, &line)?;
        out.write_all(b"\n")
    }
}
