//! Many mutants at once.

use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::format::{Format, corpus, files};
use crate::mutate::Mutator;
use crate::run::{Bench, Fault, Kind, Verdict};

/// Runs that making a finding smaller may take.
const REDUCTIONS: usize = 200;

/// What is tried.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// The program.
    pub program: PathBuf,
    /// The series of mutants.
    pub seed: u64,
    /// How many.
    pub mutants: u64,
    /// Of which formats, in turn.
    pub formats: Vec<Format>,
    /// Processes at a time.
    pub jobs: usize,
}

/// What became of the mutants of one format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Mutants that the program accepted.
    pub accepted: u64,
    /// Mutants that it refused as it should.
    pub refused: u64,
    /// Mutants that it was wrong about.
    pub faulty: u64,
    /// The longest time of one, all commands together.
    pub slowest: Duration,
}

impl Tally {
    /// Mutants tried.
    pub fn tried(&self) -> u64 {
        self.accepted + self.refused + self.faulty
    }

    fn count(&mut self, verdict: &Verdict, took: Duration) {
        match verdict {
            Verdict::Accepted => self.accepted += 1,
            Verdict::Refused(_) => self.refused += 1,
            Verdict::Faulty(_) => self.faulty += 1,
        }
        self.slowest = self.slowest.max(took);
    }

    fn add(&mut self, other: &Self) {
        self.accepted += other.accepted;
        self.refused += other.refused;
        self.faulty += other.faulty;
        self.slowest = self.slowest.max(other.slowest);
    }
}

/// A fault, and the first mutant that shows it.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The format.
    pub format: Format,
    /// The lowest number of such a mutant.
    pub number: u64,
    /// What it shows.
    pub fault: Fault,
    /// How many mutants show the like.
    pub count: u64,
}

/// Findings that say the same but for numbers and names are one.
type Findings = BTreeMap<(Format, Kind, String), Finding>;

/// What came of it.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// By format.
    pub tallies: BTreeMap<Format, Tally>,
    /// What must not be.
    pub findings: Vec<Finding>,
}

impl Campaign {
    /// The number of a mutant by its place: each number has one format, whichever are chosen.
    fn number(&self, place: u64) -> u64 {
        let chosen = self.formats.len() as u64;
        let format = self.formats[usize::try_from(place % chosen).unwrap_or_default()];
        let all = Format::ALL.len() as u64;
        let index = Format::ALL.iter().position(|other| *other == format).unwrap_or_default();
        place / chosen * all + index as u64
    }

    /// The format of a number.
    pub fn format(number: u64) -> Format {
        let place = number % Format::ALL.len() as u64;
        Format::ALL[usize::try_from(place).unwrap_or_default()]
    }

    /// Makes mutants of the seeds in the corpus.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn mutator(format: Format) -> io::Result<Mutator> {
        let seeds = files(&corpus().join(format.name()))?;
        Ok(Mutator::new(format, seeds.into_iter().map(|(_, bytes)| bytes).collect()))
    }

    /// Tries all of them; tells of each that is done, from any thread, and of a fault that is new.
    ///
    /// # Errors
    /// When the program cannot be started, or a folder not be read or written.
    pub fn run(&self, done: &(impl Fn(Option<&Finding>) + Sync)) -> io::Result<Outcome> {
        let mut mutators = BTreeMap::new();
        for &format in &self.formats {
            mutators.insert(format, Self::mutator(format)?);
        }
        let (next, stop) = (AtomicU64::new(0), AtomicBool::new(false));
        let findings = Mutex::new(Findings::new());
        let work = || -> io::Result<BTreeMap<Format, Tally>> {
            let mut bench = Bench::new(&self.program)?;
            let mut tallies: BTreeMap<Format, Tally> = BTreeMap::new();
            while !stop.load(Ordering::Relaxed) {
                let place = next.fetch_add(1, Ordering::Relaxed);
                if place >= self.mutants {
                    break;
                }
                let number = self.number(place);
                let format = Self::format(number);
                let mutant = mutators[&format].mutant(self.seed, number);
                let start = Instant::now();
                let verdict = bench.verdict(format, &mutant, number)?;
                tallies.entry(format).or_default().count(&verdict, start.elapsed());
                let Verdict::Faulty(fault) = verdict else {
                    done(None);
                    continue;
                };
                let finding = Finding { format, number, fault, count: 1 };
                let is_new = keep(&mut *findings.lock().map_err(|_| poisoned())?, finding.clone());
                done(is_new.then_some(&finding));
            }
            Ok(tallies)
        };
        let worker = || {
            let result = work();
            // What one cannot do, the others cannot either.
            stop.fetch_or(result.is_err(), Ordering::Relaxed);
            result
        };
        let tallies = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..self.jobs.max(1)).map(|_| scope.spawn(worker)).collect();
            let join = |worker: std::thread::ScopedJoinHandle<'_, _>| {
                worker.join().unwrap_or_else(|_| Err(poisoned()))
            };
            workers.into_iter().map(join).collect::<io::Result<Vec<_>>>()
        })?;
        let mut outcome = Outcome::default();
        for (format, tally) in tallies.iter().flatten() {
            outcome.tallies.entry(*format).or_default().add(tally);
        }
        let findings = findings.into_inner().map_err(|_| poisoned())?;
        outcome.findings = findings.into_values().collect();
        Ok(outcome)
    }

    /// A smaller file that shows the same fault: parts are left out as long as it does.
    ///
    /// # Errors
    /// As [`Campaign::run`].
    pub fn reduced(&self, finding: &Finding) -> io::Result<Vec<u8>> {
        let mut bytes = Self::mutator(finding.format)?.mutant(self.seed, finding.number);
        if finding.fault.kind == Kind::Time {
            return Ok(bytes);
        }
        let mut bench = Bench::new(&self.program)?;
        let same = finding.fault.class();
        let mut runs = 0;
        let mut part = bytes.len().div_ceil(2);
        while part > 0 {
            let mut at = 0;
            while at < bytes.len() && runs < REDUCTIONS {
                let end = bytes.len().min(at + part);
                let rest = [&bytes[..at], &bytes[end..]].concat();
                runs += 1;
                match bench.verdict(finding.format, &rest, finding.number)? {
                    Verdict::Faulty(fault)
                        if fault.kind == finding.fault.kind && fault.class() == same =>
                    {
                        bytes = rest;
                    }
                    _ => at = end,
                }
            }
            part /= 2;
        }
        Ok(bytes)
    }
}

fn poisoned() -> io::Error {
    io::Error::other("a thread of the fuzzer panicked")
}

/// Adds a finding; says whether it is the first of its kind.
fn keep(findings: &mut Findings, finding: Finding) -> bool {
    let key = (finding.format, finding.fault.kind, finding.fault.class());
    let Some(known) = findings.get_mut(&key) else {
        findings.insert(key, finding);
        return true;
    };
    let count = known.count + 1;
    if finding.number < known.number {
        *known = finding;
    }
    known.count = count;
    false
}

impl Fault {
    /// What it says, without what differs from file to file: numbers, and what is quoted.
    pub fn class(&self) -> String {
        let what = self.what.as_str();
        match self.kind {
            // The line of the code.
            Kind::Crash if what.starts_with("panicked at") => {
                what.split(' ').take(3).collect::<Vec<_>>().join(" ")
            }
            Kind::Crash | Kind::Disagreement => class_of(what),
            _ => what.split(':').next().unwrap_or_default().to_owned(),
        }
    }
}

/// The class of a message: its head without numbers and without what is quoted.
pub fn class_of(message: &str) -> String {
    let outside = message.split(['`', '"']).step_by(2).collect::<String>();
    outside.chars().filter(|c| !c.is_ascii_digit() && !"+-.".contains(*c)).take(80).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_keeps_its_format_whichever_are_chosen() {
        let campaign = |formats: Vec<Format>| Campaign {
            program: PathBuf::new(),
            seed: 1,
            mutants: 0,
            formats,
            jobs: 1,
        };
        let all = campaign(Format::ALL.to_vec());
        assert!((0..100).all(|place| all.number(place) == place));
        let two = campaign(vec![Format::Stl, Format::Exr]);
        let numbers: Vec<u64> = (0..4).map(|place| two.number(place)).collect();
        assert_eq!(numbers, [3, 12, 16, 25]);
        let formats: Vec<Format> = numbers.into_iter().map(Campaign::format).collect();
        assert_eq!(formats, [Format::Stl, Format::Exr, Format::Stl, Format::Exr]);
    }

    #[test]
    fn like_faults_are_one_finding() {
        let finding = |number, what: &str| Finding {
            format: Format::Ply,
            number,
            fault: Fault {
                kind: Kind::Disagreement,
                command: String::new(),
                what: what.to_owned(),
            },
            count: 1,
        };
        let mut findings = Findings::new();
        keep(&mut findings, finding(9, "line 3: `x` is bad"));
        keep(&mut findings, finding(5, "line 17: `y z` is bad"));
        keep(&mut findings, finding(7, "line 17: `y z` is worse"));
        let found: Vec<_> = findings.values().map(|f| (f.number, f.count)).collect();
        assert_eq!(found, [(5, 2), (7, 1)]);
    }
}
