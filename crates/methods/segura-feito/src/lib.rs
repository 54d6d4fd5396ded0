#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{Corners, Given, Homogeneous, Input, Method, MethodInfo, Of, Output};

/// Segura–Feito 2001.
pub struct SeguraFeito;

impl Method for SeguraFeito {
    const INFO: MethodInfo = MethodInfo {
        name: "segura-feito",
        title: "Segura–Feito",
        year: 2001,
        source: "R. J. Segura, F. R. Feito: Algorithms to Test Ray-Triangle Intersection. \
                 Comparative Study. WSCG, 2001",
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
        let (a, b, c) = (corners.a - ray.o, corners.b - ray.o, corners.c - ray.o);
        // Two of the three tetrahedra share D × A.
        let m = ray.d.cross(a);
        let alpha = c.dot(ray.d.cross(b));
        let beta = -c.dot(m);
        let gamma = b.dot(m);
        Homogeneous {
            det: alpha + (beta + gamma),
            t: a.dot(corners.normal()),
            alpha: Given(alpha),
            beta,
            gamma,
        }
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

trisect_method::methods!(SeguraFeito);
