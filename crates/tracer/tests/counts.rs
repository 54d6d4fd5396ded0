//! What a ray costs, counted, and which triangles it may hit.

mod common;

use common::{brute_force, rays_of, traced, tree_by};
use trisect_core::{Float, Ray, Triangle, Vec3};
use trisect_exact::{Exact, ExactInTrees};
use trisect_method::{Culling, Method};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_oracle::Oracle;
use trisect_tracer::{Builder, Counted, EveryTriangle, Tracing, Tree};
use trisect_wald::Wald;
use trisect_watertight::Watertight;
use trisect_workloads::{Mesh, Stream, Stress};

#[test]
fn counting_changes_no_answer_and_a_tree_saves_tests() {
    fn check<M: Method>(mesh: &Mesh) {
        let rays = rays_of(mesh);
        let all = brute_force::<M>(&mesh.triangles, &rays, Culling::None);
        for builder in [Builder::Linear, Builder::Binned, Builder::Spatial] {
            let tree = tree_by::<M>(builder, &mesh.triangles);
            let counted: Vec<Counted> = rays.iter().map(|ray| tree.inspect(ray)).collect();
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
    let bunny = trisect_workloads::bunny();
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
    let (hit, miss) = (every.inspect(&ray(0.25)), every.inspect(&ray(9.0)));
    assert_eq!((hit.nodes, hit.triangles, hit.found.map(|hit| hit.triangle)), (0, 11, Some(10)));
    assert_eq!(miss, Counted { triangles: 11, ..Counted::default() });
    for count in [1, 8, 11] {
        let tree = tree_by::<MollerTrumbore>(Builder::Binned, &stack[..count]);
        let (hit, miss) = (tree.inspect(&ray(0.25)), tree.inspect(&ray(9.0)));
        assert_eq!(hit.found.map(|hit| hit.triangle as usize), Some(count - 1));
        assert_eq!((hit.nodes, miss), (1, Counted { nodes: 1, ..Counted::default() }));
        assert!(hit.triangles <= count, "{hit:?}");
    }
    let tree = tree_by::<MollerTrumbore>(Builder::Binned, &stack[..1]);
    assert_eq!(tree.inspect(&ray(0.25)).triangles, 1);
}

/// Counted, traced plainly and without a tree, the answer is one, whatever the numbers: infinite ends of intervals
/// and `t` beyond the largest number among them.
#[test]
fn counting_decides_as_tracing_does_whatever_the_numbers() {
    fn check<M: Method>(triangles: &[Triangle<f32>], ray: &Ray<f32>) -> bool {
        let tree = tree_by::<M>(Builder::Binned, triangles);
        let counted = tree.inspect(ray).found;
        let mut plain = [None];
        tree.closest(Tracing::Plain, Culling::None, &[*ray], &mut plain);
        assert_eq!(counted, plain[0], "{}: {ray:?} {triangles:?}", M::INFO.name);
        let is_finite = |found: trisect_tracer::TriangleHit| found.hit.t.is_finite();
        assert!(counted.is_none_or(is_finite), "{}: {ray:?} {triangles:?}", M::INFO.name);
        if M::INFO.claims.exact {
            let every =
                EveryTriangle::<M>::new(triangles).expect("it takes all").inspect(ray).found;
            assert_eq!(counted, every, "{ray:?} {triangles:?}");
            let truth = Oracle::default().closest(ray, triangles).map(|(_, truth)| truth.hit);
            let t = |hit: trisect_core::Hit<f32>| hit.t + 0.0;
            assert_eq!(counted.map(|found| t(found.hit)), truth.flatten().map(t), "{ray:?}");
        }
        counted.is_some()
    }
    let all = |triangles: &[Triangle<f32>], ray: &Ray<f32>| {
        [
            check::<MollerTrumbore>(triangles, ray),
            check::<Wald>(triangles, ray),
            check::<Watertight>(triangles, ray),
            check::<Exact>(triangles, ray),
            check::<ExactInTrees>(triangles, ray),
        ]
    };
    // Larger than the ray is long, by more than there are numbers for: along the plane, and onto it.
    for size in [1e18, 1e30, 1e-30] {
        for [x, y, z] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
            let turned = |v: [f32; 3]| Vec3::new(v[x], v[y], v[z]);
            let [a, b, c] = [[0.0; 3], [size, 0.0, 0.0], [0.0, 0.0, size]].map(turned);
            for small in [1e-30, 1e-40, f32::from_bits(1), 1e-10] {
                for last in [-0.0, 0.0, small] {
                    for o in [[2.0 * size, 0.0, size], [0.2 * size, -size, 0.2 * size]] {
                        let ray = Ray::<f32>::new(turned(o), turned([small, small, last]));
                        all(&[Triangle { a, b, c }], &ray);
                        all(&[Triangle { a, b, c }], &Ray { tmin: -ray.tmax, ..ray });
                    }
                }
            }
        }
    }
    let mut hits = [0; 5];
    for family in Stress::ALL {
        for level in family.levels::<f32>() {
            for (ray, triangle) in family.pairs::<f32>(3, level, 12) {
                for ray in [ray, Ray { tmin: f32::NEG_INFINITY, tmax: f32::INFINITY, ..ray }] {
                    let found = all(&[triangle], &ray);
                    hits.iter_mut().zip(found).for_each(|(hits, hit)| *hits += u32::from(hit));
                }
            }
        }
    }
    // Numbers of any exponent, aimed at what is there.
    let mut stream = Stream::new("counts", 1);
    let mut number = || f32::from_upper_bits(stream.bits());
    for _ in 0..3000 {
        let mut corner = || Vec3::new(number(), number(), number());
        let (a, b, c, o) = (corner(), corner(), corner(), corner());
        let target = a.scale(0.5) + b.scale(0.25) + c.scale(0.25);
        let along = number();
        let d = (target.scale(0.5) - o.scale(0.5)).scale(along);
        let found = all(&[Triangle { a, b, c }], &Ray::new(o, d));
        hits.iter_mut().zip(found).for_each(|(hits, hit)| *hits += u32::from(hit));
    }
    assert!(hits.iter().all(|&hits| hits > 100), "{hits:?}");
}

/// With the exact oracle in the leaves, the tree gives the truth of testing every triangle.
#[test]
fn no_true_hit_is_left_out_of_the_candidates() {
    let bunny = trisect_workloads::bunny();
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
