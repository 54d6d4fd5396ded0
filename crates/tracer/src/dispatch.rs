//! How a batch of rays goes through a tree, whatever its method.

use std::slice::{from_mut, from_ref};

use trisect_core::Ray;
use trisect_method::Culling;

use crate::bvh::wide::WideTree;
use crate::hit::TriangleHit;
use crate::lanes::{Job, PlainLanes, has_fast_lanes, on_fast_lanes};
use crate::leaf::erased::{ErasedLeaves, LeafTester};
use crate::parallel::{self, Task};
use crate::query::{Any, Both, Closest, HasClosest, Query, Robust, Tight};
use crate::rays::reorder::{Order, TILE, of_origins, of_rows, row_length};
use crate::traced::TracedIn;
use crate::traverse::target::ThroughCalls;
use crate::traverse::trace::Trace;

/// How a batch of rays is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tracing {
    /// Every ray on its own, as fast as the processor can: with fused multiply-add where it has that, and tests
    /// of boxes that keep the promise of the method.
    Single,
    /// Many rays together, in the same arithmetic: rays that are near each other go down the tree in packets.
    /// For batches of thousands; best where rays are alike, as those of a camera, in rows of a picture or in
    /// tiles of it. Rays that have little in common go singly all the same.
    Packets,
    /// The same answers on every processor: plain arithmetic, and tests of boxes that allow for their own
    /// rounding, so that no true hit is lost. The answers of an exact method are those of testing every
    /// triangle, to the bit. What another method accepts by its own rounding or tolerance may lie beside every
    /// box that allows for less, and be lost.
    Plain,
}

/// Rays that one thread takes at a time: so many that rays that go together share much, and few enough for the
/// second cache.
const CHUNK: usize = 4096;

/// A tree of f32, which batches go through in loops of their own.
pub(crate) trait Traced: TracedIn<f32> {
    /// Its leaves, behind calls.
    fn erased(&self) -> &dyn ErasedLeaves;

    /// Finds the nearest hits of rays, with both faces seen, in a loop that is compiled for the method; whether there
    /// is one, for this processor.
    fn closest_in_loop(
        &self,
        rays: &[Ray<f32>],
        order: &Order,
        found: &mut [Option<TriangleHit>],
    ) -> bool;

    /// The same for any hits.
    fn any_in_loop(&self, rays: &[Ray<f32>], order: &Order, found: &mut [bool]) -> bool;
}

/// The nearest hit, in plain arithmetic.
pub(crate) const PLAIN: Closest<Robust, Both> = Closest::new(Both);

/// The nearest hit of each ray.
pub(crate) fn closest(
    traced: &dyn Traced,
    tracing: Tracing,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [Option<TriangleHit>],
) {
    in_chunks(tracing, rays, found, |is_plain, rays, order, found| {
        if is_plain {
            plain(traced, PLAIN, PlainLanes::Vector, culling, rays, found);
        } else if culling != Culling::None || !traced.closest_in_loop(rays, order, found) {
            traced.erased().closest(culling, &mut |hits| {
                let (tight, robust) =
                    (Closest::<Tight, _>::new(Both), Closest::<Robust, _>::new(Both));
                fast(traced.tree(), hits, tight, robust, rays, order, found);
            });
        }
    });
}

/// Whether each ray hits anything.
pub(crate) fn any(
    traced: &dyn Traced,
    tracing: Tracing,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [bool],
) {
    in_chunks(tracing, rays, found, |is_plain, rays, order, found| {
        if is_plain {
            plain(traced, HasClosest, PlainLanes::Vector, culling, rays, found);
        } else if culling != Culling::None || !traced.any_in_loop(rays, order, found) {
            traced.erased().any(culling, &mut |hits| {
                let (tight, robust) = (Any::<Tight, _>::new(Both), Any::<Robust, _>::new(Both));
                fast(traced.tree(), hits, tight, robust, rays, order, found);
            });
        }
    });
}

/// The nearest hit of one ray, as of a batch.
pub(crate) fn closest_of(
    traced: &dyn Traced,
    culling: Culling,
    ray: &Ray<f32>,
) -> Option<TriangleHit> {
    let mut found = None;
    closest(traced, Tracing::Single, culling, from_ref(ray), from_mut(&mut found));
    found
}

/// Whether one ray hits anything, as of a batch.
pub(crate) fn any_of(traced: &dyn Traced, culling: Culling, ray: &Ray<f32>) -> bool {
    let mut found = false;
    any(traced, Tracing::Single, culling, from_ref(ray), from_mut(&mut found));
    found
}

/// Traces rays in plain arithmetic, by the calling thread.
pub(crate) fn plain<Q: Query<Found = TriangleHit>>(
    traced: &dyn Traced,
    query: Q,
    lanes: PlainLanes,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [Q::Output],
) {
    assert_room(rays, found);
    traced.erased().plain(lanes, culling, &mut |hits| {
        lanes.run(through_calls(traced.tree(), hits, query, rays, &Order::Singly, found));
    });
}

/// Asserts that every ray has a place for what it finds.
pub(crate) fn assert_room<I, T>(asked: &[I], found: &[T]) {
    assert!(found.len() >= asked.len(), "every ray has a place for what it finds");
}

/// Traces rays on fast lanes through leaves that are behind calls, by the one query or the other.
fn fast<T: Query, R: Query<Found = T::Found, Output = T::Output>>(
    tree: &WideTree,
    hits: &mut dyn LeafTester<T::Found>,
    tight: T,
    robust: R,
    rays: &[Ray<f32>],
    order: &Order,
    found: &mut [T::Output],
) {
    if tree.is_robust {
        on_fast_lanes(through_calls(tree, hits, robust, rays, order, found));
    } else {
        on_fast_lanes(through_calls(tree, hits, tight, rays, order, found));
    }
}

/// Rays to be traced through leaves that are behind calls.
fn through_calls<'a, Q: Query>(
    tree: &'a WideTree,
    hits: &'a mut (dyn LeafTester<Q::Found> + 'a),
    query: Q,
    rays: &'a [Ray<f32>],
    order: &'a Order,
    found: &'a mut [Q::Output],
) -> impl Job {
    Trace { target: ThroughCalls(tree), seed: hits, query, rays, order, found }
}

/// Shares rays between the threads of the pool that it is called in, and calls `trace` for those that one of them
/// takes at a time: whether they are traced in plain arithmetic, the rays, their order, and where their results
/// belong.
fn in_chunks<T: Send>(
    tracing: Tracing,
    rays: &[Ray<f32>],
    found: &mut [T],
    trace: impl Fn(bool, &[Ray<f32>], &Order, &mut [T]) + Sync,
) {
    assert_room(rays, found);
    let is_plain = tracing == Tracing::Plain || !has_fast_lanes();
    let in_packets = tracing == Tracing::Packets && !is_plain;
    let row = if in_packets { row_length(rays) } else { None };
    let chunk = row.map_or(CHUNK, |row| CHUNK.next_multiple_of(TILE * row));
    let parts = rays.chunks(chunk).zip(found.chunks_mut(chunk));
    let trace = &trace;
    parallel::all(parts.map(|(rays, found)| -> Task<'_> {
        Box::new(move || {
            let order = match row {
                Some(row) => of_rows(rays.len(), row),
                None if in_packets => of_origins(rays),
                None => Order::Singly,
            };
            trace(is_plain, rays, &order, found);
        })
    }));
}
