//! What holds for one ray and one triangle, whatever the method.

use core::fmt::Debug;

use proptest::prelude::*;
use trisect_core::{Float, Hit, Ray, Scalar, Triangle, Vec3};
use trisect_method::{Culling, Output};
use trisect_oracle::Exact;

use crate::draw::{
    Outcome, Pair, any_pair, check, clear_hits, structured_pair, vector, well_conditioned,
};
use crate::subject::{ExactAnswer, Subject, Tests};
use crate::truth::Truth;

/// Terms of second order in the unit roundoff, which the bounds leave out: below this share for
/// condition numbers up to 10⁴ in f32.
const SECOND_ORDER: f64 = 1.0 + 1.0 / 256.0;

pub(crate) fn is_finite<E: Scalar>(hit: &Hit<E>) -> bool {
    [hit.t, hit.beta, hit.gamma].iter().all(|x| x.to_f64().is_finite())
}

/// Fails unless `hit` is within the claim of `M`, `times` over, plus `more` units.
pub(crate) fn within_claim<E: Float>(
    subject: &Subject,
    truth: &Truth,
    hit: &Hit<E>,
    more: f64,
    form: impl Debug,
) -> Outcome {
    let bound = (subject.info.error_factor + more) * SECOND_ORDER;
    let given = if subject.weighs() { 3 } else { 1 };
    for (name, error) in truth.errors(hit, E::UNIT_ROUNDOFF).into_iter().take(given) {
        prop_assert!(
            error <= bound,
            "{form:?}, {}: the error of {name} is {error:.1} condition numbers times the unit \
             roundoff, and {bound:.1} is claimed",
            E::FORMAT
        );
    }
    Ok(())
}

/// The formula over exact rationals, preparation included, gives the exact values in each form that
/// the method has, decides as the oracle does, and has the right side in front: on random pairs, and
/// on pairs with structure, where coordinates are equal, zero, or on an edge.
///
/// Methods that give no weights are compared by `t` and their decision; the sum of angles, which has
/// a tolerance, only where the point is farther than that from the edges.
pub fn formula_is_exact(subject: &Subject) {
    check(1000, &any_pair(), |pair| exact_formula(subject, &pair));
    check(1000, &structured_pair(), |pair| exact_formula(subject, &pair));
}

/// Weights nearer to 0 or 1 than this are left to the tolerance of a method that has one.
const NEAR_AN_EDGE: f64 = 1e-9;

fn exact_formula(subject: &Subject, pair: &Pair) -> Outcome {
    let (ray, triangle) = pair.round::<f32>();
    let Some(truth) = Truth::of(&ray, &triangle) else {
        return Err(TestCaseError::reject("parallel"));
    };
    Exact::scope(|| {
        let zero = Exact::from_f64(0.0);
        // The formula does not see the interval, and infinity is no rational.
        let ray = Ray { tmin: 0.0, tmax: 1.0, ..ray }.map(|&x| number(x));
        let triangle = triangle.map(|&x| number(x));
        let front = ray.d.dot(triangle.normal()) < zero;
        for ExactAnswer { form, hit, inside, facing } in (subject.exact)(&ray, &triangle) {
            prop_assert_eq!(hit.t.to_rational(), truth.t.exact.clone(), "{}", form);
            if subject.weighs() {
                prop_assert_eq!(hit.beta.to_rational(), truth.beta.exact.clone(), "{}", form);
                prop_assert_eq!(hit.gamma.to_rational(), truth.gamma.exact.clone(), "{}", form);
            }
            if subject.weighs() || truth.clearance() > NEAR_AN_EDGE {
                prop_assert_eq!(inside, truth.is_inside(), "{}", form);
            }
            prop_assert_eq!(facing > zero, front, "facing, {}", form);
            prop_assert_eq!(facing < zero, !front, "facing, {}", form);
        }
        Ok(())
    })
}

fn number(x: f32) -> Exact {
    Exact::from_f64(f64::from(x))
}

/// The normal, where a method gives one, is `(B − A) × (C − A)`.
pub fn normals_are_normal(subject: &Subject) {
    if !subject.info.gives(Output::Normal) {
        return;
    }
    check(500, &any_pair(), |pair| {
        let (ray, triangle) = pair.round::<f32>();
        Exact::scope(|| {
            let ray = Ray { tmin: 0.0, tmax: 1.0, ..ray }.map(|&x| number(x));
            let triangle = triangle.map(|&x| number(x));
            if triangle.is_degenerate() {
                return Ok(());
            }
            let normal = (subject.normal)(&ray, &triangle);
            prop_assert_eq!(normal, Some(triangle.normal()));
            Ok(())
        })
    });
}

/// On well-conditioned pairs `t`, `beta` and `gamma` are within the claim, and decisions are right
/// wherever they are clear of their bounds by as much.
pub fn errors_are_within_the_claim(subject: &Subject) {
    fn of<E: Tests>(subject: &Subject) {
        check(2000, &well_conditioned(-0.5..1.5), |pair| {
            let (ray, triangle) = pair.round::<E>();
            let truth = Truth::of(&ray, &triangle).expect("well conditioned");
            let certain =
                truth.margin(&ray, E::UNIT_ROUNDOFF) > subject.info.error_factor * SECOND_ORDER;
            for &(form, test) in E::tests(subject) {
                let hit = test(&ray, &triangle, Culling::None);
                if certain {
                    prop_assert_eq!(hit.is_some(), truth.hits, "{}", form);
                }
                if let Some(hit) = hit {
                    within_claim(subject, &truth, &hit, 0.0, form)?;
                }
            }
            Ok(())
        });
    }
    of::<f32>(subject);
    of::<f64>(subject);
}

/// The same triangle from another corner, or wound the other way round, meets the ray in the same
/// point: `beta` and `gamma` move with their corners, each result within the claim of the truth.
pub fn corners_may_be_renamed(subject: &Subject) {
    fn of<E: Tests>(subject: &Subject) {
        check(500, &clear_hits(), |pair| {
            let (ray, triangle) = pair.round::<E>();
            let Triangle { a, b, c } = triangle;
            let truth = Truth::of(&ray, &triangle).expect("well conditioned");
            let alpha = |hit: &Hit<E>| E::from_f64(1.0) - hit.beta - hit.gamma;
            // `1 − beta − gamma` has the errors of both, and rounds twice.
            let spread = truth.beta.kappa + truth.gamma.kappa;
            for &(form, test) in E::tests(subject) {
                let same = |corners: [Vec3<E>; 3], back: fn(E, &Hit<E>) -> [E; 2]| {
                    let [a, b, c] = corners;
                    let renamed = Triangle { a, b, c };
                    let hit = test(&ray, &renamed, Culling::None);
                    let hit = hit.ok_or_else(|| TestCaseError::fail("renamed corners miss"))?;
                    let other = Truth::of(&ray, &renamed).expect("well conditioned");
                    let [beta, gamma] = back(alpha(&hit), &hit);
                    let kappa = spread + other.beta.kappa + other.gamma.kappa;
                    let unit = (subject.info.error_factor + 1.0) * E::UNIT_ROUNDOFF * SECOND_ORDER;
                    prop_assert!(truth.t.error(hit.t.to_f64()) <= unit * other.t.kappa);
                    if !subject.weighs() {
                        return Ok(());
                    }
                    for (value, found) in [(&truth.beta, beta), (&truth.gamma, gamma)] {
                        let error = value.error(found.to_f64());
                        prop_assert!(error <= unit * kappa, "{form}: {error:e}");
                    }
                    Ok(())
                };
                same([a, c, b], |_, hit| [hit.gamma, hit.beta])?;
                same([b, c, a], |alpha, hit| [alpha, hit.beta])?;
                same([c, a, b], |alpha, hit| [hit.gamma, alpha])?;
            }
            Ok(())
        });
    }
    of::<f32>(subject);
    of::<f64>(subject);
}

/// Moving ray and triangle together by a vector with whole quarters up to 1, with coordinates on a
/// grid of 2⁻¹² so that nothing rounds, leaves results within the claim of the one truth.
pub fn translation_changes_no_more_than_claimed(subject: &Subject) {
    fn of<E: Tests>(subject: &Subject) {
        let offset = [-4..=4_i8, -4..=4, -4..=4];
        check(500, &(clear_hits(), offset), |(pair, offset)| {
            let grid = |v: Vec3<f64>| v.map(|x| (x * 4096.0).round() / 4096.0);
            let offset = Vec3::from(offset.map(|k| f64::from(k) / 4.0));
            let moved = |by: Vec3<f64>| {
                let Triangle { a, b, c } = pair.triangle;
                let triangle = Triangle::new(grid(a) + by, grid(b) + by, grid(c) + by);
                let ray = Ray { o: grid(pair.ray.o) + by, d: grid(pair.ray.d), ..pair.ray };
                Pair { ray, triangle }.round::<E>()
            };
            let (ray, triangle) = moved(Vec3::new(0.0, 0.0, 0.0));
            let truth = Truth::of(&ray, &triangle).expect("well conditioned");
            for &(form, test) in E::tests(subject) {
                let (ray, triangle) = moved(offset);
                let hit = test(&ray, &triangle, Culling::None);
                let hit = hit.ok_or_else(|| TestCaseError::fail("the moved pair misses"))?;
                within_claim(subject, &truth, &hit, 0.0, form)?;
            }
            Ok(())
        });
    }
    of::<f32>(subject);
    of::<f64>(subject);
}

/// Scaling the scene by a power of two scales `t` and leaves `beta` and `gamma`, to the bit;
/// scaling the direction divides `t`.
pub fn powers_of_two_scale_exactly(subject: &Subject) {
    fn of<E: Tests>(subject: &Subject) {
        // Within these no product under- or overflows, down to e⁴ in f32.
        let power = || -12..=12_i8;
        check(500, &(well_conditioned(-0.5..1.5), power(), power()), |(pair, scene, speed)| {
            let (ray, triangle) = pair.round::<E>();
            let [scene, speed] = [scene, speed].map(|k| E::from_f64(f64::from(k).exp2()));
            let Triangle { a, b, c } = triangle;
            let scaled = Triangle::new(a.scale(scene), b.scale(scene), c.scale(scene));
            let of_t = |t: E| t * scene / speed;
            let scaled_ray = Ray {
                o: ray.o.scale(scene),
                d: ray.d.scale(speed),
                tmin: of_t(ray.tmin),
                tmax: of_t(ray.tmax),
            };
            for &(form, test) in E::tests(subject) {
                let hit = test(&ray, &triangle, Culling::None);
                let wanted = hit.map(|hit| Hit { t: of_t(hit.t), ..hit });
                prop_assert_eq!(test(&scaled_ray, &scaled, Culling::None), wanted, "{}", form);
            }
            Ok(())
        });
    }
    of::<f32>(subject);
    of::<f64>(subject);
}

/// Culling hides one side and leaves the other to the bit; the corners' order says which.
pub fn culling_hides_one_side(subject: &Subject) {
    check(500, &clear_hits(), |pair| {
        let (ray, triangle) = pair.round::<f32>();
        let Triangle { a, b, c } = triangle;
        let swapped = Triangle { a, b: c, c: b };
        // The pair is clear of grazing, so that f64 has the sign.
        let front = {
            let Triangle { a, b, c } = pair.triangle;
            pair.ray.d.dot((b - a).cross(c - a)) < 0.0
        };
        for &(form, test) in f32::tests(subject) {
            for (triangle, front) in [(triangle, front), (swapped, !front)] {
                let [seen, hidden] = if front {
                    [Culling::Back, Culling::Front]
                } else {
                    [Culling::Front, Culling::Back]
                };
                let plain = test(&ray, &triangle, Culling::None);
                prop_assert!(plain.is_some(), "{form}");
                prop_assert_eq!(test(&ray, &triangle, seen), plain, "{}", form);
                prop_assert_eq!(test(&ray, &triangle, hidden), None, "{}", form);
            }
        }
        Ok(())
    });
}

/// The pair with one of its 15 coordinates replaced.
fn with_coordinate(
    pair: (Ray<f32>, Triangle<f32>),
    place: usize,
    x: f32,
) -> (Ray<f32>, Triangle<f32>) {
    let (mut ray, mut triangle) = pair;
    let Triangle { a, b, c } = &mut triangle;
    let vectors = [&mut ray.o, &mut ray.d, a, b, c];
    for (at, vector) in vectors.into_iter().enumerate() {
        for (axis, coordinate) in
            [&mut vector.x, &mut vector.y, &mut vector.z].into_iter().enumerate()
        {
            if 3 * at + axis == place {
                *coordinate = x;
            }
        }
    }
    (ray, triangle)
}

/// A NaN in any coordinate or end of the interval is a miss; an infinity is never handed on.
pub fn nan_and_infinity_never_come_out(subject: &Subject) {
    check(200, &clear_hits(), |pair| {
        let pair = pair.round::<f32>();
        for &(form, test) in f32::tests(subject) {
            for culling in [Culling::None, Culling::Back, Culling::Front] {
                for place in 0..15 {
                    let (ray, triangle) = with_coordinate(pair, place, f32::NAN);
                    prop_assert_eq!(test(&ray, &triangle, culling), None, "{}", form);
                    for infinity in [f32::INFINITY, f32::NEG_INFINITY] {
                        let (ray, triangle) = with_coordinate(pair, place, infinity);
                        let hit = test(&ray, &triangle, culling);
                        prop_assert!(hit.as_ref().is_none_or(is_finite), "{form} {hit:?}");
                    }
                }
                let (ray, triangle) = pair;
                for ray in [Ray { tmin: f32::NAN, ..ray }, Ray { tmax: f32::NAN, ..ray }] {
                    prop_assert_eq!(test(&ray, &triangle, culling), None, "{}", form);
                }
            }
        }
        Ok(())
    });
}

/// Triangles with two or three equal corners are never hit, not even by rays aimed at them; rays
/// without a direction never hit.
pub fn degenerate_input_never_hits(subject: &Subject) {
    fn of<E: Tests>(subject: &Subject) {
        let place = vector(-1.0..1.0);
        check(500, &(clear_hits(), 0.0..1.0, place), |(pair, weight, o)| {
            let Triangle { a, b, c } = pair.triangle;
            let zero = Vec3::new(0.0, 0.0, 0.0);
            for degenerate in [[a, a, c], [a, b, a], [a, b, b], [a, a, a]] {
                let [p, q, r] = degenerate;
                // From `o` to a point of the segment that is left of the triangle.
                let other = if p == q { r } else { q };
                let d = (other - p).mul_add(weight, p) - o;
                let ray = Ray { o, d, tmin: f64::NEG_INFINITY, tmax: f64::INFINITY };
                let triangle = Triangle::new(p, q, r);
                let (ray, triangle) = Pair { ray, triangle }.round::<E>();
                for &(form, test) in E::tests(subject) {
                    prop_assert_eq!(test(&ray, &triangle, Culling::None), None, "{}", form);
                }
            }
            for o in [o, a] {
                let still = Pair { ray: Ray::<f64>::new(o, zero), ..pair };
                let (ray, triangle) = still.round::<E>();
                for &(form, test) in E::tests(subject) {
                    prop_assert_eq!(test(&ray, &triangle, Culling::None), None, "{}", form);
                }
            }
            Ok(())
        });
    }
    of::<f32>(subject);
    of::<f64>(subject);
}

/// The interval is closed: a `t` that is exact hits at both of its ends and misses one ULP beyond;
/// an end that no `t` reaches misses.
pub fn the_interval_is_closed(subject: &Subject) {
    fn of<E: Tests>(subject: &Subject) {
        let n = E::from_f64;
        let vector = |x, y, z| Vec3::new(n(x), n(y), n(z));
        let triangle =
            Triangle::new(vector(0.0, 0.0, 4.0), vector(4.0, 0.0, 4.0), vector(0.0, 4.0, 4.0));
        let ulp = 8.0 * E::UNIT_ROUNDOFF;
        let infinity = f64::INFINITY;
        for (tmin, tmax, hits) in [
            (4.0, 4.0, true),
            (4.0, infinity, true),
            (-infinity, 4.0, true),
            (4.0 - ulp / 2.0, 4.0 + ulp, true),
            (4.0 + ulp, infinity, false),
            (0.0, 4.0 - ulp / 2.0, false),
            (8.0, 0.0, false),
            (infinity, 0.0, false),
            (infinity, infinity, false),
            (-infinity, -infinity, false),
        ] {
            let ray = Ray {
                o: vector(1.0, 1.0, 0.0),
                d: vector(0.0, 0.0, 1.0),
                tmin: n(tmin),
                tmax: n(tmax),
            };
            for &(form, test) in E::tests(subject) {
                let hit = Hit { t: n(4.0), beta: n(0.25), gamma: n(0.25) };
                let wanted = hits.then_some(subject.given(hit));
                let found = test(&ray, &triangle, Culling::None);
                assert_eq!(found, wanted, "{form} {}, [{tmin}, {tmax}]", E::FORMAT);
            }
        }
    }
    of::<f32>(subject);
    of::<f64>(subject);
}

/// Numbers that hurt: any bits, and powers of two over the whole range of exponents.
fn any_bits() -> impl Strategy<Value = f32> {
    let power = (any::<bool>(), -149..=127_i16)
        .prop_map(|(minus, k)| f32::from(k).exp2() * if minus { -1.0 } else { 1.0 });
    prop_oneof![
        any::<u32>().prop_map(f32::from_bits),
        power,
        Just(0.0_f32),
        Just(-0.0_f32),
        Just(1.0_f32),
        Just(f32::NEG_INFINITY),
    ]
}

/// Whatever the bits of ray and triangle, nothing panics and no hit holds a NaN or an infinity.
pub fn any_bits_are_survived(subject: &Subject) {
    let vector = || [any_bits(), any_bits(), any_bits()].prop_map(Vec3::from);
    let ray = (vector(), vector(), any_bits(), any_bits());
    let hurt = (ray, vector(), vector(), vector(), any::<bool>());
    check(20_000, &hurt, |((o, d, tmin, tmax), a, b, c, aimed)| {
        // Aimed at a corner, the ray has a chance.
        let d = if aimed { a - o } else { d };
        let (ray, triangle) = (Ray { o, d, tmin, tmax }, Triangle { a, b, c });
        let open = Ray { tmin: f32::NEG_INFINITY, tmax: f32::INFINITY, ..ray };
        for &(form, test) in f32::tests(subject) {
            for ray in [ray, open] {
                let hit = test(&ray, &triangle, Culling::None);
                prop_assert!(hit.as_ref().is_none_or(is_finite), "{form} {ray:?} {hit:?}");
            }
        }
        Ok(())
    });
}
