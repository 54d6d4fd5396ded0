//! A ray at a leaf: the test of its triangles, eight at a time.

use std::hint::select_unpredictable;
use std::ops::Range;

use trisect_core::{
    Culling, DecisionOnly, Deferred, Division, Early, Hit, Interval, Lanes, Method, Of, Record,
    TrueDivision,
};

use crate::bvh::WIDTH;
use crate::exactly::{self, Given, Left};
use crate::hit::TriangleHit;
use crate::rows::least;
use crate::slabs::{ROUNDINGS, UNDERFLOW};

/// Stands for the triangle where any will do.
pub(crate) const ANYTHING: u32 = 0;

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
/// is one. What is left to be settled, by a method that claims to be exact.
#[inline(always)]
pub(crate) fn test_leaf<M, L, const ANY: bool>(
    token: L::Token,
    blocks: Range<usize>,
    given: Given<'_, M>,
    best: &mut TriangleHit,
) -> Left
where
    M: Method,
    L: Lanes<Elem = f32>,
{
    let axis = if const { M::TURNS } { given.ray.d.largest_axis() } else { 2 };
    match axis {
        0 if const { M::TURNS } => test_blocks::<M, L, ANY, 0>(token, blocks, given, best),
        1 if const { M::TURNS } => test_blocks::<M, L, ANY, 1>(token, blocks, given, best),
        _ => test_blocks::<M, L, ANY, 2>(token, blocks, given, best),
    }
}

#[inline(always)]
fn test_blocks<M: Method, L: Lanes<Elem = f32>, const ANY: bool, const AXIS: usize>(
    token: L::Token,
    blocks: Range<usize>,
    given: Given<'_, M>,
    best: &mut TriangleHit,
) -> Left {
    let Given { bvh, ray, .. } = given;
    let interval = Interval { tmin: L::splat(token, ray.tmin), tmax: L::splat(token, ray.tmax) };
    // What is computed once per ray costs less here than to keep it for every ray in flight, even where it
    // divides.
    let ray = ray
        .map(
            #[inline(always)]
            |&x| L::splat(token, x),
        )
        .with_axis_last(AXIS);
    // Not zipped: that may stay a call.
    for at in blocks.clone() {
        let group = if const { M::GROUPS > 1 } { usize::from(bvh.groups[at]) } else { 0 };
        let ray = M::prepare_ray(&ray, group);
        let near = test_block::<M, L, ANY, AXIS>(token, &ray, at, interval, given, best);
        if const { M::INFO.claims.exact && !ANY } && near != 0 {
            return Left { blocks: at..blocks.end, near };
        }
    }
    Left { blocks, near: 0 }
}

/// Tests the triangles of a block. Those that are left to be [settled](exactly::settle_at), in bits.
#[inline(always)]
fn test_block<M: Method, L: Lanes<Elem = f32>, const ANY: bool, const AXIS: usize>(
    token: L::Token,
    ray: &M::PreparedRay<L>,
    at: usize,
    interval: Interval<L>,
    given: Given<'_, M>,
    best: &mut TriangleHit,
) -> u64 {
    let block = &given.bvh.blocks[at];
    let mut lane = 0;
    while lane < WIDTH {
        let triangle = M::Prepared::map(
            &block.prepared,
            #[inline(always)]
            |row: &[f32; WIDTH]| L::load(token, &row[lane..]),
        );
        let triangle = M::Prepared::with_axis_last(&triangle, AXIS);
        if const { M::INFO.claims.exact && !ANY } {
            let mut near = 0;
            M::screen(
                ray,
                &triangle,
                interval,
                given.culling,
                #[inline(always)]
                |screened| near = exactly::take::<L>(at, lane, screened, best),
            );
            if near != 0 {
                // With the lanes that come after these.
                return (near | u64::MAX << (L::N - 1) << 1) << lane;
            }
        } else {
            test::<M, L, ANY>(
                ray,
                &triangle,
                interval,
                given.culling,
                #[inline(always)]
                |met, hit| {
                    if ANY {
                        best.triangle = select_unpredictable(L::any(met), ANYTHING, best.triangle);
                    } else {
                        best.improve(nearest(met, hit, &block.triangles[lane..]));
                    }
                },
            );
        }
        lane += L::N;
    }
    0
}

/// The form of the division: the one that decides without quotients, where there is one, and without any
/// where `ANY` hit will do. It does not ask whether anything is hit: in a leaf that a ray has come to that
/// is as likely as not, and a branch that is foretold wrongly costs as much as the rest of the test.
#[inline(always)]
pub(crate) fn test<M: Method, L: Lanes, const ANY: bool>(
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
    if ANY {
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
