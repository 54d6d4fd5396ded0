//! `trisect stress`: the stability study.

use anyhow::Result;
use trisect_harness::{Settings, StressSettings};

use crate::arguments::Stress;
use crate::compare::command;
use crate::progress::Bar;
use crate::{output, records, tasks};

/// How much is studied.
struct Size {
    pairs: usize,
    crack_rays: usize,
    watertight_rays: usize,
    fuzz: u64,
    rounds: usize,
}

const QUICK: Size =
    Size { pairs: 128, crack_rays: 4_000, watertight_rays: 200_000, fuzz: 200_000_000, rounds: 3 };
const FULL: Size = Size {
    pairs: 2_048,
    crack_rays: 100_000,
    watertight_rays: 10_000_000,
    fuzz: 2_000_000_000,
    rounds: 7,
};

/// Pairs that must be right within the limits.
const PROBES: usize = 32;

/// Studies, prints the summary, and adds page and record to the report.
pub(crate) fn run(arguments: &Stress) -> Result<()> {
    let size = if arguments.quick { QUICK } else { FULL };
    let methods = tasks::methods(&arguments.methods)?;
    output::check_folder(&arguments.output)?;

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
    };
    taken.lines.extend(trisect_harness::stress(&settings, &mut bar));
    drop(bar);

    let Stress { output, json, .. } = arguments;
    records::keep(&taken, output, "stress.jsonl", *json, records::publish_stress)
}
