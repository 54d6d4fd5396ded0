#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{Corners, Given, Homogeneous, Input, Method, MethodInfo, Of, Output};

/// Jiménez–Segura–Feito 2010.
pub struct JimenezSeguraFeito;

impl Method for JimenezSeguraFeito {
    const INFO: MethodInfo = MethodInfo {
        name: "jimenez-segura-feito",
        title: "Jiménez–Segura–Feito",
        year: 2010,
        source: "J. J. Jiménez, R. J. Segura, F. R. Feito: A Robust Segment/Triangle Intersection \
                 Algorithm for Interference Tests. Efficiency Study. Computational Geometry 43(5), \
                 2010",
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

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, corners: &Corners<L>) -> Homogeneous<L, Given<L>> {
        // The paper's letters, but for its Q1, which is O, and its V1, V2, V3, which are A, B, C.
        let a = ray.o - corners.c;
        let b = corners.a - corners.c;
        let c = corners.b - corners.c;
        let w1 = b.cross(c);
        let w2 = a.cross(ray.d);
        let det = -ray.d.dot(w1);
        let alpha = w2.dot(c);
        let beta = -w2.dot(b);
        Homogeneous { det, t: a.dot(w1), alpha: Given(alpha), beta, gamma: det - alpha - beta }
    }

    #[inline(always)]
    fn normal<L: Lanes>(corners: &Corners<L>, _group: usize) -> Option<Vec3<L>> {
        Some(corners.normal())
    }
}

trisect_method::methods!(JimenezSeguraFeito);
