//! What a ray does to the triangles of a leaf, block by block: for queries that want more than the nearest hit.
//!
//! Of a method the test of a block alone is compiled for them, behind a call for each leaf.

use std::cmp::Ordering;
use std::marker::PhantomData;
use std::ops::Range;

use trisect_core::{Hit, Lanes, Ray, Token as _, Vec3};
use trisect_method::{Culling, ExactMethod, Interval, Method, Of};

use super::blocks::Blocks;
use super::exact::{self, Exactly};
use super::pairs::test;
use super::single::Rounded;
use crate::hit::TriangleHit;
use crate::lanes::Job;
use crate::precision::Real;
use crate::query::{Both, Closest, Robust};
use crate::vectors::WIDTH;

/// What a ray does to the triangles of a block.
pub(crate) struct BlockHits<'a, P = f32> {
    /// The index of the block.
    pub(crate) at: usize,
    /// The ids of its triangles.
    pub(crate) triangles: &'a [u32; WIDTH],
    /// The triangles, in bits, that are in other places of the tree as well.
    pub(crate) repeated: u64,
    /// Those that are hit, in bits.
    pub(crate) met: u64,
    /// Those that are left to be [decided](ExactLeaves::is_hit), in bits; none of a method that rounds.
    pub(crate) open: u64,
    /// The values of hits, of a method that rounds.
    values: Hit<[P; WIDTH]>,
}

impl<P: Copy> BlockHits<'_, P> {
    /// The values of a hit, of a method that rounds.
    pub(crate) fn hit(&self, lane: usize) -> Hit<P> {
        let Hit { t, beta, gamma } = &self.values;
        Hit { t: t[lane], beta: beta[lane], gamma: gamma[lane] }
    }
}

/// Says what a ray does to the triangles of a leaf.
pub(crate) trait LeafReporter<P> {
    /// Calls `take` for each block in which anything may be hit.
    fn report(&self, ray: &Ray<P>, leaf: Range<usize>, take: &mut dyn FnMut(&BlockHits<'_, P>));
}

/// What is done with a reporter.
pub(crate) type WithReporter<'a, P> = &'a mut dyn FnMut(&dyn LeafReporter<P>);

/// What the leaves of an exact method know of triangles, which are named by their [slots](super::blocks::slot).
/// Rays have intervals as leaves take them.
pub(crate) trait ExactLeaves<P> {
    /// Whether a ray hits a triangle, and where `owned` [owns](ExactMethod::owns) it.
    fn is_hit(&self, ray: &Ray<P>, culling: Culling, owned: bool, slot: u32) -> bool;

    /// Computes the values of hits, whose slots are in the places of ids.
    fn values(&self, ray: &Ray<P>, hits: &mut [TriangleHit<P>]);

    /// Which of two triangles that a ray hits comes first along it.
    fn order(&self, ray: &Ray<P>, slots: [u32; 2]) -> Ordering;

    /// Whether a point is on a triangle.
    fn is_on(&self, point: Vec3<P>, slot: u32) -> bool;
}

/// How the leaves of a method report.
pub(crate) trait Reports<M: Method, P: Real> {
    /// Tests a ray against as many triangles of a block as there are lanes, from `lane` on.
    fn test<L: Lanes<Elem = P>>(
        ray: &M::PreparedRay<L>,
        triangles: &Of<M::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        lane: usize,
        into: &mut BlockHits<'_, P>,
    );

    /// What is known exactly.
    fn exact(blocks: &Blocks<M, P>) -> Option<&dyn ExactLeaves<P>>;
}

impl<M: Method, P: Real> Reports<M, P> for Rounded {
    #[inline(always)]
    fn test<L: Lanes<Elem = P>>(
        ray: &M::PreparedRay<L>,
        triangles: &Of<M::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        lane: usize,
        into: &mut BlockHits<'_, P>,
    ) {
        test::<M, L, Closest<Robust, Both, P>>(
            ray,
            triangles,
            interval,
            culling,
            #[inline(always)]
            |met, hit| {
                into.met |= L::bits(met) << lane;
                hit.t.store(&mut into.values.t[lane..]);
                hit.beta.store(&mut into.values.beta[lane..]);
                hit.gamma.store(&mut into.values.gamma[lane..]);
            },
        );
    }

    fn exact(_: &Blocks<M, P>) -> Option<&dyn ExactLeaves<P>> {
        None
    }
}

impl<M: ExactMethod, P: Real> Reports<M, P> for Exactly {
    #[inline(always)]
    fn test<L: Lanes<Elem = P>>(
        ray: &M::PreparedRay<L>,
        triangles: &Of<M::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        lane: usize,
        into: &mut BlockHits<'_, P>,
    ) {
        M::screen(
            ray,
            triangles,
            interval,
            culling,
            #[inline(always)]
            |screened| {
                into.met |= L::bits(screened.certain) << lane;
                into.open |= screened.open << lane;
            },
        );
    }

    fn exact(blocks: &Blocks<M, P>) -> Option<&dyn ExactLeaves<P>> {
        Some(blocks)
    }
}

impl<M: ExactMethod, P: Real> ExactLeaves<P> for Blocks<M, P> {
    fn is_hit(&self, ray: &Ray<P>, culling: Culling, owned: bool, slot: u32) -> bool {
        let prepared = self.prepared(slot);
        exact::is_hit::<M, P>(ray, culling, &prepared) && (!owned || M::owns(ray, &prepared))
    }

    /// One by one: most rays have few, and lanes that are not filled take as long.
    fn values(&self, ray: &Ray<P>, hits: &mut [TriangleHit<P>]) {
        for found in hits {
            found.hit = exact::values::<M, P>(ray, &self.prepared(found.triangle));
        }
    }

    fn order(&self, ray: &Ray<P>, slots: [u32; 2]) -> Ordering {
        let [first, second] = slots.map(|slot| self.prepared(slot));
        M::order(ray, &first, &second)
    }

    fn is_on(&self, point: Vec3<P>, slot: u32) -> bool {
        M::is_on(point, &self.prepared(slot))
    }
}

/// Makes a reporter on lanes of choice.
pub(crate) struct Reporting<'a, M: Method, K, P: Real> {
    pub(crate) blocks: &'a Blocks<M, P>,
    pub(crate) culling: Culling,
    pub(crate) with: WithReporter<'a, P>,
    pub(crate) reports: PhantomData<K>,
}

impl<M: Method, K: Reports<M, P>, P: Real> Job for Reporting<'_, M, K, P> {
    type Output = ();

    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { blocks, culling, with, .. } = self;
        with(&Reporter::<M, P::Lanes<L>, K> { blocks, culling, token, reports: PhantomData });
    }
}

struct Reporter<'a, M: Method, L: Lanes<Elem: Real>, K> {
    blocks: &'a Blocks<M, L::Elem>,
    culling: Culling,
    token: L::Token,
    reports: PhantomData<K>,
}

impl<M, L, K, P> LeafReporter<P> for Reporter<'_, M, L, K>
where
    M: Method,
    L: Lanes<Elem = P>,
    K: Reports<M, P>,
    P: Real,
{
    fn report(&self, ray: &Ray<P>, leaf: Range<usize>, take: &mut dyn FnMut(&BlockHits<'_, P>)) {
        self.token.run(
            #[inline(always)]
            || {
                let axis = if const { M::TURNS } { ray.d.largest_axis() } else { 2 };
                match axis {
                    0 if const { M::TURNS } => self.report_along::<0>(ray, leaf, take),
                    1 if const { M::TURNS } => self.report_along::<1>(ray, leaf, take),
                    _ => self.report_along::<2>(ray, leaf, take),
                }
            },
        );
    }
}

impl<M: Method, L: Lanes<Elem = P>, K: Reports<M, P>, P: Real> Reporter<'_, M, L, K> {
    #[inline(always)]
    fn report_along<const AXIS: usize>(
        &self,
        ray: &Ray<P>,
        leaf: Range<usize>,
        take: &mut dyn FnMut(&BlockHits<'_, P>),
    ) {
        let Self { blocks, culling, token, .. } = *self;
        let interval =
            Interval { tmin: L::splat(token, ray.tmin), tmax: L::splat(token, ray.tmax) };
        let ray = Ray::<L>::splat(token, ray).with_axis_last(AXIS);
        for at in leaf {
            let ray = M::prepare_ray(&ray, blocks.kind(at));
            let block = &blocks.blocks[at];
            let zeros = [P::ZERO; WIDTH];
            let mut hits = BlockHits {
                at,
                triangles: &block.triangles,
                repeated: blocks.repeated(at),
                met: 0,
                open: 0,
                values: Hit { t: zeros, beta: zeros, gamma: zeros },
            };
            let mut lane = 0;
            while lane < WIDTH {
                let triangles = block.lanes::<L, AXIS>(token, lane);
                K::test::<L>(&ray, &triangles, interval, culling, lane, &mut hits);
                lane += L::N;
            }
            if hits.met | hits.open != 0 {
                take(&hits);
            }
        }
    }
}
