//! The records: one JSON object a line, written by `measure` and `verify`, read by everything
//! else. Times are integer nanoseconds, floats keep every bit, and the first line holds the
//! facts about the machine.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
pub use trisect_catalog::Variant;
use trisect_core::{FloatFormat, Form, Input, InstructionSet, Output};

use crate::stats;

mod reading;

pub use reading::{ReadError, Records};

/// The version of the schema that this build writes and reads.
pub const SCHEMA: u32 = 7;

/// One line of a record file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Record {
    /// The first line: who measured, where and how.
    Header(Header),
    /// A method that was measured.
    Method(MethodFacts),
    /// A set of rays and triangles that something was measured on.
    Workload(Workload),
    /// The time of one variant on one workload.
    Throughput(Throughput),
    /// The error of one variant on one workload, in one quantity, against one reference.
    Error(Error),
    /// The decisions of one variant on one workload, against the oracle.
    Decisions(Decisions),
    /// The time to prepare a workload's triangles for one method.
    Preparation(Preparation),
    /// Whether all methods pick the same triangle for each ray of a workload.
    Agreement(Agreement),
    /// A method that cannot take a workload's triangles.
    Refusal(Refusal),
    /// Rays that pass through a closed surface.
    Cracks(Cracks),
    /// Rays that pass through closed surfaces, of the stability study.
    SurfaceCracks(SurfaceCracks),
    /// What a variant does on a family of hard pairs.
    Stress(StressFamily),
    /// The errors of a variant against the condition number.
    ByCondition(ByCondition),
    /// What fused multiply-add changes.
    FusedDifference(FusedDifference),
    /// Where a variant begins to be wrong.
    Limits(Limits),
    /// What a variant does with a clause of the contract.
    Contract(Contract),
    /// What a variant makes of a special value.
    SpecialValues(SpecialValues),
    /// A method that claims to be exact, held to it.
    Exactness(Exactness),
    /// Which stage of a method decides.
    Stages(Stages),
    /// A tree over a scene, and the time to build it.
    Tree(TreeBuilt),
    /// The time of rays through a tree.
    Traced(Traced),
    /// The time of pictures of a scene.
    Frames(Frames),
    /// A picture to look at.
    Picture(Picture),
    /// What it takes to keep what nobody asks for.
    Omission(Omission),
    /// Code that is compiled several times.
    Code(Code),
}

/// Who measured, where and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// [`SCHEMA`] of the writer.
    pub schema: u32,
    /// The version of trisect.
    pub trisect: String,
    /// The command line, as typed.
    pub command: String,
    /// Start of the measurement, RFC 3339, UTC.
    pub started: String,
    /// The seed of every workload.
    pub seed: u64,
    /// How many rounds each variant was timed for.
    pub rounds: usize,
    /// The machine.
    pub machine: Machine,
}

/// The machine a record was made on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's own name.
    pub cpu: String,
    /// How many logical processors the process may use.
    pub logical_cpus: usize,
    /// Instruction sets that kernels may use here, weakest first.
    pub instruction_sets: Vec<InstructionSet>,
    /// Operating system and architecture.
    pub platform: String,
    /// The compiler and its version.
    pub compiler: String,
    /// Compiler flags, profile and target of the build.
    pub build: String,
    /// Frequency of the core while measuring, in GHz: median over the rounds of a chain of
    /// dependent operations of known latency. Cycles are derived from it.
    pub core_ghz: f64,
}

/// A method that was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodFacts {
    /// Name in the catalogue, as typed on the command line.
    pub name: String,
    /// Name in prose.
    pub title: String,
    /// Year of publication.
    pub year: u16,
    /// Citation.
    pub source: String,
    /// Numbers stored per triangle.
    pub stored_numbers: usize,
    /// What a triangle is given as; `None` in the oldest records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<Input>,
    /// What a hit can be asked for. What is not listed is not timed.
    #[serde(default)]
    pub outputs: Vec<Output>,
    /// The forms of the division that the method has.
    #[serde(default)]
    pub divisions: Vec<Form>,
    /// What the method promises: `watertight`, `culls`, `unit-direction` (which it needs).
    #[serde(default)]
    pub claims: Vec<String>,
    /// What each part costs.
    #[serde(default)]
    pub cost: Vec<PartCost>,
}

/// Operations of one part of a method, counted by running its formula.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartCost {
    /// Which part.
    pub part: String,
    /// Products.
    pub multiplies: u32,
    /// Sums and differences.
    pub adds: u32,
    /// Quotients.
    pub divisions: u32,
    /// Comparisons.
    pub comparisons: u32,
}

/// A set of rays and triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Workload {
    /// Unique name within the file, for example `random`, `bunny/primary`, `hit-rate/30`.
    pub name: String,
    /// One sentence for a reader.
    pub description: String,
    /// What it is for: decides the figure that it appears in.
    pub family: Family,
    /// Rays.
    pub rays: usize,
    /// Triangles.
    pub triangles: usize,
    /// Ray–triangle pairs that the oracle calls a hit, as a share of the pairs looked at.
    pub hit_rate: f64,
    /// How many pairs the oracle was asked, and how many of those needed exact arithmetic.
    pub oracle_tests: u64,
    /// See [`Workload::oracle_tests`].
    pub oracle_exact: u64,
}

/// What a workload is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// Random rays and triangles, as in the literature.
    Random,
    /// Rays against a mesh.
    Mesh,
    /// One of a series in which the share of hits grows from 0 to 100 %.
    HitRate,
    /// One of a series in which the number of triangles grows from L1 to DRAM.
    WorkingSet,
    /// Rays that share an origin or a direction.
    Packets,
    /// Rays aimed at the edges of a closed surface.
    Edges,
}

/// The time of one variant on one workload.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Throughput {
    /// The variant.
    #[serde(flatten)]
    pub variant: Variant,
    /// Name of the [`Workload`].
    pub workload: String,
    /// Ray–triangle tests in one sample.
    pub tests: u64,
    /// Nanoseconds of each sample, in the order measured.
    pub samples_ns: Vec<u64>,
    /// Hits that each sample counted, verified.
    pub hits: u64,
    /// Bits of the sum that each sample returned, verified.
    pub checksum: u64,
    /// Bytes of prepared data read per triangle.
    pub bytes_per_triangle: usize,
}

/// The error of one variant over the hits that it shares with the reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Error {
    /// The variant; `early_out`, `needs` and `arrangement` do not change values.
    #[serde(flatten)]
    pub variant: Variant,
    /// Name of the [`Workload`].
    pub workload: String,
    /// `oracle` or `f64-moller-trumbore`.
    pub reference: String,
    /// `t`, `beta` or `gamma`.
    pub quantity: String,
    /// Hits compared.
    pub count: u64,
    /// Relative errors `|x − reference| / |reference|`; 0 where both are 0.
    pub relative: Quantiles,
    /// The same in units of the last place of the variant's own precision, at the reference.
    pub ulps: Quantiles,
}

/// Of a list of errors; all zero for an empty one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// Arithmetic mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Largest.
    pub max: f64,
}

/// The decisions of one variant on every pair of a workload, against the oracle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decisions {
    /// The variant.
    #[serde(flatten)]
    pub variant: Variant,
    /// Name of the [`Workload`].
    pub workload: String,
    /// Pairs, by the oracle's class and the variant's answer.
    pub classes: Vec<ClassCount>,
}

/// One row of a confusion table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClassCount {
    /// The oracle's class, for example `interior`, `edge`, `miss`.
    pub class: String,
    /// Whether the class is a hit.
    pub is_hit: bool,
    /// Pairs of the class that the variant called a hit.
    pub called_hit: u64,
    /// Pairs of the class that the variant called a miss.
    pub called_miss: u64,
}

/// The time to prepare a workload's triangles for one method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Preparation {
    /// Name of the method in the catalogue.
    pub method: String,
    /// The format that it was prepared in.
    pub precision: FloatFormat,
    /// Name of the [`Workload`].
    pub workload: String,
    /// Triangles prepared in one sample.
    pub triangles: usize,
    /// Nanoseconds of each sample.
    pub samples_ns: Vec<u64>,
}

/// Whether all methods pick the same closest triangle for each ray of a workload.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// Name of the [`Workload`].
    pub workload: String,
    /// The format that it was prepared in.
    pub precision: FloatFormat,
    /// Rays looked at.
    pub rays: usize,
    /// Rays for which every method named the same triangle, or every one a miss.
    pub unanimous: usize,
    /// Per method, rays for which its answer differs from the oracle's closest triangle.
    pub differs_from_oracle: Vec<MethodCount>,
}

/// A count for one method.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MethodCount {
    /// Name of the method in the catalogue.
    pub method: String,
    /// The count.
    pub count: usize,
}

/// A method that cannot take a workload's triangles.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refusal {
    /// Name of the method in the catalogue.
    pub method: String,
    /// The format that it was prepared in.
    pub precision: FloatFormat,
    /// Name of the [`Workload`].
    pub workload: String,
    /// What the method said.
    pub reason: String,
}

/// Rays from inside a closed surface that one variant lets out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cracks {
    /// The variant.
    #[serde(flatten)]
    pub variant: Variant,
    /// Name of the [`Workload`].
    pub workload: String,
    /// Rays.
    pub rays: usize,
    /// Rays that hit nothing.
    pub no_hit: usize,
    /// Rays that hit more than one triangle, as they may where triangles meet.
    pub many_hits: usize,
}

/// Rays from inside closed surfaces, aimed at edges and corners, that one variant lets out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceCracks {
    /// The variant.
    #[serde(flatten)]
    pub variant: Variant,
    /// The surfaces that the method can take, wherever they are put.
    pub sites: Vec<Site>,
}

/// A closed surface, put somewhere, with rays aimed at one kind of feature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Site {
    /// Name of the surface.
    pub surface: String,
    /// `edges` or `vertices`.
    pub aim: String,
    /// Distance of the surface from the world's origin; its radius is about 2 times the scale.
    pub offset: f64,
    /// The factor of its size.
    pub scale: f64,
    /// Rays.
    pub rays: usize,
    /// Rays that hit nothing.
    pub no_hit: usize,
    /// Rays that hit more than one of the triangles that meet where they are aimed.
    pub many_hits: usize,
}

/// The median and the largest of a list, to three digits; both 0 for an empty one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread(pub f32, pub f32);

/// What a variant does on a family of hard pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StressFamily {
    /// The variant.
    #[serde(flatten)]
    pub variant: Variant,
    /// Name of the family.
    pub family: String,
    /// What its level is, with the unit.
    pub knob: String,
    /// The precision that the numbers of the pairs are given in.
    pub inputs: FloatFormat,
    /// Whether subnormal numbers count as zeros.
    pub flush_to_zero: bool,
    /// The levels, easiest first.
    pub levels: Vec<StressLevel>,
}

/// What a variant does at one level of difficulty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StressLevel {
    /// The level.
    pub level: f64,
    /// Per class of the oracle the pairs that the variant called a hit, and a miss.
    pub classes: BTreeMap<String, [u64; 2]>,
    /// Pairs that were called a hit and are none.
    pub false_hits: u64,
    /// Pairs that were called a miss and are a hit.
    pub false_misses: u64,
    /// Pairs whose answer is wrong by more than a thousandth: the decision, `t` relative to itself, or
    /// a weight.
    pub wrong: u64,
    /// Errors of `t` over the agreed hits.
    pub t: Errors,
    /// Errors of `beta`, where the method gives it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beta: Option<Errors>,
    /// Errors of `gamma`, where the method gives it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gamma: Option<Errors>,
    /// Distance of `O + t·D` from the true point, as a share of the longest edge.
    pub point_along_ray: Spread,
    /// Distance of the point that the weights give from the true one, in the same unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point_by_weights: Option<Spread>,
}

/// The errors of one number; in a file the four in order, without their names: there are so many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[Spread; 4]", into = "[Spread; 4]")]
pub struct Errors {
    /// Relative to the true value; 0 where both are 0, left out where that is 0 alone.
    pub relative: Spread,
    /// As they are.
    pub absolute: Spread,
    /// In units of the last place of the variant's own precision, at the true value.
    pub ulps: Spread,
    /// Over the condition number times the unit roundoff.
    pub over_condition: Spread,
}

impl From<[Spread; 4]> for Errors {
    fn from([relative, absolute, ulps, over_condition]: [Spread; 4]) -> Self {
        Self { relative, absolute, ulps, over_condition }
    }
}

impl From<Errors> for [Spread; 4] {
    fn from(errors: Errors) -> Self {
        let Errors { relative, absolute, ulps, over_condition } = errors;
        [relative, absolute, ulps, over_condition]
    }
}

/// The errors of a variant in one number against its condition number, over all families but those
/// about the range of numbers: those of `t` and their condition number relative to `t`, those of the
/// weights as they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ByCondition {
    /// The variant.
    #[serde(flatten)]
    pub variant: Variant,
    /// The precision that the numbers of the pairs are given in.
    pub inputs: FloatFormat,
    /// `t`, `beta` or `gamma`.
    pub quantity: String,
    /// By decade of the condition number; those without pairs are left out.
    pub decades: Vec<Bin>,
    /// Easy, stiff and extreme: below 10², below 10⁶, and beyond.
    pub strata: Vec<Bin>,
}

/// The errors of the pairs whose condition number is in a range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// The smallest condition number.
    pub from: f64,
    /// The first one beyond.
    pub to: f64,
    /// Pairs.
    pub count: u64,
    /// The errors.
    pub error: Spread,
    /// The same over the condition number times the unit roundoff.
    pub over_condition: Spread,
}

/// What fused multiply-add changes, over all families but those about the range of numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FusedDifference {
    /// The fused variant; it is compared with the plain one of the same division.
    #[serde(flatten)]
    pub variant: Variant,
    /// The precision that the numbers of the pairs are given in.
    pub inputs: FloatFormat,
    /// Pairs.
    pub pairs: u64,
    /// Pairs that are decided differently.
    pub decisions: u64,
    /// The difference of `t` over its condition number times the unit roundoff.
    pub t: Spread,
    /// The same of `beta`, where the method gives it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beta: Option<Spread>,
    /// The same of `gamma`, where the method gives it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gamma: Option<Spread>,
}

/// The levels of a family between which a variant is right to a thousandth, to three digits. The ends
/// of the precision's range where it is right up to there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// The variant.
    #[serde(flatten)]
    pub variant: Variant,
    /// Name of the family.
    pub family: String,
    /// The smallest level.
    pub smallest: f64,
    /// The largest level.
    pub largest: f64,
}

/// A clause of the contract that every method keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clause {
    /// No hit holds a NaN or an infinity.
    FiniteHits,
    /// A ray or a triangle with a NaN or an infinity in it misses.
    NotFiniteMisses,
    /// A degenerate triangle is missed.
    DegenerateMisses,
    /// A ray with a zero direction misses.
    ZeroDirectionMisses,
    /// The `t` of a hit is in the interval.
    WithinInterval,
    /// Whatever is asked, and in whatever arrangement, the decision is the same.
    SameDecisions,
    /// Every width and instruction set gives the same bits.
    SameBits,
}

/// What a variant does with a clause of the contract.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Contract {
    /// The variant.
    #[serde(flatten)]
    pub variant: Variant,
    /// Per clause the pairs that were tested, and those that violate it.
    pub clauses: BTreeMap<Clause, [u64; 2]>,
}

/// A method that claims to be exact, held to it in one way: by a kernel in one arrangement, or in the tree.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Exactness {
    /// The method.
    pub method: String,
    /// The format that it was prepared in.
    pub precision: FloatFormat,
    /// Lanes, instruction set, arithmetic and arrangement, or how rays go through the tree.
    pub way: String,
    /// By the kind of scene.
    pub kinds: BTreeMap<String, ExactCounts>,
    /// The first answer that was wrong, with its input.
    pub first_wrong: Option<String>,
}

/// Answers held to the oracle's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExactCounts {
    /// Tests of one ray against one triangle.
    pub tests: u64,
    /// Those that are decided wrongly.
    pub wrong: u64,
    /// Hits with a value that is not the true one, rounded once.
    pub wrong_values: u64,
    /// Rays whose first triangle was asked for.
    pub rays: u64,
    /// Those with another first triangle than the true one.
    pub wrong_closest: u64,
}

impl ExactCounts {
    /// Adds other counts.
    pub fn add(&mut self, other: &Self) {
        self.tests += other.tests;
        self.wrong += other.wrong;
        self.wrong_values += other.wrong_values;
        self.rays += other.rays;
        self.wrong_closest += other.wrong_closest;
    }

    /// All that are wrong in any way.
    pub fn all_wrong(&self) -> u64 {
        self.wrong + self.wrong_values + self.wrong_closest
    }
}

/// Which stage of a method decides pairs of one source.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stages {
    /// The method.
    pub method: String,
    /// The format that it was prepared in.
    pub precision: FloatFormat,
    /// A family of hard pairs, over all its levels, or a scene.
    pub source: String,
    /// The stages, the cheapest first.
    pub stages: Vec<String>,
    /// How many pairs each decides.
    pub pairs: Vec<u64>,
}

/// What a variant makes of special values in the place of a number of a clear hit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SpecialValues {
    /// The variant.
    #[serde(flatten)]
    pub variant: Variant,
    /// Whether subnormal numbers count as zeros.
    pub flush_to_zero: bool,
    /// By value and place.
    pub outcomes: Vec<Outcome>,
}

/// What a special value in some place leads to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    /// The value.
    pub value: String,
    /// `origin`, `direction`, `tmin`, `tmax` or `corner`.
    pub place: String,
    /// Pairs.
    pub tests: u64,
    /// Pairs that were called a hit.
    pub hits: u64,
    /// Pairs that were called a hit and are none.
    pub false_hits: u64,
    /// Pairs that were called a miss and are a hit.
    pub false_misses: u64,
}

/// What a tree of the tracer's study takes part in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Contest {
    /// Every method behind a call, in turn with the one that all are compared with, on one thread.
    Methods,
    /// The methods whose test is compiled into the traversal loop, in turn with themselves behind a call.
    Inline,
    /// One method: its trees, and the ways to trace them, in turn, on one thread.
    Trees,
    /// One method: numbers of threads, in turn.
    Threads,
}

/// A tree over a scene, and the time to build it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeBuilt {
    /// What it takes part in.
    pub contest: Contest,
    /// Name of the method in the catalogue.
    pub method: String,
    /// Name of the scene.
    pub scene: String,
    /// Triangles of the scene.
    pub triangles: usize,
    /// `linear`, `binned` or `spatial`.
    pub builder: String,
    /// When triangles become a leaf: `cheapest`, or always up to `16` or `32`.
    pub leaves: String,
    /// Threads that built it.
    pub threads: usize,
    /// Nanoseconds of each time that it was built.
    pub samples_ns: Vec<u64>,
    /// Wide nodes.
    pub nodes: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
    /// Triangles in leaves; more than the scene has where space was split.
    pub references: usize,
    /// Nodes on the longest way down.
    pub depth: usize,
    /// Bytes of nodes and blocks.
    pub bytes: usize,
    /// Expected tests of a node or a block for a ray that meets the root.
    pub cost: f64,
}

/// The time of rays through a tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Traced {
    /// What the tree takes part in.
    pub contest: Contest,
    /// Name of the method in the catalogue.
    pub method: String,
    /// Name of the scene.
    pub scene: String,
    /// `linear`, `binned` or `spatial`.
    pub builder: String,
    /// When triangles become a leaf: `cheapest`, or always up to `16` or `32`.
    pub leaves: String,
    /// `primary`, `random`, `diffuse` or `occlusion`.
    pub class: String,
    /// Whether any hit was asked for instead of the closest.
    pub any: bool,
    /// `single`, `packets` or `plain`.
    pub tracing: String,
    /// `batch`, one call of the tree for all rays of a turn, or `ray`, one for each.
    pub calls: String,
    /// Threads that traced.
    pub threads: usize,
    /// Rays of a sample.
    pub rays: u64,
    /// Rays that hit, the same in every sample.
    pub hits: u64,
    /// Rays whose decision differs from the same method's in plain arithmetic.
    pub differ: u64,
    /// Nanoseconds of each sample, in the order measured.
    pub samples_ns: Vec<u64>,
    /// The same of the method that all are compared with, its rays in turn with these, in the same
    /// rounds. Of [`Contest::Methods`] and [`Contest::Inline`] alone: in the others all lines of a class went in turn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub baseline_ns: Vec<u64>,
}

/// What pictures are timed for: those of one series differ in one thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrameSeries {
    /// The picture that the speed is wanted of: 640 by 480, one sample, one light, depth 16.
    Goal,
    /// Sizes of pictures, each from low to very hard.
    Sizes,
    /// Threads.
    Threads,
    /// Samples of a pixel.
    Samples,
    /// Lights.
    Lights,
    /// How often a ray may be reflected.
    Depth,
    /// When triangles become a leaf.
    Leaves,
    /// Sizes of tiles.
    Tiles,
    /// From a serial scalar tracer that tests every triangle, one technique after another.
    Techniques,
}

/// The time of pictures of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    /// What it is compared with.
    pub series: FrameSeries,
    /// What sets it apart from others of its series.
    pub name: String,
    /// The scene's name.
    pub scene: String,
    /// Name of the method.
    pub method: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples of a pixel.
    pub samples: u32,
    /// How often a ray may be reflected.
    pub depth: u32,
    /// Lights.
    pub lights: usize,
    /// Threads that render.
    pub threads: usize,
    /// Pixels across and down of a tile.
    pub tile: u32,
    /// When triangles become a leaf: `cheapest`, or always up to `16` or `32`.
    pub leaves: String,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Rays of a picture, the same in every sample.
    pub rays: u64,
    /// Nanoseconds of each picture, in the order measured.
    pub samples_ns: Vec<u64>,
}

/// A picture to look at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Its name.
    pub name: String,
    /// What is to be seen.
    pub says: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// A PNG, in base64.
    pub png: String,
}

/// Where something that nobody asks for is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layer {
    /// The test of rays against triangles.
    Kernel,
    /// The way of rays through a tree.
    Tracer,
    /// The renderer.
    Picture,
}

/// What it takes to keep what nobody asks for: the same work timed with it and without, in turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Omission {
    /// Where it is left out.
    pub layer: Layer,
    /// What is left out.
    pub part: String,
    /// Name of the scene, or of the [`Workload`].
    pub scene: String,
    /// What is done with it: the form of the division, the class of rays, what is asked of a picture.
    pub of: String,
    /// Name of the method in the catalogue.
    pub method: String,
    /// Nanoseconds of each sample without it, in the order measured.
    pub without_ns: Vec<u64>,
    /// Nanoseconds of each sample with it, in the same rounds.
    pub with_ns: Vec<u64>,
}

impl Omission {
    /// How many times as long it takes with it as without, of each round: the median, and the quartiles.
    /// `None` where nothing was timed.
    pub fn ratio(&self) -> Option<(f64, [f64; 2])> {
        let pairs = self.with_ns.iter().zip(&self.without_ns);
        let ratios: Vec<f64> =
            pairs.map(|(with, without)| *with as f64 / (*without).max(1) as f64).collect();
        let (low, high) = stats::quartiles(&ratios)?;
        Some((stats::median(&ratios)?, [low, high]))
    }
}

/// Code that is compiled once for each of several sets of needs, as the program holds it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Code {
    /// Of what.
    pub of: String,
    /// How often it is compiled.
    pub instances: usize,
    /// Bytes of machine code of all instances.
    pub bytes: u64,
    /// Bytes of machine code of the whole program.
    pub of_bytes: u64,
}
