//! Writing: to standard output, or to a file that is there whole or not at all.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Context as _, Result, anyhow, bail};
use serde::Serialize;

/// Refuses a folder that cannot be written, before any work is done for it.
pub(crate) fn check_folder(folder: &Path) -> Result<()> {
    check_folder_for(folder, "--output")
}

fn check_folder_for(folder: &Path, option: &str) -> Result<()> {
    fs::create_dir_all(folder)
        .and_then(|()| tempfile::Builder::new().prefix(".trisect-").tempfile_in(folder))
        .map(drop)
        .map_err(|error| {
            let folder = folder.display();
            anyhow!(
                "{folder}: cannot write to this folder ({error}); name another with {option}",
                error = without_path(&error)
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
    check_folder_for(folder_of(file), option)
}

/// What the system said, without the temporary file's name that was tried.
fn without_path(error: &io::Error) -> String {
    error
        .raw_os_error()
        .map_or_else(|| error.to_string(), |code| io::Error::from_raw_os_error(code).to_string())
}

/// The folder that a file lies in.
fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Writes a file beside its place, then renames it.
pub(crate) fn write_file(
    file: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<()> {
    trisect_harness::file::replace(file, write)
        .with_context(|| format!("{}: cannot write", file.display()))
}

/// Prints through a buffer.
pub(crate) fn print(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    write(&mut out)?;
    out.flush()?;
    Ok(())
}

/// Whether the reader of our output went away: no failure of ours.
pub(crate) fn is_closed_pipe(error: &anyhow::Error) -> bool {
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
