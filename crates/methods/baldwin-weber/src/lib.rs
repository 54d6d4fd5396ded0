#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Frame, Function, Homogeneous, Implied, MappedRay, Method, MethodInfo, Of, Quotients, Slopes,
    Vertex, World, record,
};

record! {
    /// What differs from triangle to triangle of the slopes, the axes being in the order `u, v, w`.
    pub struct ShortSlopes {
        /// `n|u / n|w`
        nu: number,
        /// `n|v / n|w`
        nv: number,
        /// `e2|v / n|w`
        bu: number,
        /// `−e2|u / n|w`
        bv: number,
        /// `−e1|v / n|w`
        cu: number,
        /// `e1|u / n|w`
        cv: number,
    }
}

/// The slopes of a triangle mapped to the unit triangle with the unit vector along its axis `w` for
/// a third side, in the order `u, v, w`; NaN for a triangle without area.
#[inline(always)]
fn slopes<X: Scalar>(triangle: &Triangle<X>, w: usize) -> Slopes<X> {
    let Triangle { a, b, c } = triangle.with_axis_last(w);
    let (e1, e2) = (b - a, c - a);
    let n = e1.cross(e2).map(X::or_nan);
    let [zero, one] = [0.0, 1.0].map(X::from_f64);
    Slopes {
        plane: Vec3::new(n.x / n.z, n.y / n.z, one),
        beta: Vec3::new(e2.y / n.z, -e2.x / n.z, zero),
        gamma: Vec3::new(-e1.y / n.z, e1.x / n.z, zero),
    }
}

const INFO: MethodInfo = MethodInfo {
    year: 2016,
    source: "D. Baldwin, M. Weber: Fast Ray-Triangle Intersections by Coordinate Transformation. \
             Journal of Computer Graphics Techniques 5(3), 2016",
    ..MethodInfo::USUAL
};

/// Baldwin–Weber 2016 with 12 numbers: the whole map, constants in frame `F`.
pub struct BaldwinWeber12<F = World>(PhantomData<F>);

impl<F: Frame> Method for BaldwinWeber12<F> {
    const INFO: MethodInfo = MethodInfo {
        name: if F::RELATIVE { "baldwin-weber-12-relative" } else { "baldwin-weber-12" },
        title: if F::RELATIVE {
            "Baldwin–Weber, 12 numbers, from a corner"
        } else {
            "Baldwin–Weber, 12 numbers"
        },
        ..INFO
    };
    type Prepared = (Slopes<()>, F::Stored);
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        let w = triangle.projection_axis();
        let Slopes { plane, beta, gamma } = slopes(triangle, w);
        let [plane, beta, gamma] = [plane, beta, gamma].map(|v| v.with_axis_restored(w));
        (Slopes { plane, beta, gamma }, F::store(triangle.a, [plane, beta, gamma]))
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, map: &Of<Self::Prepared, L>) -> Homogeneous<L> {
        MappedRay::new::<F>(ray, map).deferred()
    }

    /// As published: `t` first.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        map: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L> {
        MappedRay::new::<F>(ray, map).early(reciprocal)
    }

    /// `det = D·N / N|w` lost the sign of `N|w`; the slopes' product, `1 / N|w`, brings it back.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, (slopes, _): &Of<Self::Prepared, L>, det: L) -> L {
        -det * slopes.plane.dot(slopes.beta.cross(slopes.gamma))
    }
}

/// Baldwin–Weber 2016 with 9 numbers: without the third column, which is a unit vector; triangles
/// sorted by it. Constants in frame `F`.
pub struct BaldwinWeber9<F = World>(PhantomData<F>);

/// The ray as the unit triangle sees it; the axes are in the triangle's order.
#[inline(always)]
fn map_short<F: Frame, L: Lanes>(
    ray: &Ray<L>,
    (slopes, stored): &(ShortSlopes<L>, Of<F::Stored, L>),
) -> MappedRay<L> {
    let ShortSlopes { nu, nv, bu, bv, cu, cv } = *slopes;
    let one = ray.tmin.constant(L::Elem::from_f64(1.0));
    let (o, d) = (F::relative(stored, ray.o), ray.d);
    let height = F::plus(stored, Function::Plane, o.z);
    MappedRay {
        o: [
            nu.mul_add(o.x, nv.mul_add(o.y, height)),
            bu.mul_add(o.x, F::last(stored, Function::Beta, bv, o.y, one)),
            cu.mul_add(o.x, F::last(stored, Function::Gamma, cv, o.y, one)),
        ],
        d: [
            nu.mul_add(d.x, nv.mul_add(d.y, d.z)),
            bu.mul_add(d.x, bv * d.y),
            cu.mul_add(d.x, cv * d.y),
        ],
    }
}

impl<F: Frame> Method for BaldwinWeber9<F> {
    const INFO: MethodInfo = MethodInfo {
        name: if F::RELATIVE { "baldwin-weber-9-relative" } else { "baldwin-weber-9" },
        title: if F::RELATIVE {
            "Baldwin–Weber, 9 numbers, from a corner"
        } else {
            "Baldwin–Weber, 9 numbers"
        },
        ..INFO
    };
    const GROUPS: usize = 3;
    type Prepared = (ShortSlopes<()>, F::Stored);
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn group<X: Scalar>(triangle: &Triangle<X>) -> usize {
        triangle.projection_axis()
    }

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, w: usize) -> Of<Self::Prepared, X> {
        let slopes = slopes(triangle, w);
        let Slopes { plane, beta, gamma } = slopes;
        let short = ShortSlopes {
            nu: plane.x,
            nv: plane.y,
            bu: beta.x,
            bv: beta.y,
            cu: gamma.x,
            cv: gamma.y,
        };
        (short, F::store(triangle.a.with_axis_last(w), slopes.to_array()))
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, w: usize) -> Ray<L> {
        ray.with_axis_last(w)
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, map: &Of<Self::Prepared, L>) -> Homogeneous<L> {
        map_short::<F, L>(ray, map).deferred()
    }

    /// As published: `t` first.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        map: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L> {
        map_short::<F, L>(ray, map).early(reciprocal)
    }

    /// As for 12 numbers.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, (s, _): &Of<Self::Prepared, L>, det: L) -> L {
        det * s.bv.mul_sub(s.cu, s.bu * s.cv)
    }
}

trisect_method::methods!(
    BaldwinWeber9,
    BaldwinWeber12,
    BaldwinWeber9<Vertex>,
    BaldwinWeber12<Vertex>,
);
