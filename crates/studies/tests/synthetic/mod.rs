//! Records that were never measured: four methods with plausible numbers, from a fixed formula.

use trisect_core::{FloatFormat, InstructionSet, MultiplyAdd};
use trisect_kernels::Arrangement;
use trisect_method::{Form, Input, Output, ReciprocalKind};
use trisect_studies::comparison::{
    Agreement, ClassCount, Decisions, Error, Family, MethodCount, MethodFacts, PartCost,
    Preparation, Quantiles, Throughput, Workload,
};
use trisect_studies::noise::Noise;
use trisect_studies::record::{Header, Line, Machine, Records, SCHEMA, Variant};
use trisect_studies::tracer::{Contest, Traced, TreeBuilt, TreeChecked};

/// Name, title, year, citation, stored numbers, base ns, factor of error, gain of deferring.
type Fact = (&'static str, &'static str, u16, &'static str, usize, f64, f64, f64);
const METHODS: [Fact; 4] = [
    (
        "moller-trumbore",
        "Möller–Trumbore",
        1997,
        "T. Möller and B. Trumbore, “Fast, Minimum Storage Ray/Triangle Intersection”, Journal of Graphics Tools 2(1), 1997",
        9,
        14.0,
        1.0,
        1.2,
    ),
    (
        "kensler-shirley",
        "Kensler–Shirley",
        2006,
        "A. Kensler and P. Shirley, “Optimizing Ray-Triangle Intersection via Automated Search”, IEEE Symposium on Interactive Ray Tracing, 2006",
        9,
        11.0,
        1.2,
        1.17,
    ),
    (
        "wald",
        "Wald",
        2004,
        "I. Wald, “Realtime Ray Tracing and Interactive Global Illumination”, PhD thesis, Saarland University, 2004",
        12,
        6.5,
        2.4,
        0.95,
    ),
    (
        "perpendicular-planes",
        "Perpendicular planes",
        2008,
        "M. Shevtsov, A. Soupikov and A. Kapustin, as an example of a long citation & one with signs <to escape>, 2008",
        12,
        7.2,
        1.6,
        0.9,
    ),
];

/// Precision, width, instruction set, arithmetic, speed-up.
const LANES: [(FloatFormat, usize, InstructionSet, MultiplyAdd, f64); 8] = [
    (FloatFormat::F32, 1, InstructionSet::Scalar, MultiplyAdd::Plain, 1.0),
    (FloatFormat::F32, 4, InstructionSet::Sse42, MultiplyAdd::Plain, 3.5),
    (FloatFormat::F32, 8, InstructionSet::Avx2, MultiplyAdd::Plain, 6.6),
    (FloatFormat::F32, 8, InstructionSet::Avx2, MultiplyAdd::Fused, 8.1),
    (FloatFormat::F64, 1, InstructionSet::Scalar, MultiplyAdd::Plain, 0.9),
    (FloatFormat::F64, 2, InstructionSet::Sse42, MultiplyAdd::Plain, 1.7),
    (FloatFormat::F64, 4, InstructionSet::Avx2, MultiplyAdd::Plain, 3.3),
    (FloatFormat::F64, 4, InstructionSet::Avx2, MultiplyAdd::Fused, 4.0),
];

pub(crate) fn header() -> Header {
    Header {
        schema: SCHEMA,
        study: None,
        trisect: "0.1.0".into(),
        command: "trisect measure --seed 7 --rounds 9 --output records.jsonl".into(),
        started: "2026-11-22T04:00:00Z".into(),
        seed: 7,
        rounds: 9,
        machine: Machine {
            cpu: "Synthetic Processor 9000 @ 3.00GHz".into(),
            logical_cpus: 2,
            instruction_sets: vec![
                InstructionSet::Scalar,
                InstructionSet::Sse2,
                InstructionSet::Sse42,
                InstructionSet::Avx2,
            ],
            platform: "linux x86_64".into(),
            compiler: "rustc 1.95.0".into(),
            build: "release, x86_64-unknown-linux-gnu".into(),
            core_ghz: 3.0,
        },
        noise: Some(Noise { stolen: Some(0.003), drift: 0.011, spread: 0.008 }),
        shard: None,
    }
}

fn workload(name: &str, family: Family, triangles: usize, hit_rate: f64) -> Workload {
    Workload {
        name: name.into(),
        description: format!("Made up for tests: the workload {name}."),
        family,
        rays: 4096,
        triangles,
        hit_rate,
        oracle_tests: 100_000,
        oracle_exact: 137,
    }
}

pub(crate) fn workloads() -> Vec<Workload> {
    let mut all = vec![
        workload("random", Family::Random, 1024, 0.07),
        workload("bunny/primary", Family::Mesh, 69_451, 0.002),
        workload("bunny/random", Family::Mesh, 69_451, 0.001),
        workload("bunny/diffuse", Family::Mesh, 69_451, 0.0005),
        workload("bunny/occlusion", Family::Mesh, 69_451, 0.0007),
    ];
    for percent in (0..=100).step_by(10) {
        let rate = f64::from(percent) / 100.0;
        all.push(workload(&format!("hit-rate/{percent}"), Family::HitRate, 1024, rate));
    }
    for k in 0..9 {
        let triangles = 64usize << (2 * k);
        all.push(workload(
            &format!("working-set/{triangles}"),
            Family::WorkingSet,
            triangles,
            0.05,
        ));
    }
    all
}

/// A number in 0..1 that depends on nothing but its argument.
fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x ^= x >> 29;
    x = x.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x ^= x >> 32;
    (x >> 11) as f64 / (1u64 << 53) as f64
}

/// Records of the first `count` methods.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small positives")]
#[expect(clippy::too_many_lines, reason = "one loop per kind of record, read from top to bottom")]
pub(crate) fn records(count: usize) -> Records {
    let workloads = workloads();
    let mut lines = Vec::new();
    let mut seed = 0;
    let mut random = || {
        seed += 1;
        noise(seed)
    };
    for (name, title, year, source, stored_numbers, ..) in METHODS.iter().take(count).copied() {
        lines.push(Line::from(MethodFacts {
            name: name.into(),
            title: title.into(),
            year,
            source: source.into(),
            stored_numbers,
            input: Some(Input::Prepared),
            outputs: vec![Output::Occlusion, Output::T, Output::Barycentrics],
            divisions: vec![Form::Deferred, Form::Early],
            claims: vec!["culls".into()],
            cost: vec![PartCost {
                part: "test, deferred division".into(),
                multiplies: 27,
                adds: 20,
                divisions: 0,
                comparisons: 7,
            }],
        }));
    }
    lines.extend(workloads.iter().cloned().map(Line::from));
    for (m, fact) in METHODS.iter().take(count).enumerate() {
        let (name, _, _, _, stored, base, error, gain) = *fact;
        for (precision, width, set, arithmetic, speed) in LANES {
            let bytes = stored * if precision == FloatFormat::F32 { 4 } else { 8 };
            for division in [Form::Early, Form::Deferred] {
                let variant = |arrangement: Arrangement, early_out: bool, needs: Output| Variant {
                    method: name.into(),
                    precision,
                    width,
                    instruction_set: set,
                    arithmetic,
                    arrangement,
                    division,
                    reciprocal: ReciprocalKind::True,
                    early_out,
                    needs,
                };
                for arrangement in [Arrangement::OneRay, Arrangement::OneTriangle] {
                    for early_out in [true, false] {
                        for needs in [Output::Occlusion, Output::T, Output::Barycentrics] {
                            for w in &workloads {
                                let mut ns = base / speed;
                                ns *= match needs {
                                    Output::Occlusion => 0.8,
                                    Output::T => 0.93,
                                    _ => 1.0,
                                };
                                if division == Form::Deferred {
                                    ns /= gain;
                                }
                                if arrangement == Arrangement::OneTriangle {
                                    ns *= 1.06;
                                }
                                ns *= if early_out { 0.8 + 0.3 * w.hit_rate } else { 1.0 };
                                let size = (w.triangles * bytes) as f64;
                                if size > 2e6 && w.family == Family::WorkingSet {
                                    ns = ns.max(bytes as f64 / 9.0);
                                }
                                let tests = 1_000_000u64;
                                let samples_ns = (0..9)
                                    .map(|_| (ns * tests as f64 * (1.0 + 0.05 * random())) as u64)
                                    .collect();
                                lines.push(Line::from(Throughput {
                                    variant: variant(arrangement, early_out, needs),
                                    workload: w.name.clone(),
                                    tests,
                                    samples_ns,
                                    hits: (w.hit_rate * tests as f64) as u64,
                                    checksum: 1,
                                    bytes_per_triangle: bytes,
                                }));
                            }
                        }
                    }
                }
                for w in
                    workloads.iter().filter(|w| matches!(w.family, Family::Random | Family::Mesh))
                {
                    let unit = if precision == FloatFormat::F32 { 6e-8 } else { 1.1e-16 };
                    for (quantity, scale) in [("t", 1.0), ("beta", 2.1), ("gamma", 2.3)] {
                        let fused = if arithmetic == MultiplyAdd::Fused { 0.8 } else { 1.0 };
                        let late = if division == Form::Deferred { 0.95 } else { 1.0 };
                        let late = late * if width == 1 { 0.85 } else { 1.0 };
                        let of = unit * error * scale * fused * late * (0.95 + 0.1 * random());
                        let relative =
                            Quantiles { mean: 3.0 * of, median: of, p99: 90.0 * of, max: 4e4 * of };
                        lines.push(Line::from(Error {
                            variant: variant(Arrangement::OneRay, true, Output::Barycentrics),
                            workload: w.name.clone(),
                            reference: "oracle".into(),
                            quantity: quantity.into(),
                            count: 5000,
                            relative,
                            ulps: Quantiles {
                                mean: relative.mean / unit,
                                median: relative.median / unit,
                                p99: relative.p99 / unit,
                                max: relative.max / unit,
                            },
                            over_condition: None,
                        }));
                    }
                    let class = |class: &str, is_hit, called_hit, called_miss| ClassCount {
                        class: class.into(),
                        is_hit,
                        called_hit,
                        called_miss,
                    };
                    let wrong = if precision == FloatFormat::F32 { m as u64 + 1 } else { 0 };
                    lines.push(Line::from(Decisions {
                        variant: variant(Arrangement::OneRay, true, Output::Barycentrics),
                        workload: w.name.clone(),
                        classes: vec![
                            class("interior", true, 5000, wrong),
                            class("edge", true, 40, 2 * wrong),
                            class("miss", false, wrong, 95_000),
                        ],
                    }));
                }
            }
        }
        for precision in [FloatFormat::F32, FloatFormat::F64] {
            for w in workloads.iter().filter(|w| w.family == Family::Mesh) {
                let ns =
                    (4.0 + stored as f64) * if precision == FloatFormat::F32 { 1.0 } else { 1.5 };
                lines.push(Line::from(Preparation {
                    method: name.into(),
                    precision,
                    workload: w.name.clone(),
                    triangles: w.triangles,
                    samples_ns: (0..9)
                        .map(|_| (ns * w.triangles as f64 * (1.0 + 0.1 * random())) as u64)
                        .collect(),
                }));
            }
        }
    }
    for w in workloads.iter().filter(|w| w.family == Family::Mesh) {
        for (precision, differs) in [(FloatFormat::F32, 3), (FloatFormat::F64, 0)] {
            lines.push(Line::from(Agreement {
                workload: w.name.clone(),
                precision,
                rays: w.rays,
                unanimous: w.rays - 2 * differs,
                differs_from_oracle: METHODS
                    .iter()
                    .take(count)
                    .enumerate()
                    .map(|(m, f)| MethodCount { method: f.0.into(), count: m * differs })
                    .collect(),
            }));
        }
    }
    Records { header: header(), lines }
}

/// Trees of methods over a mesh, each with its wrong decisions and rays through edges, as much slower than the
/// one before it as a twentieth, all in turn.
#[allow(dead_code, reason = "not every test binary has trees")]
pub(crate) fn trees(methods: &[(&str, usize, usize)], triangles: usize) -> Vec<Line> {
    let mut lines = Vec::new();
    for (place, &(method, wrong, passed)) in methods.iter().enumerate() {
        let [method, scene] = [method, "bunny"].map(str::to_owned);
        let [builder, leaves] = ["spatial", "cheapest"].map(str::to_owned);
        lines.push(Line::from(TreeBuilt {
            contest: Contest::Together,
            method: method.clone(),
            scene: scene.clone(),
            triangles,
            builder: builder.clone(),
            leaves: leaves.clone(),
            threads: 2,
            samples_ns: vec![200_000_000],
            nodes: 6000,
            blocks: 12_000,
            references: 80_000,
            depth: 9,
            bytes: triangles * 70,
            cost: 12.5,
        }));
        for (class, any, calls) in
            [("closest", false, "batch"), ("any", true, "batch"), ("closest", false, "ray")]
        {
            // The same drift for all.
            let ns =
                |round: u64| 5_000_000 * (100 + 5 * place as u64) * (1000 + round % 3) / 100_000;
            lines.push(Line::from(Traced {
                contest: Contest::Together,
                method: method.clone(),
                scene: scene.clone(),
                builder: builder.clone(),
                leaves: leaves.clone(),
                class: class.to_owned(),
                any,
                tracing: "single".to_owned(),
                calls: calls.to_owned(),
                threads: 1,
                rays: 50_000,
                hits: 20_000,
                differ: 0,
                samples_ns: (0..9).map(ns).collect(),
                baseline_ns: Vec::new(),
            }));
        }
        lines.push(Line::from(TreeChecked {
            method,
            scene,
            open_edges: 0,
            rays: 10_000,
            wrong,
            error: 1.5e-5,
            edge_rays: 20_000,
            passed,
        }));
    }
    lines
}
