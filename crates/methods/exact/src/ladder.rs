//! What becomes of a pair that the filter leaves open: f64 with its own bound, then whole numbers.

use core::cmp::Ordering;

use trisect_core::{Ray, Triangle, Vec3};

use crate::double::{self, Estimate};
use crate::whole::{self, Format, Volumes};

/// Limbs for all that is computed from numbers of f32: 1673 bits for the order of two `t`.
const SINGLE: usize = 27;

/// Limbs for all that is computed from numbers of f64: 12 600 bits for the order of two `t`.
const DOUBLE: usize = 198;

/// What a ray does to a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// It misses.
    Miss,
    /// It hits the front: `det > 0`.
    Front,
    /// It hits the back: `det < 0`.
    Back,
}

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
    if !is_finite(ray, triangle) {
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

/// `t`, `beta` and `gamma` of a hit, each rounded once to the nearest number of the precision.
pub(crate) fn values(
    precision: Precision,
    ray: &Ray<f64>,
    triangle: &Triangle<f64>,
    unit: f64,
) -> [f64; 3] {
    let singles = match precision {
        Precision::Single => double::singles_within(ray, triangle)
            .or_else(|| Estimate::new(ray, triangle, unit).and_then(|e| e.singles())),
        // Its last bit cannot be told in the same precision.
        Precision::Double => None,
    };
    singles.unwrap_or_else(|| whole_values(precision, ray, triangle))
}

#[cold]
#[inline(never)]
fn whole_values(precision: Precision, ray: &Ray<f64>, triangle: &Triangle<f64>) -> [f64; 3] {
    match precision {
        Precision::Single => Volumes::<SINGLE>::new(ray, triangle).values(Format::F32),
        Precision::Double => Volumes::<DOUBLE>::new(ray, triangle).values(Format::F64),
    }
}

/// Which of two triangles that a ray hits comes first along it.
pub(crate) fn order(
    precision: Precision,
    ray: &Ray<f64>,
    first: &Triangle<f64>,
    second: &Triangle<f64>,
) -> Ordering {
    match precision {
        Precision::Single => {
            let [first, second] = [first, second].map(|t| Volumes::<SINGLE>::new(ray, t));
            first.order(&second)
        }
        Precision::Double => {
            let [first, second] = [first, second].map(|t| Volumes::<DOUBLE>::new(ray, t));
            first.order(&second)
        }
    }
}

/// Which way the path over three points of a plane turns; see [`whole::turn`].
pub(crate) fn turn(precision: Precision, points: [[f64; 2]; 3]) -> Ordering {
    match precision {
        Precision::Single => whole::turn::<SINGLE>(points),
        Precision::Double => whole::turn::<DOUBLE>(points),
    }
}

/// The sign of `t` where a line that is not parallel to a plane meets it.
pub(crate) fn sign_of_t(
    precision: Precision,
    ray: &Ray<f64>,
    triangle: &Triangle<f64>,
) -> Ordering {
    match precision {
        Precision::Single => Volumes::<SINGLE>::new(ray, triangle).sign_of_t(),
        Precision::Double => Volumes::<DOUBLE>::new(ray, triangle).sign_of_t(),
    }
}
