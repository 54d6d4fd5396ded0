//! How a method's formula becomes a decision and a hit: when to divide, how to divide, and
//! whether to leave early. All of it is type parameters of one function, so that what is not
//! used costs nothing.

use crate::form::{Form, ReciprocalKind};
use crate::method::{Homogeneous, Method};
use crate::record::Of;
use crate::weights::Alpha as _;
use trisect_core::{Hit, Ray};
use trisect_core::{Lanes, Scalar};

/// The values of `t` that count as hits: `tmin ≤ t ≤ tmax`.
#[derive(Clone, Copy, Debug)]
pub struct Interval<L> {
    /// Smallest `t`, at least −[`Scalar::largest_t`].
    pub tmin: L,
    /// Largest `t`, at most [`Scalar::largest_t`].
    pub tmax: L,
}

impl<L: Lanes> Interval<L> {
    /// The interval of a ray, see [`Interval::new`]; one that nothing is in for a ray that is not
    /// finite, so that no formula has to mind what an infinity does to it.
    #[allow(clippy::eq_op, reason = "x − x is NaN where x is not finite")]
    #[inline(always)]
    pub fn of(ray: &Ray<L>) -> Self {
        // Zero, or NaN where a coordinate is infinite or NaN.
        let nothing = (ray.o - ray.o) + (ray.d - ray.d);
        Self::new(ray.tmin + nothing.sum(), ray.tmax)
    }

    /// The closed interval, its ends brought within half the largest finite number, so that no
    /// hit can carry an infinite `t` however its quotient rounds.
    #[allow(clippy::eq_op, reason = "x − x is NaN where x is NaN, and zero elsewhere")]
    #[inline(always)]
    pub fn new(tmin: L, tmax: L) -> Self {
        let end = tmax.constant(L::Elem::largest_t());
        // A NaN stays, and fails every test; of either end it is in both.
        let tmin = L::select(tmin.lt(-end), -end, tmin);
        let tmax = L::select(tmax.gt(end), end, tmax);
        Self { tmin: tmin + (tmax - tmax), tmax: tmax + (tmin - tmin) }
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

impl Culling {
    /// `mask` without the lanes whose face is not seen: `facing` is positive at the front, negative at the
    /// back.
    #[inline(always)]
    pub fn seen<L: Lanes>(self, mask: L::Mask, facing: impl FnOnce() -> L) -> L::Mask {
        if self == Self::None {
            return mask;
        }
        let facing = facing();
        let zero = facing.constant(L::Elem::from_f64(0.0));
        mask & if self == Self::Back { facing.gt(zero) } else { facing.lt(zero) }
    }
}

/// How `1 / x` is computed.
pub trait Reciprocal: 'static {
    /// Which way it is.
    const KIND: ReciprocalKind;
    /// `1 / x`
    fn reciprocal<L: Lanes>(x: L) -> L;
}

/// The processor's division, correctly rounded.
pub struct TrueDivision;

impl Reciprocal for TrueDivision {
    const KIND: ReciprocalKind = ReciprocalKind::True;
    #[inline(always)]
    fn reciprocal<L: Lanes>(x: L) -> L {
        x.constant(L::Elem::from_f64(1.0)) / x
    }
}

/// The processor's estimate and Newton steps: one for f32, where the estimate has eleven bits or
/// more, three for f64. Precisions and instruction sets without an estimate divide.
pub struct Newton;

impl Reciprocal for Newton {
    const KIND: ReciprocalKind = ReciprocalKind::Newton;
    #[inline(always)]
    fn reciprocal<L: Lanes>(x: L) -> L {
        let one = x.constant(L::Elem::from_f64(1.0));
        // Each step doubles the bits that are right: 11, 22 and, for f64, 44, 88.
        let steps = if size_of::<L::Elem>() > size_of::<f32>() { 3 } else { 1 };
        let mut r = x.reciprocal_estimate();
        for _ in 0..steps {
            // r' = r + r·(1 − x·r)
            let residual = -x.mul_sub(r, one);
            r = r.mul_add(residual, r);
        }
        r
    }
}

/// When the division comes, and whether a test ends as soon as no lane can hit.
pub trait Division: 'static {
    /// When it comes.
    const FORM: Form;
    /// How `1 / x` is computed.
    type Reciprocal: Reciprocal;
    /// Whether a test ends as soon as no lane can hit.
    const EARLY_OUT: bool;
    /// Whether the values of a hit are asked for; where not, `found` gets numbers that mean nothing.
    /// For methods that compute them apart from the decision: what the others compute and nobody
    /// reads, the compiler leaves out.
    const VALUES: bool = true;

    /// `1 / x` as the division has it.
    #[inline(always)]
    fn reciprocal<L: Lanes>(x: L) -> L {
        Self::Reciprocal::reciprocal(x)
    }

    /// Whether a test ends here: nothing hits, and the division leaves early.
    #[inline(always)]
    fn stops<L: Lanes>(mask: L::Mask) -> bool {
        Self::EARLY_OUT && !L::any(mask)
    }

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
    const FORM: Form = Form::Early;
    type Reciprocal = R;
    const EARLY_OUT: bool = EARLY_OUT;

    #[inline(always)]
    fn test<M: Method, L: Lanes>(
        ray: &M::PreparedRay<L>,
        triangle: &Of<M::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    ) {
        let q = M::intersect_early(
            ray,
            triangle,
            #[inline(always)]
            |det| R::reciprocal(det),
        );
        let one = q.det.constant(L::Elem::from_f64(1.0));
        let in_time = q.t.ge(interval.tmin) & q.t.le(interval.tmax);
        let mut mask = seen::<M, L>(in_time, ray, triangle, q.det, culling);
        // With lanes a single branch, after all tests: some lane mostly passes the first, and a branch
        // that is hard to predict costs more than the tests that it skips.
        if L::N == 1 && Self::stops::<L>(mask) {
            return;
        }
        mask = mask & q.alpha.inside(q.beta, q.gamma, one);
        if Self::stops::<L>(mask) {
            return;
        }
        found(mask, q.hit());
    }
}

/// Tests numerators against the denominator and divides for hits alone. With
/// `x' = x · sign(det)`: `beta' ≥ 0`, `gamma' ≥ 0`, `beta' + gamma' ≤ |det|`,
/// `tmin·|det| − t' ≤ 0`, `tmax·|det| − t' ≥ 0` (Havel 2008, section 4.2.4), and `|det|` neither
/// subnormal nor overflowed, so that the reciprocal is finite and not zero.
///
/// One number at a time, `beta` and `gamma` are tested before `t`, and after it with `T_FIRST`, by which Havel
/// explains which methods are fast (section 5.1.1). Lanes leave at one place. Decisions are the same.
pub struct Deferred<R, const EARLY_OUT: bool, const T_FIRST: bool = false>(
    core::marker::PhantomData<R>,
);

impl<R: Reciprocal, const EARLY_OUT: bool, const T_FIRST: bool> Division
    for Deferred<R, EARLY_OUT, T_FIRST>
{
    const FORM: Form = Form::Deferred;
    type Reciprocal = R;
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
        let front = h.positive();
        // One number at a time, each test spares the next. Lanes have a single branch, as in the early form, and
        // behind it what is nearly always so.
        let mut mask = if L::N > 1 {
            front.inside() & front.in_time(interval)
        } else {
            let first = if T_FIRST { front.in_time(interval) } else { front.inside() };
            let mask = first & front.has_reciprocal();
            if Self::stops::<L>(mask) {
                return;
            }
            mask & if T_FIRST { front.inside() } else { front.in_time(interval) }
        };
        mask = seen::<M, L>(mask, ray, triangle, h.det, culling);
        if Self::stops::<L>(mask) {
            return;
        }
        if L::N > 1 {
            mask = mask & front.has_reciprocal();
            if Self::stops::<L>(mask) {
                return;
            }
        }
        found(mask, front.hit(R::reciprocal(front.det)));
    }
}

/// As [`Deferred`], by sign bits (Havel 2008, section 4.2.4): `t − tmin·det`, `tmax·det − t`, `beta`, `gamma` and
/// what these leave of `det`, all of them numerators, have one sign. Nothing is flipped, and one comparison is left,
/// for `det`. `t` comes first.
///
/// Decides as [`Deferred`] does where none of the five is zero or NaN, and no difference underflows. What it
/// promises of the others is its own: a zero counts as its sign bit has it, so that a point on an edge, or at an end of
/// the interval, may hit where `det` is positive and miss where it is negative; so does a NaN of a numerator
/// that overflowed, whose values are then NaN. A triangle of NaN, which fills up blocks, misses.
pub struct BySigns<R, const EARLY_OUT: bool>(core::marker::PhantomData<R>);

impl<R: Reciprocal, const EARLY_OUT: bool> Division for BySigns<R, EARLY_OUT> {
    const FORM: Form = Form::Deferred;
    type Reciprocal = R;
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
        // An end that is NaN, as that of a ray that is not finite, would count by its sign.
        let one = h.det.constant(L::Elem::from_f64(1.0));
        let some = interval.tmin.le(interval.tmax);
        let after = L::select(some, -interval.tmin, -one).mul_add(h.det, h.t);
        let before = L::select(some, interval.tmax, -one).mul_sub(h.det, h.t);
        let alike = |signed: L| signed.is_within(L::Elem::smallest_det(), L::Elem::largest_t());
        if L::N == 1 && Self::stops::<L>(alike(h.det.negative_unless_alike([after, before]))) {
            return;
        }
        let alpha = h.alpha.weight(h.beta, h.gamma, h.det);
        let all = [h.beta, h.gamma, alpha, after, before];
        let mask = alike(h.det.negative_unless_alike(all));
        let mask = seen::<M, L>(mask, ray, triangle, h.det, culling);
        if Self::stops::<L>(mask) {
            return;
        }
        found(mask, h.hit(R::reciprocal(h.det)));
    }
}

/// Division `D` for a caller that asks whether there is a hit, and for no value of it.
pub struct DecisionOnly<D>(core::marker::PhantomData<D>);

impl<D: Division> Division for DecisionOnly<D> {
    const FORM: Form = D::FORM;
    type Reciprocal = D::Reciprocal;
    const EARLY_OUT: bool = D::EARLY_OUT;
    const VALUES: bool = false;

    #[inline(always)]
    fn test<M: Method, L: Lanes>(
        ray: &M::PreparedRay<L>,
        triangle: &Of<M::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    ) {
        D::test::<M, L>(ray, triangle, interval, culling, found);
    }
}

impl<L: Lanes, A: crate::weights::Alpha<L>> Homogeneous<L, A> {
    /// The same numbers with a denominator that is not negative: the signs of all flipped where
    /// that of `det` is set.
    #[inline(always)]
    #[must_use]
    pub fn positive(self) -> Self {
        let Self { det, t, alpha, beta, gamma } = self;
        Self {
            det: det.xor_sign(det),
            t: t.xor_sign(det),
            alpha: alpha.xor_sign(det),
            beta: beta.xor_sign(det),
            gamma: gamma.xor_sign(det),
        }
    }

    /// Where the point is inside, of [`positive`](Homogeneous::positive) numbers: no weight is negative.
    #[inline(always)]
    pub fn inside(self) -> L::Mask {
        self.alpha.inside(self.beta, self.gamma, self.det)
    }

    /// Where `det` is neither zero nor subnormal, and has not overflowed, of
    /// [`positive`](Homogeneous::positive) numbers.
    #[inline(always)]
    pub fn has_reciprocal(self) -> L::Mask {
        self.det.is_within(L::Elem::smallest_det(), L::Elem::largest_t())
    }

    /// Where `t` is in the interval, of [`positive`](Homogeneous::positive) numbers that
    /// [have a reciprocal](Homogeneous::has_reciprocal).
    #[inline(always)]
    pub fn in_time(self, interval: Interval<L>) -> L::Mask {
        let zero = self.det.constant(L::Elem::from_f64(0.0));
        let Interval { tmin, tmax } = interval;
        // As differences, so that an infinite t against an infinite end is NaN and misses.
        let before = tmax.mul_sub(self.det, self.t);
        if L::ONE_ROUNDING {
            // No product overflows: where one difference is NaN the other is, too.
            let after = (-tmin).mul_add(self.det, self.t);
            after.min(before).ge(zero)
        } else {
            tmin.mul_sub(self.det, self.t).le(zero) & before.ge(zero)
        }
    }

    /// The hit, given `1 / det`.
    #[inline(always)]
    pub fn hit(self, reciprocal: L) -> Hit<L> {
        Hit { t: self.t * reciprocal, beta: self.beta * reciprocal, gamma: self.gamma * reciprocal }
    }
}

/// `mask` without the lanes whose face is culled, of pairs prepared for `M`.
#[inline(always)]
pub fn seen<M: Method, L: Lanes>(
    mask: L::Mask,
    ray: &M::PreparedRay<L>,
    triangle: &Of<M::Prepared, L>,
    det: L,
    culling: Culling,
) -> L::Mask {
    culling.seen::<L>(
        mask,
        #[inline(always)]
        || M::facing(ray, triangle, det),
    )
}
