//! `trisect pictures`: the study of pictures.

use std::num::NonZero;

use anyhow::Result;
use trisect_harness::PictureSettings;
use trisect_report::Chapter;

use crate::arguments::Pictures;
use crate::progress::Bar;
use crate::{records, tasks};

/// Studies, prints the summary, and adds page and record to the report.
pub(crate) fn run(arguments: &Pictures) -> Result<()> {
    let methods = tasks::methods(&arguments.methods)?;
    records::check(Chapter::Pictures, &arguments.output)?;
    let rounds = if arguments.quick { 3 } else { 7 };
    let mut bar = Bar::new();
    let mut taken = records::of_machine(arguments.seed, rounds, &mut bar)?;
    let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
    let settings = PictureSettings {
        seed: arguments.seed,
        methods,
        rounds,
        threads: arguments.threads.map_or(processors, usize::from),
        largest: if arguments.quick { 600 } else { u32::MAX },
        shrink: arguments.shrink,
    };
    taken.lines.extend(trisect_harness::pictures(&settings, &mut bar)?);
    drop(bar);

    let Pictures { output, json, .. } = arguments;
    records::keep(Chapter::Pictures, &taken, output, *json)
}
