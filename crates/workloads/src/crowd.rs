//! Many copies of a mesh, for scenes larger than any that is shipped.

use trisect_core::{Triangle, Vec3};
use trisect_mesh::{Mesh, MeshError};

/// How far the copies stand apart, in diagonals of the mesh.
const SPACING: f64 = 0.8;

/// The angle between one copy and the next: no two of them are turned alike.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// So many copies of a mesh on the squares of a plane, each turned about the vertical through its center, as one mesh
/// of triangles.
///
/// # Errors
/// When a copy's corners are beyond the range of f32.
pub fn crowd(mesh: &Mesh, copies: u16) -> Result<Mesh, MeshError> {
    let side = (1..=copies).find(|side| side.saturating_mul(*side) >= copies).unwrap_or(1);
    let center = Vec3::<f64>::from(mesh.bounds.center());
    let spacing = SPACING * f64::from(mesh.bounds.diagonal());
    let mut triangles = Vec::new();
    for copy in 0..copies {
        let (sin, cos) = (GOLDEN_ANGLE * f64::from(copy)).sin_cos();
        let (column, row) = (f64::from(copy % side), f64::from(copy / side));
        let place = Vec3::new(spacing * column, 0.0, spacing * row);
        let moved = |corner: &Vec3<f32>| {
            let Vec3 { x, y, z } = Vec3::<f64>::from(*corner) - center;
            let turned = Vec3::new(cos * x + sin * z, y, cos * z - sin * x);
            (turned + center + place).map(|x| {
                #[allow(clippy::cast_possible_truncation, reason = "a mesh of f32 is made")]
                let x = x as f32;
                x
            })
        };
        triangles.extend(mesh.triangles.iter().map(|Triangle { a, b, c }| Triangle {
            a: moved(a),
            b: moved(b),
            c: moved(c),
        }));
    }
    Mesh::from_triangles(format!("{}×{copies}", mesh.name), triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_copy_is_the_mesh_and_all_are_apart() {
        let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        let triangle = Triangle {
            a: corner(-1.0, 0.0, -1.0),
            b: corner(1.0, 0.0, 1.0),
            c: corner(-1.0, 1.0, 1.0),
        };
        let mesh = Mesh::from_triangles("one", vec![triangle]).expect("it is finite");
        let crowd = crowd(&mesh, 5).expect("it is finite");
        assert_eq!((crowd.name.as_str(), crowd.triangles.len()), ("one×5", 5));
        assert_eq!(crowd.triangles[0], triangle);
        let centers: Vec<_> = crowd.triangles.iter().map(|t| (t.a + t.b).scale(0.5)).collect();
        for (at, a) in centers.iter().enumerate() {
            for b in &centers[..at] {
                let apart = *a - *b;
                assert!(apart.dot(apart).sqrt() > 0.79 * mesh.bounds.diagonal(), "{a:?} {b:?}");
            }
        }
    }
}
