#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Homogeneous, Lanes, Method, MethodInfo, Of, Ray, Scalar, Triangle, record};

record! {
    /// A corner and the two edges at it, one leaving, one arriving.
    pub struct CornerTriangle {
        /// Corner `A`.
        a: vec3,
        /// Edge `ab = B − A`.
        ab: vec3,
        /// Edge `ca = A − C`.
        ca: vec3,
    }
}

/// Kensler–Shirley 2006.
pub struct KenslerShirley;

impl Method for KenslerShirley {
    const INFO: MethodInfo = MethodInfo {
        name: "kensler-shirley",
        title: "Kensler–Shirley",
        year: 2006,
        source: "A. Kensler, P. Shirley: Optimizing Ray-Triangle Intersection via Automated \
                 Search. IEEE Symposium on Interactive Ray Tracing, 2006",
        outputs: &["hit", "t", "beta", "gamma"],
        // As Möller–Trumbore's: the same six products in each volume, rounded as often.
        error_factor: 9.0,
    };
    type Prepared = CornerTriangle<()>;
    type PreparedRay<L: Lanes> = Ray<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        let a = triangle.a;
        if triangle.is_degenerate() {
            // Fused arithmetic would give `ab × ca` a rounding error instead of zero.
            let zero = a.map(|_| X::from_f64(0.0));
            return CornerTriangle { a, ab: zero, ca: zero };
        }
        CornerTriangle { a, ab: triangle.b - a, ca: a - triangle.c }
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, triangle: &CornerTriangle<L>) -> Homogeneous<L> {
        // The normal depends on the triangle alone: a packet of rays shares it.
        let n = triangle.ab.cross(triangle.ca);
        let oa = triangle.a - ray.o;
        let i = oa.cross(ray.d);
        Homogeneous {
            det: ray.d.dot(n),
            t: n.dot(oa),
            beta: i.dot(triangle.ca),
            gamma: i.dot(triangle.ab),
        }
    }
}

trisect_core::methods!(KenslerShirley);
