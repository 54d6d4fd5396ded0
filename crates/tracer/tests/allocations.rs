//! Queries of one ray or point allocate nothing, once the buffer of their caller has room.

use allocation_counter::measure;
use trisect_core::{Ray, Vec3};
use trisect_exact::ExactInTrees;
use trisect_method::{Culling, Method};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_tracer::{Builder, Crossings, ErasedBvh, Tracing, Tree as _, Verdict};
use trisect_workloads::{Mesh, random_through_box};

fn check<M: Method>(mesh: &Mesh, rays: &[Ray<f32>]) {
    let tree = ErasedBvh::build::<M>(&mesh.triangles, Builder::Spatial).expect("it takes all");
    let (culling, mut hits, mut sum) = (Culling::None, vec![], 0);
    for tracing in [Tracing::Single, Tracing::Plain] {
        for crossings in [Crossings::Every, Crossings::Owned] {
            let mut all = || {
                for ray in rays {
                    tree.all(tracing, culling, crossings, ray, &mut hits);
                    sum += hits.len();
                    sum += tree.count(tracing, culling, crossings, ray) as usize;
                    let first = tree.filtered(tracing, culling, ray, &mut |_| Verdict::Accept);
                    sum += usize::from(first.is_some());
                    sum += usize::from(tree.contains(ray.o).is_ok());
                }
            };
            // The buffers grow.
            all();
            let counted = measure(all);
            assert_eq!(counted.count_total, 0, "{}, {tracing:?}, {crossings:?}", M::INFO.name);
        }
    }
    assert!(sum > rays.len(), "{sum}");
}

#[test]
fn a_query_of_one_ray_allocates_nothing() {
    let bunny = trisect_workloads::bunny();
    let mut rays = random_through_box(1, &bunny, 300).rays;
    let corner = bunny.triangles[0].a;
    rays.push(Ray::<f32>::new(corner, Vec3::new(0.0, 0.0, 1.0)));
    check::<ExactInTrees>(&bunny, &rays);
    check::<MollerTrumbore>(&bunny, &rays);
    assert_eq!(measure(|| drop(std::hint::black_box(Box::new(1)))).count_total, 1);
}
