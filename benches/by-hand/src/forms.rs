//! The forms of one test, of the methods that Havel timed: what moving the division gains where tests end early, what
//! testing `t` first does, and what signs gain over comparisons.

use std::rc::Rc;

use anyhow::{Result, ensure};
#[cfg(target_arch = "x86_64")]
use fearless_simd::x86::{Avx2, Avx512, Sse4_2};
#[cfg(target_arch = "x86_64")]
use fearless_simd::{f32x4, f32x8, f32x16};
use trisect_badouel::BadouelCramer;
#[cfg(target_arch = "x86_64")]
use trisect_core::{Fused, Plain, Vector};
use trisect_core::{Lanes, MultiplyAdd, Token};
use trisect_havel_herout::HavelHerout;
use trisect_keidy::Keidy;
use trisect_kensler_shirley::{KenslerShirley, Points};
use trisect_kernels::Arrangement::{self, OneRay, OneTriangle};
use trisect_kernels::{Packets, PreparedTriangles};
use trisect_machine::forms::{FormTime, FormVariant, TestForm};
use trisect_method::{
    BySigns, Deferred, Division, Early, Method, Newton, Reciprocal, TrueDivision,
};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_perpendicular_planes::PerpendicularPlanes;
use trisect_shevtsov::Shevtsov;
use trisect_wald::Wald;
use trisect_workloads::{Workload, hit_rate, random};

use crate::record::Record;
use crate::timed::{Timed, in_turn};
use crate::{SEED, SIDE, Tally, kernels};

/// How often every ray meets every triangle in a sample.
const REPEATS: u32 = 4;

/// Percent of the tests that hit where most do, and where hardly any does.
const SHARES: [u32; 2] = [90, 2];

/// Times every form whose name contains `only`.
pub(crate) fn time(record: &mut Record, only: &str, compiler: &str) -> Result<()> {
    let mut workloads = vec![random(SEED, SIDE, SIDE)];
    workloads.extend(SHARES.map(|percent| hit_rate(SEED, percent, SIDE, SIDE)));
    let mut all = Vec::new();
    for workload in &workloads {
        let mut of_workload = Forms { workload, only, compiler, all: Vec::new() };
        of_workload.every_method()?;
        all.extend(of_workload.all);
    }
    agree(&all)?;
    in_turn(&mut all, record.rounds, &mut record.meter)?;
    for Timed { what, samples_ns, found, .. } in all {
        let hits = found.hits * u64::from(REPEATS);
        record.add("form", &FormTime { hits, samples_ns, ..what })?;
    }
    Ok(())
}

/// Whether all forms of a method find the same, but for pairs so near to an edge that rounding decides: one in ten
/// thousand.
fn agree(all: &[Timed<'_, FormTime>]) -> Result<()> {
    let pairs = (SIDE * SIDE) as u64;
    for timed in all {
        let is_like = |other: &&Timed<'_, FormTime>| {
            other.what.variant.method == timed.what.variant.method
                && other.what.workload == timed.what.workload
        };
        let Some(first) = all.iter().find(is_like) else { continue };
        let differ = first.found.hits.abs_diff(timed.found.hits);
        ensure!(differ <= pairs / 10_000, "{:?} and {:?}: {differ} hits", first.what, timed.what);
    }
    Ok(())
}

/// The forms on one workload.
struct Forms<'a> {
    workload: &'a Workload,
    only: &'a str,
    compiler: &'a str,
    all: Vec<Timed<'a, FormTime>>,
}

/// A method's triangles, and the rays in packets as it takes them.
struct Prepared<M: Method> {
    triangles: PreparedTriangles<M, f32>,
    packets: Packets<f32>,
}

impl<'a> Forms<'a> {
    fn every_method(&mut self) -> Result<()> {
        self.of_method::<MollerTrumbore>()?;
        self.of_method::<KenslerShirley<Points>>()?;
        self.of_method::<Keidy>()?;
        self.of_method::<BadouelCramer>()?;
        self.of_method::<Wald>()?;
        self.of_method::<Shevtsov>()?;
        self.of_method::<PerpendicularPlanes>()?;
        self.of_method::<HavelHerout>()
    }

    fn of_method<M: Method>(&mut self) -> Result<()> {
        let Workload { rays, triangles, .. } = self.workload;
        let triangles = PreparedTriangles::<M, f32>::new(triangles)?;
        let prepared = Rc::new(Prepared { triangles, packets: Packets::new::<M>(rays) });
        self.on_lanes::<M, f32>(&prepared);
        #[cfg(target_arch = "x86_64")]
        {
            self.on_lanes::<M, Vector<Sse4_2, f32x4<Sse4_2>, Plain>>(&prepared);
            self.on_lanes::<M, Vector<Avx2, f32x8<Avx2>, Fused>>(&prepared);
            self.on_lanes::<M, Vector<Avx512, f32x16<Avx512>, Fused>>(&prepared);
        }
        Ok(())
    }

    fn on_lanes<M: Method, L: Lanes<Elem = f32>>(&mut self, of: &Rc<Prepared<M>>) {
        if L::Token::detect().is_none() {
            return;
        }
        if const { M::INFO.forms.early() } {
            self.form::<M, L, Early<TrueDivision, true>>(of, TestForm::Early);
            self.form::<M, L, Early<TrueDivision, false>>(of, TestForm::Early);
            if const { L::N > 1 } {
                self.form::<M, L, Early<Newton, false>>(of, TestForm::Early);
            }
        }
        if const { M::INFO.forms.deferred() } {
            self.form::<M, L, Deferred<TrueDivision, true>>(of, TestForm::Deferred);
            self.form::<M, L, Deferred<TrueDivision, false>>(of, TestForm::Deferred);
            // Lanes end in one place, behind all tests: none is first.
            if const { L::N == 1 } {
                self.form::<M, L, Deferred<TrueDivision, true, true>>(of, TestForm::TFirst);
            }
            self.form::<M, L, BySigns<TrueDivision, true>>(of, TestForm::Signs);
            self.form::<M, L, BySigns<TrueDivision, false>>(of, TestForm::Signs);
        }
    }

    fn form<M: Method, L: Lanes<Elem = f32>, D: Division>(
        &mut self,
        of: &Rc<Prepared<M>>,
        form: TestForm,
    ) {
        let (workload, prepared) = (self.workload, Rc::clone(of));
        self.add::<M, L, D>(form, OneRay, move || {
            kernels::values::<M, L, D>(&workload.rays, &prepared.triangles).unwrap_or_default()
        });
        if const { L::N > 1 } {
            let prepared = Rc::clone(of);
            self.add::<M, L, D>(form, OneTriangle, move || {
                let Prepared { triangles, packets } = &*prepared;
                kernels::values_of_packets::<M, L, D>(packets, triangles).unwrap_or_default()
            });
        }
    }

    fn add<M: Method, L: Lanes<Elem = f32>, D: Division>(
        &mut self,
        form: TestForm,
        arrangement: Arrangement,
        run: impl Fn() -> Tally + 'a,
    ) {
        let variant = FormVariant {
            method: M::INFO.name.to_owned(),
            width: L::N,
            instruction_set: L::Token::INSTRUCTION_SET,
            arithmetic: if L::FUSED { MultiplyAdd::Fused } else { MultiplyAdd::Plain },
            arrangement,
            form,
            reciprocal: D::Reciprocal::KIND,
            early_out: D::EARLY_OUT,
        };
        let what = FormTime {
            variant,
            compiler: self.compiler.to_owned(),
            workload: self.workload.name.clone(),
            tests: (SIDE * SIDE) as u64 * u64::from(REPEATS),
            hits: 0,
            samples_ns: Vec::new(),
        };
        if what.to_string().contains(self.only) {
            self.all.push(Timed::new(what, REPEATS, run));
        }
    }
}
