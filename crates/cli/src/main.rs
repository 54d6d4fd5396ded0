//! `trisect`: compares ray–triangle methods on your machine and your scene.
#![forbid(unsafe_code)]

mod arguments;
mod emit;
mod explain;
mod list;
mod output;
mod paint;
mod progress;
mod publish;
mod query;
mod reading;
mod recommend;
mod records;
mod render;
mod studies;
mod trace;
mod verify;

use std::process::ExitCode;

use anyhow::{Context as _, Result};
use clap::{CommandFactory as _, Parser as _};
use trisect_mesh::cut;
use trisect_studies::{StudyError, WrongAnswer};

use arguments::{Arguments, Verb};

/// The most characters of a message that are shown: names of files and what is quoted from them may hold
/// anything, and any amount of it.
const LONGEST: usize = 600;

fn main() -> ExitCode {
    match Arguments::try_parse() {
        Ok(arguments) => ended(run(arguments), ExitCode::SUCCESS),
        Err(message) => {
            let code = if message.use_stderr() { ExitCode::from(2) } else { ExitCode::SUCCESS };
            ended(output::print_by_clap(&message), code)
        }
    }
}

/// The manual page of the command, or of one of its commands, in roff.
fn manual_page(of: Option<&str>) -> Result<Vec<u8>> {
    let mut command = Arguments::command().name("trisect");
    command.build();
    if let Some(name) = of {
        let of_name = command.find_subcommand(name).cloned();
        command = of_name.with_context(|| {
            format!("unknown command `{name}`; `trisect --help` lists the commands")
        })?;
    }
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    Ok(page)
}

/// Does what is asked.
fn run(arguments: Arguments) -> Result<()> {
    match arguments.verb {
        None => studies::compare(&arguments.compare),
        Some(Verb::List(arguments)) => list::run(&arguments),
        Some(Verb::Measure(arguments)) => studies::measure(&arguments),
        Some(Verb::Merge(arguments)) => records::merge(&arguments),
        Some(Verb::Rank(arguments)) => records::rank(&arguments),
        Some(Verb::Cmp(arguments)) => records::compare(&arguments),
        Some(Verb::Report(arguments)) => records::report(&arguments),
        Some(Verb::Verify(arguments)) => verify::run(&arguments),
        Some(Verb::Study(choice)) => studies::run(&choice),
        Some(Verb::Trace(arguments)) => trace::run(&arguments),
        Some(Verb::Query(arguments)) => query::run(&arguments),
        Some(Verb::Render(arguments)) => render::run(&arguments),
        Some(Verb::Recommend(arguments)) => recommend::run(&arguments),
        Some(Verb::Explain(arguments)) => explain::run(&arguments),
        Some(Verb::Emit(arguments)) => emit::run(&arguments),
        Some(Verb::Completions { shell }) => output::print(|out| {
            // Into memory first: the generator panics where it cannot write.
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "trisect", &mut script);
            out.write_all(&script)
        }),
        Some(Verb::Man { command }) => {
            let page = manual_page(command.as_deref())?;
            output::print(|out| out.write_all(&page))
        }
    }
}

/// How the program ends: with `code` where all was done, and else with a line that says why not.
fn ended(done: Result<()>, code: ExitCode) -> ExitCode {
    match done {
        Ok(()) => code,
        Err(error) if output::is_closed_pipe(&error) => code,
        Err(error) => {
            output::say(format_args!("trisect: {}", cut(&format!("{error:#}"), LONGEST)));
            // 2: the input is at fault, as for clap's own errors; 1: trisect is.
            let is_ours =
                error.is::<WrongAnswer>() || error.downcast_ref().is_some_and(StudyError::is_a_bug);
            ExitCode::from(if is_ours { 1 } else { 2 })
        }
    }
}
