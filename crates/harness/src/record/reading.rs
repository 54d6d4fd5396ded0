//! Record files: how they are read and written.

use std::fs::File;
use std::io::{BufRead, BufReader, Read as _, Write};
use std::path::Path;

use super::{Header, Record, SCHEMA};

/// The oldest schema that this build reads: 2 added facts about methods, refusals and cracks, 3 the
/// stability study, 4 the study of the tracer, 5 pictures, 6 exactness and stages, 7 omissions.
const OLDEST: u64 = 1;

/// Why a record file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be opened. Not a `source`: the message holds it already.
    #[error("cannot be read ({0}); check the path")]
    NotOpened(std::io::Error),
    /// The stream failed.
    #[error("cannot be read as a record")]
    Io(#[from] std::io::Error),
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
    pub lines: Vec<Record>,
}

impl Records {
    /// Reads a record file.
    ///
    /// # Errors
    /// When the stream fails, or a line is not a record of this [`SCHEMA`].
    pub fn read(mut from: impl BufRead) -> Result<Self, ReadError> {
        let mut lines = (1..).map_while(|line| read_line(&mut from, line).transpose());
        let first = lines.next().ok_or(ReadError::Empty)??;
        let head: serde_json::Value =
            serde_json::from_str(&first).map_err(|_| ReadError::NoHeader)?;
        if head["kind"] != "header" {
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
                serde_json::from_str(&line?)
                    .map_err(|problem| ReadError::Line { line: i + 2, problem })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { header, lines })
    }

    /// Reads a record file by its path; a pipe will do.
    ///
    /// # Errors
    /// As [`read`](Records::read).
    pub fn load(path: &Path) -> Result<Self, ReadError> {
        Self::read(BufReader::new(File::open(path).map_err(ReadError::NotOpened)?))
    }

    /// Writes a record file: the header, then each line.
    ///
    /// # Errors
    /// When the stream fails.
    pub fn write(&self, mut to: impl Write) -> std::io::Result<()> {
        let header = Record::Header(self.header.clone());
        for record in std::iter::once(&header).chain(&self.lines) {
            serde_json::to_writer(&mut to, record)?;
            to.write_all(b"\n")?;
        }
        Ok(())
    }
}
