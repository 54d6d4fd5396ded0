//! What the stability study can be asked for.

use clap::Args;
use trisect_catalog::Entry;

use crate::input::{count, methods};
use crate::shard::Shard;
use crate::study::StudyError;

/// Study what every method does in stiff and extreme cases: wrong decisions and errors against the
/// exact oracle on families of hard pairs, limits, cracks in closed surfaces, hostile input.
///
/// Prints a table, and adds the page stress.html and the record stress.jsonl to a report.
#[derive(Debug, Args)]
pub struct Settings {
    /// Methods, separated by commas; all if left out
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Seed of every random choice
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Fewer pairs and rays: two minutes instead of half an hour and more, on two cores
    #[arg(long)]
    pub quick: bool,
    /// Tests of hostile input in all [default: 2e9, or 2e8 with --quick]
    #[arg(long, value_name = "N", value_parser = count)]
    pub fuzz: Option<u64>,
    /// Nothing but N tests of methods that claim to be exact, against the oracle: no report
    #[arg(long, value_name = "N", value_parser = count, conflicts_with_all = ["quick", "fuzz"])]
    pub exact: Option<u64>,
    /// Only share I of N, from 1: its record alone, stress-I-of-N.jsonl in the folder; `trisect merge` makes
    /// the record of one run of all
    #[arg(long, value_name = "I/N", conflicts_with = "json")]
    pub shard: Option<Shard>,
}

/// How much is studied; a part with nothing to do is left out.
pub struct Stability {
    /// Seed of everything.
    pub seed: u64,
    /// The methods.
    pub methods: Vec<&'static Entry>,
    /// Samples of each kernel; without any, none is timed.
    pub rounds: usize,
    /// Pairs at each level of each family.
    pub pairs: usize,
    /// Pairs that must be right within the limits.
    pub probes: usize,
    /// Rays at each place of each closed surface, aimed at edges, and again at vertices.
    pub crack_rays: usize,
    /// The same in all for a form that claims to be watertight, at the offsets 0, 10³ and 10⁶.
    pub watertight_rays: usize,
    /// Tests of random bits and of other hostile input, over all methods and kernels.
    pub fuzz: u64,
    /// Tests of the methods that claim to be exact, against the oracle.
    pub exact: u64,
}

impl Stability {
    /// Nothing, to be filled in.
    pub fn nothing(seed: u64, methods: Vec<&'static Entry>) -> Self {
        Self {
            seed,
            methods,
            rounds: 0,
            pairs: 0,
            probes: 0,
            crack_rays: 0,
            watertight_rays: 0,
            fuzz: 0,
            exact: 0,
        }
    }
}

impl Settings {
    pub(super) fn plan(&self) -> Result<Stability, StudyError> {
        let nothing = Stability::nothing(self.seed, methods(&self.methods)?);
        if let Some(exact) = self.exact {
            if nothing.methods.iter().all(|entry| !entry.info.claims.exact) {
                return Err(StudyError::NoneExact);
            }
            return Ok(Stability { exact, ..nothing });
        }
        let full = Stability {
            rounds: 7,
            pairs: 2_048,
            probes: 32,
            crack_rays: 100_000,
            watertight_rays: 10_000_000,
            fuzz: self.fuzz.unwrap_or(2_000_000_000),
            exact: 1_000_000_000,
            ..nothing
        };
        Ok(if self.quick {
            Stability {
                rounds: 3,
                pairs: 128,
                crack_rays: 4_000,
                watertight_rays: 200_000,
                fuzz: self.fuzz.unwrap_or(200_000_000),
                exact: 10_000_000,
                ..full
            }
        } else {
            full
        })
    }
}
