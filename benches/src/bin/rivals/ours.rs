//! This project's tree, with any method of the catalogue.

use std::ops::Range;
use std::sync::Arc;

use anyhow::{Context as _, Result, anyhow};
use trisect_catalog::{Builder, Entry, Tracing, Tree, TriangleHit, find};
use trisect_core::Ray;
use trisect_method::Culling;

use crate::contender::{Answers, Built, Contender, Entrant, Found, timed};

/// The methods that take part if none are named: the fastest in a tree that any mesh may be given
/// to, and the one that never lets a ray through between triangles.
pub(crate) const DEFAULT: [&str; 2] = ["moller-trumbore", "watertight"];

/// How rays are handed to a tree.
#[derive(Clone, Copy)]
enum Handing {
    /// All at once.
    Batch(Tracing),
    /// One per call, as Embree's are.
    Calls,
}

/// How a tree is traced with, and what the name of who does so ends in.
type Way = (Handing, &'static str);

const WAYS: [Way; 3] = [
    (Handing::Batch(Tracing::Single), ""),
    (Handing::Batch(Tracing::Packets), " packets"),
    (Handing::Calls, " calls"),
];

/// The trees of a method: that which is the fastest to trace in every way of tracing, and those that are
/// built by other builders.
///
/// # Errors
/// When there is no such method.
pub(crate) fn entrants(method: &str) -> Result<Vec<Entrant>> {
    let entry = self::method(method)?;
    let entrants = Builder::ALL.into_iter().rev().map(|builder| {
        if builder == Builder::default() {
            entrant(method, &WAYS, builder, entry)
        } else {
            entrant(&format!("{method} {builder}"), &WAYS[..1], builder, entry)
        }
    });
    Ok(entrants.collect())
}

fn method(name: &str) -> Result<&'static Entry> {
    find(name)
        .with_context(|| format!("unknown method `{name}`; `trisect list` shows what there is"))
}

fn entrant(name: &str, ways: &'static [Way], builder: Builder, entry: &'static Entry) -> Entrant {
    Entrant {
        name: name.to_owned(),
        contenders: ways.iter().map(|(_, suffix)| format!("{name}{suffix}")).collect(),
        build: Box::new(move |triangles, threads| {
            let (tree, time) = timed(threads, || entry.tree(triangles, builder))?;
            let tree = tree.map_err(|unsuitable| anyhow!("{unsuitable}"))?;
            let bytes = Some(tree.statistics().bytes);
            let tree: Arc<dyn Tree> = tree.into();
            let contender = |&(handing, _): &Way| {
                let tree = Arc::clone(&tree);
                let (rays, closest, any) = (Vec::new(), Vec::new(), Vec::new());
                Box::new(Ours { tree, handing, rays, closest, any }) as Box<dyn Contender>
            };
            Ok(Built { contenders: ways.iter().map(contender).collect(), time, bytes })
        }),
    }
}

struct Ours {
    tree: Arc<dyn Tree>,
    handing: Handing,
    rays: Vec<Ray<f32>>,
    closest: Vec<Option<TriangleHit>>,
    any: Vec<bool>,
}

impl Contender for Ours {
    fn load(&mut self, rays: &[Ray<f32>]) {
        self.rays = rays.to_vec();
        self.closest = vec![None; rays.len()];
        self.any = vec![false; rays.len()];
    }

    fn closest(&mut self, rays: Range<usize>) {
        let found = &mut self.closest[rays.clone()];
        let rays = &self.rays[rays];
        match self.handing {
            Handing::Batch(tracing) => self.tree.closest(tracing, Culling::None, rays, found),
            Handing::Calls => {
                for (ray, found) in rays.iter().zip(found) {
                    *found = self.tree.closest_hit(Culling::None, ray).found();
                }
            }
        }
    }

    fn any(&mut self, rays: Range<usize>) {
        let found = &mut self.any[rays.clone()];
        let rays = &self.rays[rays];
        match self.handing {
            Handing::Batch(tracing) => self.tree.any(tracing, Culling::None, rays, found),
            Handing::Calls => {
                for (ray, found) in rays.iter().zip(found) {
                    *found = self.tree.any_hit(Culling::None, ray);
                }
            }
        }
    }

    fn answers(&self, any: bool) -> Answers {
        if any {
            return Answers::Any(self.any.clone());
        }
        let found = |hit: &TriangleHit| Found { triangle: hit.triangle, t: hit.hit.t };
        Answers::Closest(self.closest.iter().map(|hit| hit.as_ref().map(found)).collect())
    }
}
