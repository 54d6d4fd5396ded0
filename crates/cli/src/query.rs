//! `trisect query`: rays against a mesh.

use std::io::{self, Write};
use std::sync::Arc;

use anyhow::{Result, anyhow, bail};
use rayon::prelude::*;
use serde::Serialize;
use trisect_catalog::{Builder, Entry, Finder, Kernels, Tracing, TriangleHit, Variant};
use trisect_core::{FloatFormat, Hit, Precision, Ray, Scalar as _, Triangle, Vec3};
use trisect_method::{Culling, Output, UnsuitableMesh};
use trisect_oracle::{Exact, Oracle};
use trisect_studies::input;
use trisect_workloads::{Mesh, RaysFile};

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

pub(crate) fn run(arguments: &Query) -> Result<()> {
    match arguments.precision {
        FloatFormat::F32 => {
            // The tree decides as the form does that decides without quotients.
            let in_tree = !arguments.brute_force && arguments.division.is_none();
            answer(
                arguments,
                |entry| &entry.f32,
                |file| file.rays_f32,
                |mesh| {
                    let mend = "--precision f64 keeps them where they are";
                    input::say_degenerate(&arguments.mesh, mesh.degenerate, mesh, &say);
                    input::say_rounding(&arguments.mesh, mesh.rounding(), mend, &say);
                    Arc::clone(&mesh.triangles)
                },
                in_tree.then_some(in_tree_of),
            )
        }
        FloatFormat::F64 => {
            let triangles = |mesh: &Mesh| {
                input::say_degenerate(&arguments.mesh, mesh.degenerate_f64(), mesh, &say);
                mesh.triangles_f64()
            };
            answer(arguments, |entry| &entry.f64, |file| file.rays, triangles, None)
        }
    }
}

fn answer<E: Precision + Serialize>(
    arguments: &Query,
    kernels: impl Fn(&'static Entry) -> &'static Kernels<E>,
    rays: impl Fn(RaysFile) -> Vec<Ray<E>>,
    triangles: impl Fn(&Mesh) -> Arc<[Triangle<E>]>,
    tree: Option<InTree<E>>,
) -> Result<()> {
    // What is typed is checked before what is read.
    let finder = if arguments.method == ORACLE {
        None
    } else {
        let entry = input::method(&arguments.method)?;
        let kernels = kernels(entry);
        Some((entry, kernels, choose(arguments, entry, kernels)?))
    };
    let triangles = triangles(&input::read_mesh(&arguments.mesh, &arguments.reading, &say)?);
    let rays = rays(reading::load_rays(&arguments.rays, &arguments.reading)?);
    let culling = arguments.cull.into();
    let answers = match finder {
        None => truth(&rays, &triangles, culling, arguments.any),
        Some((entry, ..)) if let Some(tree) = tree => {
            tree(entry, arguments, &rays, &triangles, culling)
                .map_err(|unsuitable| anyhow!("{}: {unsuitable}", arguments.mesh.display()))?
        }
        Some((entry, kernels, finder)) => {
            let weighs = entry.info.gives(Output::Barycentrics);
            let scene = (kernels.prepare)(&triangles, &rays)
                .map_err(|unsuitable| anyhow!("{}: {unsuitable}", arguments.mesh.display()))?;
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

/// Answers from a tree.
type InTree<E> = fn(
    &Entry,
    &Query,
    &[Ray<E>],
    &[Triangle<E>],
    Culling,
) -> Result<Vec<Answer<E>>, UnsuitableMesh>;

fn in_tree_of(
    entry: &Entry,
    arguments: &Query,
    rays: &[Ray<f32>],
    triangles: &[Triangle<f32>],
    culling: Culling,
) -> Result<Vec<Answer<f32>>, UnsuitableMesh> {
    // Quick to build, as it is used once.
    let tree = entry.tree(triangles, Builder::Binned)?;
    if arguments.any {
        let mut any = vec![false; rays.len()];
        tree.any(Tracing::Plain, culling, rays, &mut any);
        return Ok(any.into_iter().map(Answer::any).collect());
    }
    let weighs = entry.info.gives(Output::Barycentrics);
    let mut found = vec![None; rays.len()];
    tree.closest(Tracing::Plain, culling, rays, &mut found);
    let widen = |TriangleHit { triangle, hit: Hit { t, beta, gamma } }| {
        let [t, beta, gamma] = [t, beta, gamma].map(f64::from);
        (triangle, Hit { t, beta, gamma })
    };
    Ok(found.into_iter().map(|found| Answer::widened(found.map(widen), weighs)).collect())
}

/// The finder of the width and division asked for.
fn choose<E: Precision>(
    arguments: &Query,
    entry: &Entry,
    kernels: &'static Kernels<E>,
) -> Result<&'static Finder> {
    let here = list::widths(&kernels.finders).iter().map(usize::to_string).collect::<Vec<_>>();
    let here = here.join(", ");
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
        bail!("{precision} has no width {width}; use --width native or one of {here}");
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
