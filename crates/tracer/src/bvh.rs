//! The wide tree as it is traversed: nodes of eight children, leaves of blocks of eight triangles.

use prefetch_index::prefetch_index;
use trisect_core::{Lanes, Method, Of, Record as _, Vec3};

use crate::bounds::Bounds;
use crate::build::Builder;
use crate::rows::load;
use crate::slabs::LARGEST;

/// Children of a node, and triangles of a block.
pub(crate) const WIDTH: usize = 8;

/// A leaf: the uppermost bit, then how many blocks, then the first of them.
const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 28;
const FIRST_MASK: u32 = (1 << COUNT_SHIFT) - 1;

/// Eight boxes, coordinate by coordinate, and what is in them. A place without a child has a box at
/// infinity, which hardly any ray comes to, and a leaf without blocks.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// Along each axis, from and to.
    pub(crate) bounds: [[[f32; WIDTH]; 2]; 3],
    /// A node's place, or a leaf.
    pub(crate) children: [u32; WIDTH],
}

impl Node {
    pub(crate) const EMPTY: Self =
        Self { bounds: [[[f32::INFINITY; WIDTH]; 2]; 3], children: [LEAF; WIDTH] };

    /// The coordinates, along each axis, of planes of as many boxes as there are lanes, from one on: those
    /// where the boxes begin where `ends` is 0, and where they end where it is 1.
    #[inline(always)]
    pub(crate) fn planes<L: Lanes<Elem = f32>>(
        &self,
        token: L::Token,
        ends: [usize; 3],
        lane: usize,
    ) -> Vec3<L> {
        let [x, y, z] = &self.bounds;
        load(token, [&x[ends[0] & 1], &y[ends[1] & 1], &z[ends[2] & 1]], lane)
    }

    pub(crate) fn set(&mut self, lane: usize, bounds: &Bounds, child: u32) {
        for axis in 0..3 {
            self.bounds[axis][0][lane] = outwards(bounds.min[axis]);
            self.bounds[axis][1][lane] = -outwards(-bounds.max[axis]);
        }
        self.children[lane] = child;
    }

    /// Moves the sides of all boxes outwards.
    pub(crate) fn widen(&mut self, margin: f32) {
        for lane in 0..WIDTH {
            let Bounds { min, max } = self.bounds_of(lane);
            let bounds = Bounds { min: min.map(|x| x - margin), max: max.map(|x| x + margin) };
            self.set(lane, &bounds, self.children[lane]);
        }
    }

    /// Has it fetched.
    #[inline(always)]
    pub(crate) fn prefetch(&self) {
        // A cache line holds two rows.
        prefetch_index(self.bounds[0][0].as_slice(), 0);
        prefetch_index(self.bounds[1][0].as_slice(), 0);
        prefetch_index(self.bounds[2][0].as_slice(), 0);
        prefetch_index(self.children.as_slice(), 0);
    }

    /// The box around all children. Whichever ray meets one of them meets this: rounding keeps the order
    /// of distances to planes. Out of line, as it is asked for once.
    #[inline(never)]
    pub(crate) fn whole(&self) -> Bounds {
        let mut whole = Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };
        for lane in 0..WIDTH {
            let Bounds { min, max } = self.bounds_of(lane);
            for axis in 0..3 {
                // Not a place without a child, whose box is at infinity.
                if min[axis] < f32::INFINITY {
                    whole.min[axis] = whole.min[axis].min(min[axis]);
                    whole.max[axis] = whole.max[axis].max(max[axis]);
                }
            }
        }
        whole
    }

    /// The box of a child.
    pub(crate) fn bounds_of(&self, lane: usize) -> Bounds {
        let corner = |row: usize| [0, 1, 2].map(|axis| self.bounds[axis][row][lane]);
        Bounds { min: corner(0), max: corner(1) }
    }
}

/// Where a box may begin that begins there: from an origin within [`LARGEST`] no difference overflows.
fn outwards(begin: f32) -> f32 {
    if begin < -LARGEST {
        f32::NEG_INFINITY
    } else if begin > LARGEST && begin.is_finite() {
        LARGEST
    } else {
        begin
    }
}

/// Eight triangles of one kind, prepared, number by number.
#[repr(align(64))]
pub(crate) struct Block<M: Method> {
    pub(crate) prepared: Of<M::Prepared, [f32; WIDTH]>,
    /// Their numbers.
    pub(crate) triangles: [u32; WIDTH],
}

impl<M: Method> Clone for Block<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Method> Copy for Block<M> {}

impl<M: Method> Block<M> {
    /// One of them.
    #[inline(always)]
    pub(crate) fn prepared_of(&self, lane: usize) -> Of<M::Prepared, f32> {
        M::Prepared::map(
            &self.prepared,
            #[inline(always)]
            |row: &[f32; WIDTH]| row[lane],
        )
    }
}

/// The number of a leaf.
///
/// # Panics
/// When there are more blocks than a tree can number.
pub(crate) fn leaf(blocks: std::ops::Range<usize>) -> u32 {
    let first = u32::try_from(blocks.start).unwrap_or(u32::MAX);
    assert!(first <= FIRST_MASK, "more blocks than the tree can number");
    let count = u32::try_from(blocks.len()).expect("a leaf has few blocks");
    LEAF | count << COUNT_SHIFT | first
}

/// What a child is.
pub(crate) enum Child {
    Node(usize),
    /// The first block, and how many.
    Leaf(usize, usize),
}

/// What a child's number stands for.
#[inline(always)]
pub(crate) fn child(number: u32) -> Child {
    if number & LEAF == 0 {
        return Child::Node(number as usize);
    }
    let count = (number & !LEAF) >> COUNT_SHIFT;
    Child::Leaf((number & FIRST_MASK) as usize, count as usize)
}

/// A mesh, prepared for a method, in a tree.
pub struct Bvh<M: Method> {
    pub(crate) nodes: Vec<Node>,
    pub(crate) blocks: Vec<Block<M>>,
    /// The kind of triangles in each block; empty where the method has one.
    pub(crate) groups: Vec<u8>,
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    pub(crate) bounds: Bounds,
    pub(crate) origin: Origin,
}

/// What the tree was built from.
pub(crate) struct Origin {
    pub(crate) builder: Builder,
    /// How many triangles there were.
    pub(crate) triangles: usize,
    /// The numbers of those that nothing could hit.
    pub(crate) left_out: Vec<u32>,
    /// Triangles in leaves, in each one of them once.
    pub(crate) references: usize,
}

/// Facts about a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// What built it.
    pub builder: Builder,
    /// Wide nodes.
    pub nodes: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
    /// Triangles in leaves; those whose space was split count in each leaf that they are in.
    pub references: usize,
    /// Nodes on the longest way down.
    pub depth: usize,
    /// Bytes of nodes and blocks.
    pub bytes: usize,
    /// Expected cost of a ray that meets the root, in tests of a node or a block (the surface area
    /// heuristic).
    pub cost: f64,
}

impl<M: Method> Block<M> {
    /// Has it fetched.
    #[inline(always)]
    pub(crate) fn prefetch(&self) {
        M::Prepared::map(
            &self.prepared,
            #[inline(always)]
            |row: &[f32; WIDTH]| prefetch_index(row, 0),
        );
        prefetch_index(self.triangles.as_slice(), 0);
    }
}

/// The expected cost of a ray that meets the root.
fn cost(nodes: &[Node], bounds: &Bounds) -> f64 {
    let whole = f64::from(bounds.half_area());
    let mut cost = 1.0;
    for node in nodes {
        for lane in 0..WIDTH {
            let share = f64::from(node.bounds_of(lane).half_area()) / whole;
            if share.is_finite() {
                cost += share
                    * match child(node.children[lane]) {
                        Child::Node(_) => 1.0,
                        Child::Leaf(_, count) => count as f64,
                    };
            }
        }
    }
    cost
}

impl<M: Method> Bvh<M> {
    /// The triangle at a place among all blocks.
    #[inline(always)]
    pub(crate) fn prepared(&self, place: u32) -> Of<M::Prepared, f32> {
        self.blocks[place as usize / WIDTH].prepared_of(place as usize % WIDTH)
    }

    /// Its number.
    #[inline(always)]
    pub(crate) fn triangle(&self, place: u32) -> u32 {
        self.blocks[place as usize / WIDTH].triangles[place as usize % WIDTH]
    }

    /// Facts about the tree.
    pub(crate) fn statistics_of(&self) -> Statistics {
        Statistics {
            builder: self.origin.builder,
            nodes: self.nodes.len(),
            blocks: self.blocks.len(),
            references: self.origin.references,
            depth: self.depth,
            bytes: size_of_val(&self.nodes[..])
                + size_of_val(&self.blocks[..])
                + size_of_val(&self.groups[..]),
            cost: cost(&self.nodes, &self.bounds),
        }
    }
}
