#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Corners, Given, Homogeneous, Input, Method, MethodInfo, Of, Output, Quotients,
};

/// Signed areas, a common method, as Havel 2008 describes it.
pub struct SignedAreas;

/// A point `(weight·o + t·d) / weight` of the plane with normal `n`.
struct Point<'a, L> {
    ray: &'a Ray<L>,
    n: Vec3<L>,
    weight: L,
    t: L,
}

impl<L: Lanes> Point<'_, L> {
    /// Twice the area of the triangle that the point makes with an edge, times `|N|` and `weight`.
    #[inline(always)]
    fn area(&self, from: Vec3<L>, to: Vec3<L>) -> L {
        let seen = self.ray.d.mul_add(self.t, (self.ray.o - from).scale(self.weight));
        self.n.dot((to - from).cross(seen))
    }

    /// The areas opposite `A`, `B` and `C`.
    #[inline(always)]
    fn areas(&self, Corners { a, b, c }: Corners<L>) -> [L; 3] {
        [self.area(b, c), self.area(c, a), self.area(a, b)]
    }
}

impl Method for SignedAreas {
    const INFO: MethodInfo = MethodInfo {
        name: "signed-areas",
        title: "Signed areas",
        year: 2008,
        source: "Common; described by J. Havel: Rychlý výpočet průsečíku paprsku s trojúhelníkem \
                 (Fast Ray-Triangle Intersection). Master's thesis, Brno University of Technology, \
                 2008, section 3.4.4.3",
        input: Input::Points,
        outputs: Output::ALL,
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

    /// Both determinants multiplied into one denominator.
    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, corners: &Corners<L>) -> Homogeneous<L, Given<L>> {
        let (e1, e2) = corners.edges();
        let n = e1.cross(e2);
        let (det, t) = (n.dot(ray.d), n.dot(corners.a - ray.o));
        let [alpha, beta, gamma] = Point { ray, n, weight: det, t }.areas(*corners);
        // The areas sum to N², times det.
        let whole = alpha + (beta + gamma);
        Homogeneous { det: whole, t: t * n.dot(n), alpha: Given(alpha), beta, gamma }
    }

    /// As published: a division for `t`, another for the areas.
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
        let [alpha, beta, gamma] = Point { ray, n, weight: one, t }.areas(*corners);
        // Of an infinite reciprocal a NaN, lest the weights become infinite and inside.
        let r = reciprocal(alpha + (beta + gamma)).or_nan();
        Quotients { det, t, alpha: Given(alpha * r), beta: beta * r, gamma: gamma * r }
    }

    /// Here `det = D·N`, or `D·N · N²`.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, _triangle: &Of<Self::Prepared, L>, det: L) -> L {
        -det
    }

    #[inline(always)]
    fn normal<L: Lanes>(corners: &Corners<L>, _group: usize) -> Option<Vec3<L>> {
        Some(corners.normal())
    }
}

trisect_method::methods!(SignedAreas);
