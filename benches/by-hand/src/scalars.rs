//! The forms of one scalar test, one pair at a time, of the methods that Havel timed: what moving the division
//! gains where tests end early, and what testing `t` first does.

use std::rc::Rc;

use anyhow::Result;
use trisect_badouel::BadouelCramer;
use trisect_keidy::Keidy;
use trisect_kensler_shirley::KenslerShirley;
use trisect_kernels::PreparedTriangles;
use trisect_method::{Barycentrics, BySigns, Deferred, Division, Early, Method, TrueDivision};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_perpendicular_planes::PerpendicularPlanes;
use trisect_shevtsov::Shevtsov;
use trisect_wald::Wald;
use trisect_workloads::Workload;

use crate::{Comparison, Contender, Written, kernels};

/// The tests of all his methods.
pub(crate) fn all<'a>(workload: &'a Workload, all: &mut Vec<Contender<'a>>) -> Result<()> {
    of_method::<MollerTrumbore>(workload, all)?;
    of_method::<KenslerShirley>(workload, all)?;
    of_method::<Shevtsov>(workload, all)?;
    of_method::<BadouelCramer>(workload, all)?;
    of_method::<Wald>(workload, all)?;
    of_method::<Keidy>(workload, all)?;
    of_method::<PerpendicularPlanes>(workload, all)
}

fn of_method<'a, M: Method>(workload: &'a Workload, all: &mut Vec<Contender<'a>>) -> Result<()> {
    let prepared = Rc::new(PreparedTriangles::<M, f32>::new(&workload.triangles)?);
    if const { M::INFO.forms.early() } {
        test::<M, Early<TrueDivision, true>>(workload, &prepared, "early", all);
        test::<M, Early<TrueDivision, false>>(workload, &prepared, "early, no exits", all);
    }
    if const { M::INFO.forms.deferred() } {
        test::<M, Deferred<TrueDivision, true>>(workload, &prepared, "deferred", all);
        test::<M, Deferred<TrueDivision, true, true>>(
            workload,
            &prepared,
            "deferred, t first",
            all,
        );
        test::<M, Deferred<TrueDivision, false>>(workload, &prepared, "deferred, no exits", all);
        test::<M, BySigns<TrueDivision, true>>(workload, &prepared, "signs, t first", all);
        test::<M, BySigns<TrueDivision, false>>(workload, &prepared, "signs, no exits", all);
    }
    Ok(())
}

fn test<'a, M: Method, D: Division>(
    workload: &'a Workload,
    prepared: &Rc<PreparedTriangles<M, f32>>,
    division: &'static str,
    all: &mut Vec<Contender<'a>>,
) {
    let prepared = Rc::clone(prepared);
    let method = M::INFO.name;
    all.push(Contender::new(
        Comparison { method, lanes: "f32 scalar", asked: "values", division },
        Written::Directly,
        move || {
            kernels::count::<M, f32, D, Barycentrics>(&workload.rays, &prepared).unwrap_or_default()
        },
    ));
}
