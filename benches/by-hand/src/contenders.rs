//! All that is timed.

use std::rc::Rc;

use anyhow::Result;
use fearless_simd::x86::{Avx2, Avx512};
use fearless_simd::{f32x8, f32x16};
use trisect_badouel::BadouelCramer;
use trisect_baldwin_weber::BaldwinWeber12;
use trisect_core::{Fused, Lanes, Ray, Vector};
use trisect_kernels::PreparedTriangles;
use trisect_method::{
    Barycentrics, BySigns, Deferred, Division, Early, Method, Occlusion, TrueDivision,
};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_wald::Wald;
use trisect_workloads::Workload;

use crate::isa::{self, Isa};
use crate::loops::{self, Blocks, ByHand, DividesFirst, DividesLast, Form, SameSigns};
use crate::{Comparison, Contender, Tally, Written, kernels};

type Lanes8 = Vector<Avx2, f32x8<Avx2>, Fused>;
type Lanes16 = Vector<Avx512, f32x16<Avx512>, Fused>;

/// Runs a kernel of the project, where the processor has the instructions.
type Kernel<M> = fn(&[Ray<f32>], &PreparedTriangles<M, f32>) -> Option<Tally>;

/// Everything that this processor can run.
pub(crate) fn all<'a>(workload: &'a Workload, all: &mut Vec<Contender<'a>>) -> Result<()> {
    of_method::<MollerTrumbore, 9>(workload, all)?;
    of_method::<Wald, 9>(workload, all)?;
    of_method::<BadouelCramer, 10>(workload, all)?;
    of_method::<BaldwinWeber12, 12>(workload, all)
}

fn of_method<'a, F: ByHand<ROWS>, const ROWS: usize>(
    workload: &'a Workload,
    all: &mut Vec<Contender<'a>>,
) -> Result<()> {
    let Workload { rays, triangles, .. } = workload;
    let scene = Scene::<'_, F, ROWS> {
        rays,
        blocks: Rc::new(loops::prepare::<F, ROWS>(triangles)),
        prepared: Rc::new(PreparedTriangles::new(triangles)?),
    };
    if let Some(i) = isa::Avx2::detect() {
        scene.on::<_, Lanes8>(i, all);
    }
    if let Some(i) = isa::Avx512::detect() {
        scene.on::<_, Lanes16>(i, all);
    }
    #[cfg(feature = "catalogue")]
    crate::catalogue::of_method(F::Method::INFO.name, workload, all)?;
    Ok(())
}

/// What all contenders of a method are timed on.
struct Scene<'a, F: ByHand<ROWS>, const ROWS: usize> {
    rays: &'a [Ray<f32>],
    blocks: Rc<Blocks<ROWS>>,
    prepared: Rc<PreparedTriangles<F::Method, f32>>,
}

impl<'a, F: ByHand<ROWS>, const ROWS: usize> Scene<'a, F, ROWS> {
    fn on<I: Isa, L: Lanes<Elem = f32>>(&self, i: I, all: &mut Vec<Contender<'a>>) {
        self.division::<I, L, DividesFirst, Early<TrueDivision, false>, Early<TrueDivision, true>>(
            i, "early", all,
        );
        self.division::<
            I,
            L,
            DividesLast<true>,
            Deferred<TrueDivision, false>,
            Deferred<TrueDivision, true>,
        >(i, "deferred", all);
        self.by_hand::<I, DividesLast<false>>(i, "deferred", Written::Bare, all);
        self.division::<
            I,
            L,
            SameSigns<true>,
            BySigns<TrueDivision, false>,
            BySigns<TrueDivision, true>,
        >(i, "signs", all);
        self.by_hand::<I, SameSigns<false>>(i, "signs", Written::Bare, all);
    }

    /// One form of the division; `D` without early-out, and `E` with it.
    fn division<I: Isa, L: Lanes<Elem = f32>, T: Form, D: Division, E: Division>(
        &self,
        i: I,
        division: &'static str,
        all: &mut Vec<Contender<'a>>,
    ) {
        self.by_hand::<I, T>(i, division, Written::ByHand, all);
        let mut push = |asked, run: Kernel<F::Method>| {
            let (rays, prepared) = (self.rays, Rc::clone(&self.prepared));
            all.push(Contender::new(
                Comparison { method: F::Method::INFO.name, lanes: I::NAME, asked, division },
                Written::Directly,
                move || run(rays, &prepared).unwrap_or_default(),
            ));
        };
        push("occlusion", kernels::count::<F::Method, L, D, Occlusion>);
        push("values", kernels::count::<F::Method, L, D, Barycentrics>);
        push("closest", kernels::closest::<F::Method, L, E>);
    }

    fn by_hand<I: Isa, T: Form>(
        &self,
        i: I,
        division: &'static str,
        written: Written,
        all: &mut Vec<Contender<'a>>,
    ) {
        let mut push = |asked, run: fn(I, &[Ray<f32>], &Blocks<ROWS>) -> Tally| {
            let (rays, blocks) = (self.rays, Rc::clone(&self.blocks));
            all.push(Contender::new(
                Comparison { method: F::Method::INFO.name, lanes: I::NAME, asked, division },
                written,
                move || run(i, rays, &blocks),
            ));
        };
        push("occlusion", |i, rays, blocks| {
            loops::run::<F, T, I, _, ROWS>(i, loops::Occlusion::new, rays, blocks)
        });
        push("values", |i, rays, blocks| {
            loops::run::<F, T, I, _, ROWS>(i, loops::Values::new, rays, blocks)
        });
        push("closest", |i, rays, blocks| {
            loops::run::<F, T, I, _, ROWS>(i, loops::Closest::new, rays, blocks)
        });
    }
}
