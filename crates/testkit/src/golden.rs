//! Named cases: one table, run for every method in both forms, in f32.
//!
//! Restated from the stability notes of this project, which collected them from Embree's verify
//! program, pbrt-v4's shape tests, the Vulkan conformance suite, the DXR specification, and issues
//! of trimesh, libgdx, tinybvh and mitsuba, without keeping which came from where.
//!
//! A method that is known to fail a case says so as `"S4/early"`: the case's name and the form.

use std::collections::BTreeSet;

use trisect_core::{Culling, Hit, Method, Ray, Triangle, Vec3};

use crate::properties::{Test, forms, given};

/// A case: what must hold for a test, or why it does not.
struct Case {
    name: &'static str,
    what: &'static str,
    check: fn(Test<f32>, Given) -> Result<(), String>,
}

/// What a method gives of a hit.
type Given = fn(Hit<f32>) -> Hit<f32>;

const MINUS_ZERO: f32 = -0.0;
const INFINITY: f32 = f32::INFINITY;
const UNIT: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn ray(o: [f32; 3], d: [f32; 3]) -> Ray<f32> {
    Ray::<f32>::new(o, d)
}

fn triangle([a, b, c]: [[f32; 3]; 3]) -> Triangle<f32> {
    Triangle::new(a, b, c)
}

/// Onto the unit triangle from its back, `t = 1`.
fn onto_unit() -> Ray<f32> {
    ray([0.25, 0.25, -1.0], [0.0, 0.0, 1.0])
}

fn misses(test: Test<f32>, ray: Ray<f32>, corners: [[f32; 3]; 3]) -> Result<(), String> {
    match test(&ray, &triangle(corners), Culling::None) {
        None => Ok(()),
        Some(hit) => Err(format!("{ray:?} hits {corners:?}: {hit:?}")),
    }
}

fn hits(test: Test<f32>, ray: Ray<f32>, corners: [[f32; 3]; 3]) -> Result<Hit<f32>, String> {
    test(&ray, &triangle(corners), Culling::None)
        .ok_or_else(|| format!("{ray:?} misses {corners:?}"))
}

fn same<T: Copy + PartialEq + core::fmt::Debug>(found: T, wanted: T) -> Result<(), String> {
    if found == wanted { Ok(()) } else { Err(format!("{found:?} instead of {wanted:?}")) }
}

/// Two directions in the plane of the unit triangle, and one beside it.
fn in_the_plane(test: Test<f32>) -> Result<(), String> {
    misses(test, ray([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]), UNIT)?;
    misses(test, ray([0.25, 0.25, 0.0], [1.0, 1.0, 0.0]), UNIT)?;
    misses(test, ray([-1.0, 0.25, 1.0], [1.0, 0.0, 0.0]), UNIT)
}

const CASES: [Case; 17] = [
    Case {
        name: "H1",
        what: "hits inside the unit triangle, at most 16 ULP off",
        check: |test, given| {
            for place in 0..256_u16 {
                let at = |k: u16| (f32::from(k) + 0.5) / 33.0;
                let (u, v) = (at(place % 16), at(place / 16));
                let hit = hits(test, ray([u, v, -1.0], [0.0, 0.0, 1.0]), UNIT)?;
                let exact = given(Hit { t: 1.0, beta: u, gamma: v });
                for (found, wanted) in
                    [(hit.t, exact.t), (hit.beta, exact.beta), (hit.gamma, exact.gamma)]
                {
                    if found.to_bits().abs_diff(wanted.to_bits()) > 16 {
                        return Err(format!("{found} is more than 16 ULP from {wanted}"));
                    }
                }
            }
            Ok(())
        },
    },
    Case {
        name: "B1",
        what: "culling of back faces and of front faces",
        check: |test, given| {
            let (back, unit) = (onto_unit(), triangle(UNIT));
            let front = ray([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
            let hit = Some(given(Hit { t: 1.0, beta: 0.25, gamma: 0.25 }));
            same(test(&front, &unit, Culling::Back), hit)?;
            same(test(&back, &unit, Culling::Back), None)?;
            same(test(&front, &unit, Culling::Front), None)?;
            same(test(&back, &unit, Culling::Front), hit)
        },
    },
    Case {
        name: "B2",
        what: "two corners swapped swap beta and gamma",
        check: |test, given| {
            let [a, b, c] = UNIT;
            let ray = ray([0.5, 0.25, -1.0], [0.0, 0.0, 1.0]);
            same(hits(test, ray, [a, b, c])?, given(Hit { t: 1.0, beta: 0.5, gamma: 0.25 }))?;
            same(hits(test, ray, [a, c, b])?, given(Hit { t: 1.0, beta: 0.25, gamma: 0.5 }))
        },
    },
    Case {
        name: "T1",
        what: "the interval is closed",
        check: |test, _| {
            hits(test, Ray { tmin: 1.0, ..onto_unit() }, UNIT)?;
            hits(test, Ray { tmax: 1.0, ..onto_unit() }, UNIT)?;
            misses(test, Ray { tmin: 1.0_f32.next_up(), ..onto_unit() }, UNIT)?;
            misses(test, Ray { tmax: 1.0_f32.next_down(), ..onto_unit() }, UNIT)
        },
    },
    Case {
        name: "T2",
        what: "a ray switched off by tmin = inf, tmax = 0",
        check: |test, _| misses(test, Ray { tmin: INFINITY, tmax: 0.0, ..onto_unit() }, UNIT),
    },
    Case {
        name: "T3",
        what: "tmin = −0 is zero",
        check: |test, _| {
            let touching = ray([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
            hits(test, touching, UNIT)?;
            hits(test, Ray { tmin: MINUS_ZERO, ..touching }, UNIT).map(|_| ())
        },
    },
    Case {
        name: "T4",
        what: "an empty interval, and a triangle behind the ray",
        check: |test, _| {
            misses(test, Ray { tmin: 2.0, tmax: 0.5, ..onto_unit() }, UNIT)?;
            misses(test, ray([0.25, 0.25, 1.0], [0.0, 0.0, 1.0]), UNIT)
        },
    },
    Case {
        name: "N1",
        what: "NaN in the ray",
        check: |test, _| {
            for axis in 0..3 {
                let mut bad = [0.25, 0.25, -1.0];
                bad[axis] = f32::NAN;
                misses(test, ray(bad, [0.0, 0.0, 1.0]), UNIT)?;
                misses(test, ray([0.25, 0.25, -1.0], bad), UNIT)?;
            }
            misses(test, Ray { tmin: f32::NAN, ..onto_unit() }, UNIT)?;
            misses(test, Ray { tmax: f32::NAN, ..onto_unit() }, UNIT)
        },
    },
    Case {
        name: "N2",
        what: "infinities in the ray",
        check: |test, _| {
            for infinity in [INFINITY, -INFINITY] {
                for axis in 0..3 {
                    let mut bad = [0.25, 0.25, -1.0];
                    bad[axis] = infinity;
                    misses(test, ray(bad, [0.0, 0.0, 1.0]), UNIT)?;
                    misses(test, ray([0.25, 0.25, -1.0], bad), UNIT)?;
                }
            }
            Ok(())
        },
    },
    Case {
        name: "N3",
        what: "a NaN in a corner",
        check: |test, _| {
            for place in 0..9 {
                let mut corners = UNIT;
                corners[place / 3][place % 3] = f32::NAN;
                misses(test, onto_unit(), corners)?;
            }
            Ok(())
        },
    },
    Case {
        name: "N5",
        what: "a zero direction misses, and the sign of a zero does not matter",
        check: |test, _| {
            misses(test, ray([0.25, 0.25, -1.0], [0.0; 3]), UNIT)?;
            misses(test, ray([0.25, 0.25, 0.0], [MINUS_ZERO; 3]), UNIT)?;
            let signed = ray([0.25, 0.25, -1.0], [MINUS_ZERO, MINUS_ZERO, 1.0]);
            same(hits(test, signed, UNIT)?, hits(test, onto_unit(), UNIT)?)
        },
    },
    Case {
        name: "D1",
        what: "a triangle that is a line",
        check: |test, _| {
            let near_line = [
                [-1_113.454_6, -79.049_614, -56.243_19],
                [-1_113.454_6, -87.092_27, -56.243_19],
                [-1_113.454_6, -79.209_015, -56.243_19],
            ];
            let mut along =
                ray([-1_081.479_2, 99.999_954, 87.770_11], [-32.107_3, -183.355_87, -144.607_64]);
            along.tmax = 0.9999;
            misses(test, along, near_line)
        },
    },
    Case {
        name: "D2",
        what: "triangles with equal corners",
        check: |test, _| {
            let [a, b, c] = UNIT;
            for corners in [[a, a, c], [a, b, a], [a, b, b], [a, a, a]] {
                misses(test, ray([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]), corners)?;
                misses(test, ray([0.5, 0.0, -1.0], [0.0, 0.0, 1.0]), corners)?;
            }
            Ok(())
        },
    },
    Case {
        name: "D3",
        what: "collinear corners",
        check: |test, _| {
            let line = [[0.0; 3], [1.0, 2.0, 3.0], [2.0, 4.0, 6.0]];
            for o in [[0.1, 0.7, -1.3], [-1.7, 0.3, 0.9], [5.1, -4.3, 2.7]] {
                let o = Vec3::from(o);
                let d = Vec3::new(1.0, 2.0, 3.0) - o;
                misses(test, Ray::<f32>::new(o, d), line)?;
            }
            Ok(())
        },
    },
    Case {
        name: "C1",
        what: "a ray in the plane of the triangle",
        check: |test, _| in_the_plane(test),
    },
    Case {
        name: "S4",
        what: "an edge of 2e-4",
        check: |test, _| {
            let s = 2e-4;
            let corners = [[0.0; 3], [s, 0.0, 0.0], [0.0, s, 0.0]];
            hits(test, ray([s / 3.0, s / 3.0, -1.0], [0.0, 0.0, 1.0]), corners).map(|_| ())
        },
    },
    Case {
        name: "S4-tiny",
        what: "as S4 with an edge of 1e-12, below usual absolute tolerances",
        check: |test, _| {
            let s = 1e-12;
            let corners = [[0.0; 3], [s, 0.0, 0.0], [0.0, s, 0.0]];
            hits(test, ray([s / 3.0, s / 3.0, -1.0], [0.0, 0.0, 1.0]), corners).map(|_| ())
        },
    },
];

/// Runs every case in both forms; those in `known_failures`, and no others, must fail.
///
/// # Panics
/// When a case fails that is not known to, or holds though it is known to fail.
pub fn golden_cases<M: Method>(known_failures: &[&str]) {
    let mut known: BTreeSet<&str> = known_failures.iter().copied().collect();
    let mut wrong = Vec::new();
    for (form, test) in forms::<M, f32>() {
        for Case { name, what, check } in &CASES {
            let id = format!("{name}/{form}");
            match (check(test, given::<M, f32>), known.remove(id.as_str())) {
                (Err(error), false) => wrong.push(format!("{id} ({what}): {error}")),
                (Ok(()), true) => wrong.push(format!("{id} is known to fail, and holds")),
                _ => {}
            }
        }
    }
    wrong.extend(known.into_iter().map(|id| format!("there is no case {id}")));
    assert!(wrong.is_empty(), "{}: {}", M::INFO.name, wrong.join("\n"));
}
