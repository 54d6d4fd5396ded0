//! Rays and triangles to hold a method to, the same on every run.

use std::ops::Range;

use proptest::prelude::*;
use proptest::test_runner::{Config, TestCaseError, TestRng, TestRunner};
use trisect_core::{Float, Ray, Triangle, Vec3};

pub(crate) type Outcome = Result<(), TestCaseError>;

/// Runs `test` on `cases` values of `strategy`; a failure is shrunk first.
pub(crate) fn check<S: Strategy>(cases: u32, strategy: &S, test: impl Fn(S::Value) -> Outcome) {
    let config = Config {
        cases,
        failure_persistence: None,
        // Structured pairs are parallel more often than not.
        max_global_rejects: 20 * cases + 1024,
        ..Config::default()
    };
    let rng = TestRng::deterministic_rng(config.rng_algorithm);
    if let Err(error) = TestRunner::new_with_rng(config, rng).run(strategy, test) {
        panic!("{error}");
    }
}

/// A ray and a triangle, in f64.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub(crate) ray: Ray<f64>,
    pub(crate) triangle: Triangle<f64>,
}

impl Pair {
    /// Rounded to the precision under test.
    pub(crate) fn round<E: Float>(&self) -> (Ray<E>, Triangle<E>) {
        let round = |v: Vec3<f64>| v.map(E::from_f64);
        let Triangle { a, b, c } = self.triangle;
        (self.ray.map(|&x| E::from_f64(x)), Triangle::new(round(a), round(b), round(c)))
    }
}

pub(crate) fn vector(range: Range<f64>) -> impl Strategy<Value = Vec3<f64>> {
    [range.clone(), range.clone(), range].prop_map(Vec3::from)
}

fn triangle() -> impl Strategy<Value = Triangle<f64>> {
    let corner = || vector(-1.0..1.0);
    (corner(), corner(), corner()).prop_map(|(a, b, c)| Triangle::new(a, b, c))
}

fn length(v: Vec3<f64>) -> f64 {
    v.dot(v).sqrt()
}

/// Rays and triangles anywhere in the unit cube: most of them miss.
pub(crate) fn any_pair() -> impl Strategy<Value = Pair> {
    (vector(-1.0..1.0), vector(-1.0..1.0), triangle())
        .prop_map(|(o, d, triangle)| Pair { ray: Ray::<f64>::new(o, d), triangle })
}

/// Pairs with structure: small whole coordinates, many of them zero or equal, and half of the rays
/// aimed at a point with whole eighths for weights, often an edge or a corner.
pub(crate) fn structured_pair() -> impl Strategy<Value = Pair> {
    let whole = || {
        let coordinate = || prop_oneof![2 => -2..=2_i8, 1 => Just(0_i8)].prop_map(f64::from);
        [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from)
    };
    let triangle = (whole(), whole(), whole()).prop_map(|(a, b, c)| Triangle::<f64>::new(a, b, c));
    let eighths = || (0..=8_i8).prop_map(|k| f64::from(k) / 8.0);
    (whole(), whole(), triangle, eighths(), eighths(), any::<bool>()).prop_map(
        |(o, d, triangle, beta, gamma, aimed)| {
            let Triangle { a, b, c } = triangle;
            let point = (b - a).mul_add(beta, (c - a).mul_add(gamma, a));
            let d = if aimed { point - o } else { d };
            Pair { ray: Ray::<f64>::new(o, d), triangle }
        },
    )
}

/// Well-conditioned pairs, on which the claims about errors hold: corners within the unit cube,
/// edges at `A` no shorter than a quarter and at an angle with a sine of a quarter or more, a
/// direction of length 1/2 to 2 whose angle with the plane has such a sine, and an origin 1/2 to 2
/// away from the plane's point with barycentrics drawn from `weights`.
pub(crate) fn well_conditioned(weights: Range<f64>) -> impl Strategy<Value = Pair> {
    let direction = (vector(-1.0..1.0), 0.5..2.0)
        .prop_filter("of some length", |(v, _)| (0.1..1.0).contains(&length(*v)))
        .prop_map(|(v, size): (Vec3<f64>, f64)| v.scale(size / length(v)));
    (triangle(), direction, weights.clone(), weights, 0.5..2.0, 0.25..4.0)
        .prop_filter(
            "well conditioned",
            |(triangle, d, ..): &(Triangle<f64>, Vec3<f64>, f64, f64, f64, f64)| {
                let (e1, e2) = (triangle.b - triangle.a, triangle.c - triangle.a);
                let n = e1.cross(e2);
                length(e1).min(length(e2)) >= 0.25
                    && length(n) >= 0.25 * length(e1) * length(e2)
                    && d.dot(n).abs() >= 0.25 * length(*d) * length(n)
            },
        )
        .prop_map(|(triangle, d, beta, gamma, distance, tmax)| {
            let Triangle { a, b, c } = triangle;
            let point = (b - a).mul_add(beta, (c - a).mul_add(gamma, a));
            let o = d.mul_add(-distance / length(d), point);
            Pair { ray: Ray { tmax, ..Ray::<f64>::new(o, d) }, triangle }
        })
}

/// Well-conditioned pairs that hit, far from every bound.
pub(crate) fn clear_hits() -> impl Strategy<Value = Pair> {
    well_conditioned(0.1..0.4)
        .prop_map(|pair| Pair { ray: Ray { tmax: f64::INFINITY, ..pair.ray }, ..pair })
}
