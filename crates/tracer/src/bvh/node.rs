//! A node as it is traversed: the boxes of eight children, and what they are.

use prefetch_index::prefetch_index;
use trisect_core::{Lanes, Vec3};

use super::bounds::{Bounds, LARGEST};
use crate::vectors::{WIDTH, load};

/// The reference of a leaf: the uppermost bit, then how many blocks, then the first of them.
const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 28;
const FIRST_MASK: u32 = (1 << COUNT_SHIFT) - 1;

/// Eight boxes, coordinate by coordinate, and what is in them. An empty place has a box at infinity, which
/// hardly any ray reaches, and a leaf without blocks.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// Along each axis, from and to.
    pub(crate) bounds: [[[f32; WIDTH]; 2]; 3],
    /// A reference to each child, see [`child`].
    pub(crate) children: [u32; WIDTH],
}

impl Node {
    pub(crate) const EMPTY: Self =
        Self { bounds: [[[f32::INFINITY; WIDTH]; 2]; 3], children: [LEAF; WIDTH] };

    /// The planes of as many boxes as there are lanes, from box `lane` on: along each axis the side where a box
    /// begins if `ends` is 0, and the side where it ends if `ends` is 1.
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

    /// Sets a child and its box.
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

    /// Prefetches the node.
    #[inline(always)]
    pub(crate) fn prefetch(&self) {
        // A cache line holds two rows.
        prefetch_index(self.bounds[0][0].as_slice(), 0);
        prefetch_index(self.bounds[1][0].as_slice(), 0);
        prefetch_index(self.bounds[2][0].as_slice(), 0);
        prefetch_index(self.children.as_slice(), 0);
    }

    /// The box around all children. A ray that meets one of them meets this one too, since rounding keeps the
    /// order of distances to planes. Out of line, since it is called once a batch.
    #[inline(never)]
    pub(crate) fn whole(&self) -> Bounds {
        let mut whole = Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };
        for lane in 0..WIDTH {
            let Bounds { min, max } = self.bounds_of(lane);
            for axis in 0..3 {
                // An empty place has its box at infinity.
                if min[axis] < f32::INFINITY {
                    whole.min[axis] = whole.min[axis].min(min[axis]);
                    whole.max[axis] = whole.max[axis].max(max[axis]);
                }
            }
        }
        whole
    }

    /// The children that there are, with their boxes.
    pub(crate) fn boxes(&self) -> impl Iterator<Item = (Bounds, u32)> + '_ {
        let children = self.children.iter().enumerate();
        let boxes = children.map(|(lane, &reference)| (self.bounds_of(lane), reference));
        // An empty place has its box at infinity, or an empty one.
        boxes.filter(|(Bounds { min, max }, _)| min[0] <= max[0] && min[0] < f32::INFINITY)
    }

    /// The box of a child.
    pub(crate) fn bounds_of(&self, lane: usize) -> Bounds {
        let corner = |row: usize| [0, 1, 2].map(|axis| self.bounds[axis][row][lane]);
        Bounds { min: corner(0), max: corner(1) }
    }
}

/// Moves a side that begins a box outwards until its difference to an origin within [`LARGEST`] cannot overflow.
fn outwards(begin: f32) -> f32 {
    if begin < -LARGEST {
        f32::NEG_INFINITY
    } else if begin > LARGEST && begin.is_finite() {
        LARGEST
    } else {
        begin
    }
}

/// The reference of a leaf of those blocks.
///
/// # Panics
/// When there are more blocks than a reference can count.
pub(crate) fn leaf(blocks: std::ops::Range<usize>) -> u32 {
    let first = u32::try_from(blocks.start).unwrap_or(u32::MAX);
    assert!(first <= FIRST_MASK, "more blocks than the tree can count");
    let count = u32::try_from(blocks.len()).expect("a leaf has few blocks");
    LEAF | count << COUNT_SHIFT | first
}

/// What a child is.
pub(crate) enum Child {
    /// The node of that index.
    Node(usize),
    /// The index of its first block, and how many there are.
    Leaf(usize, usize),
}

/// What a reference stands for.
#[inline(always)]
pub(crate) fn child(reference: u32) -> Child {
    if reference & LEAF == 0 {
        return Child::Node(reference as usize);
    }
    let count = (reference & !LEAF) >> COUNT_SHIFT;
    Child::Leaf((reference & FIRST_MASK) as usize, count as usize)
}
