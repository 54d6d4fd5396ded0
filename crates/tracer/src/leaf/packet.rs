//! Rays of a packet at a leaf: as many rays as there are lanes are tested against one triangle after another, where
//! that takes fewer tests than one ray after another against as many triangles.

use std::ops::Range;

use trisect_core::{Hit, Lanes};
use trisect_method::{Culling, Interval, Method, Record as _};

use super::blocks::Blocks;
use super::pairs::test;
use super::query::LeafQuery;
use crate::hit::TriangleHit;
use crate::precision::Real;
use crate::rays::batch::{Gather, RAYS};
use crate::vectors::WIDTH;

/// So many rays at least: a block of eight triangles has five on average.
const LEAST: u32 = 6;

/// The hits of as many rays as there are lanes with the triangles of a block.
struct LaneHits<L> {
    /// The lanes that hit anything, in bits.
    met: u64,
    /// The nearest hits, infinitely far where there is none; not where any hit will do.
    hit: Hit<L>,
    /// The lanes of their triangles in the block.
    lane: L,
}

/// Tests rays, in bits, against the triangles of a leaf, with both faces seen; whether any of them has hit anything
/// so far, and the rays that are left, too few to be worth it. All of them are for a method that turns space,
/// as each ray has its own axes. `take` takes a hit where it is better than the best.
#[inline(always)]
pub(crate) fn test_leaf<M: Method, P: Real, L: Lanes<Elem = P>, Q: LeafQuery<M, P>>(
    token: L::Token,
    blocks: &Blocks<M, P>,
    leaf: &Range<usize>,
    rays: &mut impl Gather<P>,
    best: &mut [Q::Best; RAYS],
    mut which: u64,
    take: impl Fn(&mut Q::Best, TriangleHit<P>),
) -> (bool, u64) {
    if const { M::TURNS } {
        return (false, which);
    }
    let mut any = false;
    while which.count_ones() >= LEAST {
        let (ray, indices) = rays.gather::<L>(token, &mut which);
        let interval = Interval::new(ray.tmin, ray.tmax);
        for at in leaf.clone() {
            let ray = M::prepare_ray(&ray, blocks.kind(at));
            let LaneHits { met: mut bits, hit, lane: of } =
                test_block::<M, P, L, Q>(token, blocks, at, &ray, interval);
            let mut lanes = [[P::ZERO; WIDTH]; 4];
            hit.t.store(&mut lanes[0]);
            hit.beta.store(&mut lanes[1]);
            hit.gamma.store(&mut lanes[2]);
            of.store(&mut lanes[3]);
            any |= bits != 0;
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize % WIDTH;
                bits &= bits - 1;
                let index = usize::from(indices[lane]) % RAYS;
                let [t, beta, gamma] = [lanes[0][lane], lanes[1][lane], lanes[2][lane]];
                let of = lanes[3][lane].index() % WIDTH;
                let triangle = blocks.blocks[at].triangles[of];
                let (tmax, best) = (rays.tmax(index), &mut best[index]);
                take(best, TriangleHit { triangle, hit: Hit { t, beta, gamma } });
                rays.shorten(index, Q::end(best, tmax));
            }
        }
    }
    (any, which)
}

/// Tests rays against the triangles of a block.
#[inline(always)]
fn test_block<M: Method, P: Real, L: Lanes<Elem = P>, Q: LeafQuery<M, P>>(
    token: L::Token,
    blocks: &Blocks<M, P>,
    at: usize,
    ray: &M::PreparedRay<L>,
    interval: Interval<L>,
) -> LaneHits<L> {
    let block = &blocks.blocks[at];
    let zero = L::splat(token, P::ZERO);
    let infinity = zero.constant(P::INFINITY);
    let mut met = 0;
    let mut nearest = Hit { t: infinity, beta: zero, gamma: zero };
    let mut of = zero;
    let mut lane = 0;
    loop {
        let triangle = M::Prepared::map(
            &block.prepared,
            #[inline(always)]
            |row: &[P; WIDTH]| L::splat(token, row[lane]),
        );
        test::<M, L, Q>(
            ray,
            &triangle,
            interval,
            Culling::None,
            #[inline(always)]
            |mask, hit| {
                if Q::ANY {
                    met |= L::bits(mask);
                } else {
                    // Of equally near ones the first, which has the lowest id.
                    let is_nearer = mask & hit.t.lt(nearest.t);
                    nearest.t = L::select(is_nearer, hit.t, nearest.t);
                    nearest.beta = L::select(is_nearer, hit.beta, nearest.beta);
                    nearest.gamma = L::select(is_nearer, hit.gamma, nearest.gamma);
                    of = L::select(is_nearer, L::splat(token, P::from_index(lane)), of);
                }
            },
        );
        // What fills a block has the id of the last triangle.
        let id = block.triangles[lane];
        lane += 1;
        if lane == WIDTH || block.triangles[lane] == id {
            break;
        }
    }
    if !Q::ANY {
        met = L::bits(nearest.t.lt(infinity));
    }
    LaneHits { met, hit: nearest, lane: of }
}
