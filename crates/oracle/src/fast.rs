//! The certified fast path: f64 arithmetic with proven error bounds.
//!
//! Notation: `u = 2⁻⁵³`, `γₙ = nu/(1 − nu)`; a hat marks a computed number. With `e1 = B − A`,
//! `e2 = C − A`, `s = O − A` the four volumes of Möller and Trumbore are
//!
//! ```text
//! det = e1·(D×e2)    U = s·(D×e2)    V = D·(s×e1)    T = e2·(s×e1)
//! ```
//!
//! and `t = T/det`, `beta = U/det`, `gamma = V/det`. Each is a sum of six products of three
//! factors. Along the longest path one such product takes a rounding for each difference among
//! its factors (two in `det`, `U` and `V`, three in `T`), two for the multiplications, one for
//! the subtraction in the vector product and two for the sums in the scalar product: seven in
//! all, eight in `T`. So, with `P_x` the same sum with every factor and term made absolute (the
//! permanent),
//!
//! ```text
//! |det̂ − det| ≤ γ₇·P_det   |Û − U| ≤ γ₇·P_U   |V̂ − V| ≤ γ₇·P_V   |T̂ − T| ≤ γ₈·P_T
//! ```
//!
//! The permanent is itself computed, with a relative error of at most `γ₈`; a count of one more
//! rounding, 8u and 9u, covers that and the rounding of the bound, as
//! `γ₈/(1 − γ₈)·(1 + u)² < 9u`. Derived values cost more: `W = det − U − V` adds its own two
//! subtractions, `T − τ·det` a multiplication and a subtraction; ten roundings in units of the
//! sum of the permanents cover each.
//!
//! The count holds where nothing underflows or overflows, so the path is taken only in
//! [`RANGE`], where no product of three differences does; f32 never leaves it. There a bound of
//! exactly zero means that all six products are zero, so that the value is exactly zero too.

use core::cmp::Ordering;
use core::ops::RangeInclusive;

use trisect_core::{Float, Ray, Triangle, Vec3};
use trisect_method::Interval;

use crate::Condition;
use crate::class::Class;

/// The unit roundoff of f64.
pub(crate) const UNIT: f64 = f64::EPSILON / 2.0;

/// Where the magnitude of an f64 must lie, unless it is zero, for the bounds to hold.
///
/// A difference of two such numbers is zero or at least `2⁻¹⁹²`, a volume, certified non-zero,
/// at least `2⁻⁵⁷⁶` and at most `2⁴²⁷`: quotients of volumes stay normal. Numbers of f32 are
/// multiples of `2⁻¹⁴⁹` below `2¹²⁸`, and their volumes multiples of `2⁻⁴⁴⁷` below `2³⁹⁰`.
const RANGE: RangeInclusive<f64> =
    f64::from_bits((1023 - 140) << 52)..=f64::from_bits((1023 + 140) << 52);

/// Relative error below which a value counts as certified: half of it for each of the two
/// volumes, with room for the rounding of the quotient.
const CERTIFIED: f64 = 1.0 / (1_u64 << 32) as f64;

/// Whether the bounds hold for inputs of these values.
#[inline(always)]
fn in_range<E: Float, const N: usize>(xs: [f64; N]) -> bool {
    E::UNIT_ROUNDOFF > UNIT || xs.into_iter().all(|x| x == 0.0 || RANGE.contains(&x.abs()))
}

/// The larger; `b` when either is NaN. One instruction, where `f64::max` is several.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn norm(v: Vec3<f64>) -> f64 {
    larger(v.x.abs(), larger(v.y.abs(), v.z.abs()))
}

/// The vector product with absolute factors and terms.
#[inline(always)]
fn permanent_cross(a: Vec3<f64>, b: Vec3<f64>) -> Vec3<f64> {
    Vec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)
}

/// The sign of a number known up to `error`; `None` when it is not certain.
///
/// NaN in either makes every comparison false, hence `None`.
#[inline(always)]
fn sign(x: f64, error: f64) -> Option<Ordering> {
    if x > error {
        Some(Ordering::Greater)
    } else if x < -error {
        Some(Ordering::Less)
    } else if x == 0.0 && error == 0.0 {
        Some(Ordering::Equal)
    } else {
        None
    }
}

/// An end of an interval of the contract, as far as the bounds ask. Of f64 no `t` that they hold for is beyond
/// 2¹⁰⁰³, so an end that was brought within half the largest number is as good as infinite: it compares
/// without a product, which would leave [`RANGE`].
#[inline(always)]
fn far_end<E: Float>(tau: E) -> f64 {
    let (tau, end) = (tau.to_f64(), E::largest_t().to_f64());
    if E::UNIT_ROUNDOFF <= UNIT && tau.abs() >= end { f64::INFINITY.copysign(tau) } else { tau }
}

/// A ray widened to f64, once for many triangles; its interval is that of the contract.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FastRay {
    pub(crate) o: Vec3<f64>,
    pub(crate) d: Vec3<f64>,
    pub(crate) tmin: f64,
    pub(crate) tmax: f64,
    d_norm: f64,
    usable: bool,
}

impl FastRay {
    #[inline(always)]
    pub(crate) fn new<E: Float>(ray: &Ray<E>) -> Self {
        let o = ray.o.map(E::to_f64);
        let d = ray.d.map(E::to_f64);
        let Interval { tmin, tmax } = Interval::new(ray.tmin, ray.tmax);
        let (tmin, tmax) = (far_end::<E>(tmin), far_end::<E>(tmax));
        let finite = |t: f64| if t.is_infinite() { 0.0 } else { t };
        let usable = !tmin.is_nan()
            && !tmax.is_nan()
            && in_range::<E, 8>([o.x, o.y, o.z, d.x, d.y, d.z, finite(tmin), finite(tmax)]);
        Self { o, d, tmin, tmax, d_norm: norm(d), usable }
    }
}

/// Widens a triangle; `None` where the bounds do not hold.
#[inline(always)]
fn corners<E: Float>(ray: &FastRay, triangle: &Triangle<E>) -> Option<[Vec3<f64>; 3]> {
    let [a, b, c] = triangle.corners().map(|v| v.map(E::to_f64));
    let usable = ray.usable && in_range::<E, 9>([a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z]);
    usable.then_some([a, b, c])
}

/// Whether `triangle` is certain to be no hit with `t` in `[tmin, limit]`, for a `limit` at most
/// `tmax`. Quick and blunt: `false` says nothing.
///
/// The permanents are replaced by six times the product of the largest coordinates, which makes
/// the eight, nine and ten roundings 48, 54 and 60; two more cover the products of the bounds.
#[inline(always)]
pub(crate) fn rejects<E: Float>(
    ray: &FastRay,
    triangle: &Triangle<E>,
    limit: f64,
    unit: f64,
) -> bool {
    let Some([a, b, c]) = corners(ray, triangle) else { return false };
    let (e1, e2, s) = (b - a, c - a, ray.o - a);
    let (e1_norm, e2_norm, s_norm) = (norm(e1), norm(e2), norm(s));

    let p = ray.d.cross(e2);
    let det = e1.dot(p);
    let det_size = ray.d_norm * e1_norm * e2_norm;
    // A sign of det that is not certain certifies nothing below, nor does NaN.
    if det.abs() <= 50.0 * unit * det_size || det.is_nan() {
        return false;
    }
    // After this every volume has the sign of its quotient.
    let orientation = f64::copysign(1.0, det);
    let det = det.abs();

    let u = s.dot(p) * orientation;
    let u_size = s_norm * ray.d_norm * e2_norm;
    // A certain det means finite D, A, B and C. An origin that is not leaves NaN, or an infinite
    // bound, and so a false comparison in each of the following.
    if u < -50.0 * unit * u_size {
        return true;
    }
    let q = s.cross(e1);
    let v = ray.d.dot(q) * orientation;
    let v_size = ray.d_norm * s_norm * e1_norm;
    let w = det - u - v;
    if v < -50.0 * unit * v_size || w < -62.0 * unit * (det_size + u_size + v_size) {
        return true;
    }
    let t = e2.dot(q) * orientation;
    let t_size = e2_norm * s_norm * e1_norm;
    let past = |tau: f64| (t - tau * det, 62.0 * unit * (t_size + tau.abs() * det_size));
    let (below, below_error) = past(ray.tmin);
    let (above, above_error) = past(limit);
    below < -below_error || above > above_error
}

/// `limit` for [`rejects`] from an upper bound of `t`: the bound where its products cannot
/// underflow or overflow, else none.
#[inline]
pub(crate) fn usable_limit(t: f64) -> f64 {
    if RANGE.contains(&t.abs()) || t == 0.0 { t } else { f64::INFINITY }
}

/// The four volumes with their error bounds, `det ≥ 0`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    det: f64,
    u: f64,
    v: f64,
    t: f64,
    det_permanent: f64,
    u_permanent: f64,
    v_permanent: f64,
    t_permanent: f64,
    unit: f64,
    /// Whether the triangle is certain to have an area, if that was asked.
    has_area: bool,
}

impl Estimate {
    /// `None` where the bounds do not hold. `unit` is the unit roundoff, or less in tests that
    /// show what the bound is worth.
    #[inline(always)]
    pub(crate) fn new<E: Float>(ray: &FastRay, triangle: &Triangle<E>, unit: f64) -> Option<Self> {
        let [a, b, c] = corners(ray, triangle)?;
        let (d, e1, e2, s) = (ray.d, b - a, c - a, ray.o - a);
        let (p, q) = (d.cross(e2), s.cross(e1));
        let [d_abs, e1_abs, e2_abs, s_abs] = [d, e1, e2, s].map(|x| x.map(f64::abs));
        let (p_abs, q_abs) = (permanent_cross(d_abs, e2_abs), permanent_cross(s_abs, e1_abs));
        let det = e1.dot(p);
        let orientation = f64::copysign(1.0, det);
        let det_permanent = e1_abs.dot(p_abs);
        // Parallel to an axis plane: the one way for det to be certainly zero, and common.
        let has_area = det_permanent == 0.0 && {
            let n = e1.cross(e2);
            let size = permanent_cross(e1_abs, e2_abs);
            [(n.x, size.x), (n.y, size.y), (n.z, size.z)]
                .into_iter()
                .any(|(n, size)| n.abs() > 5.0 * unit * size)
        };
        Some(Self {
            det: det.abs(),
            u: s.dot(p) * orientation,
            v: d.dot(q) * orientation,
            t: e2.dot(q) * orientation,
            det_permanent,
            u_permanent: s_abs.dot(p_abs),
            v_permanent: d_abs.dot(q_abs),
            t_permanent: e2_abs.dot(q_abs),
            unit,
            has_area,
        })
    }

    #[inline(always)]
    fn det_error(&self) -> f64 {
        8.0 * self.unit * self.det_permanent
    }

    /// The sign of `t − tau`.
    #[inline(always)]
    fn compare(&self, tau: f64) -> Option<Ordering> {
        if tau.is_infinite() {
            return Some(if tau > 0.0 { Ordering::Less } else { Ordering::Greater });
        }
        let error = 10.0 * self.unit * (self.t_permanent + tau.abs() * self.det_permanent);
        sign(self.t - tau * self.det, error)
    }

    /// The class, or `None` when a sign is not certain.
    #[inline(always)]
    pub(crate) fn class(&self, ray: &FastRay) -> Option<Class> {
        match sign(self.det, self.det_error())? {
            // NaN and infinities never come here: they leave det NaN or its permanent infinite,
            // or, from the origin, do so to the permanents of U, V and T.
            Ordering::Equal => {
                let finite = self.u_permanent.is_finite() && self.t_permanent.is_finite();
                return (self.has_area && finite).then_some(Class::Coplanar);
            }
            // det was made positive, up to its error.
            Ordering::Less => return None,
            Ordering::Greater => {}
        }
        let w = self.det - self.u - self.v;
        let w_size = self.det_permanent + self.u_permanent + self.v_permanent;
        let signs = [
            sign(self.u, 8.0 * self.unit * self.u_permanent),
            sign(self.v, 8.0 * self.unit * self.v_permanent),
            sign(w, 10.0 * self.unit * w_size),
        ];
        if signs.contains(&Some(Ordering::Less)) {
            return Some(Class::Miss);
        }
        let mut zeros = 0;
        for sign in signs {
            zeros += usize::from(sign? == Ordering::Equal);
        }
        if self.compare(ray.tmin)? == Ordering::Less || self.compare(ray.tmax)? == Ordering::Greater
        {
            return Some(Class::OutOfInterval);
        }
        Some(Class::hit(zeros))
    }

    /// `numerator/det` and a bound of its relative error, for a numerator known up to `error`;
    /// `None` when the bound is above 2⁻³⁰ or so.
    ///
    /// With relative errors `a` of the numerator and `b` of det, both at most 2⁻³², the true
    /// quotient lies within a factor `1 ± (a + b)(1 + 2⁻³⁰)` of the quotient of the computed ones,
    /// and that within `1 ± u` of the computed quotient; 4u covers this and what is computed from it.
    #[inline(always)]
    fn quotient(&self, numerator: f64, error: f64) -> Option<(f64, f64)> {
        if error == 0.0 && numerator == 0.0 {
            return Some((0.0, 0.0));
        }
        let a = error / numerator.abs();
        let b = self.det_error() / self.det;
        (a <= CERTIFIED && b <= CERTIFIED)
            .then(|| (numerator / self.det, (a + b) * (1.0 + CERTIFIED * 8.0) + 4.0 * UNIT))
    }

    #[inline(always)]
    fn t(&self) -> Option<(f64, f64)> {
        self.quotient(self.t, 9.0 * self.unit * self.t_permanent)
    }

    /// `t`, `beta` and `gamma`, each with a bound of its relative error below 2⁻³⁰.
    #[inline(always)]
    pub(crate) fn values(&self) -> Option<[(f64, f64); 3]> {
        Some([
            self.t()?,
            self.quotient(self.u, 8.0 * self.unit * self.u_permanent)?,
            self.quotient(self.v, 8.0 * self.unit * self.v_permanent)?,
        ])
    }

    /// An interval that holds `t`.
    #[inline(always)]
    pub(crate) fn t_interval(&self) -> Option<[f64; 2]> {
        self.t().map(|(t, error)| interval(t, error))
    }

    /// The condition numbers, where [`values`](Self::values) is certain.
    #[inline(always)]
    pub(crate) fn condition(&self) -> Condition {
        let of_det = self.det_permanent / self.det;
        let of = |permanent: f64, x: f64| permanent / self.det + (x / self.det).abs() * of_det;
        Condition {
            t: of(self.t_permanent, self.t),
            beta: of(self.u_permanent, self.u),
            gamma: of(self.v_permanent, self.v),
        }
    }
}

/// The ends of `x·(1 ± error)`, computed outwards.
#[inline(always)]
pub(crate) fn interval(x: f64, error: f64) -> [f64; 2] {
    let radius = if x == 0.0 { 0.0 } else { x.abs() * (error + 4.0 * UNIT) };
    [x - radius, x + radius]
}

/// The number of `E` nearest to every number in the interval, if that is one and the same.
///
/// Rounding is monotone, so it is enough that both ends round to it.
#[inline(always)]
pub(crate) fn rounded<E: Float>((x, error): (f64, f64)) -> Option<E> {
    let [low, high] = interval(x, error).map(E::from_f64);
    // Compared as bits, since −0 and +0 are different answers.
    (low.bits64() == high.bits64()).then_some(low)
}
