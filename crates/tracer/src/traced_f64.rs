//! Trees of f64: their boxes are those of a tree of f32, in a [frame](crate::bvh::frame) of its own, and their leaves
//! are tested in f64. Rays go down alone, whatever is asked of how many.

use std::ops::Range;

use trisect_core::{Lanes, Ray, Token, Triangle};
use trisect_method::{Culling, ExactMethod, Method, Refine, UnsuitableMesh};

use crate::bvh::builders::settings::{Builder, Leaves};
use crate::bvh::frame::Span;
use crate::bvh::wide::WideTree;
use crate::dispatch::{Tracing, assert_room};
use crate::hit::TriangleHit;
use crate::hits::{Crossings, Source, Verdict, as_tested, lanes_of};
use crate::lanes::on_fast_lanes;
use crate::leaf::blocks::Blocks;
use crate::leaf::erased::{LeafData, MethodLeaves};
use crate::leaf::exact::Exactly;
use crate::leaf::query::{Hits, HitsOf, LeafQuery, Queries};
use crate::leaf::single::{AtLeaf, Rounded, test_ray};
use crate::parallel::fill;
use crate::precision::{Entry, Real as _};
use crate::query::{Any, Widened};
use crate::rays::batch::{Rays, Work};
use crate::traced::{TracedIn, built};
use crate::traverse::target::Target;
use crate::traverse::trace::TraceOne;

/// A tree with the leaves of a method.
struct TreeOf<M: Method, K> {
    tree: WideTree,
    leaves: MethodLeaves<M, K, f64>,
}

/// Builds a tree of f64.
///
/// # Errors
/// When the method cannot take the mesh.
pub(crate) fn in_f64<M: Method>(
    triangles: &[Triangle<f64>],
    builder: Builder,
    leaves: Leaves,
) -> Result<Box<dyn TracedIn<f64>>, UnsuitableMesh> {
    let (tree, blocks) = built(triangles, builder, leaves)?;
    Ok(M::refine(Parts::<M>(tree, blocks)))
}

struct Parts<M: Method>(WideTree, Blocks<M, f64>);

impl<M: Method> Parts<M> {
    fn put<K: Queries<M, f64>>(self) -> Box<dyn TracedIn<f64>> {
        let Self(tree, blocks) = self;
        Box::new(TreeOf::<M, K> { tree, leaves: MethodLeaves::new(blocks) })
    }
}

impl<M: Method> Refine<M> for Parts<M> {
    type Output = Box<dyn TracedIn<f64>>;

    fn rounded(self) -> Box<dyn TracedIn<f64>> {
        self.put::<Rounded>()
    }

    fn exact(self) -> Box<dyn TracedIn<f64>>
    where
        M: ExactMethod,
    {
        self.put::<Exactly>()
    }
}

impl<M: Method, K: Queries<M, f64>> TreeOf<M, K> {
    /// Traces a ray in the loop that is compiled for the method. `None` where there is none for this processor, and
    /// where boxes say nothing about the ray.
    fn trace<Q: LeafQuery<M, f64>>(
        &self,
        query: Q,
        ray: &Ray<f64>,
        found: &mut Q::Output,
    ) -> Option<()> {
        let ray = as_tested(ray);
        match f64::enter(self.tree.frame.as_ref(), &ray) {
            Entry::Missed => Some(()),
            Entry::Boxes(boxed, span) => {
                let seed = Alone { ray: ray.map(|&x| [x]), span };
                on_fast_lanes(TraceOne { target: self, seed, query, ray: &boxed, found })
            }
            Entry::Everywhere => None,
        }
    }

    /// The way of queries for more than the nearest hit, which is compiled for every processor.
    fn source(&self, tracing: Tracing, culling: Culling) -> Source<'_, f64> {
        let (lanes, crossings) = (lanes_of(tracing), Crossings::Every);
        Source { traced: self, lanes, culling, crossings, counted: None }
    }

    fn closest_by(
        &self,
        tracing: Tracing,
        culling: Culling,
        ray: &Ray<f64>,
    ) -> Option<TriangleHit<f64>> {
        let mut found = None;
        let query = K::closest::<Widened, Culling>(culling);
        if tracing != Tracing::Plain && self.trace(query, ray, &mut found).is_some() {
            return found;
        }
        self.source(tracing, culling).filtered(ray, &mut |_| Verdict::Accept)
    }

    fn any_by(&self, tracing: Tracing, culling: Culling, ray: &Ray<f64>) -> bool {
        let mut found = false;
        let query = Any::<Widened, Culling>::new(culling);
        if tracing != Tracing::Plain && self.trace(query, ray, &mut found).is_some() {
            return found;
        }
        self.source(tracing, culling).filtered(ray, &mut |_| Verdict::End).is_some()
    }
}

impl<M: Method, K: Queries<M, f64>> TracedIn<f64> for TreeOf<M, K> {
    fn tree(&self) -> &WideTree {
        &self.tree
    }

    fn leaves(&self) -> &dyn LeafData<f64> {
        &self.leaves
    }

    fn parts(&mut self) -> (&mut WideTree, &mut dyn LeafData<f64>) {
        (&mut self.tree, &mut self.leaves)
    }

    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f64>],
        found: &mut [Option<TriangleHit<f64>>],
    ) {
        assert_room(rays, found);
        fill(rays, found, |_, ray| self.closest_by(tracing, culling, ray));
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f64>], found: &mut [bool]) {
        assert_room(rays, found);
        fill(rays, found, |_, ray| self.any_by(tracing, culling, ray));
    }

    fn closest_hit(&self, culling: Culling, ray: &Ray<f64>) -> Option<TriangleHit<f64>> {
        self.closest_by(Tracing::Single, culling, ray)
    }

    fn any_hit(&self, culling: Culling, ray: &Ray<f64>) -> bool {
        self.any_by(Tracing::Single, culling, ray)
    }
}

/// A ray, as leaves are asked about it, and how it goes through boxes.
struct Alone {
    ray: Ray<[f64; 1]>,
    span: Span,
}

impl Rays<f64, 1> for Alone {
    #[inline(always)]
    fn one(&self, _: usize) -> Ray<f64> {
        self.ray.map(|&[x]| x)
    }

    #[inline(always)]
    fn rows(&self) -> Ray<&[f64; 1]> {
        let Ray { o, d, tmin, tmax } = &self.ray;
        Ray { o: o.each_ref(), d: d.each_ref(), tmin, tmax }
    }
}

/// A ray, and what is known of its hits.
struct Asked<H> {
    ray: Alone,
    hits: H,
}

impl<'a, M, K, Q> Target<'a, Q, 1> for &'a TreeOf<M, K>
where
    M: Method,
    K: Queries<M, f64>,
    Q: LeafQuery<M, f64>,
{
    const LINES: bool = false;
    type Hits = Asked<HitsOf<M, Q, f64, 1>>;
    type Seed = Alone;

    #[inline(always)]
    fn tree(self) -> &'a WideTree {
        &self.tree
    }

    #[inline(always)]
    fn hits(ray: Alone) -> Self::Hits {
        Asked { ray, hits: Hits::new::<M, f64, Q>() }
    }

    #[inline(always)]
    fn clear(self, Asked { hits, .. }: &mut Self::Hits) {
        hits.clear::<M, f64, Q>();
    }

    #[inline(always)]
    fn test<L: Lanes<Elem = f32>>(
        self,
        token: L::Token,
        query: Q,
        Work { rays, hits: Asked { ray, hits } }: &mut Work<Self::Hits, 1>,
        index: usize,
        leaf: Range<usize>,
    ) -> bool {
        let [best] = &mut hits.best;
        let at_leaf = AtLeaf { blocks: &self.leaves.blocks, query, ray: ray.one(index) };
        let tmax = at_leaf.ray.tmax;
        let is_hit = test_ray::<M, f64, <L::Token as Token>::Doubles, Q, 1>(
            token,
            at_leaf,
            leaf,
            (&*ray, index),
            best,
        );
        if is_hit {
            let end = Q::end(best, tmax);
            ray.ray.tmax = [end];
            rays.end(index, ray.span.end(end));
        }
        is_hit
    }

    #[inline(always)]
    fn finish<L: Lanes>(
        self,
        Work { hits: Asked { ray, hits }, .. }: &mut Work<Self::Hits, 1>,
    ) -> &[Q::Found; 1] {
        Q::finish::<L, 1>(&self.leaves.blocks, ray, hits)
    }
}
