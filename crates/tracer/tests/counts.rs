//! What a ray costs, counted, and which triangles it may hit.

mod common;

use common::{brute_force, rays_of, traced, tree_by};
use trisect_core::{Culling, Method, Ray, Triangle};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_oracle::Oracle;
use trisect_tracer::{Builder, Counted, EveryTriangle, Tracing, Tree};
use trisect_wald::Wald;
use trisect_watertight::Watertight;
use trisect_workloads::Mesh;

#[test]
fn counting_changes_no_answer_and_a_tree_saves_tests() {
    fn check<M: Method>(mesh: &Mesh) {
        let rays = rays_of(mesh);
        let all = brute_force::<M>(&mesh.triangles, &rays, Culling::None);
        for builder in [Builder::Linear, Builder::Binned, Builder::Spatial] {
            let tree = tree_by::<M>(builder, &mesh.triangles);
            let counted: Vec<Counted> = rays.iter().map(|ray| tree.count(ray)).collect();
            let found: Vec<_> = counted.iter().map(|counted| counted.found).collect();
            assert_eq!(found, all, "{builder}");
            assert_eq!(found, traced(&tree, Tracing::Plain, Culling::None, &rays), "{builder}");
            let mut tests = 0;
            for Counted { found, nodes, triangles } in counted {
                assert!(nodes > 0 && (found.is_none() || triangles > 0));
                tests += triangles;
            }
            let every = rays.len() * mesh.triangles.len();
            assert!(tests > rays.len() && tests * 100 < every, "{builder}: {tests} of {every}");
        }
    }
    let bunny = Mesh::bunny();
    check::<MollerTrumbore>(&bunny);
    check::<Wald>(&bunny);
    check::<Watertight>(&bunny);
}

/// Eleven triangles in two blocks of a leaf, which are one and a half: what is repeated does not count.
#[test]
fn counts_are_those_counted_by_hand() {
    let stack: Vec<Triangle<f32>> = (0..11)
        .map(|i| {
            let z = i as f32 / 1024.0;
            Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z])
        })
        .collect();
    let ray = |x: f32| Ray::<f32>::new([x, 0.25, 1.0], [0.0, 0.0, -1.0]);
    let every = EveryTriangle::<MollerTrumbore>::new(&stack).expect("it takes all");
    let (hit, miss) = (every.count(&ray(0.25)), every.count(&ray(9.0)));
    assert_eq!((hit.nodes, hit.triangles, hit.found.map(|hit| hit.triangle)), (0, 11, Some(10)));
    assert_eq!(miss, Counted { triangles: 11, ..Counted::default() });
    for count in [1, 8, 11] {
        let tree = tree_by::<MollerTrumbore>(Builder::Binned, &stack[..count]);
        let (hit, miss) = (tree.count(&ray(0.25)), tree.count(&ray(9.0)));
        assert_eq!(hit.found.map(|hit| hit.triangle as usize), Some(count - 1));
        assert_eq!((hit.nodes, miss), (1, Counted { nodes: 1, ..Counted::default() }));
        assert!(hit.triangles <= count, "{hit:?}");
    }
    let tree = tree_by::<MollerTrumbore>(Builder::Binned, &stack[..1]);
    assert_eq!(tree.count(&ray(0.25)).triangles, 1);
}

/// With the exact oracle in the leaves, the tree gives the truth of testing every triangle.
#[test]
fn no_true_hit_is_left_out_of_the_candidates() {
    let bunny = Mesh::bunny();
    let tree = tree_by::<MollerTrumbore>(Builder::Spatial, &bunny.triangles);
    let every = EveryTriangle::<MollerTrumbore>::new(&bunny.triangles).expect("it takes all");
    let mut oracle = Oracle::default();
    let mut hits = 0;
    for ray in rays_of(&bunny).iter().step_by(5) {
        let truth = oracle.closest(ray, &bunny.triangles).map(|(_, answer)| answer.hit);
        let mut visits = [0_usize; 2];
        let found = [&tree as &dyn Tree, &every].map(|tree| {
            let mut best = None;
            let mut end = ray.tmax;
            visits.rotate_left(1);
            tree.candidates(ray, &mut |number| {
                visits[1] += 1;
                if let Some(hit) = oracle.intersect(ray, &bunny.triangles[number as usize]).hit
                    && best.is_none_or(|best: trisect_core::Hit<f32>| hit.t < best.t)
                {
                    best = Some(hit);
                    end = hit.t;
                }
                end
            });
            best.map(|hit| hit.t)
        });
        let t = truth.flatten().map(|hit| hit.t);
        assert_eq!(found, [t, t], "{ray:?}");
        assert!(visits[0] < bunny.triangles.len() / 20 && visits[1] == bunny.triangles.len());
        hits += usize::from(t.is_some());
    }
    assert!(hits > 50, "{hits}");
}
