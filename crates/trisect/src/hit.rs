//! Where a ray hits.

use std::fmt;

use trisect_core::Vec3;
use trisect_tracer::TriangleHit;

use crate::{Precision, Scene};

/// A triangle that a ray hits, and where.
#[derive(Clone, Copy, PartialEq)]
pub struct Hit<P = f32> {
    /// The triangle: the index of its face, or its place among the triangles that the scene was made of.
    pub triangle: u32,
    /// How far along the ray: the hit is at `o + t·d`.
    pub t: P,
    /// The weight of the triangle's second corner.
    pub beta: P,
    /// The weight of its third corner.
    pub gamma: P,
}

impl<P: Precision> fmt::Debug for Hit<P> {
    /// With all three weights.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { triangle, t, beta, gamma } = self;
        f.debug_struct("Hit")
            .field("triangle", triangle)
            .field("t", t)
            .field("alpha", &self.alpha())
            .field("beta", beta)
            .field("gamma", gamma)
            .finish()
    }
}

impl<P: Precision> Hit<P> {
    #[inline(always)]
    pub(crate) fn of(TriangleHit { triangle, hit }: TriangleHit<P>) -> Self {
        Self { triangle, t: hit.t, beta: hit.beta, gamma: hit.gamma }
    }

    /// The weight of the triangle's first corner: 1 − `beta` − `gamma`, rounded once, and 0 where that is less.
    #[inline]
    pub fn alpha(&self) -> P {
        let (beta, gamma) = (self.beta.to_f64(), self.gamma.to_f64());
        // What the first difference loses, which is nothing in f32, comes back in the second.
        let rest = 1.0 - beta;
        let lost = (1.0 - rest) - beta;
        P::from_f64(((rest - gamma) + lost).max(0.0))
    }

    /// The point of the triangle that is hit, from its corners as `scene` has them now and their weights: nearer to
    /// the triangle than `o + t·d` where the ray comes from afar.
    ///
    /// # Panics
    /// When the scene has no such triangle.
    pub fn point(&self, scene: &Scene<P>) -> [P; 3] {
        let corners = scene.corners(self.triangle);
        let weights = [self.alpha(), self.beta, self.gamma].map(P::to_f64);
        let point = |axis: usize| {
            let weighted = |k: usize| weights[k] * corners[k].to_array()[axis];
            P::from_f64(weighted(0) + weighted(1) + weighted(2))
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
    pub fn normal(&self, scene: &Scene<P>) -> [P; 3] {
        let [a, b, c] = scene.corners(self.triangle);
        // Of corners that are carried, this is the mesh's normal times the matrix of cofactors: the inverse transpose
        // times the determinant, whose sign alone matters.
        let normal: Vec3<f64> = (b - a).cross(c - a);
        let normal = if scene.is_mirrored(self.triangle) { -normal } else { normal };
        let length = normal.dot(normal).sqrt();
        let share = |x: f64| P::from_f64(if length > 0.0 { x / length } else { 0.0 });
        normal.to_array().map(share)
    }
}

/// All hits of each of many rays.
#[derive(Clone, Debug, PartialEq)]
pub struct AllHits<P = f32>(pub(crate) trisect_tracer::AllHits<P>);

impl<P: Precision> AllHits<P> {
    /// The hits of a ray, by its place among the rays, in order.
    ///
    /// # Panics
    /// When there is no such ray.
    pub fn of(&self, ray: usize) -> impl ExactSizeIterator<Item = Hit<P>> + '_ {
        self.0.of(ray).iter().copied().map(Hit::of)
    }

    /// The hits of all rays, one ray after another.
    pub fn hits(&self) -> impl ExactSizeIterator<Item = Hit<P>> + '_ {
        self.0.hits().iter().copied().map(Hit::of)
    }

    /// Where the hits of each ray end among those of all.
    pub fn ends(&self) -> &[usize] {
        self.0.ends()
    }
}
