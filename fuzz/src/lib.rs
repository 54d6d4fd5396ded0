#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod campaign;
mod format;
mod layout;
mod mutate;
mod run;
mod words;

pub use campaign::{Campaign, Finding, Outcome, Tally, class_of};
pub use format::{Format, corpus, files};
pub use layout::seal;
pub use mutate::Mutator;
pub use run::{Bench, Fault, Judgement, Kind, MEMORY, TIME, Verdict, limit_memory, quick_folder};

use std::path::{Path, PathBuf};

/// The program: the one that is named, or the one beside the program that runs now.
///
/// # Errors
/// A message that says how to build it, where it is not there.
pub fn program(named: Option<&Path>) -> anyhow::Result<PathBuf> {
    let beside = || -> std::io::Result<PathBuf> {
        Ok(std::env::current_exe()?
            .with_file_name("trisect")
            .with_extension(std::env::consts::EXE_EXTENSION))
    };
    let program = named.map_or_else(beside, std::path::absolute)?;
    anyhow::ensure!(
        program.is_file(),
        "{}: there is no such program; build it with `cargo build --release`, or name one with --program",
        program.display()
    );
    Ok(program)
}
