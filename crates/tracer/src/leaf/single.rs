//! A ray at a leaf: it is tested against as many triangles at a time as there are lanes.

use std::ops::Range;

use trisect_core::{Hit, Lanes, Ray};
use trisect_method::{Culling, Interval, Method, Of};

use super::blocks::Blocks;
use super::packet;
use super::pairs::test;
use super::query::{Hits, InBlock, LeafQuery, Left, Queries, end_after};
use crate::hit::TriangleHit;
use crate::precision::Real;
use crate::query::{Any, Boxes, Closest, Faces};
use crate::rays::batch::{Gather, RAYS, Rays};
use crate::vectors::{WIDTH, least};

/// A ray at the leaves of a method. Handed on by value: a call that might see the ray in memory would have it stored
/// for every leaf.
pub(crate) struct AtLeaf<'a, M: Method, Q, P: Real = f32> {
    pub(crate) blocks: &'a Blocks<M, P>,
    pub(crate) query: Q,
    pub(crate) ray: Ray<P>,
}

impl<M: Method, Q: Copy, P: Real> Clone for AtLeaf<'_, M, Q, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Method, Q: Copy, P: Real> Copy for AtLeaf<'_, M, Q, P> {}

/// Tests one of some rays against the triangles of a leaf; whether it has hit anything so far.
#[inline(always)]
pub(crate) fn test_ray<M, P, L, Q, const N: usize>(
    token: L::Token,
    at_leaf: AtLeaf<'_, M, Q, P>,
    leaf: Range<usize>,
    (rays, index): (&impl Rays<P, N>, usize),
    best: &mut Q::Best,
) -> bool
where
    M: Method,
    P: Real,
    L: Lanes<Elem = P>,
    Q: LeafQuery<M, P>,
{
    let axis = if const { M::TURNS } { at_leaf.ray.d.largest_axis() } else { 2 };
    let left = match axis {
        0 if const { M::TURNS } => test_leaf::<M, P, L, Q, 0>(token, leaf, at_leaf, best),
        1 if const { M::TURNS } => test_leaf::<M, P, L, Q, 1>(token, leaf, at_leaf, best),
        _ => test_leaf::<M, P, L, Q, 2>(token, leaf, at_leaf, best),
    };
    // Not in the loop over blocks: all that is computed before it would be kept in memory, and loaded in
    // every round.
    if left.lanes != 0 {
        at_leaf.query.settle(at_leaf.blocks, rays, index, left, best);
    }
    Q::is_hit(best)
}

#[inline(always)]
fn test_leaf<M, P, L, Q, const AXIS: usize>(
    token: L::Token,
    leaf: Range<usize>,
    at_leaf: AtLeaf<'_, M, Q, P>,
    best: &mut Q::Best,
) -> Left
where
    M: Method,
    P: Real,
    L: Lanes<Elem = P>,
    Q: LeafQuery<M, P>,
{
    let AtLeaf { blocks, ray, .. } = at_leaf;
    let interval = Interval { tmin: L::splat(token, ray.tmin), tmax: L::splat(token, ray.tmax) };
    // Computing this for each leaf costs less than keeping it for every ray in flight, even where it divides.
    let ray = Ray::<L>::splat(token, &ray).with_axis_last(AXIS);
    // Not zipped: that may stay a call.
    for at in leaf.clone() {
        let ray = M::prepare_ray(&ray, blocks.kind(at));
        let lanes = test_block::<M, P, L, Q, AXIS>(token, &ray, at, interval, at_leaf, best);
        if lanes != 0 {
            return Left { blocks: at..leaf.end, lanes };
        }
    }
    Left { blocks: leaf, lanes: 0 }
}

/// Tests the triangles of a block. The lanes that are left to be settled, in bits.
#[inline(always)]
fn test_block<M, P, L, Q, const AXIS: usize>(
    token: L::Token,
    ray: &M::PreparedRay<L>,
    at: usize,
    interval: Interval<L>,
    AtLeaf { blocks, query, .. }: AtLeaf<'_, M, Q, P>,
    best: &mut Q::Best,
) -> u64
where
    M: Method,
    P: Real,
    L: Lanes<Elem = P>,
    Q: LeafQuery<M, P>,
{
    let block = &blocks.blocks[at];
    let mut lane = 0;
    while lane < WIDTH {
        let triangles = block.lanes::<L, AXIS>(token, lane);
        let in_block = InBlock { block, at, lane };
        let left = query.test::<L>(ray, &triangles, interval, in_block, best);
        if left != 0 {
            // With the lanes that come after these.
            return (left | u64::MAX << (L::N - 1) << 1) << lane;
        }
        lane += L::N;
    }
    0
}

/// The queries of a method that rounds.
pub(crate) struct Rounded;

impl<M: Method, P: Real> Queries<M, P> for Rounded {
    const LINES: bool = false;
    type Closest<B: Boxes, F: Faces> = Closest<B, F, P>;

    #[inline(always)]
    fn closest<B: Boxes, F: Faces>(faces: F) -> Closest<B, F, P> {
        Closest::new(faces)
    }
}

impl<M: Method, B: Boxes, F: Faces, P: Real> LeafQuery<M, P> for Closest<B, F, P> {
    type Best = TriangleHit<P>;
    type Room<const N: usize> = ();
    const NOTHING: TriangleHit<P> = TriangleHit::NONE;

    fn room<const N: usize>() {}

    #[inline(always)]
    fn culling(self) -> Culling {
        self.faces.culling()
    }

    #[inline(always)]
    fn is_hit(best: &TriangleHit<P>) -> bool {
        best.is_hit()
    }

    #[inline(always)]
    fn end(best: &TriangleHit<P>, tmax: P) -> P {
        end_after::<B, P>(best.hit.t, tmax)
    }

    #[inline(always)]
    fn test<L: Lanes<Elem = P>>(
        self,
        ray: &M::PreparedRay<L>,
        triangles: &Of<M::Prepared, L>,
        interval: Interval<L>,
        InBlock { block, lane, .. }: InBlock<'_, M, P>,
        best: &mut TriangleHit<P>,
    ) -> u64 {
        test::<M, L, Self>(
            ray,
            triangles,
            interval,
            self.faces.culling(),
            #[inline(always)]
            |met, hit| {
                // The one thing that is asked: where nothing is hit, a ray alone goes on without waiting for the
                // least of the lanes.
                if L::any(met) {
                    best.improve(nearest(met, hit, &block.triangles[lane..]));
                }
            },
        );
        0
    }

    #[inline(always)]
    fn test_packet<L: Lanes<Elem = P>>(
        token: L::Token,
        blocks: &Blocks<M, P>,
        leaf: &Range<usize>,
        rays: &mut impl Gather<P>,
        best: &mut [TriangleHit<P>; RAYS],
        which: u64,
    ) -> (bool, u64) {
        packet::test_leaf::<M, P, L, Self>(
            token,
            blocks,
            leaf,
            rays,
            best,
            which,
            TriangleHit::improve,
        )
    }

    #[inline(always)]
    fn finish<'a, L: Lanes, const N: usize>(
        _: &Blocks<M, P>,
        _: &impl Rays<P, N>,
        hits: &'a mut Hits<TriangleHit<P>, (), N>,
    ) -> &'a [TriangleHit<P>; N] {
        &hits.best
    }
}

impl<M: Method, B: Boxes, F: Faces, P: Real> LeafQuery<M, P> for Any<B, F> {
    type Best = bool;
    type Room<const N: usize> = ();
    const NOTHING: bool = false;

    fn room<const N: usize>() {}

    #[inline(always)]
    fn culling(self) -> Culling {
        self.faces.culling()
    }

    #[inline(always)]
    fn is_hit(best: &bool) -> bool {
        *best
    }

    /// Nothing more is looked for.
    #[inline(always)]
    fn end(_: &bool, _: P) -> P {
        P::NEG_INFINITY
    }

    #[inline(always)]
    fn test<L: Lanes<Elem = P>>(
        self,
        ray: &M::PreparedRay<L>,
        triangles: &Of<M::Prepared, L>,
        interval: Interval<L>,
        _: InBlock<'_, M, P>,
        best: &mut bool,
    ) -> u64 {
        test::<M, L, Self>(
            ray,
            triangles,
            interval,
            self.faces.culling(),
            #[inline(always)]
            |met, _| *best |= L::any(met),
        );
        0
    }

    #[inline(always)]
    fn test_packet<L: Lanes<Elem = P>>(
        token: L::Token,
        blocks: &Blocks<M, P>,
        leaf: &Range<usize>,
        rays: &mut impl Gather<P>,
        best: &mut [bool; RAYS],
        which: u64,
    ) -> (bool, u64) {
        packet::test_leaf::<M, P, L, Self>(
            token,
            blocks,
            leaf,
            rays,
            best,
            which,
            #[inline(always)]
            |best, _| *best = true,
        )
    }

    #[inline(always)]
    fn finish<'a, L: Lanes, const N: usize>(
        _: &Blocks<M, P>,
        _: &impl Rays<P, N>,
        hits: &'a mut Hits<bool, (), N>,
    ) -> &'a [bool; N] {
        &hits.best
    }
}

/// The nearest of the lanes that hit, of equally near ones the first, which has the lowest id; infinitely far where
/// none hits.
#[inline(always)]
fn nearest<P: Real, L: Lanes<Elem = P>>(met: L::Mask, hit: Hit<L>, ids: &[u32]) -> TriangleHit<P> {
    let mut lanes = [[P::ZERO; WIDTH]; 2];
    hit.beta.store(&mut lanes[0]);
    hit.gamma.store(&mut lanes[1]);
    let t = L::select(met, hit.t, hit.t.constant(P::INFINITY));
    let least = least(t);
    let lane = L::bits(t.le(t.constant(least))).trailing_zeros() as usize % WIDTH;
    let hit = Hit { t: least, beta: lanes[0][lane], gamma: lanes[1][lane] };
    TriangleHit { triangle: ids[lane % L::N], hit }
}
