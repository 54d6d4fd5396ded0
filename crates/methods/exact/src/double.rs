//! The second stage: one pair in f64, each number with a bound of its own error.

use trisect_core::{Ray, Triangle, Vec3};

use crate::filter::{self, BoundedRay, SizedTriangle, Volumes};
use crate::ladder::Outcome;

/// Coordinates, differences and ends of the interval up to this keep all products in range.
const LARGEST: f64 = f64::from_bits((1023 + 130) << 52);

/// What underflow takes, at most: far below the smallest volume of numbers of f32.
const UNDERFLOW: f64 = f64::from_bits((1023 - 620) << 52);

/// Ten unit roundoffs: nine that are proved, and one for what the bound itself loses.
pub(crate) const UNIT: f64 = 10.0 * (f64::EPSILON / 2.0);

/// A number and how far it is off, at most.
#[derive(Clone, Copy)]
struct Bounded {
    value: f64,
    error: f64,
}

impl Bounded {
    /// The sign that is certain, or zero.
    fn sign(self) -> i8 {
        i8::from(self.value > self.error) - i8::from(self.value < -self.error)
    }

    /// The interval that the number is in, rounded to f32; `None` where that is more than one number.
    #[allow(clippy::cast_possible_truncation, reason = "rounding to f32 is the point")]
    fn single(self) -> Option<f64> {
        let [low, high] = [self.value - self.error, self.value + self.error].map(|x| x as f32);
        (low.to_bits() == high.to_bits()).then(|| f64::from(low))
    }
}

/// The volumes of a pair, and their permanents: the same sums over magnitudes.
pub(crate) struct Estimate {
    volumes: [f64; 4],
    permanents: [f64; 4],
    unit: f64,
}

fn permanent_cross(a: Vec3<f64>, b: Vec3<f64>) -> Vec3<f64> {
    Vec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)
}

/// `det`, `U`, `V`, `T`
#[inline(always)]
fn volumes(
    [s, d, e1, e2]: [Vec3<f64>; 4],
    cross: impl Fn(Vec3<f64>, Vec3<f64>) -> Vec3<f64>,
) -> [f64; 4] {
    let (p, q) = (cross(d, e2), cross(s, e1));
    [e1.dot(p), s.dot(p), d.dot(q), e2.dot(q)]
}

impl Estimate {
    /// `None` where the pair is out of range. `unit` is [`UNIT`], or less for a test that wants to
    /// see errors.
    pub(crate) fn new(ray: &Ray<f64>, triangle: &Triangle<f64>, unit: f64) -> Option<Self> {
        let Triangle { a, b, c } = *triangle;
        let vectors = [ray.o - a, ray.d, b - a, c - a];
        let magnitudes = vectors.map(|v| v.map(f64::abs));
        let is_in_range = magnitudes.iter().all(|v| v.to_array().iter().all(|&x| x <= LARGEST));
        is_in_range.then(|| Self {
            volumes: volumes(vectors, Vec3::cross),
            permanents: volumes(magnitudes, permanent_cross),
            unit,
        })
    }

    fn bounded(&self, value: f64, permanent: f64) -> Bounded {
        Bounded { value, error: self.unit * permanent + UNDERFLOW }
    }

    /// What the ray does, where that is certain.
    pub(crate) fn outcome(&self, ray: &Ray<f64>) -> Option<Outcome> {
        let ([det, u, v, t], [p_det, p_u, p_v, p_t]) = (self.volumes, self.permanents);
        let signs = [
            self.bounded(u, p_u).sign(),
            self.bounded(v, p_v).sign(),
            self.bounded((det - u) - v, p_det + p_u + p_v).sign(),
        ];
        if signs.contains(&1) && signs.contains(&-1) {
            return Some(Outcome::Miss);
        }
        if signs[0] == 0 || signs != [signs[0]; 3] {
            return None;
        }
        // All volumes have one sign, so that `det`, their sum, has it too.
        let sign = f64::from(signs[0]);
        let (det, t) = (det * sign, t * sign);
        let after = |tau: f64| self.bounded(t - tau * det, p_t + tau.abs() * p_det).sign();
        // An end that is out of range is brought into it: what is within is within still.
        let (tmin, tmax) = (ray.tmin, ray.tmax);
        let (from, to) = (after(tmin.max(-LARGEST)), after(tmax.min(LARGEST)));
        if tmin.is_nan() || tmax.is_nan() || tmin > LARGEST || tmax < -LARGEST {
            return None;
        }
        if from < 0 && tmin >= -LARGEST || to > 0 && tmax <= LARGEST {
            return Some(Outcome::Miss);
        }
        (from > 0 && to < 0).then_some(if sign > 0.0 { Outcome::Front } else { Outcome::Back })
    }

    /// `t`, `beta` and `gamma`, rounded once to f32, where f64 can tell.
    pub(crate) fn singles(&self) -> Option<[f64; 3]> {
        let ([det, u, v, t], [p_det, p_u, p_v, p_t]) = (self.volumes, self.permanents);
        let det = self.bounded(det, p_det);
        quotients(det, [self.bounded(t, p_t), self.bounded(u, p_u), self.bounded(v, p_v)])
    }
}

/// The numerators over `det`, each rounded once to f32, where that is certain.
fn quotients(det: Bounded, numerators: [Bounded; 3]) -> Option<[f64; 3]> {
    let size = det.value.abs();
    if size <= 2.0 * det.error {
        return None;
    }
    let reciprocal = 1.0 / det.value;
    // At least 1/|y|, but for two roundings: the exact denominator is no smaller than |y'| − |Δy|.
    let largest = 1.0 / (size - det.error);
    let quotient = |x: Bounded| {
        let value = x.value * reciprocal;
        // |x/y − x'/y'| ≤ (|Δx| + |x'/y'|·|Δy|) / |y|; the rest is for the roundings of this line, of
        // the quotient and of the ends of the interval.
        let error = (x.error + value.abs() * det.error) * largest;
        let error = error * (1.0 + 1e-9) + value.abs() * (4.0 * f64::EPSILON);
        Bounded { value, error }.single()
    };
    let [t, beta, gamma] = numerators;
    Some([quotient(t)?, quotient(beta)?, quotient(gamma)?])
}

/// `t`, `beta` and `gamma` of a pair of f32, rounded once, where the filter's bounds can tell, in f64: they
/// cost less than the permanents.
pub(crate) fn singles_within(ray: &Ray<f64>, triangle: &Triangle<f64>) -> Option<[f64; 3]> {
    let ray = BoundedRay::new(ray.o, ray.d, 1.0);
    let triangle = SizedTriangle::new(triangle);
    let volumes = Volumes::new(&ray, &triangle);
    let error = filter::bound(&ray, &triangle, &volumes);
    if error >= filter::NO_BOUND {
        return None;
    }
    let bounded = |value| Bounded { value, error };
    let t = Bounded { value: volumes.t(), error: filter::bound_of_t(&triangle, &volumes, 1.0) };
    quotients(bounded(volumes.det), [t, bounded(volumes.u), bounded(volumes.v)])
}
