//! Polygons: the triangles fill them, face their way, and have all their corners.
#![allow(missing_docs, reason = "tests")]

use std::f64::consts::TAU;
use std::fmt::Write as _;

use proptest::prelude::*;
use trisect_core::{Triangle, Vec3};
use trisect_mesh::{Mesh, MeshFormat};

type Point = [f64; 3];

/// The mesh of one polygon.
fn mesh(corners: &[Point]) -> Mesh {
    let mut obj = String::new();
    for [x, y, z] in corners {
        writeln!(obj, "v {x:?} {y:?} {z:?}").expect("text");
    }
    obj += "f";
    for number in 1..=corners.len() {
        write!(obj, " {number}").expect("text");
    }
    Mesh::from_bytes("polygon", MeshFormat::Obj, obj.as_bytes()).expect("a polygon")
}

fn triangles(corners: &[Point]) -> Vec<Triangle<f64>> {
    let mesh = mesh(corners);
    assert!(mesh.notes.is_empty(), "{corners:?}: {:?}", mesh.notes);
    mesh.triangles_f64().to_vec()
}

/// Twice the area times the normal.
fn normal(triangle: &Triangle<f64>) -> Vec3<f64> {
    (triangle.b - triangle.a).cross(triangle.c - triangle.a)
}

/// The same of a polygon (Newell 1972).
fn newell(corners: &[Point]) -> Vec3<f64> {
    let origin = Vec3::from(corners[0]);
    let pairs = corners
        .windows(2)
        .map(|pair| (Vec3::from(pair[0]) - origin).cross(Vec3::from(pair[1]) - origin));
    pairs.fold(Vec3::from([0.0; 3]), |sum, part| sum + part)
}

/// A plane figure in a plane of space.
fn placed(outline: &[[f64; 2]], plane: usize) -> Vec<Point> {
    let place = |&[x, y]: &[f64; 2]| match plane {
        0 => [x, y, 0.25],
        1 => [0.25, x, y],
        2 => [y, 0.25, x],
        3 => [y, x, 7.0],
        4 => [x, y, x + y],
        _ => [0.6 * x - 0.64 * y, 0.8 * x + 0.48 * y, 0.6 * y - 3.0],
    };
    outline.iter().map(place).collect()
}

/// The triangles have the polygon's area, and none looks the other way: together they are the polygon.
fn check(corners: &[Point], count: usize) -> Result<(), TestCaseError> {
    let triangles = triangles(corners);
    prop_assert_eq!(triangles.len(), count);
    let whole = newell(corners);
    let size = whole.dot(whole).sqrt();
    let mut sum = 0.0;
    for triangle in &triangles {
        let part = normal(triangle).dot(whole) / size;
        prop_assert!(part > -1e-9 * size, "{part} of {size}");
        sum += part.abs();
    }
    prop_assert!((sum - size).abs() < 1e-9 * size, "{sum} of {size}");
    Ok(())
}

proptest! {
    #[test]
    fn stars_are_filled(
        radii in prop::collection::vec(0.1_f64..10.0, 3..60),
        plane in 0_usize..6,
        start in 0.0..TAU,
    ) {
        // No two neighbours are half a turn apart.
        prop_assume!(radii.len() > 2);
        let step = TAU / radii.len() as f64;
        let at = |(i, r): (usize, &f64)| {
            let angle = start + step * i as f64;
            [r * angle.cos(), r * angle.sin()]
        };
        let outline: Vec<[f64; 2]> = radii.iter().enumerate().map(at).collect();
        check(&placed(&outline, plane), radii.len() - 2)?;
    }

    /// Rows of teeth of any height, whose feet are on one line: many corners are in the middle of edges.
    #[test]
    fn combs_are_filled(
        teeth in prop::collection::vec(1_i32..50, 1..40),
        plane in 0_usize..5,
        back in any::<bool>(),
    ) {
        let mut outline = Vec::new();
        for (i, &height) in teeth.iter().enumerate() {
            let x = 2.0 * i as f64;
            outline.extend([[x, f64::from(height)], [x + 1.0, f64::from(height)], [x + 1.0, 0.0], [x + 2.0, 0.0]]);
        }
        outline.extend((0..=2 * teeth.len()).rev().map(|x| [x as f64, -1.0]));
        if back {
            outline.reverse();
        }
        let count = outline.len() - 2;
        let corners = placed(&outline, plane);
        check(&corners, count)?;
        // A corner in the middle of an edge is one of the triangles' corners: the mesh has no crack there.
        prop_assert!(triangles(&corners).iter().all(|triangle| normal(triangle).dot(normal(triangle)) > 0.0));
    }

    /// Corners on a small grid repeat, cross, and lie on each other's edges in every way.
    #[test]
    fn any_corners_give_triangles_between_them(
        grid in prop::collection::vec((0_i8..4, 0_i8..4, 0_i8..2), 4..14),
    ) {
        let corners: Vec<Point> = grid.iter().map(|&(x, y, z)| [x, y, z].map(f64::from)).collect();
        let apart: Vec<Point> = corners.iter().map(|[x, y, z]| [x + 9.0, *y, *z]).collect();
        let mut obj = String::new();
        for [x, y, z] in corners.iter().chain(&apart) {
            writeln!(obj, "v {x} {y} {z}").expect("text");
        }
        for from in [1, 1 + corners.len()] {
            obj += "f";
            for number in from..from + corners.len() {
                write!(obj, " {number}").expect("text");
            }
            obj += "\n";
        }
        // A triangle beside them, as a mesh is never empty.
        obj += "f 1 1 1";
        let mesh = Mesh::from_bytes("any", MeshFormat::Obj, obj.as_bytes()).expect("a mesh");
        let triangles = mesh.triangles_f64();
        let count = (triangles.len() - 1) / 2;
        prop_assert!(count < 2 * corners.len());
        for (here, there) in triangles[..count].iter().zip(&triangles[count..]) {
            let here = here.corners().map(Vec3::to_array);
            prop_assert!(here.iter().all(|corner| corners.contains(corner)));
            // A polygon that is moved is split alike.
            let there = there.corners().map(Vec3::to_array);
            prop_assert_eq!(here.map(|[x, y, z]| [x + 9.0, y, z]), there);
        }
    }

    /// Where a figure begins, and how large it is, changes nothing.
    #[test]
    fn scaling_by_a_power_of_two_scales_the_triangles(
        radii in prop::collection::vec(1_u8.., 3..20),
        power in -100_i32..=100,
    ) {
        let step = TAU / radii.len() as f64;
        let at = |(i, &r): (usize, &u8)| {
            let angle = step * i as f64;
            [f64::from(r) * angle.cos(), f64::from(r) * angle.sin()]
        };
        let outline: Vec<[f64; 2]> = radii.iter().enumerate().map(at).collect();
        let corners = placed(&outline, 5);
        let scale = 2.0_f64.powi(power);
        let scaled: Vec<Point> = corners.iter().map(|p| p.map(|x| x * scale)).collect();
        let expected: Vec<_> = triangles(&corners).iter().map(|t| t.corners().map(|p| p.scale(scale))).collect();
        let found: Vec<_> = triangles(&scaled).iter().map(|t| t.corners()).collect();
        prop_assert_eq!(found, expected);
    }
}

fn flat(outline: &[[i32; 2]]) -> Vec<Point> {
    outline.iter().map(|&[x, y]| [f64::from(x), f64::from(y), 0.0]).collect()
}

/// The triangles by the places of their corners.
fn places(outline: &[[i32; 2]]) -> Vec<[usize; 3]> {
    let corners = flat(outline);
    let place = |p: Vec3<f64>| corners.iter().position(|c| *c == p.to_array()).expect("a corner");
    triangles(&corners).iter().map(|triangle| triangle.corners().map(place)).collect()
}

#[test]
fn convex_polygons_are_fans() {
    assert_eq!(places(&[[0, 0], [2, 0], [2, 2], [0, 2]]), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(places(&[[0, 2], [2, 2], [2, 0], [0, 0]]), [[0, 1, 2], [0, 2, 3]]);
    let pentagon = [[0, 0], [4, 0], [5, 3], [2, 5], [-1, 3]];
    assert_eq!(places(&pentagon), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn golden_polygons() {
    // An arrow head, from its tip and from beside it: the fan from the first corner would leave it.
    assert_eq!(places(&[[0, 0], [2, 2], [0, 1], [-2, 2]]), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(places(&[[2, 2], [0, 1], [-2, 2], [0, 0]]), [[0, 1, 3], [1, 2, 3]]);
    // A corner in the middle of an edge.
    assert_eq!(places(&[[0, 0], [1, 0], [2, 0], [2, 2]]), [[0, 1, 3], [1, 2, 3]]);
    // Corners that repeat the one before, and the first at the end.
    assert_eq!(
        places(&[[0, 0], [0, 0], [2, 0], [2, 2], [2, 2], [0, 2], [0, 0]]),
        [[0, 2, 3], [0, 3, 5]]
    );
    // Two triangles that touch in a corner, the smaller one with its back in front.
    let touching = [[0, 0], [2, 1], [2, -1], [0, 0], [-4, 2], [-4, -2]];
    let areas: Vec<f64> = triangles(&flat(&touching)).iter().map(|t| normal(t).z).collect();
    assert_eq!(areas, [-4.0, 16.0]);
}

#[test]
fn a_hole_is_cut_by_a_bridge() {
    let corners =
        flat(&[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0], [3, 3], [3, 6], [6, 6], [6, 3], [3, 3]]);
    check(&corners, 8).expect("it is filled but for the hole");
    assert_eq!(newell(&corners).z, 2.0 * 72.0);
}

#[test]
fn what_is_no_polygon_is_told() {
    let noted = |outline: &[[i32; 2]]| {
        // A triangle beside it, as a mesh is never empty.
        let mut obj = "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n".to_owned();
        for [x, y] in outline {
            writeln!(obj, "v {x} {y} 0").expect("text");
        }
        obj += "f";
        for number in 0..outline.len() {
            write!(obj, " {}", number + 4).expect("text");
        }
        let mesh = Mesh::from_bytes("m", MeshFormat::Obj, obj.as_bytes()).expect("sound");
        let note = mesh.notes.iter().map(|note| note.what.clone()).collect::<Vec<_>>().join("; ");
        (mesh.triangles.len() - 1, note)
    };
    let crossing = "a polygon whose outline crosses itself, seen along its normal, is taken as a fan of \
                    triangles from its first corner";
    let none = "a polygon without area is left out";
    for (outline, count, note) in [
        (&[[0, 0], [2, 2], [2, 0], [0, 1]][..], 2, crossing),
        (&[[0, 0], [1, 1], [1, 0], [0, 1]], 2, crossing),
        (&[[0, 3], [2, -3], [-3, 1], [3, 1], [-2, -3]], 3, crossing),
        // A loop inside of the outline, the same way round: its inside would be there twice.
        (&[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0], [4, 2], [2, 4]], 5, crossing),
        (&[[0, 0], [1, 1], [2, 2], [3, 3]], 0, none),
        (&[[0, 0], [1, 1], [0, 0], [1, 1]], 0, none),
        (&[[5, 5], [5, 5], [5, 5], [5, 5]], 0, none),
    ] {
        assert_eq!(noted(outline), (count, note.to_owned()), "{outline:?}");
    }
}

/// Tiny and huge at once: neither overflows nor vanishes.
#[test]
fn the_range_of_f32_is_the_range_of_polygons() {
    for size in [1e-300, 1e-45, 1e-20, 1e20, 3e38] {
        let arrow: Vec<Point> = [[-1.0, 1.0], [0.0, 0.5], [1.0, 1.0], [0.0, -1.0]]
            .map(|[x, y]| [x * size, 0.0, y * size])
            .into();
        assert_eq!(triangles(&arrow).len(), 2, "{size}");
    }
}

#[test]
fn the_corners_of_a_polygon_are_limited() {
    let gear = |count: usize, depth: f64| -> Vec<Point> {
        let at = |i: usize| {
            let (angle, r) = (TAU * i as f64 / count as f64, 1.0 + depth * (i % 2) as f64);
            [r * angle.cos(), r * angle.sin(), 0.0]
        };
        (0..count).map(at).collect()
    };
    assert_eq!(mesh(&gear(2000, 0.3)).triangles.len(), 1998);
    let many = gear((1 << 15) + 2, 0.3);
    let mut obj: String = many.iter().fold(String::new(), |mut obj, [x, y, z]| {
        writeln!(obj, "v {x} {y} {z}").expect("text");
        obj
    });
    obj += "f";
    for number in 1..=many.len() {
        write!(obj, " {number}").expect("text");
    }
    let error = Mesh::from_bytes("m", MeshFormat::Obj, obj.as_bytes()).expect_err("too many");
    assert_eq!(
        error.to_string(),
        "m: face 0 (line 32771): 32770 corners, more than 32768, are not supported; split it into \
         smaller polygons"
    );
}
