//! The trees that are compiled in this crate, once: what the methods of a [`Scene`](crate::Scene) are made of. A
//! program that uses them compiles none.

use trisect_exact::ExactInTrees;
use trisect_method::{Method, UnsuitableMesh};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_tracer::{Builder, Bvh, Leaves, Tree};
use trisect_watertight::Watertight;

use crate::Triangle;

/// Builds a tree over triangles, or says why the method does not take them.
pub type BuildTree = fn(&[Triangle], Builder, Leaves) -> Result<Box<dyn Tree>, UnsuitableMesh>;

/// The names of the methods whose trees are here, as the catalogue of methods has them: that which is never wrong,
/// the fastest, and that which lets no ray through between triangles.
pub const NAMES: [&str; 3] = [EXACT.0, FAST.0, WATERTIGHT.0];

const EXACT: (&str, BuildTree) = (ExactInTrees::INFO.name, exact);
const FAST: (&str, BuildTree) = (MollerTrumbore::INFO.name, fast);
const WATERTIGHT: (&str, BuildTree) = (<Watertight>::INFO.name, watertight);

/// The function that builds the tree of a method of [`NAMES`].
pub fn find(name: &str) -> Option<BuildTree> {
    [EXACT, FAST, WATERTIGHT].into_iter().find(|(other, _)| *other == name).map(|(_, build)| build)
}

/// Builds a tree whose decisions, and whose order of hits, are those of exact arithmetic.
///
/// # Errors
/// Never: the method takes every mesh.
///
/// # Panics
/// When there are more triangles or blocks than a tree can number, see [`Bvh::build`].
pub fn exact(
    triangles: &[Triangle],
    builder: Builder,
    leaves: Leaves,
) -> Result<Box<dyn Tree>, UnsuitableMesh> {
    build::<ExactInTrees>(triangles, builder, leaves)
}

/// Builds a tree with Möller and Trumbore's test.
///
/// # Errors
/// Never: the method takes every mesh.
///
/// # Panics
/// As [`exact`].
pub fn fast(
    triangles: &[Triangle],
    builder: Builder,
    leaves: Leaves,
) -> Result<Box<dyn Tree>, UnsuitableMesh> {
    build::<MollerTrumbore>(triangles, builder, leaves)
}

/// Builds a tree with the watertight test of Woop, Benthin and Wald.
///
/// # Errors
/// Never: the method takes every mesh.
///
/// # Panics
/// As [`exact`].
pub fn watertight(
    triangles: &[Triangle],
    builder: Builder,
    leaves: Leaves,
) -> Result<Box<dyn Tree>, UnsuitableMesh> {
    build::<Watertight>(triangles, builder, leaves)
}

/// Builds a tree of any method: compiled where it is called.
pub(crate) fn build<M: Method>(
    triangles: &[Triangle],
    builder: Builder,
    leaves: Leaves,
) -> Result<Box<dyn Tree>, UnsuitableMesh> {
    Ok(Box::new(Bvh::<M>::build_with(triangles, builder, leaves)?))
}
