#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Hit, Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Corners, Culling, Division, Form, Forms, Homogeneous, Implied, Input, Interval, Method,
    MethodInfo, Of, Output, record, seen,
};

record! {
    /// A corner and the two edges that leave it.
    pub struct EdgeTriangle {
        /// Corner `A`.
        a: vec3,
        /// Edge `e1 = B − A`.
        e1: vec3,
        /// Edge `e2 = C − A`.
        e2: vec3,
    }
}

/// What is known before `gamma`.
struct Start<L> {
    det: L,
    s: Vec3<L>,
    beta: L,
}

/// The first half of the formula: `det`, and `beta · det`.
#[inline(always)]
fn start<L: Lanes>(ray: &Ray<L>, triangle: &EdgeTriangle<L>) -> Start<L> {
    let p = ray.d.cross(triangle.e2);
    let s = ray.o - triangle.a;
    Start { det: triangle.e1.dot(p), s, beta: s.dot(p) }
}

/// The second half: `gamma · det` and `t · det`.
#[inline(always)]
fn finish<L: Lanes>(ray: &Ray<L>, triangle: &EdgeTriangle<L>, q: Vec3<L>) -> (L, L) {
    (ray.d.dot(q), triangle.e2.dot(q))
}

/// The whole formula.
#[inline(always)]
fn solve<L: Lanes>(ray: &Ray<L>, triangle: &EdgeTriangle<L>) -> Homogeneous<L> {
    let Start { det, s, beta } = start(ray, triangle);
    let (gamma, t) = finish(ray, triangle, s.cross(triangle.e1));
    Homogeneous { det, t, alpha: Implied, beta, gamma }
}

const INFO: MethodInfo = MethodInfo {
    name: "moller-trumbore",
    title: "Möller–Trumbore",
    year: 1997,
    source: "T. Möller, B. Trumbore: Fast, Minimum Storage Ray/Triangle Intersection. \
             Journal of Graphics Tools 2(1), 1997, section 2",
    outputs: Output::ALL,
    // `t`: its numerator has 8 roundings and `det` 7, the reciprocal and the product one more
    // each, `κ_t ≥ 2|t|`. One fewer for `beta` and `gamma`. See the README.
    error_factor: 9.0,
    ..MethodInfo::USUAL
};

/// Möller–Trumbore 1997.
pub struct MollerTrumbore;

impl Method for MollerTrumbore {
    const INFO: MethodInfo = INFO;
    type Prepared = EdgeTriangle<()>;
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        let a = triangle.a;
        EdgeTriangle { a, e1: triangle.b - a, e2: triangle.c - a }
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, triangle: &EdgeTriangle<L>) -> Homogeneous<L> {
        solve(ray, triangle)
    }

    #[inline(always)]
    fn normal<L: Lanes>(triangle: &EdgeTriangle<L>, _group: usize) -> Option<Vec3<L>> {
        Some(triangle.e1.cross(triangle.e2))
    }
}

/// Möller–Trumbore from three points, in one of the four published orders of test and division.
///
/// Order 1 is the one in print: divide, then test `beta`, `gamma` and `t` as quotients. Order 2 of
/// the authors' code tests numerators, and divides for what is left; order 3 divides first and still
/// tests numerators, so that the quotient is ready when it is asked for; order 4 computes `q` before
/// the first test as well.
pub struct PublishedOrder<const ORDER: u8>;

/// By order: as typed, and in prose.
const NAMES: [(&str, &str); 4] = [
    ("moller-trumbore-1", "Möller–Trumbore, order 1"),
    ("moller-trumbore-2", "Möller–Trumbore, order 2"),
    ("moller-trumbore-3", "Möller–Trumbore, order 3"),
    ("moller-trumbore-4", "Möller–Trumbore, order 4"),
];

#[inline(always)]
fn edges<L: Lanes>(corners: &Corners<L>) -> EdgeTriangle<L> {
    let (e1, e2) = corners.edges();
    EdgeTriangle { a: corners.a, e1, e2 }
}

impl<const ORDER: u8> PublishedOrder<ORDER> {
    /// Order 1: tests of quotients, each followed by a way out.
    #[inline(always)]
    fn test_quotients<L: Lanes, D: Division>(
        ray: &Ray<L>,
        corners: &Corners<L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    ) {
        let triangle = edges(corners);
        let Start { det, s, beta } = start(ray, &triangle);
        let zero = det.constant(L::Elem::from_f64(0.0));
        let one = det.constant(L::Elem::from_f64(1.0));
        let r = D::reciprocal(det);
        let beta = beta * r;
        let mask = beta.ge(zero) & beta.le(one);
        if D::stops::<L>(mask) {
            return;
        }
        let (gamma, t) = finish(ray, &triangle, s.cross(triangle.e1));
        let gamma = gamma * r;
        let mask = mask & gamma.ge(zero) & (beta + gamma).le(one);
        if D::stops::<L>(mask) {
            return;
        }
        let t = t * r;
        let mask = mask & t.ge(interval.tmin) & t.le(interval.tmax);
        let mask = seen::<Self, L>(mask, ray, corners, det, culling);
        if D::stops::<L>(mask) {
            return;
        }
        found(mask, Hit { t, beta, gamma });
    }

    /// Orders 2 to 4, and order 1 where it is not to divide: tests of numerators, each followed by a way out.
    #[inline(always)]
    fn test_numerators<L: Lanes, D: Division>(
        ray: &Ray<L>,
        corners: &Corners<L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    ) {
        let triangle = edges(corners);
        let Start { det, s, beta } = start(ray, &triangle);
        let whole = det.magnitude();
        let zero = det.constant(L::Elem::from_f64(0.0));
        let ahead = (ORDER >= 3).then(|| D::reciprocal(whole));
        let q_ahead = (ORDER == 4).then(|| s.cross(triangle.e1));
        let beta_ahead = beta.xor_sign(det);
        let mask = beta_ahead.ge(zero) & beta_ahead.le(whole);
        if D::stops::<L>(mask) {
            return;
        }
        let q = q_ahead.unwrap_or_else(|| s.cross(triangle.e1));
        let (gamma, t) = finish(ray, &triangle, q);
        let h = Homogeneous { det, t, alpha: Implied, beta, gamma }.positive();
        let mask = h.inside() & h.has_reciprocal();
        if D::stops::<L>(mask) {
            return;
        }
        let mask = seen::<Self, L>(mask & h.in_time(interval), ray, corners, det, culling);
        if D::stops::<L>(mask) {
            return;
        }
        found(mask, h.hit(ahead.unwrap_or_else(|| D::reciprocal(whole))));
    }
}

impl<const ORDER: u8> Method for PublishedOrder<ORDER> {
    const INFO: MethodInfo = MethodInfo {
        name: NAMES[ORDER as usize - 1].0,
        title: NAMES[ORDER as usize - 1].1,
        input: Input::Points,
        forms: if ORDER == 1 { Forms::Early } else { Forms::Deferred },
        ..INFO
    };
    type Prepared = Corners<()>;
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        Corners::new(triangle)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, corners: &Corners<L>) -> Homogeneous<L> {
        solve(ray, &edges(corners))
    }

    #[inline(always)]
    fn normal<L: Lanes>(corners: &Corners<L>, _group: usize) -> Option<Vec3<L>> {
        MollerTrumbore::normal(&edges(corners), 0)
    }

    #[inline(always)]
    fn test<L: Lanes, D: Division>(
        ray: &Ray<L>,
        corners: &Corners<L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    ) {
        // Known when it is compiled. The early form decides alike whatever is asked of it.
        let divides_first = matches!(D::FORM, Form::Early);
        if ORDER == 1 && divides_first {
            Self::test_quotients::<L, D>(ray, corners, interval, culling, found);
        } else {
            Self::test_numerators::<L, D>(ray, corners, interval, culling, found);
        }
    }
}

trisect_method::methods!(
    MollerTrumbore,
    PublishedOrder<1>,
    PublishedOrder<2>,
    PublishedOrder<3>,
    PublishedOrder<4>,
);
