//! What holds across widths, instruction sets, arrangements and divisions.
//!
//! Each lane type times division times arrangement is a kernel that takes a fifth of a second of a
//! processor's time to compile, for 46 methods. The bits are compared for both forms of each method on the
//! native widths, a ray at a time, and with the feature `every-width` for one form on every width and
//! instruction set. The loops
//! of the arrangements, and leaving early, are the same code for every method: they are compared on one
//! width of each precision. `tests/tests/stress.rs` holds every kernel of the catalogue, in all
//! arrangements and on all widths, to the same decisions.

use proptest::prelude::*;
use trisect_core::{FloatFormat, Hit, Precision, Ray, Triangle};
use trisect_kernels::Common;
use trisect_method::{Culling, ReciprocalKind};

use crate::draw::{Pair, check, clear_hits, well_conditioned};
use crate::kernels::{Found, Kernel, Kernels, NOTHING};
use crate::properties::within_claim;
use crate::subject::Subject;
use crate::truth::Truth;

/// Counts of rays and triangles around whole blocks.
const COUNTS: [usize; 5] = [1, 15, 16, 17, 33];

/// Pairs, every fourth aimed at a corner, where decisions hang on the last bit.
fn scene() -> impl Strategy<Value = Vec<Pair>> {
    prop::collection::vec(well_conditioned(-0.2..0.8), 33).prop_map(|mut pairs| {
        for pair in pairs.iter_mut().step_by(4) {
            pair.ray.d = pair.triangle.b - pair.ray.o;
        }
        // NaN and degenerate triangles must be the same everywhere as well.
        pairs[2].ray.o.x = f64::NAN;
        pairs[3].triangle.b = pairs[3].triangle.c;
        pairs
    })
}

/// Gives all rays what they must share.
fn share(rays: &mut [Ray<f64>], needs: Common) {
    // The first ray is finite: one of them is not.
    let first = rays[0];
    for ray in rays {
        if needs.origin {
            ray.o = first.o;
        }
        if needs.direction {
            ray.d = first.d;
        }
    }
}

/// Holds kernels to the bits of the scalar, pair by pair.
fn have_the_scalar_bits(kernels: &Kernels) {
    for kernel in &kernels.list {
        check(2, &scene(), |pairs| {
            let (mut rays, triangles): (Vec<_>, Vec<_>) =
                pairs.iter().map(|pair| (pair.ray, pair.triangle)).unzip();
            share(&mut rays, kernel.needs);
            for culling in [Culling::None, Culling::Back, Culling::Front] {
                for count in COUNTS {
                    let whole = kernel.needs != NOTHING;
                    let rays = &rays[..count];
                    let triangles = if whole { &triangles[..] } else { &triangles[..count] };
                    let mesh =
                        kernels.prepare(triangles).expect("random triangles suit every method");
                    let results = kernel.run(rays, &mesh, culling);
                    let scalar = (kernel.one_by_one)(rays, triangles, culling);
                    let difference = results.difference(&scalar, Found::is_same);
                    prop_assert!(
                        difference.is_none(),
                        "{}, {:?}, {culling:?}: against the scalar {difference:?}",
                        kernels.precision,
                        kernel.kind,
                    );
                }
            }
            Ok(())
        });
    }
}

/// Every width on every instruction set has the bits of the scalar.
pub fn every_width_has_the_scalar_bits(subject: &Subject) {
    for lists in &subject.lists {
        have_the_scalar_bits(&(lists.widths)());
    }
}

/// The native widths have the bits of the scalar in every form; so has one of them without early-out, and
/// in every arrangement.
pub fn every_division_has_the_scalar_bits(subject: &Subject) {
    for lists in &subject.lists {
        for list in [lists.divisions, lists.by_triangle, lists.by_origin, lists.by_direction] {
            have_the_scalar_bits(&list());
        }
    }
}

/// Fused arithmetic and Newton's reciprocal keep the claim about errors, the latter with 4 units
/// more, hit what is hit clearly, and do not hit degenerate triangles.
pub fn fused_and_newton_keep_the_claim(subject: &Subject) {
    for lists in &subject.lists {
        for kernels in [(lists.fused)(), (lists.newton)()] {
            check(8, &prop::collection::vec(clear_hits(), 33), |pairs| {
                for kernel in &kernels.list {
                    let keeps = match kernels.precision {
                        FloatFormat::F32 => keeps_the_claim::<f32>,
                        FloatFormat::F64 => keeps_the_claim::<f64>,
                    };
                    keeps(subject, &kernels, kernel, &pairs)?;
                }
                Ok(())
            });
        }
    }
}

fn keeps_the_claim<E: Precision>(
    subject: &Subject,
    kernels: &Kernels,
    kernel: &Kernel,
    pairs: &[Pair],
) -> Result<(), TestCaseError> {
    // One Newton step from eleven bits leaves a relative error of 4 units or less, its own rounding
    // adds 3; the condition number is at least twice the value.
    let more = match kernel.kind.reciprocal {
        ReciprocalKind::True => 0.0,
        ReciprocalKind::Newton => 4.0,
    };
    let (mut rays, mut triangles): (Vec<_>, Vec<_>) =
        pairs.iter().map(|pair| (pair.ray, pair.triangle)).unzip();
    let clear = rays.len();
    for place in 0..clear {
        // A degenerate triangle, and a ray to the middle of what is left of it.
        let (o, Triangle { a, b, .. }) = (rays[place].o, triangles[place]);
        rays.push(Ray { d: (a + b).scale(0.5) - o, ..rays[place] });
        triangles.push(Triangle { a, b, c: b });
    }
    let mesh = kernels.prepare(&triangles).expect("random triangles suit every method");
    let results = kernel.run(&rays, &mesh, Culling::None);
    let degenerate = results.hits().iter().find(|found| found.triangle as usize >= clear);
    prop_assert!(degenerate.is_none(), "{:?} hits a degenerate one", kernel.kind);
    for (number, pair) in pairs.iter().enumerate() {
        let hit = results.of_ray(number).iter().find(|found| found.triangle as usize == number);
        let Some(Found { hit: Hit { t, beta, gamma }, .. }) = hit else {
            return Err(TestCaseError::fail(format!("{:?} misses a clear hit", kernel.kind)));
        };
        let [t, beta, gamma] = [*t, *beta, *gamma].map(E::from_f64);
        let (ray, triangle) = pair.round::<E>();
        let truth = Truth::of(&ray, &triangle).expect("well conditioned");
        within_claim(subject, &truth, &Hit { t, beta, gamma }, more, kernel.kind)?;
    }
    Ok(())
}
