//! How much of the filter's bound is needed: pairs that a narrower one decides falsely.

use core::cmp::Ordering;

use trisect_core::{Hit, Ray, Scalar as _, Triangle, Vec3};
use trisect_exact::{Exact, Proved, Width};
use trisect_formula::Flushing;
use trisect_kernels::{intersect, intersect_with};
use trisect_method::{Culling, Deferred, ExactMethod, Interval, Method, TrueDivision};
use trisect_oracle::Oracle;
use trisect_workloads::{Pair, Stream, Stress};

/// `O`, `D`, `A`, `B` and `C` of pairs that miss, as bits, which the ignored test of `src/filter.rs` found by
/// climbing. The least of the three volumes is negative, and comes out as such a share of the bound, or more.
#[allow(clippy::unreadable_literal, reason = "bits of floats, as they were printed")]
const FALSE_HITS: [(f64, [u32; 15]); 6] = [
    (
        0.177,
        [
            0xbf07172e, 0xbe85e27a, 0x3e7729f2, 0x3eba99b3, 0xbd88c0ba, 0xbd118767, 0xbef84907,
            0x3d00ca2d, 0xbeea6e74, 0xbdc8beb8, 0xbf4c24e3, 0x3e2fdc56, 0xbe29fc0f, 0x3f551c53,
            0x3e8d9307,
        ],
    ),
    (
        0.171,
        [
            0x3d77e0ae, 0x3df2a303, 0x3ee4efc9, 0xbda9e526, 0xbee01241, 0x4011c5e4, 0xbd9e6cc3,
            0xbed62932, 0x3eb184b6, 0xbf24beb3, 0x3d9a8885, 0xbe5b35fa, 0x3ea743fc, 0x3df94586,
            0x3f449e9e,
        ],
    ),
    (
        0.123,
        [
            0x3ecba7a5, 0xbed1dcd0, 0xbe91ca97, 0xbeb3a27e, 0x3fd16a47, 0xbc26107e, 0x3e6d3737,
            0x3e1dbe68, 0xbf9618eb, 0x3f2fce3d, 0xbf63a5fc, 0xbe8dc799, 0xbf5ea53f, 0xbf1b9937,
            0xbea2b0e0,
        ],
    ),
    (
        0.122,
        [
            0x3f4b155a, 0xbf1c1ecf, 0x3f29e153, 0xbe286982, 0xbedee256, 0xbf1db47b, 0x3e1f3cdf,
            0xbe4d762a, 0xbd5b1717, 0xbf49a68c, 0xbf6a8bc5, 0x3f22100d, 0x3f53a241, 0xbf666576,
            0x3e5acd67,
        ],
    ),
    (
        0.119,
        [
            0xbe4535c0, 0xbea0fc25, 0xbe6a8033, 0xbddadb0c, 0xbee666fc, 0xbc6bf7c9, 0x3f717755,
            0x3f544aa9, 0xbd4a4a64, 0x3e56c06e, 0xbefe68c7, 0xbfab9e45, 0xbecd1b7c, 0xbd5f347f,
            0x3ee5bdf0,
        ],
    ),
    (
        0.117,
        [
            0xbdd6c4f2, 0xbf15b938, 0x3e5f7e83, 0xbd6ed7c2, 0x3ca28923, 0x3f06a38b, 0x3ed6315a,
            0xbf85f920, 0xbe2ea6e4, 0xbf4bb52a, 0xbf91d9b9, 0xbf152ce2, 0x3f2eae52, 0xbc691e96,
            0x3f15bc04,
        ],
    ),
];

fn pair(bits: &[u32; 15]) -> Pair<f32> {
    let vector = |place: usize| {
        let [x, y, z] = [0, 1, 2].map(|axis| f32::from_bits(bits[place + axis]));
        Vec3::new(x, y, z)
    };
    let ray = Ray::<f32>::new(vector(0), vector(3));
    let ray = Ray { tmin: -ray.tmax, ..ray };
    (ray, Triangle { a: vector(6), b: vector(9), c: vector(12) })
}

/// A filter that believes a tenth of its bound.
struct Tenth;

impl Width for Tenth {
    const FILTER: f64 = 0.1;
    const DOUBLE: f64 = 1.0;
}

#[test]
fn a_tenth_of_the_bound_calls_misses_hits() {
    let mut most: f64 = 0.0;
    for (share, bits) in &FALSE_HITS {
        let (ray, triangle) = pair(bits);
        assert!(!Oracle::default().classify(&ray, &triangle).is_hit());
        assert!(intersect::<Exact, f32>(&ray, &triangle).is_none());
        let is_fooled = intersect::<Exact<Tenth>, f32>(&ray, &triangle).is_some();
        assert_eq!(is_fooled, *share > 0.1, "{share}");
        most = most.max(*share);
    }
    assert!(most > 0.17);
}

/// Subnormal numbers as zeros of their sign.
fn flushed((ray, triangle): &Pair<f32>) -> Pair<f32> {
    let zero = |x: &f32| if x.is_subnormal() { 0.0_f32.copysign(*x) } else { *x };
    (ray.map(zero), triangle.map(zero))
}

fn truth((ray, triangle): &Pair<f32>) -> Option<Hit<f32>> {
    let Interval { tmin, tmax } = Interval::new(ray.tmin, ray.tmax);
    let ray = Ray { tmin, tmax, ..*ray };
    Oracle::default().intersect(&ray, triangle).hit
}

/// A processor that flushes subnormal numbers to zero gets the truth, of the numbers or of those that it
/// sees: nothing between.
#[test]
fn flushing_to_zero_gives_the_truth_of_the_numbers_or_of_zeros_for_them() {
    let (mut tests, mut hits, mut differ) = (0, 0, 0);
    for family in Stress::ALL {
        for level in family.levels::<f32>() {
            for pair in family.pairs::<f32>(3, level, 100) {
                let number = |x: &f32| Flushing::from_f64(f64::from(*x));
                let (ray, triangle) = (pair.0.map(number), pair.1.map(number));
                let found = intersect_with::<Exact, Deferred<TrueDivision, true>, Flushing>(
                    &ray,
                    &triangle,
                    Culling::None,
                );
                let found = found.is_some();
                let [kept, zeros] = [truth(&pair), truth(&flushed(&pair))].map(|hit| hit.is_some());
                assert!(found == kept || found == zeros, "{}: {pair:?}", family.name());
                tests += 1;
                hits += u32::from(found);
                differ += u32::from(kept != zeros);
            }
        }
    }
    println!("{tests} pairs, {hits} hits, {differ} not as with zeros");
    assert!(hits > 1000);
}

/// f64 that believes a hundredth of its bound.
struct Hundredth;

impl Width for Hundredth {
    const FILTER: f64 = 1.0;
    const DOUBLE: f64 = 0.01;
}

/// Halves of parallelograms that f32 holds exactly, so that they are in one plane: f64 sees their `t` differ,
/// and must not believe it.
#[test]
fn a_hundredth_of_the_bound_orders_what_is_equal() {
    fn order<W: Width>(ray: &Ray<f32>, triangles: &[Triangle<f32>; 2]) -> Ordering
    where
        Exact<W>: ExactMethod,
    {
        let [first, second] = triangles.map(|triangle| Exact::<W>::prepare(&triangle, 0));
        Exact::<W>::order(ray, &first, &second)
    }
    let mut stream = Stream::new("exact/order", 1);
    let mut fooled = 0;
    for _ in 0..10_000 {
        // Twenty bits before the point, of which sums have two more.
        #[allow(clippy::cast_possible_truncation, reason = "whole numbers of few bits")]
        let mut vector = || {
            let [x, y, z] = [0, 1, 2].map(|_| stream.range_f64(-1e6, 1e6).round() as f32);
            Vec3::new(x, y, z)
        };
        let (a, b, c, o, d) = (vector(), vector(), vector(), vector(), vector());
        let triangles = [Triangle { a, b, c }, Triangle { a: b + c - a, b, c }];
        let ray = Ray::<f32>::new(o, d);
        assert_eq!(order::<Proved>(&ray, &triangles), Ordering::Equal);
        fooled += usize::from(order::<Hundredth>(&ray, &triangles) != Ordering::Equal);
    }
    assert!(fooled > 20, "{fooled}");
}
