//! Rays of a packet at a leaf: as many of them as there are lanes against one triangle after another,
//! where that takes fewer tests than one ray after another against as many triangles.

use std::ops::Range;

use trisect_core::{Culling, Hit, Interval, Lanes, Method, Record as _};

use crate::bvh::{Bvh, WIDTH};
use crate::hit::TriangleHit;
use crate::leaf::{ANYTHING, end, test};
use crate::rows::{RAYS, Rows};

/// So many rays at least: a block of eight triangles has five on average.
const LEAST: u32 = 6;

/// Whether the rays of a packet are tested side by side: where none has its own axes, and where a test
/// decides.
pub(crate) const fn suits<M: Method, const ANY: bool>() -> bool {
    !M::TURNS && (ANY || !M::INFO.claims.exact)
}

/// Tests the triangles of a leaf for some rays, in bits, as [`leaf::test_leaf`](crate::leaf::test_leaf) does
/// for one; whether any of them has hit anything so far, and those that are left, too few to be worth it.
#[inline(always)]
pub(crate) fn test_leaf<M, L, const ANY: bool, const ROBUST: bool>(
    token: L::Token,
    bvh: &Bvh<M>,
    blocks: &Range<usize>,
    rows: &mut Rows,
    mut rays: u64,
) -> (bool, u64)
where
    M: Method,
    L: Lanes<Elem = f32>,
{
    let mut any = false;
    while rays.count_ones() >= LEAST {
        let (ray, places) = rows.abreast::<L>(token, &mut rays);
        let interval = Interval::new(ray.tmin, ray.tmax);
        for at in blocks.clone() {
            let group = if const { M::GROUPS > 1 } { usize::from(bvh.groups[at]) } else { 0 };
            let ray = M::prepare_ray(&ray, group);
            any |= test_block::<M, L, ANY, ROBUST>(token, bvh, at, &ray, interval, rows, &places);
        }
    }
    (any, rays)
}

/// Tests the triangles of a block; whether any is hit.
#[inline(always)]
fn test_block<M: Method, L: Lanes<Elem = f32>, const ANY: bool, const ROBUST: bool>(
    token: L::Token,
    bvh: &Bvh<M>,
    at: usize,
    ray: &M::PreparedRay<L>,
    interval: Interval<L>,
    rows: &mut Rows,
    places: &[u8; WIDTH],
) -> bool {
    let block = &bvh.blocks[at];
    let zero = L::splat(token, 0.0);
    // The best of each ray, and the number of its triangle, whose bits are only carried.
    let mut nearest = Hit { t: zero.constant(f32::INFINITY), beta: zero, gamma: zero };
    let mut numbers = zero;
    let mut bits = 0;
    let mut lane = 0;
    loop {
        let triangle = M::Prepared::map(
            &block.prepared,
            #[inline(always)]
            |row: &[f32; WIDTH]| L::splat(token, row[lane]),
        );
        let number = block.triangles[lane];
        test::<M, L, ANY>(
            ray,
            &triangle,
            interval,
            Culling::None,
            #[inline(always)]
            |met, hit| {
                if ANY {
                    bits |= L::bits(met);
                } else {
                    // Of equally near ones the first, which has the lowest number.
                    let is_nearer = met & hit.t.lt(nearest.t);
                    nearest.t = L::select(is_nearer, hit.t, nearest.t);
                    nearest.beta = L::select(is_nearer, hit.beta, nearest.beta);
                    nearest.gamma = L::select(is_nearer, hit.gamma, nearest.gamma);
                    let number = L::splat(token, f32::from_bits(number));
                    numbers = L::select(is_nearer, number, numbers);
                }
            },
        );
        lane += 1;
        // Whatever fills up a block has the number of the last one.
        if lane == WIDTH || block.triangles[lane] == number {
            break;
        }
    }
    if !ANY {
        bits = L::bits(nearest.t.lt(zero.constant(f32::INFINITY)));
    }
    let mut lanes = [[0.0; WIDTH]; 4];
    nearest.t.store(&mut lanes[0]);
    nearest.beta.store(&mut lanes[1]);
    nearest.gamma.store(&mut lanes[2]);
    numbers.store(&mut lanes[3]);
    let any = bits != 0;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize % WIDTH;
        bits &= bits - 1;
        let place = usize::from(places[lane]) % RAYS;
        let tmax = rows.tmax(place);
        let best = &mut rows.best[place];
        if ANY {
            best.triangle = ANYTHING;
        } else {
            let [t, beta, gamma, number] =
                [lanes[0][lane], lanes[1][lane], lanes[2][lane], lanes[3][lane]];
            let hit = Hit { t, beta, gamma };
            best.improve(TriangleHit { triangle: number.to_bits(), hit });
        }
        let tmax = end::<ANY, ROBUST>(best, tmax);
        rows.shorten(place, tmax);
    }
    any
}
