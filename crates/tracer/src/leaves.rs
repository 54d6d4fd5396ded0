//! The leaves of a tree, as the way through its nodes sees them: part of one loop where single rays are to be
//! as fast as can be, and else behind a call, so that the way is compiled once for all methods.

use std::hint::select_unpredictable;
use std::ops::Range;

use trisect_core::{Culling, Lanes, Method, Token as _};

use crate::abreast;
use crate::bvh::{Bvh, Child, Node, child};
use crate::exactly::{self, Given, settle_at};
use crate::leaf::{end, test_leaf};
use crate::rows::{RAYS, Rows};

/// Which faces are seen: both, as a type, where nothing in a leaf is to ask, and otherwise a value.
pub(crate) trait Faces: Copy {
    /// The faces that are not seen.
    fn culling(self) -> Culling;
}

/// Both.
#[derive(Clone, Copy)]
pub(crate) struct Both;

impl Faces for Both {
    #[inline(always)]
    fn culling(self) -> Culling {
        Culling::None
    }
}

impl Faces for Culling {
    #[inline(always)]
    fn culling(self) -> Culling {
        self
    }
}

/// A tree as single rays go through it on lanes of choice.
pub(crate) trait ForSingleRays<L: Lanes, const ANY: bool, const ROBUST: bool> {
    /// Whether the numbers of a ray are [kept together](Rows::line).
    const LINES: bool;

    /// Its nodes.
    fn nodes(&self) -> &[Node];

    /// Nodes on the longest way down.
    fn depth(&self) -> usize;

    /// Tests a leaf's triangles for a ray, whose interval ends at its best hit from then on; whether it has
    /// hit anything so far.
    fn test(&self, token: L::Token, rows: &mut Rows, place: usize, blocks: Range<usize>) -> bool;

    /// Computes what is left to compute of rays that have arrived.
    fn arrive(&self, rows: &mut Rows);
}

/// Both faces are seen, and all is in one loop. By the tree itself, not by [`LeavesOf`]: what is behind one
/// pointer is at hand in a register, which is worth a tenth.
impl<M, L, const ANY: bool, const ROBUST: bool> ForSingleRays<L, ANY, ROBUST> for Bvh<M>
where
    M: Method,
    L: Lanes<Elem = f32>,
{
    const LINES: bool = M::INFO.claims.exact;

    #[inline(always)]
    fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    #[inline(always)]
    fn depth(&self) -> usize {
        self.depth
    }

    #[inline(always)]
    fn test(&self, token: L::Token, rows: &mut Rows, place: usize, blocks: Range<usize>) -> bool {
        let ray = if const { M::INFO.claims.exact } { rows.line(place) } else { rows.ray(place) };
        let given = Given { bvh: self, ray, culling: Culling::None };
        let best = &mut rows.best[place % RAYS];
        let left = test_leaf::<M, L, ANY>(token, blocks, given, best);
        settle_at(self, Culling::None, rows, place, &left);
        let best = &rows.best[place % RAYS];
        let is_hit = best.is_hit();
        if is_hit {
            let tmax = end::<ANY, ROBUST>(best, ray.tmax);
            rows.end(place, tmax);
        }
        is_hit
    }

    #[inline(always)]
    fn arrive(&self, rows: &mut Rows) {
        if const { M::INFO.claims.exact && !ANY } {
            exactly::arrive(self, rows);
        }
    }
}

/// The leaves of a tree, whatever their method.
pub(crate) trait Leaves {
    /// Has a leaf fetched that will be visited.
    fn prefetch(&self, first: usize);

    /// Tests its triangles for those rays; whether any of them has hit anything so far.
    fn test(&self, rows: &mut Rows, rays: u64, blocks: Range<usize>) -> bool;

    /// Computes what is left to compute of rays that have arrived.
    fn arrive(&self, rows: &mut Rows);
}

/// The leaves of a tree, tested on lanes of choice.
pub(crate) struct LeavesOf<'a, M: Method, L: Lanes, F, const ANY: bool, const ROBUST: bool> {
    bvh: &'a Bvh<M>,
    token: L::Token,
    faces: F,
}

impl<'a, M: Method, L: Lanes, F, const ANY: bool, const ROBUST: bool>
    LeavesOf<'a, M, L, F, ANY, ROBUST>
{
    /// Those of a tree.
    pub(crate) fn new(bvh: &'a Bvh<M>, token: L::Token, faces: F) -> Self {
        Self { bvh, token, faces }
    }
}

impl<M, L, F, const ANY: bool, const ROBUST: bool> Leaves for LeavesOf<'_, M, L, F, ANY, ROBUST>
where
    M: Method,
    L: Lanes<Elem = f32>,
    F: Faces,
{
    fn prefetch(&self, first: usize) {
        if let Some(block) = self.bvh.blocks.get(first) {
            block.prefetch();
        }
    }

    fn test(&self, rows: &mut Rows, mut rays: u64, blocks: Range<usize>) -> bool {
        let Self { bvh, token, faces } = *self;
        let culling = faces.culling();
        token.run(
            #[inline(always)]
            || {
                let mut any = false;
                // Not where faces are culled: few rays are traced so.
                if const { abreast::suits::<M, ANY>() } && culling == Culling::None {
                    let (some, rest) =
                        abreast::test_leaf::<M, L, ANY, ROBUST>(token, bvh, &blocks, rows, rays);
                    (any, rays) = (some, rest);
                }
                while rays != 0 {
                    let place = rays.trailing_zeros() as usize % RAYS;
                    rays &= rays - 1;
                    let (ray, best) = (rows.ray(place), &mut rows.best[place]);
                    let blocks = blocks.clone();
                    let given = Given { bvh, ray, culling };
                    let left = test_leaf::<M, L, ANY>(token, blocks, given, best);
                    settle_at(bvh, culling, rows, place, &left);
                    let best = &rows.best[place];
                    let is_hit = best.is_hit();
                    any |= is_hit;
                    let tmax = end::<ANY, ROBUST>(best, ray.tmax);
                    rows.shorten(place, select_unpredictable(is_hit, tmax, ray.tmax));
                }
                any
            },
        )
    }

    fn arrive(&self, rows: &mut Rows) {
        let Self { bvh, token, .. } = *self;
        if const { M::INFO.claims.exact && !ANY } {
            token.run(
                #[inline(always)]
                || exactly::arrive(bvh, rows),
            );
        }
    }
}

/// The nodes of a tree, and its leaves behind calls.
#[derive(Clone, Copy)]
pub(crate) struct Whole<'a> {
    pub(crate) nodes: &'a [Node],
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    pub(crate) leaves: &'a dyn Leaves,
}

impl Whole<'_> {
    /// Has a child fetched that will be visited.
    #[inline(always)]
    pub(crate) fn prefetch(self, number: u32) {
        match child(number) {
            Child::Node(at) => self.nodes[at].prefetch(),
            Child::Leaf(first, _) => self.leaves.prefetch(first),
        }
    }
}

/// A single ray calls what many rays do.
impl<L: Lanes, const ANY: bool, const ROBUST: bool> ForSingleRays<L, ANY, ROBUST> for Whole<'_> {
    const LINES: bool = false;

    #[inline(always)]
    fn nodes(&self) -> &[Node] {
        self.nodes
    }

    #[inline(always)]
    fn depth(&self) -> usize {
        self.depth
    }

    #[inline(always)]
    fn test(&self, _: L::Token, rows: &mut Rows, place: usize, blocks: Range<usize>) -> bool {
        self.leaves.test(rows, 1 << (place % RAYS), blocks)
    }

    #[inline(always)]
    fn arrive(&self, rows: &mut Rows) {
        self.leaves.arrive(rows);
    }
}
