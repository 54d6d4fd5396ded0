#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Given, Homogeneous, Method, MethodInfo, Of, Output, PlaneFirst, Quotients, Slopes, ThreePlanes,
    Vertex,
};

/// Arenberg 1988.
pub struct Arenberg;

/// The planes of the triangle seen from corner `C`.
type FromC = ThreePlanes<Vertex>;

impl Method for Arenberg {
    const INFO: MethodInfo = MethodInfo {
        name: "arenberg",
        title: "Arenberg",
        year: 1988,
        source: "J. Arenberg: Re: Ray/Triangle Intersection with Barycentric Coordinates. Ray \
                 Tracing News 1(11), 1988",
        outputs: Output::ALL,
        ..MethodInfo::USUAL
    };
    type Prepared = (Slopes<()>, <Vertex as trisect_method::Frame>::Stored);
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Given<L>;

    /// The inverse of the matrix of `A − C`, `B − C` and `N`, and `C`.
    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        let Triangle { a, b, c } = *triangle;
        FromC::prepare(&Triangle { a: c, b: a, c: b })
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(
        ray: &Ray<L>,
        triangle: &Of<Self::Prepared, L>,
    ) -> Homogeneous<L, Given<L>> {
        let Homogeneous { det, t, beta: alpha, gamma: beta, .. } = FromC::deferred(ray, triangle);
        Homogeneous { det, t, alpha: Given(alpha), beta, gamma: det - alpha - beta }
    }

    /// As published: `t` first, then the point.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        triangle: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L, Given<L>> {
        let Quotients { det, t, beta: alpha, gamma: beta, .. } =
            FromC::early(ray, triangle, reciprocal);
        let one = det.constant(L::Elem::from_f64(1.0));
        Quotients { det, t, alpha: Given(alpha), beta, gamma: one - alpha - beta }
    }

    /// Here `det = D·N`, which is negative at the front.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, _triangle: &Of<Self::Prepared, L>, det: L) -> L {
        -det
    }

    #[inline(always)]
    fn normal<L: Lanes>((slopes, _): &Of<Self::Prepared, L>, _group: usize) -> Option<Vec3<L>> {
        Some(slopes.plane)
    }
}

trisect_method::methods!(Arenberg);
