//! The project's kernels, called as a program of one's own would.

use trisect_core::{Hit, Lanes, Ray, Token};
use trisect_kernels::{BLOCK, Packets, PreparedTriangles, one_ray, one_ray_until, one_triangle};
use trisect_method::{Barycentrics, Culling, Division, Method, Needs};

use crate::Tally;
use crate::loops::nearest;

/// How many pairs hit, and the sum over them of what is asked.
pub(crate) fn count<M: Method, L: Lanes<Elem = f32>, D: Division, N: Needs>(
    rays: &[Ray<f32>],
    triangles: &PreparedTriangles<M, f32>,
) -> Option<Tally> {
    let token = L::Token::detect()?;
    Some(token.run(
        #[inline(always)]
        || {
            let zero = L::splat(token, 0.0);
            let (mut hits, mut sum) = (0, zero);
            for ray in rays {
                one_ray::<M, L, N::Asks<D>>(
                    token,
                    ray,
                    triangles,
                    Culling::None,
                    #[inline(always)]
                    |tested, mask, hit| {
                        hits += u64::from(L::bits(mask).count_ones());
                        let asked = N::fold::<M, L>(tested.ray, tested.triangle, tested.group, hit);
                        if let Some(asked) = asked {
                            sum = sum + L::select(mask, asked, zero);
                        }
                    },
                );
            }
            let mut sums = [0.0; BLOCK];
            sum.store(&mut sums);
            Tally { hits, sum: sums.into_iter().map(f64::from).sum() }
        },
    ))
}

/// How many pairs hit, and the sum of `t`, `beta` and `gamma` over them.
pub(crate) fn values<M: Method, L: Lanes<Elem = f32>, D: Division>(
    rays: &[Ray<f32>],
    triangles: &PreparedTriangles<M, f32>,
) -> Option<Tally> {
    count::<M, L, D, Barycentrics>(rays, triangles)
}

/// The same, of packets of rays against one triangle at a time.
pub(crate) fn values_of_packets<M: Method, L: Lanes<Elem = f32>, D: Division>(
    rays: &Packets<f32>,
    triangles: &PreparedTriangles<M, f32>,
) -> Option<Tally> {
    let token = L::Token::detect()?;
    Some(token.run(
        #[inline(always)]
        || {
            let zero = L::splat(token, 0.0);
            let (mut hits, mut sum) = (0, zero);
            one_triangle::<M, L, D>(
                token,
                rays,
                triangles,
                Culling::None,
                #[inline(always)]
                |_, mask, Hit { t, beta, gamma }| {
                    hits += u64::from(L::bits(mask).count_ones());
                    sum = sum + L::select(mask, t + (beta + gamma), zero);
                },
            );
            let mut sums = [0.0; BLOCK];
            sum.store(&mut sums);
            Tally { hits, sum: sums.into_iter().map(f64::from).sum() }
        },
    ))
}

/// How many rays hit, and the sum of the closest `t`.
pub(crate) fn closest<M: Method, L: Lanes<Elem = f32>, D: Division>(
    rays: &[Ray<f32>],
    triangles: &PreparedTriangles<M, f32>,
) -> Option<Tally> {
    let token = L::Token::detect()?;
    Some(token.run(
        #[inline(always)]
        || {
            let mut tally = Tally::default();
            let mut best = None;
            for ray in rays {
                one_ray_until::<M, L, D>(
                    token,
                    ray,
                    triangles,
                    Culling::None,
                    #[inline(always)]
                    |_, mask, Hit { t, .. }| {
                        let mut all = [0.0; BLOCK];
                        t.store(&mut all);
                        nearest(L::bits(mask), &all, &mut best);
                        best
                    },
                );
                tally.take(&mut best);
            }
            tally
        },
    ))
}
