//! Every builder's tree answers as testing every triangle does, is bounded, and can be refitted.

mod common;

use common::{answers, rays_of, traced, tree_by};
use trisect_core::{Ray, Triangle, Vec3};
use trisect_method::{Culling, Method};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_tracer::{Builder, Bvh, Leaves, RefitError, Statistics, Tracing, Tree};
use trisect_wald::Wald;
use trisect_watertight::Watertight;
use trisect_workloads::{Mesh, Placement, Stream, Surface};

/// One by each builder.
fn trees<M: Method>(triangles: &[Triangle<f32>]) -> [Bvh<M>; 3] {
    Builder::ALL.map(|builder| tree_by(builder, triangles))
}

fn agree(name: &str, triangles: &[Triangle<f32>], rays: &[Ray<f32>]) {
    fn check<M: Method>(name: &str, triangles: &[Triangle<f32>], rays: &[Ray<f32>]) {
        answers(name, &trees::<M>(triangles), triangles, rays);
    }
    check::<MollerTrumbore>(name, triangles, rays);
    check::<Wald>(name, triangles, rays);
    check::<Watertight>(name, triangles, rays);
}

fn statistics(builder: Builder, triangles: &[Triangle<f32>]) -> Statistics {
    tree_by::<MollerTrumbore>(builder, triangles).statistics()
}

fn mesh(name: &str, triangles: Vec<Triangle<f32>>) -> Mesh {
    Mesh::from_triangles(name, triangles).expect("finite triangles")
}

/// Long thin triangles across one another, as beams in a hall: the worst for boxes, so space is split.
fn beams(count: usize) -> Mesh {
    let mut stream = Stream::new("beams", 1);
    let mut point = || {
        let Vec3 { x, y, z } = stream.cube();
        #[allow(clippy::cast_possible_truncation, reason = "rounds")]
        let point = Vec3::new(x as f32, y as f32, z as f32);
        point
    };
    let triangles = (0..count).map(|_| {
        let (a, b) = (point(), point());
        Triangle { a, b, c: b + point().scale(0.02) }
    });
    mesh("beams", triangles.collect())
}

/// Beams among small things: an interior.
fn hall() -> Mesh {
    let mut triangles = beams(150).triangles.to_vec();
    let mut stream = Stream::new("hall", 1);
    for _ in 0..4000 {
        let corner = |v: Vec3<f64>| {
            #[allow(clippy::cast_possible_truncation, reason = "rounds")]
            let corner = Vec3::new(v.x as f32, v.y as f32, v.z as f32);
            corner
        };
        let a = corner(stream.cube());
        let [b, c] = [0, 1].map(|_| a + corner(stream.cube()).scale(0.02));
        triangles.push(Triangle { a, b, c });
    }
    mesh("hall", triangles)
}

/// Moved and turned about, each triangle as a whole.
fn moved(triangles: &[Triangle<f32>], far: f32) -> Vec<Triangle<f32>> {
    let turn = |v: Vec3<f32>| {
        let bent = 0.3 * (v.x + 2.0 * v.y);
        Vec3::new(v.y + far, bent.cos() * v.x - bent.sin() * v.z, bent.sin() * v.x + v.z)
    };
    triangles
        .iter()
        .map(|&Triangle { a, b, c }| Triangle { a: turn(a), b: turn(b), c: turn(c) })
        .collect()
}

#[test]
fn every_builder_finds_what_testing_every_triangle_finds() {
    let bunny = trisect_workloads::bunny();
    agree("bunny", &bunny.triangles, &rays_of(&bunny));
    let beams = beams(3000);
    let facts = statistics(Builder::Spatial, &beams.triangles);
    assert!(facts.references > beams.triangles.len(), "space is split: {facts:?}");
    agree("beams", &beams.triangles, &rays_of(&beams));
}

/// Beside the edges of triangles that are cut into parts: what a method that rounds takes for a hit
/// there is found as well.
#[test]
fn rays_along_the_edges_of_divided_triangles_are_not_lost() {
    let beams = beams(1000);
    let mut stream = Stream::new("edges", 1);
    let mut rays = Vec::new();
    for triangle in beams.triangles.iter() {
        for (from, to) in [(triangle.a, triangle.b), (triangle.c, triangle.a)] {
            #[allow(clippy::cast_possible_truncation, reason = "rounds")]
            let share = stream.unit_f64() as f32;
            let aim = from + (to - from).scale(share);
            let o = Vec3::new(2.5, -3.0, 2.0);
            rays.push(Ray::<f32>::new(o, aim - o));
            let o = Vec3 { z: 4.0, ..aim };
            rays.push(Ray::<f32>::new(o, aim - o));
        }
    }
    agree("beams", &beams.triangles, &rays);
}

#[test]
fn closed_surfaces_anywhere_are_the_same_for_every_builder() {
    for surface in [Surface::sphere(3), Surface::ragged_sphere(1), Surface::fan(300)] {
        for (offset, scale) in [(0.0, 1.0), (0.0, 1e-12), (0.0, 1e12)] {
            let offset = Vec3::new(0.6, -0.48, 0.64).scale(offset);
            let triangles = surface.triangles::<f32>(&Placement { scale, offset });
            let rays = rays_of(&mesh(surface.name, triangles.clone()));
            agree(&format!("{} {offset:?} {scale}", surface.name), &triangles, &rays);
        }
        // Far away, where distances that Wald computes from the origin are of no use.
        for offset in [1e5, 1e18] {
            let offset = Vec3::new(0.6, -0.48, 0.64).scale(offset);
            let scale = if offset.x > 1e10 { 1e12 } else { 1.0 };
            let triangles = surface.triangles::<f32>(&Placement { scale, offset });
            let rays = rays_of(&mesh(surface.name, triangles.clone()));
            let name = format!("{} {offset:?}", surface.name);
            answers(&name, &trees::<MollerTrumbore>(&triangles), &triangles, &rays);
            answers(&name, &trees::<Watertight>(&triangles), &triangles, &rays);
        }
    }
}

#[test]
fn trees_are_bounded_whatever_the_mesh() {
    let unit = Triangle::<f32>::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let copies = vec![unit; 300_000];
    let chain = |ratio: f32, count: i32| -> Vec<Triangle<f32>> {
        let of_size = |size: f32| {
            Triangle::new([size, 0.0, 0.0], [1.1 * size, 0.0, 0.0], [size, 0.1 * size, 0.0])
        };
        (0..count).map(|k| of_size(ratio.powi(k))).filter(Triangle::can_be_hit).collect()
    };
    // Each within the next: the boxes of any two sides have the smaller one in common.
    let shells: Vec<Triangle<f32>> = (0..5000_u16)
        .map(|k| {
            let size = 1.01_f32.powi(i32::from(k) % 4000);
            Triangle::new([-size, -size, size], [size, -size, -size], [0.0, size, 0.0])
        })
        .collect();
    let ray = Ray::<f32>::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
    for builder in Builder::ALL {
        let facts = statistics(builder, &copies);
        assert!(facts.depth <= 10, "{facts:?}");
        assert!(facts.bytes < copies.len() * 50, "{facts:?}");
        assert_eq!(facts.references, copies.len(), "nothing is gained by splitting: {facts:?}");
        let tree = tree_by::<MollerTrumbore>(builder, &copies);
        let found = traced(&tree, Tracing::Single, Culling::None, &[ray])[0];
        assert_eq!(found.map(|found| found.triangle), Some(0));
        for chain in [chain(0.9, 800), chain(0.5, 120), chain(1.2, 400)] {
            let facts = statistics(builder, &chain);
            assert!(facts.depth <= 40, "{facts:?}");
            assert!(facts.references <= chain.len() + chain.len() / 2, "{facts:?}");
        }
        let facts = statistics(builder, &shells);
        assert!(facts.depth <= 40, "{facts:?}");
        assert!(facts.references <= shells.len() + shells.len() / 2, "{facts:?}");
    }
}

#[test]
fn splitting_space_pays_and_stays_within_its_room() {
    let scenes = [trisect_workloads::bunny(), hall(), beams(20_000)];
    for scene in &scenes {
        let cost = |builder| statistics(builder, &scene.triangles).cost;
        let [linear, binned, spatial] = Builder::ALL.map(cost);
        assert!(binned <= linear, "{}: {binned} {linear}", scene.name);
        assert!(spatial <= binned, "{}: {spatial} {binned}", scene.name);
        let facts = statistics(Builder::Spatial, &scene.triangles);
        let count = scene.triangles.len();
        assert!(facts.references <= count + count / 2, "{facts:?}");
    }
    let [_, binned, spatial] =
        Builder::ALL.map(|builder| statistics(builder, &scenes[1].triangles).cost);
    assert!(spatial < 0.8 * binned, "{spatial} {binned}");
    // Few triangles are not worth it.
    assert_eq!(statistics(Builder::Spatial, &beams(200).triangles).references, 200);
}

#[test]
fn a_refitted_tree_answers_as_a_new_one() {
    fn check<M: Method>(scene: &Mesh) {
        let moved = mesh("moved", moved(&scene.triangles, 1.5));
        let mut trees = trees::<M>(&scene.triangles);
        let before = trees.each_ref().map(Bvh::statistics);
        for tree in &mut trees {
            tree.refit(&moved.triangles).expect("as many as before");
        }
        answers("moved", &trees, &moved.triangles, &rays_of(&moved));
        for (tree, before) in trees.iter_mut().zip(before) {
            tree.refit(&scene.triangles).expect("as many as before");
            let after = tree.statistics();
            assert_eq!((before.nodes, before.blocks), (after.nodes, after.blocks));
            if before.builder != Builder::Spatial {
                assert_eq!(before.cost, after.cost, "boxes are the same again");
            }
        }
        answers("moved back", &trees, &scene.triangles, &rays_of(scene));
    }
    for scene in [trisect_workloads::bunny(), beams(1500)] {
        check::<MollerTrumbore>(&scene);
        check::<Wald>(&scene);
        check::<Watertight>(&scene);
    }
}

#[test]
fn triangles_may_vanish_and_come_back_but_not_appear() {
    let sphere = Surface::sphere(3).triangles::<f32>(&Placement::HERE);
    let line = Triangle { c: sphere[7].b, ..sphere[7] };
    let infinite = Triangle { a: Vec3::new(f32::INFINITY, 0.0, 0.0), ..sphere[9] };
    let mut holes = sphere.clone();
    (holes[7], holes[9]) = (line, infinite);
    let rays = rays_of(&mesh("sphere", sphere.clone()));
    let mut trees = trees::<Wald>(&sphere);
    let mut refit = |name: &str, triangles: &[Triangle<f32>]| {
        for tree in &mut trees {
            tree.refit(triangles).expect("triangles may vanish and come back");
        }
        answers(name, &trees, triangles, &rays);
    };
    refit("holes", &holes);
    refit("sphere", &sphere);
    // All of them, and the tree is empty for a while.
    refit("nothing", &vec![line; sphere.len()]);
    refit("sphere", &sphere);

    let mut trees = self::trees::<Wald>(&holes);
    for tree in &mut trees {
        assert_eq!(tree.refit(&sphere), Err(RefitError::Appeared { triangle: 7 }));
        let given = sphere.len() - 1;
        let error = tree.refit(&holes[1..]);
        assert_eq!(error, Err(RefitError::Count { built: sphere.len(), given }));
    }
    answers("as before", &trees, &holes, &rays);
}

#[test]
fn builders_are_found_by_their_names() {
    for builder in Builder::ALL {
        assert_eq!(builder.name().parse(), Ok(builder));
    }
    let unknown = "best".parse::<Builder>().expect_err("there is none").to_string();
    assert!(Builder::ALL.iter().all(|builder| unknown.contains(builder.name())), "{unknown}");
}

#[test]
fn leaves_of_any_size_give_the_same_answers() {
    let scene = hall();
    let trees = Leaves::ALL.map(|leaves| {
        Bvh::<MollerTrumbore>::build_with(&scene.triangles, Builder::Spatial, leaves)
            .expect("it takes all meshes")
    });
    let nodes = trees.each_ref().map(|tree| tree.statistics().nodes);
    assert!(nodes[0] > nodes[1] && nodes[1] > nodes[2], "{nodes:?}");
    answers("leaves", &trees, &scene.triangles, &rays_of(&scene));
    // Of a method that tells triangles apart, whose leaves may take two blocks more.
    let mut trees = Leaves::ALL.map(|leaves| {
        Bvh::<Wald>::build_with(&scene.triangles, Builder::Spatial, leaves)
            .expect("it takes all meshes")
    });
    answers("leaves", &trees, &scene.triangles, &rays_of(&scene));
    for tree in &mut trees {
        tree.refit(&scene.triangles).expect("as many as before");
    }
    answers("refitted leaves", &trees, &scene.triangles, &rays_of(&scene));
}
