//! The lines of the stability study.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use trisect_core::FloatFormat;

use crate::record::{Variant, lines};

lines! {
    SurfaceCracks = "surface-cracks",
    StressFamily = "stress",
    ByCondition = "by-condition",
    FusedDifference = "fused-difference",
    Limits = "limits",
    Contract = "contract",
    SpecialValues = "special-values",
    Exactness = "exactness" joined Exactness::join_kinds,
    Stages = "stages",
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
    /// The first answer that was wrong, with its input: of the first kind by name in which any is.
    pub first_wrong: Option<String>,
}

impl Exactness {
    /// Takes in other kinds of scenes; whether they are tested in the same way.
    fn join_kinds(&mut self, other: &Self) -> bool {
        let same = |line: &Self| (line.method.clone(), line.precision, line.way.clone());
        let wrong = |line: &Self| {
            let mut kinds = line.kinds.iter().filter(|(_, counts)| counts.all_wrong() > 0);
            kinds.next().map(|(kind, _)| kind.clone())
        };
        let is_first = match (wrong(self), wrong(other)) {
            (Some(mine), Some(other)) => mine < other,
            (mine, _) => mine.is_some(),
        };
        if !is_first {
            self.first_wrong.clone_from(&other.first_wrong);
        }
        let is_apart = other.kinds.keys().all(|kind| !self.kinds.contains_key(kind));
        self.kinds.extend(other.kinds.clone());
        is_apart && same(self) == same(other)
    }
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
