//! Access to files: what one reading may do, how much it has taken, and what it passed over.

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// How files are read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// Refuses everything that the standard of the file's format does not allow. Otherwise what is
    /// unambiguous is read, and what is lost is noted.
    pub strict: bool,
    /// Refuses files outside the folder of the file that is read first.
    pub sandbox: bool,
    /// The most bytes that files, and what is decoded from them, may take together.
    pub max_memory: u64,
}

impl ReadOptions {
    /// The limit on memory unless another is given: 8 GiB.
    pub const MAX_MEMORY: u64 = 8 << 30;
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { strict: false, sandbox: false, max_memory: Self::MAX_MEMORY }
    }
}

/// Something that a reader passed over or mended: one note for all places of a kind in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The file as it was named.
    pub file: String,
    /// What was passed over, and what that means for the result.
    pub what: String,
    /// In how many places.
    pub count: usize,
    /// The first of them: a line, or an element.
    pub first: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, what, count, first } = self;
        match count {
            1 => write!(f, "{file}: {what} ({first})"),
            _ => write!(f, "{file}: {what} ({count} times, first {first})"),
        }
    }
}

/// Why a file, or something in it, is not read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadProblem {
    /// The system refuses it.
    #[error("cannot be read ({0}); check the path")]
    Unreadable(io::Error),
    /// A folder, a pipe or a device.
    #[error("is not a regular file; name one")]
    NotAFile,
    /// It lies outside the folder that the sandbox keeps to.
    #[error(
        "lies outside {folder}, which --sandbox keeps to; copy it there, or leave out --sandbox"
    )]
    Outside {
        /// The folder.
        folder: String,
    },
    /// More memory is needed than is allowed.
    #[error("needs more than the {limit} bytes that --max-memory allows; raise it")]
    TooLarge {
        /// The limit.
        limit: u64,
    },
    /// It is read as text, and is not.
    #[error("line {line}: is no text; save the file as UTF-8")]
    NotText {
        /// The first line that is none.
        line: usize,
    },
    /// The file departs from the standard of its format, and the reading is strict.
    #[error("{place}: {what}, which the format's standard does not allow; leave out --strict")]
    NotStandard {
        /// The line, or the element.
        place: String,
        /// What is not standard.
        what: String,
    },
}

/// One reading of a file and of those that it names.
#[derive(Debug)]
pub struct Reading {
    options: ReadOptions,
    /// The folder of the first file, where the sandbox keeps to it.
    root: Option<PathBuf>,
    used: u64,
    notes: Vec<Note>,
    /// The files that there are; those of the system, where none are given.
    files: Option<&'static [FileInMemory]>,
}

/// A file in memory: its path, and its content.
pub type FileInMemory = (&'static str, &'static [u8]);

/// What a reader reads beside the file's own bytes, and whom it tells.
pub(crate) struct Source<'a> {
    /// Stands for the file in messages.
    pub(crate) file: &'a str,
    /// Where other files are looked for.
    pub(crate) folder: Option<&'a Path>,
    pub(crate) reading: &'a mut Reading,
}

impl Reading {
    /// A reading of what is in memory; nothing is read yet.
    pub fn new(options: &ReadOptions) -> Self {
        Self { options: options.clone(), root: None, used: 0, notes: Vec::new(), files: None }
    }

    /// A reading of files in memory: no others are there.
    pub fn in_memory(files: &'static [FileInMemory]) -> Self {
        Self { files: Some(files), ..Self::new(&ReadOptions::default()) }
    }

    /// The whole content of a regular file. The first file's folder is the one that a sandbox keeps
    /// to.
    ///
    /// # Errors
    /// When the file cannot be read, is no regular file, lies outside the sandbox, or is larger than
    /// the memory that is left.
    pub fn file(&mut self, path: &Path) -> Result<Vec<u8>, ReadProblem> {
        if let Some(files) = self.files {
            let path = without_parents(path);
            let file = files.iter().find(|(name, _)| Path::new(name) == path);
            let missing = || ReadProblem::Unreadable(io::ErrorKind::NotFound.into());
            return self.stream(file.ok_or_else(missing)?.1);
        }
        // Before it is opened: to open a pipe that nobody writes to would wait for ever.
        let facts = path.metadata().map_err(ReadProblem::Unreadable)?;
        if !facts.is_file() {
            return Err(ReadProblem::NotAFile);
        }
        if self.options.sandbox {
            self.keep_inside(path)?;
        }
        self.stream(File::open(path).map_err(ReadProblem::Unreadable)?)
    }

    /// All that comes from a reader, such as standard input.
    ///
    /// # Errors
    /// When it cannot be read, or is larger than the memory that is left.
    pub fn stream(&mut self, reader: impl Read) -> Result<Vec<u8>, ReadProblem> {
        let left = self.options.max_memory.saturating_sub(self.used);
        let mut bytes = Vec::new();
        let read = reader.take(left.saturating_add(1)).read_to_end(&mut bytes);
        self.claim(read.map_err(ReadProblem::Unreadable)? as u64)?;
        Ok(bytes)
    }

    fn keep_inside(&mut self, path: &Path) -> Result<(), ReadProblem> {
        let whole = path.canonicalize().map_err(ReadProblem::Unreadable)?;
        let folder = whole.parent().unwrap_or(&whole);
        let root = self.root.get_or_insert_with(|| folder.to_owned());
        if whole.starts_with(&*root) {
            Ok(())
        } else {
            Err(ReadProblem::Outside { folder: root.display().to_string() })
        }
    }

    /// Counts memory that is about to be taken, for a file's bytes or what is decoded from them.
    ///
    /// # Errors
    /// When it is more than is left.
    pub fn claim(&mut self, bytes: u64) -> Result<(), ReadProblem> {
        self.used = self.used.saturating_add(bytes);
        self.afford(0)
    }

    /// Checks that so much memory could be taken for a while; it is not counted.
    ///
    /// # Errors
    /// When it is more than is left.
    pub fn afford(&self, bytes: u64) -> Result<(), ReadProblem> {
        let limit = self.options.max_memory;
        if self.used.saturating_add(bytes) > limit {
            Err(ReadProblem::TooLarge { limit })
        } else {
            Ok(())
        }
    }

    /// Passes over a departure from the format's standard by which nothing is lost.
    ///
    /// # Errors
    /// When the reading is strict.
    pub fn tolerate(&self, place: impl fmt::Display, what: &str) -> Result<(), ReadProblem> {
        if self.options.strict {
            let (place, what) = (place.to_string(), what.to_owned());
            return Err(ReadProblem::NotStandard { place, what });
        }
        Ok(())
    }

    /// Notes a departure from the format's standard that `what` describes, with what it means for the
    /// result.
    ///
    /// # Errors
    /// When the reading is strict.
    pub fn note(&mut self, file: &str, place: &str, what: &str) -> Result<(), ReadProblem> {
        self.tolerate(place, what)?;
        self.remark(file, place, what);
        Ok(())
    }

    /// Notes what is lost although the format's standard allows it; a strict reading takes it too.
    pub fn remark(&mut self, file: &str, place: &str, what: &str) {
        let known = self.notes.iter_mut().find(|note| note.file == file && note.what == what);
        match known {
            Some(note) => note.count += 1,
            None => self.notes.push(Note {
                file: file.to_owned(),
                what: what.to_owned(),
                count: 1,
                first: place.to_owned(),
            }),
        }
    }

    /// What was noted, each kind once for a file, in the order in which it was met.
    pub fn into_notes(self) -> Vec<Note> {
        self.notes
    }
}

/// A path with `folder/..` left out.
fn without_parents(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        if part != Component::ParentDir || !short.pop() {
            short.push(part);
        }
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_in_memory_are_named_by_their_paths() {
        let mut reading = Reading::in_memory(&[("scenes/a", b"1"), ("b", b"2")]);
        let mut content = |path: &str| reading.file(Path::new(path));
        assert_eq!(content("scenes/a").expect("it is there"), b"1");
        assert_eq!(content("scenes/../b").expect("it is there"), b"2");
        for missing in ["a", "scenes/b", "../b", "/etc/passwd"] {
            assert!(matches!(content(missing), Err(ReadProblem::Unreadable(_))), "{missing}");
        }
    }
}
