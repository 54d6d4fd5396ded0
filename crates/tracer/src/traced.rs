//! What rays are traced through: a tree with a method's test in its loops, or with the method behind calls.

use std::ops::Range;

use trisect_core::{Lanes, Ray};
use trisect_method::{ExactMethod, Method, Refine};

use crate::bvh::wide::WideTree;
use crate::dispatch::Traced;
use crate::hit::TriangleHit;
use crate::lanes::on_fast_lanes;
use crate::leaf::blocks::Blocks;
use crate::leaf::erased::{Erase, ErasedLeaves, MethodLeaves, Tester};
use crate::leaf::exact::Exactly;
use crate::leaf::query::{Hits, LeafQuery, Queries};
use crate::leaf::single::{AtLeaf, Rounded, test_ray};
use crate::query::{Any, Both, Promised};
use crate::rays::batch::{RAYS, Work};
use crate::rays::reorder::Order;
use crate::traverse::target::Target;
use crate::traverse::trace::Trace;

/// See [`in_loop`].
struct InLoop<M: Method, K> {
    tree: WideTree,
    leaves: MethodLeaves<M, K>,
}

/// A tree with a method's test in its loops.
pub(crate) fn in_loop<M: Method>(tree: WideTree, blocks: Blocks<M>) -> Box<dyn Traced> {
    M::refine(PutInLoop(tree, blocks))
}

struct PutInLoop<M: Method>(WideTree, Blocks<M>);

impl<M: Method> Refine<M> for PutInLoop<M> {
    type Output = Box<dyn Traced>;

    fn rounded(self) -> Box<dyn Traced> {
        Box::new(InLoop { tree: self.0, leaves: MethodLeaves::<M, Rounded>::new(self.1) })
    }

    fn exact(self) -> Box<dyn Traced>
    where
        M: ExactMethod,
    {
        Box::new(InLoop { tree: self.0, leaves: MethodLeaves::<M, Exactly>::new(self.1) })
    }
}

impl<M: Method, K: Queries<M>> InLoop<M, K> {
    fn trace<Q: LeafQuery<M>>(
        &self,
        query: Q,
        rays: &[Ray<f32>],
        order: &Order,
        found: &mut [Q::Output],
    ) -> bool {
        on_fast_lanes(Trace { target: self, seed: (), query, rays, order, found }).is_some()
    }
}

impl<M: Method, K: Queries<M>> Traced for InLoop<M, K> {
    fn tree(&self) -> &WideTree {
        &self.tree
    }

    fn leaves(&self) -> &dyn ErasedLeaves {
        &self.leaves
    }

    fn parts(&mut self) -> (&mut WideTree, &mut dyn ErasedLeaves) {
        (&mut self.tree, &mut self.leaves)
    }

    fn closest_in_loop(
        &self,
        rays: &[Ray<f32>],
        order: &Order,
        found: &mut [Option<TriangleHit>],
    ) -> bool {
        self.trace(K::closest::<Promised<M>, Both>(Both), rays, order, found)
    }

    fn any_in_loop(&self, rays: &[Ray<f32>], order: &Order, found: &mut [bool]) -> bool {
        self.trace(Any::<Promised<M>, Both>::new(Both), rays, order, found)
    }
}

/// The tree itself, not a pair of nodes and leaves: what is behind one pointer is at hand in a register, which is
/// worth a tenth.
impl<'a, M, K, Q> Target<'a, Q> for &'a InLoop<M, K>
where
    M: Method,
    K: Queries<M>,
    Q: LeafQuery<M>,
{
    const LINES: bool = K::LINES;
    type Hits = Hits<Q::Best, Q::Room>;
    type Seed = ();
    type Packets<L: Lanes<Elem = f32>> = Tester<'a, M, L, Q>;

    #[inline(always)]
    fn tree(self) -> &'a WideTree {
        &self.tree
    }

    #[inline(always)]
    fn hits((): ()) -> Self::Hits {
        Hits::new::<M, Q>()
    }

    #[inline(always)]
    fn clear(self, hits: &mut Self::Hits) {
        hits.clear::<M, Q>();
    }

    #[inline(always)]
    fn test<L: Lanes<Elem = f32>>(
        self,
        token: L::Token,
        query: Q,
        Work { rays, hits }: &mut Work<Self::Hits>,
        index: usize,
        leaf: Range<usize>,
    ) -> bool {
        let ray = if const { K::LINES } { rays.line(index) } else { rays.ray(index) };
        let best = &mut hits.best[index % RAYS];
        let at_leaf = AtLeaf { blocks: &self.leaves.blocks, query, ray };
        let is_hit = test_ray::<M, L, Q>(token, at_leaf, leaf, (rays, index), best);
        if is_hit {
            rays.end(index, Q::end(best, ray.tmax));
        }
        is_hit
    }

    #[inline(always)]
    fn finish(self, Work { rays, hits }: &mut Work<Self::Hits>) -> &[Q::Found; RAYS] {
        Q::finish(&self.leaves.blocks, rays, hits)
    }

    #[inline(always)]
    fn packets<L: Lanes<Elem = f32>>(self, token: L::Token, query: Q, (): ()) -> Self::Packets<L> {
        Tester::new(&self.leaves.blocks, token, query)
    }
}

/// See [`behind_calls`].
struct BehindCalls {
    tree: WideTree,
    leaves: Box<dyn ErasedLeaves>,
}

/// A tree with its leaves behind calls.
pub(crate) fn behind_calls<M: Method>(tree: WideTree, blocks: Blocks<M>) -> Box<dyn Traced> {
    Box::new(BehindCalls { tree, leaves: M::refine(Erase(blocks)) })
}

impl Traced for BehindCalls {
    fn tree(&self) -> &WideTree {
        &self.tree
    }

    fn leaves(&self) -> &dyn ErasedLeaves {
        &*self.leaves
    }

    fn parts(&mut self) -> (&mut WideTree, &mut dyn ErasedLeaves) {
        (&mut self.tree, &mut *self.leaves)
    }
}
