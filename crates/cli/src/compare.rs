//! The comparison, and `trisect measure`.

use std::path::Path;

use anyhow::{Context as _, Result};
use trisect_harness::record::Records;
use trisect_harness::{Settings, file};
use trisect_report::Chapter;
use trisect_workloads::Mesh;

use crate::arguments::{Compare, Measure, Measurement};
use crate::progress::Bar;
use crate::{output, records, tasks};

/// Measures, prints the summary, writes the record and the page.
pub(crate) fn run(arguments: &Compare) -> Result<()> {
    let planned = Plan::new(&arguments.measurement)?;
    records::check(Chapter::Comparison, &arguments.output)?;
    let taken = planned.run()?;
    let Compare { output, json, .. } = arguments;
    records::keep(Chapter::Comparison, &taken, output, *json)
}

/// Measures and writes the record.
pub(crate) fn measure(arguments: &Measure) -> Result<()> {
    let planned = Plan::new(&arguments.measurement)?;
    if let Some(file) = &arguments.output {
        output::check_file(file)?;
    }
    let records = planned.run()?;
    match &arguments.output {
        Some(file) => Ok(file::replace(file, |out| records.write(out))?),
        None => output::print(|out| records.write(out)),
    }
}

/// A measurement whose input is read and found good: nothing is written before that.
struct Plan<'a> {
    settings: Settings,
    measurement: &'a Measurement,
    meshes: Vec<Mesh>,
}

impl<'a> Plan<'a> {
    fn new(measurement: &'a Measurement) -> Result<Self> {
        let rounds = if measurement.full { 15 } else { 5 };
        let settings = Settings {
            command: command(),
            seed: measurement.subjects.seed,
            rounds: measurement.rounds.map_or(rounds, |n| n as usize),
            methods: tasks::methods(&measurement.subjects.methods)?,
            timed: true,
        };
        let meshes = tasks::meshes(&measurement.subjects, || vec![Mesh::bunny()])?;
        tasks::say_all_rounding(&measurement.subjects, &meshes);
        Ok(Self { settings, measurement, meshes })
    }

    fn run(self) -> Result<Records> {
        let tasks = tasks::comparison(self.measurement, self.meshes);
        Ok(trisect_harness::measure(&self.settings, tasks, &mut Bar::new())?)
    }
}

/// The command line as it was typed, without the folder of the program.
pub(crate) fn command() -> String {
    let arguments = std::env::args().skip(1);
    std::iter::once("trisect".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Reads a record.
pub(crate) fn read(path: &Path) -> Result<Records> {
    Records::load(path).with_context(|| path.display().to_string())
}
