//! `rank`, `cmp` and `report`: what is made of records.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail};
use serde::Serialize;
use trisect_harness::Settings;
use trisect_harness::record::{Record, Records};
use trisect_report::{Filter, Page, PageError};

use crate::arguments::{Cmp, Rank, Report};
use crate::compare::{command, read};
use crate::output;
use crate::progress::Bar;

/// Columns of what is printed: a terminal's.
pub(crate) const COLUMNS: usize = 80;

pub(crate) fn rank(arguments: &Rank) -> Result<()> {
    let records = read(&arguments.record)?;
    let filter = Filter {
        needs: arguments.needs.map(|needs| needs.name().to_owned()),
        workload: arguments.workload.clone(),
    };
    let ranking = trisect_report::rank(&records, &filter);
    if ranking.entries.is_empty() {
        bail!("{}: {}", arguments.record.display(), nothing_to_rank(&records, &filter));
    }
    show(&ranking, &ranking.to_text(COLUMNS), arguments.json)
}

/// Why a ranking is empty, and what mends it.
fn nothing_to_rank(records: &Records, filter: &Filter) -> String {
    let timed = |line: &Record| match line {
        Record::Throughput(line) => Some(line.workload.clone()),
        _ => None,
    };
    let timed: BTreeSet<String> = records.lines.iter().filter_map(timed).collect();
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
    let comparison = trisect_report::compare(&a, &b);
    show(&comparison, &comparison.to_text(COLUMNS), arguments.json)
}

pub(crate) fn report(arguments: &Report) -> Result<()> {
    let records = read(&arguments.record)?;
    if !arguments.splice.is_empty() {
        return splice(&records, &arguments.splice);
    }
    output::check_folder(&arguments.output)?;
    if records.lines.iter().any(|line| matches!(line, Record::Stress(_))) {
        return publish_stress(&records, &arguments.output, arguments.json);
    }
    if records.lines.iter().any(|line| matches!(line, Record::Frames(_))) {
        return publish_pictures(&records, &arguments.output, arguments.json);
    }
    if records.lines.iter().any(|line| matches!(line, Record::Omission(_))) {
        return publish_omissions(&records, &arguments.output, arguments.json);
    }
    if records.lines.iter().any(|line| matches!(line, Record::Traced(_))) {
        return publish_study(&records, &arguments.output, arguments.json);
    }
    publish(&records, &arguments.output, arguments.json)
}

/// Makes what stands between markers anew: in all documents, or where one is not sound in none.
fn splice(records: &Records, documents: &[PathBuf]) -> Result<()> {
    let mut spliced = Vec::new();
    for path in documents {
        let document = std::fs::read_to_string(path).map_err(|error| {
            anyhow!("{}: cannot be read ({error}); check the path", path.display())
        })?;
        let text = trisect_report::splice(&document, records)
            .with_context(|| path.display().to_string())?;
        spliced.push((path, text));
    }
    for (path, text) in spliced {
        output::write_file(path, |out| out.write_all(text.as_bytes()))?;
        eprintln!("spliced {}", path.display());
    }
    Ok(())
}

/// A record with no more than the facts of the machine, for a study that adds what it finds.
pub(crate) fn of_machine(seed: u64, rounds: usize, progress: &mut Bar) -> Result<Records> {
    let settings = Settings { command: command(), seed, rounds, methods: Vec::new(), timed: false };
    Ok(trisect_harness::measure(&settings, [], progress)?)
}

/// What is made of a record: a page in a folder, and its summary, printed.
pub(crate) type Publish = fn(&Records, &Path, bool) -> Result<()>;

/// Writes a record that was taken for a report, and publishes it there.
pub(crate) fn keep(
    taken: &Records,
    folder: &Path,
    name: &str,
    json: bool,
    publish: Publish,
) -> Result<()> {
    let file = folder.join(name);
    output::write_file(&file, |out| taken.write(out))?;
    publish(taken, folder, json)?;
    eprintln!("record  {}", file.display());
    Ok(())
}

/// Writes the page and prints the summary.
pub(crate) fn publish(records: &Records, folder: &Path, json: bool) -> Result<()> {
    let page = trisect_report::write_page(records, folder)
        .with_context(|| format!("{}: cannot write the page", folder.display()))?;
    let summary = trisect_report::summary(records);
    tell(&page, &summary, &summary.to_text(COLUMNS), json)
}

/// Adds the page of the stability study to a report and prints its summary.
pub(crate) fn publish_stress(records: &Records, folder: &Path, json: bool) -> Result<()> {
    let page = add(folder, || trisect_report::write_stress_page(records, folder))?;
    let summary = trisect_report::stress_summary(records);
    tell(&page, &summary, &summary.to_text(COLUMNS), json)
}

/// Adds the page of the tracer's study to a report and prints its summary.
pub(crate) fn publish_study(records: &Records, folder: &Path, json: bool) -> Result<()> {
    let page = add(folder, || trisect_report::write_study_page(records, folder))?;
    let summary = trisect_report::study_summary(records);
    tell(&page, &summary, &summary.to_text(COLUMNS), json)
}

/// Adds the page of the study of pictures to a report and prints its summary.
pub(crate) fn publish_pictures(records: &Records, folder: &Path, json: bool) -> Result<()> {
    let page = add(folder, || trisect_report::write_pictures_page(records, folder))?;
    let summary = trisect_report::picture_summary(records);
    tell(&page, &summary, &summary.to_text(COLUMNS), json)
}

/// Adds the page of the study of omissions to a report and prints its summary.
pub(crate) fn publish_omissions(records: &Records, folder: &Path, json: bool) -> Result<()> {
    let page = add(folder, || trisect_report::write_omissions_page(records, folder))?;
    let summary = trisect_report::omission_summary(records);
    tell(&page, &summary, &summary.to_text(COLUMNS), json)
}

/// Prints a summary, and says where the page is.
fn tell(page: &Page, summary: &impl Serialize, text: &str, json: bool) -> Result<()> {
    show(summary, text, json)?;
    eprintln!("\npage    {}", page.index.display());
    Ok(())
}

/// Adds a page to a report. The pages that are there lead to the new one from now on.
fn add(folder: &Path, write: impl FnOnce() -> Result<Page, PageError>) -> Result<Page> {
    let cannot_write = || format!("{}: cannot write the page", folder.display());
    let page = write().with_context(cannot_write)?;
    for (record, drawn, write) in [
        ("record.jsonl", "index.html", trisect_report::write_page as fn(&_, &_) -> _),
        ("stress.jsonl", "stress.html", trisect_report::write_stress_page),
        ("study.jsonl", "study.html", trisect_report::write_study_page),
        ("pictures.jsonl", "pictures.html", trisect_report::write_pictures_page),
        ("omissions.jsonl", "omissions.html", trisect_report::write_omissions_page),
    ] {
        let record = folder.join(record);
        if record.exists() && folder.join(drawn) != page.index {
            write(&read(&record)?, folder).with_context(cannot_write)?;
        }
    }
    Ok(page)
}

pub(crate) fn show(value: &impl Serialize, text: &str, json: bool) -> Result<()> {
    output::print_as(json, value, |out| writeln!(out, "{}", text.trim_end()))
}
