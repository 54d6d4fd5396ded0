//! Where a ray hits.

use trisect_core::Vec3;
use trisect_tracer::TriangleHit;

use crate::Scene;

/// A triangle that a ray hits, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle: the index of its face, or its place among the triangles that the scene was made of.
    pub triangle: u32,
    /// How far along the ray: the hit is at `o + t·d`.
    pub t: f32,
    /// The weight of the triangle's first corner: 1 − `beta` − `gamma`, rounded once, and 0 where that is less.
    pub alpha: f32,
    /// The weight of its second corner.
    pub beta: f32,
    /// The weight of its third corner.
    pub gamma: f32,
}

impl Hit {
    #[allow(clippy::cast_possible_truncation, reason = "rounds")]
    #[inline]
    pub(crate) fn of(TriangleHit { triangle, hit }: TriangleHit) -> Self {
        let alpha = 1.0 - f64::from(hit.beta) - f64::from(hit.gamma);
        let alpha = alpha.max(0.0) as f32;
        Self { triangle, t: hit.t, alpha, beta: hit.beta, gamma: hit.gamma }
    }

    /// The point of the triangle that is hit, from its corners as `scene` has them now and their weights: nearer to
    /// the triangle than `o + t·d` where the ray comes from afar.
    ///
    /// # Panics
    /// When the scene has no such triangle.
    #[allow(clippy::cast_possible_truncation, reason = "rounds")]
    pub fn point(&self, scene: &Scene) -> [f32; 3] {
        let corners = scene.corners(self.triangle);
        let weights = [self.alpha, self.beta, self.gamma].map(f64::from);
        let point = |axis: usize| {
            let weighted = |k: usize| weights[k] * corners[k].to_array()[axis];
            (weighted(0) + weighted(1) + weighted(2)) as f32
        };
        [0, 1, 2].map(point)
    }

    /// The normal of the triangle that is hit, of unit length: it points from the front, from where the corners
    /// `a, b, c` run counter-clockwise, whichever side the ray comes from. In an instance the front is where it is in
    /// the space of the mesh, mirrored or not: the normal is carried by the inverse transpose. Computed in f64 from the corners as
    /// `scene` has them now; zeros for a triangle so thin that not even that finds its plane.
    ///
    /// # Panics
    /// When the scene has no such triangle.
    #[allow(clippy::cast_possible_truncation, reason = "rounds")]
    pub fn normal(&self, scene: &Scene) -> [f32; 3] {
        let [a, b, c] = scene.corners(self.triangle);
        // Of corners that are carried, this is the mesh's normal times the matrix of cofactors: the inverse transpose
        // times the determinant, whose sign alone matters.
        let normal: Vec3<f64> = (b - a).cross(c - a);
        let normal = if scene.is_mirrored(self.triangle) { -normal } else { normal };
        let length = normal.dot(normal).sqrt();
        if length > 0.0 { normal.to_array().map(|x| (x / length) as f32) } else { [0.0; 3] }
    }
}

/// All hits of each of many rays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllHits(pub(crate) trisect_tracer::AllHits);

impl AllHits {
    /// The hits of a ray, by its place among the rays, in order.
    ///
    /// # Panics
    /// When there is no such ray.
    pub fn of(&self, ray: usize) -> impl ExactSizeIterator<Item = Hit> + '_ {
        self.0.of(ray).iter().copied().map(Hit::of)
    }

    /// The hits of all rays, one ray after another.
    pub fn hits(&self) -> impl ExactSizeIterator<Item = Hit> + '_ {
        self.0.hits().iter().copied().map(Hit::of)
    }

    /// Where the hits of each ray end among those of all.
    pub fn ends(&self) -> &[usize] {
        self.0.ends()
    }
}
