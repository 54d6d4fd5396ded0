//! What holds across widths, instruction sets, arrangements and divisions.
//!
//! Each lane type times division times arrangement is a kernel that takes a twentieth of a second to
//! compile. The bits are compared on every width and instruction set for one form of each method, a
//! ray at a time; for both forms, in all arrangements, with early-out and without, on the native
//! widths, which differ from the others in the number of lanes alone.

use core::marker::PhantomData;

use proptest::prelude::*;
use trisect_core::{
    BLOCK, Common, CommonDirection, CommonOrigin, Culling, Deferred, Division, Early, Float, Hit,
    Interval, Lanes, LanesVisitor, Method, Newton, PADDING, Packets, Precision, PreparedPair,
    PreparedTriangles, Ray, Reciprocal, Scalar, Tested, Token, Triangle, TrueDivision, one_ray,
    one_triangle, shared_packets,
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

/// A way to test every ray against every triangle.
trait Arrange {
    const NAME: &'static str;
    /// What rays must share for it.
    const NEEDS: Common;
    fn run<M: Method, L: Lanes, D: Division>(
        token: L::Token,
        rays: &[Ray<L::Elem>],
        triangles: &[Triangle<L::Elem>],
        culling: Culling,
    ) -> Results<L::Elem>;
}

const NOTHING: Common = Common { origin: false, direction: false };

struct ByRay;

impl Arrange for ByRay {
    const NAME: &'static str = "one ray";
    const NEEDS: Common = NOTHING;
    fn run<M: Method, L: Lanes, D: Division>(
        token: L::Token,
        rays: &[Ray<L::Elem>],
        triangles: &[Triangle<L::Elem>],
        culling: Culling,
    ) -> Results<L::Elem> {
        let prepared = prepared::<M, L::Elem>(triangles);
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
                        |tested, mask, hit| {
                            unpack(mask, hit, |lane, hit| {
                                let number = prepared.number(tested.triangle_place + lane);
                                results.note(i, number, hit);
                            });
                        },
                    );
                }
            },
        );
        results
    }
}

macro_rules! packets {
    ($name:ident, $words:literal, $common:expr, $run:expr) => {
        struct $name;

        impl Arrange for $name {
            const NAME: &'static str = $words;
            const NEEDS: Common = $common;
            fn run<M: Method, L: Lanes, D: Division>(
                token: L::Token,
                rays: &[Ray<L::Elem>],
                triangles: &[Triangle<L::Elem>],
                culling: Culling,
            ) -> Results<L::Elem> {
                let prepared = prepared::<M, L::Elem>(triangles);
                let packets = Packets::new::<M>(rays);
                let mut results = Results::none(rays.len(), triangles.len());
                token.run(
                    #[inline(always)]
                    || {
                        $run(
                            token,
                            &packets,
                            &prepared,
                            culling,
                            #[inline(always)]
                            |tested: Tested<'_, M, L>, mask, hit| {
                                unpack(mask, hit, |lane, hit| {
                                    let ray = packets.number(tested.ray_place + lane);
                                    let number = prepared.number(tested.triangle_place);
                                    assert!(ray != PADDING, "a lane without a ray hits");
                                    results.note(ray as usize, number, hit);
                                });
                            },
                        );
                    },
                );
                results
            }
        }
    };
}
packets!(ByTriangle, "one triangle", NOTHING, one_triangle::<M, L, D>);
packets!(
    ByOrigin,
    "common origin",
    Common { origin: true, direction: false },
    shared_packets::<M, L, D, CommonOrigin>
);
packets!(
    ByDirection,
    "common direction",
    Common { origin: false, direction: true },
    shared_packets::<M, L, D, CommonDirection>
);

fn prepared<M: Method, E: Scalar>(triangles: &[Triangle<E>]) -> PreparedTriangles<M, E> {
    PreparedTriangles::new(triangles).expect("random triangles suit every method")
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

fn wide<E: Float>(hit: Hit<E>) -> [u64; 3] {
    [hit.t.bits64(), hit.beta.bits64(), hit.gamma.bits64()]
}

struct SameBits<'a, M, D, A> {
    pairs: &'a [Pair],
    method: PhantomData<(M, D, A)>,
}

impl<M: Method, D: Division, A: Arrange> LanesVisitor for SameBits<'_, M, D, A> {
    fn visit<L: Lanes<Elem: Precision>>(&mut self) {
        if const { L::FUSED } {
            return;
        }
        let Some(token) = L::Token::detect() else {
            return;
        };
        let (mut rays, triangles) = split::<L::Elem>(self.pairs);
        share(&mut rays, A::NEEDS);
        for culling in [Culling::None, Culling::Back, Culling::Front] {
            for count in COUNTS {
                let rays = if A::NEEDS == NOTHING { &rays } else { &rays[..count] };
                let triangles =
                    if A::NEEDS == NOTHING { &triangles[..count] } else { &triangles[..] };
                let results = A::run::<M, L, D>(token, rays, triangles, culling);
                same_bits::<M, D, L>(A::NAME, &results, rays, triangles, culling);
            }
        }
    }
}

/// Gives all rays what they must share.
fn share<E: Float>(rays: &mut [Ray<E>], needs: Common) {
    // The first ray that is finite: one of them is not.
    let first = rays[0];
    for ray in rays {
        if needs.origin {
            ray.o = first.o;
        }
        if needs.direction {
            ray.d = first.d;
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
        let scalar = in_mesh::<M, D, L::Elem>(ray, triangle, triangles, culling);
        assert!(
            found.map(wide) == scalar.map(wide),
            "{}, {}×{} on {}, {arrangement}, {culling:?}: {found:?}, scalar {scalar:?}\n\
             {ray:?}\n{triangle:?}",
            D::NAME,
            <L::Elem as Float>::NAME,
            L::N,
            L::Token::INSTRUCTION_SET,
        );
    }
}

/// The scalar's answer to a pair, the triangle being one of a mesh.
fn in_mesh<M: Method, D: Division, E: Scalar>(
    ray: &Ray<E>,
    triangle: &Triangle<E>,
    mesh: &[Triangle<E>],
    culling: Culling,
) -> Option<Hit<E>> {
    let fixed = M::mesh_group(mesh).expect("random triangles suit every method");
    let pair = match fixed {
        Some(group) => PreparedPair::<M, E>::of_group(ray, triangle, group),
        None => PreparedPair::new(ray, triangle),
    };
    pair.test::<D>(Interval::of(ray), culling)
}

/// Something to do for each form of a method.
trait FormVisitor {
    fn visit<M: Method, D: Division>(&mut self);
}

/// Visits the forms that a method has, with the true division.
fn each_form<M: Method, const EARLY_OUT: bool>(visitor: &mut impl FormVisitor) {
    if const { M::INFO.forms.early() } {
        visitor.visit::<M, Early<TrueDivision, EARLY_OUT>>();
    }
    if const { M::INFO.forms.deferred() } {
        visitor.visit::<M, Deferred<TrueDivision, EARLY_OUT>>();
    }
}

/// Visits the one form that decides without quotients, where there is one.
fn one_form<M: Method>(visitor: &mut impl FormVisitor) {
    if const { M::INFO.forms.deferred() } {
        visitor.visit::<M, Deferred<TrueDivision, true>>();
    } else {
        visitor.visit::<M, Early<TrueDivision, true>>();
    }
}

struct AllWidths;

impl FormVisitor for AllWidths {
    fn visit<M: Method, D: Division>(&mut self) {
        check(2, &scene(), |pairs| {
            let mut visitor = SameBits::<M, D, ByRay> { pairs: &pairs, method: PhantomData };
            f32::visit_all(&mut visitor);
            f64::visit_all(&mut visitor);
            Ok(())
        });
    }
}

/// Every width on every instruction set has the bits of the scalar.
pub fn every_width_has_the_scalar_bits<M: Method>() {
    one_form::<M>(&mut AllWidths);
}

struct NativeWidths<A>(PhantomData<A>);

impl<A: Arrange> FormVisitor for NativeWidths<A> {
    fn visit<M: Method, D: Division>(&mut self) {
        check(2, &scene(), |pairs| {
            let mut visitor = SameBits::<M, D, A> { pairs: &pairs, method: PhantomData };
            f32::visit_native(&mut visitor);
            f64::visit_native(&mut visitor);
            Ok(())
        });
    }
}

/// The native widths have the bits of the scalar in every form, with early-out and without, and in
/// every arrangement.
pub fn every_division_has_the_scalar_bits<M: Method>() {
    each_form::<M, true>(&mut NativeWidths::<ByRay>(PhantomData));
    each_form::<M, false>(&mut NativeWidths::<ByRay>(PhantomData));
    one_form::<M>(&mut NativeWidths::<ByTriangle>(PhantomData));
    one_form::<M>(&mut NativeWidths::<ByOrigin>(PhantomData));
    one_form::<M>(&mut NativeWidths::<ByDirection>(PhantomData));
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
        let results = ByRay::run::<M, L, D>(token, &rays, &triangles, Culling::None);
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
    if const { M::INFO.forms.deferred() } {
        Claims.visit::<M, Deferred<Newton, true>>();
    } else {
        Claims.visit::<M, Early<Newton, true>>();
    }
    one_form::<M>(&mut Claims);
}

struct Claims;

impl FormVisitor for Claims {
    fn visit<M: Method, D: Division>(&mut self) {
        check(8, &prop::collection::vec(clear_hits(), 33), |pairs| {
            let mut visitor = WithinClaim::<M, D> { pairs: &pairs, method: PhantomData };
            f32::visit_native(&mut visitor);
            f64::visit_native(&mut visitor);
            Ok(())
        });
    }
}
