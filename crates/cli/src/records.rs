//! `rank`, `cmp` and `report`: what is made of records.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail};
use serde::Serialize;
use trisect_mesh::{ReadOptions, Reading};
use trisect_studies::comparison::{self, Filter, Throughput};
use trisect_studies::file::Files;
use trisect_studies::record::Records;
use trisect_studies::{Chapter, Page, chapter_of};

use crate::arguments::{Cmp, Rank, Report};
use crate::output;
use crate::studies::read;

/// Columns of what is printed: a terminal's.
pub(crate) const COLUMNS: usize = 80;

pub(crate) fn rank(arguments: &Rank) -> Result<()> {
    let records = read(&arguments.record)?;
    let filter = Filter { needs: arguments.needs, workload: arguments.workload.clone() };
    let ranking = comparison::rank(&records, &filter);
    if ranking.entries.is_empty() {
        bail!("{}: {}", arguments.record.display(), nothing_to_rank(&records, &filter));
    }
    show(&ranking, &ranking.to_text(COLUMNS), arguments.json)
}

/// Why a ranking is empty, and what mends it.
fn nothing_to_rank(records: &Records, filter: &Filter) -> String {
    let timed: BTreeSet<&str> =
        records.all().map(|line: &Throughput| line.workload.as_str()).collect();
    if timed.is_empty() {
        return "nothing in this record is timed; make one with `trisect measure --output FILE`"
            .to_owned();
    }
    let all = timed.into_iter().collect::<Vec<_>>().join(", ");
    match (&filter.workload, &filter.needs) {
        (Some(workload), None) => {
            format!("nothing is timed on workload `{workload}`; timed are {all}")
        }
        (Some(workload), Some(needs)) => {
            format!("{needs} is not timed on workload `{workload}`; timed are {all}")
        }
        (None, _) => {
            format!("no workload is timed for all variants; name one with --workload, of {all}")
        }
    }
}

pub(crate) fn compare(arguments: &Cmp) -> Result<()> {
    let (a, b) = (read(&arguments.a)?, read(&arguments.b)?);
    let comparison = comparison::compare_records(&a, &b);
    show(&comparison, &comparison.to_text(COLUMNS), arguments.json)
}

pub(crate) fn report(arguments: &Report) -> Result<()> {
    let records = read(&arguments.record)?;
    if !arguments.splice.is_empty() {
        return splice(&records, &arguments.splice);
    }
    let chapter = chapter_of(&records);
    check(chapter, &arguments.output)?;
    tell(chapter, &chapter.publish(&records, &arguments.output)?, &records, arguments.json)
}

/// Makes what stands between markers anew: in all documents, or where one is not sound in none.
fn splice(records: &Records, documents: &[PathBuf]) -> Result<()> {
    let mut spliced = Vec::new();
    for path in documents {
        let document = Reading::new(&ReadOptions::default())
            .file(path)
            .map_err(|problem| anyhow!("{}: {problem}", path.display()))?;
        let document = String::from_utf8(document)
            .map_err(|_| anyhow!("{}: is not UTF-8; save it as that", path.display()))?;
        let text = trisect_studies::splice(&document, records)
            .with_context(|| path.display().to_string())?;
        spliced.push((path, text));
    }
    let mut files = Files::default();
    for (path, text) in &spliced {
        files.add(path, |out| out.write_all(text.as_bytes()))?;
    }
    files.commit()?;
    for (path, _) in spliced {
        output::say(format_args!("spliced {}", path.display()));
    }
    Ok(())
}

/// Refuses a folder that a chapter could not be published in, before any work is done for it.
pub(crate) fn check(chapter: &Chapter, folder: &Path) -> Result<()> {
    output::check_folder(folder)?;
    Ok(chapter.check(folder)?)
}

/// Publishes a record that was taken for a report, with its page, and prints its summary.
pub(crate) fn keep(chapter: &Chapter, taken: &Records, folder: &Path, json: bool) -> Result<()> {
    let page = chapter.keep(taken, folder)?;
    tell(chapter, &page, taken, json)?;
    output::say(format_args!("record  {}", folder.join(chapter.about.record).display()));
    Ok(())
}

/// Prints a summary, and says where the page is.
fn tell(chapter: &Chapter, page: &Page, records: &Records, json: bool) -> Result<()> {
    output::print(|out| {
        if json {
            chapter.write_summary(records, &mut *out)?;
            writeln!(out)
        } else {
            writeln!(out, "{}", page.document.to_text(COLUMNS).trim_end())
        }
    })?;
    output::say(format_args!("\npage    {}", page.index.display()));
    Ok(())
}

pub(crate) fn show(value: &impl Serialize, text: &str, json: bool) -> Result<()> {
    output::print_as(json, value, |out| writeln!(out, "{}", text.trim_end()))
}
