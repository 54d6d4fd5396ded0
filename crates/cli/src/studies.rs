//! Studies: they are taken, published and summed up.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Args;
use trisect_studies::comparison::Comparison;
use trisect_studies::raster;
use trisect_studies::record::Records;
use trisect_studies::stress::{self, Stability, exactness_summary};
use trisect_studies::{Chapter, Choice, Shard, Study, StudyError, StudyVisitor, file};

use crate::arguments::{Compare, Measure};
use crate::output;
use crate::progress::Bar;
use crate::publish;

/// Where a study goes.
#[derive(Debug, Args)]
pub(crate) struct Published {
    /// Folder of the report that the page is added to
    #[arg(long, value_name = "FOLDER", default_value = "reports/latest")]
    pub output: PathBuf,
    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// Takes a study, publishes its record and its page, and prints its summary.
pub(crate) fn run(choice: &Choice<Published>) -> Result<()> {
    match choice {
        Choice::Stress(asked) if asked.settings.shard.is_some() => {
            take_shard(&asked.settings, &asked.more.output)
        }
        Choice::Stress(asked) if asked.settings.exact.is_some() => {
            hold_to_exactness(&asked.settings, asked.more.json)
        }
        Choice::Raster(asked) if asked.settings.check => {
            compare_pixels(&asked.settings, asked.more.json)
        }
        _ => choice.visit(Publish),
    }
}

/// The same of the comparison.
pub(crate) fn compare(arguments: &Compare) -> Result<()> {
    Publish(&arguments.published).visit::<Comparison>(&arguments.settings)
}

struct Publish<'a>(&'a Published);

impl StudyVisitor for Publish<'_> {
    type Output = Result<()>;

    fn visit<S: Study>(self, settings: &S::Settings) -> Result<()> {
        let Published { output, json } = self.0;
        // All input is read before anything is written or measured.
        let study = S::plan(settings, &say)?;
        let chapter = Chapter::of::<S>();
        publish::check(&chapter, output)?;
        let taken = study.record(command(), &mut Bar::new())?;
        publish::keep(&chapter, &taken, output, *json)
    }
}

/// Takes the record of a comparison alone.
pub(crate) fn measure(arguments: &Measure) -> Result<()> {
    let study = Comparison::plan(&arguments.settings, &say)?;
    if let Some(file) = &arguments.output {
        output::check_file(file)?;
    }
    let shard = arguments.shard;
    let records = study.record_shard(command_of(shard), shard, &mut Bar::new())?;
    write(&records, arguments.output.as_deref())
}

/// Writes a record to a file, or else prints it.
pub(crate) fn write(records: &Records, file: Option<&Path>) -> Result<()> {
    match file {
        Some(file) => Ok(file::replace(file, |out| records.write(out))?),
        None => output::print(|out| records.write(out)),
    }
}

/// Takes a share of the study of stiff cases: its record alone.
fn take_shard(settings: &stress::Settings, folder: &Path) -> Result<()> {
    let study = Stability::plan(settings, &say)?;
    output::check_folder(folder)?;
    let shard = settings.shard;
    let records = study.record_shard(command_of(shard), shard, &mut Bar::new())?;
    let name =
        shard.map_or_else(|| Stability::ABOUT.record.to_owned(), |shard| shard.file("stress"));
    let file = folder.join(name);
    write(&records, Some(&file))?;
    output::say(format_args!("record  {}", file.display()));
    Ok(())
}

/// Nothing but methods that claim to be exact against the oracle.
fn hold_to_exactness(settings: &stress::Settings, json: bool) -> Result<()> {
    let records = Stability::plan(settings, &say)?.record(command(), &mut Bar::new())?;
    let summary = exactness_summary(&records);
    output::show(&summary, &summary.to_text(output::COLUMNS), json)?;
    if summary.total().all_wrong() > 0 {
        return Err(StudyError::NotExact(summary.first_wrong.unwrap_or_default()).into());
    }
    Ok(())
}

/// Counts pixels at which the rasteriser and the exact caster differ.
fn compare_pixels(settings: &raster::Settings, json: bool) -> Result<()> {
    let summary = raster::check(settings, &mut Bar::new())?;
    output::show(&summary, &summary.to_text(output::COLUMNS), json)?;
    if summary.different > 0 {
        let what = format!("the rasteriser differs from it at {} pixels", summary.different);
        return Err(StudyError::NotExact(what).into());
    }
    Ok(())
}

/// Says something about the input.
pub(crate) fn say(line: &dyn Display) {
    output::say(line);
}

/// The command line as it was typed, without the folder of the program.
pub(crate) fn command() -> String {
    let arguments = std::env::args().skip(1);
    std::iter::once("trisect".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// The same of all shards of a record: without which it is, and without where it goes.
fn command_of(shard: Option<Shard>) -> String {
    if shard.is_none() {
        return command();
    }
    let (mut kept, mut is_value) = (vec!["trisect".to_owned()], false);
    for argument in std::env::args().skip(1) {
        let name = argument.split('=').next().unwrap_or_default();
        let is_left_out = matches!(name, "--shard" | "--output");
        if !is_left_out && !is_value {
            kept.push(argument.clone());
        }
        is_value = is_left_out && !argument.contains('=');
    }
    kept.join(" ")
}

/// Reads a record.
pub(crate) fn read(path: &Path) -> Result<Records> {
    trisect_studies::load(path).with_context(|| path.display().to_string())
}
