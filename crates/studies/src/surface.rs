//! Whether triangles enclose anything.

use rand::RngExt as _;
use rand_pcg::Pcg64;
use trisect_core::{Ray, Triangle, Vec3};

/// A corner, by the bits of its coordinates, in which both zeros are one.
type Corner = [u32; 3];

/// How many edges do not join exactly two triangles: none of a closed surface, whose inside a ray cannot leave
/// unseen by a method that is watertight. Corners are the same where their coordinates are; triangles without
/// area join nothing.
pub fn open_edges(triangles: &[Triangle<f32>]) -> usize {
    edges(triangles).chunk_by(is_same).filter(|same| same.len() != 2).count()
}

/// An edge: its corners, and one of its triangles.
type Edge = ([Corner; 2], u32);

fn is_same(one: &Edge, other: &Edge) -> bool {
    one.0 == other.0
}

/// The edges of all triangles, in order, so that those that are the same lie beside each other.
fn edges(triangles: &[Triangle<f32>]) -> Vec<Edge> {
    let mut edges: Vec<Edge> = Vec::with_capacity(3 * triangles.len());
    for (triangle, id) in triangles.iter().zip(0..) {
        let [a, b, c] = triangle.corners().map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
        if a != b && b != c && c != a {
            let each = [[a, b], [b, c], [c, a]];
            edges.extend(each.map(|[from, to]| ([from.min(to), from.max(to)], id)));
        }
    }
    edges.sort_unstable();
    edges
}

/// So many rays, or fewer where edges are few, from the origins of others at points on edges where two
/// triangles meet that face the ray alike, and not from the side: no ray may pass there. Each reaches its
/// edge at 1.
pub(crate) fn at_edges(
    triangles: &[Triangle<f32>],
    from: &[Ray<f32>],
    count: usize,
    random: &mut Pcg64,
) -> Vec<Ray<f32>> {
    /// Attempts for each ray that is asked for.
    const ATTEMPTS: usize = 4;
    let edges = edges(triangles);
    let joined: Vec<&[Edge]> = edges.chunk_by(is_same).filter(|same| same.len() == 2).collect();
    if joined.is_empty() || from.is_empty() {
        return Vec::new();
    }
    let mut aim = |_| {
        let edge = joined[random.random_range(0..joined.len())];
        let origin = from[random.random_range(0..from.len())].o;
        let [a, b] = edge[0].0.map(|corner| Vec3::from(corner.map(f32::from_bits)));
        let share: f32 = random.random_range(0.1..0.9);
        let ray = Ray {
            o: origin,
            d: a + (b - a).map(|x| x * share) - origin,
            tmin: 0.0,
            tmax: f32::INFINITY,
        };
        let facing = |&(_, id): &Edge| {
            let n = triangles[id as usize].normal();
            n.dot(ray.d) / (n.dot(n) * ray.d.dot(ray.d)).sqrt()
        };
        let [one, other] = [facing(&edge[0]), facing(&edge[1])];
        (one * other > 0.0 && one.abs().min(other.abs()) > 0.05).then_some(ray)
    };
    (0..ATTEMPTS * count).filter_map(&mut aim).take(count).collect()
}

#[cfg(test)]
mod tests {
    use trisect_workloads::{Placement, Surface, bunny};

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
        let edges = open_edges(&bunny().triangles);
        assert!(edges > 0 && edges < 1000, "{edges}");
    }
}
