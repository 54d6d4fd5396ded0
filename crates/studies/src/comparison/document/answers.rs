//! Which method to use: in a tree, and where every triangle is tested.
//!
//! A winner ran on every workload of the record; a difference that the record cannot tell is none.

use std::collections::BTreeMap;

use serde::Serialize;
use trisect_core::{FloatFormat, MultiplyAdd};
use trisect_kernels::Arrangement;
use trisect_method::{Form, Input, Output};
use trisect_report::document::{Content, Section, Shown};
use trisect_report::format::{grouped, number, or_dash, percent, scientific};
use trisect_report::stats::{geometric_mean, median, median_interval};
use trisect_report::table::{Cell, Columns, Kind, Table, count};

use super::view::View;
use crate::comparison::record::{MethodFacts, Refusal};
use crate::lines::distinct;
use crate::noise::Verdict;
use crate::record::Variant;
use crate::tracer::record::{Contest, Traced, TreeBuilt, TreeChecked};

/// The answers of a record.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Answers {
    /// The scenes that trees were compared on, with their triangles.
    pub scenes: Vec<(String, usize)>,
    /// Methods that were compared in trees.
    pub in_trees: usize,
    /// By how much of the speed of the fastest the slowest of them is behind it, at closest hits.
    pub most_behind: Option<f64>,
    /// Whether each scene is closed.
    pub closed: bool,
    /// Rays that were checked, and rays aimed at edges.
    pub checked: [usize; 2],
    /// In a tree: million rays per second.
    pub trees: Vec<Answer>,
    /// Every triangle tested: million tests per second.
    pub loops: Vec<Answer>,
}

/// The fastest method that keeps a promise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// The promise: `fastest`, which promises nothing, `from points`, `no cracks` or `never wrong`.
    pub asked: &'static str,
    /// Name in the catalogue.
    pub method: String,
    /// In a tree for `closest` and `any` hits in batches, and for the `closest` of `one` ray a call; or where
    /// every triangle is tested, when asked for `occlusion`, `t`, or `barycentrics`.
    pub speeds: BTreeMap<&'static str, Speed>,
    /// Wrong decisions per million: of rays in a tree, else of pairs of a ray and a triangle.
    pub wrong_per_million: Option<f64>,
    /// Rays per million aimed at edges between two triangles that pass between them.
    pub cracks_per_million: Option<f64>,
    /// Relative error of t: the largest in a tree, else the 99th percentile.
    pub error: Option<f64>,
    /// Bytes of a triangle; in a tree with its part of the nodes.
    pub bytes_per_triangle: Option<f64>,
    /// Milliseconds to build the trees of all scenes.
    pub build_ms: Option<f64>,
}

/// A speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Speed {
    /// Million per second, over rounds the median.
    pub million_per_second: f64,
    /// Half of its 95 % interval.
    pub within: f64,
    /// By how much of the fastest's speed it is behind, both in the same rounds; none where that is not told
    /// apart, and of the fastest.
    pub behind: Option<f64>,
}

/// So few triangles are tested all, without a tree.
const FEW: usize = 64;

/// What is asked of a method beside speed.
type Promise = (&'static str, fn(&MethodFacts) -> bool);

const PROMISES: [Promise; 4] = [
    ("fastest", |_| true),
    ("from points", |facts| facts.input == Some(Input::Points)),
    ("no cracks", |facts| facts.claims.iter().any(|claim| claim == "watertight")),
    ("never wrong", |facts| facts.claims.iter().any(|claim| claim == "exact")),
];

/// Million per second in each round.
type Rates = Vec<f64>;

/// A method with its rates, by what is asked of it.
type Rated<'a> = (&'a str, BTreeMap<&'static str, Rates>);

impl Answers {
    /// The answers of a record: none where its machine was too noisy to name a winner.
    pub(crate) fn of(view: &View) -> Self {
        let trees: Vec<&TreeBuilt> =
            view.all().filter(|t: &&TreeBuilt| is_ours(t.contest)).collect();
        let checks: Vec<&TreeChecked> = view.all().collect();
        let scenes = distinct(trees.iter().map(|tree| (tree.scene.clone(), tree.triangles)));
        let mut answers = Self {
            closed: checks.iter().all(|check| check.open_edges == 0),
            checked: checks.first().map_or([0; 2], |check| {
                let of_method = checks.iter().filter(|other| other.method == check.method);
                of_method.fold([0; 2], |sum, c| [sum[0] + c.rays, sum[1] + c.edge_rays])
            }),
            scenes,
            ..Self::default()
        };
        let resolution = match view.records.header.noise.map(|noise| (noise, noise.verdict())) {
            Some((_, Verdict::Unusable)) => return answers,
            Some((noise, _)) => noise.resolution(),
            None => 0.0,
        };
        let in_trees = rated_trees(view, answers.scenes.len());
        answers.in_trees = in_trees.len();
        let middles = || in_trees.iter().filter_map(|(_, rates)| median(rates.get("closest")?));
        answers.most_behind = (in_trees.len() > 1)
            .then(|| 1.0 - middles().fold(f64::MAX, f64::min) / middles().fold(0.0, f64::max));
        answers.trees = picked(view, &in_trees, resolution, |answer| {
            let mine = || checks.iter().filter(|check| check.method == answer.method);
            let per_million = |of: fn(&TreeChecked) -> usize, all: fn(&TreeChecked) -> usize| {
                let [part, all] = [of, all].map(|of| mine().map(|check| of(check)).sum::<usize>());
                (all > 0).then(|| part as f64 * 1e6 / all as f64)
            };
            answer.wrong_per_million = per_million(|check| check.wrong, |check| check.rays);
            answer.cracks_per_million = per_million(|check| check.passed, |check| check.edge_rays);
            answer.error = mine().map(|check| check.error).max_by(f64::total_cmp);
            let built = || trees.iter().filter(|tree| tree.method == answer.method);
            let [bytes, triangles] =
                built().fold([0, 0], |sum, tree| [sum[0] + tree.bytes, sum[1] + tree.triangles]);
            answer.bytes_per_triangle = (triangles > 0).then(|| bytes as f64 / triangles as f64);
            let ms = |tree: &&TreeBuilt| Some(*tree.samples_ns.iter().min()? as f64 / 1e6);
            answer.build_ms = built().map(ms).sum();
        });
        answers.trees.retain(|answer| answer.asked != "from points");
        answers.loops = picked(view, &rated_loops(view), resolution, |answer| {
            let of = (answer.method.as_str(), FloatFormat::F32);
            answer.wrong_per_million = view.wrong_per_million(of, |_| true);
            answer.error = view.pooled_error(of, "t", |_| true).map(|error| error.p99);
            answer.bytes_per_triangle = view.bytes(of.0, of.1).map(|bytes| bytes as f64);
        });
        answers
    }

    /// The answers as tables, whichever is asked first.
    pub(crate) fn sections(&self, view: &View) -> Vec<Section> {
        if view.records.header.noise.is_some_and(|noise| noise.verdict() == Verdict::Unusable) {
            let says = "**No winner is named:** the machine did other work while it measured, so that speeds \
                        are not told apart. Measure again when it is idle.";
            return vec![Section::prose(says).shown(Shown::Everywhere)];
        }
        let mut both = [self.in_a_tree(), self.in_loops(view)];
        if self.scenes.iter().any(|(_, triangles)| *triangles <= FEW) {
            both.reverse();
        }
        both.into_iter().flatten().flatten().collect()
    }

    fn in_a_tree(&self) -> Option<[Section; 2]> {
        let scenes = self.scenes.iter();
        let scenes = scenes.map(|(name, n)| format!("{name}, {} triangles", grouped(*n as u64)));
        let head = format!(
            "**Rays against a mesh: use a tree.** {}; million rays/s on one thread.",
            scenes.collect::<Vec<_>>().join("; "),
        );
        let matters = match self.most_behind {
            Some(most) if most < 0.2 => format!(
                " The choice matters little: all {} methods that are compiled into the loop are within {} of \
                 the fastest.",
                self.in_trees,
                percent(most * 100.0),
            ),
            _ => String::new(),
        };
        let build = self.trees.iter().map(|answer| or_dash(answer.build_ms, number));
        let error = self.trees.iter().map(|answer| or_dash(answer.error, scientific));
        let [build, error] = [distinct(build), distinct(error)].map(|all| all.join(", "));
        let says = format!(
            "closest, any: hits of batches; 1 ray: a call for each. ±: 95 % interval; else the difference to \
             the fastest, none where it is not told apart. wrong: rays in 10⁶, of {} checked by exact \
             arithmetic; cracks: of {} aimed at edges between two triangles, those in 10⁶ that pass. B: bytes \
             of a triangle. Built in {build} ms; largest relative errors of t: {error}.{matters}",
            grouped(self.checked[0] as u64),
            grouped(self.checked[1] as u64),
        );
        let table = columns(&self.trees, &["closest", "any", "one"])
            .number("wrong", number, |answer| answer.wrong_per_million)
            .number("cracks", number, |answer| answer.cracks_per_million)
            .number("B", count, |answer| answer.bytes_per_triangle);
        answered(("in-a-tree", "In a tree"), head, says, table.done())
    }

    fn in_loops(&self, view: &View) -> Option<[Section; 2]> {
        let head = "**A few triangles, or leaves of your own: test them all.** Million tests/s on one core, one \
                    ray at a time.";
        let refused = distinct(view.all::<Refusal>().map(|refusal| refusal.method.as_str()));
        let refused = match refused[..] {
            [] => String::new(),
            _ => format!(" Without {}, which not all of it suits.", refused.join(", ")),
        };
        let says = format!(
            "hit, t, t β γ: what is asked for. err t: relative error of t, 99th percentile; wrong: decisions in \
             10⁶.{refused}",
        );
        let table = columns(&self.loops, &["occlusion", "t", "barycentrics"])
            .number("err t", scientific, |answer| answer.error)
            .number("wrong", number, |answer| answer.wrong_per_million)
            .number("B", count, |answer| answer.bytes_per_triangle);
        let head = head.to_owned();
        answered(("every-triangle", "Every triangle"), head, says, table.done())
    }
}

/// What a table answers, and the table; nothing where it has no rows.
fn answered(
    (id, title): (&'static str, &str),
    head: String,
    says: String,
    table: Table,
) -> Option<[Section; 2]> {
    let head = Section::new(id, title, Content::Prose).says(head);
    let both = [head, Section::table("", "", says, table)];
    (!both[1].is_empty())
        .then(|| both.map(|section| section.shown(Shown::Everywhere).part("answers")))
}

/// The columns that both tables begin with.
fn columns<'a>(answers: &'a [Answer], speeds: &[&'static str]) -> Columns<'a, Answer> {
    let columns =
        Table::of(answers).text("", |answer| answer.asked).name("method", |answer| &answer.method);
    speeds.iter().fold(columns, |columns, speed| {
        let name = match *speed {
            "occlusion" => "hit",
            "barycentrics" => "t β γ",
            "one" => "1 ray",
            name => name,
        };
        // Where intervals stand they are of the fastest, and the others stand beside it.
        let is_wide = matches!(*speed, "closest" | "any");
        columns.cells(name, Kind::Number, |answer| {
            let Some(Speed { million_per_second, within, behind }) = answer.speeds.get(speed)
            else {
                return Cell::Missing;
            };
            let shown = number(*million_per_second);
            let percent = |share: f64| format!("{:.0}%", share * 100.0);
            Cell::Text(match behind {
                _ if !is_wide => shown,
                None if answer.asked == "fastest" => {
                    format!("{shown} ±{}", percent(within / million_per_second))
                }
                None => format!("{shown} none"),
                Some(behind) => format!("{shown} {}", percent(-behind).replace('-', "−")),
            })
        })
    })
}

/// The fastest of some methods that keeps each promise, and takes every workload of the record.
fn picked(
    view: &View,
    rated: &[Rated],
    resolution: f64,
    fill: impl Fn(&mut Answer),
) -> Vec<Answer> {
    let score = |(_, rates): &&Rated| {
        geometric_mean(rates.values().filter_map(|rates| median(rates))).unwrap_or(0.0)
    };
    let mut order: Vec<&Rated> = rated.iter().collect();
    order.sort_by(|a, b| score(b).total_cmp(&score(a)));
    let Some((_, fastest)) = order.first() else { return Vec::new() };
    let answer = |(asked, keeps): Promise| {
        let all = order.iter().filter(|(method, _)| view.fact(method).is_some_and(keeps));
        all.map(|(method, rates)| {
            let speed = |(&of, rates): (&&'static str, &Rates)| {
                let speed = Speed::of(rates, fastest.get(of), resolution)?;
                Some((of, speed))
            };
            let mut answer = Answer {
                asked,
                method: (*method).to_owned(),
                speeds: rates.iter().filter_map(speed).collect(),
                wrong_per_million: None,
                cracks_per_million: None,
                error: None,
                bytes_per_triangle: None,
                build_ms: None,
            };
            fill(&mut answer);
            answer
        })
        .find(|answer| match asked {
            // A promise that this record shows broken is none.
            "no cracks" => answer.cracks_per_million.is_none_or(|cracks| cracks == 0.0),
            "never wrong" => answer.wrong_per_million.is_none_or(|wrong| wrong == 0.0),
            _ => true,
        })
    };
    PROMISES.into_iter().filter_map(answer).collect()
}

impl Speed {
    fn of(rates: &Rates, fastest: Option<&Rates>, resolution: f64) -> Option<Self> {
        let [low, middle, high] = median_interval(rates)?;
        let ratios = fastest.map(|of| rates.iter().zip(of).map(|(a, b)| a / b).collect::<Vec<_>>());
        let behind =
            ratios.and_then(|ratios| median_interval(&ratios)).and_then(|[low, share, high]| {
                let is_told = (high < 1.0 || low > 1.0) && (share - 1.0).abs() > resolution;
                is_told.then_some(1.0 - share)
            });
        Some(Self { million_per_second: middle, within: (high - low) / 2.0, behind })
    }
}

/// Million per second in each round, over some sets of samples that all have.
fn rates(sets: &[(u64, &[u64])]) -> Rates {
    let rounds = sets.iter().map(|(_, samples)| samples.len()).min().unwrap_or(0);
    let of = |round: usize| {
        geometric_mean(
            sets.iter().map(|(count, samples)| *count as f64 * 1e3 / samples[round] as f64),
        )
    };
    (0..rounds).filter_map(of).collect()
}

fn is_ours(contest: Contest) -> bool {
    contest == Contest::Together
}

/// Methods that went through trees of all scenes.
fn rated_trees<'a>(view: &View<'a>, scenes: usize) -> Vec<Rated<'a>> {
    let ours: Vec<&Traced> = view.all().filter(|t: &&Traced| is_ours(t.contest)).collect();
    let methods = distinct(ours.iter().map(|traced| traced.method.as_str()));
    let rated = |method: &'a str| {
        let of = |is: fn(&Traced) -> bool| {
            let mine = ours.iter().filter(|t| t.method == method && is(t));
            let sets: Vec<_> = mine.map(|t| (t.rays, &t.samples_ns[..])).collect();
            (sets.len() == scenes).then(|| rates(&sets)).filter(|rates| !rates.is_empty())
        };
        let all = [
            ("closest", of(|t| !t.any && t.calls == "batch")),
            ("any", of(|t| t.any && t.calls == "batch")),
            ("one", of(|t| !t.any && t.calls == "ray")),
        ];
        let all = all.into_iter().map(|(name, rates)| Some((name, rates?)));
        Some((method, all.collect::<Option<_>>()?))
    };
    methods.into_iter().filter_map(rated).collect()
}

/// Methods that every workload was timed with, one ray at a time in single precision, each by its fastest
/// variant that gives what is asked. A watertight one is so in plain arithmetic and by numerators,
/// but for one that is exact, in any.
fn rated_loops<'a>(view: &View<'a>) -> Vec<Rated<'a>> {
    let rated = |method: &'a str| {
        let facts = view.fact(method)?;
        let is_bound = PROMISES[2].1(facts) && !PROMISES[3].1(facts);
        let of = |asked: Output| {
            let keep = |v: &Variant| {
                v.method == method
                    && v.precision == FloatFormat::F32
                    && v.arrangement == Arrangement::OneRay
                    && gives(v.needs, asked)
                    && !view.is_refused(v)
                    && (!is_bound
                        || (v.arithmetic == MultiplyAdd::Plain && v.division == Form::Deferred))
            };
            let comparable = view.comparable(keep);
            let (variant, _) = *comparable.scores().first()?;
            let sets = comparable.workloads.iter().filter_map(|workload| {
                let timed = view.throughput.get(variant)?.get(workload)?;
                Some((timed.tests, &timed.samples_ns[..]))
            });
            Some((asked.name(), rates(&sets.collect::<Vec<_>>())))
        };
        let speeds: BTreeMap<_, _> = [Output::Occlusion, Output::T, Output::Barycentrics]
            .into_iter()
            .filter_map(of)
            .collect();
        (!speeds.is_empty()).then_some((method, speeds))
    };
    view.methods().iter().filter_map(|method| rated(method)).collect()
}

/// Whether a kernel that was asked for `output` gives `asked`.
fn gives(output: Output, asked: Output) -> bool {
    match asked {
        Output::Occlusion => true,
        Output::T => matches!(output, Output::T | Output::Barycentrics | Output::Normal),
        other => output == other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_told_apart_by_rounds_in_turn() {
        // Everything slows down, and the second is a tenth behind all the time.
        let fast = vec![10.0, 9.0, 8.0, 7.0, 6.0, 5.0, 4.0];
        let slow: Rates = fast.iter().map(|x| x * 0.9).collect();
        let behind = |rates: &Rates, resolution| {
            Speed::of(rates, Some(&fast), resolution).expect("it was timed").behind
        };
        assert!(behind(&slow, 0.02).is_some_and(|share| (share - 0.1).abs() < 1e-12));
        assert_eq!(behind(&slow, 0.15), None, "the machine is too noisy");
        assert_eq!(behind(&fast, 0.0), None);
        // Ahead in some rounds, and behind in others.
        let either: Rates =
            fast.iter().zip([0.9, 1.1].into_iter().cycle()).map(|(x, by)| x * by).collect();
        assert_eq!(behind(&either, 0.0), None);
    }

    #[test]
    fn what_gives_more_answers_as_well() {
        assert!(gives(Output::Barycentrics, Output::T));
        assert!(gives(Output::Normal, Output::Occlusion));
        assert!(!gives(Output::T, Output::Barycentrics));
        assert!(!gives(Output::Occlusion, Output::T));
    }
}
