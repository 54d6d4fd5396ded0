#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Corners, Given, Homogeneous, Input, Method, MethodInfo, Of, Output, Quotients,
};

/// Half-spaces at right angles to the triangle, a common method, as Havel 2008 describes it.
pub struct HalfSpaces;

/// A point `(weight·o + t·d) / weight` of the plane with normal `n`.
struct Point<'a, L> {
    ray: &'a Ray<L>,
    n: Vec3<L>,
    weight: L,
    t: L,
}

impl<L: Lanes> Point<'_, L> {
    /// The distance from the plane through an edge and along the normal, times `weight`, positive on
    /// the side of the opposite corner.
    #[inline(always)]
    fn side(&self, from: Vec3<L>, to: Vec3<L>, opposite: Vec3<L>) -> L {
        let plane = self.n.cross(to - from);
        let seen = self.ray.d.mul_add(self.t, (self.ray.o - from).scale(self.weight));
        plane.dot(seen).xor_sign(plane.dot(opposite - from))
    }

    /// The sides of the edges opposite `A`, `B` and `C`.
    #[inline(always)]
    fn sides(&self, Corners { a, b, c }: Corners<L>) -> [L; 3] {
        [self.side(b, c, a), self.side(c, a, b), self.side(a, b, c)]
    }
}

impl Method for HalfSpaces {
    const INFO: MethodInfo = MethodInfo {
        name: "half-spaces",
        title: "Perpendicular half-spaces",
        year: 2008,
        source: "Common; described by J. Havel: Rychlý výpočet průsečíku paprsku s trojúhelníkem \
                 (Fast Ray-Triangle Intersection). Master's thesis, Brno University of Technology, \
                 2008, section 3.4.4.2",
        input: Input::Points,
        outputs: Output::FLAG_T_AND_NORMAL,
        ..MethodInfo::USUAL
    };
    type Prepared = Corners<()>;
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Given<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        Corners::new(triangle)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, corners: &Corners<L>) -> Homogeneous<L, Given<L>> {
        let (e1, e2) = corners.edges();
        let n = e1.cross(e2);
        let (det, t) = (n.dot(ray.d), n.dot(corners.a - ray.o));
        let [alpha, beta, gamma] = Point { ray, n, weight: det, t }.sides(*corners);
        Homogeneous { det, t, alpha: Given(alpha), beta, gamma }
    }

    /// As published: `t` first, then the sides of the point.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        corners: &Corners<L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L, Given<L>> {
        let (e1, e2) = corners.edges();
        let n = e1.cross(e2);
        let det = n.dot(ray.d);
        let t = n.dot(corners.a - ray.o) * reciprocal(det);
        let one = det.constant(L::Elem::from_f64(1.0));
        let [alpha, beta, gamma] = Point { ray, n, weight: one, t }.sides(*corners);
        Quotients { det, t, alpha: Given(alpha), beta, gamma }
    }

    /// Here `det = D·N`, which is negative at the front.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, _triangle: &Of<Self::Prepared, L>, det: L) -> L {
        -det
    }

    #[inline(always)]
    fn normal<L: Lanes>(corners: &Corners<L>, _group: usize) -> Option<Vec3<L>> {
        Some(corners.normal())
    }
}

trisect_method::methods!(HalfSpaces);
