//! Facts about the machine that a record was made on.

use std::hint::black_box;
use std::time::Instant;

use sysinfo::{CpuRefreshKind, RefreshKind, System};
use trisect_core::InstructionSet;

use crate::Machine;

/// Operations in the chain that the frequency is measured by.
const LINKS: u32 = 100_000;

/// Cycles of one link: an integer multiplication (three on every 64-bit core of the last decade)
/// and a bitwise or (one).
const CYCLES_PER_LINK: f64 = 4.0;

/// The facts, but for the frequency, which is measured along with everything else.
pub fn facts() -> Machine {
    let system = System::new_with_specifics(
        RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing().with_frequency()),
    );
    let cpu = system
        .ok()
        .and_then(|system| Some(system.cpus().first()?.brand().trim().to_owned()))
        .filter(|brand| !brand.is_empty());
    Machine {
        cpu: cpu.unwrap_or_else(|| "unknown processor".to_owned()),
        logical_cpus: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        instruction_sets: instruction_sets().collect(),
        platform: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        compiler: env!("TRISECT_COMPILER").to_owned(),
        build: env!("TRISECT_BUILD").to_owned(),
        core_ghz: 0.0,
    }
}

/// The instruction sets of this processor, weakest first.
pub fn instruction_sets() -> impl Iterator<Item = InstructionSet> {
    InstructionSet::ALL.iter().copied().filter(|set| set.is_available())
}

/// The frequency of the core at this moment, in GHz, from a chain of dependent operations.
pub fn core_ghz() -> f64 {
    let mut x = black_box(3_u64);
    let start = Instant::now();
    for _ in 0..LINKS {
        x = x.wrapping_mul(x) | 1;
    }
    black_box(x);
    let ns = start.elapsed().as_nanos().max(1);
    f64::from(LINKS) * CYCLES_PER_LINK / ns as f64
}
