//! The comparison, and `trisect measure`.

use std::fs::File;
use std::path::Path;

use anyhow::{Context as _, Result};
use trisect_harness::Settings;
use trisect_harness::record::Records;

use crate::arguments::{Compare, Measure, Measurement};
use crate::progress::Bar;
use crate::{output, records, tasks};

/// Measures, prints the summary, writes the record and the page.
pub(crate) fn run(arguments: &Compare) -> Result<()> {
    output::check_folder(&arguments.output)?;
    let taken = take(&arguments.measurement)?;
    let file = arguments.output.join("record.jsonl");
    output::write_file(&file, |out| taken.write(out))?;
    records::publish(&taken, &arguments.output, arguments.json)?;
    eprintln!("record  {}", file.display());
    Ok(())
}

/// Measures and writes the record.
pub(crate) fn measure(arguments: &Measure) -> Result<()> {
    if let Some(file) = &arguments.output {
        output::check_folder(output::folder_of(file))?;
    }
    let records = take(&arguments.measurement)?;
    match &arguments.output {
        Some(file) => output::write_file(file, |out| records.write(out)),
        None => output::print(|out| records.write(out)),
    }
}

fn take(measurement: &Measurement) -> Result<Records> {
    let settings = Settings {
        command: command(),
        seed: measurement.subjects.seed,
        rounds: measurement.rounds.map_or(if measurement.full { 15 } else { 5 }, |n| n as usize),
        methods: tasks::methods(&measurement.subjects.methods)?,
        timed: true,
    };
    let meshes = tasks::meshes(&measurement.subjects)?;
    let tasks = tasks::comparison(measurement, meshes);
    Ok(trisect_harness::measure(&settings, tasks, &mut Bar::new())?)
}

/// The command line as it was typed, without the folder of the program.
pub(crate) fn command() -> String {
    let arguments = std::env::args().skip(1);
    std::iter::once("trisect".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Reads a record.
pub(crate) fn read(path: &Path) -> Result<Records> {
    let context = || path.display().to_string();
    let file = File::open(path).with_context(context)?;
    Records::read(std::io::BufReader::new(file)).with_context(context)
}
