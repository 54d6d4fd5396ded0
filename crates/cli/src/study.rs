//! `trisect study`: the study of the tracer.

use std::num::NonZero;

use anyhow::Result;
use trisect_harness::{REFERENCE, Settings, StudySettings, keep_for_study};
use trisect_report::Chapter;
use trisect_workloads::{Mesh, hall};

use crate::arguments::Study;
use crate::compare::command;
use crate::progress::Bar;
use crate::{records, tasks};

/// How much is studied.
struct Size {
    /// Side, in pixels, of the picture whose rays meet a scene.
    pixels: usize,
    rounds: usize,
}

const QUICK: Size = Size { pixels: 160, rounds: 5 };
const FULL: Size = Size { pixels: 384, rounds: 5 };

/// Studies, prints the summary, and adds page and record to the report.
pub(crate) fn run(arguments: &Study) -> Result<()> {
    let size = if arguments.quick { QUICK } else { FULL };
    let Study { subjects, .. } = arguments;
    let mut methods = tasks::methods(&subjects.methods)?;
    let reference = tasks::method(REFERENCE)?;
    if methods.iter().all(|entry| entry.info.name != REFERENCE) {
        methods.insert(0, reference);
    }
    let scenes = tasks::meshes(subjects, || vec![Mesh::bunny(), hall()])?;
    tasks::say_all_rounding(subjects, &scenes);
    records::check(Chapter::Tracer, &arguments.output)?;

    let settings = Settings {
        command: command(),
        seed: subjects.seed,
        rounds: size.rounds,
        methods: methods.clone(),
        timed: true,
    };
    let mut bar = Bar::new();
    let timing = [tasks::timing(subjects.seed)];
    let mut taken = trisect_harness::measure(&settings, timing, &mut bar)?;
    taken.lines.retain(keep_for_study);
    let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
    let settings = StudySettings {
        seed: subjects.seed,
        methods,
        scenes,
        pixels: size.pixels,
        rounds: size.rounds,
        threads: arguments.threads.map_or(processors, usize::from),
    };
    taken.lines.extend(trisect_harness::study(&settings, &mut bar)?);
    drop(bar);

    let Study { output, json, .. } = arguments;
    records::keep(Chapter::Tracer, &taken, output, *json)
}
