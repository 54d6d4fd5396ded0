//! What is printed: a table for people, JSON for programs.

use std::io::Write as _;
use std::time::Duration;

use anyhow::Result;
use serde::Serialize;
use trisect_report::stats::{geometric_mean, median};
use trisect_studies::record::Machine;
use trisect_studies::{machine, nanoseconds};
use trisect_workloads::Mesh;

use crate::contender::{Answers, Resident, Standing};
use crate::settle::{Settlement, Verdict};

/// Everything that is printed.
#[derive(Serialize)]
pub(crate) struct Report {
    machine: Machine,
    /// Threads that built.
    threads: usize,
    repeat: usize,
    builds: Vec<Built>,
    races: Vec<Race>,
}

/// The trees of one mesh.
#[derive(Serialize)]
struct Built {
    mesh: String,
    triangles: usize,
    trees: Vec<BuiltTree>,
}

#[derive(Serialize)]
struct BuiltTree {
    name: String,
    /// Of each build.
    samples_ns: Vec<u64>,
    median_ms: f64,
    bytes: Option<usize>,
}

/// A class of rays.
#[derive(Serialize)]
pub(crate) struct Class {
    pub(crate) name: String,
    pub(crate) any: bool,
    pub(crate) rays: usize,
}

/// All contenders on one class of rays of one mesh.
#[derive(Serialize)]
struct Race {
    mesh: String,
    #[serde(flatten)]
    class: Class,
    contenders: Vec<Raced>,
    differing: usize,
    settled: usize,
    sampled: usize,
    examples: Vec<crate::settle::Example>,
}

#[derive(Serialize)]
struct Raced {
    name: String,
    /// Of each repetition.
    samples_ns: Vec<u64>,
    /// From the median.
    million_rays_per_second: f64,
    /// Speed over that of each other contender: the median over the repetitions.
    times: Vec<f64>,
    hits: usize,
    /// Over the closest hits.
    sum_t: f64,
    verdict: Verdict,
}

impl Report {
    pub(crate) fn new(threads: usize, repeat: usize) -> Self {
        let machine = machine::facts();
        Self { machine, threads, repeat, builds: Vec::new(), races: Vec::new() }
    }

    pub(crate) fn built(&mut self, mesh: &Mesh, trees: &[Standing]) {
        let trees = trees
            .iter()
            .map(|Standing { name, builds, bytes }| BuiltTree {
                name: name.clone(),
                samples_ns: builds.iter().copied().map(nanoseconds).collect(),
                median_ms: median_of(builds) * 1e3,
                bytes: *bytes,
            })
            .collect();
        let (mesh, triangles) = (mesh.name.clone(), mesh.triangles.len());
        self.builds.push(Built { mesh, triangles, trees });
    }

    pub(crate) fn raced(
        &mut self,
        class: Class,
        residents: &[Resident],
        times: &[Vec<Duration>],
        answers: &[Answers],
        settlement: Settlement,
    ) {
        let Settlement { differing, settled, sampled, verdicts, examples } = settlement;
        let contenders = residents
            .iter()
            .zip(times)
            .zip(answers)
            .zip(verdicts)
            .map(|(((resident, mine), answers), verdict)| {
                let against = |others: &Vec<Duration>| {
                    let ratios: Vec<f64> = mine
                        .iter()
                        .zip(others)
                        .map(|(mine, other)| other.as_secs_f64() / mine.as_secs_f64())
                        .collect();
                    median(&ratios).unwrap_or(f64::NAN)
                };
                let (hits, sum_t) = match answers {
                    Answers::Any(found) => (found.iter().filter(|found| **found).count(), 0.0),
                    Answers::Closest(found) => (
                        found.iter().flatten().count(),
                        found.iter().flatten().map(|found| f64::from(found.t)).sum(),
                    ),
                };
                Raced {
                    name: resident.name.clone(),
                    samples_ns: mine.iter().copied().map(nanoseconds).collect(),
                    million_rays_per_second: class.rays as f64 / median_of(mine) / 1e6,
                    times: times.iter().map(against).collect(),
                    hits,
                    sum_t,
                    verdict,
                }
            })
            .collect();
        let mesh = self.builds.last().map(|built| built.mesh.clone()).unwrap_or_default();
        self.races.push(Race { mesh, class, contenders, differing, settled, sampled, examples });
    }

    /// # Errors
    /// When standard output takes no more.
    pub(crate) fn print(&self, json: bool) -> Result<()> {
        let mut out = std::io::stdout().lock();
        if json {
            serde_json::to_writer(&mut out, self)?;
            writeln!(out)?;
            return Ok(());
        }
        let Machine { cpu, instruction_sets, compiler, .. } = &self.machine;
        let best = instruction_sets.last().map_or("no instruction set", |set| set.name());
        writeln!(
            out,
            "{cpu}, {best}, {compiler}; built on {} thread(s), traced on one",
            self.threads
        )?;
        for built in &self.builds {
            writeln!(out, "\n{}: {} triangles", built.mesh, built.triangles)?;
            writeln!(out, "{:24} {:>10} {:>10}", "tree", "ms", "MB")?;
            for BuiltTree { name, median_ms, bytes, .. } in &built.trees {
                let bytes =
                    bytes.map_or("-".to_owned(), |bytes| format!("{:.1}", bytes as f64 / 1e6));
                writeln!(out, "{name:24} {median_ms:>10.1} {bytes:>10}")?;
            }
            for race in self.races.iter().filter(|race| race.mesh == built.mesh) {
                race.print(&mut out)?;
            }
        }
        self.print_means(&mut out)?;
        Ok(())
    }

    /// Over all races, each contender's speed relative to that of the first one.
    fn print_means(&self, out: &mut impl std::io::Write) -> Result<()> {
        let Some(first) = self.races.first() else { return Ok(()) };
        let classes: Vec<&str> = {
            let mut names: Vec<&str> = self.races.iter().map(|race| &race.class.name[..]).collect();
            names.sort_unstable();
            names.dedup();
            names
        };
        let reference = first.reference();
        writeln!(
            out,
            "\nspeed over {}, geometric mean of the meshes",
            first.contenders[reference].name
        )?;
        write!(out, "{:24}", "")?;
        for class in &classes {
            write!(out, " {class:>10}")?;
        }
        writeln!(out, " {:>10}", "all")?;
        for (place, contender) in first.contenders.iter().enumerate() {
            write!(out, "{:24}", contender.name)?;
            let of = |class: Option<&str>| {
                let races = self
                    .races
                    .iter()
                    .filter(|race| class.is_none_or(|class| race.class.name == class));
                geometric_mean(races.map(|race| race.contenders[place].times[reference]))
                    .unwrap_or(f64::NAN)
            };
            for class in &classes {
                write!(out, " {:>10.2}", of(Some(class)))?;
            }
            writeln!(out, " {:>10.2}", of(None))?;
        }
        Ok(())
    }
}

impl Race {
    /// The contender that the others are compared with: Embree's single rays, or else the first.
    fn reference(&self) -> usize {
        self.contenders.iter().position(|contender| contender.name == "embree").unwrap_or(0)
    }

    fn print(&self, out: &mut impl std::io::Write) -> Result<()> {
        let Self { class, differing, settled, sampled, .. } = self;
        let kind = if class.any { "any hit" } else { "closest hit" };
        writeln!(
            out,
            "\n{} {}, {} rays, {kind}; {differing} answered differently, {settled} settled and \
             {sampled} sampled",
            self.mesh, class.name, class.rays
        )?;
        writeln!(
            out,
            "{:24} {:>8} {:>6} {:>8} {:>6} {:>6} {:>6} {:>6}",
            "", "Mrays/s", "times", "hits", "close", "beside", "missed", "wrong"
        )?;
        let reference = self.reference();
        for contender in &self.contenders {
            let Verdict { close, beside, missed, .. } = contender.verdict;
            writeln!(
                out,
                "{:24} {:>8.2} {:>6.2} {:>8} {close:>6} {beside:>6} {missed:>6} {:>6}",
                contender.name,
                contender.million_rays_per_second,
                contender.times[reference],
                contender.hits,
                contender.verdict.wrong(),
            )?;
        }
        Ok(())
    }
}

/// In seconds.
fn median_of(times: &[Duration]) -> f64 {
    median(&times.iter().map(Duration::as_secs_f64).collect::<Vec<_>>()).unwrap_or(f64::NAN)
}
