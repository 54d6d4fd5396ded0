//! How long the renderer takes to compile, with all its instances.
//!
//! `cargo run --release -p trisect-render --example compile_time` has cargo compile this package alone, several
//! times, after what it depends on.

use std::error::Error;
use std::process::Command;
use std::time::{Duration, Instant};

use trisect_render::Part;

/// Compilations that are timed.
const ROUNDS: u32 = 5;

/// Compiles the package under a name that it was never compiled under, so that cargo cannot take what it has;
/// how long that took.
fn compile(round: u32) -> Result<Duration, Box<dyn Error>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let name = format!("compile_time=\"{}-{round}\"", std::process::id());
    let mut command = Command::new(cargo);
    command.args(["rustc", "--release", "--quiet", "-p", "trisect-render", "--lib"]);
    command.args(["--", "--cfg", &name]);
    let start = Instant::now();
    if !command.status()?.success() {
        return Err("cargo could not compile the renderer".into());
    }
    Ok(start.elapsed())
}

fn main() -> Result<(), Box<dyn Error>> {
    // What it depends on is compiled first.
    compile(0)?;
    let mut times = (1..=ROUNDS).map(compile).collect::<Result<Vec<_>, _>>()?;
    times.sort();
    let seconds = |at: usize| times[at].as_secs_f64();
    println!(
        "the renderer, {} instances: {:.1} s to compile ({:.1} to {:.1}, {ROUNDS} times, {} processors)",
        (1 << Part::COMPILED.len()) + 1,
        seconds(times.len() / 2),
        seconds(0),
        seconds(times.len() - 1),
        std::thread::available_parallelism()?,
    );
    Ok(())
}
