//! Every ray against every triangle: hits counted, or the first of each ray found.

use std::cmp::Ordering;

use trisect_core::{Hit, Lanes, Ray, Scalar as _, Token, Triangle};
use trisect_exact::Exact;
use trisect_kernels::{BLOCK, PreparedTriangles, one_ray, one_ray_until};
use trisect_method::{Culling, DecisionOnly, Deferred, Method, TrueDivision};

/// The form that both methods have.
type Form = Deferred<TrueDivision, true>;

/// Triangles of a workload, prepared for a method, and rays.
pub(crate) struct Scene<'a, M: Method> {
    pub(crate) rays: &'a [Ray<f32>],
    pub(crate) triangles: &'a [Triangle<f32>],
    pub(crate) prepared: PreparedTriangles<M, f32>,
}

impl<M: Method> Scene<'_, M> {
    /// How many pairs hit: the decision alone.
    pub(crate) fn decide<L: Lanes<Elem = f32>>(&self, token: L::Token) -> u64 {
        token.run(
            #[inline(always)]
            || {
                let mut hits = 0;
                for ray in self.rays {
                    one_ray::<M, L, DecisionOnly<Form>>(
                        token,
                        ray,
                        &self.prepared,
                        Culling::None,
                        #[inline(always)]
                        |_, mask, _| hits += u64::from(L::bits(mask).count_ones()),
                    );
                }
                hits
            },
        )
    }

    /// How many rays hit: the first hit of each is found, by its rounded `t`, then by number.
    pub(crate) fn closest<L: Lanes<Elem = f32>>(&self, token: L::Token) -> u64 {
        token.run(
            #[inline(always)]
            || {
                let mut hits = 0;
                for ray in self.rays {
                    let mut best: Option<(u32, Hit<f32>)> = None;
                    one_ray_until::<M, L, Form>(
                        token,
                        ray,
                        &self.prepared,
                        Culling::None,
                        #[inline(always)]
                        |tested, mask, hit| {
                            let numbers = self.prepared.numbers(tested.triangle_place);
                            take::<L>(L::bits(mask), hit, numbers, &mut best);
                            best.map(|(_, hit)| hit.t)
                        },
                    );
                    hits += u64::from(best.is_some());
                }
                hits
            },
        )
    }
}

impl Scene<'_, Exact> {
    /// The same in exact order.
    pub(crate) fn closest_exactly<L: Lanes<Elem = f32>>(&self, token: L::Token) -> u64 {
        let closest = |ray| trisect_exact::closest::<L>(token, ray, self.triangles, &self.prepared);
        self.rays.iter().map(|ray| u64::from(closest(ray).is_some())).sum()
    }
}

#[inline(never)]
fn take<L: Lanes<Elem = f32>>(
    mut bits: u64,
    hit: Hit<L>,
    numbers: &[u32],
    best: &mut Option<(u32, Hit<f32>)>,
) {
    let mut rows = [[f32::from_f64(0.0); BLOCK]; 3];
    hit.t.store(&mut rows[0]);
    hit.beta.store(&mut rows[1]);
    hit.gamma.store(&mut rows[2]);
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        let hit = Hit { t: rows[0][lane], beta: rows[1][lane], gamma: rows[2][lane] };
        let number = numbers[lane];
        let is_first = best.is_none_or(|(other, first)| {
            hit.t.total_cmp(&first.t).then(number.cmp(&other)) == Ordering::Less
        });
        if is_first {
            *best = Some((number, hit));
        }
    }
}
