//! What tracing plainly promises: no box discards a true hit; and what it does beyond: what a method that rounds takes for
//! a hit beside a triangle is found as well, as far as sides of boxes are moved outwards.

mod common;

use common::tree_by;
use trisect_angle_sum::AngleSum;
use trisect_core::{Ray, Triangle};
use trisect_exact::{Exact, ExactInTrees};
use trisect_havel_herout::HavelHerout;
use trisect_keidy::Keidy;
use trisect_method::{Culling, Method};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_oracle::{Class, Oracle};
use trisect_tracer::{Builder, EveryTriangle, Tracing, Tree};
use trisect_watertight::Watertight;

/// Whether testing the triangle finds a hit, and whether tracing plainly does.
fn found<M: Method>(triangle: Triangle<f32>, ray: &Ray<f32>) -> (bool, bool) {
    let all = EveryTriangle::<M>::new(&[triangle]).expect("it takes all").inspect(ray).found;
    let mut plain = [None];
    let tree = tree_by::<M>(Builder::Spatial, &[triangle]);
    tree.closest(Tracing::Plain, Culling::None, &[*ray], &mut plain);
    assert!(plain[0].is_none() || plain[0] == all, "what is found is the same to the bit");
    assert_eq!(tree.inspect(ray).found, plain[0]);
    (all.is_some(), plain[0].is_some())
}

/// What some methods say of one ray.
fn said(triangle: Triangle<f32>, ray: &Ray<f32>) -> [(&'static str, (bool, bool)); 7] {
    [
        ("keidy", found::<Keidy>(triangle, ray)),
        ("havel-herout", found::<HavelHerout>(triangle, ray)),
        ("angle-sum", found::<AngleSum>(triangle, ray)),
        ("moller-trumbore", found::<MollerTrumbore>(triangle, ray)),
        ("watertight", found::<Watertight>(triangle, ray)),
        ("exact", found::<Exact>(triangle, ray)),
        ("exact, in trees", found::<ExactInTrees>(triangle, ray)),
    ]
}

/// A roof whose ridge is a side of its box, and rays along an axis that pass above it.
#[test]
fn a_hit_beside_the_box_is_found() {
    let roof = Triangle::<f32>::new([-1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]);
    // By a unit in the last place, which some methods take for a hit: tree or no tree.
    let near = Ray::<f32>::new([0.0, -5.0, 1.0_f32.next_up()], [0.0, 1.0, 0.0]);
    assert_eq!(Oracle::default().classify(&near, &roof), Class::Miss);
    for (method, (all, plain)) in said(roof, &near) {
        assert_eq!(all, plain, "{method}");
        assert_eq!(all, ["keidy", "havel-herout", "angle-sum"].contains(&method), "{method}");
    }
    // From afar they are off by more, and sides are moved by more.
    let roof = Triangle::<f32>::new([-10.0, 0.0, 0.9], [10.0, 0.1, 1.0], [-10.0, 0.1, 1.0]);
    let far = Ray::<f32>::new([0.0, -1e4, 1.00001], [0.0, 1.0, 0.0]);
    assert_eq!(Oracle::default().classify(&far, &roof), Class::Miss);
    for (method, found) in said(roof, &far) {
        let is_off = ["keidy", "havel-herout", "angle-sum"].contains(&method);
        assert_eq!(found, (is_off, is_off), "{method}");
    }
    // What is truly hit is found by all that find it without a tree, as most do.
    for z in [0.95, 1.0] {
        let ray = Ray::<f32>::new([0.0, -5.0, z], [0.0, 1.0, 0.0]);
        assert!(Oracle::default().classify(&ray, &roof).is_hit());
        for (method, (all, plain)) in said(roof, &ray) {
            assert_eq!(all, plain, "{method} {z}");
            assert!(all || method == "angle-sum", "{method} {z}");
        }
    }
}
