//! `trisect-fuzz`: tries damaged files on the program.
#![forbid(unsafe_code)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context as _, Result};
use clap::Parser;
use indicatif::ProgressBar;
use trisect_fuzz::{Bench, Campaign, Finding, Format, Outcome, Verdict, limit_memory};

/// Gives damaged files to every reader of the program, each in a process of its own with 2 GB of memory and
/// 10 seconds, and prints what became of them.
///
/// A mutant is named by the seed and a number: the same everywhere. Exit code 0: nothing was found; 1:
/// something was, see the folder; 2: it cannot be tried; 3: this system has no limits on processes, skipped.
#[derive(Debug, Parser)]
#[command(max_term_width = 100)]
struct Arguments {
    /// How many, in digits or as 1e6
    #[arg(long, value_name = "N", default_value = "1e4", value_parser = count)]
    mutants: u64,
    /// Seed of every random choice
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Formats, separated by commas; all if left out
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = format)]
    formats: Vec<Format>,
    /// The program; the one beside this one if left out
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// Processes at a time; one for each processor if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Folder for what is found
    #[arg(long, value_name = "FOLDER", default_value = "target/fuzz-findings")]
    save: PathBuf,
    /// Try one mutant again, write it to the folder and print what the program makes of it
    #[arg(long, value_name = "SEED:N", value_parser = name, conflicts_with_all = ["mutants", "formats"])]
    reproduce: Option<(u64, u64)>,
}

/// A count, in digits or as `1e6`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole and in range")]
fn count(text: &str) -> Result<u64, String> {
    let asked: f64 = text.parse().map_err(|_| "not a number; give a count, as 1e6".to_owned())?;
    if asked.fract() == 0.0 && (1.0..=1e15).contains(&asked) {
        Ok(asked as u64)
    } else {
        Err("not a whole number from 1 to 1e15".to_owned())
    }
}

fn format(text: &str) -> Result<Format, String> {
    Format::named(text)
        .ok_or_else(|| format!("known are {}", Format::ALL.map(Format::name).join(", ")))
}

fn name(text: &str) -> Result<(u64, u64), String> {
    text.split_once(':')
        .and_then(|(seed, number)| seed.parse().ok().zip(number.parse().ok()))
        .ok_or_else(|| "give a seed and a number, as 1:4711".to_owned())
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("trisect-fuzz: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<ExitCode> {
    let program = trisect_fuzz::program(arguments.program.as_deref())?;
    if let Err(error) = limit_memory() {
        eprintln!("skipped: {error}");
        return Ok(ExitCode::from(3));
    }
    if let Some((seed, number)) = arguments.reproduce {
        return reproduce(&program, &arguments.save, seed, number);
    }
    let formats = match arguments.formats.as_slice() {
        [] => Format::ALL.to_vec(),
        chosen => Format::ALL.into_iter().filter(|format| chosen.contains(format)).collect(),
    };
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = arguments.jobs.map_or(processors, usize::from);
    let (seed, mutants) = (arguments.seed, arguments.mutants);
    let campaign = Campaign { program, seed, mutants, formats, jobs };
    let bar = ProgressBar::new(mutants);
    let start = Instant::now();
    let outcome = campaign.run(&|new| {
        if let Some(Finding { format, number, fault, .. }) = new {
            let (format, kind) = (format.name(), fault.kind.name());
            bar.suspend(|| eprintln!("{format} {kind} by {seed}:{number}: {}", fault.what));
        }
        bar.inc(1);
    })?;
    let seconds = start.elapsed().as_secs_f64();
    bar.finish_and_clear();
    print(&outcome);
    println!(
        "\n{mutants} mutants of seed {seed} in {seconds:.0} s, {:.0} a second, {jobs} at a time",
        mutants as f64 / seconds
    );
    if outcome.findings.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    for finding in &outcome.findings {
        let bytes = campaign.reduced(finding)?;
        report(finding, seed, &keep(&arguments.save, finding, &bytes)?);
    }
    Ok(ExitCode::FAILURE)
}

fn print(outcome: &Outcome) {
    println!(
        "{:8}{:>11}{:>11}{:>11}{:>10}{:>12}",
        "format", "tried", "accepted", "refused", "faulty", "slowest"
    );
    for (format, tally) in &outcome.tallies {
        println!(
            "{:8}{:>11}{:>11}{:>11}{:>10}{:>9.2} s",
            format.name(),
            tally.tried(),
            tally.accepted,
            tally.refused,
            tally.faulty,
            tally.slowest.as_secs_f64(),
        );
    }
}

fn report(finding: &Finding, seed: u64, file: &Path) {
    let Finding { format, number, fault, count } = finding;
    println!(
        "\n{} {}, {count} times, first by {seed}:{number}\n  {}\n  trisect {}\n  smaller: {}",
        format.name(),
        fault.kind.name(),
        fault.what,
        fault.command,
        file.display()
    );
}

/// Writes what was found to the folder; gives the file.
fn keep(
    folder: &Path,
    Finding { format, number, fault, .. }: &Finding,
    bytes: &[u8],
) -> Result<PathBuf> {
    let name = format!("{}-{}-{number}.{}", format.name(), fault.kind.name(), format.ending());
    let file = folder.join(name);
    fs::create_dir_all(folder).and_then(|()| fs::write(&file, bytes)).with_context(|| {
        format!("{}: cannot be written; name another with --save", folder.display())
    })?;
    Ok(file)
}

fn reproduce(program: &Path, folder: &Path, seed: u64, number: u64) -> Result<ExitCode> {
    let format = Campaign::format(number);
    let bytes = Campaign::mutator(format)?.mutant(seed, number);
    let verdict = Bench::new(program)?.verdict(format, &bytes, number)?;
    let (code, says) = match verdict {
        Verdict::Accepted => (ExitCode::SUCCESS, "accepted".to_owned()),
        Verdict::Refused(message) => (ExitCode::SUCCESS, format!("refused: {message}")),
        Verdict::Faulty(fault) => (
            ExitCode::FAILURE,
            format!("{}: {}\ntrisect {}", fault.kind.name(), fault.what, fault.command),
        ),
    };
    let file = folder.join(format!("{}-{seed}-{number}.{}", format.name(), format.ending()));
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&file, &bytes))
        .with_context(|| format!("{}: cannot be written", folder.display()))?;
    println!("{}, {} bytes\n{says}", file.display(), bytes.len());
    Ok(code)
}
