//! The last stage: everything as whole numbers, where nothing rounds.

use core::cmp::Ordering;

use trisect_core::{Ray, Triangle, Vec3, decode};

use crate::integer::Integer;
use crate::outcome::Outcome;

/// The largest power of two that divides all of some numbers: of 1 where all are zero.
fn unit(vectors: &[Vec3<f64>]) -> i32 {
    let numbers = vectors.iter().flat_map(|v| v.to_array());
    numbers.filter(|x| *x != 0.0).map(|x| decode(x).1).min().unwrap_or(0)
}

/// Whether the coordinates of points are less than `2^bits` in multiples of the largest power of two that
/// divides all of them.
pub(crate) fn are_near(points: &[Vec3<f64>], bits: i32) -> bool {
    let largest = power_of_two(bits) * power_of_two(unit(points));
    points.iter().flat_map(|v| v.to_array()).all(|x| x.abs() < largest)
}

/// A vector in multiples of `2^unit`, which divides its coordinates.
fn multiples<const LIMBS: usize>(v: Vec3<f64>, unit: i32) -> Vec3<Integer<LIMBS>> {
    v.map(|x| {
        let (mantissa, exponent) = decode(x);
        if mantissa == 0 {
            return Integer::ZERO;
        }
        Integer::new(mantissa, (exponent - unit).unsigned_abs() as usize)
    })
}

fn difference<const LIMBS: usize>(
    a: &Vec3<Integer<LIMBS>>,
    b: &Vec3<Integer<LIMBS>>,
) -> Vec3<Integer<LIMBS>> {
    Vec3::new(a.x.minus(&b.x), a.y.minus(&b.y), a.z.minus(&b.z))
}

fn cross<const LIMBS: usize>(
    a: &Vec3<Integer<LIMBS>>,
    b: &Vec3<Integer<LIMBS>>,
) -> Vec3<Integer<LIMBS>> {
    Vec3::new(
        a.y.times(&b.z).minus(&a.z.times(&b.y)),
        a.z.times(&b.x).minus(&a.x.times(&b.z)),
        a.x.times(&b.y).minus(&a.y.times(&b.x)),
    )
}

fn dot<const LIMBS: usize>(a: &Vec3<Integer<LIMBS>>, b: &Vec3<Integer<LIMBS>>) -> Integer<LIMBS> {
    a.x.times(&b.x).plus(&a.y.times(&b.y)).plus(&a.z.times(&b.z))
}

/// The volumes of a finite ray and a finite triangle, with their signs turned so that `det ≥ 0`:
/// `beta = u/det`, `gamma = v/det`, `t = t/det · 2^exponent`.
pub(crate) struct Volumes<const LIMBS: usize> {
    det: Integer<LIMBS>,
    /// Whether `det` was negative.
    turned: bool,
    u: Integer<LIMBS>,
    v: Integer<LIMBS>,
    t: Integer<LIMBS>,
    exponent: i32,
}

impl<const LIMBS: usize> Volumes<LIMBS> {
    pub(crate) fn new(ray: &Ray<f64>, triangle: &Triangle<f64>) -> Self {
        let Triangle { a, b, c } = *triangle;
        let (place, speed) = (unit(&[ray.o, a, b, c]), unit(&[ray.d]));
        let [o, a, b, c] = [ray.o, a, b, c].map(|point| multiples::<LIMBS>(point, place));
        let d = multiples(ray.d, speed);
        let (s, e1, e2) = (difference(&o, &a), difference(&b, &a), difference(&c, &a));
        let (p, q) = (cross(&d, &e2), cross(&s, &e1));
        let det = dot(&e1, &p);
        let turned = det.sign() == Ordering::Less;
        Self {
            det: det.magnitude(),
            turned,
            u: dot(&s, &p).negated_if(turned),
            v: dot(&d, &q).negated_if(turned),
            t: dot(&e2, &q).negated_if(turned),
            exponent: place - speed,
        }
    }

    /// What the ray does.
    pub(crate) fn outcome(&self, ray: &Ray<f64>) -> Outcome {
        let w = self.det.minus(&self.u).minus(&self.v);
        let is_outside = [&self.u, &self.v, &w].iter().any(|x| x.sign() == Ordering::Less);
        if self.det.sign() == Ordering::Equal
            || is_outside
            || self.is_beyond(ray.tmin, Ordering::Less)
            || self.is_beyond(ray.tmax, Ordering::Greater)
        {
            return Outcome::Miss;
        }
        if self.turned { Outcome::Back } else { Outcome::Front }
    }

    /// Whether `t` is on that side of an end of the interval; always where the end is NaN.
    fn is_beyond(&self, tau: f64, side: Ordering) -> bool {
        if tau.is_nan() {
            return true;
        }
        if tau.is_infinite() {
            return (if tau > 0.0 { Ordering::Less } else { Ordering::Greater }) == side;
        }
        let (mantissa, exponent) = decode(tau);
        let bound = self.det.times(&Integer::new(mantissa, 0));
        compare_shifted(&self.t, &bound, self.exponent - exponent) == side
    }

    /// Whether all weights of a hit are positive once the origin is moved by `(ε, ε², ε³)`: where one is zero, the
    /// first coordinate decides that its change depends on. Not all are zero, as no edge is parallel to the
    /// ray.
    pub(crate) fn owns(&self, ray: &Ray<f64>, triangle: &Triangle<f64>) -> bool {
        let Triangle { a, b, c } = *triangle;
        let (place, speed) = (unit(&[a, b, c]), unit(&[ray.d]));
        let [a, b, c] = [a, b, c].map(|point| multiples::<LIMBS>(point, place));
        let d = multiples(ray.d, speed);
        let (e1, e2) = (difference(&b, &a), difference(&c, &a));
        let w = self.det.minus(&self.u).minus(&self.v);
        [
            (&self.u, cross(&d, &e2)),
            (&self.v, cross(&e1, &d)),
            (&w, cross(&d, &difference(&e1, &e2))),
        ]
        .into_iter()
        .all(|(weight, Vec3 { x, y, z })| {
            let change = x.sign().then(y.sign()).then(z.sign());
            let change = if self.turned { change.reverse() } else { change };
            weight.sign().then(change) == Ordering::Greater
        })
    }

    /// The order of the `t` of two triangles that a ray meets, neither parallel to it.
    pub(crate) fn order(&self, other: &Self) -> Ordering {
        let (x, y) = (self.t.times(&other.det), other.t.times(&self.det));
        compare_shifted(&x, &y, self.exponent - other.exponent)
    }

    /// `t`, `beta` and `gamma`, each rounded once to the nearest, for `det ≠ 0`.
    pub(crate) fn values(&self, format: Format) -> [f64; 3] {
        [
            nearest(&self.t, &self.det, self.exponent, format),
            nearest(&self.u, &self.det, 0, format),
            nearest(&self.v, &self.det, 0, format),
        ]
    }
}

/// The order of `x · 2^shift` and `y`.
fn compare_shifted<const LIMBS: usize>(
    x: &Integer<LIMBS>,
    y: &Integer<LIMBS>,
    shift: i32,
) -> Ordering {
    // Signs first, so that what is far apart need not be shifted.
    x.sign().cmp(&y.sign()).then_with(|| {
        let places = shift.unsigned_abs() as usize;
        if shift >= 0 { x.shifted(places).cmp(y) } else { x.cmp(&y.shifted(places)) }
    })
}

/// A binary format that results are rounded to.
#[derive(Clone, Copy)]
pub(crate) struct Format {
    /// Bits of the significand.
    pub(crate) bits: i32,
    /// The exponent of the smallest number.
    pub(crate) smallest: i32,
}

impl Format {
    pub(crate) const F32: Self = Self { bits: 24, smallest: -149 };
    pub(crate) const F64: Self = Self { bits: 53, smallest: -1074 };
}

/// `x/y · 2^shift` rounded once, ties to even, for `y > 0`.
///
/// The uppermost 64 bits of both give a quotient that is off by less than 2⁻⁶⁰ of itself, so that the
/// lower of its two neighbours in the format is known, or the value lies so near to a number of the
/// format that it is on the right side of the middle whichever neighbour that is. The exact comparison
/// with the middle decides.
#[allow(clippy::cast_possible_truncation, reason = "a quotient of 63 or 64 bits")]
fn nearest<const LIMBS: usize>(
    x: &Integer<LIMBS>,
    y: &Integer<LIMBS>,
    shift: i32,
    format: Format,
) -> f64 {
    if x.sign() == Ordering::Equal {
        return 0.0;
    }
    let ((a, a_exponent), (b, b_exponent)) = (x.leading(), y.leading());
    let quotient = ((u128::from(a) << 63) / u128::from(b)) as u64;
    let exponent = a_exponent - b_exponent - 63 + shift;
    let uppermost = exponent + 63 - quotient.leading_zeros().cast_signed();
    let ulp = (uppermost + 1 - format.bits).max(format.smallest);
    let lower = quotient.checked_shr((ulp - exponent).unsigned_abs()).unwrap_or(0);
    // At most 2⁵³.
    let middle = Integer::new((2 * lower + 1).cast_signed(), 0).times(y);
    let units = match compare_shifted(&x.magnitude(), &middle, shift + 1 - ulp) {
        Ordering::Less => lower,
        Ordering::Equal => lower + (lower & 1),
        Ordering::Greater => lower + 1,
    };
    let magnitude = units as f64 * power_of_two(ulp);
    if x.sign() == Ordering::Less { -magnitude } else { magnitude }
}

/// `2^exponent`, from the smallest f64 on; infinite beyond the largest.
fn power_of_two(exponent: i32) -> f64 {
    if exponent > 1023 {
        return f64::INFINITY;
    }
    let bits = if exponent >= -1022 {
        u64::from((exponent + 1023).unsigned_abs()) << 52
    } else {
        1 << (exponent + 1074)
    };
    f64::from_bits(bits)
}
