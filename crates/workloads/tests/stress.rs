//! The stress families turn the knob that they name, and nothing else breaks.

use trisect_core::{Float, Ray, Triangle, Vec3};
use trisect_workloads::Stress;

const COUNT: usize = 200;

fn wide<E: Float>((ray, triangle): (Ray<E>, Triangle<E>)) -> (Ray<f64>, Triangle<f64>) {
    (ray.map(|x| x.to_f64()), triangle.map(|x| x.to_f64()))
}

fn length(v: Vec3<f64>) -> f64 {
    v.dot(v).sqrt()
}

/// The knob as it can be read off a pair; `None` for families whose knob is in the last bits.
fn knob(family: Stress, (ray, triangle): &(Ray<f64>, Triangle<f64>)) -> Option<f64> {
    let Triangle { a, b, c } = *triangle;
    let mut edges = [length(b - a), length(c - b), length(a - c)];
    edges.sort_by(f64::total_cmp);
    let n = triangle.normal();
    let height = |p: Vec3<f64>| n.dot(p - a) / length(n);
    match family {
        Stress::Sliver => Some(edges[2] * edges[2] / length(n)),
        Stress::Needle | Stress::MixedScale => Some(edges[2] / edges[0]),
        Stress::Grazing => Some((n.dot(ray.d) / (length(n) * length(ray.d))).abs()),
        Stress::FarOrigin => Some(length(ray.o - a) / edges[2]),
        // Nearer by, the place within the triangle counts as much.
        Stress::FarMesh if length(a) > 20.0 => Some(length(a) / edges[2]),
        Stress::Scale => Some(edges[2]),
        Stress::DirectionLength => Some(length(ray.d)),
        Stress::OriginNearPlane => Some(height(ray.o).abs() / edges[2]),
        _ => None,
    }
}

#[test]
fn the_knob_turns_what_it_names() {
    for family in Stress::ALL {
        // Where f64 keeps the digits that the measurement takes.
        let levels = family.levels::<f64>().into_iter().filter(|l| (1e-12..=1e12).contains(l));
        for level in levels {
            for pair in family.pairs::<f64>(1, level, COUNT) {
                if let Some(found) = knob(family, &pair) {
                    let ratio = found / level;
                    assert!((0.1..10.0).contains(&ratio), "{} {level}: {found}", family.name());
                }
            }
        }
    }
}

#[test]
fn numbers_are_finite_but_for_random_bits() {
    fn check<E: Float>(family: Stress) {
        for level in family.levels::<E>() {
            let pairs = family.pairs::<E>(1, level, COUNT);
            assert_eq!(pairs.len(), COUNT);
            for pair in pairs {
                let (ray, triangle) = wide(pair);
                let all = [ray.o, ray.d, triangle.a, triangle.b, triangle.c];
                let finite = all.iter().all(|v| v.map(|x| x - x).sum() == 0.0);
                assert!(finite, "{} {level}: {ray:?} {triangle:?}", family.name());
                // Where few bits are left the origin may round to the point that it is aimed at.
                let coarse = matches!(family, Stress::FarMesh | Stress::Subnormal);
                assert!(length(ray.d) > 0.0 || coarse, "{} {level}: {ray:?}", family.name());
            }
        }
    }
    for family in Stress::ALL.into_iter().filter(|&family| family != Stress::RandomBits) {
        check::<f32>(family);
        check::<f64>(family);
    }
}

#[test]
fn easy_levels_hit_three_of_four() {
    for family in [Stress::Sliver, Stress::Grazing, Stress::FarOrigin, Stress::Scale] {
        let pairs = family.pairs::<f64>(3, family.levels::<f64>()[0], 1000);
        let hits = pairs.iter().filter(|(ray, triangle)| {
            let Triangle { a, b, c } = *triangle;
            let (e1, e2, s) = (b - a, c - a, ray.o - a);
            let (p, q) = (ray.d.cross(e2), s.cross(e1));
            let det = e1.dot(p);
            let (beta, gamma) = (s.dot(p) / det, ray.d.dot(q) / det);
            beta >= 0.0 && gamma >= 0.0 && beta + gamma <= 1.0
        });
        assert!((700..800).contains(&hits.count()), "{}", family.name());
    }
}

#[test]
fn directions_on_the_lattice_have_the_zeros_they_should() {
    for zeros in [0_u8, 1, 2] {
        for (ray, _) in Stress::AxisAligned.pairs::<f32>(1, f64::from(zeros), COUNT) {
            let found = ray.d.to_array().iter().filter(|&&x| x == 0.0).count();
            assert_eq!(found, usize::from(zeros));
        }
    }
}

#[test]
fn levels_share_their_random_numbers_and_seeds_do_not() {
    let pairs = |seed, level| Stress::FarMesh.pairs::<f64>(seed, level, 1)[0];
    let (near, far, other) = (pairs(1, 1.0), pairs(1, 1e8), pairs(2, 1.0));
    let shape = |(_, t): (Ray<f64>, Triangle<f64>)| t.b - t.a;
    assert!(length(shape(near) - shape(far)) < 1e-6);
    assert!(length(shape(near) - shape(other)) > 1e-3);
}

/// FNV-1a over the bits of all pairs.
fn hash<E: Float>(family: Stress) -> u64 {
    let pairs = family.levels::<E>().into_iter().flat_map(|level| family.pairs::<E>(1, level, 20));
    let numbers = pairs.flat_map(|(ray, t)| {
        let corners = t.corners().into_iter().chain([ray.o, ray.d]).flat_map(Vec3::to_array);
        corners.chain([ray.tmin, ray.tmax]).collect::<Vec<_>>()
    });
    // A NaN that was computed has the bits that the processor gives it.
    let bits = numbers.map(|x| if x.to_f64().is_nan() { 0 } else { x.bits64() });
    bits.flat_map(u64::to_le_bytes).fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
#[allow(clippy::unreadable_literal, reason = "hashes")]
fn a_seed_gives_the_same_bits_everywhere() {
    let hashes =
        Stress::ALL.map(|family| (family.name(), hash::<f32>(family), hash::<f64>(family)));
    let golden: [(&str, u64, u64); 16] = [
        ("sliver", 0x4cf4f8d49c3ab4cd, 0x22278c5a0b97a709),
        ("needle", 0xf527225212d7caf4, 0xc870c6e5ff27b4e0),
        ("mixed-scale", 0xf76f43ae3d41b5ab, 0xbd0f51b58ba1bfbb),
        ("near-collinear", 0x7945eea6da740b46, 0x832590b23c19b8dd),
        ("grazing", 0x9840a816485837d7, 0x3c3f5372d93400a0),
        ("far-origin", 0x723825561830a193, 0xaaf9f4c6e9cd7948),
        ("far-mesh", 0x4be2d16dcc3cda3, 0x983588beda3a3cd3),
        ("scale", 0x408131984e20e367, 0xa43da61bfeaaa9e7),
        ("direction-length", 0x8dea12bb08cfe5d5, 0xe8857a4759c69c6c),
        ("subnormal", 0xb145cba1004199ce, 0x607a516cd8930c4a),
        ("near-edge", 0x3ee56695fe2d0cf4, 0x2ba0a533d1566311),
        ("near-vertex", 0x342824cf7faa99b7, 0xdf0a119621ce7592),
        ("interval-end", 0xbe1acc4c5e779d03, 0xa38afa3fc9dc8161),
        ("origin-near-plane", 0x618d32aea7b9f7b7, 0xc55b7f244390e76c),
        ("axis-aligned", 0x97649210ef11dd05, 0xce61f3beeeff4833),
        ("random-bits", 0x1aa2a23f7508ff73, 0x4e56a44551336c35),
    ];
    assert_eq!(hashes, golden, "{hashes:#x?}");
}
