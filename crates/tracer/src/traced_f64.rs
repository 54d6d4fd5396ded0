//! Trees of f64: their boxes are those of a tree of f32, in a [frame](crate::bvh::frame) of its own, and their leaves
//! are tested in f64. Rays of a batch go down each on its own way, never in packets.

use std::ops::Range;

use trisect_core::{Lanes, Ray, Token, Triangle, Vec3};
use trisect_method::{Culling, ExactMethod, Method, Refine, UnsuitableMesh};

use crate::bvh::builders::settings::{Builder, Leaves};
use crate::bvh::frame::Span;
use crate::bvh::wide::WideTree;
use crate::dispatch::{Tracing, assert_room};
use crate::hit::{MaybeHit, TriangleHit};
use crate::hits::{Crossings, Source, Verdict, as_tested, lanes_of};
use crate::lanes::on_fast_lanes;
use crate::leaf::blocks::Blocks;
use crate::leaf::erased::{LeafData, MethodLeaves};
use crate::leaf::exact::Exactly;
use crate::leaf::query::{Hits, HitsOf, LeafQuery, Queries};
use crate::leaf::single::{AtLeaf, Rounded, test_ray};
use crate::parallel::{self, PART, Task, fill};
use crate::precision::{Entry, Real as _};
use crate::query::{Any, Widened};
use crate::rays::batch::{NO_RAY, RAYS, Rays, Work};
use crate::traced::{TracedIn, built};
use crate::traverse::target::Target;
use crate::traverse::trace::{TraceOne, TraceSingly};

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
    fn trace<Q: LeafQuery<M, f64>>(&self, query: Q, ray: &Ray<f64>) -> Option<Q::Packed> {
        let ray = as_tested(ray);
        match f64::enter(self.tree.frame.as_ref(), &ray) {
            Entry::Missed => Some(Q::pack(Q::MISS)),
            Entry::Boxes(boxed, span) => {
                let seed = Given { rays: ray.map(|&x| [x]), spans: [span] };
                on_fast_lanes(TraceOne { target: self, seed, query, ray: &boxed })
            }
            Entry::Everywhere => None,
        }
    }

    /// Traces rays in such a loop on the threads of the pool that it is called in, or each by `other`.
    fn trace_all<Q: LeafQuery<M, f64>>(
        &self,
        query: Q,
        rays: &[Ray<f64>],
        found: &mut [Q::Output],
        other: impl Fn(&Ray<f64>) -> Q::Output + Sync,
    ) {
        let other = &other;
        let parts = rays.chunks(PART).zip(found.chunks_mut(PART));
        parallel::all(parts.map(|(rays, found)| -> Task<'_> {
            Box::new(move || {
                for (rays, found) in rays.chunks(RAYS).zip(found.chunks_mut(RAYS)) {
                    self.trace_batch(query, rays, found, other);
                }
            })
        }));
    }

    /// The same for [so many rays](RAYS) at most, by the calling thread.
    fn trace_batch<Q: LeafQuery<M, f64>>(
        &self,
        query: Q,
        rays: &[Ray<f64>],
        found: &mut [Q::Output],
        other: &impl Fn(&Ray<f64>) -> Q::Output,
    ) {
        let mut boxed = [NO_RAY; RAYS];
        let mut seed = Given::<RAYS>::NOTHING;
        let mut others = 0_u64;
        for (index, ray) in rays.iter().enumerate() {
            let ray = as_tested(ray);
            match f64::enter(self.tree.frame.as_ref(), &ray) {
                Entry::Missed => {}
                Entry::Boxes(entered, span) => {
                    boxed[index] = entered;
                    seed.set(index, &ray, span);
                }
                Entry::Everywhere => others |= 1 << index,
            }
        }
        let boxed = &boxed[..rays.len()];
        if on_fast_lanes(TraceSingly { target: self, seed, query, rays: boxed, found }).is_none() {
            others = u64::MAX;
        }
        for (index, (ray, found)) in rays.iter().zip(found).enumerate() {
            if others >> index & 1 != 0 {
                *found = other(ray);
            }
        }
    }

    /// The nearest hit by the way of queries for more than that, which is compiled for every processor.
    fn closest_by_walk(
        &self,
        tracing: Tracing,
        culling: Culling,
        ray: &Ray<f64>,
    ) -> Option<TriangleHit<f64>> {
        self.first(tracing, culling, ray, Verdict::Accept)
    }

    fn any_by_walk(&self, tracing: Tracing, culling: Culling, ray: &Ray<f64>) -> bool {
        self.first(tracing, culling, ray, Verdict::End).is_some()
    }

    fn first(
        &self,
        tracing: Tracing,
        culling: Culling,
        ray: &Ray<f64>,
        verdict: Verdict,
    ) -> Option<TriangleHit<f64>> {
        let (lanes, crossings) = (lanes_of(tracing), Crossings::Every);
        let source = Source { traced: self, lanes, culling, crossings, counted: None };
        source.filtered(ray, &mut |_| verdict)
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
        let by_walk = |ray: &Ray<f64>| self.closest_by_walk(tracing, culling, ray);
        if tracing == Tracing::Plain {
            fill(rays, found, |_, ray| by_walk(ray));
        } else {
            self.trace_all(K::closest::<Widened, Culling>(culling), rays, found, by_walk);
        }
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f64>], found: &mut [bool]) {
        assert_room(rays, found);
        let by_walk = |ray: &Ray<f64>| self.any_by_walk(tracing, culling, ray);
        if tracing == Tracing::Plain {
            fill(rays, found, |_, ray| by_walk(ray));
        } else {
            self.trace_all(Any::<Widened, Culling>::new(culling), rays, found, by_walk);
        }
    }

    fn closest_hit(&self, culling: Culling, ray: &Ray<f64>) -> MaybeHit<f64> {
        self.trace(K::closest::<Widened, Culling>(culling), ray)
            .map_or_else(|| self.closest_by_walk(Tracing::Single, culling, ray).into(), MaybeHit)
    }

    fn any_hit(&self, culling: Culling, ray: &Ray<f64>) -> bool {
        self.trace(Any::<Widened, Culling>::new(culling), ray)
            .unwrap_or_else(|| self.any_by_walk(Tracing::Single, culling, ray))
    }
}

/// Rays, as leaves are asked about them, and how they go through boxes.
struct Given<const N: usize> {
    rays: Ray<[f64; N]>,
    spans: [Span; N],
}

impl Given<RAYS> {
    const NOTHING: Self = {
        let zeros = Vec3::new([0.0; RAYS], [0.0; RAYS], [0.0; RAYS]);
        let rays = Ray { o: zeros, d: zeros, tmin: [0.0; RAYS], tmax: [0.0; RAYS] };
        Self { rays, spans: [Span::NOTHING; RAYS] }
    };

    fn set(&mut self, index: usize, ray: &Ray<f64>, span: Span) {
        let Ray { o, d, tmin, tmax } = &mut self.rays;
        (o.x[index], o.y[index], o.z[index]) = (ray.o.x, ray.o.y, ray.o.z);
        (d.x[index], d.y[index], d.z[index]) = (ray.d.x, ray.d.y, ray.d.z);
        (tmin[index], tmax[index], self.spans[index]) = (ray.tmin, ray.tmax, span);
    }
}

impl<const N: usize> Rays<f64, N> for Given<N> {
    #[inline(always)]
    fn one(&self, index: usize) -> Ray<f64> {
        let Ray { o, d, tmin, tmax } = &self.rays;
        let at = index % N;
        let (o, d) = (Vec3::new(o.x[at], o.y[at], o.z[at]), Vec3::new(d.x[at], d.y[at], d.z[at]));
        Ray { o, d, tmin: tmin[at], tmax: tmax[at] }
    }

    #[inline(always)]
    fn rows(&self) -> Ray<&[f64; N]> {
        let Ray { o, d, tmin, tmax } = &self.rays;
        Ray { o: o.each_ref(), d: d.each_ref(), tmin, tmax }
    }
}

/// Rays, and what is known of their hits.
struct Asked<H, const N: usize> {
    given: Given<N>,
    hits: H,
}

impl<'a, M, K, Q, const N: usize> Target<'a, Q, N> for &'a TreeOf<M, K>
where
    M: Method,
    K: Queries<M, f64>,
    Q: LeafQuery<M, f64>,
{
    const LINES: bool = false;
    type Hits = Asked<HitsOf<M, Q, f64, N>, N>;
    type Seed = Given<N>;

    #[inline(always)]
    fn tree(self) -> &'a WideTree {
        &self.tree
    }

    #[inline(always)]
    fn hits(given: Given<N>) -> Self::Hits {
        Asked { given, hits: Hits::new::<M, f64, Q>() }
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
        Work { rays, hits: Asked { given, hits } }: &mut Work<Self::Hits, N>,
        index: usize,
        leaf: Range<usize>,
    ) -> bool {
        let best = &mut hits.best[index % N];
        let at_leaf = AtLeaf { blocks: &self.leaves.blocks, query, ray: given.one(index) };
        let tmax = at_leaf.ray.tmax;
        let is_hit = test_ray::<M, f64, <L::Token as Token>::Doubles, Q, N>(
            token,
            at_leaf,
            leaf,
            (&*given, index),
            best,
        );
        if is_hit {
            let end = Q::end(best, tmax);
            given.rays.tmax[index % N] = end;
            rays.end(index, given.spans[index % N].end(end));
        }
        is_hit
    }

    #[inline(always)]
    fn finish<L: Lanes>(
        self,
        Work { hits: Asked { given, hits }, .. }: &mut Work<Self::Hits, N>,
    ) -> &[Q::Found; N] {
        Q::finish::<L, N>(&self.leaves.blocks, given, hits)
    }
}
