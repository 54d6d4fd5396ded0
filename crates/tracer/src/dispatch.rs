//! How a batch of rays goes through a tree: what depends on its method, chosen once.

use trisect_core::{Culling, Lanes, Method, Ray, Token as _};

use crate::bvh::{Bvh, Statistics};
use crate::called::Called;
use crate::hit::{Found, TriangleHit};
use crate::lanes::{Job, OnFast, OnLanes, OnPlain, has_fast_lanes};
use crate::leaves::{Both, Leaves, LeavesOf, Whole};
use crate::order::{Order, TILE, of_origins, of_rows, row_length};
use crate::packet::in_packets;
use crate::parallel;
use crate::single::singly;
use crate::walk::Counted;

/// How a batch of rays is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tracing {
    /// Every ray on its own, as fast as the processor can: with fused multiply-add where it has that,
    /// and tests of boxes that are as exact as the method promises to be.
    Single,
    /// Many rays together, in the same arithmetic: those that are near each other go down the tree in
    /// packets. For batches of thousands; best where rays are alike, as those of a camera, in rows of a
    /// picture or in tiles of it. Rays that have little in common go singly after all.
    Packets,
    /// The same answers on every processor: plain arithmetic, and tests of boxes that allow for their own
    /// rounding, so that no true hit is lost. Those of a method that claims to be exact are the answers of
    /// testing every triangle, to the bit. What another method accepts by its own rounding or tolerance
    /// may lie beside every box that allows for less, and be lost.
    Plain,
}

/// Rays that one thread takes at a time: so many that those that go together share much, and few enough
/// for the second cache.
const CHUNK: usize = 4096;

/// Rays through a tree, compiled for its method: in packets as well, as calls of leaves that are known are
/// worth a twentieth.
struct Batch<'a, M: Method, T, const ANY: bool, const ROBUST: bool> {
    bvh: &'a Bvh<M>,
    rays: &'a [Ray<f32>],
    order: Order,
    found: &'a mut [T],
}

impl<M: Method, T: Found, const ANY: bool, const ROBUST: bool> Job
    for Batch<'_, M, T, ANY, ROBUST>
{
    type Output = ();
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { bvh, rays, order, found } = self;
        match order {
            Order::Packets(numbers) => {
                let leaves = &LeavesOf::<M, L, Both, ANY, ROBUST>::new(bvh, token, Both);
                in_packets::<L, T, ROBUST>(bvh.whole(leaves), token, rays, &numbers, found);
            }
            Order::Singly => token.run(
                #[inline(always)]
                || singly::<_, L, T, ANY, ROBUST>(bvh, token, rays, found),
            ),
        }
    }
}

/// A tree's leaves, which see those faces that culling leaves, for who calls them.
struct WithLeaves<'a, M: Method, F, const ANY: bool, const ROBUST: bool> {
    bvh: &'a Bvh<M>,
    culling: Culling,
    then: F,
}

impl<M, F, const ANY: bool, const ROBUST: bool> Job for WithLeaves<'_, M, F, ANY, ROBUST>
where
    M: Method,
    F: FnOnce(&dyn Leaves),
{
    type Output = ();
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { bvh, culling, then } = self;
        then(&LeavesOf::<M, L, Culling, ANY, ROBUST>::new(bvh, token, culling));
    }
}

/// A tree over a mesh, whatever its method.
pub trait Tree: Send + Sync {
    /// The closest hit of each ray: smallest `t`, then lowest number. On the threads of the pool that
    /// it is called in.
    ///
    /// # Panics
    /// When there are fewer places in `found` than rays.
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    );

    /// Whether each ray hits anything. On the threads of the pool that it is called in.
    ///
    /// # Panics
    /// When there are fewer places in `found` than rays.
    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]);

    /// A ray's closest hit, and how many tests it takes to find it, one box and one triangle at a time.
    /// The hit is that of [`Tracing::Plain`].
    fn count(&self, ray: &Ray<f32>) -> Counted;

    /// Visits the triangles that a ray may hit, near ones first and some of them several times: `visit`
    /// gets the number of one, and says where the ray's interval ends from then on. None that the ray
    /// truly hits before that end is left out.
    fn candidates(&self, ray: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32);

    /// Facts about the tree.
    fn statistics(&self) -> Statistics;
}

impl<M: Method> Tree for Bvh<M> {
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        self.batch::<_, false, true>(tracing, culling, rays, found);
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        self.batch::<_, true, true>(tracing, culling, rays, found);
    }

    fn count(&self, ray: &Ray<f32>) -> Counted {
        self.counted(ray)
    }

    fn candidates(&self, ray: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
        self.visit_candidates(ray, visit);
    }

    fn statistics(&self) -> Statistics {
        self.statistics_of()
    }
}

impl<M: Method> Bvh<M> {
    pub(crate) fn batch<T: Found, const ANY: bool, const IN_LOOP: bool>(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [T],
    ) {
        assert!(found.len() >= rays.len(), "every ray has a place for what it finds");
        let tracing = if has_fast_lanes() { tracing } else { Tracing::Plain };
        let together = tracing == Tracing::Packets;
        let row = if together { row_length(rays) } else { None };
        let chunk = row.map_or(CHUNK, |row| CHUNK.next_multiple_of(TILE * row));
        let parts = rays.chunks(chunk).zip(found.chunks_mut(chunk));
        parallel::all(parts.map(|(rays, found)| -> parallel::Task<'_> {
            Box::new(move || {
                let order = match row {
                    Some(row) => of_rows(rays.len(), row),
                    None if together => of_origins(rays),
                    None => Order::Singly,
                };
                if tracing == Tracing::Plain {
                    self.plainly::<OnPlain, T>(culling, rays, found);
                } else if const { M::INFO.claims.watertight } {
                    self.fast::<T, ANY, true, IN_LOOP>(culling, rays, order, found);
                } else {
                    self.fast::<T, ANY, false, IN_LOOP>(culling, rays, order, found);
                }
            })
        }));
    }

    /// Traces on fast lanes.
    fn fast<T: Found, const ANY: bool, const ROBUST: bool, const IN_LOOP: bool>(
        &self,
        culling: Culling,
        rays: &[Ray<f32>],
        order: Order,
        found: &mut [T],
    ) {
        if const { IN_LOOP } && culling == Culling::None {
            OnFast::run(Batch::<M, T, ANY, ROBUST> { bvh: self, rays, order, found });
        } else {
            self.called::<OnFast, T, ANY, ROBUST>(culling, rays, order, found);
        }
    }

    /// Traces in plain arithmetic. Whoever asks whether there is a hit gets the nearest.
    pub(crate) fn plainly<O: OnLanes, T: Found>(
        &self,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [T],
    ) {
        self.called::<O, T, false, true>(culling, rays, Order::Singly, found);
    }

    /// Traces through leaves that are behind a call.
    fn called<O: OnLanes, T: Found, const ANY: bool, const ROBUST: bool>(
        &self,
        culling: Culling,
        rays: &[Ray<f32>],
        order: Order,
        found: &mut [T],
    ) {
        let then = |leaves: &dyn Leaves| {
            let called =
                Called { tree: self.whole(leaves), is_robust: ROBUST, any: ANY, rays, order };
            T::trace(called, O::ON, found);
        };
        O::run(WithLeaves::<M, _, ANY, ROBUST> { bvh: self, culling, then });
    }

    /// Its nodes, with leaves of choice.
    fn whole<'a>(&'a self, leaves: &'a dyn Leaves) -> Whole<'a> {
        Whole { nodes: &self.nodes, depth: self.depth, leaves }
    }
}
