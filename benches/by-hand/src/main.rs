//! Loops of hand-written intrinsics against the project's kernels of the same formula: called directly, and,
//! with the feature `catalogue`, as the catalogue has them. All take turns in one process, in an order drawn by
//! lot, and the fastest sample of each counts: it is the one that a machine's other work disturbs least.
//!
//! With `--record` it times forms of one test instead, and writes what `trisect report` reads.
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code, reason = "there is nothing by hand"))]

#[cfg(target_arch = "x86_64")]
mod calls;
#[cfg(all(feature = "catalogue", target_arch = "x86_64"))]
mod catalogue;
#[cfg(target_arch = "x86_64")]
mod contenders;
#[cfg(target_arch = "x86_64")]
mod isa;
#[cfg(target_arch = "x86_64")]
mod leaves;
#[cfg(target_arch = "x86_64")]
mod loops;

mod borders;
mod forms;
mod kernels;
mod record;
mod timed;

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Result, ensure};
use clap::Parser;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use serde::Serialize;
use trisect_workloads::random;

/// The seed of everything random here.
const SEED: u64 = 1;

/// Rays, and triangles: few enough for the first cache.
const SIDE: usize = 512;

/// How often every ray meets every triangle in a sample.
const REPEATS: u32 = 8;

/// Holds the kernels of four methods against loops of hand-written intrinsics, or writes a record of the forms of one
/// test, of what they decide on borders, and of what leaves and calls cost.
#[derive(Parser)]
struct Arguments {
    /// Print JSON.
    #[arg(long, conflicts_with = "record")]
    json: bool,
    /// Write a record of forms, which `trisect report` reads.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// What the record says of the compiler's settings, where they are not the project's: nothing but forms is timed.
    #[arg(long, value_name = "TEXT", default_value = "", requires = "record")]
    compiler: String,
    /// Samples of each contender, one per round; 100 if left out, and 21 of a record.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: Option<u16>,
    /// Only what has this in its name, as `wald f32×8 avx2 occlusion deferred`, or as
    /// `wald 8 avx2 one-ray early exits random` in a record.
    #[arg(long, default_value = "")]
    only: String,
}

/// What a run found; the same number for everyone who computes alike.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tally {
    hits: u64,
    sum: f64,
}

impl Tally {
    /// Counts a ray by its closest hit, and forgets that.
    fn take(&mut self, closest: &mut Option<f32>) {
        if let Some(t) = closest.take() {
            self.hits += 1;
            self.sum += f64::from(t);
        }
    }
}

/// What is compared: a method, lanes, what is asked, and when the division comes.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Comparison {
    method: &'static str,
    lanes: &'static str,
    asked: &'static str,
    division: &'static str,
}

/// How a contender came to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Written {
    /// In intrinsics.
    ByHand,
    /// In intrinsics, but for what the contract asks beyond the formula: `det` is not looked at.
    Bare,
    /// The kernel of the project, inlined into a loop here.
    Directly,
    /// The kernel of the catalogue.
    Catalogue,
}

/// Something to time.
struct Contender<'a> {
    comparison: Comparison,
    written: Written,
    run: Box<dyn Fn() -> Tally + 'a>,
    /// The fastest sample, in nanoseconds per test.
    least: f64,
}

/// The times of a comparison, in nanoseconds per test.
#[derive(Serialize)]
struct Row {
    #[serde(flatten)]
    comparison: Comparison,
    by_hand: Option<f64>,
    bare: Option<f64>,
    directly: Option<f64>,
    catalogue: Option<f64>,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    match &arguments.record {
        Some(path) => write_record(&arguments, path),
        None => compare(&arguments),
    }
}

/// Writes a record of forms.
fn write_record(arguments: &Arguments, path: &Path) -> Result<()> {
    let Arguments { compiler, only, rounds, .. } = arguments;
    let mut record = record::Record::new(rounds.unwrap_or(21).into());
    forms::time(&mut record, only, compiler)?;
    record.clock();
    if compiler.is_empty() {
        borders::decide(&mut record)?;
        #[cfg(target_arch = "x86_64")]
        {
            leaves::time(&mut record)?;
            calls::time(&mut record)?;
            record.clock();
        }
    }
    record.write(path)
}

/// Prints a table of kernels and loops by hand.
fn compare(arguments: &Arguments) -> Result<()> {
    let workload = random(SEED, SIDE, SIDE);
    let mut all = Vec::new();
    #[cfg(target_arch = "x86_64")]
    contenders::all(&workload, &mut all)?;
    all.retain(|contender| contender.comparison.to_string().contains(&arguments.only));
    ensure!(
        !all.is_empty(),
        "nothing to compare on this processor by the name {:?}",
        arguments.only
    );
    agree(&all)?;
    let tests = (workload.rays.len() * workload.triangles.len()) as f64;
    let rounds = arguments.rounds.unwrap_or(100);
    let mut order: Vec<usize> = (0..all.len()).collect();
    let mut lot = Pcg64::seed_from_u64(SEED);
    for _ in 0..rounds {
        order.shuffle(&mut lot);
        for &at in &order {
            let contender = &mut all[at];
            let start = Instant::now();
            for _ in 0..REPEATS {
                black_box((contender.run)());
            }
            let ns = start.elapsed().as_nanos() as f64 / f64::from(REPEATS) / tests;
            contender.least = contender.least.min(ns);
        }
    }
    let rows = rows(&all);
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&rows)?);
    } else {
        print(&rows, rounds);
    }
    Ok(())
}

/// Whether all contenders of each comparison find the same: loops that do something else are not compared.
fn agree(all: &[Contender<'_>]) -> Result<()> {
    for contender in all {
        let first = all.iter().find(|other| other.comparison == contender.comparison);
        let Some(first) = first else { continue };
        let (ours, theirs) = ((contender.run)(), (first.run)());
        // A sum in any order, of as many terms as there are hits, none of them negative.
        let slack = theirs.hits as f64 * f64::from(f32::EPSILON) * theirs.sum;
        ensure!(
            ours.hits == theirs.hits && (ours.sum - theirs.sum).abs() <= slack,
            "{}: {:?} found {ours:?}, {:?} {theirs:?}",
            contender.comparison,
            contender.written,
            first.written,
        );
    }
    Ok(())
}

fn rows(all: &[Contender<'_>]) -> Vec<Row> {
    let mut comparisons: Vec<&Comparison> = Vec::new();
    for Contender { comparison, .. } in all {
        if !comparisons.contains(&comparison) {
            comparisons.push(comparison);
        }
    }
    let row = |comparison: &Comparison| {
        let least = |written| {
            let same = |other: &&Contender<'_>| {
                other.comparison == *comparison && other.written == written
            };
            all.iter().find(same).map(|other| other.least)
        };
        Row {
            comparison: comparison.clone(),
            by_hand: least(Written::ByHand),
            bare: least(Written::Bare),
            directly: least(Written::Directly),
            catalogue: least(Written::Catalogue),
        }
    };
    comparisons.into_iter().map(row).collect()
}

fn print(rows: &[Row], rounds: u16) {
    println!(
        "ns per test, the least of {rounds} samples: {SIDE} random rays against {SIDE} random triangles; \
         in brackets the time over that of the loop by hand"
    );
    println!("{:52} {:>7} {:>7}  {:14}  {:14}", "", "by hand", "bare", "directly", "catalogue");
    for row in rows {
        let plain = |ns: Option<f64>| ns.map_or(String::new(), |ns| format!("{ns:.3}"));
        let over = |ns: Option<f64>| {
            let Some(ns) = ns else { return String::new() };
            row.by_hand.map_or(format!("{ns:.3}"), |hand| format!("{ns:.3} ({:.2})", ns / hand))
        };
        println!(
            "{:52} {:>7} {:>7}  {:14}  {:14}",
            row.comparison.to_string(),
            plain(row.by_hand),
            plain(row.bare),
            over(row.directly),
            over(row.catalogue)
        );
    }
}

impl<'a> Contender<'a> {
    fn new(comparison: Comparison, written: Written, run: impl Fn() -> Tally + 'a) -> Self {
        Self { comparison, written, run: Box::new(run), least: f64::INFINITY }
    }
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { method, lanes, asked, division } = self;
        write!(f, "{method} {lanes} {asked} {division}")
    }
}
