//! Records: one JSON object a line. Times are integer nanoseconds, floats keep every bit, and the first line
//! holds the facts about the machine. Each study defines its own kinds of lines.

use std::any::Any;
use std::borrow::Cow;
use std::fmt;
use std::io::{self, BufRead, Read as _, Write};
use std::sync::Arc;

use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Serialize};
pub use trisect_catalog::Variant;
pub use trisect_machine::Machine;

use crate::noise::Noise;
use crate::shard::Shard;

/// The version of the schema that this build writes and reads.
pub const SCHEMA: u32 = 9;

/// The oldest schema that this build reads: 2 added facts about methods, refusals and cracks, 3 the
/// stability study, 4 the study of the tracer, 5 pictures, 6 exactness and stages, 7 omissions,
/// 8 noise, and trees in a comparison, 9 errors over condition numbers, and Morozov's series of pictures.
const OLDEST: u64 = 1;

/// Who measured, where and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// [`SCHEMA`] of the writer.
    pub schema: u32,
    /// The study that took it; `None` in records older than this field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<Cow<'static, str>>,
    /// The version of trisect.
    pub trisect: String,
    /// The command line, as typed.
    pub command: String,
    /// Start of the measurement, RFC 3339, UTC.
    pub started: String,
    /// The seed of every workload.
    pub seed: u64,
    /// How many rounds each variant was timed for.
    pub rounds: usize,
    /// The machine.
    pub machine: Machine,
    /// How steady it was; none where nothing was timed, and in records older than this field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
    /// Which share of the study it is; none where it is whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
}

/// A kind of line.
pub trait LineKind:
    Clone + fmt::Debug + PartialEq + Serialize + DeserializeOwned + Send + Sync + 'static
{
    /// Its name: what the field `kind` of such a line holds.
    const NAME: &'static str;

    /// Takes in what another [shard](crate::Shard) found of the same; whether that is a part of the same line.
    fn join(&mut self, _other: &Self) -> bool {
        false
    }
}

/// Names kinds of lines, and lists what reads them as `LINES`; `joined` by a function where shards find parts of a line.
macro_rules! lines {
    ($($kind:ident = $name:literal $(joined $join:expr)?,)+) => {
        $(impl crate::record::LineKind for $kind {
            const NAME: &'static str = $name;

            $(fn join(&mut self, other: &Self) -> bool {
                $join(self, other)
            })?
        })+

        /// What reads the lines of this study alone.
        pub(super) const LINES: &[crate::record::Parser] =
            &[$(crate::record::Parser::of::<$kind>()),+];
    };
}
pub(crate) use lines;

/// A line of a record, of any [`LineKind`].
#[derive(Clone)]
pub struct Line(Arc<dyn Erased>);

/// A [`LineKind`] whose type is not known.
trait Erased: Any + fmt::Debug + Send + Sync {
    fn name(&self) -> &'static str;
    fn is_same(&self, other: &Line) -> bool;
    fn joined(&self, other: &Line) -> Option<Line>;
    fn write(&self, to: &mut dyn Write) -> serde_json::Result<()>;
}

impl<K: LineKind> Erased for K {
    fn name(&self) -> &'static str {
        K::NAME
    }

    fn is_same(&self, other: &Line) -> bool {
        other.get::<K>() == Some(self)
    }

    fn joined(&self, other: &Line) -> Option<Line> {
        let mut line = self.clone();
        line.join(other.get::<K>()?).then(|| line.into())
    }

    fn write(&self, to: &mut dyn Write) -> serde_json::Result<()> {
        /// As it stands in a file.
        #[derive(Serialize)]
        struct Tagged<'a, K> {
            kind: &'static str,
            #[serde(flatten)]
            line: &'a K,
        }
        serde_json::to_writer(to, &Tagged { kind: K::NAME, line: self })
    }
}

impl Line {
    /// The line, where it is of that kind.
    pub fn get<K: LineKind>(&self) -> Option<&K> {
        (&*self.0 as &dyn Any).downcast_ref()
    }

    /// Changes the line, where it is of that kind.
    pub fn edit<K: LineKind>(&mut self, change: impl FnOnce(&mut K)) {
        if let Some(mut line) = self.get::<K>().cloned() {
            change(&mut line);
            *self = line.into();
        }
    }

    /// As [`LineKind::join`].
    pub(crate) fn join(&mut self, other: &Self) -> bool {
        let joined = self.0.joined(other);
        let is_joined = joined.is_some();
        *self = joined.unwrap_or_else(|| self.clone());
        is_joined
    }

    /// The name of its kind.
    pub fn kind(&self) -> &'static str {
        self.0.name()
    }
}

impl<K: LineKind> From<K> for Line {
    fn from(line: K) -> Self {
        Self(Arc::new(line))
    }
}

impl fmt::Debug for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl PartialEq for Line {
    fn eq(&self, other: &Self) -> bool {
        self.0.is_same(other)
    }
}

/// Reads lines of one kind.
#[derive(Clone, Copy)]
pub struct Parser {
    /// The name of the kind.
    pub kind: &'static str,
    parse: fn(&str) -> serde_json::Result<Line>,
}

impl Parser {
    /// What reads lines of kind `K`.
    pub const fn of<K: LineKind>() -> Self {
        Self { kind: K::NAME, parse: |text| serde_json::from_str::<K>(text).map(Line::from) }
    }

    /// Reads a line, whose kind is among those of some parsers.
    fn parse(text: &str, parsers: &[Self]) -> serde_json::Result<Line> {
        /// What tells the kind.
        #[derive(Deserialize)]
        struct Head<'a> {
            #[serde(borrow)]
            kind: Cow<'a, str>,
        }
        let Head { kind } = serde_json::from_str(text)?;
        let parser = parsers.iter().find(|parser| parser.kind == kind);
        let unknown = || serde_json::Error::custom(format!("no line is of the kind `{kind}`"));
        (parser.ok_or_else(unknown)?.parse)(text)
    }
}

/// Why a record file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be opened. Not a `source`: the message holds it already.
    #[error("cannot be read ({0}); check the path")]
    NotOpened(io::Error),
    /// The stream failed.
    #[error("cannot be read as a record")]
    Io(#[from] io::Error),
    /// No record has such a line.
    #[error("line {line} is longer than {LONGEST} bytes; this is no record, check the path")]
    TooLong {
        /// Line number, from 1.
        line: usize,
    },
    /// The file has no line.
    #[error("the record is empty; make one with `trisect measure --output FILE`")]
    Empty,
    /// The first line is no header.
    #[error("line 1 is not a record header; make a record with `trisect measure --output FILE`")]
    NoHeader,
    /// Written by another version.
    #[error(
        "line 1: the record has schema {found}, this trisect reads schema {SCHEMA}; measure again with this version"
    )]
    OtherVersion {
        /// The schema in the file.
        found: u64,
    },
    /// A line that is no record.
    #[error("line {line}: {problem}; the file is damaged, measure again")]
    Line {
        /// Line number, from 1.
        line: usize,
        /// What the parser said. Not a `source`: the message holds it already.
        problem: serde_json::Error,
    },
}

/// Bytes of a line, at most: ten times what the largest picture of a study takes.
const LONGEST: u64 = 1 << 26;

/// The next line, without its end; none where there is no more.
fn read_line(from: &mut impl BufRead, line: usize) -> Result<Option<String>, ReadError> {
    let mut text = String::new();
    // Devices may have no end.
    if from.take(LONGEST).read_line(&mut text)? as u64 == LONGEST {
        return Err(ReadError::TooLong { line });
    }
    let text_alone = text.trim_end_matches('\n');
    Ok((!text.is_empty()).then(|| text_alone.strip_suffix('\r').unwrap_or(text_alone).to_owned()))
}

/// A record file in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Records {
    /// The first line.
    pub header: Header,
    /// All other lines, in order.
    pub lines: Vec<Line>,
}

impl Records {
    /// All lines of one kind, in order.
    pub fn all<K: LineKind>(&self) -> impl Iterator<Item = &K> {
        self.lines.iter().filter_map(Line::get)
    }

    /// Reads a record file whose lines are of known kinds.
    ///
    /// # Errors
    /// When the stream fails, or a line is not a record of this [`SCHEMA`].
    pub fn read(mut from: impl BufRead, parsers: &[Parser]) -> Result<Self, ReadError> {
        let mut lines = (1..).map_while(|line| read_line(&mut from, line).transpose());
        let first = lines.next().ok_or(ReadError::Empty)??;
        let head: serde_json::Value =
            serde_json::from_str(&first).map_err(|_| ReadError::NoHeader)?;
        if head["kind"] != HEADER {
            return Err(ReadError::NoHeader);
        }
        let found = head["schema"].as_u64().ok_or(ReadError::NoHeader)?;
        if !(OLDEST..=u64::from(SCHEMA)).contains(&found) {
            return Err(ReadError::OtherVersion { found });
        }
        let header =
            serde_json::from_value(head).map_err(|problem| ReadError::Line { line: 1, problem })?;
        let lines = lines
            .enumerate()
            .map(|(i, line)| {
                Parser::parse(&line?, parsers)
                    .map_err(|problem| ReadError::Line { line: i + 2, problem })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { header, lines })
    }

    /// Writes a record file: the header, then each line.
    ///
    /// # Errors
    /// When the stream fails.
    pub fn write(&self, mut to: impl Write) -> io::Result<()> {
        self.header.write(&mut to)?;
        to.write_all(b"\n")?;
        for line in &self.lines {
            line.0.write(&mut to)?;
            to.write_all(b"\n")?;
        }
        Ok(())
    }
}

/// The kind of the first line.
const HEADER: &str = "header";

impl LineKind for Header {
    const NAME: &'static str = HEADER;
}
