//! What rays are traced through: a tree with a method's test in its loops, or with the method behind calls.

use std::ops::Range;

use trisect_core::{Lanes, Ray, Triangle};
use trisect_method::{Culling, ExactMethod, Method, Refine, UnsuitableMesh};

use crate::bvh::builders;
use crate::bvh::builders::members::Kinds;
use crate::bvh::builders::settings::{Builder, Leaves};
use crate::bvh::wide::WideTree;
use crate::dispatch::{self, Traced, Tracing};
use crate::hit::{MaybeHit, TriangleHit};
use crate::lanes::on_fast_lanes;
use crate::leaf::blocks::Blocks;
use crate::leaf::erased::{ErasedLeaves, LeafData, MethodLeaves, Tester};
use crate::leaf::exact::Exactly;
use crate::leaf::query::{Hits, HitsOf, LeafQuery, Queries};
use crate::leaf::single::{AtLeaf, Rounded, test_ray};
use crate::precision::Real;
use crate::query::{Any, Both, Promised};
use crate::rays::batch::Work;
use crate::rays::reorder::Order;
use crate::traverse::target::{PacketTarget, Target};
use crate::traverse::trace::{Trace, TraceOne};

/// A tree, as it is traced.
pub(crate) trait TracedIn<P: Real>: Send + Sync {
    /// Its nodes.
    fn tree(&self) -> &WideTree;

    /// Its leaves, behind calls.
    fn leaves(&self) -> &dyn LeafData<P>;

    /// Both, to be changed.
    fn parts(&mut self) -> (&mut WideTree, &mut dyn LeafData<P>);

    /// The nearest hit of each ray.
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<P>],
        found: &mut [Option<TriangleHit<P>>],
    );

    /// Whether each ray hits anything.
    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<P>], found: &mut [bool]);

    /// The nearest hit of one ray, in a loop that is compiled for the method where there is one for this processor.
    fn closest_hit(&self, culling: Culling, ray: &Ray<P>) -> MaybeHit<P>;

    /// The same for any hit.
    fn any_hit(&self, culling: Culling, ray: &Ray<P>) -> bool;
}

/// A tree, as a [precision](crate::Precision) builds it.
pub struct Built<P>(pub(crate) Box<dyn TracedIn<P>>);

/// Builds the nodes of a tree, and prepares what is in its leaves.
///
/// # Errors
/// When the method cannot take the mesh.
pub(crate) fn built<M: Method, P: Real>(
    triangles: &[Triangle<P>],
    builder: Builder,
    leaves: Leaves,
) -> Result<(WideTree, Blocks<M, P>), UnsuitableMesh> {
    let kinds = Kinds::new::<M, P>(triangles)?;
    let is_robust = M::INFO.claims.watertight;
    let (in_boxes, frame) = P::in_frame(triangles);
    let (tree, members) = builders::build(&in_boxes, frame, builder, leaves, &kinds, is_robust);
    Ok((tree, Blocks::new(triangles, &members)))
}

/// A tree with the leaves of a method, whose test is in the loops of the tree or behind calls.
struct TreeOf<M: Method, K, const IN_LOOP: bool> {
    tree: WideTree,
    leaves: MethodLeaves<M, K>,
}

/// Builds a tree of f32.
///
/// # Errors
/// When the method cannot take the mesh.
pub(crate) fn in_f32<M: Method, const IN_LOOP: bool>(
    triangles: &[Triangle<f32>],
    builder: Builder,
    leaves: Leaves,
) -> Result<Box<dyn Traced>, UnsuitableMesh> {
    let (tree, blocks) = built(triangles, builder, leaves)?;
    Ok(M::refine(Parts::<M, IN_LOOP>(tree, blocks)))
}

struct Parts<M: Method, const IN_LOOP: bool>(WideTree, Blocks<M>);

impl<M: Method, const IN_LOOP: bool> Parts<M, IN_LOOP> {
    fn put<K: Queries<M>>(self) -> Box<dyn Traced> {
        let Self(tree, blocks) = self;
        Box::new(TreeOf::<M, K, IN_LOOP> { tree, leaves: MethodLeaves::new(blocks) })
    }
}

impl<M: Method, const IN_LOOP: bool> Refine<M> for Parts<M, IN_LOOP> {
    type Output = Box<dyn Traced>;

    fn rounded(self) -> Box<dyn Traced> {
        self.put::<Rounded>()
    }

    fn exact(self) -> Box<dyn Traced>
    where
        M: ExactMethod,
    {
        self.put::<Exactly>()
    }
}

impl<M: Method, K: Queries<M>, const IN_LOOP: bool> TreeOf<M, K, IN_LOOP> {
    fn trace<Q: LeafQuery<M>>(
        &self,
        query: Q,
        rays: &[Ray<f32>],
        order: &Order,
        found: &mut [Q::Output],
    ) -> bool {
        // What is not in the loops is not compiled either.
        if const { IN_LOOP } {
            on_fast_lanes(Trace { target: self, seed: (), query, rays, order, found }).is_some()
        } else {
            false
        }
    }

    #[inline(always)]
    fn trace_one<Q: LeafQuery<M>>(&self, query: Q, ray: &Ray<f32>) -> Option<Q::Packed> {
        if const { IN_LOOP } {
            on_fast_lanes(TraceOne { target: self, seed: (), query, ray })
        } else {
            None
        }
    }
}

impl<M: Method, K: Queries<M>, const IN_LOOP: bool> Traced for TreeOf<M, K, IN_LOOP> {
    fn erased(&self) -> &dyn ErasedLeaves {
        &self.leaves
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

impl<M: Method, K: Queries<M>, const IN_LOOP: bool> TracedIn<f32> for TreeOf<M, K, IN_LOOP> {
    fn tree(&self) -> &WideTree {
        &self.tree
    }

    fn leaves(&self) -> &dyn LeafData<f32> {
        &self.leaves
    }

    fn parts(&mut self) -> (&mut WideTree, &mut dyn LeafData<f32>) {
        (&mut self.tree, &mut self.leaves)
    }

    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        dispatch::closest(self, tracing, culling, rays, found);
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        dispatch::any(self, tracing, culling, rays, found);
    }

    fn closest_hit(&self, culling: Culling, ray: &Ray<f32>) -> MaybeHit {
        self.trace_one(K::closest::<Promised<M>, Culling>(culling), ray)
            .map_or_else(|| dispatch::closest_of(self, culling, ray).into(), MaybeHit)
    }

    fn any_hit(&self, culling: Culling, ray: &Ray<f32>) -> bool {
        self.trace_one(Any::<Promised<M>, Culling>::new(culling), ray)
            .unwrap_or_else(|| dispatch::any_of(self, culling, ray))
    }
}

/// The tree itself, not a pair of nodes and leaves: what is behind one pointer is at hand in a register, which is
/// worth a tenth.
impl<'a, M, K, Q, const IN_LOOP: bool, const N: usize> Target<'a, Q, N>
    for &'a TreeOf<M, K, IN_LOOP>
where
    M: Method,
    K: Queries<M>,
    Q: LeafQuery<M>,
{
    const LINES: bool = K::LINES;
    type Hits = HitsOf<M, Q, f32, N>;
    type Seed = ();

    #[inline(always)]
    fn tree(self) -> &'a WideTree {
        &self.tree
    }

    #[inline(always)]
    fn hits((): ()) -> Self::Hits {
        Hits::new::<M, f32, Q>()
    }

    #[inline(always)]
    fn clear(self, hits: &mut Self::Hits) {
        hits.clear::<M, f32, Q>();
    }

    #[inline(always)]
    fn test<L: Lanes<Elem = f32>>(
        self,
        token: L::Token,
        query: Q,
        Work { rays, hits }: &mut Work<Self::Hits, N>,
        index: usize,
        leaf: Range<usize>,
    ) -> bool {
        let ray = if const { K::LINES } { rays.line(index) } else { rays.ray(index) };
        let best = &mut hits.best[index % N];
        let at_leaf = AtLeaf { blocks: &self.leaves.blocks, query, ray };
        let is_hit = test_ray::<M, f32, L, Q, N>(token, at_leaf, leaf, (rays, index), best);
        if is_hit {
            rays.end(index, Q::end(best, ray.tmax));
        }
        is_hit
    }

    #[inline(always)]
    fn finish<L: Lanes>(self, Work { rays, hits }: &mut Work<Self::Hits, N>) -> &[Q::Found; N] {
        Q::finish::<L, N>(&self.leaves.blocks, rays, hits)
    }
}

impl<'a, M, K, Q, const IN_LOOP: bool> PacketTarget<'a, Q> for &'a TreeOf<M, K, IN_LOOP>
where
    M: Method,
    K: Queries<M>,
    Q: LeafQuery<M>,
{
    type Packets<L: Lanes<Elem = f32>> = Tester<'a, M, L, Q>;

    #[inline(always)]
    fn packets<L: Lanes<Elem = f32>>(self, token: L::Token, query: Q, (): ()) -> Self::Packets<L> {
        Tester::new(&self.leaves.blocks, token, query)
    }
}
