//! `trisect verify`: every method against the oracle.

use std::io::{self, Write};

use anyhow::Result;
use trisect_core::MultiplyAdd;
use trisect_method::ReciprocalKind;
use trisect_studies::comparison::{
    Agreement, Decisions, Error, Quantiles, Workload, compare, verification,
};
use trisect_studies::record::{Records, Variant};
use trisect_studies::{Taken, input};

use crate::arguments::Verify;
use crate::progress::Bar;
use crate::studies::{command, say};
use crate::{output, reading};

pub(crate) fn run(arguments: &Verify) -> Result<()> {
    const MEND: &str = "kernels in f32 are judged by where they move to";
    let seed = arguments.subjects.seed;
    let methods = input::methods(&arguments.subjects.methods)?;
    let meshes = arguments.subjects.meshes(Vec::new, MEND, &say)?;
    let rays = match &arguments.rays {
        Some(path) => {
            let rays = reading::load_rays(path, &arguments.subjects.reading)?;
            reading::some_rays(&rays, path)?;
            Some(rays)
        }
        None => None,
    };
    let tasks = verification(seed, &meshes, rays.as_ref());
    // Nothing is timed.
    let taken = Taken { command: command(), seed, rounds: 0 };
    let records = taken.record(&mut Bar::new(), |run| compare(&methods, (seed, 0), tasks, run))?;
    output::print(|out| if arguments.json { records.write(out) } else { table(&records, out) })
}

/// The confusion table and the errors of t, workload by workload.
fn table(records: &Records, out: &mut dyn Write) -> io::Result<()> {
    let mut first = true;
    let mut heading = None;
    for line in &records.lines {
        if let Some(workload) = line.get::<Workload>() {
            if !std::mem::take(&mut first) {
                writeln!(out)?;
            }
            writeln!(
                out,
                "{}: {}\n{} rays, {} triangles, {:.3} % of the pairs hit\n\
                     exact arithmetic for {} of {} pairs\n",
                workload.name,
                workload.description,
                workload.rays,
                workload.triangles,
                workload.hit_rate * 100.0,
                workload.oracle_exact,
                workload.oracle_tests,
            )?;
            writeln!(out, "{:<32} {:>7} {:>7}   relative error of t", "", "false", "false")?;
            writeln!(
                out,
                "{:<32} {:>7} {:>7} {:>8} {:>8} {:>8}",
                "", "hits", "misses", "median", "p99", "max"
            )?;
            heading = None;
        } else if let Some(decisions) = line.get::<Decisions>() {
            let errors = records.all().find(|error| of_t(error, decisions));
            let (false_hits, false_misses) = wrong(decisions);
            if heading != Some(&decisions.variant.method) {
                heading = Some(&decisions.variant.method);
                writeln!(out, "{}", decisions.variant.method)?;
            }
            let label = label(&decisions.variant);
            write!(out, "  {label:<30} {false_hits:>7} {false_misses:>7}")?;
            let numbers: [fn(&Quantiles) -> f64; 3] = [|q| q.median, |q| q.p99, |q| q.max];
            for number in numbers {
                let number = errors.map_or_else(String::new, |error| shown(error, number));
                write!(out, " {number:>8}")?;
            }
            writeln!(out)?;
        } else if let Some(agreement) = line.get::<Agreement>() {
            writeln!(
                out,
                "\n{}: all methods pick the same closest triangle for {} of {} rays",
                agreement.precision, agreement.unanimous, agreement.rays
            )?;
            for differs in &agreement.differs_from_oracle {
                writeln!(
                    out,
                    "  {:<30} differs from the oracle on {}",
                    differs.method, differs.count
                )?;
            }
        }
    }
    Ok(())
}

/// Whether an error is the one of `t` against the oracle, of the variant whose decisions these are.
fn of_t(error: &Error, decisions: &Decisions) -> bool {
    error.quantity == "t"
        && error.reference == "oracle"
        && error.workload == decisions.workload
        && error.variant == decisions.variant
}

/// One of the errors; a dash where there was nothing to compare.
fn shown(error: &Error, of: fn(&Quantiles) -> f64) -> String {
    match of(&error.relative) {
        _ if error.count == 0 => "–".to_owned(),
        0.0 => "0".to_owned(),
        x => format!("{x:.1e}"),
    }
}

/// False hits and false misses.
fn wrong(decisions: &Decisions) -> (u64, u64) {
    let hits = decisions.classes.iter().filter(|row| !row.is_hit).map(|row| row.called_hit).sum();
    let misses = decisions.classes.iter().filter(|row| row.is_hit).map(|row| row.called_miss).sum();
    (hits, misses)
}

/// Precision, width, arithmetic and division in 30 columns.
fn label(variant: &Variant) -> String {
    let newton = match variant.reciprocal {
        ReciprocalKind::True => "",
        ReciprocalKind::Newton => " newton",
    };
    format!(
        "{}×{}{} {}{newton}",
        variant.precision,
        variant.width,
        match variant.arithmetic {
            MultiplyAdd::Plain => "",
            MultiplyAdd::Fused => " fused",
        },
        variant.division,
    )
}
