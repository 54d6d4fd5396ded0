//! Measures every variant of every method on a list of workloads.

use std::time::{Instant, SystemTime};

use rand::SeedableRng;
use rand_pcg::Pcg64;
use trisect_catalog::{Entry, Finder, Kernel, Kernels, Scene, Variant};
use trisect_core::{
    Arrangement, Claims, FloatFormat, MultiplyAdd, Ops, Output, Precision, Ray, ReciprocalKind,
    Triangle,
};

use crate::answers::{Answers, Pair, QUANTITIES, Quantity};
use crate::machine;
use crate::record::{
    Agreement, Cracks, Decisions, Error, Family, Header, MethodCount, MethodFacts, PartCost,
    Preparation, Record, Records, Refusal, SCHEMA, Throughput, Workload,
};
use crate::subject::{Inputs, Side, Subject};
use crate::timing::{self, Contender, WrongAnswer, nanoseconds};

/// The method that all are compared with, and, in f64, the reference of the error tables.
pub const REFERENCE: &str = "moller-trumbore";

/// Rays and triangles to measure on.
pub struct Task {
    /// Unique name.
    pub name: String,
    /// One sentence for a reader.
    pub description: String,
    /// What it is for: decides what is measured on it.
    pub family: Family,
    /// The rays and triangles.
    pub inputs: Inputs,
    /// How many of the rays, from the first, are timed; all of them answer.
    pub timed_rays: usize,
}

/// How to measure.
pub struct Settings {
    /// The command line, for the record.
    pub command: String,
    /// Seed of the order of samples; workloads carry their own.
    pub seed: u64,
    /// Samples of each variant.
    pub rounds: usize,
    /// The methods to measure.
    pub methods: Vec<&'static Entry>,
    /// Whether time is measured; without, only answers are.
    pub timed: bool,
}

/// Hears how far a measurement is; never called inside a timed section.
pub trait Progress {
    /// A new phase of `steps` steps begins.
    fn phase(&mut self, name: &str, steps: u64);
    /// One step is done.
    fn step(&mut self);
}

/// Measures the methods on each task.
///
/// # Errors
/// When a timed sample does not return what its variant's answers add up to.
pub fn measure(
    settings: &Settings,
    tasks: impl IntoIterator<Item = Task>,
    progress: &mut dyn Progress,
) -> Result<Records, WrongAnswer> {
    let started = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let mut machine = machine::facts();
    let mut run = Run {
        settings,
        random: Pcg64::seed_from_u64(settings.seed),
        lines: Vec::new(),
        ghz: vec![machine::core_ghz()],
        progress,
    };
    run.lines.extend(settings.methods.iter().map(|entry| {
        Record::Method(MethodFacts {
            name: entry.info.name.to_owned(),
            title: entry.info.title.to_owned(),
            year: entry.info.year,
            source: entry.info.source.to_owned(),
            stored_numbers: entry.cost.stored_numbers,
            input: Some(entry.info.input),
            outputs: entry.info.outputs.to_vec(),
            divisions: entry.info.forms.list().to_vec(),
            claims: claims(entry.info.claims),
            cost: entry.cost.parts().map(part_cost).collect(),
        })
    }));
    for task in tasks {
        run.task(task)?;
    }
    run.ghz.sort_unstable_by(f64::total_cmp);
    machine.core_ghz = run.ghz[run.ghz.len() / 2];
    let header = Header {
        schema: SCHEMA,
        trisect: env!("CARGO_PKG_VERSION").to_owned(),
        command: settings.command.clone(),
        started,
        seed: settings.seed,
        rounds: settings.rounds,
        machine,
    };
    Ok(Records { header, lines: run.lines })
}

/// A measurement under way.
struct Run<'a> {
    settings: &'a Settings,
    random: Pcg64,
    lines: Vec<Record>,
    ghz: Vec<f64>,
    progress: &'a mut dyn Progress,
}

/// One method in one precision on one subject: the answers of each finder that can run here.
struct Answered {
    method: &'static str,
    precision: FloatFormat,
    significant_bits: i32,
    /// Whether the method gives barycentrics.
    weighs: bool,
    variants: Vec<(&'static Variant, Answers)>,
}

impl Run<'_> {
    fn task(&mut self, task: Task) -> Result<(), WrongAnswer> {
        let Task { name, description, family, inputs, timed_rays } = task;
        self.progress.phase(&format!("{name}: asking the oracle"), 1);
        let subject = Subject::new(name, description, family, inputs);
        self.progress.step();
        self.lines.push(Record::Workload(subject.workload.clone()));

        let methods = self.settings.methods.clone();
        if family == Family::Edges {
            self.cracks(&subject);
        }
        if matches!(family, Family::Random | Family::Mesh) {
            self.progress.phase(
                &format!("{}: comparing answers", subject.workload.name),
                methods.len() as u64 * 2,
            );
            let mut answered = Vec::new();
            for entry in &methods {
                let name = &subject.workload.name;
                answered.extend(self.answer(name, entry, &entry.f32, &subject.single));
                answered.extend(self.answer(name, entry, &entry.f64, &subject.double));
            }
            self.errors(&subject, &answered);
            self.agreement(&subject, &answered);
        }
        if self.settings.timed && timed_rays > 0 {
            let timed_rays = timed_rays.min(subject.workload.rays);
            let mut groups = Vec::new();
            self.progress
                .phase(&format!("{}: preparing", subject.workload.name), methods.len() as u64 * 2);
            for entry in &methods {
                let workload = &subject.workload;
                let (single, double) = (&subject.single, &subject.double);
                groups.extend(self.prepare(workload, entry, &entry.f32, single, timed_rays));
                groups.extend(self.prepare(workload, entry, &entry.f64, double, timed_rays));
            }
            self.time(&subject, timed_rays, &groups)?;
        }
        Ok(())
    }

    /// Prepares a workload, or notes why the method cannot take it.
    fn scene<E: Precision>(
        &mut self,
        workload: &str,
        entry: &Entry,
        kernels: &Kernels<E>,
        rays: &[Ray<E>],
        triangles: &[Triangle<E>],
    ) -> Option<Scene> {
        match (kernels.prepare)(triangles, rays) {
            Ok(scene) => Some(scene),
            Err(unsuitable) => {
                let refusal = Record::Refusal(Refusal {
                    method: entry.info.name.to_owned(),
                    precision: E::FORMAT,
                    workload: workload.to_owned(),
                    reason: unsuitable.to_string(),
                });
                if !self.lines.contains(&refusal) {
                    self.lines.push(refusal);
                }
                None
            }
        }
    }

    /// What a method answers, see [`answers_of_widest`].
    fn answer<E: Precision>(
        &mut self,
        workload: &str,
        entry: &Entry,
        kernels: &'static Kernels<E>,
        side: &Side<E>,
    ) -> Option<Answered> {
        let scene = self.scene(workload, entry, kernels, &side.rays, &side.triangles);
        self.progress.step();
        Some(Answered {
            method: entry.info.name,
            precision: E::FORMAT,
            significant_bits: E::SIGNIFICANT_BITS,
            weighs: entry.info.gives(Output::Barycentrics),
            variants: answers_of_widest(&kernels.finders, &scene?),
        })
    }

    /// Counts the rays that pass through the closed surface of `subject`, per variant in f32.
    fn cracks(&mut self, subject: &Subject) {
        let methods = self.settings.methods.clone();
        let Subject { workload, single, .. } = subject;
        let name = &workload.name;
        self.progress.phase(&format!("{name}: looking for cracks"), methods.len() as u64);
        for entry in methods {
            if let Some(answered) = self.answer(name, entry, &entry.f32, single) {
                for (variant, answers) in &answered.variants {
                    let (no_hit, many_hits) = answers.none_and_many(workload.rays);
                    self.lines.push(Record::Cracks(Cracks {
                        variant: (*variant).clone(),
                        workload: name.clone(),
                        rays: workload.rays,
                        no_hit,
                        many_hits,
                    }));
                }
            }
        }
    }

    fn errors(&mut self, subject: &Subject, answered: &[Answered]) {
        let truth_of = |precision| -> Vec<Pair> {
            subject.of(precision).known().truth.iter().map(Pair::from).collect()
        };
        let truth: Vec<(FloatFormat, Vec<Pair>)> =
            FloatFormat::ALL.iter().map(|&precision| (precision, truth_of(precision))).collect();
        let reference = answered
            .iter()
            .find(|a| a.method == REFERENCE && a.precision == FloatFormat::F64)
            .and_then(Answered::plain);
        // On other numbers than a method's the reference says nothing about the method.
        let methods = self.settings.methods.iter().filter(|_| !subject.is_same);
        let of_rounded = methods
            .filter(|entry| entry.info.name == REFERENCE)
            .find_map(|entry| answers_in_f64(entry, &subject.single));
        for method in answered {
            let of = subject.of(method.precision);
            let truth = truth.iter().filter(|(precision, _)| *precision == method.precision);
            let mut references: Vec<(&str, &[Pair])> =
                truth.map(|(_, pairs)| ("oracle", pairs.as_slice())).collect();
            let is_rounded = !subject.is_same && method.precision == FloatFormat::F32;
            let reference = if is_rounded { of_rounded.as_ref() } else { reference };
            references.extend(reference.map(|answers| ("f64-moller-trumbore", answers.pairs())));
            for (variant, answers) in &method.variants {
                for (name, pairs) in &references {
                    for (quantity, of) in method.quantities() {
                        let (count, relative, ulps) =
                            answers.errors(pairs, of, method.significant_bits);
                        self.lines.push(Record::Error(Error {
                            variant: (*variant).clone(),
                            workload: subject.workload.name.clone(),
                            reference: (*name).to_owned(),
                            quantity: quantity.to_owned(),
                            count,
                            relative,
                            ulps,
                        }));
                    }
                }
                self.lines.push(Record::Decisions(Decisions {
                    variant: (*variant).clone(),
                    workload: subject.workload.name.clone(),
                    classes: answers.decisions(of),
                }));
            }
        }
    }

    fn agreement(&mut self, subject: &Subject, answered: &[Answered]) {
        let rays = subject.workload.rays;
        for &precision in FloatFormat::ALL {
            let closest: Vec<_> = answered
                .iter()
                .filter(|a| a.precision == precision)
                .filter_map(|a| Some((a.method, a.plain()?.closest(rays))))
                .collect();
            let Some((_, first)) = closest.first() else { continue };
            let truth = &subject.of(precision).known().closest;
            let unanimous =
                (0..rays).filter(|&ray| closest.iter().all(|(_, c)| c[ray] == first[ray])).count();
            let differs_from_oracle = closest
                .iter()
                .map(|(method, closest)| MethodCount {
                    method: (*method).to_owned(),
                    count: closest.iter().zip(truth).filter(|(a, b)| a != b).count(),
                })
                .collect();
            self.lines.push(Record::Agreement(Agreement {
                workload: subject.workload.name.clone(),
                precision,
                rays,
                unanimous,
                differs_from_oracle,
            }));
        }
    }

    /// Prepares a method's triangles, timed, and lists the kernels to time on them; nothing where
    /// there are none.
    fn prepare<E: Precision>(
        &mut self,
        workload: &Workload,
        entry: &'static Entry,
        kernels: &'static Kernels<E>,
        Side { rays, triangles, .. }: &Side<E>,
        timed_rays: usize,
    ) -> Option<Group> {
        let timed: Vec<&'static Kernel> = kernels
            .timed
            .iter()
            .filter(|kernel| kernel.variant.is_available())
            .filter(|kernel| is_shown(workload.family, kernel, &kernels.timed))
            .collect();
        if timed.is_empty() {
            self.progress.step();
            return None;
        }
        let rays = &rays[..timed_rays];
        let Some(scene) = self.scene(&workload.name, entry, kernels, rays, triangles) else {
            self.progress.step();
            return None;
        };
        if matches!(workload.family, Family::Random | Family::Mesh) {
            let mut samples_ns = Vec::new();
            for _ in 0..self.settings.rounds {
                let start = Instant::now();
                let prepared = (kernels.prepare)(triangles, &[]);
                samples_ns.push(nanoseconds(start.elapsed()));
                drop(prepared);
            }
            self.lines.push(Record::Preparation(Preparation {
                method: entry.info.name.to_owned(),
                precision: E::FORMAT,
                workload: workload.name.clone(),
                triangles: triangles.len(),
                samples_ns,
            }));
        }
        let group = Group::new(entry, kernels, scene, timed);
        self.progress.step();
        Some(group)
    }

    fn time(
        &mut self,
        subject: &Subject,
        timed_rays: usize,
        groups: &[Group],
    ) -> Result<(), WrongAnswer> {
        let mut contenders = contenders(groups, subject);
        let steps = contenders.len() * (self.settings.rounds + 1);
        self.progress.phase(&format!("{}: timing", subject.workload.name), steps as u64);
        let progress = &mut *self.progress;
        let rounds = self.settings.rounds;
        timing::rounds(&mut contenders, rounds, &mut self.random, |(_, contender), timed| {
            contender.sample(timed)?;
            progress.step();
            Ok(())
        })?;
        self.ghz.push(machine::core_ghz());
        for (group, contender) in contenders {
            let kernel = contender.kernel;
            let Some(tally) = contender.tally else { continue };
            self.lines.push(Record::Throughput(Throughput {
                variant: kernel.variant.clone(),
                workload: subject.workload.name.clone(),
                tests: (timed_rays * subject.workload.triangles) as u64,
                samples_ns: contender.samples_ns,
                hits: tally.hits,
                checksum: tally.sum.to_bits(),
                bytes_per_triangle: group.bytes_per_triangle,
            }));
        }
        Ok(())
    }
}

/// What a method answers in f64, in plain arithmetic, about the numbers of f32.
fn answers_in_f64(entry: &Entry, single: &Side<f32>) -> Option<Answers> {
    let triangles: Vec<Triangle<f64>> = single.triangles.iter().map(|&t| t.into()).collect();
    let rays: Vec<Ray<f64>> = single.rays.iter().map(|&ray| ray.into()).collect();
    let scene = (entry.f64.prepare)(&triangles, &rays).ok()?;
    Some(Answers::of(entry.f64.plain_finder(None, None)?, &scene))
}

/// The answers of each of some finders that computes values of its own here: plain arithmetic gives the
/// same bits on every width, and so does fused, so that the widest stands for all.
pub(crate) fn answers_of_widest<'a>(
    finders: &'a [Finder],
    scene: &Scene,
) -> Vec<(&'a Variant, Answers)> {
    let here = || finders.iter().filter(|finder| finder.variant.is_available());
    let widest = here().map(|finder| finder.variant.width).max();
    here()
        .filter(|finder| Some(finder.variant.width) == widest)
        .map(|finder| (&finder.variant, Answers::of(finder, scene)))
        .collect()
}

/// A method in one precision, prepared for timing.
pub(crate) struct Group {
    pub method: &'static str,
    pub bytes_per_triangle: usize,
    unit_roundoff: f64,
    scene: Scene,
    timed: Vec<&'static Kernel>,
    answers: Vec<(&'static Variant, Answers)>,
}

/// Each kernel of some groups, ready to be timed, with its group.
pub(crate) fn contenders<'a>(
    groups: &'a [Group],
    subject: &Subject,
) -> Vec<(&'a Group, Contender<'a>)> {
    let of_group = |group: &'a Group| {
        group.timed.iter().map(move |&kernel| (group, group.contender(kernel, subject)))
    };
    groups.iter().flat_map(of_group).collect()
}

impl Group {
    /// The answers of kernels on a scene, those whose arrangement serves its rays.
    pub(crate) fn new<E: Precision>(
        entry: &Entry,
        kernels: &'static Kernels<E>,
        scene: Scene,
        mut timed: Vec<&'static Kernel>,
    ) -> Self {
        timed.retain(|kernel| kernel.variant.arrangement.serves(scene.common()));
        let mut answers: Vec<(&'static Variant, Answers)> = Vec::new();
        for kernel in &timed {
            if !answers.iter().any(|(variant, _)| variant.computes_like(&kernel.variant)) {
                let finder = kernels.finder_of(kernel);
                answers.push((&finder.variant, Answers::of(finder, &scene)));
            }
        }
        Self {
            method: entry.info.name,
            bytes_per_triangle: entry.cost.stored_numbers * size_of::<E>(),
            unit_roundoff: E::UNIT_ROUNDOFF,
            scene,
            timed,
            answers,
        }
    }

    /// Its kernels, those that serve its rays.
    pub(crate) fn kernels(&self) -> impl Iterator<Item = &'static Kernel> + '_ {
        self.timed.iter().copied()
    }

    /// A kernel of it, ready to be timed.
    pub(crate) fn contender(&self, kernel: &'static Kernel, subject: &Subject) -> Contender<'_> {
        Contender {
            kernel,
            scene: &self.scene,
            expected: self.expected(kernel, subject),
            samples_ns: Vec::new(),
            tally: None,
        }
    }

    fn expected(&self, kernel: &Kernel, subject: &Subject) -> timing::Expected {
        let (_, answers) = self
            .answers
            .iter()
            .find(|(variant, _)| variant.computes_like(&kernel.variant))
            .expect("every timed variant has a finder");
        let of = subject.of(kernel.variant.precision);
        answers.expected(kernel.variant.needs, self.unit_roundoff, of)
    }
}

impl Answered {
    /// The answers that are the same on every machine.
    fn plain(&self) -> Option<&Answers> {
        // Deferred comes last, where there is one.
        self.variants.iter().rfind(|(variant, _)| variant.is_plain()).map(|(_, answers)| answers)
    }

    /// What the method gives that has an error.
    fn quantities(&self) -> impl Iterator<Item = (&'static str, Quantity)> {
        QUANTITIES.into_iter().take(if self.weighs { 3 } else { 1 })
    }
}

fn claims(claims: Claims) -> Vec<String> {
    let Claims { watertight, culls, unit_direction, exact } = claims;
    let named = [
        ("watertight", watertight),
        ("culls", culls),
        ("unit-direction", unit_direction),
        ("exact", exact),
    ];
    named.into_iter().filter(|(_, holds)| *holds).map(|(name, _)| name.to_owned()).collect()
}

fn part_cost((part, ops): (&str, Ops)) -> PartCost {
    let Ops { multiplies, adds, divisions, comparisons, signs: _ } = ops;
    PartCost { part: part.to_owned(), multiplies, adds, divisions, comparisons }
}

/// Whether a kernel is timed on a family of workloads: where methods are compared everything but
/// what rays must share something for; on the series the widest f32 lanes with the fullest hit, one
/// ray at a time; and on packets in every arrangement.
fn is_shown(family: Family, Kernel { variant, .. }: &Kernel, all: &[Kernel]) -> bool {
    let shares =
        matches!(variant.arrangement, Arrangement::CommonOrigin | Arrangement::CommonDirection);
    if matches!(family, Family::Random | Family::Mesh) {
        return !shares;
    }
    let here = || all.iter().map(|other| &other.variant).filter(|other| other.is_available());
    let widest = here()
        .map(Variant::lane)
        .max_by_key(|lane| (lane.width, lane.arithmetic == MultiplyAdd::Fused));
    let asked = if here().any(|other| other.needs == Output::Barycentrics) {
        Output::Barycentrics
    } else {
        Output::T
    };
    Some(variant.lane()) == widest
        && variant.precision == FloatFormat::F32
        && variant.needs == asked
        && variant.reciprocal == ReciprocalKind::True
        && match family {
            Family::Packets => !variant.early_out,
            _ => variant.arrangement == Arrangement::OneRay,
        }
}
