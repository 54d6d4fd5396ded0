//! What a study is, and how its record is taken.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::SystemTime;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use serde::Serialize;
use trisect_mesh::MeshError;
use trisect_report::document::Document;
use trisect_scene::SceneError;

use crate::machine;
use crate::noise::Meter;
use crate::record::{Header, Line, Parser, Records, SCHEMA};
use crate::shard::{Part, Shard};
use crate::timing::WrongAnswer;

/// A study: what it asks for, how it measures, and the kinds of lines that its record holds.
///
/// A value is a study whose input was read and found good.
pub trait Study: Sized {
    /// Its names.
    const ABOUT: About;
    /// Its options on the command line.
    type Settings: clap::Args;

    /// Reads and checks all input. `say` takes what a user is to know about it.
    ///
    /// # Errors
    /// When the input is at fault.
    fn plan(settings: &Self::Settings, say: &dyn Fn(&dyn Display)) -> Result<Self, StudyError>;

    /// The seed of every random choice, and how often everything is timed.
    fn seed_and_rounds(&self) -> (u64, usize);

    /// Measures, and adds what it finds to the record.
    ///
    /// # Errors
    /// When a timed sample is not what it must be, or the system gives no threads.
    fn measure(self, run: &mut Run<'_>) -> Result<(), StudyError>;

    /// What a record says, as a page, a text and parts of documents.
    fn document(records: &Records) -> Document;

    /// What a record says in numbers.
    type Summary: Serialize;

    /// The same in numbers, for a program to read.
    fn summary(records: &Records) -> Self::Summary;

    /// Takes the study's record. `command` is the command line that asked for it.
    ///
    /// # Errors
    /// As [`measure`](Study::measure).
    fn record(self, command: String, progress: &mut dyn Progress) -> Result<Records, StudyError> {
        self.record_shard(command, None, progress)
    }

    /// The same of a share of it, where there is one: all shares [merge](crate::merge) into the whole record. Of a study
    /// that is not divided into parts every share is the whole.
    ///
    /// # Errors
    /// As [`measure`](Study::measure).
    fn record_shard(
        self,
        command: String,
        shard: Option<Shard>,
        progress: &mut dyn Progress,
    ) -> Result<Records, StudyError> {
        let (seed, rounds) = self.seed_and_rounds();
        let taken = Taken { command, seed, rounds };
        let mut records = taken.record(progress, |run| {
            run.shard = shard;
            self.measure(run)
        })?;
        records.header.study = Some(Cow::Borrowed(Self::ABOUT.name));
        records.header.shard = shard;
        Ok(records)
    }
}

/// What there is to know of a study without measuring.
#[derive(Clone, Copy)]
pub struct About {
    /// Its name in records and on the command line.
    pub name: &'static str,
    /// The file of its page.
    pub page: &'static str,
    /// The file of its record, where that lies beside the page.
    pub record: &'static str,
    /// What it is called where other pages lead to it.
    pub title: &'static str,
    /// What it is about, in a line.
    pub says: &'static str,
    /// What reads the kinds of lines that only this study writes. A record may hold lines of a comparison
    /// as well.
    pub lines: &'static [Parser],
}

/// A study as a chapter of a report: what can be done with its records, whatever its type.
pub struct Chapter {
    /// Its names.
    pub about: About,
    document: fn(&Records) -> Document,
    summary: fn(&Records, &mut dyn Write) -> serde_json::Result<()>,
}

impl Chapter {
    /// A study as a chapter.
    pub const fn of<S: Study>() -> Self {
        Self {
            about: S::ABOUT,
            document: S::document,
            summary: |records, to| serde_json::to_writer(to, &S::summary(records)),
        }
    }

    /// What a program writes that is no study of trisect's, as a chapter.
    pub(crate) const fn of_program(
        about: About,
        document: fn(&Records) -> Document,
        summary: fn(&Records, &mut dyn Write) -> serde_json::Result<()>,
    ) -> Self {
        Self { about, document, summary }
    }

    /// What a record says.
    pub fn document(&self, records: &Records) -> Document {
        (self.document)(records)
    }

    /// Writes what a record says in numbers, as JSON.
    ///
    /// # Errors
    /// When the stream fails.
    pub fn write_summary(&self, records: &Records, mut to: impl Write) -> io::Result<()> {
        Ok((self.summary)(records, &mut to)?)
    }
}

/// Hears how far a measurement is; never called inside a timed section.
pub trait Progress {
    /// A new phase of `steps` steps begins.
    fn phase(&mut self, name: &str, steps: u64);
    /// One step is done.
    fn step(&mut self);
}

/// No progress is shown.
pub struct Silent;

impl Progress for Silent {
    fn phase(&mut self, _name: &str, _steps: u64) {}
    fn step(&mut self) {}
}

/// A record that is being taken.
pub struct Run<'a> {
    /// The lines so far.
    pub lines: Vec<Line>,
    /// Hears how far it is.
    pub progress: &'a mut dyn Progress,
    pub(crate) meter: Meter,
    ghz: Vec<f64>,
    shard: Option<Shard>,
    /// How many parts of the study have been dealt out.
    parts: usize,
}

impl Run<'_> {
    /// Adds a line.
    pub fn add(&mut self, line: impl Into<Line>) {
        self.lines.push(line.into());
    }

    /// Deals out parts of the study to shards: the number of the first, and which are this run's.
    pub(crate) fn deal(&mut self, count: usize) -> (usize, Vec<bool>) {
        let first = self.parts;
        self.parts += count;
        let is_mine = |part| self.shard.is_none_or(|shard| shard.has(part));
        (first, (first..self.parts).map(is_mine).collect())
    }

    /// Deals out one: its number, where it is this run's.
    pub(crate) fn claim(&mut self) -> Option<usize> {
        let (part, is_mine) = self.deal(1);
        is_mine[0].then_some(part)
    }

    /// What is added from now on is of that part.
    pub(crate) fn begin(&mut self, number: usize) {
        if self.shard.is_some() {
            self.add(Part { number });
        }
    }

    /// A phase of one part for each of `all`, those that are this run's.
    pub(crate) fn each<T>(
        &mut self,
        phase: &str,
        all: impl ExactSizeIterator<Item = T>,
        lines: impl Fn(T) -> Vec<Line>,
    ) {
        self.progress.phase(phase, all.len() as u64);
        for one in all {
            if let Some(part) = self.claim() {
                self.begin(part);
                self.lines.extend(lines(one));
            }
            self.progress.step();
        }
    }

    /// Measures the core's frequency once more. A record has the median.
    pub fn clock(&mut self) {
        self.ghz.push(machine::core_ghz());
    }
}

/// What a header says beside the facts of the machine.
pub struct Taken {
    /// The command line, as typed.
    pub command: String,
    /// The seed of every random choice.
    pub seed: u64,
    /// How often everything is timed.
    pub rounds: usize,
}

impl Taken {
    /// Takes a record of what `measure` adds.
    ///
    /// # Errors
    /// Those of `measure`.
    pub fn record<E>(
        self,
        progress: &mut dyn Progress,
        measure: impl FnOnce(&mut Run<'_>) -> Result<(), E>,
    ) -> Result<Records, E> {
        let started = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        let mut machine = machine::facts();
        let ghz = vec![machine::core_ghz()];
        let (lines, meter) = (Vec::new(), Meter::default());
        let mut run = Run { lines, progress, meter, ghz, shard: None, parts: 0 };
        measure(&mut run)?;
        run.ghz.sort_unstable_by(f64::total_cmp);
        machine.core_ghz = run.ghz[run.ghz.len() / 2];
        let Self { command, seed, rounds } = self;
        let trisect = env!("CARGO_PKG_VERSION").to_owned();
        let header = Header {
            schema: SCHEMA,
            study: None,
            trisect,
            command,
            started,
            seed,
            rounds,
            machine,
            noise: run.meter.noise(),
            shard: None,
        };
        Ok(Records { header, lines: run.lines })
    }
}

/// Why there is no record.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// No method has that name.
    #[error("unknown method `{0}`; `trisect list` shows what there is")]
    UnknownMethod(String),
    /// A method is named twice.
    #[error("method `{0}` is named twice; name each once with --methods")]
    MethodTwice(String),
    /// A mesh cannot be read.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A scene that is compiled into the program cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Two meshes have one name, by which workloads are told apart.
    #[error("{}: a mesh named `{name}` is given already; rename one of the files", path.display())]
    MeshTwice {
        /// The second of them.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// No method claims what is to be tested.
    #[error("none of these methods claims to be exact; `trisect list --json` says which do")]
    NoneExact,
    /// A method that claims to be exact gave an answer that is not.
    #[error("{0}; this is a bug in trisect, please report it with the command")]
    NotExact(String),
    /// The system gives no threads.
    #[error("the system gives no threads; ask for fewer with --threads")]
    Threads(#[from] ThreadPoolBuildError),
    /// A timed sample was wrong.
    #[error(transparent)]
    WrongAnswer(#[from] WrongAnswer),
}

impl StudyError {
    /// Whether trisect is at fault, and not its input.
    pub fn is_a_bug(&self) -> bool {
        matches!(self, Self::WrongAnswer(_) | Self::NotExact(_) | Self::Scene(_))
    }
}

/// So many threads.
pub(crate) fn pool(threads: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(threads).build()
}

/// The threads that were asked for, or as many as there are processors.
pub(crate) fn threads(asked: Option<u16>) -> usize {
    let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    asked.map_or(processors, usize::from)
}
