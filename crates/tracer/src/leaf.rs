//! A ray at a leaf: the test of its triangles, eight at a time.

use std::hint::select_unpredictable;
use std::ops::Range;

use trisect_core::{
    Culling, DecisionOnly, Deferred, Division, Early, Hit, Interval, Lanes, Method, Of, Ray,
    Record, TrueDivision,
};

use crate::bvh::{Block, Bvh, WIDTH};
use crate::hit::TriangleHit;
use crate::rows::least;
use crate::slabs::{ROUNDINGS, UNDERFLOW};

/// Stands for the triangle where any will do.
const ANYTHING: u32 = 0;

/// Where a ray's interval ends after its best hit, not later than it did.
#[inline(always)]
pub(crate) fn end<const ANY: bool, const ROBUST: bool>(best: &TriangleHit, tmax: f32) -> f32 {
    let t = best.hit.t;
    match (ANY, ROBUST) {
        // Nothing more is looked for.
        (true, _) => f32::NEG_INFINITY,
        // What is nearer may have the same rounded `t`, and the quotient may round to a tie that the
        // numerators do not show: a triangle of a lower number must not be lost to that.
        (false, true) => Lanes::min(t + (t.abs() * ROUNDINGS + UNDERFLOW), tmax),
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
    let given = ray;
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
        test_block::<M, L, ANY, AXIS>(
            token,
            &ray,
            block,
            interval,
            culling,
            best,
            #[inline(always)]
            |best, hits| settle(bvh, given, block, hits, best),
        );
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
    settle: impl Fn(&mut TriangleHit, u64),
) {
    let mut lane = 0;
    while lane < WIDTH {
        let triangle = M::Prepared::map(
            &block.prepared,
            #[inline(always)]
            |row: &[f32; WIDTH]| L::load(token, &row[lane..]),
        );
        let triangle = M::Prepared::with_axis_last(&triangle, AXIS);
        test::<M, L, ANY>(
            ray,
            &triangle,
            interval,
            culling,
            #[inline(always)]
            |met, hit| {
                if ANY {
                    best.triangle = select_unpredictable(L::any(met), ANYTHING, best.triangle);
                } else if const { M::INFO.claims.exact } {
                    settle(best, L::bits(met) << lane);
                } else {
                    let numbers = &block.triangles[lane..];
                    best.improve(nearest(met, hit, numbers));
                }
            },
        );
        lane += L::N;
    }
}

/// Takes the first of the lanes of a block that hit, where it comes before the best hit: for a method that
/// orders what is equally near, and computes values apart.
#[inline(never)]
fn settle<M: Method>(
    bvh: &Bvh<M>,
    ray: &Ray<f32>,
    block: &Block<M>,
    mut hits: u64,
    best: &mut TriangleHit,
) {
    while hits != 0 {
        let lane = hits.trailing_zeros() as usize % WIDTH;
        hits &= hits - 1;
        let prepared = block.prepared_of(lane);
        let hit = M::values(ray, &prepared);
        let other = TriangleHit { triangle: block.triangles[lane], hit };
        let first = best.triangle;
        best.improve_by(other, || M::order(ray, &prepared, &bvh.prepared(first)));
    }
}

/// The form of the division: the one that decides without quotients, where there is one, and without any
/// where `ANY` hit will do or values come later. It does not ask whether anything is hit: in a leaf that a ray has come to that
/// is as likely as not, and a branch that is foretold wrongly costs as much as the rest of the test.
#[inline(always)]
fn test<M: Method, L: Lanes, const ANY: bool>(
    ray: &M::PreparedRay<L>,
    triangle: &Of<M::Prepared, L>,
    interval: Interval<L>,
    culling: Culling,
    found: impl FnOnce(L::Mask, Hit<L>),
) {
    // A method whose only published form divides first decides by numerators all the same, where it can.
    if const { M::INFO.forms.deferred() || (ANY && !M::INFO.always_divides) } {
        in_form::<M, L, Deferred<TrueDivision, false>, ANY>(
            ray, triangle, interval, culling, found,
        );
    } else {
        in_form::<M, L, Early<TrueDivision, false>, ANY>(ray, triangle, interval, culling, found);
    }
}

#[inline(always)]
fn in_form<M: Method, L: Lanes, D: Division, const ANY: bool>(
    ray: &M::PreparedRay<L>,
    triangle: &Of<M::Prepared, L>,
    interval: Interval<L>,
    culling: Culling,
    found: impl FnOnce(L::Mask, Hit<L>),
) {
    if ANY || const { M::INFO.claims.exact } {
        M::test::<L, DecisionOnly<D>>(ray, triangle, interval, culling, found);
    } else {
        M::test::<L, D>(ray, triangle, interval, culling, found);
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
