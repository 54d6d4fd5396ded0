//! Surfaces are what they claim to be.

use std::collections::BTreeMap;

use trisect_core::{Scalar as _, Triangle, Vec3};
use trisect_workloads::{Aim, Placement, Surface};

fn closed() -> Vec<Surface> {
    vec![Surface::sphere(2), Surface::ragged_sphere(1), Surface::cube(1), Surface::cube(5)]
}

fn open() -> Vec<Surface> {
    vec![Surface::square(12), Surface::split_square(1, 100), Surface::fan(7), Surface::fan(64)]
}

#[test]
fn closed_surfaces_have_two_triangles_at_each_edge_and_enclose_their_inside() {
    for surface in closed() {
        let edges = surface.features(Aim::Edges);
        assert!(edges.iter().all(|edge| edge.faces.len() == 2), "{}", surface.name);
        // Euler: corners − edges + faces = 2.
        let corners = surface.features(Aim::Vertices).len();
        assert_eq!(corners, surface.corners.len(), "{}", surface.name);
        assert_eq!(corners + surface.faces.len(), edges.len() + 2, "{}", surface.name);
        // Six times the volume seen from each corner of the cube of inner points, sign by sign.
        for triangle in surface.triangles::<f64>(&Placement::HERE) {
            let Triangle { a, b, c } = triangle;
            let n = triangle.normal();
            let heights: Vec<f64> = (0..8)
                .map(|k| {
                    let side = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
                    let p = Vec3::new(side(0), side(1), side(2)).scale(surface.inside);
                    n.dot(p - a)
                })
                .collect();
            let one_side = heights.iter().all(|&h| h > 0.0) || heights.iter().all(|&h| h < 0.0);
            assert!(
                one_side || surface.name == "ragged-sphere",
                "{}: {a:?} {b:?} {c:?}",
                surface.name
            );
        }
    }
}

#[test]
fn no_surface_has_a_degenerate_triangle_or_an_edge_of_three() {
    for surface in closed().into_iter().chain(open()) {
        for triangle in surface.triangles::<f32>(&Placement::HERE) {
            assert!(!triangle.is_degenerate(), "{}", surface.name);
        }
        assert!(surface.features(Aim::Edges).iter().all(|edge| edge.faces.len() <= 2));
    }
}

#[test]
fn flat_surfaces_cover_their_area_once() {
    for (surface, area) in [
        (Surface::square(12), 4.0),
        (Surface::split_square(3, 500), 4.0),
        (Surface::fan(4), 2.0),
        (Surface::fan(1024), std::f64::consts::PI),
    ] {
        let twice: f64 =
            surface.triangles::<f64>(&Placement::HERE).iter().map(|t| t.normal().z.abs()).sum();
        assert!((twice / 2.0 - area).abs() < 1e-4, "{}: {}", surface.name, twice / 2.0);
    }
}

#[test]
fn rays_start_inside_and_are_aimed_at_their_feature() {
    let far = Placement { scale: 0.5, offset: Vec3::new(1000.0, -300.0, 20.0) };
    let surface = Surface::sphere(1);
    for placement in [Placement::HERE, far] {
        for aim in [Aim::Edges, Aim::Vertices] {
            let mut lengths = BTreeMap::new();
            for feature in surface.features(aim) {
                let [p, q] = feature
                    .ends
                    .map(|end| surface.corners[end].mul_add(placement.scale, placement.offset));
                for ray in surface.aimed::<f32>(&feature, &placement, 1, 8) {
                    let o = ray.o.map(f64::from) - placement.offset;
                    let reach = surface.inside * placement.scale + 1e-4;
                    assert!(o.map(f64::abs).to_array().iter().all(|&x| x <= reach));
                    // The distance of the end of the ray from the segment.
                    let end = ray.at(1.0).map(f64::from);
                    let (along, from) = (q - p, end - p);
                    let t =
                        if aim == Aim::Edges { from.dot(along) / along.dot(along) } else { 0.0 };
                    let off = from - along.scale(t.to_f64());
                    assert!(off.dot(off).sqrt() < 2e-4, "{off:?}");
                    *lengths.entry((t * 4.0).floor().to_bits()).or_insert(0) += 1;
                }
            }
            assert_eq!(lengths.len(), if aim == Aim::Edges { 4 } else { 1 });
        }
    }
}
