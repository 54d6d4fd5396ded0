//! How fast the catalogue's kernels are against their own scalars and against hand-written
//! intrinsics: everything in one run, in rounds of random order, compared round by round.
#![deny(unsafe_code)]

use std::hint::black_box;
use std::time::{Duration, Instant};

use anyhow::{Result, ensure};
use clap::Parser;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use serde::Serialize;
use trisect_benches::{SEED, kernel_name, workloads};
use trisect_catalog::{Arrangement, Kernel, Scene, Tally, entries};
use trisect_core::Float;
use trisect_harness::machine;
use trisect_harness::record::Machine;
use trisect_workloads::Workload;

/// The method that the intrinsics are written for.
const BY_HAND: &str = "moller-trumbore";

/// A sample takes at least this long, so that the clock's own steps do not show.
const SAMPLE: Duration = Duration::from_millis(1);

/// Holds the fastest kernel of every method against its scalar, and the kernels of one method
/// against hand-written intrinsics.
#[derive(Parser)]
struct Arguments {
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Samples of each contender, one per round.
    #[arg(long, default_value_t = 31, value_parser = clap::value_parser!(u16).range(31..))]
    rounds: u16,
}

/// Everything that is printed.
#[derive(Serialize)]
struct Yardstick {
    machine: Machine,
    rounds: u16,
    workloads: Vec<Measured>,
}

/// One workload.
#[derive(Serialize)]
struct Measured {
    workload: String,
    rays: usize,
    triangles: usize,
    methods: Vec<AgainstScalar>,
    intrinsics: Vec<AgainstIntrinsics>,
}

/// A method's fastest lanes against its scalars.
#[derive(Serialize)]
struct AgainstScalar {
    method: &'static str,
    best: Timing,
    published: Timing,
    fastest_scalar: Timing,
    times_published: Ratio,
    times_fastest_scalar: Ratio,
}

/// A kernel against the intrinsics of the same formula and tests.
#[derive(Serialize)]
struct AgainstIntrinsics {
    kernel: Timing,
    intrinsics: Timing,
    hits: u64,
    /// Time of the kernel over time of the intrinsics.
    time: Ratio,
}

/// A contender and its median.
#[derive(Clone, Serialize)]
struct Timing {
    name: String,
    ns_per_test: f64,
}

/// Of the ratios of each round.
#[derive(Clone, Copy, Serialize)]
struct Ratio {
    median: f64,
    lower_quartile: f64,
    upper_quartile: f64,
}

/// What is timed: a kernel on its scene, or a loop of intrinsics on its blocks.
struct Contender<'a> {
    name: String,
    run: Box<dyn Fn() -> Tally + 'a>,
    tally: Tally,
    repeats: u32,
    ns: Vec<f64>,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut yardstick =
        Yardstick { machine: machine::facts(), rounds: arguments.rounds, workloads: Vec::new() };
    let mut random = Pcg64::seed_from_u64(SEED);
    let mut ghz = Vec::new();
    for workload in workloads() {
        yardstick.workloads.push(measure(&workload, arguments.rounds, &mut random)?);
        ghz.push(machine::core_ghz());
    }
    yardstick.machine.core_ghz = quantile(&mut ghz, 0.5);
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&yardstick)?);
    } else {
        print(&yardstick);
    }
    Ok(())
}

/// Whether a kernel takes part: f32 with full hits, as scalar or on the best instruction set here.
fn takes_part(kernel: &Kernel, all: &[Kernel]) -> bool {
    let best = all
        .iter()
        .map(|other| other.variant.lane.instruction_set)
        .filter(|set| set.is_available())
        .max();
    let lane = kernel.variant.lane;
    kernel.needs == "barycentrics" && (lane.width == 1 || Some(lane.instruction_set) == best)
}

fn measure(workload: &Workload, rounds: u16, random: &mut Pcg64) -> Result<Measured> {
    let (triangles, rays) = (&workload.triangles, &workload.rays);
    let tests = (rays.len() * triangles.len()) as f64;
    let scenes: Vec<Scene> =
        entries().iter().map(|entry| (entry.f32.prepare)(triangles, rays)).collect();
    let mut contenders: Vec<Contender<'_>> = Vec::new();
    let mut kernels: Vec<(&'static str, &'static Kernel)> = Vec::new();
    for (entry, scene) in entries().iter().zip(&scenes) {
        let timed = &entry.f32.timed;
        for kernel in timed.iter().filter(|kernel| takes_part(kernel, timed)) {
            kernels.push((entry.info.name, kernel));
            contenders.push(Contender::new(kernel_name(kernel), || kernel.run(scene)));
        }
    }
    #[cfg(target_arch = "x86_64")]
    let by_hand = {
        use trisect_benches::intrinsics;
        let blocks = intrinsics::prepare(triangles);
        let first = contenders.len();
        let loops = intrinsics::loops();
        for by_hand in &loops {
            let name = format!(
                "intrinsics f32x{} {}{}",
                by_hand.width,
                by_hand.instruction_set,
                if by_hand.early_out { " early-out" } else { "" }
            );
            let (run, blocks) = (*by_hand, blocks.clone());
            contenders.push(Contender::new(name, move || run.run(rays, &blocks)));
        }
        loops
            .iter()
            .enumerate()
            .map(|(i, by_hand)| (first + i, by_hand.instruction_set, by_hand.early_out))
            .collect::<Vec<_>>()
    };
    #[cfg(not(target_arch = "x86_64"))]
    let by_hand: Vec<(usize, trisect_core::InstructionSet, bool)> = Vec::new();

    let mut order: Vec<usize> = (0..contenders.len()).collect();
    for _ in 0..rounds {
        order.shuffle(random);
        for &i in &order {
            contenders[i].sample()?;
        }
    }

    let timing = |i: usize| Timing {
        name: contenders[i].name.clone(),
        ns_per_test: contenders[i].median() / tests,
    };
    let ratio = |i: usize, j: usize| Ratio::of(&contenders[i].ns, &contenders[j].ns);
    let methods = entries()
        .iter()
        .map(|entry| {
            let fastest = |wanted: &dyn Fn(&Kernel) -> bool| {
                (0..kernels.len())
                    .filter(|&i| kernels[i].0 == entry.info.name && wanted(kernels[i].1))
                    .min_by(|&i, &j| contenders[i].median().total_cmp(&contenders[j].median()))
                    .expect("every method has scalars and lanes")
            };
            let best = fastest(&|kernel| kernel.variant.lane.width > 1);
            let published = fastest(&|kernel| {
                kernel.variant.lane.width == 1
                    && kernel.early_out
                    && kernel.variant.division == "early"
                    && kernel.arrangement == Arrangement::OneRay
            });
            let fastest_scalar = fastest(&|kernel| kernel.variant.lane.width == 1);
            AgainstScalar {
                method: entry.info.name,
                best: timing(best),
                published: timing(published),
                fastest_scalar: timing(fastest_scalar),
                times_published: ratio(published, best),
                times_fastest_scalar: ratio(fastest_scalar, best),
            }
        })
        .collect();
    let mut against_intrinsics = Vec::new();
    for (by_hand, instruction_set, early_out) in by_hand {
        let twin = kernels.iter().position(|(method, kernel)| {
            *method == BY_HAND
                && kernel.variant.lane.instruction_set == instruction_set
                && kernel.variant.lane.arithmetic == "fused"
                && kernel.arrangement == Arrangement::OneRay
                && kernel.variant.division == "deferred"
                && kernel.variant.reciprocal == "true"
                && kernel.early_out == early_out
        });
        // The kernels of a lesser instruction set than the best take no part.
        let Some(twin) = twin else { continue };
        let (ours, theirs) = (contenders[twin].tally, contenders[by_hand].tally);
        // `n · u · Σ|x|`, the bound for a sum in any order; no term is negative here.
        let slack = ours.hits as f64 * f32::UNIT_ROUNDOFF * ours.sum;
        ensure!(
            ours.hits == theirs.hits && (ours.sum - theirs.sum).abs() <= slack,
            "{}: {} returned {ours:?}, the intrinsics {theirs:?}",
            workload.name,
            contenders[twin].name,
        );
        against_intrinsics.push(AgainstIntrinsics {
            kernel: timing(twin),
            intrinsics: timing(by_hand),
            hits: ours.hits,
            time: ratio(twin, by_hand),
        });
    }
    Ok(Measured {
        workload: workload.name.clone(),
        rays: rays.len(),
        triangles: triangles.len(),
        methods,
        intrinsics: against_intrinsics,
    })
}

impl<'a> Contender<'a> {
    /// Runs it until it is warm, and finds how often it must run for a sample.
    fn new(name: String, run: impl Fn() -> Tally + 'a) -> Self {
        let tally = run();
        let start = Instant::now();
        let mut runs = 0;
        while start.elapsed() < SAMPLE * 2 {
            black_box(run());
            runs += 1;
        }
        Self { name, run: Box::new(run), tally, repeats: runs, ns: Vec::new() }
    }

    fn sample(&mut self) -> Result<()> {
        let start = Instant::now();
        let mut wrong = 0;
        for _ in 0..self.repeats {
            wrong += u32::from(black_box((self.run)()) != self.tally);
        }
        let elapsed = start.elapsed();
        ensure!(wrong == 0, "{} does not repeat its answer", self.name);
        if elapsed < SAMPLE {
            // Warmer than when it was tried.
            self.repeats *= 2;
            return self.sample();
        }
        self.ns.push(elapsed.as_nanos() as f64 / f64::from(self.repeats));
        Ok(())
    }

    fn median(&self) -> f64 {
        quantile(&mut self.ns.clone(), 0.5)
    }
}

impl Ratio {
    fn of(numerators: &[f64], denominators: &[f64]) -> Self {
        let mut ratios: Vec<f64> =
            numerators.iter().zip(denominators).map(|(a, b)| a / b).collect();
        Self {
            median: quantile(&mut ratios, 0.5),
            lower_quartile: quantile(&mut ratios, 0.25),
            upper_quartile: quantile(&mut ratios, 0.75),
        }
    }
}

/// The nearest sample to a quantile.
fn quantile(samples: &mut [f64], quantile: f64) -> f64 {
    samples.sort_unstable_by(f64::total_cmp);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between zero and the number of samples"
    )]
    let place = ((samples.len() - 1) as f64 * quantile).round() as usize;
    samples[place]
}

fn print(yardstick: &Yardstick) {
    let Yardstick { machine, rounds, workloads } = yardstick;
    println!("{}, {:.2} GHz measured, {}", machine.cpu, machine.core_ghz, machine.platform);
    println!("instruction sets {}", machine.instruction_sets.join(" "));
    println!("{}; {}", machine.compiler, machine.build);
    println!("medians over {rounds} rounds in random order, quartiles in brackets");
    for measured in workloads {
        let Measured { workload, rays, triangles, methods, intrinsics } = measured;
        println!("\n{workload}: {rays} rays, {triangles} triangles");
        println!("  fastest lanes against f32 scalars, times as fast");
        for row in methods {
            println!("  {}", row.method);
            let line = |label: &str, timing: &Timing, ratio: Option<Ratio>| {
                let ratio = ratio.map(|ratio| format!("  {:>5.2}x {ratio}", ratio.median));
                println!(
                    "    {label:9} {:7.3} ns{}  {}",
                    timing.ns_per_test,
                    ratio.unwrap_or_default(),
                    timing.name
                );
            };
            line("lanes", &row.best, None);
            line("published", &row.published, Some(row.times_published));
            line("scalar", &row.fastest_scalar, Some(row.times_fastest_scalar));
        }
        println!("  {BY_HAND} against intrinsics of the same formula, time over time");
        for row in intrinsics {
            println!(
                "    {:.3} {}  {:.3} ns {} / {:.3} ns {}, {} hits in both",
                row.time.median,
                row.time,
                row.kernel.ns_per_test,
                row.kernel.name,
                row.intrinsics.ns_per_test,
                row.intrinsics.name,
                row.hits
            );
        }
    }
}

impl std::fmt::Display for Ratio {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "[{:.3} {:.3}]", self.lower_quartile, self.upper_quartile)
    }
}
