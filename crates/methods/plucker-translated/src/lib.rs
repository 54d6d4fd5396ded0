#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{Alpha, Corners, Given, Homogeneous, Input, Method, MethodInfo, Of, Output};

/// What counts as inside.
pub trait Tolerance: Send + Sync + 'static {
    /// Whether weights may be a little negative.
    const TOLERANT: bool;
    /// The weight of `A`, with the test.
    type Alpha<L: Lanes>: Alpha<L>;
    /// The weight with the test.
    fn alpha<L: Lanes>(alpha: L) -> Self::Alpha<L>;
}

/// No weight may be negative.
pub struct Exactly;

impl Tolerance for Exactly {
    const TOLERANT: bool = false;
    type Alpha<L: Lanes> = Given<L>;
    #[inline(always)]
    fn alpha<L: Lanes>(alpha: L) -> Given<L> {
        Given(alpha)
    }
}

/// Weights may be negative by one unit in the last place of their sum, as ray tracers have it.
pub struct UnitInTheLastPlace;

/// The weight of `A`, tested with a tolerance.
#[derive(Clone, Copy)]
pub struct Tolerant<L>(L);

impl<L: Lanes> Alpha<L> for Tolerant<L> {
    #[inline(always)]
    fn scale(self, factor: L) -> Self {
        Self(self.0 * factor)
    }
    #[inline(always)]
    fn xor_sign(self, s: L) -> Self {
        Self(self.0.xor_sign(s))
    }
    #[inline(always)]
    fn weight(self, _beta: L, _gamma: L, _whole: L) -> L {
        self.0
    }
    #[inline(always)]
    fn inside(self, beta: L, gamma: L, whole: L) -> L::Mask {
        let ulp = L::Elem::unit_roundoff() + L::Elem::unit_roundoff();
        let least = -(whole * whole.constant(ulp));
        self.0.ge(least) & beta.ge(least) & gamma.ge(least)
    }
}

impl Tolerance for UnitInTheLastPlace {
    const TOLERANT: bool = true;
    type Alpha<L: Lanes> = Tolerant<L>;
    #[inline(always)]
    fn alpha<L: Lanes>(alpha: L) -> Tolerant<L> {
        Tolerant(alpha)
    }
}

/// Twice the volume that a direction spans with an edge. The same edge met from its other end gives
/// the same number with the other sign, to the bit.
#[inline(always)]
fn side<L: Lanes>(d: Vec3<L>, from: Vec3<L>, to: Vec3<L>) -> L {
    d.dot((to - from).cross(to + from))
}

/// Plücker coordinates with the origin at the ray's, as ray tracers use them.
pub struct PluckerTranslated<T = Exactly>(PhantomData<T>);

impl<T: Tolerance> Method for PluckerTranslated<T> {
    const INFO: MethodInfo = MethodInfo {
        name: if T::TOLERANT { "plucker-tolerance" } else { "plucker-translated" },
        title: if T::TOLERANT {
            "Plücker from the ray, with tolerance"
        } else {
            "Plücker from the ray"
        },
        year: 2014,
        source: "I. Wald, S. Woop, C. Benthin, G. S. Johnson, M. Ernst: Embree: A Kernel Framework \
                 for Efficient CPU Ray Tracing. ACM Transactions on Graphics 33(4), 2014",
        input: Input::Points,
        outputs: Output::ALL,
        ..MethodInfo::USUAL
    };
    type Prepared = Corners<()>;
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = T::Alpha<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        Corners::new(triangle)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, corners: &Corners<L>) -> Homogeneous<L, T::Alpha<L>> {
        let (a, b, c) = (corners.a - ray.o, corners.b - ray.o, corners.c - ray.o);
        let alpha = side(ray.d, c, b);
        let beta = side(ray.d, a, c);
        let gamma = side(ray.d, b, a);
        let height = a.dot((b - a).cross(c - a));
        Homogeneous {
            det: alpha + (beta + gamma),
            t: height + height,
            alpha: T::alpha(alpha),
            beta,
            gamma,
        }
    }

    /// Here `det = 2·D·N`, which is negative at the front.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, _triangle: &Of<Self::Prepared, L>, det: L) -> L {
        -det
    }

    #[inline(always)]
    fn normal<L: Lanes>(corners: &Corners<L>, _group: usize) -> Option<Vec3<L>> {
        Some(corners.normal())
    }
}

trisect_method::methods!(PluckerTranslated, PluckerTranslated<UnitInTheLastPlace>);
