//! A ray at a leaf: the test of its triangles, eight at a time.

use std::hint::select_unpredictable;
use std::ops::Range;

use trisect_core::{
    Culling, Deferred, Early, Hit, Interval, Lanes, Method, Of, Ray, Record, TrueDivision,
};

use crate::bvh::{Block, Bvh, WIDTH};
use crate::hit::TriangleHit;
use crate::rows::least;
use crate::slabs::ROUNDINGS;

/// Stands for the triangle where any will do.
const ANYTHING: u32 = 0;

/// Where a ray's interval ends after its best hit.
#[inline(always)]
pub(crate) fn end<const ANY: bool, const ROBUST: bool>(best: &TriangleHit) -> f32 {
    let t = best.hit.t;
    match (ANY, ROBUST) {
        // Nothing more is looked for.
        (true, _) => f32::NEG_INFINITY,
        // The quotient may round to a tie that the numerators do not show: a triangle of a lower
        // number must not be lost to that.
        (false, true) => t + t.abs() * ROUNDINGS,
        (false, false) => t,
    }
}

/// Tests the triangles of a leaf, and takes what is better than the best hit; where `ANY`, only that there
/// is one.
#[inline(always)]
pub(crate) fn test_leaf<M, L, const ANY: bool>(
    bvh: &Bvh<M>,
    token: L::Token,
    blocks: Range<usize>,
    culling: Culling,
    ray: &Ray<f32>,
    best: &mut TriangleHit,
) where
    M: Method,
    L: Lanes<Elem = f32>,
{
    let axis = if const { M::TURNS } { ray.d.largest_axis() } else { 2 };
    match axis {
        0 if const { M::TURNS } => {
            test_blocks::<M, L, ANY, 0>(bvh, token, blocks, culling, ray, best);
        }
        1 if const { M::TURNS } => {
            test_blocks::<M, L, ANY, 1>(bvh, token, blocks, culling, ray, best);
        }
        _ => test_blocks::<M, L, ANY, 2>(bvh, token, blocks, culling, ray, best),
    }
}

#[inline(always)]
fn test_blocks<M: Method, L: Lanes<Elem = f32>, const ANY: bool, const AXIS: usize>(
    bvh: &Bvh<M>,
    token: L::Token,
    blocks: Range<usize>,
    culling: Culling,
    ray: &Ray<f32>,
    best: &mut TriangleHit,
) {
    let interval = Interval { tmin: L::splat(token, ray.tmin), tmax: L::splat(token, ray.tmax) };
    // What is computed once per ray costs less here than to keep it for every ray in flight.
    let ray = ray
        .map(
            #[inline(always)]
            |&x| L::splat(token, x),
        )
        .with_axis_last(AXIS);
    // Not zipped: that may stay a call.
    for at in blocks {
        let block = &bvh.blocks[at];
        let group = if const { M::GROUPS > 1 } { usize::from(bvh.groups[at]) } else { 0 };
        let ray = M::prepare_ray(&ray, group);
        test_block::<M, L, ANY, AXIS>(token, &ray, block, interval, culling, best);
    }
}

/// Tests the triangles of a block.
#[inline(always)]
fn test_block<M: Method, L: Lanes<Elem = f32>, const ANY: bool, const AXIS: usize>(
    token: L::Token,
    ray: &M::PreparedRay<L>,
    block: &Block<M>,
    interval: Interval<L>,
    culling: Culling,
    best: &mut TriangleHit,
) {
    let mut lane = 0;
    while lane < WIDTH {
        let triangle = M::Prepared::map(
            &block.prepared,
            #[inline(always)]
            |row: &[f32; WIDTH]| L::load(token, &row[lane..]),
        );
        let triangle = M::Prepared::with_axis_last(&triangle, AXIS);
        test::<M, L>(
            ray,
            &triangle,
            interval,
            culling,
            #[inline(always)]
            |met, hit| {
                if ANY {
                    best.triangle = select_unpredictable(L::any(met), ANYTHING, best.triangle);
                } else {
                    let numbers = &block.triangles[lane..];
                    best.improve(nearest(met, hit, numbers));
                }
            },
        );
        lane += L::N;
    }
}

/// The form of the division: the one that decides without quotients, where there is one. It does not ask
/// whether anything is hit: in a leaf that a ray has come to that is as likely as not, and a branch that
/// is foretold wrongly costs as much as the rest of the test.
#[inline(always)]
fn test<M: Method, L: Lanes>(
    ray: &M::PreparedRay<L>,
    triangle: &Of<M::Prepared, L>,
    interval: Interval<L>,
    culling: Culling,
    found: impl FnOnce(L::Mask, Hit<L>),
) {
    if const { M::INFO.forms.deferred() } {
        M::test::<L, Deferred<TrueDivision, false>>(ray, triangle, interval, culling, found);
    } else {
        M::test::<L, Early<TrueDivision, false>>(ray, triangle, interval, culling, found);
    }
}

/// The nearest of the lanes that hit, of equally near ones the first, which has the lowest number; as far
/// as can be where none hits.
#[inline(always)]
fn nearest<L: Lanes<Elem = f32>>(met: L::Mask, hit: Hit<L>, numbers: &[u32]) -> TriangleHit {
    let mut lanes = [[0.0; WIDTH]; 2];
    hit.beta.store(&mut lanes[0]);
    hit.gamma.store(&mut lanes[1]);
    let t = L::select(met, hit.t, hit.t.constant(f32::INFINITY));
    let least = least(t);
    let lane = L::bits(t.le(t.constant(least))).trailing_zeros() as usize % WIDTH;
    let hit = Hit { t: least, beta: lanes[0][lane], gamma: lanes[1][lane] };
    TriangleHit { triangle: numbers[lane % L::N], hit }
}
