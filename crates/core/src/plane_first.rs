//! What methods have in common that find the plane first, then the point, then `beta` and `gamma`.

use crate::geometry::Hit;
use crate::lanes::{Lanes, Scalar};
use crate::method::{Homogeneous, Method};
use crate::record::Of;

/// A method that meets the plane first and finds `beta` and `gamma` as linear functions of the
/// point there.
///
/// Both forms of the division come from two functions: the point may be asked for times any
/// weight. Weighted by `det` it needs no division ([`deferred`](PlaneFirst::deferred)); weighted
/// by 1 it is the point itself ([`early`](PlaneFirst::early)), as the papers have it.
pub trait PlaneFirst: Method {
    /// `(det, t · det)` where the ray meets the plane.
    fn plane<L: Lanes>(ray: &Self::PreparedRay<L>, triangle: &Of<Self::Prepared, L>) -> (L, L);

    /// `(beta, gamma)`, times `weight`, of the point `(weight·o + t·d) / weight`.
    fn barycentrics<L: Lanes>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
        weight: L,
        t: L,
    ) -> (L, L);

    /// What [`Method::intersect`] returns.
    #[inline(always)]
    fn deferred<L: Lanes>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
    ) -> Homogeneous<L> {
        let (det, t) = Self::plane(ray, triangle);
        let (beta, gamma) = Self::barycentrics(ray, triangle, det, t);
        Homogeneous { det, t, beta, gamma }
    }

    /// What [`Method::intersect_early`] returns.
    #[inline(always)]
    fn early<L: Lanes>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> (L, Hit<L>) {
        let (det, dett) = Self::plane(ray, triangle);
        let t = dett * reciprocal(det);
        // A product with the constant 1 is compiled to nothing.
        let one = t.constant(L::Elem::from_f64(1.0));
        let (beta, gamma) = Self::barycentrics(ray, triangle, one, t);
        (det, Hit { t, beta, gamma })
    }
}
