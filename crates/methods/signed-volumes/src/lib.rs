#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{Corners, Given, Homogeneous, Input, Method, MethodInfo, Of, Output};

/// Signed volumes: half-spaces through the origin of the ray.
pub struct SignedVolumes;

impl Method for SignedVolumes {
    const INFO: MethodInfo = MethodInfo {
        name: "signed-volumes",
        title: "Signed volumes",
        year: 2005,
        source: "A. Lagae, P. Dutré: An Efficient Ray-Quadrilateral Intersection Test. Journal of \
                 Graphics Tools 10(4), 2005",
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
        // The normals of the half-spaces depend on the origin and the triangle alone.
        let alpha = ray.d.dot(b.cross(c));
        let beta = ray.d.dot(c.cross(a));
        let gamma = ray.d.dot(a.cross(b));
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

trisect_method::methods!(SignedVolumes);
