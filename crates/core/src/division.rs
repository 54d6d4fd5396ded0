//! How a method's formula becomes a decision and a hit: when to divide, how to divide, and
//! whether to leave early. All of it is type parameters of one function, so that what is not
//! used costs nothing.

use crate::geometry::Hit;
use crate::lanes::{Lanes, Scalar};
use crate::method::Method;
use crate::record::Of;

/// The values of `t` that count as hits: `tmin ≤ t ≤ tmax`.
#[derive(Clone, Copy, Debug)]
pub struct Interval<L> {
    /// Smallest `t`, at least −[`Scalar::largest_t`].
    pub tmin: L,
    /// Largest `t`, at most [`Scalar::largest_t`].
    pub tmax: L,
}

impl<L: Lanes> Interval<L> {
    /// The closed interval, its ends brought within half the largest finite number, so that no
    /// hit can carry an infinite `t` however its quotient rounds.
    #[inline(always)]
    pub fn new(tmin: L, tmax: L) -> Self {
        let end = tmax.constant(L::Elem::largest_t());
        // A NaN stays, and fails every test.
        Self {
            tmin: L::select(tmin.lt(-end), -end, tmin),
            tmax: L::select(tmax.gt(end), end, tmax),
        }
    }
}

/// Which faces are not seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Culling {
    /// Both faces are seen.
    #[default]
    None,
    /// Back faces are not seen.
    Back,
    /// Front faces are not seen.
    Front,
}

/// How `1 / x` is computed.
pub trait Reciprocal: 'static {
    /// The name used in records.
    const NAME: &'static str;
    /// `1 / x`
    fn reciprocal<L: Lanes>(x: L) -> L;
}

/// The processor's division, correctly rounded.
pub struct TrueDivision;

impl Reciprocal for TrueDivision {
    const NAME: &'static str = "true";
    #[inline(always)]
    fn reciprocal<L: Lanes>(x: L) -> L {
        x.constant(L::Elem::from_f64(1.0)) / x
    }
}

/// The processor's estimate and Newton steps: one for f32, where the estimate has eleven bits or
/// more. Precisions and instruction sets without an estimate divide.
pub struct Newton;

impl Reciprocal for Newton {
    const NAME: &'static str = "newton";
    #[inline(always)]
    fn reciprocal<L: Lanes>(x: L) -> L {
        let r = x.reciprocal_estimate();
        // r' = r + r·(1 − x·r)
        let one = x.constant(L::Elem::from_f64(1.0));
        let residual = -x.mul_sub(r, one);
        r.mul_add(residual, r)
    }
}

/// When the division comes, and whether a test ends as soon as no lane can hit.
pub trait Division: 'static {
    /// `early` or `deferred`
    const NAME: &'static str;
    /// Name of the [`Reciprocal`].
    const RECIPROCAL: &'static str;
    /// Whether a test ends as soon as no lane can hit.
    const EARLY_OUT: bool;

    /// Tests one vector of pairs and hands the lanes that hit, with their values, to `found`;
    /// without early-out `found` is called even when no lane hits.
    fn test<M: Method, L: Lanes>(
        ray: &M::PreparedRay<L>,
        triangle: &Of<M::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    );
}

/// Divides first, then tests quotients: `tmin ≤ t ≤ tmax`, `beta ≥ 0`, `gamma ≥ 0`,
/// `beta + gamma ≤ 1`. A zero `det` gives quotients that are infinite or NaN: no hit.
pub struct Early<R, const EARLY_OUT: bool>(core::marker::PhantomData<R>);

impl<R: Reciprocal, const EARLY_OUT: bool> Division for Early<R, EARLY_OUT> {
    const NAME: &'static str = "early";
    const RECIPROCAL: &'static str = R::NAME;
    const EARLY_OUT: bool = EARLY_OUT;

    #[inline(always)]
    fn test<M: Method, L: Lanes>(
        ray: &M::PreparedRay<L>,
        triangle: &Of<M::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    ) {
        let (det, hit) = M::intersect_early(
            ray,
            triangle,
            #[inline(always)]
            |det| R::reciprocal(det),
        );
        let zero = det.constant(L::Elem::from_f64(0.0));
        let one = det.constant(L::Elem::from_f64(1.0));
        let mut mask =
            seen::<M, L>(hit.t.ge(interval.tmin) & hit.t.le(interval.tmax), triangle, det, culling);
        // With lanes a single branch, after all tests: some lane mostly passes the first, and a branch
        // that is hard to predict costs more than the tests that it skips.
        if EARLY_OUT && L::N == 1 && !L::any(mask) {
            return;
        }
        mask = mask & hit.beta.ge(zero) & hit.gamma.ge(zero) & (hit.beta + hit.gamma).le(one);
        if EARLY_OUT && !L::any(mask) {
            return;
        }
        found(mask, hit);
    }
}

/// Tests numerators against the denominator and divides for hits alone. With
/// `x' = x · sign(det)`: `beta' ≥ 0`, `gamma' ≥ 0`, `beta' + gamma' ≤ |det|`,
/// `tmin·|det| − t' ≤ 0`, `tmax·|det| − t' ≥ 0` (Havel 2008, section 4.2.4), and `|det|` neither
/// subnormal nor overflowed, so that the reciprocal is finite and not zero.
pub struct Deferred<R, const EARLY_OUT: bool>(core::marker::PhantomData<R>);

impl<R: Reciprocal, const EARLY_OUT: bool> Division for Deferred<R, EARLY_OUT> {
    const NAME: &'static str = "deferred";
    const RECIPROCAL: &'static str = R::NAME;
    const EARLY_OUT: bool = EARLY_OUT;

    #[inline(always)]
    fn test<M: Method, L: Lanes>(
        ray: &M::PreparedRay<L>,
        triangle: &Of<M::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    ) {
        let h = M::intersect(ray, triangle);
        let zero = h.det.constant(L::Elem::from_f64(0.0));
        let smallest = zero.constant(L::Elem::smallest_det());
        let largest = zero.constant(L::Elem::largest_t());
        let det = h.det.xor_sign(h.det);
        let beta = h.beta.xor_sign(h.det);
        let gamma = h.gamma.xor_sign(h.det);
        let t = h.t.xor_sign(h.det);
        let mask = beta.ge(zero) & gamma.ge(zero) & (beta + gamma).le(det) & det.ge(smallest);
        if EARLY_OUT && !L::any(mask) {
            return;
        }
        let mask = seen::<M, L>(
            // As differences, so that an infinite t' against an infinite end is NaN and misses.
            mask & interval.tmin.mul_sub(det, t).le(zero)
                & interval.tmax.mul_sub(det, t).ge(zero)
                & det.le(largest),
            triangle,
            h.det,
            culling,
        );
        if EARLY_OUT && !L::any(mask) {
            return;
        }
        let r = R::reciprocal(det);
        found(mask, Hit { t: t * r, beta: beta * r, gamma: gamma * r });
    }
}

/// `mask` without the lanes whose face is culled.
#[inline(always)]
fn seen<M: Method, L: Lanes>(
    mask: L::Mask,
    triangle: &Of<M::Prepared, L>,
    det: L,
    culling: Culling,
) -> L::Mask {
    let zero = det.constant(L::Elem::from_f64(0.0));
    match culling {
        Culling::None => mask,
        Culling::Back => mask & M::facing(triangle, det).gt(zero),
        Culling::Front => mask & M::facing(triangle, det).lt(zero),
    }
}
