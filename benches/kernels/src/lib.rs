//! What the benches share: the workloads, and the kernels by name.
#![forbid(unsafe_code)]

use trisect_catalog::{Kernel, Variant};
use trisect_method::ReciprocalKind;
use trisect_workloads::{Workload, bunny, primary, random};

/// The seed of everything random here.
pub const SEED: u64 = 1;

/// Rays, and triangles, of the random workload: enough for a sample, few enough for the caches.
const RANDOM: usize = 512;

/// Side, in pixels, of the picture whose rays meet the bunny: one packet of rays.
const PICTURE: usize = 4;

/// What is timed on: random rays and triangles, and a mesh beyond the first caches.
pub fn workloads() -> [Workload; 2] {
    [random(SEED, RANDOM, RANDOM), primary(&bunny(), PICTURE, PICTURE)]
}

/// A kernel's name, without its method: `f32x8 avx2 fused one-ray deferred early-out barycentrics`.
pub fn kernel_name(kernel: &Kernel) -> String {
    let Variant { precision, width, instruction_set, arithmetic, arrangement, .. } =
        &kernel.variant;
    let Variant { division, reciprocal, early_out, needs, .. } = &kernel.variant;
    let reciprocal = match reciprocal {
        ReciprocalKind::True => "",
        ReciprocalKind::Newton => " newton",
    };
    let early_out = if *early_out { " early-out" } else { "" };
    format!(
        "{precision}x{width} {instruction_set} {arithmetic} {arrangement} {division}{reciprocal}{early_out} {needs}"
    )
}
