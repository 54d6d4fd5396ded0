//! Which lanes a batch of rays runs on: the best that the processor has, chosen once.

use rayon::prelude::*;
use trisect_core::{Culling, Fused, InstructionSet, Lanes, Method, Plain, Ray, Token, Vector};

use crate::bvh::{Bvh, Statistics};
use crate::hit::{Found, TriangleHit};
use crate::order::{Order, TILE, of_origins, of_rows, row_length};
use crate::packet::in_packets;
use crate::single::singly;

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
    /// The same answers on every processor, those of testing every triangle: plain arithmetic, and
    /// tests of boxes that allow for their rounding. They do not allow for a method whose `t` is off by
    /// more than that, as Wald's was at ten thousand sizes from the origin.
    Plain,
}

/// Rays that one thread takes at a time: so many that those that go together share much, and few enough
/// for the second cache.
const CHUNK: usize = 4096;

/// Something to do on lanes of choice.
trait Job {
    type Output;
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) -> Self::Output;
}

/// Runs a job on the lanes that are fast, where the processor has them.
fn on_fast_lanes<J: Job>(job: J) -> Result<J::Output, J> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        use fearless_simd::f32x8;
        use fearless_simd::x86::{Avx2, Avx512};
        if let Some(token) = Avx512::detect() {
            return Ok(job.run::<Vector<Avx512, f32x8<Avx512>, Fused>>(token));
        }
        if let Some(token) = Avx2::detect() {
            return Ok(job.run::<Vector<Avx2, f32x8<Avx2>, Fused>>(token));
        }
    }
    #[cfg(target_arch = "aarch64")]
    if let Some(token) = fearless_simd::aarch64::Neon::detect() {
        use fearless_simd::aarch64::Neon;
        return Ok(job.run::<Vector<Neon, fearless_simd::f32x4<Neon>, Fused>>(token));
    }
    Err(job)
}

/// The instruction set and the number of lanes that triangles are tested on here, unless plainly.
pub fn fast_lanes() -> (InstructionSet, usize) {
    struct Which;
    impl Job for Which {
        type Output = (InstructionSet, usize);
        fn run<L: Lanes<Elem = f32>>(self, _token: L::Token) -> Self::Output {
            (L::Token::INSTRUCTION_SET, L::N)
        }
    }
    on_fast_lanes(Which).unwrap_or_else(on_plain_lanes)
}

/// Runs a job in plain arithmetic, which gives the same bits everywhere: on one instruction set that
/// nearly all processors have, as each takes its time to compile for every method.
fn on_plain_lanes<J: Job>(job: J) -> J::Output {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(token) = fearless_simd::x86::Sse4_2::detect() {
        use fearless_simd::x86::Sse4_2;
        return job.run::<Vector<Sse4_2, fearless_simd::f32x4<Sse4_2>, Plain>>(token);
    }
    job.run::<f32>(())
}

/// Rays and where their hits go.
struct Batch<'a, M: Method, T, const ANY: bool, const ROBUST: bool, const PACKETS: bool> {
    bvh: &'a Bvh<M>,
    rays: &'a [Ray<f32>],
    order: Order,
    culling: Culling,
    found: &'a mut [T],
}

impl<M, T, const ANY: bool, const ROBUST: bool, const PACKETS: bool> Job
    for Batch<'_, M, T, ANY, ROBUST, PACKETS>
where
    M: Method,
    T: Found,
{
    type Output = ();
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { bvh, rays, order, culling, found } = self;
        token.run(
            #[inline(always)]
            || {
                // Known when it is compiled, where nothing is culled or nothing goes together.
                let culling = if ROBUST { culling } else { Culling::None };
                match order {
                    Order::Packets(numbers) if PACKETS => {
                        in_packets::<M, L, T, ANY, ROBUST>(
                            bvh, token, culling, rays, &numbers, found,
                        );
                    }
                    _ => singly::<M, L, T, ANY, ROBUST>(bvh, token, culling, rays, found),
                }
            },
        );
    }
}

/// Traces on the calling thread, one number at a time, as testing every triangle does.
pub(crate) fn on_scalar_lanes<M: Method, T: Found>(
    bvh: &Bvh<M>,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [T],
) {
    assert!(found.len() >= rays.len(), "every ray has a place for what it finds");
    let order = Order::Singly;
    Batch::<M, T, false, true, false> { bvh, rays, order, culling, found }.run::<f32>(());
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
        self.batch::<_, false>(tracing, culling, rays, found);
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        self.batch::<_, true>(tracing, culling, rays, found);
    }

    fn statistics(&self) -> Statistics {
        self.statistics_of()
    }
}

impl<M: Method> Bvh<M> {
    fn batch<T: Found, const ANY: bool>(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [T],
    ) {
        assert!(found.len() >= rays.len(), "every ray has a place for what it finds");
        let fast = tracing != Tracing::Plain && culling == Culling::None;
        let together = fast && tracing == Tracing::Packets;
        let row = if together { row_length(rays) } else { None };
        let chunk = row.map_or(CHUNK, |row| CHUNK.next_multiple_of(TILE * row));
        rays.par_chunks(chunk).zip(found.par_chunks_mut(chunk)).for_each(|(rays, found)| {
            let order = match row {
                Some(row) => of_rows(rays.len(), row),
                None if together => of_origins(rays),
                None => Order::Singly,
            };
            let rest = if fast { self.fast::<T, ANY>(rays, order, found) } else { Some(found) };
            if let Some(found) = rest {
                let order = Order::Singly;
                // The nearest hit is one as well: one instance less.
                let plain =
                    Batch::<M, T, false, true, false> { bvh: self, rays, order, culling, found };
                on_plain_lanes(plain);
            }
        });
    }

    /// Traces on fast lanes; gives the places back where the processor has none.
    fn fast<'a, T: Found, const ANY: bool>(
        &'a self,
        rays: &'a [Ray<f32>],
        order: Order,
        found: &'a mut [T],
    ) -> Option<&'a mut [T]> {
        let culling = Culling::None;
        if const { M::INFO.claims.watertight } {
            let batch = Batch::<M, T, ANY, true, true> { bvh: self, rays, order, culling, found };
            on_fast_lanes(batch).err().map(|batch| batch.found)
        } else {
            let batch = Batch::<M, T, ANY, false, true> { bvh: self, rays, order, culling, found };
            on_fast_lanes(batch).err().map(|batch| batch.found)
        }
    }
}
