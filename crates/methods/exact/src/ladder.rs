//! What becomes of a pair that the filter leaves open: f64 with its own bound, then whole numbers.

use core::cmp::Ordering;

use trisect_core::{Hit, Lanes, Ray, Scalar, Triangle, Vec3};

use crate::compensated;
use crate::double::{self, Estimate};
use crate::outcome::Outcome;
use crate::whole::{self, Format, Volumes};

/// Limbs for all that is computed from numbers of f32: 1673 bits for the order of two `t`.
const SINGLE: usize = 27;

/// Limbs for the order of two `t` where coordinates have [`FEW_BITS`] between the largest and the unit that
/// all of them are multiples of: 491 bits.
const FEW: usize = 8;
const FEW_BITS: i32 = 60;

/// Limbs for all that is computed from numbers of f64: 12 600 bits for the order of two `t`.
const DOUBLE: usize = 198;

/// The precision of the numbers of a pair, which are carried in f64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Precision {
    Single,
    Double,
}

impl Precision {
    /// Of numbers that take so many bytes.
    pub(crate) const fn of_size(bytes: usize) -> Self {
        if bytes <= size_of::<f32>() { Self::Single } else { Self::Double }
    }
}

fn is_finite(ray: &Ray<f64>, triangle: &Triangle<f64>) -> bool {
    let finite = |v: Vec3<f64>| v.to_array().iter().all(|x| x.is_finite());
    finite(ray.o) && finite(ray.d) && triangle.corners().into_iter().all(finite)
}

/// What the ray does, exactly. `unit` is what [`Estimate::new`] takes.
pub(crate) fn outcome(
    precision: Precision,
    ray: &Ray<f64>,
    triangle: &Triangle<f64>,
    unit: f64,
) -> Outcome {
    // A ray without a direction is parallel to everything.
    if !is_finite(ray, triangle) || ray.d.to_array() == [0.0; 3] {
        return Outcome::Miss;
    }
    let estimate = Estimate::new(ray, triangle, unit).and_then(|estimate| estimate.outcome(ray));
    estimate.unwrap_or_else(|| whole_outcome(precision, ray, triangle))
}

#[cold]
#[inline(never)]
fn whole_outcome(precision: Precision, ray: &Ray<f64>, triangle: &Triangle<f64>) -> Outcome {
    match precision {
        Precision::Single => Volumes::<SINGLE>::new(ray, triangle).outcome(ray),
        Precision::Double => Volumes::<DOUBLE>::new(ray, triangle).outcome(ray),
    }
}

/// `t`, `beta` and `gamma` of the hits at the places of some bits, rounded once to the nearest number of the
/// precision; other places get anything. `pair` gives the pair at a place. `L` are lanes whose instructions are at hand.
#[allow(clippy::needless_range_loop, reason = "a loop over places is spread over lanes")]
#[inline(always)]
pub(crate) fn values<L: Lanes, X: Scalar, const N: usize>(
    pair: impl Fn(usize) -> (Ray<f64>, Triangle<f64>),
    mut hits: u64,
    unit: f64,
) -> Hit<[X; N]> {
    let precision = const { Precision::of_size(size_of::<X>()) };
    let zeros = [X::from_f64(0.0); N];
    let mut hit = Hit { t: zeros, beta: zeros, gamma: zeros };
    if precision == Precision::Single {
        let mut told = [0_u8; N];
        // All places, whatever is there: to bring hits together takes longer.
        for place in 0..N {
            let (ray, triangle) = pair(place);
            let ([t, beta, gamma], is_told) = double::singles_within(&ray, &triangle);
            hit.t[place] = X::from_f64(t);
            hit.beta[place] = X::from_f64(beta);
            hit.gamma[place] = X::from_f64(gamma);
            told[place] = u8::from(is_told);
        }
        let mut all = 0;
        for place in 0..N {
            all |= u64::from(told[place]) << place;
        }
        hits &= !all;
    }
    while hits != 0 {
        let place = hits.trailing_zeros() as usize % N;
        hits &= hits - 1;
        let (ray, triangle) = pair(place);
        let (mut values, mut is_told) = ([0.0; 3], false);
        if precision == Precision::Double {
            (values, is_told) = compensated::values::<L>(&ray, &triangle);
        }
        if !is_told {
            values = exact_values(precision, &ray, &triangle, unit);
        }
        let [t, beta, gamma] = values.map(X::from_f64);
        hit.t[place] = t;
        hit.beta[place] = beta;
        hit.gamma[place] = gamma;
    }
    hit
}

/// The values of a pair whose values take longer.
#[cold]
#[inline(never)]
fn exact_values(
    precision: Precision,
    ray: &Ray<f64>,
    triangle: &Triangle<f64>,
    unit: f64,
) -> [f64; 3] {
    match precision {
        Precision::Single => Estimate::new(ray, triangle, unit)
            .and_then(|estimate| estimate.singles())
            .unwrap_or_else(|| Volumes::<SINGLE>::new(ray, triangle).values(Format::F32)),
        Precision::Double => Volumes::<DOUBLE>::new(ray, triangle).values(Format::F64),
    }
}

/// Which of two triangles that a ray hits comes first along it. `unit` is what [`Estimate::new`] takes.
pub(crate) fn order(
    precision: Precision,
    ray: &Ray<f64>,
    [first, second]: [&Triangle<f64>; 2],
    unit: f64,
) -> Ordering {
    let estimates = [first, second].map(|triangle| Estimate::new(ray, triangle, unit));
    if let [Some(first), Some(second)] = &estimates
        && let Some(order) = first.order(second)
    {
        return order;
    }
    whole_order(precision, ray, first, second)
}

#[cold]
#[inline(never)]
fn whole_order(
    precision: Precision,
    ray: &Ray<f64>,
    first: &Triangle<f64>,
    second: &Triangle<f64>,
) -> Ordering {
    let (Triangle { a, b, c }, Triangle { a: d, b: e, c: f }) = (*first, *second);
    let is_near = whole::are_near(&[ray.o, a, b, c, d, e, f], FEW_BITS)
        && whole::are_near(&[ray.d], FEW_BITS);
    match precision {
        _ if is_near => order_of::<FEW>(ray, first, second),
        Precision::Single => order_of::<SINGLE>(ray, first, second),
        Precision::Double => order_of::<DOUBLE>(ray, first, second),
    }
}

fn order_of<const LIMBS: usize>(
    ray: &Ray<f64>,
    first: &Triangle<f64>,
    second: &Triangle<f64>,
) -> Ordering {
    let [first, second] = [first, second].map(|t| Volumes::<LIMBS>::new(ray, t));
    first.order(&second)
}

/// Whether a triangle that a ray hits owns the crossing; see [`ExactMethod::owns`](trisect_method::ExactMethod::owns).
/// `unit` is what [`Estimate::new`] takes.
pub(crate) fn owns(
    precision: Precision,
    ray: &Ray<f64>,
    triangle: &Triangle<f64>,
    unit: f64,
) -> bool {
    // What f64 is certain of is inside.
    let estimate = Estimate::new(ray, triangle, unit).and_then(|estimate| estimate.outcome(ray));
    estimate.is_some() || whole_owns(precision, ray, triangle)
}

#[cold]
#[inline(never)]
fn whole_owns(precision: Precision, ray: &Ray<f64>, triangle: &Triangle<f64>) -> bool {
    match precision {
        Precision::Single => Volumes::<SINGLE>::new(ray, triangle).owns(ray, triangle),
        Precision::Double => Volumes::<DOUBLE>::new(ray, triangle).owns(ray, triangle),
    }
}
