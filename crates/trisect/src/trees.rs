//! The trees that are compiled in this crate, once: what the methods of a [`Scene`](crate::Scene) are made of. A
//! program that uses them compiles none.

use trisect_exact::ExactInTrees;
use trisect_method::{Method, UnsuitableMesh};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_tracer::{Builder, Bvh, Leaves, Tree};
use trisect_watertight::Watertight;

use crate::{Precision, Triangle};

/// Builds a tree over triangles, or says why the method does not take them.
///
/// # Panics
/// When there are more triangles or blocks than a tree can number, see [`Bvh::build`].
pub type BuildTree<P = f32> = fn(&[Triangle<P>], Builder, Leaves) -> Built<P>;

/// A tree, or why the method does not take the triangles.
pub type Built<P = f32> = Result<Box<dyn Tree<P>>, UnsuitableMesh>;

/// The names of the methods whose trees are here, as the catalogue of methods has them: that which is never wrong,
/// the fastest, and that which lets no ray through between triangles.
pub const NAMES: [&str; 3] =
    [ExactInTrees::INFO.name, MollerTrumbore::INFO.name, <Watertight>::INFO.name];

/// The function that builds the tree of a method of [`NAMES`].
pub fn find<P: Precision>(name: &str) -> Option<BuildTree<P>> {
    let builds = [P::exact, P::fast, P::watertight];
    NAMES.into_iter().zip(builds).find(|(other, _)| *other == name).map(|(_, build)| build)
}

/// Builds a tree of any method: compiled where it is called.
pub(crate) fn build<M: Method, P: trisect_tracer::Precision>(
    triangles: &[Triangle<P>],
    builder: Builder,
    leaves: Leaves,
) -> Built<P> {
    Ok(Box::new(Bvh::<M, P>::build_with(triangles, builder, leaves)?))
}
