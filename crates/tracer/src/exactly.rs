//! What a leaf's triangles do to a ray's best hit where the method claims to be exact.
//!
//! On its way a ray knows of its best hit the triangle, and between which numbers `t` lies. That is mostly
//! enough to tell which of two hits comes first, at a filter's cost and without branches. What is not told so
//! is settled at once, exactly; and values are computed once, when the ray has arrived.

use std::hint::select_unpredictable;
use std::ops::Range;

use trisect_core::{
    Culling, DecisionOnly, Deferred, Hit, Interval, Lanes, Method, Of, Ray, Screened, Triangle,
    TrueDivision, Vec3,
};

use crate::bvh::{Bvh, WIDTH};
use crate::hit::TriangleHit;
use crate::rows::{RAYS, Row, Rows, least};

/// What a decision takes besides the triangle. Handed on by value: where a call might see the ray in memory,
/// it would be put there for every leaf.
pub(crate) struct Given<'a, M: Method> {
    pub(crate) bvh: &'a Bvh<M>,
    pub(crate) ray: Ray<f32>,
    pub(crate) culling: Culling,
}

impl<M: Method> Clone for Given<'_, M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Method> Copy for Given<'_, M> {}

/// The best hit of a ray on its way: the place of a triangle among all blocks, and between which numbers `t`
/// lies. It ends the ray's interval where `t` is largest.
#[inline(always)]
fn on_its_way(place: u32, [low, high]: [f32; 2]) -> TriangleHit {
    TriangleHit { triangle: place, hit: Hit { t: high, beta: low, gamma: 0.0 } }
}

/// The place of a lane of a block.
#[allow(clippy::cast_possible_truncation, reason = "a tree has fewer blocks than 2²⁸")]
#[inline(always)]
fn place_of(block: usize, lane: usize) -> u32 {
    (block * WIDTH + lane) as u32
}

/// Takes what comes before the best hit of the lanes of a block from `lane` on. The lanes that may, in
/// bits, where the bounds do not tell which of them does; nothing is taken then.
#[inline(always)]
pub(crate) fn take<L: Lanes<Elem = f32>>(
    block: usize,
    lane: usize,
    screened: Screened<L>,
    best: &mut TriangleHit,
) -> u64 {
    let Screened { certain, open, low, high } = screened;
    let first_high = least(L::select(certain, high, high.constant(f32::INFINITY)));
    let mut lows = [0.0; WIDTH];
    low.store(&mut lows);
    let (best_low, best_high) = (best.hit.beta, best.hit.t);
    let is_before = first_high < best_low;
    // All that may come before, or at the same point: among them whatever ends there.
    let end = Lanes::min(first_high, best_high);
    let near = L::bits(certain) & L::bits(low.le(low.constant(end))) | open;
    // One, where it is before the best hit, and otherwise none.
    if near & near.wrapping_sub(u64::from(is_before)) != 0 {
        return near;
    }
    let first = near.trailing_zeros() as usize % WIDTH;
    let place = place_of(block, lane + first);
    best.triangle = select_unpredictable(is_before, place, best.triangle);
    best.hit.t = end;
    best.hit.beta = select_unpredictable(is_before, lows[first], best_low);
    0
}

/// What is left of a leaf to be settled: the lanes of the first of some blocks, in bits, and all of the
/// others. Nothing where there are no bits.
#[must_use]
pub(crate) struct Left {
    pub(crate) blocks: Range<usize>,
    pub(crate) near: u64,
}

/// Settles what a test of a leaf has left of a ray, if anything. Called in the loop over blocks it would have all
/// that is computed before that kept in memory, and fetched from there in every round; and the ray likewise,
/// were it handed on.
#[inline(always)]
pub(crate) fn settle_at<M: Method>(
    bvh: &Bvh<M>,
    culling: Culling,
    rows: &mut Rows,
    place: usize,
    left: &Left,
) {
    if const { M::INFO.claims.exact } && left.near != 0 {
        let Left { blocks: Range { start, end }, near } = *left;
        settle_in_rows(bvh, culling, rows, place, (start, end), near);
    }
}

#[cold]
#[inline(never)]
fn settle_in_rows<M: Method>(
    bvh: &Bvh<M>,
    culling: Culling,
    rows: &mut Rows,
    place: usize,
    (start, end): (usize, usize),
    near: u64,
) {
    let place = place % RAYS;
    let given = Given { bvh, ray: rows.ray(place), culling };
    settle(given, Left { blocks: start..end, near }, &mut rows.best[place]);
}

/// Takes the first of what is left where it comes before the best hit: decides and orders exactly.
#[cold]
pub(crate) fn settle<M: Method>(
    given: Given<'_, M>,
    Left { blocks, near }: Left,
    best: &mut TriangleHit,
) {
    let Given { bvh, ref ray, .. } = given;
    let known = best.is_hit().then(|| bvh.triangle(best.triangle));
    let mut first = None;
    let lanes = blocks.clone().flat_map(|block| (0..WIDTH).map(move |lane| (block, lane)));
    let is_near = |&(block, lane): &(usize, usize)| block > blocks.start || near >> lane & 1 != 0;
    for (block, lane) in lanes.filter(is_near) {
        let place = place_of(block, lane);
        let triangle = bvh.triangle(place);
        let prepared = bvh.prepared(place);
        // Where space is split a triangle is met in several leaves.
        if known == Some(triangle) || !is_hit(&given, &prepared) {
            continue;
        }
        let (first_place, first) =
            first.get_or_insert_with(|| (best.triangle, arrived(bvh, ray, best)));
        let other = TriangleHit { triangle, hit: values::<M>(ray, &prepared) };
        if first.improve_by(other, || M::order(ray, &prepared, &bvh.prepared(*first_place))) {
            *first_place = place;
        }
    }
    if let Some((place, TriangleHit { hit: Hit { t, .. }, .. })) = first {
        // It was rounded once, and its ends are.
        let rounding = t.abs().mul_add(2.0 * f32::EPSILON, f32::MIN_POSITIVE);
        *best = on_its_way(place, [t - rounding, t + rounding]);
    }
}

/// Whether a ray hits a triangle.
fn is_hit<M: Method>(given: &Given<'_, M>, prepared: &Of<M::Prepared, f32>) -> bool {
    let Given { ref ray, culling, .. } = *given;
    let interval = Interval { tmin: ray.tmin, tmax: ray.tmax };
    let ray = M::prepare_ray::<f32>(ray, 0);
    let mut is_hit = false;
    M::test::<f32, DecisionOnly<Deferred<TrueDivision, true>>>(
        &ray,
        prepared,
        interval,
        culling,
        |met, _| is_hit = met,
    );
    is_hit
}

/// The best hit of a ray that has arrived, with its number and its values.
pub(crate) fn arrived<M: Method>(bvh: &Bvh<M>, ray: &Ray<f32>, best: &TriangleHit) -> TriangleHit {
    if !best.is_hit() {
        return *best;
    }
    let place = best.triangle;
    TriangleHit { triangle: bvh.triangle(place), hit: values::<M>(ray, &bvh.prepared(place)) }
}

/// The values of one hit.
fn values<M: Method>(ray: &Ray<f32>, prepared: &Of<M::Prepared, f32>) -> Hit<f32> {
    let rays = ray.map(|&x| [x]);
    let Ray { o, d, tmin, tmax } = &rays;
    let rays = Ray { o: o.each_ref(), d: d.each_ref(), tmin, tmax };
    let Hit { t: [t], beta: [beta], gamma: [gamma] } =
        M::values(&rays, &M::corners(prepared).map(|&x| [x]), 1);
    Hit { t, beta, gamma }
}

/// Computes the values of rays that have arrived, all at once: what is brought together number by number
/// can be read by lanes only when it has been written for a while. The rays lie number by number already, so
/// that only triangles have to be brought to them.
#[inline(always)]
pub(crate) fn arrive<M: Method>(bvh: &Bvh<M>, rows: &mut Rows) {
    let mut hits = 0;
    for place in 0..RAYS {
        hits |= u64::from(rows.best[place].is_hit()) << place;
    }
    if hits == 0 {
        return;
    }
    let mut left = hits;
    while left != 0 {
        let place = left.trailing_zeros() as usize % RAYS;
        left &= left - 1;
        let triangle = &mut rows.best[place].triangle;
        let Triangle { a, b, c } = M::corners(&bvh.prepared(*triangle));
        put(&mut rows.corners.a, place, a);
        put(&mut rows.corners.b, place, b);
        put(&mut rows.corners.c, place, c);
        // Here, where the next ones do not wait for it: it is in a part of the block not yet seen.
        *triangle = bvh.triangle(*triangle);
    }
    let found = M::values(&rows.rays(), &rows.corners, hits);
    while hits != 0 {
        let place = hits.trailing_zeros() as usize % RAYS;
        hits &= hits - 1;
        let (t, beta, gamma) = (found.t[place], found.beta[place], found.gamma[place]);
        rows.best[place].hit = Hit { t, beta, gamma };
    }
}

#[inline(always)]
fn put(rows: &mut Vec3<Row>, place: usize, v: Vec3<f32>) {
    (rows.x[place], rows.y[place], rows.z[place]) = (v.x, v.y, v.z);
}
