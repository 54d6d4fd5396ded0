//! What a leaf does for a query.

use std::ops::Range;

use trisect_core::Lanes;
use trisect_method::{Culling, Interval, Method, Of};

use super::blocks::{Block, Blocks};
use super::report::Reports;
use crate::hit::TriangleHit;
use crate::precision::Real;
use crate::query::{Boxes, Faces, Query};
use crate::rays::batch::{Gather, RAYS, Rays};

/// A query, as the leaves of a method answer it.
pub(crate) trait LeafQuery<M: Method, P: Real = f32>: Query {
    /// What is known of the hits of one ray on its way.
    type Best: Copy;
    /// Room for what is computed when so many rays have left the tree.
    type Room<const N: usize>;
    /// What is known before any test.
    const NOTHING: Self::Best;
    /// The room before anything is in it.
    fn room<const N: usize>() -> Self::Room<N>;

    /// The faces that are not seen.
    fn culling(self) -> Culling;

    /// Whether anything was hit.
    fn is_hit(best: &Self::Best) -> bool;

    /// Where a ray's interval ends after its best hit; not later than `tmax`.
    fn end(best: &Self::Best, tmax: P) -> P;

    /// Tests a ray against as many triangles of a block as there are lanes, from `lane` on, and takes what is
    /// better than the best. The lanes that are left to be [settled](LeafQuery::settle), in bits.
    fn test<L: Lanes<Elem = P>>(
        self,
        ray: &M::PreparedRay<L>,
        triangles: &Of<M::Prepared, L>,
        interval: Interval<L>,
        block: InBlock<'_, M, P>,
        best: &mut Self::Best,
    ) -> u64;

    /// Takes what is better than the best of what a test has left. A method that rounds leaves nothing.
    #[inline(always)]
    fn settle<const N: usize>(
        self,
        _blocks: &Blocks<M, P>,
        _rays: &impl Rays<P, N>,
        _index: usize,
        _left: Left,
        _best: &mut Self::Best,
    ) {
    }

    /// Tests rays of a packet, in bits, against the triangles of a leaf, as many rays at a time as there are lanes,
    /// with both faces seen. Whether any of them has hit anything so far, and the rays that are left to be tested
    /// one by one.
    #[inline(always)]
    fn test_packet<L: Lanes<Elem = P>>(
        _token: L::Token,
        _blocks: &Blocks<M, P>,
        _leaf: &Range<usize>,
        _rays: &mut impl Gather<P>,
        _best: &mut [Self::Best; RAYS],
        which: u64,
    ) -> (bool, u64) {
        (false, which)
    }

    /// What rays have found that have left the tree. `L` are lanes whose instructions are at hand.
    fn finish<'a, L: Lanes, const N: usize>(
        blocks: &Blocks<M, P>,
        rays: &impl Rays<P, N>,
        hits: &'a mut HitsOf<M, Self, P, N>,
    ) -> &'a [Self::Found; N];
}

/// Which triangles of which block.
pub(crate) struct InBlock<'a, M: Method, P: Real> {
    pub(crate) block: &'a Block<M, P>,
    /// The index of the block.
    pub(crate) at: usize,
    /// The first lane.
    pub(crate) lane: usize,
}

/// What a test of a leaf has left to be settled: the lanes of the first of some blocks, in bits, and all lanes of
/// the others. Nothing where there are no bits.
pub(crate) struct Left {
    pub(crate) blocks: Range<usize>,
    pub(crate) lanes: u64,
}

/// What is known of the hits of some rays.
pub(crate) struct Hits<B, R, const N: usize> {
    pub(crate) best: [B; N],
    pub(crate) room: R,
}

/// What is known of the hits of some rays that ask a query.
pub(crate) type HitsOf<M, Q, P = f32, const N: usize = RAYS> =
    Hits<<Q as LeafQuery<M, P>>::Best, <Q as LeafQuery<M, P>>::Room<N>, N>;

impl<B: Copy, R, const N: usize> Hits<B, R, N> {
    /// Nothing so far.
    #[inline(always)]
    pub(crate) fn new<M: Method, P: Real, Q: LeafQuery<M, P, Best = B, Room<N> = R>>() -> Self {
        Self { best: [Q::NOTHING; N], room: Q::room::<N>() }
    }

    /// For other rays: nothing so far.
    #[inline(always)]
    pub(crate) fn clear<M: Method, P: Real, Q: LeafQuery<M, P, Best = B>>(&mut self) {
        self.best = [Q::NOTHING; N];
    }
}

/// Where an interval ends after a hit at `t`; not later than `tmax`.
#[inline(always)]
pub(crate) fn end_after<B: Boxes, P: Real>(t: P, tmax: P) -> P {
    if B::LATE {
        // What is nearer may have the same rounded `t`, and the quotient may round to a tie that the
        // numerators do not show: a triangle of a lower id must not be lost to that.
        Lanes::min(t + (t.abs() * P::ROUNDINGS + P::UNDERFLOW), tmax)
    } else {
        t
    }
}

/// Which leaf queries a method has: those that round, or those that are exact.
pub(crate) trait Queries<M: Method, P: Real = f32>:
    Reports<M, P> + Send + Sync + 'static
{
    /// Whether a loop over single rays reads the numbers of a ray [side by side](RayBatch::line).
    const LINES: bool;
    /// The nearest hit.
    type Closest<B: Boxes, F: Faces>: LeafQuery<M, P, Found = TriangleHit<P>, Output = Option<TriangleHit<P>>>;

    /// The nearest hit of a face that is seen.
    fn closest<B: Boxes, F: Faces>(faces: F) -> Self::Closest<B, F>;
}
