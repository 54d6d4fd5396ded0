//! Triangles with what shading asks of them.

use std::collections::HashMap;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use trisect_core::Triangle;
use trisect_mesh::Reading;

use crate::camera::power_of_two;
use crate::error::SceneError;

/// Triangles with normals, coordinates for textures, and materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The name that files know it by.
    pub name: String,
    /// The triangles; every coordinate is finite.
    pub triangles: Vec<Triangle<f32>>,
    /// The corners' normals, of unit length, one triple a triangle; empty where there are none.
    pub normals: Vec<[Vec3; 3]>,
    /// The corners' coordinates for textures, one triple a triangle; empty where there are none.
    pub coordinates: Vec<[Vec2; 3]>,
    /// Each triangle's material; empty where an instance says it.
    pub materials: Vec<usize>,
    /// What was subtracted from the positions that its file has; instances of it allow for that.
    pub origin: DVec3,
    /// By how much the corner that moves most moved when it was rounded to f32.
    pub rounding: f64,
}

impl Mesh {
    /// A mesh of triangles alone, moved to near 0 and rounded to f32.
    pub(crate) fn near(name: impl Into<String>, exact: &[Triangle<f64>]) -> Self {
        let corners = exact.iter().flat_map(|triangle| triangle.corners());
        let bounds = corners.fold(None, |bounds, corner| {
            let corner = DVec3::from(corner.to_array());
            let [low, high] = bounds.unwrap_or([corner; 2]);
            Some([low.min(corner), high.max(corner)])
        });
        let origin = bounds.map_or(DVec3::ZERO, near_origin);
        let mut rounding = 0.0_f64;
        let triangles = exact.iter().map(|triangle| {
            let [a, b, c] = triangle.corners().map(|corner| {
                let exact = DVec3::from(corner.to_array()) - origin;
                let near = exact.as_vec3();
                rounding = rounding.max(near.as_dvec3().distance(exact));
                near
            });
            Triangle::new(a, b, c)
        });
        let triangles = triangles.collect();
        Self { name: name.into(), triangles, origin, rounding, ..Self::default() }
    }

    /// A mesh of triangles alone. Normals are those of [`with_smooth_normals`](Mesh::with_smooth_normals).
    pub fn of_triangles(name: impl Into<String>, triangles: Vec<Triangle<f32>>) -> Self {
        Self { name: name.into(), triangles, ..Self::default() }.with_smooth_normals()
    }

    /// Gives each corner the mean of the normals of all triangles that have a corner there, weighted by
    /// their area; the triangle's own where that has no direction.
    #[must_use]
    pub fn with_smooth_normals(mut self) -> Self {
        let key = |corner: trisect_core::Vec3<f32>| corner.map(|x| (x + 0.0).to_bits()).to_array();
        let own = self.areas();
        let mut sums: HashMap<[u32; 3], Vec3> = HashMap::new();
        for (triangle, normal) in self.triangles.iter().zip(&own) {
            for corner in triangle.corners() {
                *sums.entry(key(corner)).or_default() += *normal;
            }
        }
        self.normals = self
            .triangles
            .iter()
            .zip(own)
            .map(|(triangle, own)| {
                let own = own.normalize_or_zero();
                triangle.corners().map(|corner| sums[&key(corner)].normalize_or(own))
            })
            .collect();
        self
    }

    /// The triangles' own normals, of unit length; 0 where a triangle has no area.
    pub(crate) fn own_normals(&self) -> impl Iterator<Item = Vec3> + use<> {
        self.areas().into_iter().map(Vec3::normalize_or_zero)
    }

    /// The triangles' normals, as long as their areas, in units in which the mesh is about as large as 1: in
    /// the file's own they may be out of range.
    fn areas(&self) -> Vec<Vec3> {
        let corners =
            || self.triangles.iter().flat_map(|triangle| triangle.corners().map(Vec3::from));
        let [low, high] =
            [Vec3::min, Vec3::max].map(|pick| corners().reduce(pick).unwrap_or_default());
        let unit = power_of_two(high * 0.5 - low * 0.5);
        let scaled = |triangle: &Triangle<f32>| {
            let [a, b, c] = triangle.corners().map(|corner| Vec3::from(corner) / unit);
            Vec3::from(Triangle::new(a, b, c).normal())
        };
        self.triangles.iter().map(scaled).collect()
    }
}

/// What is further from 0 than so many times its size is moved.
pub(crate) const FAR: f64 = 16.0;

/// What to subtract from positions in a box, so that f32 holds them well: 0 where the box is not far from 0,
/// else its middle, with so few bits that the difference is exact. A box that is larger by a power of two has
/// an origin that is.
pub(crate) fn near_origin([low, high]: [DVec3; 2]) -> DVec3 {
    let (size, middle) = ((high - low).max_element(), low * 0.5 + high * 0.5);
    // The power of two below the size; a box without size is as large as its distance.
    let power = f64::from_bits(size.to_bits() & 0x7ff0_0000_0000_0000);
    if !(size > 0.0 && power > 0.0 && middle.abs().max_element() > FAR * size) {
        return DVec3::ZERO;
    }
    (middle / power).round() * power
}

/// Triangles of a file of any format, with smooth normals and without materials.
pub(crate) fn load_triangles(path: &Path, reading: &mut Reading) -> Result<Mesh, SceneError> {
    let mesh = trisect_mesh::Mesh::read(path, reading)?;
    Ok(Mesh::near(&*mesh.name, &mesh.triangles_f64()).with_smooth_normals())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_an_octahedron_point_along_its_axes() {
        let mut triangles = Vec::new();
        for [x, y, z] in
            (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { 1.0 } else { -1.0 }))
        {
            let [a, b, c] = [Vec3::X * x, Vec3::Y * y, Vec3::Z * z];
            // An odd number of mirrors turns the order round.
            let (b, c) = if x * y * z > 0.0 { (b, c) } else { (c, b) };
            triangles.push(Triangle::new(a, b, c));
        }
        let mesh = Mesh::of_triangles("octahedron", triangles);
        for (triangle, normals) in mesh.triangles.iter().zip(&mesh.normals) {
            for (corner, normal) in triangle.corners().into_iter().zip(normals) {
                assert!((*normal - Vec3::from(corner)).length() < 1e-6, "{corner:?} {normal}");
            }
        }
    }
}
