//! The second stage: one pair in f64, each number with a bound of its own error.

use core::cmp::Ordering;

use trisect_core::{Ray, Triangle, Vec3};

use crate::filter::{self, BoundedRay, SizedTriangle, Volumes};
use crate::outcome::Outcome;

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

    /// The lower end of the interval that the number is in, rounded to f32, and whether the upper one rounds
    /// to the same.
    #[allow(clippy::cast_possible_truncation, reason = "rounding to f32 is the point")]
    #[inline(always)]
    fn single(self) -> (f64, bool) {
        let (low, high) = ((self.value - self.error) as f32, (self.value + self.error) as f32);
        (f64::from(low), low.to_bits() == high.to_bits())
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
        let ([_, u, v, _], [p_det, p_u, p_v, _]) = (self.volumes, self.permanents);
        let (reciprocal, t) = self.reciprocal_and_t()?;
        let weight = |value: f64, permanent: f64| {
            let error = self.bounded(value, permanent + p_det).error + UNDERFLOW;
            quotient(Bounded { value, error }, reciprocal, 1.0)
        };
        let (singles, is_told) = singles([t, weight(u, p_u), weight(v, p_v)]);
        is_told.then_some(singles)
    }

    /// Which of two hits of a ray comes first along it, where f64 can tell.
    pub(crate) fn order(&self, other: &Self) -> Option<Ordering> {
        let (_, this) = self.reciprocal_and_t()?;
        let (_, other) = other.reciprocal_and_t()?;
        if this.value + this.error < other.value - other.error {
            return Some(Ordering::Less);
        }
        (this.value - this.error > other.value + other.error).then_some(Ordering::Greater)
    }

    /// `1/det` and `t`, where `det` is far enough from zero.
    fn reciprocal_and_t(&self) -> Option<(f64, Bounded)> {
        let ([det, _, _, t], [p_det, _, _, p_t]) = (self.volumes, self.permanents);
        let det = self.bounded(det, p_det);
        let reciprocal = 1.0 / det.value;
        let size = (t * reciprocal).abs();
        // Not |t| of the hit but that of the quotient: twice the error pays for the difference.
        let error = 2.0 * (self.bounded(t, p_t).error + size * det.error);
        let t = quotient(Bounded { value: t, error }, reciprocal, size);
        (det.value.abs() > 2.0 * det.error).then_some((reciprocal, t))
    }
}

/// A numerator over `det`, whose reciprocal is given. The error of the numerator is also that of `det`, times the
/// quotient: `|x − X'/Y'| = |X' − x·Y'|/|Y'| ≤ (|ΔX| + |x|·|ΔY|)/|Y'|`. The rest is for the
/// roundings of this, and of the ends of the interval; `size` is at least that of the quotient, or 1.
#[inline(always)]
fn quotient(numerator: Bounded, reciprocal: f64, size: f64) -> Bounded {
    let value = numerator.value * reciprocal;
    let rounding = size * (4.0 * f64::EPSILON) + f64::MIN_POSITIVE;
    let error = numerator.error * ((1.0 + 1e-9) * reciprocal.abs()) + rounding;
    Bounded { value, error }
}

/// Each rounded once to f32, and whether that is certain.
#[inline(always)]
fn singles([t, beta, gamma]: [Bounded; 3]) -> ([f64; 3], bool) {
    let (t, is_t_told) = t.single();
    let (beta, is_beta_told) = beta.single();
    let (gamma, is_gamma_told) = gamma.single();
    ([t, beta, gamma], is_t_told & is_beta_told & is_gamma_told)
}

/// `t`, `beta` and `gamma` of a hit in numbers of f32, rounded once, and whether the filter's bounds, in f64,
/// can tell them: they cost less than the permanents. Without branches, so that a loop over pairs can be
/// spread over lanes.
#[inline(always)]
pub(crate) fn singles_within(ray: &Ray<f64>, triangle: &Triangle<f64>) -> ([f64; 3], bool) {
    let ray = BoundedRay::new(ray.o, ray.d, 1.0);
    let triangle = &SizedTriangle::new(triangle);
    let volumes = Volumes::new(&ray, triangle, triangle.normal());
    let Volumes { det, u, v, t, .. } = volumes;
    let (bound, of_t) =
        (filter::bound(&ray, triangle, &volumes), filter::bound_of_hit(triangle, &volumes, 1.0));
    let reciprocal = 1.0 / det;
    let weight = |value| quotient(Bounded { value, error: 2.0 * bound }, reciprocal, 1.0);
    let size = (t * reciprocal).abs();
    let t = quotient(Bounded { value: t, error: of_t }, reciprocal, size);
    let (singles, is_told) = singles([t, weight(u), weight(v)]);
    let is_bounded = bound < filter::NO_BOUND;
    let is_large = det.abs() > 2.0 * bound;
    (singles, is_told & is_bounded & is_large)
}
