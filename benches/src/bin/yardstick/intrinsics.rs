//! Möller–Trumbore in hand-written intrinsics: what a kernel of the catalogue costs beyond the
//! instructions that the formula needs.
//!
//! One ray against blocks of sixteen triangles, fused multiply-add, division deferred, hits
//! counted and `t + beta + gamma` of each hit summed: the formula, the tests and the answers of
//! the catalogue's `deferred` kernel, so that the two differ in how they were written alone.
#![allow(unsafe_code, reason = "loads through pointers, and calls of functions with features")]

use std::arch::x86_64::{
    __m256, __m512, _CMP_GE_OQ, _CMP_LE_OQ, _mm256_add_ps, _mm256_and_ps, _mm256_cmp_ps,
    _mm256_div_ps, _mm256_fmadd_ps, _mm256_fmsub_ps, _mm256_load_ps, _mm256_movemask_ps,
    _mm256_mul_ps, _mm256_set1_ps, _mm256_setzero_ps, _mm256_storeu_ps, _mm256_sub_ps,
    _mm256_xor_ps, _mm512_abs_ps, _mm512_add_ps, _mm512_castps_si512, _mm512_castsi512_ps,
    _mm512_cmp_ps_mask, _mm512_div_ps, _mm512_fmadd_ps, _mm512_fmsub_ps, _mm512_load_ps,
    _mm512_mask_add_ps, _mm512_mask_cmp_ps_mask, _mm512_mul_ps, _mm512_reduce_add_ps,
    _mm512_set1_epi32, _mm512_set1_ps, _mm512_setzero_ps, _mm512_sub_ps, _mm512_ternarylogic_epi32,
};

use trisect_catalog::Tally;
use trisect_core::{InstructionSet, Ray, Scalar, Triangle};
use trisect_kernels::BLOCK;
use trisect_method::Interval;

/// Sixteen triangles: a corner and two edges, coordinate by coordinate.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Block([[f32; BLOCK]; 9]);

/// Prepares triangles as the catalogue's kernels do; places without a triangle have no edges,
/// and so never hit.
pub(crate) fn prepare(triangles: &[Triangle<f32>]) -> Vec<Block> {
    triangles
        .chunks(BLOCK)
        .map(|chunk| {
            let mut block = Block([[0.0; BLOCK]; 9]);
            for (lane, triangle) in chunk.iter().enumerate() {
                if triangle.is_degenerate() {
                    continue;
                }
                let a = triangle.a;
                for (vector, v) in [a, triangle.b - a, triangle.c - a].into_iter().enumerate() {
                    for (axis, x) in v.to_array().into_iter().enumerate() {
                        block.0[3 * vector + axis][lane] = x;
                    }
                }
            }
            block
        })
        .collect()
}

/// A loop of intrinsics over every ray and every triangle.
#[derive(Clone, Copy)]
pub(crate) struct Loop {
    /// The instructions it is written in.
    pub instruction_set: InstructionSet,
    /// Lanes of a vector.
    pub width: usize,
    /// Whether a test ends as soon as no lane can hit.
    pub early_out: bool,
    run: fn(&[Ray<f32>], &[Block]) -> Tally,
}

impl Loop {
    /// Tests every ray against every triangle.
    pub(crate) fn run(&self, rays: &[Ray<f32>], blocks: &[Block]) -> Tally {
        (self.run)(rays, blocks)
    }
}

/// The loops that this processor can run.
pub(crate) fn loops() -> Vec<Loop> {
    let mut loops = Vec::new();
    if has_avx2() {
        let of = |early_out, run| Loop {
            instruction_set: InstructionSet::Avx2,
            width: 8,
            early_out,
            run,
        };
        loops.extend([of(true, run_avx2::<true>), of(false, run_avx2::<false>)]);
    }
    if has_avx512() {
        let of = |early_out, run| Loop {
            instruction_set: InstructionSet::Avx512,
            width: 16,
            early_out,
            run,
        };
        loops.extend([of(true, run_avx512::<true>), of(false, run_avx512::<false>)]);
    }
    loops
}

fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("popcnt")
}

fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("popcnt")
}

fn run_avx2<const EARLY_OUT: bool>(rays: &[Ray<f32>], blocks: &[Block]) -> Tally {
    assert!(has_avx2(), "the processor has the instructions of the loop");
    // SAFETY: the processor has the features, as was just asserted.
    unsafe { avx2::<EARLY_OUT>(rays, blocks) }
}

fn run_avx512<const EARLY_OUT: bool>(rays: &[Ray<f32>], blocks: &[Block]) -> Tally {
    assert!(has_avx512(), "the processor has the instructions of the loop");
    // SAFETY: the processor has the features, as was just asserted.
    unsafe { avx512::<EARLY_OUT>(rays, blocks) }
}

#[target_feature(enable = "avx2,fma,popcnt")]
fn avx2<const EARLY_OUT: bool>(rays: &[Ray<f32>], blocks: &[Block]) -> Tally {
    const WIDTH: usize = 8;
    const BLOCK_BYTES: usize = size_of::<Block>();
    /// From a lower half to its upper one, and from there to the next block's lower one.
    const STEPS: [usize; 2] = [WIDTH * 4, BLOCK_BYTES - WIDTH * 4];
    let zero = _mm256_setzero_ps();
    let sign_bit = _mm256_set1_ps(-0.0);
    let smallest = _mm256_set1_ps(f32::smallest_det());
    let largest = _mm256_set1_ps(f32::largest_t());
    let one = _mm256_set1_ps(1.0);
    let mut hits = 0;
    let mut sum = zero;
    for ray in rays {
        let [ox, oy, oz] = ray.o.to_array().map(|x| _mm256_set1_ps(x));
        let [dx, dy, dz] = ray.d.to_array().map(|x| _mm256_set1_ps(x));
        let interval = Interval::new(ray.tmin, ray.tmax);
        let (tmin, tmax) = (_mm256_set1_ps(interval.tmin), _mm256_set1_ps(interval.tmax));
        // One loop over half blocks: two nested ones are unrolled until they spill. Steps in place of
        // a half's number save its division into block and start.
        let mut offset = 0;
        let mut step = STEPS[0];
        while offset < size_of_val(blocks) {
            let half = blocks.as_ptr().cast::<u8>().wrapping_add(offset);
            offset += step;
            step ^= STEPS[0] ^ STEPS[1];
            let row = |number: usize| -> __m256 {
                // SAFETY: the offset stands at the first or the ninth number of a block among
                // `blocks`, so eight numbers of the row follow, whose rows begin every 64 bytes of a
                // block that is aligned to 64.
                unsafe { _mm256_load_ps(half.add(number * size_of::<[f32; BLOCK]>()).cast()) }
            };
            // p = d × e2, det = e1 · p
            let (e2x, e2y, e2z) = (row(6), row(7), row(8));
            let px = _mm256_fmsub_ps(dy, e2z, _mm256_mul_ps(dz, e2y));
            let py = _mm256_fmsub_ps(dz, e2x, _mm256_mul_ps(dx, e2z));
            let pz = _mm256_fmsub_ps(dx, e2y, _mm256_mul_ps(dy, e2x));
            let (e1x, e1y, e1z) = (row(3), row(4), row(5));
            let det = _mm256_fmadd_ps(e1x, px, _mm256_fmadd_ps(e1y, py, _mm256_mul_ps(e1z, pz)));
            // s = o − a, beta' = s · p
            let sx = _mm256_sub_ps(ox, row(0));
            let sy = _mm256_sub_ps(oy, row(1));
            let sz = _mm256_sub_ps(oz, row(2));
            let beta = _mm256_fmadd_ps(sx, px, _mm256_fmadd_ps(sy, py, _mm256_mul_ps(sz, pz)));
            // q = s × e1, gamma' = d · q, t' = e2 · q
            let qx = _mm256_fmsub_ps(sy, e1z, _mm256_mul_ps(sz, e1y));
            let qy = _mm256_fmsub_ps(sz, e1x, _mm256_mul_ps(sx, e1z));
            let qz = _mm256_fmsub_ps(sx, e1y, _mm256_mul_ps(sy, e1x));
            let gamma = _mm256_fmadd_ps(dx, qx, _mm256_fmadd_ps(dy, qy, _mm256_mul_ps(dz, qz)));
            let t = _mm256_fmadd_ps(e2x, qx, _mm256_fmadd_ps(e2y, qy, _mm256_mul_ps(e2z, qz)));

            let sign = _mm256_and_ps(det, sign_bit);
            let det = _mm256_xor_ps(det, sign);
            let beta = _mm256_xor_ps(beta, sign);
            let gamma = _mm256_xor_ps(gamma, sign);
            let t = _mm256_xor_ps(t, sign);
            let mask = and4(
                _mm256_cmp_ps::<_CMP_GE_OQ>(beta, zero),
                _mm256_cmp_ps::<_CMP_GE_OQ>(gamma, zero),
                _mm256_cmp_ps::<_CMP_LE_OQ>(_mm256_add_ps(beta, gamma), det),
                _mm256_cmp_ps::<_CMP_GE_OQ>(det, smallest),
            );
            if EARLY_OUT && _mm256_movemask_ps(mask) == 0 {
                continue;
            }
            let mask = and4(
                mask,
                _mm256_cmp_ps::<_CMP_LE_OQ>(_mm256_fmsub_ps(tmin, det, t), zero),
                _mm256_cmp_ps::<_CMP_GE_OQ>(_mm256_fmsub_ps(tmax, det, t), zero),
                _mm256_cmp_ps::<_CMP_LE_OQ>(det, largest),
            );
            let bits = _mm256_movemask_ps(mask);
            if EARLY_OUT && bits == 0 {
                continue;
            }
            let r = _mm256_div_ps(one, det);
            let asked = _mm256_add_ps(
                _mm256_mul_ps(t, r),
                _mm256_add_ps(_mm256_mul_ps(beta, r), _mm256_mul_ps(gamma, r)),
            );
            hits += u64::from(bits.count_ones());
            sum = _mm256_add_ps(sum, _mm256_and_ps(asked, mask));
        }
    }
    let mut sums = [0.0; WIDTH];
    // SAFETY: eight numbers, as many as the vector has; the store asks for no alignment.
    unsafe { _mm256_storeu_ps(sums.as_mut_ptr(), sum) };
    Tally { hits, sum: sums.into_iter().map(f64::from).sum() }
}

#[target_feature(enable = "avx2")]
fn and4(a: __m256, b: __m256, c: __m256, d: __m256) -> __m256 {
    _mm256_and_ps(_mm256_and_ps(a, b), _mm256_and_ps(c, d))
}

#[target_feature(enable = "avx512f,popcnt")]
fn avx512<const EARLY_OUT: bool>(rays: &[Ray<f32>], blocks: &[Block]) -> Tally {
    /// `a` with its sign flipped where `det` is negative: `a ^ (det & sign bit)`.
    const XOR_SIGN: i32 = 0x78;
    let zero = _mm512_setzero_ps();
    let sign_bit = _mm512_set1_epi32(i32::MIN);
    let smallest = _mm512_set1_ps(f32::smallest_det());
    let largest = _mm512_set1_ps(f32::largest_t());
    let one = _mm512_set1_ps(1.0);
    let mut hits = 0;
    let mut sum = zero;
    for ray in rays {
        let [ox, oy, oz] = ray.o.to_array().map(|x| _mm512_set1_ps(x));
        let [dx, dy, dz] = ray.d.to_array().map(|x| _mm512_set1_ps(x));
        let interval = Interval::new(ray.tmin, ray.tmax);
        let (tmin, tmax) = (_mm512_set1_ps(interval.tmin), _mm512_set1_ps(interval.tmax));
        for Block(block) in blocks {
            let row = |number: usize| -> __m512 {
                // SAFETY: a row has sixteen numbers and begins every 64 bytes of a block that is
                // aligned to 64.
                unsafe { _mm512_load_ps(block[number].as_ptr()) }
            };
            // As above.
            let (e2x, e2y, e2z) = (row(6), row(7), row(8));
            let px = _mm512_fmsub_ps(dy, e2z, _mm512_mul_ps(dz, e2y));
            let py = _mm512_fmsub_ps(dz, e2x, _mm512_mul_ps(dx, e2z));
            let pz = _mm512_fmsub_ps(dx, e2y, _mm512_mul_ps(dy, e2x));
            let (e1x, e1y, e1z) = (row(3), row(4), row(5));
            let det = _mm512_fmadd_ps(e1x, px, _mm512_fmadd_ps(e1y, py, _mm512_mul_ps(e1z, pz)));
            let sx = _mm512_sub_ps(ox, row(0));
            let sy = _mm512_sub_ps(oy, row(1));
            let sz = _mm512_sub_ps(oz, row(2));
            let beta = _mm512_fmadd_ps(sx, px, _mm512_fmadd_ps(sy, py, _mm512_mul_ps(sz, pz)));
            let qx = _mm512_fmsub_ps(sy, e1z, _mm512_mul_ps(sz, e1y));
            let qy = _mm512_fmsub_ps(sz, e1x, _mm512_mul_ps(sx, e1z));
            let qz = _mm512_fmsub_ps(sx, e1y, _mm512_mul_ps(sy, e1x));
            let gamma = _mm512_fmadd_ps(dx, qx, _mm512_fmadd_ps(dy, qy, _mm512_mul_ps(dz, qz)));
            let t = _mm512_fmadd_ps(e2x, qx, _mm512_fmadd_ps(e2y, qy, _mm512_mul_ps(e2z, qz)));

            let xor_sign = |a: __m512| {
                let (a, det) = (_mm512_castps_si512(a), _mm512_castps_si512(det));
                _mm512_castsi512_ps(_mm512_ternarylogic_epi32::<XOR_SIGN>(a, det, sign_bit))
            };
            let (beta, gamma, t) = (xor_sign(beta), xor_sign(gamma), xor_sign(t));
            let det = _mm512_abs_ps(det);
            let mask = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(beta, zero);
            let mask = _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(mask, gamma, zero);
            let edge = _mm512_add_ps(beta, gamma);
            let mask = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(mask, edge, det);
            let mask = _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(mask, det, smallest);
            if EARLY_OUT && mask == 0 {
                continue;
            }
            let after = _mm512_fmsub_ps(tmin, det, t);
            let before = _mm512_fmsub_ps(tmax, det, t);
            let mask = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(mask, after, zero);
            let mask = _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(mask, before, zero);
            let mask = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(mask, det, largest);
            if EARLY_OUT && mask == 0 {
                continue;
            }
            let r = _mm512_div_ps(one, det);
            let asked = _mm512_add_ps(
                _mm512_mul_ps(t, r),
                _mm512_add_ps(_mm512_mul_ps(beta, r), _mm512_mul_ps(gamma, r)),
            );
            hits += u64::from(mask.count_ones());
            sum = _mm512_mask_add_ps(sum, mask, sum, asked);
        }
    }
    Tally { hits, sum: f64::from(_mm512_reduce_add_ps(sum)) }
}
