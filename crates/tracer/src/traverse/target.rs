//! What rays go through.

use std::ops::Range;

use trisect_core::Lanes;

use crate::bvh::wide::WideTree;
use crate::leaf::erased::LeafTester;
use crate::query::Query;
use crate::rays::batch::{RAYS, Work};

/// A tree that so many rays at a time go through: with a method's test in the loop, or with its leaves behind calls.
pub(crate) trait Target<'a, Q: Query, const N: usize = RAYS>: Copy {
    /// Whether a loop over single rays reads the numbers of a ray [side by side](crate::rays::batch::RayBatch::line).
    const LINES: bool;
    /// What is known of the hits of these rays.
    type Hits;
    /// What that is made from.
    type Seed;
    /// The nodes.
    fn tree(self) -> &'a WideTree;

    /// Nothing is known so far.
    fn hits(seed: Self::Seed) -> Self::Hits;

    /// Begins with other rays.
    fn clear(self, hits: &mut Self::Hits);

    /// Tests a leaf for one ray, whose interval ends at its best hit from then on; whether it has hit anything so
    /// far.
    fn test<L: Lanes<Elem = f32>>(
        self,
        token: L::Token,
        query: Q,
        work: &mut Work<Self::Hits, N>,
        index: usize,
        leaf: Range<usize>,
    ) -> bool;

    /// What rays have found that have left the tree. `L` are lanes whose instructions are at hand.
    fn finish<L: Lanes>(self, work: &mut Work<Self::Hits, N>) -> &[Q::Found; N];
}

/// A tree that packets of rays go through as well.
pub(crate) trait PacketTarget<'a, Q: Query>: Target<'a, Q> {
    /// What tests leaves for packets.
    type Packets<L: Lanes<Elem = f32>>: LeafTester<Q::Found>;

    /// What tests leaves for packets.
    fn packets<L: Lanes<Elem = f32>>(
        self,
        token: L::Token,
        query: Q,
        seed: Self::Seed,
    ) -> Self::Packets<L>;
}

/// A tree whose leaves are behind calls.
#[derive(Clone, Copy)]
pub(crate) struct ThroughCalls<'a>(pub(crate) &'a WideTree);

impl<'a, Q: Query<Found: 'a>> Target<'a, Q> for ThroughCalls<'a> {
    const LINES: bool = false;
    type Hits = &'a mut (dyn LeafTester<Q::Found> + 'a);
    type Seed = Self::Hits;

    #[inline(always)]
    fn tree(self) -> &'a WideTree {
        self.0
    }

    #[inline(always)]
    fn hits(seed: Self::Hits) -> Self::Hits {
        seed
    }

    #[inline(always)]
    fn clear(self, hits: &mut Self::Hits) {
        hits.clear();
    }

    #[inline(always)]
    fn test<L: Lanes<Elem = f32>>(
        self,
        _: L::Token,
        _: Q,
        Work { rays, hits }: &mut Work<Self::Hits>,
        index: usize,
        leaf: Range<usize>,
    ) -> bool {
        hits.test(rays, 1 << (index % RAYS), leaf)
    }

    #[inline(always)]
    fn finish<L: Lanes>(self, Work { rays, hits }: &mut Work<Self::Hits>) -> &[Q::Found; RAYS] {
        hits.finish(rays)
    }
}

impl<'a, Q: Query<Found: 'a>> PacketTarget<'a, Q> for ThroughCalls<'a> {
    type Packets<L: Lanes<Elem = f32>> = Self::Hits;

    #[inline(always)]
    fn packets<L: Lanes<Elem = f32>>(
        self,
        _: L::Token,
        _: Q,
        seed: Self::Hits,
    ) -> Self::Packets<L> {
        seed
    }
}
