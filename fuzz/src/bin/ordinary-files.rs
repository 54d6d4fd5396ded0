//! `ordinary-files`: counts which mesh files of given folders the program loads.
#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, Result, ensure};
use clap::Parser;
use trisect_fuzz::{Bench, Format, class_of};

/// Files that may be refused, and why.
const REASONS: &str = include_str!("../../ordinary.txt");

/// Gives every mesh and glTF file in some folders to `trisect query` and `trisect render`, and counts which
/// are loaded, refused for a reason that their format gives (as listed in fuzz/ordinary.txt), or refused.
///
/// Exit code 0: none is refused without such a reason; 1: some are; 2: nothing can be tried.
#[derive(Debug, Parser)]
#[command(max_term_width = 100)]
struct Arguments {
    /// Folders, searched to their depths
    #[arg(value_name = "FOLDER", required = true)]
    folders: Vec<PathBuf>,
    /// The program; the one beside this one if left out
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
}

/// Of one format.
#[derive(Default)]
struct Counts {
    loaded: usize,
    /// Refused for a reason that the format gives.
    rightly: usize,
    refused: usize,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("ordinary-files: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<ExitCode> {
    let program = trisect_fuzz::program(arguments.program.as_deref())?;
    let mut files = Vec::new();
    for folder in &arguments.folders {
        collect(folder, &mut files)
            .with_context(|| format!("{}: cannot be searched", folder.display()))?;
    }
    ensure!(!files.is_empty(), "no file of .ply, .obj, .stl, .gltf or .glb in these folders");
    files.sort();
    let reasons: BTreeMap<&str, &str> =
        REASONS.lines().filter_map(|line| line.split_once('\t')).collect();
    let mut bench = Bench::new(&program)?;
    let mut counts: BTreeMap<Format, Counts> = BTreeMap::new();
    let mut refusals: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (format, file) in &files {
        let counts = counts.entry(*format).or_default();
        let refusal = bench.ordinary(*format, file)?.into_iter().find_map(|judgement| {
            judgement.map_err(|fault| format!("{}: {}", fault.kind.name(), fault.what)).transpose()
        });
        let Some(refusal) = refusal else {
            counts.loaded += 1;
            continue;
        };
        let reason = reasons.iter().find(|(ending, _)| file.ends_with(ending));
        let (Ok(message) | Err(message)) = &refusal;
        let message = message.replace(&format!("trisect: {}: ", file.display()), "");
        // What ends in a fault has no good reason.
        let title = if let (Ok(_), Some((_, reason))) = (&refusal, reason) {
            counts.rightly += 1;
            format!("for a reason of its format, {reason}")
        } else {
            counts.refused += 1;
            class_of(&message)
        };
        refusals.entry(title).or_default().push(format!("{}: {message}", file.display()));
    }
    for (title, lines) in refusals {
        println!("{} refused: {}", lines.len(), title.trim());
        for line in lines {
            println!("  {line}");
        }
    }
    let (mut right, mut wrong) = (0, 0);
    println!("\nformat  files  loaded  refused for a reason  refused");
    for (format, Counts { loaded, rightly, refused }) in &counts {
        let all = loaded + rightly + refused;
        println!("{:6}{all:>7}{loaded:>8}{rightly:>22}{refused:>9}", format.name());
        right += loaded + rightly;
        wrong += refused;
    }
    let all = right + wrong;
    println!("{right} of {all} load, or are refused for a reason that their format gives");
    Ok(if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The mesh files of a folder and those in it.
fn collect(folder: &Path, files: &mut Vec<(Format, PathBuf)>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        if entry.file_type()?.is_dir() {
            collect(&path, files)?;
        } else if let Some(format) = Format::of(&path).filter(|format| format.is_mesh()) {
            files.push((format, path));
        }
    }
    Ok(())
}
