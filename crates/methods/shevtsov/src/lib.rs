#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Frame, Homogeneous, Implied, Method, MethodInfo, Of, Start, Vertex, World, record,
};

record! {
    /// The projected triangle, every number over `n|w`.
    pub struct ScaledTriangle {
        /// `n|u / n|w`
        nu: number,
        /// `n|v / n|w`
        nv: number,
        /// `e1|u / n|w`
        e1u: number,
        /// `e1|v / n|w`
        e1v: number,
        /// `e2|u / n|w`
        e2u: number,
        /// `e2|v / n|w`
        e2v: number,
    }
}

/// Shevtsov–Soupikov–Kapustin 2007, with the plane's constant in frame `F`.
pub struct Shevtsov<F = World>(PhantomData<F>);

impl<F: Frame> Method for Shevtsov<F> {
    const INFO: MethodInfo = MethodInfo {
        name: if F::RELATIVE { "shevtsov-relative" } else { "shevtsov" },
        title: if F::RELATIVE {
            "Shevtsov–Soupikov–Kapustin from a corner"
        } else {
            "Shevtsov–Soupikov–Kapustin"
        },
        year: 2007,
        source: "M. Shevtsov, A. Soupikov, A. Kapustin: Ray-Triangle Intersection Algorithm for \
                 Modern CPU Architectures. GraphiCon, 2007",
        ..MethodInfo::USUAL
    };
    const GROUPS: usize = 3;
    type Prepared = (ScaledTriangle<()>, F::Anchored);
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn group<X: Scalar>(triangle: &Triangle<X>) -> usize {
        triangle.projection_axis()
    }

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, w: usize) -> Of<Self::Prepared, X> {
        let Triangle { a, b, c } = triangle.with_axis_last(w);
        let (e1, e2) = (b - a, c - a);
        let n = e1.cross(e2).map(X::or_nan);
        let [n_scaled, e1, e2] = [n, e1, e2].map(|v| Vec3::new(v.x / n.z, v.y / n.z, v.z));
        let slope = Vec3::new(n_scaled.x, n_scaled.y, X::from_f64(1.0));
        let scaled =
            ScaledTriangle { nu: slope.x, nv: slope.y, e1u: e1.x, e1v: e1.y, e2u: e2.x, e2v: e2.y };
        (scaled, F::anchor(a, slope))
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, w: usize) -> Ray<L> {
        ray.with_axis_last(w)
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, (tri, anchor): &Of<Self::Prepared, L>) -> Homogeneous<L> {
        let slope = Vec3::new(tri.nu, tri.nv, tri.nu.constant(L::Elem::from_f64(1.0)));
        let Start { height: t, u, v } = F::start(anchor, slope, ray.o);
        let det = tri.nu.mul_add(ray.d.x, tri.nv.mul_add(ray.d.y, ray.d.z));
        // The projected point as seen from A, times det.
        let pu = t.mul_sub(ray.d.x, det * u);
        let pv = t.mul_sub(ray.d.y, det * v);
        Homogeneous {
            det,
            t,
            alpha: Implied,
            beta: tri.e2v.mul_sub(pu, tri.e2u * pv),
            gamma: tri.e1u.mul_sub(pv, tri.e1v * pu),
        }
    }

    /// `det` lost the sign of `n|w` with the scale; `e1 × e2`, both over `n|w`, is `1 / n|w`.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, (tri, _): &Of<Self::Prepared, L>, det: L) -> L {
        det * tri.e1v.mul_sub(tri.e2u, tri.e1u * tri.e2v)
    }
}

trisect_method::methods!(Shevtsov<World>, Shevtsov<Vertex>);
