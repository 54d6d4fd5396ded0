//! The leaves of an exact method.
//!
//! On its way a ray knows the triangle of its best hit, and bounds of `t`. Mostly they tell which of two hits comes
//! first, at the cost of a filter and without branches. Where they do not, that is settled at once, exactly.
//! Values are computed once, when the ray has left the tree.

use std::hint::select_unpredictable;
use std::marker::PhantomData;
use std::ops::Range;

use trisect_core::{Hit, Lanes, Ray, Triangle, Vec3};
use trisect_method::{
    Culling, DecisionOnly, Deferred, ExactMethod, Interval, Of, Screened, TrueDivision,
};

use super::blocks::{Blocks, slot};
use super::query::{Hits, InBlock, LeafQuery, Left, Queries, end_after};
use crate::hit::TriangleHit;
use crate::precision::Real;
use crate::query::{Boxes, Faces, Query};
use crate::rays::batch::Rays;
use crate::vectors::{WIDTH, least};

/// The queries of an exact method.
pub(crate) struct Exactly;

impl<M: ExactMethod, P: Real> Queries<M, P> for Exactly {
    const LINES: bool = true;
    type Closest<B: Boxes, F: Faces> = ExactClosest<B, F, P>;

    #[inline(always)]
    fn closest<B: Boxes, F: Faces>(faces: F) -> ExactClosest<B, F, P> {
        ExactClosest { faces, boxes: PhantomData }
    }
}

/// The hit that is first in exact arithmetic; of those at the very same point that of the lowest id.
#[derive(Clone, Copy)]
pub(crate) struct ExactClosest<B, F, P> {
    faces: F,
    boxes: PhantomData<(B, P)>,
}

impl<B: Boxes, F: Faces, P: Real> Query for ExactClosest<B, F, P> {
    const ANY: bool = false;
    type Boxes = B;
    type Found = TriangleHit<P>;
    type Packed = P::Packed;
    const MISS: TriangleHit<P> = TriangleHit::NONE;
    type Output = Option<TriangleHit<P>>;

    #[inline(always)]
    fn output(found: &TriangleHit<P>) -> Option<TriangleHit<P>> {
        found.found()
    }

    #[inline(always)]
    fn pack(found: TriangleHit<P>) -> P::Packed {
        P::pack(found)
    }
}

/// The best hit of a ray on its way: the slot of the triangle, and bounds of `t`. Aligned, so that it is found, and
/// many are cleared, in few instructions.
#[derive(Clone, Copy)]
#[repr(align(16))]
pub(crate) struct Bounded<P> {
    slot: u32,
    low: P,
    high: P,
}

impl<P: Real> Bounded<P> {
    const NONE: Self = Self { slot: u32::MAX, low: P::MAX, high: P::MAX };

    #[inline(always)]
    fn is_hit(&self) -> bool {
        self.slot != Self::NONE.slot
    }
}

/// Room for the values of hits.
pub(crate) struct Values<P, const N: usize> {
    /// The triangles that rays hit. Where there is none, arbitrary numbers, so that nothing has to be cleared.
    corners: Triangle<[P; N]>,
    found: [TriangleHit<P>; N],
}

impl<M: ExactMethod, B: Boxes, F: Faces, P: Real> LeafQuery<M, P> for ExactClosest<B, F, P> {
    type Best = Bounded<P>;
    type Room<const N: usize> = Values<P, N>;
    const NOTHING: Bounded<P> = Bounded::NONE;

    #[inline(always)]
    fn room<const N: usize>() -> Values<P, N> {
        let zeros = Vec3::new([P::ZERO; N], [P::ZERO; N], [P::ZERO; N]);
        Values { corners: Triangle { a: zeros, b: zeros, c: zeros }, found: [TriangleHit::NONE; N] }
    }

    #[inline(always)]
    fn culling(self) -> Culling {
        self.faces.culling()
    }

    #[inline(always)]
    fn is_hit(best: &Bounded<P>) -> bool {
        best.is_hit()
    }

    #[inline(always)]
    fn end(best: &Bounded<P>, tmax: P) -> P {
        end_after::<B, P>(best.high, tmax)
    }

    #[inline(always)]
    fn test<L: Lanes<Elem = P>>(
        self,
        ray: &M::PreparedRay<L>,
        triangles: &Of<M::Prepared, L>,
        interval: Interval<L>,
        InBlock { at, lane, .. }: InBlock<'_, M, P>,
        best: &mut Bounded<P>,
    ) -> u64 {
        let mut left = 0;
        M::screen(
            ray,
            triangles,
            interval,
            self.faces.culling(),
            #[inline(always)]
            |screened| left = take::<P, L>(screened, slot(at, lane), best),
        );
        left
    }

    /// Out of line, and the ray is read from the batch there: in memory for its sake it would be stored for every
    /// leaf.
    #[inline(always)]
    fn settle<const N: usize>(
        self,
        blocks: &Blocks<M, P>,
        rays: &impl Rays<P, N>,
        index: usize,
        Left { blocks: Range { start, end }, lanes }: Left,
        best: &mut Bounded<P>,
    ) {
        settle(blocks, self.faces.culling(), rays, index, (start, end, lanes), best);
    }

    /// The values of all hits at once: what is brought together number by number can be read by lanes only when it
    /// has been written for a while. Rays are stored number by number already, so that only triangles have to be
    /// brought to them.
    #[inline(always)]
    fn finish<'a, L: Lanes, const N: usize>(
        blocks: &Blocks<M, P>,
        rays: &impl Rays<P, N>,
        Hits { best, room: Values { corners, found } }: &'a mut Hits<Bounded<P>, Values<P, N>, N>,
    ) -> &'a [TriangleHit<P>; N] {
        let mut hits = 0;
        for (index, (best, found)) in best.iter().zip(&mut *found).enumerate() {
            hits |= u64::from(best.is_hit()) << index;
            found.triangle = TriangleHit::<P>::NONE.triangle;
        }
        if hits == 0 {
            return found;
        }
        let mut left = hits;
        while left != 0 {
            let index = left.trailing_zeros() as usize % N;
            left &= left - 1;
            let slot = best[index].slot;
            let Triangle { a, b, c } = M::corners(&blocks.prepared(slot));
            put(&mut corners.a, index, a);
            put(&mut corners.b, index, b);
            put(&mut corners.c, index, c);
            // Here, where the next triangle does not wait for it: ids are in a part of the block not yet seen.
            found[index].triangle = blocks.triangle(slot);
        }
        let values = M::values::<L, P, N>(&rays.rows(), corners, hits);
        while hits != 0 {
            let index = hits.trailing_zeros() as usize % N;
            hits &= hits - 1;
            let (t, beta, gamma) = (values.t[index], values.beta[index], values.gamma[index]);
            found[index].hit = Hit { t, beta, gamma };
        }
        found
    }
}

#[inline(always)]
fn put<P, const N: usize>(rows: &mut Vec3<[P; N]>, index: usize, v: Vec3<P>) {
    (rows.x[index], rows.y[index], rows.z[index]) = (v.x, v.y, v.z);
}

/// Takes what comes before the best hit of the lanes whose slots begin at `first_slot`. Where the bounds do not tell
/// which of them does, takes nothing: the lanes that may, in bits.
#[inline(always)]
fn take<P: Real, L: Lanes<Elem = P>>(
    screened: Screened<L>,
    first_slot: u32,
    best: &mut Bounded<P>,
) -> u64 {
    let Screened { certain, open, low, high } = screened;
    let first_high = least(L::select(certain, high, high.constant(P::INFINITY)));
    let mut lows = [P::ZERO; WIDTH];
    low.store(&mut lows);
    let is_before = first_high < best.low;
    // All that may come before, or at the same point: among them whatever ends there.
    let end = Lanes::min(first_high, best.high);
    let near = L::bits(certain) & L::bits(low.le(low.constant(end))) | open;
    // One, where it is before the best hit, and otherwise none.
    if near & near.wrapping_sub(u64::from(is_before)) != 0 {
        return near;
    }
    let first = near.trailing_zeros() as usize % WIDTH;
    #[allow(clippy::cast_possible_truncation, reason = "it is below eight")]
    let slot = first_slot + first as u32;
    best.slot = select_unpredictable(is_before, slot, best.slot);
    best.low = select_unpredictable(is_before, lows[first], best.low);
    best.high = end;
    0
}

/// Takes the first hit of the lanes that are left where it comes before the best hit: decides and orders
/// exactly.
#[cold]
#[inline(never)]
fn settle<M: ExactMethod, P: Real, const N: usize>(
    blocks: &Blocks<M, P>,
    culling: Culling,
    rays: &impl Rays<P, N>,
    index: usize,
    (start, end, left): (usize, usize, u64),
    best: &mut Bounded<P>,
) {
    let ray = &rays.one(index);
    let known = best.is_hit().then(|| blocks.triangle(best.slot));
    let mut first = None;
    let lanes = (start..end).flat_map(|block| (0..WIDTH).map(move |lane| (block, lane)));
    let is_left = |&(block, lane): &(usize, usize)| block > start || left >> lane & 1 != 0;
    for (block, lane) in lanes.filter(is_left) {
        let slot = slot(block, lane);
        let triangle = blocks.triangle(slot);
        let prepared = blocks.prepared(slot);
        // Where space is split a ray meets a triangle in several leaves.
        if known == Some(triangle) || !is_hit::<M, P>(ray, culling, &prepared) {
            continue;
        }
        let (first_slot, first) =
            first.get_or_insert_with(|| (best.slot, with_values(blocks, ray, *best)));
        let other = TriangleHit { triangle, hit: values::<M, P>(ray, &prepared) };
        if first.improve_by(other, || M::order(ray, &prepared, &blocks.prepared(*first_slot))) {
            *first_slot = slot;
        }
    }
    if let Some((slot, TriangleHit { hit: Hit { t, .. }, .. })) = first {
        // `t` was rounded once, and so are its bounds.
        let rounding = t.abs() * P::ROUNDINGS + P::UNDERFLOW;
        *best = Bounded { slot, low: t - rounding, high: t + rounding };
    }
}

/// Whether a ray hits a triangle.
pub(super) fn is_hit<M: ExactMethod, P: Real>(
    ray: &Ray<P>,
    culling: Culling,
    prepared: &Of<M::Prepared, P>,
) -> bool {
    let interval = Interval { tmin: ray.tmin, tmax: ray.tmax };
    let ray = M::prepare_ray::<P>(ray, 0);
    let mut is_hit = false;
    M::test::<P, DecisionOnly<Deferred<TrueDivision, true>>>(
        &ray,
        prepared,
        interval,
        culling,
        |met, _| is_hit = met,
    );
    is_hit
}

/// The best hit with its values.
fn with_values<M: ExactMethod, P: Real>(
    blocks: &Blocks<M, P>,
    ray: &Ray<P>,
    best: Bounded<P>,
) -> TriangleHit<P> {
    if !best.is_hit() {
        return TriangleHit::NONE;
    }
    let hit = values::<M, P>(ray, &blocks.prepared(best.slot));
    TriangleHit { triangle: blocks.triangle(best.slot), hit }
}

/// The values of one hit.
pub(super) fn values<M: ExactMethod, P: Real>(
    ray: &Ray<P>,
    prepared: &Of<M::Prepared, P>,
) -> Hit<P> {
    let rays = ray.map(|&x| [x]);
    let Ray { o, d, tmin, tmax } = &rays;
    let rays = Ray { o: o.each_ref(), d: d.each_ref(), tmin, tmax };
    let Hit { t: [t], beta: [beta], gamma: [gamma] } =
        M::values::<P, P, 1>(&rays, &M::corners(prepared).map(|&x| [x]), 1);
    Hit { t, beta, gamma }
}
