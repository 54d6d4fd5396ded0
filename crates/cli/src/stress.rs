//! `trisect stress`: the stability study.

use anyhow::{Result, bail};
use trisect_catalog::Entry;
use trisect_harness::{NotExact, Settings, StressSettings};
use trisect_report::{Chapter, exactness_summary};

use crate::arguments::Stress;
use crate::compare::command;
use crate::progress::Bar;
use crate::{records, tasks};

/// How much is studied.
struct Size {
    pairs: usize,
    crack_rays: usize,
    watertight_rays: usize,
    fuzz: u64,
    exact: u64,
    rounds: usize,
}

const QUICK: Size = Size {
    pairs: 128,
    crack_rays: 4_000,
    watertight_rays: 200_000,
    fuzz: 200_000_000,
    exact: 10_000_000,
    rounds: 3,
};
const FULL: Size = Size {
    pairs: 2_048,
    crack_rays: 100_000,
    watertight_rays: 10_000_000,
    fuzz: 2_000_000_000,
    exact: 1_000_000_000,
    rounds: 7,
};

/// Pairs that must be right within the limits.
const PROBES: usize = 32;

/// Studies, prints the summary, and adds page and record to the report.
pub(crate) fn run(arguments: &Stress) -> Result<()> {
    let size = if arguments.quick { QUICK } else { FULL };
    let methods = tasks::methods(&arguments.methods)?;
    if let Some(tests) = arguments.exact {
        return hold_to_exactness(arguments, methods, tests);
    }
    records::check(Chapter::Stress, &arguments.output)?;

    let settings = Settings {
        command: command(),
        seed: arguments.seed,
        rounds: size.rounds,
        methods: methods.clone(),
        timed: true,
    };
    let timing = [tasks::timing(arguments.seed)];
    let mut bar = Bar::new();
    let mut taken = trisect_harness::measure(&settings, timing, &mut bar)?;
    let settings = StressSettings {
        seed: arguments.seed,
        methods,
        pairs: size.pairs,
        probes: PROBES,
        crack_rays: size.crack_rays,
        watertight_rays: size.watertight_rays,
        fuzz: arguments.fuzz.unwrap_or(size.fuzz),
        exact: size.exact,
    };
    taken.lines.extend(trisect_harness::stress(&settings, &mut bar));
    drop(bar);

    let Stress { output, json, .. } = arguments;
    records::keep(Chapter::Stress, &taken, output, *json)
}

/// Nothing but methods that claim to be exact against the oracle, in so many tests.
fn hold_to_exactness(arguments: &Stress, methods: Vec<&'static Entry>, tests: u64) -> Result<()> {
    if methods.iter().all(|entry| !entry.info.claims.exact) {
        bail!("none of these methods claims to be exact; `trisect list --json` says which do");
    }
    let nothing = StressSettings::nothing(arguments.seed, methods);
    let settings = StressSettings { exact: tests, ..nothing };
    let mut bar = Bar::new();
    let lines = trisect_harness::stress(&settings, &mut bar);
    drop(bar);
    let summary = exactness_summary(&lines);
    records::show(&summary, &summary.to_text(records::COLUMNS), arguments.json)?;
    if summary.total().all_wrong() > 0 {
        return Err(NotExact(summary.first_wrong.unwrap_or_default()).into());
    }
    Ok(())
}
