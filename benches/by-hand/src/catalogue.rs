//! The same kernels as the catalogue has them.

use std::rc::Rc;

use anyhow::{Context, Result};
use trisect_catalog::{Kernel, find};
use trisect_core::{InstructionSet, MultiplyAdd};
use trisect_kernels::Arrangement;
use trisect_method::{Output, ReciprocalKind};
use trisect_workloads::Workload;

use crate::isa::{Avx2, Avx512, Isa};
use crate::{Comparison, Contender, Tally, Written};

/// Adds the kernels of a method that there are loops by hand of.
pub(crate) fn of_method(
    method: &'static str,
    workload: &Workload,
    all: &mut Vec<Contender<'_>>,
) -> Result<()> {
    let entry = find(method).context("the catalogue has the method")?;
    let scene = Rc::new((entry.f32.prepare)(&workload.triangles, &workload.rays)?);
    for kernel in entry.f32.timed.iter().filter(|kernel| kernel.variant.is_available()) {
        let Some(comparison) = comparison(method, kernel) else { continue };
        let scene = Rc::clone(&scene);
        all.push(Contender::new(comparison, Written::Catalogue, move || {
            let trisect_catalog::Tally { hits, sum } = kernel.run(&scene);
            Tally { hits, sum }
        }));
    }
    Ok(())
}

fn comparison(method: &'static str, kernel: &Kernel) -> Option<Comparison> {
    let variant = &kernel.variant;
    let alike = variant.arithmetic == MultiplyAdd::Fused
        && variant.arrangement == Arrangement::OneRay
        && variant.reciprocal == ReciprocalKind::True
        && !variant.early_out;
    let lanes = match (variant.width, variant.instruction_set) {
        (8, InstructionSet::Avx2) => Avx2::NAME,
        (16, InstructionSet::Avx512) => Avx512::NAME,
        _ => return None,
    };
    let asked = match variant.needs {
        Output::Occlusion => "occlusion",
        Output::Barycentrics => "values",
        _ => return None,
    };
    alike.then(|| Comparison { method, lanes, asked, division: variant.division.name() })
}
