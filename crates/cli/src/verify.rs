//! `trisect verify`: every method against the oracle.

use std::io::{self, Write};

use anyhow::Result;
use trisect_harness::Settings;
use trisect_harness::record::{Decisions, Error, Record, Records, Variant};

use crate::arguments::Verify;
use crate::compare::command;
use crate::progress::Bar;
use crate::{output, tasks};

pub(crate) fn run(arguments: &Verify) -> Result<()> {
    let settings = Settings {
        command: command(),
        seed: arguments.subjects.seed,
        rounds: 0,
        methods: tasks::methods(&arguments.subjects.methods)?,
        timed: false,
    };
    let meshes = if arguments.subjects.mesh.is_empty() {
        Vec::new()
    } else {
        tasks::meshes(&arguments.subjects)?
    };
    let rays = match &arguments.rays {
        Some(path) => {
            let rays = tasks::load_rays(path)?;
            tasks::some_rays(&rays, path)?;
            Some(rays)
        }
        None => None,
    };
    let tasks = tasks::verification(&arguments.subjects, &meshes, rays.as_ref());
    let records = trisect_harness::measure(&settings, tasks, &mut Bar::new())?;
    output::print(|out| if arguments.json { records.write(out) } else { table(&records, out) })
}

/// The confusion table and the errors of t, workload by workload.
fn table(records: &Records, out: &mut dyn Write) -> io::Result<()> {
    for line in &records.lines {
        match line {
            Record::Workload(workload) => {
                writeln!(
                    out,
                    "{}: {}\n{} rays, {} triangles, {:.3} % of the pairs hit; exact arithmetic \
                     for {} of {} pairs\n",
                    workload.name,
                    workload.description,
                    workload.rays,
                    workload.triangles,
                    workload.hit_rate * 100.0,
                    workload.oracle_exact,
                    workload.oracle_tests,
                )?;
                writeln!(
                    out,
                    "{:<38} {:>6} {:>6} {:>8} {:>8} {:>8}",
                    "", "false", "false", "error", "of t", ""
                )?;
                writeln!(
                    out,
                    "{:<38} {:>6} {:>6} {:>8} {:>8} {:>8}",
                    "method and variant", "hits", "misses", "median", "p99", "max"
                )?;
            }
            Record::Decisions(decisions) => {
                let errors = records.lines.iter().find_map(|line| match line {
                    Record::Error(error) if of_t(error, decisions) => Some(error.relative),
                    _ => None,
                });
                let (false_hits, false_misses) = wrong(decisions);
                let label = label(&decisions.variant);
                let errors = errors.unwrap_or_default();
                writeln!(
                    out,
                    "{label:<38} {false_hits:>6} {false_misses:>6} {:>8.1e} {:>8.1e} {:>8.1e}",
                    errors.median, errors.p99, errors.max
                )?;
            }
            Record::Agreement(agreement) => {
                writeln!(
                    out,
                    "\n{}: all methods pick the same closest triangle for {} of {} rays;",
                    agreement.precision, agreement.unanimous, agreement.rays
                )?;
                for differs in &agreement.differs_from_oracle {
                    writeln!(
                        out,
                        "  {:<22} differs from the oracle on {}",
                        differs.method, differs.count
                    )?;
                }
                if agreement.precision == "f64" {
                    writeln!(out)?;
                }
            }
            _ => {}
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

/// False hits and false misses.
fn wrong(decisions: &Decisions) -> (u64, u64) {
    let hits = decisions.classes.iter().filter(|row| !row.is_hit).map(|row| row.called_hit).sum();
    let misses = decisions.classes.iter().filter(|row| row.is_hit).map(|row| row.called_miss).sum();
    (hits, misses)
}

/// Method, precision, width, arithmetic and division in 38 columns.
fn label(variant: &Variant) -> String {
    let newton = if variant.reciprocal == "newton" { "~" } else { "" };
    format!(
        "{} {}×{}{} {}{newton}",
        variant.method,
        variant.precision,
        variant.width,
        if variant.arithmetic == "fused" { " fused" } else { "" },
        variant.division,
    )
}
