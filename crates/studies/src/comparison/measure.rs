//! Measures every variant of every method on a list of workloads.

use std::time::Instant;

use rand::SeedableRng;
use rand_pcg::Pcg64;
use trisect_catalog::{Entry, Kernel, Kernels, Scene, Variant};
use trisect_core::{FloatFormat, MultiplyAdd, Precision, Ray, Triangle};
use trisect_formula::Ops;
use trisect_kernels::Arrangement;
use trisect_method::{Claims, Output, ReciprocalKind};

use super::record::{
    Agreement, Cracks, Decisions, Error, Family, MethodCount, MethodFacts, PartCost, Preparation,
    Refusal, Throughput, Workload,
};
use super::tasks::{Task, Timed};
use crate::answers::{Answers, CONDITIONS, ConditionOf, Pair, QUANTITIES, Quantity};
use crate::kernels::{Group, REFERENCE, answers_of_widest, contenders};
use crate::record::Line;
use crate::study::Run;
use crate::subject::{Side, Subject};
use crate::timing::{self, WrongAnswer, nanoseconds};

/// Measures methods on each task. `rounds` samples are taken of each kernel; without any, only answers are
/// compared.
///
/// # Errors
/// When a timed sample does not return what its variant's answers add up to.
pub fn compare(
    methods: &[&'static Entry],
    (seed, rounds): (u64, usize),
    tasks: impl IntoIterator<Item = Task>,
    run: &mut Run<'_>,
) -> Result<(), WrongAnswer> {
    if let Some(part) = run.claim() {
        run.begin(part);
        let facts = methods.iter().map(|entry| MethodFacts::of(entry).into());
        run.lines.extend(facts);
    }
    let random = Pcg64::seed_from_u64(seed);
    let mut measurement = Measurement { methods, rounds, random, run };
    for task in tasks {
        if let Some(part) = measurement.run.claim() {
            measurement.run.begin(part);
            measurement.task(task)?;
        }
    }
    Ok(())
}

impl MethodFacts {
    /// What there is to know of a method of the catalogue.
    pub(super) fn of(entry: &Entry) -> Self {
        Self {
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
        }
    }
}

/// A measurement under way.
struct Measurement<'a, 'r> {
    methods: &'a [&'static Entry],
    rounds: usize,
    random: Pcg64,
    run: &'a mut Run<'r>,
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

impl Measurement<'_, '_> {
    fn task(&mut self, task: Task) -> Result<(), WrongAnswer> {
        let Task { name, description, family, inputs, timed_rays, timed } = task;
        self.run.progress.phase(&format!("{name}: asking the oracle"), 1);
        let subject = Subject::new(name, description, family, inputs);
        self.run.progress.step();
        self.run.add(subject.workload.clone());

        let methods = self.methods;
        if family == Family::Edges {
            self.cracks(&subject);
        }
        if matches!(family, Family::Random | Family::Mesh) {
            self.run.progress.phase(
                &format!("{}: comparing answers", subject.workload.name),
                methods.len() as u64 * 2,
            );
            let mut answered = Vec::new();
            for entry in methods {
                let name = &subject.workload.name;
                answered.extend(self.answer(name, entry, &entry.f32, &subject.single));
                if timed == Timed::All {
                    answered.extend(self.answer(name, entry, &entry.f64, &subject.double));
                }
            }
            self.errors(&subject, &answered);
            self.agreement(&subject, &answered);
        }
        if self.rounds > 0 && timed_rays > 0 {
            let mut groups = Vec::new();
            self.run
                .progress
                .phase(&format!("{}: preparing", subject.workload.name), methods.len() as u64 * 2);
            for entry in methods {
                let workload = &subject.workload;
                let (single, double) = (&subject.single, &subject.double);
                groups.extend(self.prepare(
                    workload,
                    entry,
                    &entry.f32,
                    single,
                    (timed, timed_rays),
                ));
                groups.extend(self.prepare(
                    workload,
                    entry,
                    &entry.f64,
                    double,
                    (timed, timed_rays),
                ));
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
                let refusal = Line::from(Refusal {
                    method: entry.info.name.to_owned(),
                    precision: E::FORMAT,
                    workload: workload.to_owned(),
                    reason: unsuitable.to_string(),
                });
                if !self.run.lines.contains(&refusal) {
                    self.run.lines.push(refusal);
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
        self.run.progress.step();
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
        let methods = self.methods;
        let Subject { workload, single, .. } = subject;
        let name = &workload.name;
        self.run.progress.phase(&format!("{name}: looking for cracks"), methods.len() as u64);
        for entry in methods {
            if let Some(answered) = self.answer(name, entry, &entry.f32, single) {
                for (variant, answers) in &answered.variants {
                    let (no_hit, many_hits) = answers.none_and_many(workload.rays);
                    self.run.add(Cracks {
                        variant: (*variant).clone(),
                        workload: name.clone(),
                        rays: workload.rays,
                        no_hit,
                        many_hits,
                    });
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
        let methods = self.methods.iter().filter(|_| !subject.is_same);
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
                    for ((quantity, value), condition) in method.quantities() {
                        let (count, relative, ulps) =
                            answers.errors(pairs, value, method.significant_bits);
                        let over = || {
                            let truth = &of.known().truth;
                            let unit = f64::from(-method.significant_bits).exp2();
                            answers.over_condition(truth, (value, condition), unit)
                        };
                        self.run.add(Error {
                            variant: (*variant).clone(),
                            workload: subject.workload.name.clone(),
                            reference: (*name).to_owned(),
                            quantity: quantity.to_owned(),
                            count,
                            relative,
                            ulps,
                            over_condition: (*name == "oracle").then(over),
                        });
                    }
                }
                self.run.add(Decisions {
                    variant: (*variant).clone(),
                    workload: subject.workload.name.clone(),
                    classes: answers.decisions(of),
                });
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
            self.run.add(Agreement {
                workload: subject.workload.name.clone(),
                precision,
                rays,
                unanimous,
                differs_from_oracle,
            });
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
        (timed, timed_rays): (Timed, usize),
    ) -> Option<Group> {
        let timed: Vec<&'static Kernel> = kernels
            .timed
            .iter()
            .filter(|kernel| kernel.variant.is_available())
            .filter(|kernel| match timed {
                Timed::All => is_shown(workload.family, kernel, &kernels.timed),
                Timed::Single => is_single(kernel, &kernels.timed),
            })
            .collect();
        if timed.is_empty() {
            self.run.progress.step();
            return None;
        }
        // Few come again and again.
        let rays: Vec<_> = rays.iter().copied().cycle().take(timed_rays).collect();
        let Some(scene) = self.scene(&workload.name, entry, kernels, &rays, triangles) else {
            self.run.progress.step();
            return None;
        };
        if matches!(workload.family, Family::Random | Family::Mesh) {
            let mut samples_ns = Vec::new();
            for _ in 0..self.rounds {
                let start = Instant::now();
                let prepared = (kernels.prepare)(triangles, &[]);
                samples_ns.push(nanoseconds(start.elapsed()));
                drop(prepared);
            }
            self.run.add(Preparation {
                method: entry.info.name.to_owned(),
                precision: E::FORMAT,
                workload: workload.name.clone(),
                triangles: triangles.len(),
                samples_ns,
            });
        }
        let group = Group::new(entry, kernels, scene, timed);
        self.run.progress.step();
        Some(group)
    }

    fn time(
        &mut self,
        subject: &Subject,
        timed_rays: usize,
        groups: &[Group],
    ) -> Result<(), WrongAnswer> {
        let mut contenders = contenders(groups, subject);
        let steps = contenders.len() * (self.rounds + 1);
        self.run.progress.phase(&format!("{}: timing", subject.workload.name), steps as u64);
        let progress = &mut *self.run.progress;
        let rounds = self.rounds;
        timing::rounds(&mut contenders, rounds, &mut self.random, |(_, contender), timed| {
            contender.sample(timed)?;
            progress.step();
            Ok(())
        })?;
        self.run.clock();
        let spent = contenders.iter().map(|(_, contender)| contender.spent).sum();
        let samples = contenders.iter().map(|(_, contender)| &contender.samples_ns[..]);
        self.run.meter.take(samples, spent);
        for (group, contender) in contenders {
            let kernel = contender.kernel;
            let Some(tally) = contender.tally else { continue };
            self.run.add(Throughput {
                variant: kernel.variant.clone(),
                workload: subject.workload.name.clone(),
                tests: (timed_rays * subject.workload.triangles) as u64,
                samples_ns: contender.samples_ns,
                hits: tally.hits,
                checksum: tally.sum.to_bits(),
                bytes_per_triangle: group.bytes_per_triangle,
            });
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

impl Answered {
    /// The answers that are the same on every machine.
    fn plain(&self) -> Option<&Answers> {
        // Deferred comes last, where there is one.
        self.variants.iter().rfind(|(variant, _)| variant.is_plain()).map(|(_, answers)| answers)
    }

    /// What the method gives that has an error.
    fn quantities(&self) -> impl Iterator<Item = ((&'static str, Quantity), ConditionOf)> {
        QUANTITIES.into_iter().zip(CONDITIONS).take(if self.weighs { 3 } else { 1 })
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

/// See [`Timed::Single`].
fn is_single(Kernel { variant, .. }: &Kernel, all: &[Kernel]) -> bool {
    let here = all.iter().map(|other| &other.variant).filter(|other| other.is_available());
    // Methods without the widest are wide enough as a tracer calls them.
    let width = here.map(|other| other.width).max().unwrap_or(1).min(8);
    variant.precision == FloatFormat::F32
        && variant.arrangement == Arrangement::OneRay
        && variant.width >= width
        && !matches!(variant.needs, Output::Point | Output::Normal)
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
