//! The best hit of a ray so far, and what a caller keeps of it.

use std::cmp::Ordering;
use std::hint::select_unpredictable;

use trisect_core::Hit;

use crate::called::{Called, On};

/// The nearest triangle that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Its number.
    pub triangle: u32,
    /// Where.
    pub hit: Hit<f32>,
}

/// What is farther than every hit, and nearer than infinity, which stands for none: whichever number stands
/// for `t`.
pub(crate) const NO_HIT: TriangleHit =
    TriangleHit { triangle: u32::MAX, hit: Hit { t: f32::MAX, beta: f32::MAX, gamma: 0.0 } };

impl TriangleHit {
    /// Whether it is not [`NO_HIT`].
    #[inline(always)]
    pub(crate) fn is_hit(&self) -> bool {
        self.triangle != NO_HIT.triangle
    }

    /// Takes another, if it is nearer, or as near and of a lower number. Which cannot be foretold, so
    /// without branches.
    #[allow(clippy::needless_bitwise_bool, reason = "`||` may branch")]
    #[inline(always)]
    pub(crate) fn improve(&mut self, other: Self) {
        let (old, new) = (self.hit, other.hit);
        let is_better = (new.t < old.t) | ((new.t == old.t) & (other.triangle < self.triangle));
        self.triangle = select_unpredictable(is_better, other.triangle, self.triangle);
        self.hit.t = select_unpredictable(is_better, new.t, old.t);
        self.hit.beta = select_unpredictable(is_better, new.beta, old.beta);
        self.hit.gamma = select_unpredictable(is_better, new.gamma, old.gamma);
    }

    /// The same for a method that orders what is equally near, the other to this one by `order`; whether
    /// it was taken.
    pub(crate) fn improve_by(&mut self, other: Self, order: impl FnOnce() -> Ordering) -> bool {
        let is_better = !self.is_hit()
            || other.hit.t < self.hit.t
            || other.hit.t == self.hit.t
                && other.triangle != self.triangle
                && order().then(other.triangle.cmp(&self.triangle)) == Ordering::Less;
        if is_better {
            *self = other;
        }
        is_better
    }
}

/// What is kept of a ray's hit.
pub(crate) trait Found: Send + Sized {
    /// From the best hit, which may be [`NO_HIT`].
    fn of(best: &TriangleHit) -> Self;

    /// [`Called::trace`] for it: compiled here, as it depends on no method.
    fn trace(called: Called<'_>, on: On, found: &mut [Self]);
}

impl Found for Option<TriangleHit> {
    #[inline(always)]
    fn of(best: &TriangleHit) -> Self {
        best.is_hit().then_some(*best)
    }

    fn trace(called: Called<'_>, on: On, found: &mut [Self]) {
        called.trace(on, found);
    }
}

impl Found for bool {
    #[inline(always)]
    fn of(best: &TriangleHit) -> Self {
        best.is_hit()
    }

    fn trace(called: Called<'_>, on: On, found: &mut [Self]) {
        called.trace(on, found);
    }
}
