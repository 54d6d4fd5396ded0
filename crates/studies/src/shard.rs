//! One record from several machines: each takes its share of the parts of a study, and the shares are merged into the
//! record of one run.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::noise::Noise;
use crate::record::{Header, Line, LineKind, Records};

/// Which share of a study a run takes: `I/N`, from 1. Parts are dealt out in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Shard {
    /// Which it is, from 1.
    pub index: usize,
    /// How many there are.
    pub count: usize,
}

impl Shard {
    /// Whether a part of the study, by its number, belongs to it.
    pub(crate) fn has(self, part: usize) -> bool {
        part % self.count + 1 == self.index
    }

    /// The name of the file that such a shard of a study's record is.
    pub fn file(self, study: &str) -> String {
        let Self { index, count } = self;
        format!("{study}-{index}-of-{count}.jsonl")
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |text: &str| text.parse().ok().filter(|&number| number > 0_usize);
        let shard = text
            .split_once('/')
            .and_then(|(index, count)| Some(Self { index: parse(index)?, count: parse(count)? }));
        shard
            .filter(|shard| shard.index <= shard.count)
            .ok_or_else(|| "no shard; give I/N with I from 1 to N, as 3/8".to_owned())
    }
}

/// In a shard, the number of the part of the study that the lines below belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Part {
    pub(crate) number: usize,
}

impl LineKind for Part {
    const NAME: &'static str = "part";
}

/// Why shards make no record. Each message names the file.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// There is nothing to merge.
    #[error("no shards are given; name their files")]
    None,
    /// A record is whole.
    #[error("{0}: is no shard of a record; take one with --shard")]
    NoShard(String),
    /// A shard is of another run.
    #[error(
        "{file}: its {what} is not that of {first}; merge shards of one command, taken by one version on processors with the same instruction sets"
    )]
    Differs {
        /// The shard.
        file: String,
        /// In what it differs.
        what: &'static str,
        /// From which it does.
        first: String,
    },
    /// A shard is given twice.
    #[error("{file}: shard {shard} is given already; name each once")]
    Twice {
        /// The second of them.
        file: String,
        /// Which it is.
        shard: Shard,
    },
    /// Shards are missing.
    #[error("shards are missing: {}; take them with --shard", missing.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))]
    Missing {
        /// Which.
        missing: Vec<Shard>,
    },
    /// Two shards hold the same part.
    #[error("{file}: holds a part of the study that another shard holds; take it anew")]
    Overlap {
        /// The second of them.
        file: String,
    },
}

/// The record of one run, from all shards of it, each with the name of its file: the same lines in the same order, but for
/// times. What is said of the machine is that of the first shard, and it was as unsteady as the worst.
///
/// # Errors
/// When they are not all shards of one run, or not all of them.
pub fn merge(mut shards: Vec<(String, Records)>) -> Result<Records, MergeError> {
    if let Some((name, _)) = shards.iter().find(|(_, records)| records.header.shard.is_none()) {
        return Err(MergeError::NoShard(name.clone()));
    }
    shards.sort_by_key(|(_, records)| records.header.shard);
    let Some((first, Records { header, .. })) = shards.first() else {
        return Err(MergeError::None);
    };
    let mut merged = Header { shard: None, ..header.clone() };
    let count = header.shard.map_or(0, |shard| shard.count);
    let mut missing: Vec<Shard> = (1..=count).map(|index| Shard { index, count }).collect();
    for (file, Records { header, .. }) in &shards {
        if let Some(what) = difference(&merged, count, header) {
            let (file, first) = (file.clone(), first.clone());
            return Err(MergeError::Differs { file, what, first });
        }
        missing.retain(|&other| Some(other) != header.shard);
        merged.started = merged.started.min(header.started.clone());
        merged.noise = worse(merged.noise, header.noise);
    }
    for pair in shards.windows(2) {
        let [(_, a), (file, b)] = pair else { continue };
        if let (true, Some(shard)) = (a.header.shard == b.header.shard, b.header.shard) {
            return Err(MergeError::Twice { file: file.clone(), shard });
        }
    }
    if !missing.is_empty() {
        return Err(MergeError::Missing { missing });
    }
    Ok(Records { header: merged, lines: lines(shards)? })
}

/// In what a shard differs from the first of a run of so many.
fn difference(first: &Header, count: usize, other: &Header) -> Option<&'static str> {
    let sets = |header: &Header| header.machine.instruction_sets.clone();
    let checks = [
        ("study", first.study == other.study),
        ("command", first.command == other.command),
        ("number of shards", other.shard.is_some_and(|shard| shard.count == count)),
        ("version", (first.schema, &first.trisect) == (other.schema, &other.trisect)),
        ("seed", (first.seed, first.rounds) == (other.seed, other.rounds)),
        ("processor", sets(first) == sets(other)),
    ];
    checks.into_iter().find(|(_, is_same)| !is_same).map(|(what, _)| what)
}

fn worse(a: Option<Noise>, b: Option<Noise>) -> Option<Noise> {
    let (Some(x), Some(y)) = (a, b) else { return a.or(b) };
    let stolen = x.stolen.zip(y.stolen).map(|(x, y)| x.max(y)).or(x.stolen).or(y.stolen);
    Some(Noise { stolen, drift: x.drift.max(y.drift), spread: x.spread.max(y.spread) })
}

/// The lines of all parts, in the order of their numbers. Where several shards did a part together, each line is one of
/// theirs.
fn lines(shards: Vec<(String, Records)>) -> Result<Vec<Line>, MergeError> {
    struct OfPart {
        part: usize,
        file: usize,
        lines: Vec<Line>,
    }
    let mut parts: Vec<OfPart> = Vec::new();
    let mut names = Vec::new();
    for (file, (name, records)) in shards.into_iter().enumerate() {
        names.push(name);
        for line in records.lines {
            if let Some(&Part { number }) = line.get() {
                parts.push(OfPart { part: number, file, lines: Vec::new() });
            } else if let Some(last) = parts.last_mut().filter(|last| last.file == file) {
                last.lines.push(line);
            }
        }
    }
    parts.sort_by_key(|of| of.part);
    let mut merged: Vec<Line> = Vec::new();
    // Where the lines of the part before begin, and its number.
    let mut before = None;
    for OfPart { part, file, lines } in parts {
        match before {
            Some((start, same)) if same == part => {
                let there: &mut [Line] = &mut merged[start..];
                let is_joined = there.len() == lines.len()
                    && there.iter_mut().zip(&lines).all(|(line, other)| line.join(other));
                if !is_joined {
                    return Err(MergeError::Overlap { file: names.swap_remove(file) });
                }
            }
            _ => {
                before = Some((merged.len(), part));
                merged.extend(lines);
            }
        }
    }
    Ok(merged)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_written_as_they_are_read() {
        let shard: Shard = "3/8".parse().expect("it is one");
        assert_eq!((shard, shard.to_string().as_str()), (Shard { index: 3, count: 8 }, "3/8"));
        assert_eq!(shard.file("stress"), "stress-3-of-8.jsonl");
        for wrong in ["", "3", "0/8", "9/8", "3/0", "-1/2", "1/2/3", "a/b"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn every_part_belongs_to_one_shard() {
        for part in 0..20 {
            let shards = (1..=7).map(|index| Shard { index, count: 7 });
            assert_eq!(shards.filter(|shard| shard.has(part)).count(), 1);
        }
    }
}
