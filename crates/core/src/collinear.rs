//! Whether three points lie on one line, exactly.

use crate::decode::decode;
use crate::lanes::Float;

/// Whether the corners lie on one line: all three minors of the edges vanish.
///
/// A minor `p − q` of rounded edges is off by less than `8u(|p| + |q|)`, `u` the unit roundoff, while
/// that sum is no subnormal number: each edge rounds once, each product once more, and their
/// difference; what a product loses to underflow is below `2u` of the smallest normal number. So
/// nearly every triangle is known not to be degenerate after one cross product. For the others
/// integers decide.
#[inline]
pub(crate) fn are_collinear<E: Float>([a, b, c]: [[E; 3]; 3]) -> bool {
    let edge = |to: [E; 3]| [0, 1, 2].map(|axis| to[axis] - a[axis]);
    let (p, q) = (edge(b), edge(c));
    let bound = E::from_f64(8.0 * E::UNIT_ROUNDOFF);
    let is_clear = |p: E, q: E| {
        let size = p.abs() + q.abs();
        (p - q).abs() > bound * size && size >= E::smallest_det()
    };
    let clear = PLANES.into_iter().any(|(u, v)| is_clear(p[u] * q[v], p[v] * q[u]));
    !clear && exactly([a, b, c].map(|point| point.map(E::to_f64)))
}

/// The axes of each minor.
const PLANES: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// The same by exact arithmetic, whatever the numbers.
#[cold]
fn exactly([a, b, c]: [[f64; 3]; 3]) -> bool {
    let vanishes = |(x, y): (usize, usize)| {
        let (mut positive, mut negative) = (Sum::ZERO, Sum::ZERO);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            for (x, y) in [(p[x], q[y]), (-p[y], q[x])] {
                let ((m, i), (n, j)) = (decode(x), decode(y));
                let product = u128::from(m.unsigned_abs()) * u128::from(n.unsigned_abs());
                let sum = if (m < 0) == (n < 0) { &mut positive } else { &mut negative };
                sum.add(product, i + j);
            }
        }
        positive == negative
    };
    PLANES.into_iter().all(vanishes)
}

/// The least exponent of a product of two numbers.
const LEAST: i32 = -2 * 1074;

/// A sum of products of two numbers, none of which is negative: exact, as products are below 2²⁰⁴⁸.
#[derive(PartialEq, Eq)]
struct Sum([u64; Self::LIMBS]);

impl Sum {
    /// From 2⁻²¹⁴⁸ to 2²⁰⁴⁸, some carries, and what a product of 128 bits may reach beyond.
    const LIMBS: usize = (2048 - LEAST).unsigned_abs() as usize / 64 + 4;
    const ZERO: Self = Self([0; Self::LIMBS]);

    /// Adds `product · 2^exponent`; the product has at most 106 bits.
    fn add(&mut self, product: u128, exponent: i32) {
        let shift = (exponent - LEAST).unsigned_abs();
        let (first, bits) = ((shift / 64) as usize, shift % 64);
        let (low, high) = (product & u128::from(u64::MAX), product >> 64);
        let (low, high) = (low << bits, high << bits);
        let (mut carry, mut next) = (low, high);
        for limb in &mut self.0[first..] {
            carry += u128::from(*limb);
            #[allow(clippy::cast_possible_truncation, reason = "the rest is carried")]
            let lowest = carry as u64;
            *limb = lowest;
            carry = (carry >> 64) + next;
            next = 0;
            if carry == 0 {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Float;
    use crate::{Triangle, Vec3};

    fn are_collinear<E: Float>(triangle: &Triangle<E>) -> bool {
        super::are_collinear(triangle.corners().map(Vec3::to_array))
    }

    fn power_of_two(exponent: i32) -> f64 {
        f64::from(2).powi(exponent)
    }

    fn line<E: Float>(direction: [f64; 3], places: [f64; 3]) -> Triangle<E> {
        let [a, b, c] =
            places.map(|t| Vec3::from(direction).map(|x| E::from_f64(x) * E::from_f64(t)));
        Triangle { a, b, c }
    }

    /// Multiples of one direction by small whole numbers are exact, in both precisions.
    #[test]
    fn multiples_of_a_direction_are_collinear() {
        for size in [-100, -10, 0, 100].map(power_of_two) {
            for places in [[1.0, 2.0, 3.0], [-4.0, 0.0, 2.0], [3.0, 3.0, 1.0], [5.0, 5.0, 5.0]] {
                let direction = [1234.0 * size, -987.0 * size, 345.0 * size];
                assert!(are_collinear(&line::<f32>(direction, places)), "{size} {places:?}");
                assert!(are_collinear(&line::<f64>(direction, places)), "{size} {places:?}");
            }
        }
    }

    /// The last bit of one coordinate decides, over the whole range of exponents.
    #[test]
    fn one_unit_in_the_last_place_is_enough() {
        for exponent in [-1000, -400, -20, 0, 20, 400, 1000] {
            let direction = [3.0, 5.0, 7.0].map(|x| x * power_of_two(exponent));
            let flat: Triangle<f64> = line(direction, [1.0, 2.0, 3.0]);
            let bent = Triangle { c: Vec3 { z: flat.c.z.next_up(), ..flat.c }, ..flat };
            assert!(are_collinear(&flat) && !are_collinear(&bent), "2^{exponent}");
        }
        for exponent in [-140, -100, -20, 0, 20, 120] {
            let direction = [3.0, 5.0, 7.0].map(|x| x * power_of_two(exponent));
            let flat: Triangle<f32> = line(direction, [1.0, 2.0, 3.0]);
            let bent = Triangle { c: Vec3 { z: flat.c.z.next_up(), ..flat.c }, ..flat };
            assert!(are_collinear(&flat) && !are_collinear(&bent), "2^{exponent}");
        }
    }

    /// Axes as different as they can be: along each the numbers keep their bits.
    #[test]
    fn axes_of_different_scales_are_told_apart() {
        let direction = Vec3::new(3.0 * f64::from_bits(1), 5.0 * power_of_two(1000), 7.0);
        let [a, b, c] = [1.0, 2.0, 5.0].map(|t| direction.scale(t));
        assert!(are_collinear(&Triangle { a, b, c }));
        let bent = Vec3 { x: c.x.next_up(), ..c };
        assert!(!are_collinear(&Triangle { a, b, c: bent }));
    }

    /// Along one axis numbers of all magnitudes: found by `trisect stress --exact`, where the smaller one
    /// was lost to the larger.
    #[test]
    fn numbers_of_one_axis_are_told_apart() {
        let zero = Vec3::new(0.0, 0.0, 0.0);
        let a = Vec3::new(-8.03e249, 5.11e294, 0.0);
        let c = Vec3::new(-3.14e-201, 0.0, 0.0);
        assert!(!are_collinear(&Triangle { a, b: zero, c }));
        assert!(are_collinear(&Triangle { a: Vec3 { y: 0.0, ..a }, b: zero, c }));
        let least = Vec3::new(f64::from_bits(1), 0.0, 0.0);
        let most = Vec3::new(f64::MAX, f64::MAX, f64::MAX);
        assert!(!are_collinear(&Triangle { a: most, b: zero, c: least }));
        assert!(are_collinear(&Triangle { a: most, b: zero, c: -most }));
    }

    /// Edges round here, so that neither their cross product nor its rounding can tell.
    #[test]
    fn rounded_edges_are_seen_through() {
        // Abscissas have 21 bits, so that five times them is exact; differences have more.
        let on_line = |x: f32| Vec3::new(x, 3.0 * x, 5.0 * x);
        let a = on_line(1.0 + 1.0 / (1 << 20) as f32);
        let mut rounded = 0;
        for k in 2..200_u16 {
            let [b, c] = [f32::from(k) + 0.5, -1.25 * f32::from(k)].map(on_line);
            let flat = Triangle { a, b, c };
            rounded += usize::from(flat.normal() != Vec3::new(0.0, 0.0, 0.0));
            assert!(are_collinear(&flat), "{k}");
            let bent = Triangle { c: Vec3 { x: c.x.next_up(), ..c }, ..flat };
            assert!(!are_collinear(&bent), "{k}");
        }
        assert!(rounded > 10, "{rounded}");
    }
}
