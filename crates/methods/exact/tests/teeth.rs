//! How much of the filter's bound is needed: pairs that a narrower one decides falsely.

use trisect_core::{
    Culling, Deferred, Flushing, Hit, Interval, Ray, Scalar as _, Triangle, TrueDivision, Vec3,
    intersect, intersect_with,
};
use trisect_exact::{Exact, Width};
use trisect_oracle::Oracle;
use trisect_workloads::{Pair, Stress};

/// `O`, `D`, `A`, `B` and `C` of pairs that miss, as bits, which the ignored test of `src/filter.rs` found by
/// climbing. The least of the three volumes is negative, and comes out as such a share of the bound, or more.
#[allow(clippy::unreadable_literal, reason = "bits of floats, as they were printed")]
const FALSE_HITS: [(f64, [u32; 15]); 6] = [
    (
        0.137,
        [
            0xbeb6ee92, 0x3d29f40b, 0x3ed9bff9, 0x3f396b2e, 0xbef9d339, 0x3f45b666, 0xbeb3fc71,
            0x3db1498c, 0x3eecc9ba, 0x3ea21de8, 0xbf54eb56, 0xbec8e977, 0xbf946890, 0x3f724b72,
            0x3f67f4ce,
        ],
    ),
    (
        0.113,
        [
            0xbe28359b, 0x3d934330, 0x3ed6cb00, 0xbcf84510, 0x3d8c65ef, 0xbf8fce3a, 0x3fa4244b,
            0x3ee31ced, 0x3f45ef7b, 0xbd7dfb71, 0x3fc27643, 0x3d750009, 0xbe346221, 0x3c27ea95,
            0x3e4a7c83,
        ],
    ),
    (
        0.111,
        [
            0x3bfb7be7, 0xbc865028, 0xbea6af05, 0xbe35b80d, 0x3f4a9b69, 0x3f01c466, 0x3efd0e49,
            0x3d8e44a6, 0x3eb9ff8e, 0x3f4fb974, 0xbf26fe22, 0x3f51f22c, 0xbe4045e4, 0x3ec9039c,
            0xbe9d4f33,
        ],
    ),
    (
        0.107,
        [
            0x3e2481eb, 0x3d038c68, 0x3f000eed, 0xbd0ebb0f, 0x3f30aa0d, 0xbde878c2, 0x3ea903f9,
            0xbf369174, 0xbf790d0c, 0x40090059, 0xbf65070a, 0xbd902239, 0xbf8cad10, 0xbe490f30,
            0x3f81b291,
        ],
    ),
    (
        0.104,
        [
            0x3ca0c8a6, 0xbf499781, 0x3f3742c9, 0xbf22183d, 0xbe02c282, 0xbf83cb2c, 0x3f98efed,
            0x3e883135, 0x3e7eb662, 0x3ec4f71d, 0x3f9738aa, 0xbe9e66a9, 0x3e2375cc, 0xbf835356,
            0x3f95ef9b,
        ],
    ),
    (
        0.103,
        [
            0x3f61f40a, 0xbf753ba3, 0x3f63d719, 0xbf0db992, 0x3e6a83d6, 0xbef1c6dd, 0x3d48db9d,
            0x3d32fc14, 0xbdd131de, 0xbf4fa72d, 0xbe27e564, 0x3f3d70dc, 0x3ef3f4b2, 0xbf65a5bd,
            0xbf7176db,
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
    assert!(most > 0.13);
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
