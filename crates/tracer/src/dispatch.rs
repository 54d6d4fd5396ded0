//! Which lanes a batch of rays runs on: the best that the processor has, chosen once.

use trisect_core::{Culling, Fused, InstructionSet, Lanes, Method, Plain, Ray, Token, Vector};

use crate::bvh::{Bvh, Statistics};
use crate::hit::{Found, NO_HIT, TriangleHit};
use crate::order::{Order, TILE, of_origins, of_rows, row_length};
use crate::packet::{LeavesOf, Whole, in_packets};
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
                let leaves = &LeavesOf::<M, L, ANY, ROBUST> { bvh, token };
                let tree = Whole { nodes: &bvh.nodes, depth: bvh.depth, leaves };
                in_packets::<L, T, ROBUST>(tree, token, rays, &numbers, found);
            }
            Order::Singly => token.run(
                #[inline(always)]
                || singly::<M, L, T, ANY, ROBUST, false>(bvh, token, Culling::None, rays, found),
            ),
        }
    }
}

/// Rays that are traced as testing every triangle does. Whoever asks whether there is a hit gets the
/// nearest: an instance less for every method.
struct Plainly<'a, M: Method> {
    bvh: &'a Bvh<M>,
    culling: Culling,
    rays: &'a [Ray<f32>],
    found: &'a mut [TriangleHit],
}

impl<M: Method> Job for Plainly<'_, M> {
    type Output = ();
    // Out of line, since it is called from several places.
    #[inline(never)]
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { bvh, culling, rays, found } = self;
        token.run(
            #[inline(always)]
            || singly::<M, L, _, false, true, true>(bvh, token, culling, rays, found),
        );
    }
}

/// Traces in plain arithmetic, by a function of choice.
fn plainly<M: Method, T: Found>(
    bvh: &Bvh<M>,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [T],
    run: fn(Plainly<'_, M>),
) {
    let mut best = vec![NO_HIT; rays.len()];
    run(Plainly { bvh, culling, rays, found: &mut best });
    for (found, best) in found.iter_mut().zip(&best) {
        *found = T::of(best);
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
    plainly(bvh, culling, rays, found, |job| job.run::<f32>(()));
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
        self.batch::<_, false>(tracing, culling, rays, found);
    }

    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        self.batch::<_, true>(tracing, culling, rays, found);
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
        let parts = rays.chunks(chunk).zip(found.chunks_mut(chunk));
        parallel::all(parts.map(|(rays, found)| -> parallel::Task<'_> {
            Box::new(move || {
                let order = match row {
                    Some(row) => of_rows(rays.len(), row),
                    None if together => of_origins(rays),
                    None => Order::Singly,
                };
                let rest = if fast { self.fast::<T, ANY>(rays, order, found) } else { Some(found) };
                if let Some(found) = rest {
                    plainly(self, culling, rays, found, |job| on_plain_lanes(job));
                }
            })
        }));
    }

    /// Traces on fast lanes; gives the places back where the processor has none.
    fn fast<'a, T: Found, const ANY: bool>(
        &'a self,
        rays: &'a [Ray<f32>],
        order: Order,
        found: &'a mut [T],
    ) -> Option<&'a mut [T]> {
        if const { M::INFO.claims.watertight } {
            let batch = Batch::<M, T, ANY, true> { bvh: self, rays, order, found };
            on_fast_lanes(batch).err().map(|batch| batch.found)
        } else {
            let batch = Batch::<M, T, ANY, false> { bvh: self, rays, order, found };
            on_fast_lanes(batch).err().map(|batch| batch.found)
        }
    }
}
