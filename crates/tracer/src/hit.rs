//! The nearest hit of a ray.

use std::cmp::Ordering;
use std::hint::select_unpredictable;

use trisect_core::Hit;

use crate::precision::Real;

/// The nearest triangle that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit<P = f32> {
    /// The triangle's id: its place in the slice that the tree was built from.
    pub triangle: u32,
    /// Where the ray hits it.
    pub hit: Hit<P>,
}

/// A hit of one ray, or none.
#[derive(Clone, Copy)]
pub struct MaybeHit<P: Real = f32>(pub(crate) P::Packed);

impl<P: Real> MaybeHit<P> {
    /// The hit, if it is one.
    #[inline(always)]
    pub fn found(self) -> Option<TriangleHit<P>> {
        P::unpack(self.0).found()
    }
}

impl<P: Real> From<Option<TriangleHit<P>>> for MaybeHit<P> {
    fn from(found: Option<TriangleHit<P>>) -> Self {
        Self(P::pack(found.unwrap_or(TriangleHit::NONE)))
    }
}

impl<P: Real> TriangleHit<P> {
    /// No hit: farther than every hit, and nearer than infinity, which stands for a lane without one.
    pub(crate) const NONE: Self =
        Self { triangle: u32::MAX, hit: Hit { t: P::MAX, beta: P::MAX, gamma: P::ZERO } };

    /// Whether it is not [`NONE`](TriangleHit::NONE).
    #[inline(always)]
    pub(crate) fn is_hit(&self) -> bool {
        self.triangle != Self::NONE.triangle
    }

    /// The hit, if it is one.
    #[inline(always)]
    pub(crate) fn found(self) -> Option<Self> {
        self.is_hit().then_some(self)
    }

    /// The order of two hits by `t`, which neither is NaN.
    pub(crate) fn order_by_t(&self, other: &Self) -> Ordering {
        self.hit.t.partial_cmp(&other.hit.t).unwrap_or(Ordering::Equal)
    }

    /// Takes another hit if it is nearer, or as near and of a lower id. That is unpredictable, so it does not
    /// branch.
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

    /// The same for an exact method: `order` says how the other hit compares to this one where their rounded
    /// `t` is the same. Whether the other was taken.
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
