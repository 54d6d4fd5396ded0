//! How fast the catalogue's kernels are against their own scalars and against hand-written
//! intrinsics: everything in one run, in rounds of random order, compared round by round.
#![deny(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod intrinsics;

use std::hint::black_box;
use std::time::{Duration, Instant};

use anyhow::{Result, ensure};
use clap::Parser;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use serde::Serialize;
use trisect_catalog::{Entry, Kernel, Scene, Tally, entries};
use trisect_core::{Float, InstructionSet, MultiplyAdd};
use trisect_kernel_benches::{SEED, kernel_name, workloads};
use trisect_kernels::Arrangement;
use trisect_method::{Form, Output, ReciprocalKind};
use trisect_studies::machine;
use trisect_studies::record::Machine;
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

/// Of the ratios of each round. On a machine that others use too, the ratio of the fastest samples
/// is the one that they disturb least.
#[derive(Clone, Copy, Serialize)]
struct Ratio {
    of_fastest_samples: f64,
    median: f64,
    lower_quartile: f64,
    upper_quartile: f64,
}

/// What is timed: a kernel on its scene, or a loop of intrinsics on its blocks.
struct Contender<'a> {
    name: String,
    kind: Kind,
    run: Box<dyn Fn() -> Tally + 'a>,
    tally: Tally,
    repeats: u32,
    ns: Vec<f64>,
}

/// What a contender is compared by.
enum Kind {
    Kernel {
        method: &'static str,
        kernel: &'static Kernel,
    },
    #[cfg_attr(
        not(target_arch = "x86_64"),
        allow(dead_code, reason = "the intrinsics are written for one architecture")
    )]
    ByHand {
        instruction_set: InstructionSet,
        early_out: bool,
    },
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
        .map(|other| other.variant.instruction_set)
        .filter(|set| set.is_available())
        .max();
    let variant = &kernel.variant;
    variant.needs == Output::Barycentrics
        && matches!(variant.arrangement, Arrangement::OneRay | Arrangement::OneTriangle)
        && (variant.width == 1 || Some(variant.instruction_set) == best)
}

fn measure(workload: &Workload, rounds: u16, random: &mut Pcg64) -> Result<Measured> {
    let (triangles, rays) = (&workload.triangles, &workload.rays);
    // Methods that cannot take the triangles, or give no barycentrics, take no part.
    let scenes: Vec<(&Entry, Scene)> = entries()
        .iter()
        .filter(|entry| entry.info.gives(Output::Barycentrics))
        .filter_map(|entry| Some((entry, (entry.f32.prepare)(triangles, rays).ok()?)))
        .collect();
    let mut contenders = Vec::new();
    for (entry, scene) in &scenes {
        let timed = &entry.f32.timed;
        for kernel in timed.iter().filter(|kernel| takes_part(kernel, timed)) {
            let kind = Kind::Kernel { method: entry.info.name, kernel };
            contenders.push(Contender::new(kernel_name(kernel), kind, || kernel.run(scene)));
        }
    }
    #[cfg(target_arch = "x86_64")]
    {
        let blocks = std::rc::Rc::new(intrinsics::prepare(triangles));
        for by_hand in intrinsics::loops() {
            let early_out = if by_hand.early_out { " early-out" } else { "" };
            let (width, instruction_set) = (by_hand.width, by_hand.instruction_set);
            let name = format!("intrinsics f32x{width} {instruction_set}{early_out}");
            let kind = Kind::ByHand { instruction_set, early_out: by_hand.early_out };
            let blocks = std::rc::Rc::clone(&blocks);
            contenders.push(Contender::new(name, kind, move || by_hand.run(rays, &blocks)));
        }
    }

    let mut order: Vec<usize> = (0..contenders.len()).collect();
    for _ in 0..rounds {
        order.shuffle(random);
        for &i in &order {
            contenders[i].sample()?;
        }
    }
    let tests = (rays.len() * triangles.len()) as f64;
    Ok(Measured {
        workload: workload.name.clone(),
        rays: rays.len(),
        triangles: triangles.len(),
        methods: scenes
            .iter()
            .map(|(entry, _)| against_scalar(entry.info.name, &contenders, tests))
            .collect(),
        intrinsics: against_intrinsics(&contenders, tests)?,
    })
}

fn against_scalar(method: &'static str, contenders: &[Contender<'_>], tests: f64) -> AgainstScalar {
    let fastest = |wanted: &dyn Fn(&Kernel) -> bool| {
        contenders
            .iter()
            .filter(|contender| match contender.kind {
                Kind::Kernel { method: of, kernel } => of == method && wanted(kernel),
                Kind::ByHand { .. } => false,
            })
            .min_by(|a, b| a.median().total_cmp(&b.median()))
            .expect("every method has scalars and lanes")
    };
    let best = fastest(&|kernel| kernel.variant.width > 1);
    // Early, but for a method that has the deferred form alone.
    let has_early = contenders.iter().any(|contender| {
        matches!(contender.kind, Kind::Kernel { method: of, kernel }
            if of == method && kernel.variant.division == Form::Early)
    });
    let published = fastest(&|kernel| {
        kernel.variant.width == 1
            && kernel.variant.early_out
            && (kernel.variant.division == Form::Early || !has_early)
            && kernel.variant.arrangement == Arrangement::OneRay
    });
    let fastest_scalar = fastest(&|kernel| kernel.variant.width == 1);
    AgainstScalar {
        method,
        best: best.timing(tests),
        published: published.timing(tests),
        fastest_scalar: fastest_scalar.timing(tests),
        times_published: Ratio::of(&published.ns, &best.ns),
        times_fastest_scalar: Ratio::of(&fastest_scalar.ns, &best.ns),
    }
}

fn against_intrinsics(contenders: &[Contender<'_>], tests: f64) -> Result<Vec<AgainstIntrinsics>> {
    let mut rows = Vec::new();
    for theirs in contenders {
        let Kind::ByHand { instruction_set, early_out } = theirs.kind else { continue };
        let twin = contenders.iter().find(|contender| match contender.kind {
            Kind::Kernel { method, kernel } => {
                method == BY_HAND
                    && kernel.variant.instruction_set == instruction_set
                    && kernel.variant.arithmetic == MultiplyAdd::Fused
                    && kernel.variant.arrangement == Arrangement::OneRay
                    && kernel.variant.division == Form::Deferred
                    && kernel.variant.reciprocal == ReciprocalKind::True
                    && kernel.variant.early_out == early_out
            }
            Kind::ByHand { .. } => false,
        });
        // The kernels of a lesser instruction set than the best take no part.
        let Some(ours) = twin else { continue };
        // `n · u · Σ|x|`, the bound for a sum in any order; no term is negative here.
        let slack = ours.tally.hits as f64 * f32::UNIT_ROUNDOFF * ours.tally.sum;
        ensure!(
            ours.tally.hits == theirs.tally.hits
                && (ours.tally.sum - theirs.tally.sum).abs() <= slack,
            "{} returned {:?}, the intrinsics {:?}",
            ours.name,
            ours.tally,
            theirs.tally,
        );
        rows.push(AgainstIntrinsics {
            kernel: ours.timing(tests),
            intrinsics: theirs.timing(tests),
            hits: ours.tally.hits,
            time: Ratio::of(&ours.ns, &theirs.ns),
        });
    }
    Ok(rows)
}

impl<'a> Contender<'a> {
    /// Runs it until it is warm, and finds how often it must run for a sample.
    fn new(name: String, kind: Kind, run: impl Fn() -> Tally + 'a) -> Self {
        let tally = run();
        let start = Instant::now();
        let mut runs = 0;
        while start.elapsed() < SAMPLE * 2 {
            black_box(run());
            runs += 1;
        }
        Self { name, kind, run: Box::new(run), tally, repeats: runs, ns: Vec::new() }
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

    fn timing(&self, tests: f64) -> Timing {
        Timing { name: self.name.clone(), ns_per_test: self.median() / tests }
    }
}

impl Ratio {
    fn of(numerators: &[f64], denominators: &[f64]) -> Self {
        let mut ratios: Vec<f64> =
            numerators.iter().zip(denominators).map(|(a, b)| a / b).collect();
        let fastest = |samples: &[f64]| samples.iter().copied().fold(f64::INFINITY, f64::min);
        Self {
            of_fastest_samples: fastest(numerators) / fastest(denominators),
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
    let sets: Vec<_> = machine.instruction_sets.iter().map(|set| set.name()).collect();
    println!("instruction sets {}", sets.join(" "));
    println!("{}; {}", machine.compiler, machine.build);
    println!(
        "{rounds} rounds in random order; times are medians; ratios are the median of the rounds', \
         their quartiles in brackets, then the ratio of the fastest samples"
    );
    for measured in workloads {
        let Measured { workload, rays, triangles, methods, intrinsics } = measured;
        println!("\n{workload}: {rays} rays, {triangles} triangles");
        println!("  fastest lanes against f32 scalars, times as fast");
        for row in methods {
            println!("  {}", row.method);
            let line = |label: &str, timing: &Timing, ratio: Option<Ratio>| {
                let ratio = ratio.map_or(String::new(), |ratio| ratio.to_string());
                println!(
                    "    {label:9} {:7.3} ns  {ratio:32}  {}",
                    timing.ns_per_test, timing.name
                );
            };
            line("lanes", &row.best, None);
            line("published", &row.published, Some(row.times_published));
            line("scalar", &row.fastest_scalar, Some(row.times_fastest_scalar));
        }
        println!("  {BY_HAND} against intrinsics of the same formula, time over time");
        for row in intrinsics {
            println!(
                "    {}  {:.3} ns {} / {:.3} ns {}, {} hits in both",
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
        let Self { of_fastest_samples, median, lower_quartile, upper_quartile } = self;
        write!(
            f,
            "{median:6.3} [{lower_quartile:6.3} {upper_quartile:6.3}] {of_fastest_samples:6.3}"
        )
    }
}
