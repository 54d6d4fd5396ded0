//! `rank`, `cmp` and `report`: what is made of records.

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::{Context as _, Result, anyhow, bail};
use trisect_mesh::{ReadOptions, Reading};
use trisect_studies::chapter_of;
use trisect_studies::comparison::{self, Filter, Throughput};
use trisect_studies::file::Files;
use trisect_studies::record::Records;

use crate::arguments::{Cmp, Merge, Rank, Report};
use crate::output::{self, COLUMNS, show};
use crate::publish::{check, tell};
use crate::studies::{read, write};

pub(crate) fn merge(arguments: &Merge) -> Result<()> {
    let mut shards = Vec::new();
    for path in &arguments.shards {
        shards.push((path.display().to_string(), read(path)?));
    }
    let processors: BTreeSet<&str> =
        shards.iter().map(|(_, shard)| shard.header.machine.cpu.as_str()).collect();
    if processors.len() > 1 {
        let all = processors.into_iter().collect::<Vec<_>>().join(", ");
        output::say(format_args!("the times are those of different processors: {all}"));
    }
    if let Some(file) = &arguments.output {
        output::check_file(file)?;
    }
    write(&trisect_studies::merge(shards)?, arguments.output.as_deref())
}

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
