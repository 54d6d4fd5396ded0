#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Homogeneous, Lanes, Method, MethodInfo, Of, Ray, Scalar, Triangle, record};

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

/// Möller–Trumbore 1997.
pub struct MollerTrumbore;

impl Method for MollerTrumbore {
    const INFO: MethodInfo = MethodInfo {
        name: "moller-trumbore",
        title: "Möller–Trumbore",
        year: 1997,
        source: "T. Möller, B. Trumbore: Fast, Minimum Storage Ray/Triangle Intersection. \
                 Journal of Graphics Tools 2(1), 1997, section 2",
        outputs: &["hit", "t", "beta", "gamma"],
        // `t`: its numerator has 8 roundings and `det` 7, the reciprocal and the product one more
        // each, `κ_t ≥ 2|t|`. One fewer for `beta` and `gamma`. See the README.
        error_factor: 9.0,
    };
    type Prepared = EdgeTriangle<()>;
    type PreparedRay<L: Lanes> = Ray<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        let a = triangle.a;
        if triangle.is_degenerate() {
            // With unequal edges `det` would be a rounding error instead of zero.
            let zero = a.map(|_| X::from_f64(0.0));
            return EdgeTriangle { a, e1: zero, e2: zero };
        }
        EdgeTriangle { a, e1: triangle.b - a, e2: triangle.c - a }
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, triangle: &EdgeTriangle<L>) -> Homogeneous<L> {
        let p = ray.d.cross(triangle.e2);
        let s = ray.o - triangle.a;
        let q = s.cross(triangle.e1);
        Homogeneous {
            det: triangle.e1.dot(p),
            t: triangle.e2.dot(q),
            beta: s.dot(p),
            gamma: ray.d.dot(q),
        }
    }
}

trisect_core::methods!(MollerTrumbore);
