//! A record as `trisect report` reads it: a header with the facts of the machine, then a line for each thing.

use std::path::Path;
use std::time::SystemTime;

use anyhow::{Context as _, Result};
use serde::Serialize;
use trisect_machine::noise::{Meter, Noise};
use trisect_machine::{Machine, facts, forms};

use crate::SEED;

/// The schema of records that these lines are part of.
const SCHEMA: u32 = 9;

/// The first line.
#[derive(Serialize)]
struct Header {
    kind: &'static str,
    schema: u32,
    study: &'static str,
    trisect: &'static str,
    command: String,
    started: String,
    seed: u64,
    rounds: usize,
    machine: Machine,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<Noise>,
}

/// Any other line.
#[derive(Serialize)]
struct Line<'a, X> {
    kind: &'static str,
    #[serde(flatten)]
    line: &'a X,
}

/// A record under way.
pub(crate) struct Record {
    /// How often everything is timed.
    pub(crate) rounds: usize,
    /// Gathers how steady the machine is.
    pub(crate) meter: Meter,
    started: String,
    ghz: Vec<f64>,
    lines: Vec<u8>,
}

impl Record {
    pub(crate) fn new(rounds: usize) -> Self {
        let started = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        let ghz = vec![facts::core_ghz()];
        Self { rounds, meter: Meter::default(), started, ghz, lines: Vec::new() }
    }

    /// Adds a line.
    pub(crate) fn add(&mut self, kind: &'static str, line: &impl Serialize) -> Result<()> {
        serde_json::to_writer(&mut self.lines, &Line { kind, line })?;
        self.lines.push(b'\n');
        Ok(())
    }

    /// Measures the frequency once more.
    pub(crate) fn clock(&mut self) {
        self.ghz.push(facts::core_ghz());
    }

    /// Writes it all.
    pub(crate) fn write(mut self, path: &Path) -> Result<()> {
        self.ghz.sort_unstable_by(f64::total_cmp);
        // Where the file lies says nothing of it.
        let named = |given: String| match path.file_name() {
            Some(name) if Path::new(&given) == path => name.to_string_lossy().into_owned(),
            _ => given,
        };
        let given = std::env::args().skip(1).map(named).collect::<Vec<_>>().join(" ");
        let header = Header {
            kind: "header",
            schema: SCHEMA,
            study: forms::STUDY,
            trisect: env!("CARGO_PKG_VERSION"),
            command: format!("trisect-by-hand {given}"),
            started: self.started,
            seed: SEED,
            rounds: self.rounds,
            machine: Machine { core_ghz: self.ghz[self.ghz.len() / 2], ..facts::facts() },
            noise: self.meter.noise(),
        };
        let mut text = serde_json::to_vec(&header)?;
        text.push(b'\n');
        text.append(&mut self.lines);
        std::fs::write(path, text).with_context(|| format!("{} cannot be written", path.display()))
    }
}
