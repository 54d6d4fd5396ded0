//! A hall: few large triangles among many small ones, as indoors.

use trisect_core::{Triangle, Vec3};
use trisect_mesh::Mesh;

use crate::surface::{Placement, Surface};

/// Bays along each side.
const BAYS: u16 = 10;
/// Side of a bay.
const BAY: f64 = 8.0;
/// Height of the columns.
const HEIGHT: f64 = 12.0;

/// A hall without walls or a roof, so that a camera sees into it: a floor, columns with beams from
/// one to the next, and a sphere in each bay; turned, so that nothing lies along an axis.
///
/// 33,728 triangles, the larger ones hundreds of times as long as the smaller ones are wide.
///
/// # Panics
/// Never: there are triangles.
pub fn hall() -> Mesh {
    let length = BAY * f64::from(BAYS);
    let mut triangles = Vec::new();
    slab(&mut triangles, [0.0, -1.0, 0.0], [length, 0.0, length]);
    for row in 0..=BAYS {
        let place = BAY * f64::from(row);
        for column in 0..=BAYS {
            let across = BAY * f64::from(column);
            slab(
                &mut triangles,
                [across - 0.2, 0.0, place - 0.2],
                [across + 0.2, HEIGHT, place + 0.2],
            );
        }
        let (from, to) = (place - 0.1, place + 0.1);
        slab(&mut triangles, [0.0, HEIGHT, from], [length, HEIGHT + 0.4, to]);
        slab(&mut triangles, [from, HEIGHT + 0.4, 0.0], [to, HEIGHT + 0.8, length]);
    }
    let sphere = Surface::sphere(2);
    for row in 0..BAYS {
        for column in 0..BAYS {
            let middle = |bay: u16| BAY * (f64::from(bay) + 0.5);
            // From small to large along the diagonal.
            let scale = 0.2 + 0.05 * f64::from(row + column);
            let offset = Vec3::new(middle(column), 2.0 * scale, middle(row));
            triangles.extend(sphere.triangles::<f32>(&Placement { scale, offset }));
        }
    }
    let triangles: Vec<Triangle<f32>> = triangles.into_iter().map(turned).collect();
    Mesh::from_triangles("hall", triangles).expect("finite triangles")
}

/// The twelve triangles of a box.
fn slab(triangles: &mut Vec<Triangle<f32>>, from: [f64; 3], to: [f64; 3]) {
    let corner = |number: usize| {
        let [x, y, z] = [0, 1, 2].map(|axis| if number >> axis & 1 == 0 { from } else { to }[axis]);
        rounded(Vec3::new(x, y, z))
    };
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for side in [0, 1 << axis] {
            let [a, b, c, d] = [side, side | u, side | u | v, side | v].map(corner);
            triangles.extend([Triangle { a, b, c }, Triangle { a, b: c, c: d }]);
        }
    }
}

#[allow(clippy::cast_possible_truncation, reason = "rounds")]
fn rounded(v: Vec3<f64>) -> Vec3<f32> {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// About the axis that points up, by three and four fifths: a right angle stays one.
fn turned(triangle: Triangle<f32>) -> Triangle<f32> {
    let turn = |v: Vec3<f32>| Vec3::new(0.8 * v.x - 0.6 * v.z, v.y, 0.6 * v.x + 0.8 * v.z);
    let Triangle { a, b, c } = triangle;
    Triangle { a: turn(a), b: turn(b), c: turn(c) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hall_is_as_large_as_it_says_and_has_no_degenerate_triangle() {
        let hall = hall();
        assert_eq!(hall.triangles.len(), 33_728);
        assert!(hall.triangles.iter().all(Triangle::can_be_hit));
    }
}
