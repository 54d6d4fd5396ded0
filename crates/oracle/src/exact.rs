//! The exact path: coordinates scaled to integers, and integer arithmetic from there on.

use core::cmp::Ordering;
use core::ops::{Add, Mul, Sub};

use dashu_base::{Abs, Sign, UnsignedAbs};
use dashu_int::IBig;
use dashu_ratio::{RBig, Relaxed};
use trisect_core::{Float, Ray, Triangle, Vec3, decode};
use trisect_method::Interval;

use crate::Condition;
use crate::class::Class;

/// Finite floats as integers times one common power of two.
struct Scaled<const N: usize> {
    parts: [(i64, i32); N],
    exponent: i32,
    /// Bits of the largest magnitude among the integers.
    bits: i32,
}

impl<const N: usize> Scaled<N> {
    fn new(xs: [f64; N]) -> Self {
        let parts = xs.map(decode);
        let nonzero = || parts.iter().filter(|(mantissa, _)| *mantissa != 0);
        let exponent = nonzero().map(|(_, exponent)| *exponent).min().unwrap_or(0);
        let bits = nonzero()
            .map(|(mantissa, e)| {
                (u64::BITS - mantissa.unsigned_abs().leading_zeros()).cast_signed() + e - exponent
            })
            .max()
            .unwrap_or(0);
        Self { parts, exponent, bits }
    }

    /// The integers, given a left shift of the integer type.
    fn integers<I: From<i64>>(&self, shift: impl Fn(I, usize) -> I) -> [I; N] {
        self.parts.each_ref().map(|&(mantissa, exponent)| {
            if mantissa == 0 {
                I::from(0)
            } else {
                shift(I::from(mantissa), (exponent - self.exponent).unsigned_abs() as usize)
            }
        })
    }
}

/// Integer arithmetic by reference, which i128 and big integers share.
trait Integer:
    Sized + for<'a> Add<&'a Self, Output = Self> + for<'a> Sub<&'a Self, Output = Self>
where
    for<'a> &'a Self: Mul<&'a Self, Output = Self> + Sub<&'a Self, Output = Self>,
{
}
impl Integer for i128 {}
impl Integer for IBig {}

/// The differences that every volume is made of.
struct Edges<I> {
    d: Vec3<I>,
    e1: Vec3<I>,
    e2: Vec3<I>,
    s: Vec3<I>,
}

fn difference<I: Integer>(a: &Vec3<I>, b: &Vec3<I>) -> Vec3<I>
where
    for<'a> &'a I: Mul<&'a I, Output = I> + Sub<&'a I, Output = I>,
{
    Vec3::new(&a.x - &b.x, &a.y - &b.y, &a.z - &b.z)
}

fn cross<I: Integer>(a: &Vec3<I>, b: &Vec3<I>) -> Vec3<I>
where
    for<'a> &'a I: Mul<&'a I, Output = I> + Sub<&'a I, Output = I>,
{
    Vec3::new(
        &a.y * &b.z - &(&a.z * &b.y),
        &a.z * &b.x - &(&a.x * &b.z),
        &a.x * &b.y - &(&a.y * &b.x),
    )
}

fn permanent_cross<I: Integer>(a: &Vec3<I>, b: &Vec3<I>) -> Vec3<I>
where
    for<'a> &'a I: Mul<&'a I, Output = I> + Sub<&'a I, Output = I>,
{
    Vec3::new(
        &a.y * &b.z + &(&a.z * &b.y),
        &a.z * &b.x + &(&a.x * &b.z),
        &a.x * &b.y + &(&a.y * &b.x),
    )
}

fn dot<I: Integer>(a: &Vec3<I>, b: &Vec3<I>) -> I
where
    for<'a> &'a I: Mul<&'a I, Output = I> + Sub<&'a I, Output = I>,
{
    &a.x * &b.x + &(&a.y * &b.y) + &(&a.z * &b.z)
}

impl<I: Integer> Edges<I>
where
    for<'a> &'a I: Mul<&'a I, Output = I> + Sub<&'a I, Output = I>,
{
    /// From the coordinates of O, A, B, C in turn, and of D.
    fn new(points: [I; 12], d: [I; 3]) -> Self {
        let [ox, oy, oz, ax, ay, az, bx, by, bz, cx, cy, cz] = points;
        let (o, a) = (Vec3::new(ox, oy, oz), Vec3::new(ax, ay, az));
        let (b, c) = (Vec3::new(bx, by, bz), Vec3::new(cx, cy, cz));
        Self { d: d.into(), e1: difference(&b, &a), e2: difference(&c, &a), s: difference(&o, &a) }
    }

    /// `det`, `U`, `V`, `T` with a given vector product.
    fn volumes(&self, cross: impl Fn(&Vec3<I>, &Vec3<I>) -> Vec3<I>) -> [I; 4] {
        let (p, q) = (cross(&self.d, &self.e2), cross(&self.s, &self.e1));
        [dot(&self.e1, &p), dot(&self.s, &p), dot(&self.d, &q), dot(&self.e2, &q)]
    }

    fn has_area(&self, zero: &I) -> bool
    where
        I: PartialEq,
    {
        let n = cross(&self.e1, &self.e2);
        n.x != *zero || n.y != *zero || n.z != *zero
    }
}

/// Whether every coordinate is finite and no end of the interval is NaN.
fn is_finite<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> bool {
    let finite = |v: Vec3<E>| v.to_array().into_iter().all(|x| x.to_f64().is_finite());
    finite(ray.o)
        && finite(ray.d)
        && triangle.corners().into_iter().all(finite)
        && !ray.tmin.to_f64().is_nan()
        && !ray.tmax.to_f64().is_nan()
}

/// A ray and a triangle as integers, with `det ≥ 0`: `beta = U/det`, `gamma = V/det`,
/// `t = T/det · 2^shift`.
pub(crate) struct Volumes {
    det: IBig,
    u: IBig,
    v: IBig,
    t: IBig,
    shift: i32,
    has_area: bool,
    points: Scaled<12>,
    direction: Scaled<3>,
}

/// `x · 2^shift`, as a factor of the side that stays an integer: `(x', y')` with
/// `x'/y' = x/y · 2^shift`.
fn shifted(x: IBig, y: IBig, shift: i32) -> (IBig, IBig) {
    let places = shift.unsigned_abs() as usize;
    if shift >= 0 { (x << places, y) } else { (x, y << places) }
}

impl Volumes {
    /// `None` for NaN anywhere, or an infinity among the coordinates.
    pub(crate) fn new<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> Option<Self> {
        if !is_finite(ray, triangle) {
            return None;
        }
        let [o, d] = [ray.o, ray.d].map(|v| v.map(E::to_f64));
        let [a, b, c] = triangle.corners().map(|v| v.map(E::to_f64));
        let points = Scaled::new([o.x, o.y, o.z, a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z]);
        let direction = Scaled::new([d.x, d.y, d.z]);
        // A volume sums six products of three differences, one bit longer than the points: below
        // 2^(3·bits + 6) for T. So 40 bits fit in i128, where most scenes of f32 end up.
        let ([det, u, v, t], has_area) = if points.bits <= 40 && direction.bits <= 40 {
            let shift = |x: i128, places| x << places;
            let edges = Edges::new(points.integers(shift), direction.integers(shift));
            let volumes = edges.volumes(cross);
            (volumes.map(IBig::from), volumes[0] != 0 || edges.has_area(&0))
        } else {
            let edges = big_edges(&points, &direction);
            let volumes = edges.volumes(cross);
            let has_area = !volumes[0].is_zero() || edges.has_area(&IBig::ZERO);
            (volumes, has_area)
        };
        let shift = points.exponent - direction.exponent;
        let orient = |x: IBig| if det.sign() == Sign::Negative { -x } else { x };
        let [u, v, t] = [u, v, t].map(orient);
        Some(Self { det: det.abs(), u, v, t, shift, has_area, points, direction })
    }

    /// The order of `t` and a float that is not NaN.
    fn compare(&self, tau: f64) -> Ordering {
        if tau.is_infinite() {
            return if tau > 0.0 { Ordering::Less } else { Ordering::Greater };
        }
        let (mantissa, exponent) = decode(tau);
        let bound = &self.det * IBig::from(mantissa);
        let (t, bound) = shifted(self.t.clone(), bound, self.shift - exponent);
        t.cmp(&bound)
    }

    /// The class within the interval of the contract.
    pub(crate) fn class<E: Float>(&self, ray: &Ray<E>) -> Class {
        if !self.has_area {
            return Class::Degenerate;
        }
        if self.det.is_zero() {
            return Class::Coplanar;
        }
        let w = &self.det - &self.u - &self.v;
        let weights = [&self.u, &self.v, &w];
        if weights.iter().any(|x| x.sign() == Sign::Negative) {
            return Class::Miss;
        }
        let Interval { tmin, tmax } = Interval::new(ray.tmin, ray.tmax);
        if self.compare(tmin.to_f64()) == Ordering::Less
            || self.compare(tmax.to_f64()) == Ordering::Greater
        {
            return Class::OutOfInterval;
        }
        Class::hit(weights.iter().filter(|x| x.is_zero()).count())
    }

    /// `t`, `beta`, `gamma` as quotients with positive denominators, or `None` when `det = 0`.
    fn quotients(&self) -> Option<[(IBig, IBig); 3]> {
        (!self.det.is_zero()).then(|| {
            [
                shifted(self.t.clone(), self.det.clone(), self.shift),
                (self.u.clone(), self.det.clone()),
                (self.v.clone(), self.det.clone()),
            ]
        })
    }

    /// `t`, `beta`, `gamma`, or `None` when `det = 0`.
    pub(crate) fn rationals(&self) -> Option<[RBig; 3]> {
        Some(self.quotients()?.map(|(x, y)| RBig::from_parts(x, y.unsigned_abs())))
    }

    /// `t`, `beta`, `gamma`, each rounded once to the nearest, or `None` when `det = 0`.
    pub(crate) fn values<E: Float>(&self) -> Option<[E; 3]> {
        Some(self.quotients()?.map(|(x, y)| nearest(x, y)))
    }

    /// An interval of f64 that holds `t`, or `None` when `det = 0`.
    pub(crate) fn t_interval(&self) -> Option<[f64; 2]> {
        let [(x, y), _, _] = self.quotients()?;
        let t: f64 = nearest(x, y);
        Some([t.next_down(), t.next_up()])
    }

    /// The order of the `t` of two triangles on one ray, or `None` when a `det` is zero.
    pub(crate) fn order(&self, other: &Self) -> Option<Ordering> {
        if self.det.is_zero() || other.det.is_zero() {
            return None;
        }
        let (x, y) = shifted(&self.t * &other.det, &other.t * &self.det, self.shift - other.shift);
        Some(x.cmp(&y))
    }

    /// The condition numbers, or NaN when `det = 0`.
    pub(crate) fn condition(&self) -> Condition {
        if self.det.is_zero() {
            return Condition::NAN;
        }
        let mut edges = big_edges(&self.points, &self.direction);
        for v in [&mut edges.d, &mut edges.e1, &mut edges.e2, &mut edges.s] {
            for x in [&mut v.x, &mut v.y, &mut v.z] {
                *x = core::mem::take(x).abs();
            }
        }
        let [det_permanent, u, v, t] = edges.volumes(permanent_cross);
        let square = &self.det * &self.det;
        let of = |permanent: IBig, x: &IBig, shift| {
            let numerator = permanent * &self.det + x.clone().abs() * &det_permanent;
            let (x, y) = shifted(numerator, square.clone(), shift);
            nearest(x, y)
        };
        Condition {
            t: of(t, &self.t, self.shift),
            beta: of(u, &self.u, 0),
            gamma: of(v, &self.v, 0),
        }
    }
}

fn big_edges(points: &Scaled<12>, direction: &Scaled<3>) -> Edges<IBig> {
    let shift = |x: IBig, places| x << places;
    Edges::new(points.integers(shift), direction.integers(shift))
}

/// `x/y` rounded once to the nearest number of `E`, ties to even, for `y > 0`.
fn nearest<E: Float>(x: IBig, y: IBig) -> E {
    // Not reduced to lowest terms: that would cost far more than the division.
    let quotient = Relaxed::from_parts(x, y.unsigned_abs());
    if E::UNIT_ROUNDOFF > f64::EPSILON {
        // Exact: the number is one of f32 already.
        E::from_f64(f64::from(quotient.to_f32().value()))
    } else {
        E::from_f64(quotient.to_f64().value())
    }
}
