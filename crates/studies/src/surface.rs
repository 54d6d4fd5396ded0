//! Whether triangles enclose anything.

use trisect_core::Triangle;

/// A corner, by the bits of its coordinates, in which both zeros are one.
type Corner = [u32; 3];

/// How many edges do not join exactly two triangles: none of a closed surface, whose inside a ray cannot leave
/// unseen by a method that is watertight. Corners are the same where their coordinates are; triangles without
/// area join nothing.
pub fn open_edges(triangles: &[Triangle<f32>]) -> usize {
    let mut edges: Vec<[Corner; 2]> = Vec::with_capacity(3 * triangles.len());
    for triangle in triangles {
        let [a, b, c] = triangle.corners().map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
        if a != b && b != c && c != a {
            edges.extend([[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)]));
        }
    }
    edges.sort_unstable();
    edges.chunk_by(|one, other| one == other).filter(|same| same.len() != 2).count()
}

#[cfg(test)]
mod tests {
    use trisect_workloads::{Mesh, Placement, Surface};

    use super::*;

    #[test]
    fn a_sphere_is_closed_until_a_triangle_is_missing() {
        let mut sphere = Surface::sphere(2).triangles::<f32>(&Placement::HERE);
        assert_eq!(open_edges(&sphere), 0);
        let gone = sphere.pop().expect("it has some");
        assert_eq!(open_edges(&sphere), 3);
        // Twice the same: three of each of its edges.
        sphere.extend([gone, gone]);
        assert_eq!(open_edges(&sphere), 3);
        assert_eq!(open_edges(&[]), 0);
    }

    #[test]
    fn zeros_are_one_and_what_has_no_area_joins_nothing() {
        let o = [0.0; 3];
        let flat = Triangle::<f32>::new(o, [1.0, 0.0, 0.0], o);
        let one = Triangle::<f32>::new(o, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let other = Triangle::<f32>::new([-0.0; 3], [1.0, -0.0, 0.0], [0.0, -1.0, 0.0]);
        assert_eq!(open_edges(&[flat]), 0);
        assert_eq!(open_edges(&[one, flat]), 3);
        assert_eq!(open_edges(&[one, other]), 4);
    }

    #[test]
    fn the_bunny_has_holes_below() {
        let edges = open_edges(&Mesh::bunny().triangles);
        assert!(edges > 0 && edges < 1000, "{edges}");
    }
}
