//! A ray that is asked about alone allocates nothing.

use trisect::{Culling, Precision, Ray, Scene, Triangle, Verdict};
use trisect_workloads::{bunny, random_through_box};

#[test]
fn single_rays_allocate_nothing() {
    // Without lanes that fuse, rays take the way of batches.
    if trisect_tracer::fast_lanes().0 < trisect_core::InstructionSet::Avx2 {
        println!("skipped: this processor has no fast lanes");
        return;
    }
    let bunny = bunny();
    let rays = random_through_box(1, &bunny, 1000).rays;
    check(&bunny.triangles, &rays);
    let triangles: Vec<_> = bunny.triangles.iter().map(|&triangle| triangle.into()).collect();
    let rays: Vec<_> = rays.into_iter().map(Ray::from).collect();
    check::<f64>(&triangles, &rays);
    // The count counts.
    assert_eq!(
        allocation_counter::measure(|| drop(std::hint::black_box(Box::new(1)))).count_total,
        1
    );
}

fn check<P: Precision>(triangles: &[Triangle<P>], rays: &[Ray<P>]) {
    for options in
        [Scene::options(), Scene::options().fast(), Scene::options().watertight().moving()]
    {
        let scene = options.from_triangles(triangles).expect("it takes all");
        for culling in [Culling::None, Culling::Back, Culling::Front] {
            let view = scene.seen(culling);
            let mut all = vec![];
            let mut ask = || {
                let mut hits = 0;
                for ray in rays {
                    let hit = view.first(ray);
                    assert_eq!(hit.is_some(), view.any(ray));
                    hits += usize::from(hit.is_some());
                    view.all(ray, &mut all);
                    assert_eq!(view.count(ray) as usize, all.len());
                    assert_eq!(view.filtered(ray, |_| Verdict::Accept).is_some(), hit.is_some());
                }
                hits
            };
            // The first time makes room for what is gathered.
            let mut hits = ask();
            let counted = allocation_counter::measure(|| hits += ask());
            assert_eq!(counted.count_total, 0, "{culling:?}");
            assert!(hits > 100);
        }
    }
}
