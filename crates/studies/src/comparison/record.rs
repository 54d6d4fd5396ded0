//! The lines of a comparison.

use serde::{Deserialize, Serialize};
use trisect_core::FloatFormat;
use trisect_method::{Form, Input, Output};

use crate::record::{Variant, lines};

lines! {
    MethodFacts = "method",
    Workload = "workload",
    Throughput = "throughput",
    Error = "error",
    Decisions = "decisions",
    Preparation = "preparation",
    Agreement = "agreement",
    Refusal = "refusal",
    Cracks = "cracks",
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
    /// Errors over the condition number times the unit roundoff of the variant's precision; against the oracle
    /// alone, and in no record older than this field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over_condition: Option<Quantiles>,
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
