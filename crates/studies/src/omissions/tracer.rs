//! Rays through trees with guarantees and values that nobody asks for.

use std::time::{Duration, Instant};

use rayon::ThreadPool;
use trisect_catalog::{
    BuildTree, Builder, Leaves, Tracing, Tree, TriangleHit, find, waived_watertight,
};
use trisect_core::Ray;
use trisect_method::Culling;
use trisect_workloads::{Mesh, RayClass, hall};

use super::measure::{Leaving, Subject, in_turn};
use super::record::{Layer, Omission};
use crate::kernels::{REFERENCE, reference};
use crate::study::{StudyError, pool};
use crate::timing::WrongAnswer;
use crate::tracer::rays::{ClassOfRays, classes_of_rays};

/// Rays through a tree in some way.
struct Contender<'a> {
    method: &'a str,
    tree: &'a dyn Tree,
    tracing: Tracing,
    culling: Culling,
    any: bool,
    pool: &'a ThreadPool,
    /// Of the first time.
    hits: Option<usize>,
}

/// Where hits are written.
struct Places {
    closest: Vec<Option<TriangleHit>>,
    any: Vec<bool>,
}

impl Contender<'_> {
    /// Traces all rays; every time as many must hit.
    fn trace(&mut self, rays: &[Ray<f32>], places: &mut Places) -> Result<Duration, WrongAnswer> {
        let Self { tree, tracing, culling, any, pool, .. } = *self;
        let time = pool.install(|| {
            let start = Instant::now();
            if any {
                tree.any(tracing, culling, rays, &mut places.any);
            } else {
                tree.closest(tracing, culling, rays, &mut places.closest);
            }
            start.elapsed()
        });
        let hits = if any {
            places.any.iter().filter(|hit| **hit).count()
        } else {
            places.closest.iter().flatten().count()
        };
        let expected = *self.hits.get_or_insert(hits);
        if hits == expected {
            return Ok(time);
        }
        Err(WrongAnswer {
            kernel: format!("{} ({tracing:?})", self.method),
            found: format!("{hits} hits"),
            expected: expected.to_string(),
        })
    }
}

/// Of a scene, trees of each method that takes part.
struct Trees {
    reference: Box<dyn Tree>,
    watertight: Box<dyn Tree>,
    /// The same method and its copy without the promise, each behind calls: they differ in the promise alone.
    promised: Box<dyn Tree>,
    waived: Box<dyn Tree>,
    exact: Box<dyn Tree>,
}

impl Trees {
    fn of(scene: &Mesh) -> Self {
        let triangles = &scene.triangles;
        let of = |name: &str| {
            let entry = find(name).expect("it is in the catalogue");
            entry.tree(triangles, Builder::Spatial).expect("it takes every mesh")
        };
        let erased = |build: BuildTree| {
            build(triangles, Builder::Spatial, Leaves::default()).expect("it takes every mesh")
        };
        let promised = find("watertight").expect("it is in the catalogue").erased_tree;
        Self {
            reference: reference()
                .tree(triangles, Builder::Spatial)
                .expect("the reference takes every mesh"),
            watertight: of("watertight"),
            promised: erased(promised),
            waived: erased(waived_watertight),
            exact: of("exact"),
        }
    }
}

impl Leaving<'_, '_> {
    /// Rays of each class through the bunny and a hall, on one thread.
    pub(super) fn tracer(&mut self) -> Result<(), StudyError> {
        let one = pool(1)?;
        for scene in [trisect_workloads::bunny(), hall()] {
            self.run.progress.phase(&format!("{}: trees", scene.name), 1);
            let trees = Trees::of(&scene);
            let (pixels, seed) = (self.study.pixels, self.study.seed);
            let classes = classes_of_rays(&scene, pixels, seed, &RayClass::ALL);
            self.run.progress.step();
            self.run.progress.phase(&format!("{}: rays", scene.name), classes.len() as u64);
            for class in &classes {
                let found = self.class(&scene.name, &trees, class, &one)?;
                self.found(found);
                self.run.progress.step();
            }
        }
        Ok(())
    }

    /// Rays of a class.
    fn class(
        &mut self,
        scene: &str,
        trees: &Trees,
        class: &ClassOfRays,
        pool: &ThreadPool,
    ) -> Result<Vec<Omission>, WrongAnswer> {
        let rays = &class.rays;
        let mut places = Places { closest: vec![None; rays.len()], any: vec![false; rays.len()] };
        let of = |method, tree| Contender {
            method,
            tree,
            tracing: Tracing::Single,
            culling: Culling::None,
            any: false,
            pool,
            hits: None,
        };
        let reference = || of(REFERENCE, &*trees.reference);
        let plain = || Contender { tracing: Tracing::Plain, ..reference() };
        let races = [
            // Who asks no more than whether there is a hit needs not the first, nor its values.
            (Contender { any: true, ..reference() }, vec![("values", reference())]),
            // Lanes that round as the processor likes, against the same bits on every processor; and both
            // faces, against front faces alone.
            (
                reference(),
                vec![
                    ("same-bits", plain()),
                    ("culling", Contender { culling: Culling::Back, ..reference() }),
                ],
            ),
            (
                of("watertight", &*trees.waived),
                vec![("robust-boxes", of("watertight", &*trees.promised))],
            ),
            (
                reference(),
                vec![
                    ("watertight", of("watertight", &*trees.watertight)),
                    ("exact", of("exact", &*trees.exact)),
                ],
            ),
        ];
        let mut found = Vec::new();
        for (without, with) in races {
            let subject =
                Subject { layer: Layer::Tracer, scene, of: class.name, method: without.method };
            let raced =
                in_turn(&subject, without, with, self.study.rounds, &mut self.random, |ray| {
                    ray.trace(rays, &mut places)
                })?;
            found.extend(raced.omissions);
        }
        Ok(found)
    }
}
