#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::marker::PhantomData;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Claims, Corners, Given, Homogeneous, Input, Method, MethodInfo, Of, Output, RayParts,
};

mod edge;

pub use edge::{EdgeFunction, OnePrecision, TwicePrecision};

/// A ray, its longest axis last, with the shear that turns its direction into that axis.
#[derive(Clone, Copy)]
pub struct ShearedRay<L> {
    o: Vec3<L>,
    /// `Sx = Dx/Dz`, `Sy = Dy/Dz`, `Sz = 1/Dz`
    s: Vec3<L>,
}

impl<L: Lanes> RayParts for ShearedRay<L> {
    #[inline(always)]
    fn take_origin(&mut self, from: &Self) {
        self.o = from.o;
    }
    #[inline(always)]
    fn take_direction(&mut self, from: &Self) {
        self.s = from.s;
    }
}

/// What comes first: the ray's origin to the world's, or its direction to the axis.
pub trait Order: Send + Sync + 'static {
    /// The corners where the ray is the axis `z` from the origin on.
    fn sheared<L: Lanes>(ray: &ShearedRay<L>, corners: [Vec3<L>; 3]) -> [Vec3<L>; 3];
}

#[inline(always)]
fn shear<L: Lanes>(s: Vec3<L>, v: Vec3<L>) -> Vec3<L> {
    Vec3::new((-s.x).mul_add(v.z, v.x), (-s.y).mul_add(v.z, v.y), s.z * v.z)
}

/// Translate, then shear, as published.
pub struct TranslateFirst;

impl Order for TranslateFirst {
    #[inline(always)]
    fn sheared<L: Lanes>(ray: &ShearedRay<L>, corners: [Vec3<L>; 3]) -> [Vec3<L>; 3] {
        let [a, b, c] = corners;
        [shear(ray.s, a - ray.o), shear(ray.s, b - ray.o), shear(ray.s, c - ray.o)]
    }
}

/// Shear, then translate: the sheared triangle is the same for all rays of one direction.
pub struct ShearFirst;

impl Order for ShearFirst {
    #[inline(always)]
    fn sheared<L: Lanes>(ray: &ShearedRay<L>, corners: [Vec3<L>; 3]) -> [Vec3<L>; 3] {
        let o = shear(ray.s, ray.o);
        let [a, b, c] = corners;
        [shear(ray.s, a) - o, shear(ray.s, b) - o, shear(ray.s, c) - o]
    }
}

/// Watertight, Woop, Benthin, Wald 2013: edge functions as `E` computes them, space as `O` moves it.
pub struct Watertight<E = TwicePrecision, O = TranslateFirst>(PhantomData<(E, O)>);

impl<E: EdgeFunction, O: Order> Method for Watertight<E, O>
where
    Self: Named,
{
    const INFO: MethodInfo = MethodInfo {
        name: <Self as Named>::NAME,
        title: <Self as Named>::TITLE,
        year: 2013,
        source: "S. Woop, C. Benthin, I. Wald: Watertight Ray/Triangle Intersection. Journal of \
                 Computer Graphics Techniques 2(1), 2013",
        input: Input::Points,
        outputs: Output::ALL,
        claims: Claims { watertight: true, culls: true, unit_direction: false, exact: false },
        ..MethodInfo::USUAL
    };
    const TURNS: bool = true;
    type Prepared = Corners<()>;
    type PreparedRay<L: Lanes> = ShearedRay<L>;
    type Alpha<L: Lanes> = Given<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        Corners::new(triangle)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> ShearedRay<L> {
        let Vec3 { x, y, z } = ray.d;
        let one = z.constant(L::Elem::from_f64(1.0));
        ShearedRay { o: ray.o, s: Vec3::new(x / z, y / z, one / z) }
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &ShearedRay<L>, corners: &Corners<L>) -> Homogeneous<L, Given<L>> {
        let [a, b, c] = O::sheared(ray, [corners.a, corners.b, corners.c]);
        // Each edge as seen along the ray: the same number, but for its sign, for both neighbours.
        let [u, v, w] = E::edges(a, b, c);
        Homogeneous {
            det: u + v + w,
            t: u.mul_add(a.z, v.mul_add(b.z, w * c.z)),
            alpha: Given(u),
            beta: v,
            gamma: w,
        }
    }

    /// The shear looks along the axis, whichever way the ray goes along it.
    #[inline(always)]
    fn facing<L: Lanes>(ray: &ShearedRay<L>, _corners: &Corners<L>, det: L) -> L {
        det.xor_sign(ray.s.z)
    }

    #[inline(always)]
    fn normal<L: Lanes>(corners: &Corners<L>, _group: usize) -> Option<Vec3<L>> {
        Some(corners.normal())
    }
}

/// A variant and its name.
pub trait Named {
    /// Name as typed on the command line.
    const NAME: &'static str;
    /// Name in prose.
    const TITLE: &'static str;
}

impl Named for Watertight {
    const NAME: &'static str = "watertight";
    const TITLE: &'static str = "Watertight";
}

impl Named for Watertight<OnePrecision> {
    const NAME: &'static str = "watertight-one-precision";
    const TITLE: &'static str = "Watertight in one precision";
}

impl Named for Watertight<OnePrecision, ShearFirst> {
    const NAME: &'static str = "watertight-packet";
    const TITLE: &'static str = "Watertight, sheared per packet";
}

trisect_method::methods!(
    Watertight,
    Watertight<OnePrecision>,
    Watertight<OnePrecision, ShearFirst>,
);
