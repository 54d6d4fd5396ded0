//! This project's tree, with any method of the catalogue.

use std::ops::Range;
use std::time::Instant;

use anyhow::{Context as _, Result, anyhow};
use trisect_catalog::{Tracing, Tree, TriangleHit, entries};
use trisect_core::{Culling, Ray};

use crate::contender::{Answers, Contender, Entrant, Found};

/// The tree of a method, in every way of tracing.
///
/// # Errors
/// When there is no such method.
pub fn entrants(method: &str) -> Result<Vec<Entrant>> {
    let entry = entries()
        .iter()
        .find(|entry| entry.info.name == method)
        .with_context(|| format!("{method}: no such method; `trisect list` names them all"))?;
    let build = entry.tree;
    Ok(vec![Entrant {
        name: method.to_owned(),
        build: Box::new(move |triangles, threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .context("the system gives no threads; ask for fewer with --threads")?;
            let (tree, time) = pool.install(|| {
                let start = Instant::now();
                let tree = build(triangles);
                (tree, start.elapsed())
            });
            let tree = tree.map_err(|unsuitable| anyhow!("{method}: {unsuitable}"))?;
            let ours = Ours { tree, rays: Vec::new(), closest: Vec::new(), any: Vec::new() };
            Ok((Box::new(ours) as Box<dyn Contender>, time))
        }),
    }])
}

struct Ours {
    tree: Box<dyn Tree>,
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
        self.tree.closest(Tracing::Single, Culling::None, &self.rays[rays], found);
    }

    fn any(&mut self, rays: Range<usize>) {
        let found = &mut self.any[rays.clone()];
        self.tree.any(Tracing::Single, Culling::None, &self.rays[rays], found);
    }

    fn answers(&self, any: bool) -> Answers {
        if any {
            return Answers::Any(self.any.clone());
        }
        let found = |hit: &TriangleHit| Found { triangle: hit.triangle, t: hit.hit.t };
        Answers::Closest(self.closest.iter().map(|hit| hit.as_ref().map(found)).collect())
    }

    fn bytes(&self) -> Option<usize> {
        Some(self.tree.statistics().bytes)
    }
}
