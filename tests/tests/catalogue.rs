//! What holds for every compiled kernel of every method.

use std::ops::ControlFlow;
use std::path::Path;

use trisect_catalog::{Finder, Kernels, Scene, entries};
use trisect_core::{Precision, Ray, Triangle};
use trisect_method::{Culling, Forms, Output};
use trisect_workloads::{Mesh, Share, Workload};

/// Every hit of a finder: ray, triangle, and the bits of `t`, `beta`, `gamma`.
type Answers = Vec<(usize, u32, [u64; 3])>;

fn answers(finder: &Finder, scene: &Scene) -> Answers {
    let mut answers = Vec::new();
    finder.find(scene, Culling::None, &mut |ray, triangle, hit| {
        answers.push((ray, triangle, [hit.t, hit.beta, hit.gamma].map(f64::to_bits)));
        ControlFlow::Continue(())
    });
    answers.sort_unstable();
    answers
}

fn workloads() -> Vec<Workload> {
    let teapot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/meshes/teapot.ply");
    let teapot = Mesh::load(teapot).expect("the mesh that the project ships is sound");
    vec![
        trisect_workloads::random(7, 100, 1_003),
        trisect_workloads::primary(&teapot, 12, 12),
        trisect_workloads::random_through_box(7, &teapot, 50),
        trisect_workloads::hit_rate(7, 30, 50, 333),
        trisect_workloads::hit_rate(7, 100, 33, 77),
        trisect_workloads::random_sharing(7, Share::Origin, 100, 303),
        trisect_workloads::random_sharing(7, Share::Direction, 100, 303),
    ]
}

/// Something to hold for the kernels of one method and precision.
trait Property {
    fn check<E: Precision>(
        forms: Forms,
        kernels: &Kernels<E>,
        triangles: &[Triangle<E>],
        rays: &[Ray<E>],
        place: &str,
    );
}

fn for_all<P: Property>() {
    assert!(entries().len() >= 25, "the catalogue lost methods");
    for workload in workloads() {
        let Workload { name, rays, triangles, .. } = workload;
        let rays64: Vec<Ray<f64>> = rays.iter().map(|&ray| ray.into()).collect();
        let triangles64: Vec<Triangle<f64>> = triangles.iter().map(|&t| t.into()).collect();
        for entry in entries() {
            let place = format!("{} on {name}", entry.info.name);
            P::check(entry.info.forms, &entry.f32, &triangles, &rays, &place);
            P::check(entry.info.forms, &entry.f64, &triangles64, &rays64, &place);
        }
    }
}

struct TimedKernelsCountTheFindersHits;

impl Property for TimedKernelsCountTheFindersHits {
    fn check<E: Precision>(
        _: Forms,
        kernels: &Kernels<E>,
        triangles: &[Triangle<E>],
        rays: &[Ray<E>],
        place: &str,
    ) {
        let Ok(scene) = (kernels.prepare)(triangles, rays) else { return };
        for finder in kernels.finders.iter().chain(&kernels.deciders) {
            if !finder.variant.is_available() {
                continue;
            }
            let expected = answers(finder, &scene).len() as u64;
            let timed = kernels.answered_by(finder).filter(|kernel| {
                kernel.variant.is_available() && kernel.variant.arrangement.serves(scene.common())
            });
            for kernel in timed {
                let tally = kernel.run(&scene);
                assert_eq!(tally.hits, expected, "{place}, {:?}", kernel.variant);
                assert_eq!(
                    tally.sum == 0.0,
                    kernel.variant.needs == Output::Occlusion,
                    "{place}: {tally:?}"
                );
            }
        }
    }
}

#[test]
fn timed_kernels_count_the_hits_of_their_finders() {
    for_all::<TimedKernelsCountTheFindersHits>();
}

#[test]
fn every_timed_variant_has_a_finder() {
    for entry in entries() {
        // Which panics where there is none.
        let single = entry.f32.timed.iter().map(|kernel| &entry.f32.finder_of(kernel).variant);
        let double = entry.f64.timed.iter().map(|kernel| &entry.f64.finder_of(kernel).variant);
        let timed = entry.f32.timed.iter().chain(&entry.f64.timed);
        for (kernel, variant) in timed.zip(single.chain(double)) {
            assert!(kernel.variant.rounds_like(variant), "{:?}", kernel.variant);
        }
    }
}

#[test]
fn names_are_unique_and_can_be_typed() {
    let names: Vec<&str> = entries().iter().map(|entry| entry.info.name).collect();
    for (i, name) in names.iter().enumerate() {
        assert!(!names[..i].contains(name), "two methods are called {name}");
        assert!(
            name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-'),
            "{name}"
        );
        assert_ne!(*name, "oracle", "the name that stands for the exact truth");
    }
}
