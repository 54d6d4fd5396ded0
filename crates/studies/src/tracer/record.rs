//! The lines of the study of the tracer.

use serde::{Deserialize, Serialize};

use crate::record::lines;

lines! {
    TreeBuilt = "tree",
    Traced = "traced",
    TreeChecked = "tree-checked",
}

/// What a tree of the tracer's study takes part in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Contest {
    /// Every method, called for each leaf, in turn with the one that all are compared with, on one thread.
    Methods,
    /// Every method whose test is compiled into the traversal loop as well, in turn with itself called for
    /// each leaf, on one thread.
    Inline,
    /// Every method whose test is compiled into the traversal loop, and no other: all in turn, on one thread.
    Together,
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
    /// `primary`, `random`, `diffuse` or `occlusion`; of [`Contest::Together`] `closest` or `any`, which are
    /// rays of all classes.
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

/// The answers of a tree against exact arithmetic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeChecked {
    /// Name of the method in the catalogue.
    pub method: String,
    /// Name of the scene.
    pub scene: String,
    /// Edges of the scene that do not join two triangles; none where it is closed.
    pub open_edges: usize,
    /// Rays whose answers were checked.
    pub rays: usize,
    /// Those of them for which whether they hit, or what they hit first, is not the truth.
    pub wrong: usize,
    /// The largest relative error of `t` over the others.
    pub error: f64,
    /// Rays aimed at edges between two triangles that face them alike.
    pub edge_rays: usize,
    /// Those of them that pass between the two.
    pub passed: usize,
}
