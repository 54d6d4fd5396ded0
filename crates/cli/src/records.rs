//! `rank`, `cmp` and `report`: what is made of records.

use std::path::Path;

use anyhow::{Context as _, Result};
use serde::Serialize;
use trisect_harness::record::Records;
use trisect_report::Filter;

use crate::arguments::{Cmp, Rank, Report};
use crate::compare::read;
use crate::output;

/// Columns of what is printed: a terminal's.
const COLUMNS: usize = 80;

pub(crate) fn rank(arguments: &Rank) -> Result<()> {
    let records = read(&arguments.record)?;
    let filter = Filter { needs: arguments.needs.clone(), workload: arguments.workload.clone() };
    let ranking = trisect_report::rank(&records, &filter);
    show(&ranking, &ranking.to_text(COLUMNS), arguments.json)
}

pub(crate) fn compare(arguments: &Cmp) -> Result<()> {
    let (a, b) = (read(&arguments.a)?, read(&arguments.b)?);
    let comparison = trisect_report::compare(&a, &b);
    show(&comparison, &comparison.to_text(COLUMNS), arguments.json)
}

pub(crate) fn report(arguments: &Report) -> Result<()> {
    let records = read(&arguments.record)?;
    output::check_folder(&arguments.output)?;
    publish(&records, &arguments.output, arguments.json)
}

/// Writes the page and prints the summary.
pub(crate) fn publish(records: &Records, folder: &Path, json: bool) -> Result<()> {
    let page = trisect_report::write_page(records, folder)
        .with_context(|| format!("{}: cannot write the page", folder.display()))?;
    let summary = trisect_report::summary(records);
    show(&summary, &summary.to_text(COLUMNS), json)?;
    eprintln!("\npage    {}", page.index.display());
    Ok(())
}

fn show(value: &impl Serialize, text: &str, json: bool) -> Result<()> {
    output::print(|out| {
        if json {
            serde_json::to_writer(&mut *out, value)?;
            writeln!(out)
        } else {
            writeln!(out, "{}", text.trim_end())
        }
    })
}
