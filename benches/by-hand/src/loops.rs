//! Loops of intrinsics: one ray against eight or sixteen triangles at a time, every operation in the order of
//! the method's formula, fused as its kernels fuse, so that both find the same hits.

use std::cell::RefCell;

use trisect_badouel::BadouelCramer;
use trisect_baldwin_weber::BaldwinWeber12;
use trisect_core::{Ray, Scalar as _, Triangle, Vec3};
use trisect_kernels::BLOCK;
use trisect_method::{Interval, Method, Record as _};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_wald::Wald;

use crate::Tally;
use crate::isa::Isa;

/// Sixteen triangles, number by number.
#[repr(align(64))]
struct Block<const ROWS: usize>([[f32; BLOCK]; ROWS]);

/// The triangles of each kind.
pub(crate) struct Blocks<const ROWS: usize>(Vec<Vec<Block<ROWS>>>);

/// A method by hand. `row` loads a number of the triangles, which are stored as the method stores them.
pub(crate) trait ByHand<const ROWS: usize>: 'static {
    /// The method.
    type Method: Method;
    /// `det`, and `t`, `beta` and `gamma` times `det`.
    fn deferred<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 4];
    /// `t`, `beta`, `gamma`
    fn early<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 3];
}

/// A ray in all lanes.
pub(crate) struct Vectors<I: Isa> {
    o: [I::V; 3],
    d: [I::V; 3],
    /// `tmin` and `tmax`
    ends: [I::V; 2],
    one: I::V,
    zero: I::V,
    smallest: I::V,
    largest: I::V,
}

impl<I: Isa> Vectors<I> {
    #[inline(always)]
    fn new(i: I, ray: &Ray<f32>, interval: Interval<f32>) -> Self {
        let splat = |x| i.splat(x);
        Self {
            o: ray.o.to_array().map(splat),
            d: ray.d.to_array().map(splat),
            ends: [splat(interval.tmin), splat(interval.tmax)],
            one: splat(1.0),
            zero: splat(0.0),
            smallest: splat(f32::smallest_det()),
            largest: splat(f32::largest_t()),
        }
    }
}

/// Prepares triangles as the method does: sixteen to a block, each kind by itself.
pub(crate) fn prepare<F: ByHand<ROWS>, const ROWS: usize>(
    triangles: &[Triangle<f32>],
) -> Blocks<ROWS> {
    let mut groups: Vec<Vec<_>> = (0..F::Method::GROUPS).map(|_| Vec::new()).collect();
    for triangle in triangles {
        groups[F::Method::group(triangle)].push(triangle.or_nothing());
    }
    let block = |group, chunk: &[Triangle<f32>]| {
        let mut block = Block([[0.0; BLOCK]; ROWS]);
        for lane in 0..BLOCK {
            let triangle = chunk.get(lane).copied().unwrap_or_else(far_away);
            let numbers = RefCell::new(Vec::new());
            let collect = |&x: &f32| numbers.borrow_mut().push(x);
            <F::Method as Method>::Prepared::map(&F::Method::prepare(&triangle, group), collect);
            for (row, x) in block.0.iter_mut().zip(numbers.into_inner()) {
                row[lane] = x;
            }
        }
        block
    };
    let blocks = |(group, members): (usize, &Vec<_>)| {
        members.chunks(BLOCK).map(|chunk| block(group, chunk)).collect()
    };
    Blocks(groups.iter().enumerate().map(blocks).collect())
}

/// A triangle that no ray meets, to fill up blocks: tests by sign bits take one of NaN for hit.
fn far_away() -> Triangle<f32> {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(1000.0 + x, 1000.0 + y, 1000.0 + z);
    Triangle { a: corner(0.0, 0.0, 0.0), b: corner(1.0, 0.0, 1.0), c: corner(0.0, 1.0, 1.0) }
}

/// When a loop divides, and what it compares.
pub(crate) trait Form: 'static {
    /// Whether the values are quotients.
    const DIVIDED: bool;
    /// Where a vector of pairs hits; `det`; `t`, `beta` and `gamma`.
    fn test<F: ByHand<ROWS>, I: Isa, const ROWS: usize>(
        i: I,
        ray: &Vectors<I>,
        row: impl Fn(usize) -> I::V,
    ) -> (I::M, I::V, [I::V; 3]);
}

/// Divides first.
pub(crate) struct DividesFirst;

impl Form for DividesFirst {
    const DIVIDED: bool = true;
    #[inline(always)]
    fn test<F: ByHand<ROWS>, I: Isa, const ROWS: usize>(
        i: I,
        ray: &Vectors<I>,
        row: impl Fn(usize) -> I::V,
    ) -> (I::M, I::V, [I::V; 3]) {
        let [t, beta, gamma] = F::early(i, ray, row);
        let mask = i.le(ray.ends[0], t);
        let mask = i.and_le(mask, t, ray.ends[1]);
        let mask = i.and_le(mask, ray.zero, beta);
        let mask = i.and_le(mask, ray.zero, gamma);
        let mask = i.and_le(mask, i.add(beta, gamma), ray.one);
        (mask, ray.one, [t, beta, gamma])
    }
}

/// Divides for hits alone, and compares numerators whose signs are flipped where `det` is negative. With
/// `CONTRACT` also sees to it that the reciprocal of `det` is finite and not zero, as the kernels do.
pub(crate) struct DividesLast<const CONTRACT: bool>;

impl<const CONTRACT: bool> Form for DividesLast<CONTRACT> {
    const DIVIDED: bool = false;
    #[inline(always)]
    fn test<F: ByHand<ROWS>, I: Isa, const ROWS: usize>(
        i: I,
        ray: &Vectors<I>,
        row: impl Fn(usize) -> I::V,
    ) -> (I::M, I::V, [I::V; 3]) {
        let [det, t, beta, gamma] = F::deferred(i, ray, row);
        let [t, beta, gamma] = [t, beta, gamma].map(|x| i.flip(x, det));
        let det = i.abs(det);
        let mut mask = i.le(ray.zero, beta);
        mask = i.and_le(mask, ray.zero, gamma);
        mask = i.and_le(mask, i.add(beta, gamma), det);
        mask = i.and_le(mask, i.fms(ray.ends[0], det, t), ray.zero);
        mask = i.and_le(mask, ray.zero, i.fms(ray.ends[1], det, t));
        if CONTRACT {
            mask = i.and_le(mask, ray.smallest, det);
            mask = i.and_le(mask, det, ray.largest);
        }
        (mask, det, [t, beta, gamma])
    }
}

/// Havel's tests by sign bits (2008, section 4.2.4): `beta`, `gamma`, what they leave of `det`, and the
/// distances from both ends of the interval, all times `det`, have one sign. With `CONTRACT` also sees to it
/// that `det` is neither NaN nor subnormal.
pub(crate) struct SameSigns<const CONTRACT: bool>;

impl<const CONTRACT: bool> Form for SameSigns<CONTRACT> {
    const DIVIDED: bool = false;
    #[inline(always)]
    fn test<F: ByHand<ROWS>, I: Isa, const ROWS: usize>(
        i: I,
        ray: &Vectors<I>,
        row: impl Fn(usize) -> I::V,
    ) -> (I::M, I::V, [I::V; 3]) {
        let [det, t, beta, gamma] = F::deferred(i, ray, row);
        let alpha = i.sub(i.sub(det, beta), gamma);
        let after = i.fnma(ray.ends[0], det, t);
        let before = i.fms(ray.ends[1], det, t);
        let differ = i.differ([beta, gamma, alpha, after, before]);
        let mask = if CONTRACT {
            i.le(ray.smallest, i.with_sign(det, differ))
        } else {
            i.positive(differ)
        };
        (mask, det, [t, beta, gamma])
    }
}

/// What is asked of the hits.
pub(crate) trait Ask<I: Isa> {
    /// Whether vectors without a hit are passed over.
    const EARLY_OUT: bool;
    /// Takes in a vector; where the interval ends from now on, if that changes.
    fn found(&mut self, i: I, mask: I::M, values: impl FnOnce() -> [I::V; 3]) -> Option<f32>;
    /// A ray is done with.
    fn next_ray(&mut self) {}
    /// All that was found.
    fn tally(self, i: I) -> Tally;
}

/// How many pairs hit.
pub(crate) struct Occlusion(u64);

/// How many pairs hit, and the sum of `t + beta + gamma`.
pub(crate) struct Values<V>(u64, V);

/// How many rays hit, and the sum of the closest `t`.
pub(crate) struct Closest(Tally, Option<f32>);

impl Occlusion {
    pub(crate) fn new<I: Isa>(_: I) -> Self {
        Self(0)
    }
}

impl<V> Values<V> {
    pub(crate) fn new<I: Isa<V = V>>(i: I) -> Self {
        Self(0, i.splat(0.0))
    }
}

impl Closest {
    pub(crate) fn new<I: Isa>(_: I) -> Self {
        Self(Tally::default(), None)
    }
}

impl<I: Isa> Ask<I> for Occlusion {
    const EARLY_OUT: bool = false;
    #[inline(always)]
    fn found(&mut self, i: I, mask: I::M, _: impl FnOnce() -> [I::V; 3]) -> Option<f32> {
        self.0 += u64::from(i.bits(mask).count_ones());
        None
    }
    fn tally(self, _: I) -> Tally {
        Tally { hits: self.0, sum: 0.0 }
    }
}

impl<I: Isa> Ask<I> for Values<I::V> {
    const EARLY_OUT: bool = false;
    #[inline(always)]
    fn found(&mut self, i: I, mask: I::M, values: impl FnOnce() -> [I::V; 3]) -> Option<f32> {
        let [t, beta, gamma] = values();
        self.0 += u64::from(i.bits(mask).count_ones());
        self.1 = i.add_where(mask, self.1, i.add(t, i.add(beta, gamma)));
        None
    }
    fn tally(self, i: I) -> Tally {
        Tally { hits: self.0, sum: i.store(self.1).iter().map(|&x| f64::from(x)).sum() }
    }
}

impl<I: Isa> Ask<I> for Closest {
    const EARLY_OUT: bool = true;
    #[inline(always)]
    fn found(&mut self, i: I, mask: I::M, values: impl FnOnce() -> [I::V; 3]) -> Option<f32> {
        nearest(i.bits(mask).into(), &i.store(values()[0]), &mut self.1);
        self.1
    }
    #[inline(always)]
    fn next_ray(&mut self) {
        self.0.take(&mut self.1);
    }
    fn tally(self, _: I) -> Tally {
        self.0
    }
}

/// The smallest `t` of those whose bits are set, and of what there was.
#[inline(never)]
pub(crate) fn nearest(mut bits: u64, all: &[f32; BLOCK], nearest: &mut Option<f32>) {
    while bits != 0 {
        let t = all[bits.trailing_zeros() as usize];
        bits &= bits - 1;
        *nearest = Some(nearest.map_or(t, |nearest| nearest.min(t)));
    }
}

/// Tests every ray against every triangle.
pub(crate) fn run<F: ByHand<ROWS>, T: Form, I: Isa, A: Ask<I>, const ROWS: usize>(
    i: I,
    new: impl Fn(I) -> A,
    rays: &[Ray<f32>],
    blocks: &Blocks<ROWS>,
) -> Tally {
    i.run(
        #[inline(always)]
        || {
            let mut asked = new(i);
            for ray in rays {
                let mut interval = Interval::of(ray);
                for (group, blocks) in blocks.0.iter().enumerate() {
                    let turned =
                        if F::Method::GROUPS == 1 { *ray } else { ray.with_axis_last(group) };
                    let mut vectors = Vectors::new(i, &turned, interval);
                    // One loop: two nested ones are unrolled until they spill.
                    let mut rest = blocks.iter();
                    let mut current = rest.next();
                    let mut lane = 0;
                    while let Some(block) = current {
                        let start = lane;
                        lane = (lane + I::N) % BLOCK;
                        if lane == 0 {
                            current = rest.next();
                        }
                        let row = |number: usize| i.load(&block.0[number], start);
                        let (mask, det, numbers) = T::test::<F, I, ROWS>(i, &vectors, row);
                        if A::EARLY_OUT && i.bits(mask) == 0 {
                            continue;
                        }
                        let one = vectors.one;
                        let end = asked.found(i, mask, || {
                            if T::DIVIDED {
                                return numbers;
                            }
                            let r = i.div(one, det);
                            numbers.map(|x| i.mul(x, r))
                        });
                        if let Some(end) = end {
                            interval.tmax = end;
                            vectors.ends[1] = i.splat(end);
                        }
                    }
                }
                asked.next_ray();
            }
            asked.tally(i)
        },
    )
}

impl ByHand<9> for MollerTrumbore {
    type Method = Self;

    #[inline(always)]
    fn deferred<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 4] {
        let [ox, oy, oz] = ray.o;
        let [dx, dy, dz] = ray.d;
        // p = d × e2, det = e1 · p
        let (e2x, e2y, e2z) = (row(6), row(7), row(8));
        let px = i.fms(dy, e2z, i.mul(dz, e2y));
        let py = i.fms(dz, e2x, i.mul(dx, e2z));
        let pz = i.fms(dx, e2y, i.mul(dy, e2x));
        let (e1x, e1y, e1z) = (row(3), row(4), row(5));
        let det = i.fma(e1x, px, i.fma(e1y, py, i.mul(e1z, pz)));
        // s = o − a, beta' = s · p
        let (sx, sy, sz) = (i.sub(ox, row(0)), i.sub(oy, row(1)), i.sub(oz, row(2)));
        let beta = i.fma(sx, px, i.fma(sy, py, i.mul(sz, pz)));
        // q = s × e1, gamma' = d · q, t' = e2 · q
        let qx = i.fms(sy, e1z, i.mul(sz, e1y));
        let qy = i.fms(sz, e1x, i.mul(sx, e1z));
        let qz = i.fms(sx, e1y, i.mul(sy, e1x));
        let gamma = i.fma(dx, qx, i.fma(dy, qy, i.mul(dz, qz)));
        let t = i.fma(e2x, qx, i.fma(e2y, qy, i.mul(e2z, qz)));
        [det, t, beta, gamma]
    }

    #[inline(always)]
    fn early<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 3] {
        let [det, t, beta, gamma] = Self::deferred(i, ray, row);
        let r = i.div(ray.one, det);
        [t, beta, gamma].map(|x| i.mul(x, r))
    }
}

/// `det` and `t · det` of Wald's plane.
#[inline(always)]
fn wald_plane<I: Isa>(i: I, ray: &Vectors<I>, row: &impl Fn(usize) -> I::V) -> (I::V, I::V) {
    let [ox, oy, oz] = ray.o;
    let [dx, dy, dz] = ray.d;
    let (nu, nv, plane) = (row(0), row(1), row(6));
    let height = i.fma(nu, ox, i.fma(nv, oy, i.add(oz, plane)));
    (i.fma(nu, dx, i.fma(nv, dy, dz)), i.neg(height))
}

impl ByHand<9> for Wald {
    type Method = Self;

    #[inline(always)]
    fn deferred<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 4] {
        let (det, t) = wald_plane(i, ray, &row);
        let pu = i.fma(t, ray.d[0], i.mul(det, ray.o[0]));
        let pv = i.fma(t, ray.d[1], i.mul(det, ray.o[1]));
        let beta = i.fma(pu, row(2), i.fma(row(3), pv, i.mul(det, row(7))));
        let gamma = i.fma(pu, row(4), i.fma(row(5), pv, i.mul(det, row(8))));
        [det, t, beta, gamma]
    }

    #[inline(always)]
    fn early<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 3] {
        let (det, t) = wald_plane(i, ray, &row);
        let t = i.mul(t, i.div(ray.one, det));
        let pu = i.fma(t, ray.d[0], ray.o[0]);
        let pv = i.fma(t, ray.d[1], ray.o[1]);
        let beta = i.fma(pu, row(2), i.fma(row(3), pv, row(7)));
        let gamma = i.fma(pu, row(4), i.fma(row(5), pv, row(8)));
        [t, beta, gamma]
    }
}

/// `det`, `t · det`, and the corner as seen from the ray's origin, of Badouel's plane.
#[inline(always)]
fn badouel_plane<I: Isa>(i: I, ray: &Vectors<I>, row: &impl Fn(usize) -> I::V) -> [I::V; 4] {
    let [ox, oy, oz] = ray.o;
    let [dx, dy, dz] = ray.d;
    let (nu, nv, nw) = (row(0), row(1), row(2));
    let det = i.fma(nu, dx, i.fma(nv, dy, i.mul(nw, dz)));
    let height = i.sub(row(7), i.fma(nu, ox, i.fma(nv, oy, i.mul(nw, oz))));
    [det, height, i.sub(row(8), ox), i.sub(row(9), oy)]
}

/// The determinants of the point and either edge.
#[inline(always)]
fn badouel_inside<I: Isa>(i: I, [pu, pv]: [I::V; 2], row: &impl Fn(usize) -> I::V) -> [I::V; 2] {
    let (e1u, e1v, e2u, e2v) = (row(3), row(4), row(5), row(6));
    [i.fms(e2v, pu, i.mul(e2u, pv)), i.fms(e1u, pv, i.mul(e1v, pu))]
}

impl ByHand<10> for BadouelCramer {
    type Method = Self;

    #[inline(always)]
    fn deferred<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 4] {
        let [det, height, u, v] = badouel_plane(i, ray, &row);
        let pu = i.fms(height, ray.d[0], i.mul(det, u));
        let pv = i.fms(height, ray.d[1], i.mul(det, v));
        let [beta, gamma] = badouel_inside(i, [pu, pv], &row);
        [i.mul(det, row(2)), i.mul(height, row(2)), beta, gamma]
    }

    #[inline(always)]
    fn early<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 3] {
        let [det, height, u, v] = badouel_plane(i, ray, &row);
        let t = i.mul(height, i.div(ray.one, det));
        let (pu, pv) = (i.fms(t, ray.d[0], u), i.fms(t, ray.d[1], v));
        let r = i.div(ray.one, row(2));
        let [beta, gamma] = badouel_inside(i, [pu, pv], &row);
        [t, i.mul(beta, r), i.mul(gamma, r)]
    }
}

/// `slope · p`, the slope being stored from row `first` on, and what is added to the last product.
#[inline(always)]
fn linear<I: Isa>(
    i: I,
    row: &impl Fn(usize) -> I::V,
    first: usize,
    [x, y, _]: [I::V; 3],
    last: I::V,
) -> I::V {
    i.fma(row(first), x, i.fma(row(first + 1), y, last))
}

/// The ray as the unit triangle sees it: height, `beta` and `gamma` at its origin, then their change.
#[inline(always)]
fn mapped<I: Isa>(i: I, ray: &Vectors<I>, row: &impl Fn(usize) -> I::V) -> [[I::V; 3]; 2] {
    let (o, d) = (ray.o, ray.d);
    [
        [
            linear(i, row, 0, o, i.fma(row(2), o[2], row(9))),
            linear(i, row, 3, o, i.fma(row(5), o[2], row(10))),
            linear(i, row, 6, o, i.fma(row(8), o[2], row(11))),
        ],
        [
            linear(i, row, 0, d, i.mul(row(2), d[2])),
            linear(i, row, 3, d, i.mul(row(5), d[2])),
            linear(i, row, 6, d, i.mul(row(8), d[2])),
        ],
    ]
}

impl ByHand<12> for BaldwinWeber12 {
    type Method = Self;

    #[inline(always)]
    fn deferred<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 4] {
        let [[height, beta, gamma], [det, dbeta, dgamma]] = mapped(i, ray, &row);
        let t = i.neg(height);
        [det, t, i.fma(beta, det, i.mul(t, dbeta)), i.fma(gamma, det, i.mul(t, dgamma))]
    }

    #[inline(always)]
    fn early<I: Isa>(i: I, ray: &Vectors<I>, row: impl Fn(usize) -> I::V) -> [I::V; 3] {
        let [[height, beta, gamma], [det, dbeta, dgamma]] = mapped(i, ray, &row);
        let t = i.mul(i.neg(height), i.div(ray.one, det));
        [t, i.fma(t, dbeta, beta), i.fma(t, dgamma, gamma)]
    }
}
