#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{
    Hit, Homogeneous, Lanes, Method, MethodInfo, Of, PlaneFirst, Ray, Scalar, Triangle, Vec3,
    record,
};

record! {
    /// The triangle's plane, and the two planes on which `beta` and `gamma` are linear.
    pub struct PlaneTriangle {
        /// `n · p = nd` on the triangle's plane, `n = e1 × e2`.
        n: vec3,
        /// See `n`.
        nd: number,
        /// `beta = b · p + bd` on the triangle's plane, `b = e2 × n / n²`.
        b: vec3,
        /// See `b`.
        bd: number,
        /// `gamma = c · p + cd` on the triangle's plane, `c = n × e1 / n²`.
        c: vec3,
        /// See `c`.
        cd: number,
    }
}

/// Perpendicular planes, Havel 2008.
pub struct PerpendicularPlanes;

impl PlaneFirst for PerpendicularPlanes {
    #[inline(always)]
    fn plane<L: Lanes>(ray: &Ray<L>, tri: &PlaneTriangle<L>) -> (L, L) {
        (tri.n.dot(ray.d), tri.nd - tri.n.dot(ray.o))
    }

    #[inline(always)]
    fn barycentrics<L: Lanes>(ray: &Ray<L>, tri: &PlaneTriangle<L>, weight: L, t: L) -> (L, L) {
        let p = ray.d.mul_add(t, ray.o.scale(weight));
        let along =
            |v: Vec3<L>, d: L| v.x.mul_add(p.x, v.y.mul_add(p.y, v.z.mul_add(p.z, weight * d)));
        (along(tri.b, tri.bd), along(tri.c, tri.cd))
    }
}

impl Method for PerpendicularPlanes {
    const INFO: MethodInfo = MethodInfo {
        name: "perpendicular-planes",
        title: "Perpendicular planes",
        year: 2008,
        source: "J. Havel: Ray Tracing on Modern Processors. Master's thesis, Brno University of \
                 Technology, 2008, section 3.5",
        outputs: &["hit", "t", "beta", "gamma"],
        error_factor: 64.0,
    };
    type Prepared = PlaneTriangle<()>;
    type PreparedRay<L: Lanes> = Ray<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        let a = triangle.a;
        let (e1, e2) = (triangle.b - a, triangle.c - a);
        let n = e1.cross(e2);
        let squared = n.dot(n);
        let b = e2.cross(n).map(|x| x / squared);
        let c = n.cross(e1).map(|x| x / squared);
        PlaneTriangle { n, nd: n.dot(a), b, bd: -b.dot(a), c, cd: -c.dot(a) }
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, triangle: &PlaneTriangle<L>) -> Homogeneous<L> {
        Self::deferred(ray, triangle)
    }

    /// As published: `t` first, then the point, then `beta` and `gamma`.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        triangle: &PlaneTriangle<L>,
        reciprocal: impl Fn(L) -> L,
    ) -> (L, Hit<L>) {
        Self::early(ray, triangle, reciprocal)
    }

    /// Here `det = D·n`, which is negative at the front.
    #[inline(always)]
    fn facing<L: Lanes>(_triangle: &PlaneTriangle<L>, det: L) -> L {
        -det
    }
}

trisect_core::methods!(PerpendicularPlanes);
