//! Times every method and variant of the catalogue that this processor can run, on random
//! triangles and on the bunny.
//!
//! Hundreds of variants share a few minutes, so each has ten short samples: enough to tell
//! variants apart that differ by a tenth. A word after `--` selects by name and
//! `--measurement-time` gives what is selected more time:
//! `cargo bench -- 'random/wald/f32x8' --measurement-time 2`. For ratios that must be trusted to a
//! hundredth take the records of `trisect measure`, which interleaves what it compares.
#![allow(missing_docs, reason = "criterion's macros make public items without")]

use std::cell::OnceCell;
use std::ops::ControlFlow;
use std::time::Duration;

use criterion::{
    BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
};
use trisect_catalog::{Finder, Kernel, Kernels, Scene, entries};
use trisect_core::{Precision, Ray, Triangle};
use trisect_kernel_benches::{kernel_name, workloads};
use trisect_kernels::Common;
use trisect_method::Culling;

fn methods(criterion: &mut Criterion) {
    for workload in workloads() {
        let rays64: Vec<Ray<f64>> = workload.rays.iter().map(|&ray| ray.into()).collect();
        let triangles64: Vec<Triangle<f64>> =
            workload.triangles.iter().map(|&triangle| triangle.into()).collect();
        for entry in entries() {
            let mut group = Group {
                criterion,
                name: format!("{}/{}", workload.name, entry.info.name),
                tests: (workload.rays.len() * workload.triangles.len()) as u64,
            };
            group.bench(&entry.f32, &workload.triangles, &workload.rays);
            group.bench(&entry.f64, &triangles64, &rays64);
        }
    }
}

/// One method on one workload.
struct Group<'a> {
    criterion: &'a mut Criterion,
    name: String,
    tests: u64,
}

impl Group<'_> {
    fn bench<E: Precision>(
        &mut self,
        kernels: &Kernels<E>,
        triangles: &[Triangle<E>],
        rays: &[Ray<E>],
    ) {
        let mut group = self.criterion.benchmark_group(&self.name);
        group.throughput(Throughput::Elements(self.tests)).sampling_mode(SamplingMode::Flat);
        // Made when the first kernel that is not filtered out asks.
        let scene = OnceCell::new();
        let finders = || kernels.finders.iter().chain(&kernels.deciders);
        let hits: Vec<OnceCell<u64>> = finders().map(|_| OnceCell::new()).collect();
        let common = Common::of(rays);
        let serves = |kernel: &&Kernel| {
            kernel.variant.is_available() && kernel.variant.arrangement.serves(common)
        };
        for kernel in kernels.timed.iter().filter(serves) {
            group.bench_function(BenchmarkId::from_parameter(kernel_name(kernel)), |bencher| {
                let Some(scene) =
                    scene.get_or_init(|| (kernels.prepare)(triangles, rays).ok()).as_ref()
                else {
                    eprintln!("{}: cannot take these triangles", self.name);
                    return;
                };
                let finder = kernels.finder_of(kernel);
                let at = finders().position(|other| std::ptr::eq(other, finder)).unwrap_or(0);
                let expected = *hits[at].get_or_init(|| count_hits(finder, scene));
                let tally = kernel.run(scene);
                assert_eq!(tally.hits, expected, "{}: wrong hits", kernel_name(kernel));
                assert!(tally.sum.is_finite(), "{}: wrong sum", kernel_name(kernel));
                bencher.iter(|| kernel.run(scene));
            });
        }
        group.finish();
    }
}

fn count_hits(finder: &Finder, scene: &Scene) -> u64 {
    let mut hits = 0;
    finder.find(scene, Culling::None, &mut |_, _, _| {
        hits += 1;
        ControlFlow::Continue(())
    });
    hits
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(20))
        .measurement_time(Duration::from_millis(50))
        .nresamples(1_000);
    targets = methods
}
criterion_main!(benches);
