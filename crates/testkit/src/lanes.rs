//! What holds across widths, instruction sets, arrangements and divisions.
//!
//! Each lane type times division times arrangement is a kernel that takes a quarter of a second
//! to compile. The bits are compared on every width and instruction set for the deferred form, in
//! both arrangements; for the early form and without early-out on the native widths, which differ
//! from the others in the number of lanes alone.

use core::marker::PhantomData;

use proptest::prelude::*;
use trisect_core::{
    BLOCK, Culling, Deferred, Division, Early, Float, Hit, Lanes, LanesVisitor, Method, Newton,
    PADDING, Packet, Precision, PreparedTriangles, Ray, Reciprocal, Scalar, Token, Triangle,
    TrueDivision, intersect_with, one_ray, one_triangle,
};

use crate::draw::{Pair, check, clear_hits, well_conditioned};
use crate::properties::within_claim;
use crate::truth::Truth;

/// Counts of rays and triangles around whole blocks.
const COUNTS: [usize; 5] = [1, 15, 16, 17, 33];

/// What every ray found on every triangle.
struct Results<E> {
    triangles: usize,
    hits: Vec<Option<Hit<E>>>,
}

impl<E: Scalar> Results<E> {
    fn none(rays: usize, triangles: usize) -> Self {
        Self { triangles, hits: vec![None; rays * triangles] }
    }

    /// Notes a hit; rays and triangles that only fill up a block must have none.
    fn note(&mut self, ray: usize, triangle: u32, hit: Hit<E>) {
        assert!(triangle != PADDING, "a lane without a triangle hits");
        let place = ray * self.triangles + triangle as usize;
        assert!(place < self.hits.len(), "a lane without a ray hits");
        assert!(self.hits[place].replace(hit).is_none(), "a pair is tested twice");
    }
}

/// The lanes of a mask and their hits.
#[inline(always)]
fn unpack<L: Lanes>(mask: L::Mask, hit: Hit<L>, mut found: impl FnMut(usize, Hit<L::Elem>)) {
    let zero = L::Elem::from_f64(0.0);
    let (mut t, mut beta, mut gamma) = ([zero; BLOCK], [zero; BLOCK], [zero; BLOCK]);
    hit.t.store(&mut t);
    hit.beta.store(&mut beta);
    hit.gamma.store(&mut gamma);
    each_bit(L::bits(mask), &mut |lane| {
        found(lane, Hit { t: t[lane], beta: beta[lane], gamma: gamma[lane] });
    });
}

/// Out of line and behind a pointer: compiled once, not in every kernel.
fn each_bit(bits: u64, found: &mut dyn FnMut(usize)) {
    for lane in (0..BLOCK).filter(|lane| bits >> lane & 1 == 1) {
        found(lane);
    }
}

fn by_ray<M: Method, L: Lanes, D: Division>(
    token: L::Token,
    rays: &[Ray<L::Elem>],
    triangles: &[Triangle<L::Elem>],
    culling: Culling,
) -> Results<L::Elem> {
    let prepared = PreparedTriangles::<M, L::Elem>::new(triangles);
    let mut results = Results::none(rays.len(), triangles.len());
    token.run(
        #[inline(always)]
        || {
            for (i, ray) in rays.iter().enumerate() {
                one_ray::<M, L, D>(
                    token,
                    ray,
                    &prepared,
                    culling,
                    #[inline(always)]
                    |place, mask, hit| {
                        unpack(mask, hit, |lane, hit| {
                            results.note(i, prepared.number(place + lane), hit);
                        });
                    },
                );
            }
        },
    );
    results
}

fn by_triangle<M: Method, L: Lanes, D: Division>(
    token: L::Token,
    rays: &[Ray<L::Elem>],
    triangles: &[Triangle<L::Elem>],
    culling: Culling,
) -> Results<L::Elem> {
    let prepared = PreparedTriangles::<M, L::Elem>::new(triangles);
    let packets = Packet::pack(rays);
    let mut results = Results::none(rays.len(), triangles.len());
    token.run(
        #[inline(always)]
        || {
            for (i, packet) in packets.iter().enumerate() {
                one_triangle::<M, L, D>(
                    token,
                    packet,
                    &prepared,
                    culling,
                    #[inline(always)]
                    |first, place, mask, hit| {
                        unpack(mask, hit, |lane, hit| {
                            let ray = i * BLOCK + first + lane;
                            results.note(ray, prepared.number(place), hit);
                        });
                    },
                );
            }
        },
    );
    results
}

/// Pairs, every fourth aimed at a corner, where decisions hang on the last bit.
fn scene() -> impl Strategy<Value = Vec<Pair>> {
    prop::collection::vec(well_conditioned(-0.2..0.8), 33).prop_map(|mut pairs| {
        for pair in pairs.iter_mut().step_by(4) {
            pair.ray.d = pair.triangle.b - pair.ray.o;
        }
        // NaN and degenerate triangles must be the same everywhere as well.
        pairs[2].ray.o.x = f64::NAN;
        pairs[3].triangle.b = pairs[3].triangle.c;
        pairs
    })
}

fn split<E: Float>(pairs: &[Pair]) -> (Vec<Ray<E>>, Vec<Triangle<E>>) {
    pairs.iter().map(Pair::round::<E>).unzip()
}

fn bits<E: Float>(hit: Option<Hit<E>>) -> Option<[u64; 3]> {
    hit.map(|hit| [hit.t.bits64(), hit.beta.bits64(), hit.gamma.bits64()])
}

struct SameBits<'a, M, D> {
    pairs: &'a [Pair],
    method: PhantomData<(M, D)>,
}

impl<M: Method, D: Division> LanesVisitor for SameBits<'_, M, D> {
    fn visit<L: Lanes<Elem: Precision>>(&mut self) {
        if L::FUSED {
            return;
        }
        let Some(token) = L::Token::detect() else {
            return;
        };
        let (rays, triangles) = split::<L::Elem>(self.pairs);
        for culling in [Culling::None, Culling::Back, Culling::Front] {
            for count in COUNTS {
                let by_ray = by_ray::<M, L, D>(token, &rays, &triangles[..count], culling);
                same_bits::<M, D, L>("one ray", &by_ray, &rays, &triangles[..count], culling);
                let rays = &rays[..count];
                let by_triangle = by_triangle::<M, L, D>(token, rays, &triangles, culling);
                same_bits::<M, D, L>("one triangle", &by_triangle, rays, &triangles, culling);
            }
        }
    }
}

fn same_bits<M: Method, D: Division, L: Lanes<Elem: Float>>(
    arrangement: &str,
    results: &Results<L::Elem>,
    rays: &[Ray<L::Elem>],
    triangles: &[Triangle<L::Elem>],
    culling: Culling,
) {
    let pairs = rays.iter().flat_map(|ray| triangles.iter().map(move |triangle| (ray, triangle)));
    for ((ray, triangle), found) in pairs.zip(&results.hits) {
        let scalar = intersect_with::<M, D, L::Elem>(ray, triangle, culling);
        assert!(
            bits(*found) == bits(scalar),
            "{}, {}×{} on {}, {arrangement}, {culling:?}: {found:?}, scalar {scalar:?}\n\
             {ray:?}\n{triangle:?}",
            D::NAME,
            <L::Elem as Float>::NAME,
            L::N,
            L::Token::INSTRUCTION_SET,
        );
    }
}

/// Every width on every instruction set has the bits of the scalar.
pub fn every_width_has_the_scalar_bits<M: Method>() {
    fn of<M: Method, D: Division>() {
        check(2, &scene(), |pairs| {
            let mut visitor = SameBits::<M, D> { pairs: &pairs, method: PhantomData };
            f32::visit_all(&mut visitor);
            f64::visit_all(&mut visitor);
            Ok(())
        });
    }
    of::<M, Deferred<TrueDivision, true>>();
}

/// The native widths have the bits of the scalar in both forms, with early-out and without.
pub fn every_division_has_the_scalar_bits<M: Method>() {
    fn of<M: Method, D: Division>() {
        check(2, &scene(), |pairs| {
            let mut visitor = SameBits::<M, D> { pairs: &pairs, method: PhantomData };
            f32::visit_native(&mut visitor);
            f64::visit_native(&mut visitor);
            Ok(())
        });
    }
    of::<M, Early<TrueDivision, true>>();
    of::<M, Early<TrueDivision, false>>();
    of::<M, Deferred<TrueDivision, false>>();
}

struct WithinClaim<'a, M, D> {
    pairs: &'a [Pair],
    method: PhantomData<(M, D)>,
}

impl<M: Method, D: Division> LanesVisitor for WithinClaim<'_, M, D> {
    fn visit<L: Lanes<Elem: Precision>>(&mut self) {
        let Some(token) = L::Token::detect() else {
            return;
        };
        // One Newton step from eleven bits leaves a relative error of 4 units or less, its own
        // rounding adds 3; the condition number is at least twice the value.
        let more = if D::RECIPROCAL == TrueDivision::NAME { 0.0 } else { 4.0 };
        let (mut rays, mut triangles) = split::<L::Elem>(self.pairs);
        let clear = rays.len();
        for place in 0..clear {
            // A degenerate triangle, and a ray to the middle of what is left of it.
            let (o, Triangle { a, b, .. }) = (rays[place].o, triangles[place]);
            let half = L::Elem::from_f64(0.5);
            rays.push(Ray { d: (a + b).scale(half) - o, ..rays[place] });
            triangles.push(Triangle { a, b, c: b });
        }
        let results = by_ray::<M, L, D>(token, &rays, &triangles, Culling::None);
        let form = (D::NAME, D::RECIPROCAL, L::FUSED, L::N, L::Token::INSTRUCTION_SET);
        for (ray, found) in results.hits.chunks(triangles.len()).enumerate() {
            assert!(found[clear..].iter().all(Option::is_none), "{form:?} hits a degenerate one");
            if ray < clear {
                let hit = found[ray].unwrap_or_else(|| panic!("{form:?} misses a clear hit"));
                let truth = Truth::of(&rays[ray], &triangles[ray]).expect("well conditioned");
                if let Err(error) = within_claim::<M, L::Elem>(&truth, &hit, more, form) {
                    panic!("{error}");
                }
            }
        }
    }
}

/// Fused arithmetic and Newton's reciprocal keep the claim about errors, the latter with 4 units
/// more, hit what is hit clearly, and do not hit degenerate triangles.
pub fn fused_and_newton_keep_the_claim<M: Method>() {
    fn of<M: Method, D: Division>() {
        check(8, &prop::collection::vec(clear_hits(), 33), |pairs| {
            let mut visitor = WithinClaim::<M, D> { pairs: &pairs, method: PhantomData };
            f32::visit_native(&mut visitor);
            f64::visit_native(&mut visitor);
            Ok(())
        });
    }
    of::<M, Deferred<Newton, true>>();
    of::<M, Deferred<TrueDivision, true>>();
}
