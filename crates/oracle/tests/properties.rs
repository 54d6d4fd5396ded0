//! The oracle against independent exact arithmetic.

use core::cmp::Ordering;

use num_bigint::BigInt;
use num_rational::BigRational;
use proptest::prelude::*;
use trisect_core::{Float, FloatFormat, Ray, Scalar, Triangle, Vec3};
use trisect_method::Interval;
use trisect_oracle::{Class, Exact, Oracle, RBig, compare_t, exact_class, exact_rationals};

/// Any finite f32, with small integers, subnormals and extremes all common.
fn f32s() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -1.0f32..1.0,
        3 => (-4i8..=4).prop_map(f32::from),
        1 => (-1.0f32..1.0, -30i32..30).prop_map(|(m, e)| m * 10f32.powi(e)),
        1 => any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |x| x.is_finite()),
        1 => (0u32..20).prop_map(f32::from_bits),
    ]
}

/// Any finite f64, likewise.
fn f64s() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => f32s().prop_map(f64::from),
        4 => -1.0f64..1.0,
        1 => (-1.0f64..1.0, -30i32..30).prop_map(|(m, e)| m * 10f64.powi(e)),
        1 => any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite()),
        1 => (0u64..20).prop_map(f64::from_bits),
    ]
}

fn pair<E: Float>(xs: [E; 17]) -> (Ray<E>, Triangle<E>) {
    let v = |i: usize| Vec3::new(xs[i], xs[i + 1], xs[i + 2]);
    (Ray { o: v(0), d: v(3), tmin: xs[15], tmax: xs[16] }, Triangle { a: v(6), b: v(9), c: v(12) })
}

/// Draws 17 numbers and moves the origin, by rounded arithmetic, so that the ray passes close to
/// `A + beta·e1 + gamma·e2` for one of a few weights: else hits would be rare.
fn aimed<E: Float>(xs: [E; 17], aim: usize) -> (Ray<E>, Triangle<E>) {
    let (mut ray, triangle) = pair(xs);
    let weights = [[0.5, 0.0], [0.0, 0.25], [0.5, 0.5], [0.0, 0.0], [1.0, 0.0], [0.25, 0.5]];
    if let Some(&[beta, gamma]) = weights.get(aim) {
        let (e1, e2) = (triangle.b - triangle.a, triangle.c - triangle.a);
        let target = triangle.a + e1.scale(E::from_f64(beta)) + e2.scale(E::from_f64(gamma));
        let origin = target - ray.d;
        if origin.to_array().into_iter().all(|x| x.to_f64().is_finite()) {
            ray.o = origin;
        }
    }
    (ray, triangle)
}

type Rational3 = [BigRational; 3];

fn rational(x: f64) -> BigRational {
    BigRational::from_float(x).expect("drawn finite")
}

fn rationals<E: Float>(v: Vec3<E>) -> Rational3 {
    v.to_array().map(|x| rational(x.to_f64()))
}

fn sub(a: &Rational3, b: &Rational3) -> Rational3 {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

/// The determinant of three columns, by Sarrus: another order than the oracle's.
fn determinant(a: &Rational3, b: &Rational3, c: &Rational3) -> BigRational {
    let term = |i: usize, j: usize, k: usize| &a[i] * &b[j] * &c[k];
    term(0, 1, 2) + term(1, 2, 0) + term(2, 0, 1) - term(2, 1, 0) - term(1, 0, 2) - term(0, 2, 1)
}

/// Cramer's rule on `beta·e1 + gamma·e2 − t·d = o − a`.
fn cramer<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> Option<[BigRational; 3]> {
    let zero = BigRational::from(BigInt::from(0));
    let a = rationals(triangle.a);
    let e1 = sub(&rationals(triangle.b), &a);
    let e2 = sub(&rationals(triangle.c), &a);
    let minus_d = rationals(ray.d).map(|x| -x);
    let s = sub(&rationals(ray.o), &a);
    let det = determinant(&e1, &e2, &minus_d);
    (det != zero).then(|| {
        [
            determinant(&e1, &e2, &s) / &det,
            determinant(&s, &e2, &minus_d) / &det,
            determinant(&e1, &s, &minus_d) / &det,
        ]
    })
}

fn from_dashu(x: &RBig) -> BigRational {
    let parse = |text: String| text.parse::<BigInt>().expect("decimal digits");
    BigRational::new(parse(x.numerator().to_string()), parse(x.denominator().to_string()))
}

fn naive_class<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> Class {
    let zero = BigRational::from(BigInt::from(0));
    let one = BigRational::from(BigInt::from(1));
    let Some([t, beta, gamma]) = cramer(ray, triangle) else {
        let a = rationals(triangle.a);
        let e1 = sub(&rationals(triangle.b), &a);
        let e2 = sub(&rationals(triangle.c), &a);
        let flat =
            [(0, 1), (1, 2), (2, 0)].into_iter().all(|(i, j)| &e1[i] * &e2[j] == &e1[j] * &e2[i]);
        return if flat { Class::Degenerate } else { Class::Coplanar };
    };
    let Interval { tmin, tmax } = Interval::new(ray.tmin, ray.tmax);
    let weights = [&one - &beta - &gamma, beta, gamma];
    if weights.iter().any(|x| *x < zero) {
        Class::Miss
    } else if t < rational(tmin.to_f64()) || t > rational(tmax.to_f64()) {
        Class::OutOfInterval
    } else {
        match weights.iter().filter(|x| **x == zero).count() {
            0 => Class::Interior,
            1 => Class::Edge,
            _ => Class::Vertex,
        }
    }
}

/// Whether `x` is the number of `E` nearest to `exact`, ties to even: neither neighbour is nearer,
/// and an even one not as near.
fn is_nearest<E: Float>(x: E, exact: &BigRational) -> bool {
    let bits = |x: E| x.bits64();
    let (down, up, largest, ulp) = if E::FORMAT == FloatFormat::F32 {
        #[allow(clippy::cast_possible_truncation, reason = "the number is one of f32")]
        let narrow = x.to_f64() as f32;
        let ulp = 2f64.powi(104);
        (f64::from(narrow.next_down()), f64::from(narrow.next_up()), f64::from(f32::MAX), ulp)
    } else {
        (x.to_f64().next_down(), x.to_f64().next_up(), f64::MAX, 2f64.powi(971))
    };
    let half_beyond = rational(largest) + rational(ulp) / BigInt::from(2);
    let magnitude =
        if *exact < BigRational::from(BigInt::from(0)) { -exact } else { exact.clone() };
    if x.to_f64().is_infinite() {
        return magnitude >= half_beyond;
    }
    let distance = |y: f64| {
        let difference = exact - rational(y);
        if difference < BigRational::from(BigInt::from(0)) { -difference } else { difference }
    };
    let own = distance(x.to_f64());
    magnitude < half_beyond
        && [down, up].into_iter().filter(|y| y.is_finite()).all(|y| match distance(y).cmp(&own) {
            Ordering::Greater => true,
            Ordering::Equal => bits(x) & 1 == 0,
            Ordering::Less => false,
        })
}

fn check<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) {
    let mut oracle = Oracle::default();
    let expected = naive_class(ray, triangle);
    assert_eq!(oracle.classify(ray, triangle), expected);
    assert_eq!(exact_class(ray, triangle), expected);
    let truth = oracle.truth(ray, triangle);
    assert_eq!(truth.class, expected);
    let answer = oracle.intersect(ray, triangle);
    assert_eq!(answer.class, expected);
    assert_eq!(oracle.closest(ray, &[*triangle]), answer.hit.map(|_| (0, answer)));

    let exact = cramer(ray, triangle);
    assert_eq!(
        exact_rationals(ray, triangle).map(|xs| xs.each_ref().map(from_dashu)),
        exact.clone()
    );
    let Some(exact) = exact else {
        assert!(truth.t.is_nan() && truth.condition.max().is_nan());
        return;
    };
    let tolerance = rational(2f64.powi(-30));
    for (x, exact) in [truth.t, truth.beta, truth.gamma].into_iter().zip(&exact) {
        // Outside the normal range only the nearest number can be asked for.
        if x.is_normal() {
            let error = (rational(x) - exact) / exact;
            assert!(error < tolerance && -error < tolerance);
        } else {
            assert!(is_nearest(x, exact));
        }
    }
    if let Some(hit) = answer.hit {
        for (x, exact) in [hit.t, hit.beta, hit.gamma].into_iter().zip(&exact) {
            assert!(is_nearest(x, exact), "{x:?} is not nearest to {exact}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn f32_agrees_with_naive_rationals(
        xs in proptest::array::uniform17(f32s()),
        aim in 0usize..8,
    ) {
        let (ray, triangle) = aimed(xs, aim);
        check(&ray, &triangle);
    }

    #[test]
    fn f64_agrees_with_naive_rationals(
        xs in proptest::array::uniform17(f64s()),
        aim in 0usize..8,
    ) {
        let (ray, triangle) = aimed(xs, aim);
        check(&ray, &triangle);
    }

    #[test]
    fn bits_at_random_do_not_panic(xs in proptest::array::uniform17(any::<u64>())) {
        let (ray, triangle) = pair(xs.map(f64::from_bits));
        let mut oracle = Oracle::default();
        let class = oracle.classify(&ray, &triangle);
        prop_assert_eq!(class, exact_class(&ray, &triangle));
        prop_assert_eq!(class, oracle.truth(&ray, &triangle).class);
        let finite = xs[..15].iter().all(|&x| f64::from_bits(x).is_finite())
            && xs[15..].iter().all(|&x| !f64::from_bits(x).is_nan());
        prop_assert_eq!(class == Class::NonFinite, !finite);
    }

    /// With integer points the direction is exact, and every volume is one of a tetrahedron.
    #[test]
    fn signs_agree_with_orient3d(xs in proptest::array::uniform15(-9i8..=9)) {
        let v = |i: usize| Vec3::new(f64::from(xs[i]), f64::from(xs[i + 1]), f64::from(xs[i + 2]));
        let (o, e, a, b, c) = (v(0), v(3), v(6), v(9), v(12));
        let coordinates = |v: Vec3<f64>| robust::Coord3D { x: v.x, y: v.y, z: v.z };
        let orient = |p: Vec3<f64>, q: Vec3<f64>, r: Vec3<f64>, s: Vec3<f64>| {
            let [p, q, r, s] = [p, q, r, s].map(coordinates);
            robust::orient3d(p, q, r, s).partial_cmp(&0.0)
        };
        let ray = Ray { o, d: e - o, tmin: f64::NEG_INFINITY, tmax: f64::INFINITY };
        let triangle = Triangle { a, b, c };
        let (above, below) = (orient(a, b, c, o), orient(a, b, c, e));
        let mut sides = [orient(o, e, a, b), orient(o, e, b, c), orient(o, e, c, a)];
        if let Some(values) = exact_rationals(&ray, &triangle) {
            // t in (0, 1) exactly when the plane parts the ends; t = 0 when o lies in it.
            let zero = RBig::ZERO;
            let parted = above != below
                && above != Some(Ordering::Equal)
                && below != Some(Ordering::Equal);
            prop_assert_eq!(values[0] > zero && values[0] < RBig::ONE, parted);
            prop_assert_eq!(values[0] == zero, above == Some(Ordering::Equal));
            // gamma, alpha and beta, up to one common sign.
            let alpha = RBig::ONE - &values[1] - &values[2];
            let signs = [&values[2], &alpha, &values[1]].map(|x| x.cmp(&zero));
            if sides[0] == Some(signs[0].reverse())
                && sides[1] == Some(signs[1].reverse())
                && sides[2] == Some(signs[2].reverse())
            {
                sides = sides.map(|side| side.map(Ordering::reverse));
            }
            prop_assert_eq!(sides, signs.map(Some));
        } else {
            let class = Oracle::default().classify(&ray, &triangle);
            prop_assert!(matches!(class, Class::Coplanar | Class::Degenerate));
        }
    }

    #[test]
    fn closest_agrees_with_the_naive_one(
        ray in proptest::array::uniform17(f32s()),
        soup in proptest::collection::vec((proptest::array::uniform9(-3i8..=3), -2i32..2), 1..40),
    ) {
        let ray = Ray { tmin: -3.0, tmax: 1e6, ..pair(ray).0 };
        let triangles: Vec<_> = soup
            .iter()
            .map(|(xs, e)| {
                let x = |i: usize| f32::from(xs[i]) * 2f32.powi(*e);
                let v = |i: usize| Vec3::new(x(i), x(i + 1), x(i + 2));
                Triangle { a: v(0), b: v(3), c: v(6) }
            })
            .collect();
        let mut naive: Option<(usize, BigRational)> = None;
        for (index, triangle) in triangles.iter().enumerate() {
            if naive_class(&ray, triangle).is_hit() {
                let [t, _, _] = cramer(&ray, triangle).expect("a hit has a point");
                if let Some((other, best)) = &naive {
                    prop_assert_eq!(
                        compare_t(&ray, triangle, &triangles[*other]),
                        Some(t.cmp(best))
                    );
                }
                if naive.as_ref().is_none_or(|(_, best)| t < *best) {
                    naive = Some((index, t));
                }
            }
        }
        let mut oracle = Oracle::default();
        let closest = oracle.closest(&ray, &triangles);
        prop_assert_eq!(closest.map(|(index, _)| index), naive.map(|(index, _)| index));
        if let Some((index, answer)) = closest {
            prop_assert_eq!(answer, oracle.intersect(&ray, &triangles[index]));
        }
    }

    #[test]
    fn a_formula_run_exactly_gives_the_same_rationals(xs in proptest::array::uniform17(f64s())) {
        let (ray, triangle) = pair(xs);
        let by_formula = Exact::scope(|| {
            let number = |v: Vec3<f64>| v.map(Exact::from_f64);
            let [a, b, c] = triangle.corners().map(number);
            let (o, d, e1, e2) = (number(ray.o), number(ray.d), b - a, c - a);
            let (p, s) = (d.cross(e2), o - a);
            let (det, q) = (e1.dot(p), s.cross(e1));
            let quotients = || [e2.dot(q) / det, s.dot(p) / det, d.dot(q) / det];
            (det != Exact::from_f64(0.0)).then(|| quotients().map(Exact::to_rational))
        });
        prop_assert_eq!(by_formula, exact_rationals(&ray, &triangle));
    }
}

#[test]
fn exactly_equal_hits_go_to_the_lowest_index() {
    let near = Triangle::<f32>::new([0.0, 0.0, 1.0], [3.0, 0.0, 1.0], [0.0, 3.0, 1.0]);
    let same = Triangle { a: near.b, b: near.c, c: near.a };
    let far = Triangle::<f32>::new([0.0, 0.0, 9.0], [3.0, 0.0, 9.0], [0.0, 3.0, 9.0]);
    let ray = Ray::<f32>::new([0.3, 0.3, 0.0], [0.01, 0.02, 0.7]);
    let mut oracle = Oracle::default();
    let closest = oracle.closest(&ray, &[far, near, same, near]);
    assert_eq!(closest.map(|(index, _)| index), Some(1));
    assert_eq!(oracle.closest(&ray, &[far, same, near]).map(|(index, _)| index), Some(1));
    assert_eq!(oracle.tests(), 7);
    assert!(oracle.exact() >= 3);
    let mut sum = Oracle::default();
    sum.merge(&oracle);
    sum.merge(&oracle);
    assert_eq!((sum.tests(), sum.exact()), (2 * oracle.tests(), 2 * oracle.exact()));
}
