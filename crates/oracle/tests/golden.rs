//! Classes and values of named cases.

use trisect_core::{Float, FloatFormat, Ray, Triangle, Vec3};
use trisect_oracle::{Class, Oracle, exact_class, exact_rationals};

fn unit<E: Float>() -> Triangle<E> {
    triangle([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
}

fn vector<E: Float>(v: [f64; 3]) -> Vec3<E> {
    v.map(E::from_f64).into()
}

fn triangle<E: Float>(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> Triangle<E> {
    Triangle { a: vector(a), b: vector(b), c: vector(c) }
}

fn ray<E: Float>(o: [f64; 3], d: [f64; 3], tmin: f64, tmax: f64) -> Ray<E> {
    Ray { o: vector(o), d: vector(d), tmin: E::from_f64(tmin), tmax: E::from_f64(tmax) }
}

/// The class by every road.
fn class<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> Class {
    let mut oracle = Oracle::default();
    let class = oracle.classify(ray, triangle);
    assert_eq!(class, exact_class(ray, triangle));
    assert_eq!(class, oracle.truth(ray, triangle).class);
    let answer = oracle.intersect(ray, triangle);
    assert_eq!(class, answer.class);
    assert_eq!(class.is_hit(), answer.hit.is_some());
    assert_eq!(class.is_hit(), oracle.closest(ray, &[*triangle]).is_some());
    class
}

fn down<E: Float>(x: f64, y: f64) -> Class {
    class::<E>(&ray([x, y, 1.0], [0.0, 0.0, -1.0], 0.0, f64::INFINITY), &unit())
}

fn both(expected: Class, case: impl Fn() -> Class, other: impl Fn() -> Class) {
    assert_eq!(case(), expected);
    assert_eq!(other(), expected);
}

macro_rules! both {
    ($expected:expr, $case:ident $arguments:tt) => {
        both($expected, || $case::<f32> $arguments, || $case::<f64> $arguments)
    };
}

#[test]
fn inside_edges_and_vertices() {
    both!(Class::Interior, down(0.25, 0.25));
    both!(Class::Edge, down(0.5, 0.0));
    both!(Class::Edge, down(-0.0, 0.5));
    both!(Class::Edge, down(0.5, 0.5));
    both!(Class::Edge, down(0.125, 0.875));
    both!(Class::Vertex, down(0.0, 0.0));
    both!(Class::Vertex, down(1.0, 0.0));
    both!(Class::Vertex, down(-0.0, 1.0));
    both!(Class::Miss, down(1.0, 1.0));
    both!(Class::Miss, down(-1e-30, 0.5));
    both!(Class::Miss, down(0.5, -1e-40));
    both!(Class::Interior, down(1e-30, 0.5));
    both!(Class::Miss, down(2.0, 0.0));
}

#[test]
fn degenerate_before_coplanar() {
    fn at<E: Float>(d: [f64; 3], c: [f64; 3]) -> Class {
        let triangle = triangle::<E>([0.0; 3], [1.0, 1.0, 0.0], c);
        class(&ray([0.0, 0.0, 0.0], d, 0.0, 1.0), &triangle)
    }
    let c = [0.0, 1.0, 0.0];
    both!(Class::Coplanar, at([1.0, 0.0, 0.0], c));
    both!(Class::Coplanar, at([0.3, 0.7, -0.0], c));
    both!(Class::Coplanar, at([0.0, 0.0, 0.0], c));
    both!(Class::Coplanar, at([0.0, -0.0, 0.0], c));
    both!(Class::Coplanar, at([3.0, 0.0, 3.0], [1.0, 0.0, 1.0]));
    both!(Class::Degenerate, at([1.0, 0.0, 0.0], [0.0; 3]));
    both!(Class::Degenerate, at([1.0, 0.0, 5.0], [1.0, 1.0, 0.0]));
    both!(Class::Degenerate, at([1.0, 0.0, 5.0], [3.0, 3.0, 0.0]));
    both!(Class::Degenerate, at([0.0, 0.0, 0.0], [-0.1, -0.1, -0.0]));
    // Beside the line by one unit in the last place.
    both!(Class::Vertex, at([0.0, 0.0, 1.0], [3.0, 2.999_999_761_581_421, 0.0]));
}

#[test]
fn interval_is_closed() {
    fn at<E: Float>(tmin: f64, tmax: f64) -> Class {
        class::<E>(&ray([0.25, 0.25, 3.0], [0.0, 0.0, -1.0], tmin, tmax), &unit())
    }
    fn next<E: Float>(x: f32, up: bool) -> f64 {
        let x = if E::FORMAT == FloatFormat::F32 {
            return f64::from(if up { x.next_up() } else { x.next_down() });
        } else {
            f64::from(x)
        };
        if up { x.next_up() } else { x.next_down() }
    }
    fn near<E: Float>(up: bool, is_tmin: bool) -> Class {
        let t = next::<E>(3.0, up);
        if is_tmin { at::<E>(t, 10.0) } else { at::<E>(0.0, t) }
    }
    fn behind<E: Float>(tmin: f64) -> Class {
        class::<E>(&ray([0.25, 0.25, 3.0], [0.0, 0.0, 1.0], tmin, 1e30), &unit())
    }
    fn on_plane<E: Float>(tmin: f64) -> Class {
        class::<E>(&ray([0.25, 0.25, 0.0], [0.1, 0.0, 1.0], tmin, 1.0), &unit())
    }
    both!(Class::Interior, at(3.0, 3.0));
    both!(Class::Interior, at(3.0, f64::INFINITY));
    both!(Class::Interior, at(f64::NEG_INFINITY, 3.0));
    both!(Class::Interior, at(-0.0, 4.0));
    both!(Class::Interior, near(true, false));
    both!(Class::Interior, near(false, true));
    both!(Class::OutOfInterval, near(false, false));
    both!(Class::OutOfInterval, near(true, true));
    both!(Class::OutOfInterval, at(4.0, 2.0));
    both!(Class::OutOfInterval, at(f64::INFINITY, 0.0));
    both!(Class::OutOfInterval, at(f64::INFINITY, f64::INFINITY));
    both!(Class::OutOfInterval, at(0.0, f64::NEG_INFINITY));
    both!(Class::OutOfInterval, at(-5.0, -1.0));
    both!(Class::NonFinite, at(f64::NAN, 5.0));
    both!(Class::NonFinite, at(0.0, f64::NAN));

    both!(Class::OutOfInterval, behind(0.0));
    both!(Class::Interior, behind(-3.0));
    both!(Class::Interior, on_plane(0.0));
    both!(Class::Interior, on_plane(-0.0));
    both!(Class::OutOfInterval, on_plane(1e-45));
}

#[test]
fn non_finite_anywhere_never_hits() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for place in 0..15 {
            for fill in [0.0, 1.0, -0.5] {
                let mut xs = [
                    0.25, 0.25, 3.0, fill, fill, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0, fill, 0.0, 1.0, 0.0,
                ];
                xs[place] = bad;
                let v = |i: usize| Vec3::new(xs[i], xs[i + 1], xs[i + 2]);
                let triangle = Triangle { a: v(6), b: v(9), c: v(12) };
                let ray = Ray { o: v(0), d: v(3), tmin: -10.0, tmax: 10.0 };
                assert_eq!(class(&ray, &triangle), Class::NonFinite, "{ray:?} {triangle:?}");
                let (ray, triangle) = (Ray::<f64>::from(ray), Triangle::<f64>::from(triangle));
                assert_eq!(class(&ray, &triangle), Class::NonFinite);
                // A zero direction may be certain of its zero determinant too early.
                let still = Ray { d: Vec3::new(0.0, 0.0, 0.0), ..ray };
                if !(3..6).contains(&place) {
                    assert_eq!(class(&still, &triangle), Class::NonFinite);
                }
            }
        }
    }
}

#[test]
fn corners_that_share_two_coordinates_are_degenerate() {
    let triangle = Triangle::<f32>::new(
        [-1_113.454_6, -79.049_614, -56.243_19],
        [-1_113.454_6, -87.092_27, -56.243_19],
        [-1_113.454_6, -79.209_015, -56.243_19],
    );
    let ray = Ray {
        tmax: 0.9999,
        ..Ray::<f32>::new(
            [-1_081.479_2, 99.999_954, 87.770_11],
            [-32.107_3, -183.355_87, -144.607_64],
        )
    };
    assert_eq!(class(&ray, &triangle), Class::Degenerate);
}

#[test]
fn the_smallest_and_the_largest_numbers() {
    let least = f64::from_bits(1);
    for size in [least, f64::from_bits(7), f64::MIN_POSITIVE, 1e-200, 1e200, f64::MAX / 2.0] {
        let triangle = triangle::<f64>([0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]);
        let ray = ray::<f64>([0.0, size, size], [size, -size, -size], 0.0, 1.0);
        assert_eq!(class(&ray, &triangle), Class::Vertex);
        let truth = Oracle::default().truth(&ray, &triangle);
        assert_eq!([truth.t, truth.beta, truth.gamma], [1.0, 1.0, 0.0]);
        assert!(truth.condition.max().is_finite() && truth.condition.max() >= 1.0);
    }
}

/// A hit has no `t` beyond half the largest number, whatever the interval says.
#[test]
fn the_interval_ends_at_half_the_largest_number() {
    fn check<E: Float>() {
        let end = E::largest_t().to_f64();
        // 2 to the 127th or the 1023rd: just above the end.
        let above = end / (1.0 - E::UNIT_ROUNDOFF);
        // A power of two from which `t` is the distance times 2 to the 125th or the 1021st.
        let speed = 4.0 / above;
        let answer = |distance: f64, side: f64, tmin: f64, tmax: f64| {
            let ray = ray::<E>([0.25, 0.25, -distance * side], [0.0, 0.0, speed], tmin, tmax);
            let class = class(&ray, &unit());
            let hit = Oracle::default().intersect(&ray, &unit()).hit;
            (class, hit.map(|hit| hit.t.to_f64()))
        };
        let infinite = f64::INFINITY;
        let beyond = (Class::OutOfInterval, None);
        // The number below 4, and the one below that.
        let (last, before) = (4.0 * (1.0 - E::UNIT_ROUNDOFF), 4.0 * (1.0 - 2.0 * E::UNIT_ROUNDOFF));
        for (tmin, tmax) in [(-infinite, infinite), (-above, above), (-end, end)] {
            for side in [1.0, -1.0] {
                assert_eq!(answer(last, side, tmin, tmax), (Class::Interior, Some(end * side)));
                let found = before / speed * side;
                assert_eq!(answer(before, side, tmin, tmax), (Class::Interior, Some(found)));
                assert_eq!(answer(4.0, side, tmin, tmax), beyond);
                assert_eq!(answer(1e10, side, tmin, tmax), beyond);
            }
        }
        assert_eq!(answer(4.0, 1.0, above, infinite), beyond);
        assert_eq!(answer(4.0, -1.0, -infinite, -above), beyond);
    }
    check::<f32>();
    check::<f64>();
    // Directions that are subnormal, as files may have them: the kernels of the exact method say the same.
    for along in [1e-40, 1e-45] {
        let ray = ray::<f32>([0.25, 0.25, -1.0], [0.0, 0.0, along], 0.0, f64::INFINITY);
        assert_eq!(class(&ray, &unit()), Class::OutOfInterval);
    }
}

#[test]
fn condition_of_a_simple_case() {
    let ray = ray::<f64>([0.25, 0.5, 2.0], [0.0, 0.0, -1.0], 0.0, 9.0);
    let truth = Oracle::default().truth(&ray, &unit());
    // One product in each volume: κ = |x| + |x|.
    assert_eq!([truth.t, truth.beta, truth.gamma], [2.0, 0.25, 0.5]);
    assert_eq!(truth.condition.t, 4.0);
    assert_eq!(truth.condition.beta, 0.5);
    assert_eq!(truth.condition.gamma, 1.0);
    assert_eq!(truth.condition.max(), 4.0);
    assert_eq!(truth.relative_condition().max(), 2.0);
    let miss = Oracle::default().truth(&Ray { d: Vec3::new(0.0, 0.0, 0.0), ..ray }, &unit());
    assert!(miss.t.is_nan() && miss.condition.max().is_nan());
    assert!(exact_rationals(&Ray { d: Vec3::new(0.0, 0.0, 0.0), ..ray }, &unit()).is_none());
}
