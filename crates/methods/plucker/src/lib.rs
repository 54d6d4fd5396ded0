#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Corners, Given, Homogeneous, Method, MethodInfo, Of, Output, RayParts, record,
};

record! {
    /// The Plücker coordinates of the edges, and the plane.
    pub struct PluckerTriangle {
        /// Direction of `AB`.
        ab: vec3,
        /// Moment `A × B`.
        ab_moment: vec3,
        /// Direction of `BC`.
        bc: vec3,
        /// Moment `B × C`.
        bc_moment: vec3,
        /// Direction of `CA`.
        ca: vec3,
        /// Moment `C × A`.
        ca_moment: vec3,
        /// Normal `N = e1 × e2`.
        n: vec3,
        /// `N · A`
        nd: number,
    }
}

/// A ray with its moment.
#[derive(Clone, Copy)]
pub struct PluckerRay<L> {
    o: Vec3<L>,
    d: Vec3<L>,
    /// `O × D`
    moment: Vec3<L>,
}

impl<L: Lanes> RayParts for PluckerRay<L> {
    #[inline(always)]
    fn take_origin(&mut self, from: &Self) {
        self.o = from.o;
    }
    #[inline(always)]
    fn take_direction(&mut self, from: &Self) {
        self.d = from.d;
    }
}

impl<L: Lanes> PluckerRay<L> {
    /// The side operator: on which side the ray passes a line of that direction and moment.
    #[inline(always)]
    fn side(&self, direction: Vec3<L>, moment: Vec3<L>) -> L {
        self.d.dot(moment) + self.moment.dot(direction)
    }
}

/// Plücker coordinates with the six-vector side operator.
pub struct Plucker;

impl Method for Plucker {
    const INFO: MethodInfo = MethodInfo {
        name: "plucker",
        title: "Plücker",
        year: 1997,
        source: "J. Amanatides, K. Choi: Ray Tracing Triangular Meshes. Western Computer Graphics \
                 Symposium, 1997",
        outputs: Output::ALL,
        ..MethodInfo::USUAL
    };
    type Prepared = PluckerTriangle<()>;
    type PreparedRay<L: Lanes> = PluckerRay<L>;
    type Alpha<L: Lanes> = Given<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        let Corners { a, b, c } = Corners::new(triangle);
        let n = triangle.normal();
        PluckerTriangle {
            ab: b - a,
            ab_moment: a.cross(b),
            bc: c - b,
            bc_moment: b.cross(c),
            ca: a - c,
            ca_moment: c.cross(a),
            n,
            nd: n.dot(a),
        }
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> PluckerRay<L> {
        PluckerRay { o: ray.o, d: ray.d, moment: ray.o.cross(ray.d) }
    }

    #[inline(always)]
    fn intersect<L: Lanes>(
        ray: &PluckerRay<L>,
        tri: &PluckerTriangle<L>,
    ) -> Homogeneous<L, Given<L>> {
        let alpha = ray.side(tri.bc, tri.bc_moment);
        let beta = ray.side(tri.ca, tri.ca_moment);
        let gamma = ray.side(tri.ab, tri.ab_moment);
        Homogeneous {
            det: alpha + (beta + gamma),
            t: tri.nd - tri.n.dot(ray.o),
            alpha: Given(alpha),
            beta,
            gamma,
        }
    }

    /// Here `det = D·N`, which is negative at the front.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &PluckerRay<L>, _tri: &PluckerTriangle<L>, det: L) -> L {
        -det
    }

    #[inline(always)]
    fn normal<L: Lanes>(tri: &PluckerTriangle<L>, _group: usize) -> Option<Vec3<L>> {
        Some(tri.n)
    }
}

trisect_method::methods!(Plucker);
