//! A tree finds for every method what testing every triangle finds.

use trisect_catalog::{Builder, INLINE_IN_TREES, Leaves, Tracing, entries};
use trisect_core::Hit;
use trisect_mesh::{Mesh, MeshFormat};
use trisect_method::{Culling, Output};

fn teapot() -> Mesh {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/meshes/teapot.ply");
    let bytes = std::fs::read(file).expect("it is part of the project");
    Mesh::from_bytes("teapot", MeshFormat::Ply, &bytes).expect("sound")
}

/// In plain arithmetic, to the bit, whatever is culled. A method without weights hands out others,
/// which mean nothing.
#[test]
fn every_method_in_a_tree_finds_what_it_finds_without() {
    let mesh = teapot();
    let mut rays = trisect_workloads::primary(&mesh, 16, 16).rays;
    rays.extend(trisect_workloads::random_through_box(3, &mesh, 300).rays);
    let (mut met, mut inline) = (0, 0);
    for entry in entries() {
        let kernels = &entry.f32;
        let builds = || [Some(entry.erased_tree), entry.inline_tree].into_iter().flatten();
        let Ok(scene) = (kernels.prepare)(&mesh.triangles, &rays) else {
            for build in builds() {
                let tree = build(&mesh.triangles, Builder::Binned, Leaves::default());
                assert!(tree.is_err(), "{}", entry.info.name);
            }
            continue;
        };
        let finder = kernels.plain_finder(None, None).expect("one is compiled everywhere");
        let trees: Vec<_> = builds()
            .flat_map(|build| Builder::ALL.map(|builder| (builder, build)))
            .map(|(builder, build)| {
                let tree = build(&mesh.triangles, builder, Leaves::default());
                (tree.expect("the method takes the mesh"), builder)
            })
            .collect();
        inline += usize::from(entry.inline_tree.is_some());
        for culling in [Culling::None, Culling::Back, Culling::Front] {
            let all = finder.closest(&scene, culling, rays.len());
            for (tree, builder) in &trees {
                let mut found = vec![None; rays.len()];
                tree.closest(Tracing::Plain, culling, &rays, &mut found);
                let mut any = vec![false; rays.len()];
                tree.any(Tracing::Plain, culling, &rays, &mut any);
                for ((all, found), any) in all.iter().zip(&found).zip(any) {
                    let weighs = entry.info.gives(Output::Barycentrics);
                    let given = |triangle: u32, hit: Hit<f64>| {
                        (triangle, hit.t, weighs.then_some([hit.beta, hit.gamma]))
                    };
                    let all = all.map(|(triangle, hit)| given(triangle, hit));
                    let found = found.map(|found| {
                        let [t, beta, gamma] =
                            [found.hit.t, found.hit.beta, found.hit.gamma].map(f64::from);
                        given(found.triangle, Hit { t, beta, gamma })
                    });
                    assert_eq!(found, all, "{}, {builder}, {culling:?}", entry.info.name);
                    assert_eq!(any, all.is_some(), "{}, {builder}, {culling:?}", entry.info.name);
                    met += usize::from(any);
                }
            }
        }
    }
    assert!(met > 1000, "{met}");
    assert_eq!(inline, INLINE_IN_TREES.len(), "each of these names is a method's");
}
