//! One ray down the tree for inspection: how many tests it takes, and which triangles it may hit.
//!
//! In plain arithmetic, and apart from the loops that trace, so that these count nothing.

use std::cell::Cell;
use std::ops::Range;

use trisect_core::Ray;
use trisect_method::Culling;

use super::walk::Walk;
use crate::hit::TriangleHit;
use crate::hits::{Crossings, Source, Tests, Verdict, as_tested};
use crate::lanes::PlainLanes;
use crate::precision::{Entry, Precision};
use crate::traced::TracedIn;
use crate::vectors::WIDTH;

/// A ray's closest hit, and what it took to find it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counted<P = f32> {
    /// The hit.
    pub found: Option<TriangleHit<P>>,
    /// Nodes visited, whose eight boxes are tested together.
    pub nodes: usize,
    /// Triangles tested.
    pub triangles: usize,
}

impl<P> Default for Counted<P> {
    /// Nothing found, and nothing tested.
    fn default() -> Self {
        Self { found: None, nodes: 0, triangles: 0 }
    }
}

/// The closest hit of a ray, and what it takes to find it.
pub(crate) fn inspect<P: Precision>(traced: &dyn TracedIn<P>, ray: &Ray<P>) -> Counted<P> {
    let tests = Cell::new(Tests::default());
    let source = Source {
        traced,
        lanes: Some(PlainLanes::Scalar),
        culling: Culling::None,
        crossings: Crossings::Every,
        counted: Some(&tests),
    };
    let found = source.filtered(ray, &mut |_| Verdict::Accept);
    let Tests { nodes, triangles } = tests.get();
    Counted { found, nodes, triangles }
}

/// Visits the triangles that a ray may hit. `visit` says where its interval ends from then on.
pub(crate) fn candidates<P: Precision>(
    traced: &dyn TracedIn<P>,
    ray: &Ray<P>,
    visit: &mut dyn FnMut(u32) -> P,
) {
    let (tree, leaves) = (traced.tree(), traced.leaves());
    let ray = &as_tested(ray);
    let mut tmax = ray.tmax;
    let mut leaf = |blocks: Range<usize>| {
        for block in blocks {
            for &triangle in distinct(leaves.triangles(block)) {
                tmax = visit(triangle);
            }
        }
        tmax
    };
    match P::enter(tree.frame.as_ref(), ray) {
        Entry::Missed => {}
        Entry::Boxes(ray, span) => {
            let leaf = &mut |blocks| P::end(span, leaf(blocks));
            PlainLanes::Scalar.run(Walk { tree, ray: &ray, leaf });
        }
        Entry::Everywhere => {
            leaf(0..leaves.count());
        }
    }
}

/// The triangles of a block: where it is not full, the last one is repeated.
pub(crate) fn distinct(triangles: &[u32; WIDTH]) -> &[u32] {
    let last = triangles[WIDTH - 1];
    let count = triangles.iter().position(|&triangle| triangle == last).map_or(WIDTH, |at| at + 1);
    &triangles[..count]
}
