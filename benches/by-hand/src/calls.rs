//! What calls cost that the compiler cannot see through, against the size of the array that is looped over: one for each
//! test, for each block of eight, for each array, or none.

use std::hint::black_box;
use std::rc::Rc;

use anyhow::Result;
use fearless_simd::x86::Avx2;
use trisect_core::{Lanes, Ray, Token};
use trisect_kernels::BLOCK;
use trisect_machine::forms::{CallTime, Called};
use trisect_method::{Culling, Deferred, Interval, Method, Of, Record as _, TrueDivision, rows};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_workloads::{Workload, random};

use crate::leaves::Wide;
use crate::record::Record;
use crate::timed::{Timed, in_turn};
use crate::{SEED, Tally};

type Shape = <MollerTrumbore as Method>::Prepared;
type Prepared<L> = Of<Shape, L>;
type Test<'a, L> = &'a dyn Fn(&Ray<L>, Interval<L>, &Prepared<L>) -> u32;
type OfArray<'a, L> = &'a dyn Fn(&Ray<L>, Interval<L>, &[Prepared<L>]) -> u32;

/// Rays, and tests of a sample.
const RAYS: usize = 64;
const TESTS: usize = 1 << 18;

/// Triangles of the arrays: from half a block to more than the first cache holds.
const SIZES: [usize; 6] = [4, 16, 64, 256, 1024, 4096];

/// Times calls, where the processor has the instructions.
pub(crate) fn time(record: &mut Record) -> Result<()> {
    let Some(wide) = Avx2::detect() else { return Ok(()) };
    let workloads = SIZES.map(|size| random(SEED, RAYS, size));
    let mut all = Vec::new();
    for workload in &workloads {
        loops::<f32>((), workload, &mut all);
        loops::<Wide>(wide, workload, &mut all);
    }
    in_turn(&mut all, record.rounds, &mut record.meter)?;
    for Timed { what, samples_ns, found, .. } in all {
        let hits = found.hits * (what.tests / (RAYS * what.triangles) as u64);
        record.add("call", &CallTime { hits, samples_ns, ..what })?;
    }
    Ok(())
}

#[inline(always)]
fn hits<L: Lanes>(ray: &Ray<L>, interval: Interval<L>, triangle: &Prepared<L>) -> u32 {
    let mut bits = 0;
    MollerTrumbore::test::<L, Deferred<TrueDivision, true>>(
        ray,
        triangle,
        interval,
        Culling::None,
        #[inline(always)]
        |mask, _| bits = L::bits(mask),
    );
    bits.count_ones()
}

/// Loops over an array in lanes, each with other calls.
fn loops<'a, L: Lanes<Elem = f32> + 'static>(
    token: L::Token,
    workload: &'a Workload,
    all: &mut Vec<Timed<'a, CallTime>>,
) {
    let triangles = &workload.triangles;
    let array: Vec<Prepared<L>> = triangles
        .chunks(L::N)
        .map(|chunk| {
            // The last triangle again where there are fewer than lanes: it counts as often in every loop.
            let of_lane =
                |lane: usize| MollerTrumbore::prepare(&chunk[lane.min(chunk.len() - 1)], 0);
            let rows = rows::<Shape, f32, BLOCK>(of_lane);
            Shape::map(&rows, |row: &[f32; BLOCK]| L::load(token, row))
        })
        .collect();
    let array = Rc::new(array);
    for called in [Called::Nothing, Called::Array, Called::Test] {
        let called = if called == Called::Test && L::N > 1 { Called::Block } else { called };
        let tests = RAYS * triangles.len();
        let repeats = (TESTS / tests).max(1);
        let what = CallTime {
            called,
            width: L::N,
            triangles: triangles.len(),
            tests: (tests * repeats) as u64,
            hits: 0,
            samples_ns: Vec::new(),
        };
        let array = Rc::clone(&array);
        let repeats = u32::try_from(repeats).unwrap_or(1);
        all.push(Timed::new(what, repeats, move || Tally {
            hits: trace::<L>(token, called, &workload.rays, &array),
            sum: 0.0,
        }));
    }
}

fn trace<L: Lanes<Elem = f32>>(
    token: L::Token,
    called: Called,
    rays: &[Ray<f32>],
    array: &[Prepared<L>],
) -> u64 {
    let test = |ray: &Ray<L>, interval: Interval<L>, triangle: &Prepared<L>| {
        token.run(
            #[inline(always)]
            || hits(ray, interval, triangle),
        )
    };
    let of_array = |ray: &Ray<L>, interval: Interval<L>, array: &[Prepared<L>]| {
        token.run(
            #[inline(always)]
            || array.iter().map(|triangle| hits(ray, interval, triangle)).sum::<u32>(),
        )
    };
    // Nothing is known any more of what these are.
    let test: Test<'_, L> = black_box(&test);
    let of_array: OfArray<'_, L> = black_box(&of_array);
    token.run(
        #[inline(always)]
        || {
            let mut sum = 0;
            for ray in rays {
                let ray = Ray::<L>::splat(token, ray);
                let interval = Interval::of(&ray);
                sum += u64::from(match called {
                    Called::Nothing => {
                        array.iter().map(|triangle| hits(&ray, interval, triangle)).sum::<u32>()
                    }
                    Called::Array => of_array(&ray, interval, array),
                    Called::Block | Called::Test => {
                        array.iter().map(|triangle| test(&ray, interval, triangle)).sum::<u32>()
                    }
                });
            }
            sum
        },
    )
}
