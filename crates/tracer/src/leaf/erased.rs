//! Leaves behind a call: what goes through the nodes of a tree does not know the method, and is compiled once.

use std::hint::select_unpredictable;
use std::marker::PhantomData;
use std::ops::Range;

use trisect_core::{Lanes, Token as _, Triangle};
use trisect_method::{Culling, Method, UnsuitableMesh};

use super::blocks::Blocks;
use super::query::{Hits, HitsOf, LeafQuery, Queries};
use super::report::{ExactLeaves, Reporting, WithReporter};
use super::single::{AtLeaf, test_ray};
use crate::bvh::builders::members::{Kinds, Members};
use crate::hit::TriangleHit;
use crate::lanes::{Job, PlainLanes, on_fast_lanes};
use crate::precision::Real;
use crate::query::{Any, Promised, Robust};
use crate::rays::batch::{Gather as _, RAYS, RayBatch};
use crate::vectors::WIDTH;

/// Tests the leaves of a tree for a batch of rays, and keeps their hits.
pub(crate) trait LeafTester<F> {
    /// Begins another batch.
    fn clear(&mut self);

    /// Prefetches a block.
    fn prefetch(&self, block: usize);

    /// Tests a leaf for some rays of the batch, in bits, whose intervals end at their best hits from then on; whether
    /// any of them has hit anything so far.
    fn test(&mut self, rays: &mut RayBatch, which: u64, leaf: Range<usize>) -> bool;

    /// What rays have found that have left the tree.
    fn finish(&mut self, rays: &RayBatch) -> &[F; RAYS];
}

impl<F> LeafTester<F> for &mut (dyn LeafTester<F> + '_) {
    #[inline(always)]
    fn clear(&mut self) {
        (**self).clear();
    }

    #[inline(always)]
    fn prefetch(&self, block: usize) {
        (**self).prefetch(block);
    }

    #[inline(always)]
    fn test(&mut self, rays: &mut RayBatch, which: u64, leaf: Range<usize>) -> bool {
        (**self).test(rays, which, leaf)
    }

    #[inline(always)]
    fn finish(&mut self, rays: &RayBatch) -> &[F; RAYS] {
        (**self).finish(rays)
    }
}

/// Tests the leaves of a method on some lanes.
pub(crate) struct Tester<'a, M: Method, L: Lanes, Q: LeafQuery<M>> {
    blocks: &'a Blocks<M>,
    token: L::Token,
    query: Q,
    hits: HitsOf<M, Q>,
}

impl<'a, M: Method, L: Lanes, Q: LeafQuery<M>> Tester<'a, M, L, Q> {
    #[inline(always)]
    pub(crate) fn new(blocks: &'a Blocks<M>, token: L::Token, query: Q) -> Self {
        Self { blocks, token, query, hits: Hits::new::<M, f32, Q>() }
    }
}

impl<M, L, Q> LeafTester<Q::Found> for Tester<'_, M, L, Q>
where
    M: Method,
    L: Lanes<Elem = f32>,
    Q: LeafQuery<M>,
{
    fn clear(&mut self) {
        self.hits.clear::<M, f32, Q>();
    }

    fn prefetch(&self, block: usize) {
        self.blocks.prefetch(block);
    }

    fn test(&mut self, rays: &mut RayBatch, mut which: u64, leaf: Range<usize>) -> bool {
        let Self { blocks, token, query, ref mut hits } = *self;
        token.run(
            #[inline(always)]
            || {
                let mut any = false;
                // Not where faces are culled, which is rarely asked for.
                if query.culling() == Culling::None {
                    let best = &mut hits.best;
                    (any, which) = Q::test_packet::<L>(token, blocks, &leaf, rays, best, which);
                }
                while which != 0 {
                    let index = which.trailing_zeros() as usize % RAYS;
                    which &= which - 1;
                    let (ray, best) = (rays.ray(index), &mut hits.best[index]);
                    let at_leaf = AtLeaf { blocks, query, ray };
                    let of = (&*rays, index);
                    let is_hit =
                        test_ray::<M, f32, L, Q, RAYS>(token, at_leaf, leaf.clone(), of, best);
                    any |= is_hit;
                    let tmax = Q::end(best, ray.tmax);
                    rays.shorten(index, select_unpredictable(is_hit, tmax, ray.tmax));
                }
                any
            },
        )
    }

    fn finish(&mut self, rays: &RayBatch) -> &[Q::Found; RAYS] {
        let Self { blocks, token, ref mut hits, .. } = *self;
        token.run(
            #[inline(always)]
            || Q::finish::<L, RAYS>(blocks, rays, hits),
        )
    }
}

/// What is done with the tester of a batch.
pub(crate) type With<'a, F> = &'a mut dyn FnMut(&mut dyn LeafTester<F>);

/// The leaves of a tree, whatever the method.
pub(crate) trait LeafData<P>: Send + Sync {
    /// Calls `with` for all hits of faces that are seen: on plain lanes, or where none are named on fast ones.
    fn reporter(&self, lanes: Option<PlainLanes>, culling: Culling, with: WithReporter<'_, P>);

    /// What is known exactly; none of a method that rounds.
    fn exact(&self) -> Option<&dyn ExactLeaves<P>>;

    /// The ids of the triangles of a block.
    fn triangles(&self, block: usize) -> &[u32; WIDTH];

    /// How many blocks there are.
    fn count(&self) -> usize;

    /// Bytes of all blocks.
    fn bytes(&self) -> usize;

    /// The kinds of triangles.
    ///
    /// # Errors
    /// When the method cannot take the mesh.
    fn kinds(&self, triangles: &[Triangle<P>]) -> Result<Kinds, UnsuitableMesh>;

    /// Prepares the triangles of each block anew.
    fn prepare(&mut self, triangles: &[Triangle<P>], members: &[Members]);
}

/// The leaves of a tree that loops go through which are compiled once for all methods.
pub(crate) trait ErasedLeaves: LeafData<f32> {
    /// Calls `with` for the nearest hits of faces that are seen, on fast lanes; not where the processor has
    /// none.
    fn closest(&self, culling: Culling, with: With<'_, TriangleHit>);

    /// The same for any hits.
    fn any(&self, culling: Culling, with: With<'_, bool>);

    /// Calls `with` for the nearest hits of faces that are seen, in plain arithmetic.
    fn plain(&self, lanes: PlainLanes, culling: Culling, with: With<'_, TriangleHit>);
}

/// The leaves of a tree.
pub(crate) struct MethodLeaves<M: Method, K, P: Real = f32> {
    pub(crate) blocks: Blocks<M, P>,
    queries: PhantomData<fn() -> K>,
}

impl<M: Method, K: Queries<M, P>, P: Real> MethodLeaves<M, K, P> {
    pub(crate) fn new(blocks: Blocks<M, P>) -> Self {
        Self { blocks, queries: PhantomData }
    }
}

impl<M: Method, K: Queries<M>> ErasedLeaves for MethodLeaves<M, K> {
    fn closest(&self, culling: Culling, with: With<'_, TriangleHit>) {
        let query = K::closest::<Promised<M>, Culling>(culling);
        on_fast_lanes(WithTester { blocks: &self.blocks, query, with });
    }

    fn any(&self, culling: Culling, with: With<'_, bool>) {
        let query = Any::<Promised<M>, Culling>::new(culling);
        on_fast_lanes(WithTester { blocks: &self.blocks, query, with });
    }

    fn plain(&self, lanes: PlainLanes, culling: Culling, with: With<'_, TriangleHit>) {
        let query = K::closest::<Robust, Culling>(culling);
        lanes.run(WithTester { blocks: &self.blocks, query, with });
    }
}

impl<M: Method, K: Queries<M, P>, P: Real> LeafData<P> for MethodLeaves<M, K, P> {
    fn reporter(&self, lanes: Option<PlainLanes>, culling: Culling, with: WithReporter<'_, P>) {
        let reporting =
            Reporting::<M, K, P> { blocks: &self.blocks, culling, with, reports: PhantomData };
        match lanes {
            Some(lanes) => lanes.run(reporting),
            None => on_fast_lanes(reporting).unwrap_or_default(),
        }
    }

    fn exact(&self) -> Option<&dyn ExactLeaves<P>> {
        K::exact(&self.blocks)
    }

    fn triangles(&self, block: usize) -> &[u32; WIDTH] {
        &self.blocks.blocks[block].triangles
    }

    fn count(&self) -> usize {
        self.blocks.blocks.len()
    }

    fn bytes(&self) -> usize {
        self.blocks.bytes()
    }

    fn kinds(&self, triangles: &[Triangle<P>]) -> Result<Kinds, UnsuitableMesh> {
        Kinds::new::<M, P>(triangles)
    }

    fn prepare(&mut self, triangles: &[Triangle<P>], members: &[Members]) {
        self.blocks = Blocks::new(triangles, members);
    }
}

/// Makes a tester on lanes of choice.
struct WithTester<'a, M: Method, Q: LeafQuery<M>> {
    blocks: &'a Blocks<M>,
    query: Q,
    with: With<'a, Q::Found>,
}

impl<M: Method, Q: LeafQuery<M>> Job for WithTester<'_, M, Q> {
    type Output = ();

    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { blocks, query, with } = self;
        with(&mut Tester::<M, L, Q>::new(blocks, token, query));
    }
}
