//! Writing: data to standard output, talk to standard error, and files that are there whole or not at
//! all.

use std::fmt::Display;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Error, Result, anyhow, bail};
use serde::Serialize;
use trisect_studies::file::{self, WriteError};

/// Columns of what is printed: a terminal's.
pub(crate) const COLUMNS: usize = 80;

/// Refuses a folder that cannot be written, before any work is done for it.
pub(crate) fn check_folder(folder: &Path) -> Result<()> {
    check_folder_for(folder, "--output")
}

fn check_folder_for(folder: &Path, option: &str) -> Result<()> {
    file::check_folder(folder).map_err(|error: WriteError| {
        let said = error.said();
        anyhow!(
            "{}: cannot write to this folder ({said}); name another with {option}",
            folder.display()
        )
    })
}

/// Refuses a place that a file cannot be written to, before any work is done for it.
pub(crate) fn check_file(file: &Path) -> Result<()> {
    check_file_for(file, "--output")
}

/// The same of a file that another option names.
pub(crate) fn check_file_for(file: &Path, option: &str) -> Result<()> {
    if file.is_dir() {
        bail!("{}: is a folder; name a file with {option}", file.display());
    }
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    check_folder_for(folder.unwrap_or(Path::new(".")), option)
}

/// Says something on standard error, in a line of its own.
///
/// A stream that is closed or full is no reason to fail, let alone to panic: what is asked for goes to
/// standard output, and whether it was done is in the exit code.
pub(crate) fn say(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// Prints through a buffer.
pub(crate) fn print(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    write(&mut out).and_then(|()| out.flush()).map_err(not_printed)
}

/// Why nothing was printed.
fn not_printed(error: io::Error) -> Error {
    Error::new(error).context("standard output: cannot be written")
}

/// Prints what is no value of ours: the help, the version, or why an argument is refused.
pub(crate) fn print_by_clap(message: &clap::Error) -> Result<()> {
    let printed = message.print();
    if message.use_stderr() {
        return Ok(());
    }
    printed.and_then(|()| io::stdout().flush()).map_err(not_printed)
}

/// Whether the reader of our output went away: no failure of ours.
pub(crate) fn is_closed_pipe(error: &Error) -> bool {
    error.chain().any(|cause| {
        cause
            .downcast_ref::<io::Error>()
            .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    })
}

/// Prints a value as JSON, or as text.
pub(crate) fn print_as(
    json: bool,
    value: &impl Serialize,
    text: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<()> {
    print(|out| {
        if json {
            serde_json::to_writer(&mut *out, value)?;
            writeln!(out)
        } else {
            text(out)
        }
    })
}

/// Prints a value as JSON, or its text.
pub(crate) fn show(value: &impl Serialize, text: &str, json: bool) -> Result<()> {
    print_as(json, value, |out| writeln!(out, "{}", text.trim_end()))
}
