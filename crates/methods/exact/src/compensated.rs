//! Values of a hit in f64: with twice its bits, since the last one cannot be told in f64 itself.
//!
//! A number is the sum of two, `h + l`. What rounding takes from `h` goes to `l`; what it takes from `l` is bounded, in
//! `docs/derivations/exact.md`.
//!
//! T. Ogita, S. M. Rump, S. Oishi: Accurate Sum and Dot Product. SIAM Journal on Scientific Computing 26(6), 2005.
//! T. J. Dekker: A floating-point technique for extending the available precision. Numerische Mathematik 18, 1971.

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};

/// Unit roundoff.
const U: f64 = f64::EPSILON / 2.0;

/// Sizes within `2^±120` keep all products in range, and what underflows below all bounds.
const SMALLEST: f64 = f64::from_bits((1023 - 120) << 52);
const LARGEST: f64 = f64::from_bits((1023 + 120) << 52);

/// `h + l`.
#[derive(Clone, Copy)]
struct Sum {
    h: f64,
    l: f64,
}

/// A number of f64.
#[inline(always)]
fn single(h: f64) -> Sum {
    Sum { h, l: 0.0 }
}

/// `a + b`, exactly.
#[inline(always)]
fn sum(a: f64, b: f64) -> Sum {
    let h = a + b;
    let of_b = h - a;
    Sum { h, l: (a - (h - of_b)) + (b - of_b) }
}

/// `a · b`, exactly. `L` says whether instructions are at hand that fuse multiply-add.
#[inline(always)]
fn product<L: Lanes>(a: f64, b: f64) -> Sum {
    let h = a * b;
    if L::FUSED {
        return Sum { h, l: a.mul_add(b, -h) };
    }
    let halves = |x: f64| {
        let large = f64::splitter() * x;
        let upper = large - (large - x);
        (upper, x - upper)
    };
    let ((a, c), (b, d)) = (halves(a), halves(b));
    Sum { h, l: c * d - (((h - a * b) - c * b) - a * d) }
}

impl Sum {
    #[inline(always)]
    fn times<L: Lanes>(self, other: Self) -> Self {
        let Self { h, l } = product::<L>(self.h, other.h);
        Self { h, l: l + (self.h * other.l + self.l * other.h) }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        let Self { h, l } = sum(self.h, other.h);
        Self { h, l: l + (self.l + other.l) }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.plus(Self { h: -other.h, l: -other.l })
    }
}

#[inline(always)]
fn difference(a: Vec3<f64>, b: Vec3<f64>) -> Vec3<Sum> {
    Vec3::new(sum(a.x, -b.x), sum(a.y, -b.y), sum(a.z, -b.z))
}

#[inline(always)]
fn cross<L: Lanes>(a: Vec3<Sum>, b: Vec3<Sum>) -> Vec3<Sum> {
    Vec3::new(
        a.y.times::<L>(b.z).minus(a.z.times::<L>(b.y)),
        a.z.times::<L>(b.x).minus(a.x.times::<L>(b.z)),
        a.x.times::<L>(b.y).minus(a.y.times::<L>(b.x)),
    )
}

#[inline(always)]
fn dot<L: Lanes>(a: Vec3<Sum>, b: Vec3<Sum>) -> Sum {
    a.x.times::<L>(b.x).plus(a.y.times::<L>(b.y)).plus(a.z.times::<L>(b.z))
}

/// The largest magnitude of a coordinate.
#[inline(always)]
fn largest(v: Vec3<Sum>) -> f64 {
    v.x.h.abs().max(v.y.h.abs()).max(v.z.h.abs())
}

/// `t`, `beta` and `gamma` of a hit, rounded once, and whether that is certain.
#[inline(always)]
pub(crate) fn values<L: Lanes>(ray: &Ray<f64>, triangle: &Triangle<f64>) -> ([f64; 3], bool) {
    let Triangle { a, b, c } = *triangle;
    let d = ray.d.map(single);
    let (s, e1, e2) = (difference(a, ray.o), difference(b, a), difference(c, a));
    let (n, r) = (cross::<L>(e2, e1), cross::<L>(d, s));
    let (det, t) = (dot::<L>(d, n), dot::<L>(s, n));
    let (u, minus_v) = (dot::<L>(e2, r), dot::<L>(e1, r));
    let v = Sum { h: -minus_v.h, l: -minus_v.l };

    let (h, speed) = (largest(e1).max(largest(e2)), d.x.h.abs() + d.y.h.abs() + d.z.h.abs());
    let away = largest(s).max(SMALLEST);
    let is_in_range = h >= SMALLEST && speed >= SMALLEST && h.max(speed).max(away) <= LARGEST;
    let det = sum(det.h, det.l);
    let of_det = 200.0 * U * U * (speed * h * h);
    let of_weights = 200.0 * U * U * (speed * away * h);
    let of_t = 600.0 * U * U * (away * h * h);
    let (t, is_t_told) = quotient::<L>(t, of_t, det, of_det);
    let (beta, is_beta_told) = quotient::<L>(u, of_weights, det, of_det);
    let (gamma, is_gamma_told) = quotient::<L>(v, of_weights, det, of_det);
    let is_clear = of_det < det.h.abs() * 1e-6;
    ([t, beta, gamma], is_in_range & is_clear & is_t_told & is_beta_told & is_gamma_told)
}

/// `x / y`, of numbers that are off by at most so much, rounded once, and whether that is certain. `y` is such that
/// `h + l` rounds to `h`.
#[inline(always)]
fn quotient<L: Lanes>(x: Sum, of_x: f64, y: Sum, of_y: f64) -> (f64, bool) {
    let x = sum(x.h, x.l);
    let first = x.h / y.h;
    let back = product::<L>(first, y.h);
    let rest = ((x.h - back.h) - back.l) + (x.l - first * y.l);
    let quotient = sum(first, rest / y.h);
    let size = quotient.h.abs();
    let error = 1.00001 * ((of_x + size * of_y) / y.h.abs()) + 40.0 * U * U * size;
    let (low, high) = (quotient.h + (quotient.l - error), quotient.h + (quotient.l + error));
    (quotient.h, low.to_bits() == high.to_bits())
}

#[cfg(test)]
mod tests {
    use trisect_workloads::Stream;

    use super::*;
    use crate::whole::{Format, Volumes};

    /// Nearly all values of hits are told, and those that are told are right.
    #[test]
    fn values_that_are_told_are_those_of_whole_numbers() {
        let mut stream = Stream::new("exact/compensated", 1);
        let (mut hits, mut told) = (0, 0);
        for _ in 0..20_000 {
            let far = [1.0, 1e-3, 1e6][usize::try_from(stream.bits() % 3).unwrap_or(0)];
            let offset = stream.cube().scale(far);
            let mut point = || stream.cube() + offset;
            let triangle = Triangle { a: point(), b: point(), c: point() };
            let middle = (triangle.a + triangle.b + triangle.c).scale(1.0 / 3.0);
            let o = point();
            let ray = Ray { o, d: middle - o, tmin: 0.0, tmax: f64::INFINITY };
            let expected = Volumes::<198>::new(&ray, &triangle).values(Format::F64);
            hits += 1;
            let (values, is_told) = values::<f64>(&ray, &triangle);
            told += i32::from(is_told);
            assert!(
                !is_told || values == expected,
                "{ray:?} {triangle:?}: {values:?} {expected:?}"
            );
        }
        assert!(told * 100 > hits * 99, "{told} of {hits}");
    }
}
