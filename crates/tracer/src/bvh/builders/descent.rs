//! From the root down: the cheapest split by the surface area heuristic, of objects or of space.

use std::ops::Range;

use super::binary::{self, Built, Room, Tree, extent, places};
use super::bins::{Bins, Grid, Split};
use super::corners::{Corners, Reference};
use super::settings::Leaves;
use super::spatial::{self, Cuts};
use super::sweep::{self, FEW};
use crate::parallel::both;
use crate::vectors::WIDTH;

/// Beyond this depth references are halved, whatever it costs: depth stays bounded.
const DEEP: usize = 48;

/// Space is split where the boxes on either side have more than this in common, as a share of the
/// root's area.
const OVERLAP: f32 = 1e-5;

/// And more than this as a share of the node's own area: of less nothing is gained that would be worth
/// the time.
const SHARE: f32 = 0.1;

/// What is the same for all nodes.
struct Descent<'a> {
    /// How parts are cut, where space may be split.
    cuts: Option<&'a Cuts<'a>>,
    /// Half the area of the box that two sides may have in common before space is split.
    overlap: f32,
}

/// Where a subtree is built: references are moved from one room to the other at each split.
struct Space<'a> {
    /// Has the references in some of its places.
    from: &'a mut [Reference],
    to: &'a mut [Reference],
    room: Room<'a>,
}

/// The tree over the first `count` of `references`; the other places are room for parts of triangles,
/// where they may be cut.
pub(crate) fn build(
    references: &mut [Reference],
    count: usize,
    cuts: Option<&Cuts<'_>>,
    leaves: Leaves,
) -> Tree {
    let room = references.len();
    let mut tree = Tree { nodes: vec![[0; 8]; places(room)], ids: vec![0; room] };
    if count > 0 {
        let mut other = vec![[0.0; 8]; if count > FEW { room } else { 0 }];
        let mut descent = Descent { cuts, overlap: 0.0 };
        if cuts.is_some() {
            descent.overlap = OVERLAP * extent(&references[..count]).0.half_area();
        }
        let room = Room { nodes: &mut tree.nodes, ids: &mut tree.ids, leaves };
        descent.subtree(Space { from: references, to: &mut other, room }, 0..count, 0);
    }
    tree
}

impl Descent<'_> {
    fn subtree(&self, space: Space<'_>, places: Range<usize>, depth: usize) -> Built {
        let count = places.len();
        if count <= FEW {
            return sweep::build(&space.from[places], space.room);
        }
        let Space { from, to, room } = space;
        let Sides { left, right, room_left } = self.split(&from[places], to, depth);
        let leaves = room.leaves;
        let (root, left_room, right_room) = room.split(room_left);
        let (left_to, right_to) = from.split_at_mut(room_left);
        let (left_from, right_from) = to.split_at_mut(room_left);
        let left_space = Space { from: left_from, to: left_to, room: left_room };
        let right_space = Space { from: right_from, to: right_to, room: right_room };
        let (left, right) = both(
            count,
            || self.subtree(left_space, left, depth + 1),
            || self.subtree(right_space, right, depth + 1),
        );
        binary::join(leaves, root, room_left, &left, &right)
    }

    /// Puts the references of either side in places of `to`: at least one on each side.
    #[inline(never)]
    fn split(&self, references: &[Reference], to: &mut [Reference], depth: usize) -> Sides {
        let count = references.len();
        if depth >= DEEP {
            return halves(references, to);
        }
        let (bounds, middles) = extent(references);
        let grid = Grid::new(&middles);
        let bins = Bins::new(references, &grid);
        let objects = bins.cheapest();
        if let (Some(cuts), Some(objects)) = (self.cuts, &objects)
            && to.len() > count
            && objects.overlap() > self.overlap.max(SHARE * bounds.half_area())
            && let Some(space) =
                spatial::cheapest(references, &bounds, to.len(), objects.axis, cuts)
            && space.0.cost < objects.cost
        {
            let (left, right) = spatial::partition(references, to, space, cuts);
            if left > 0 && right > 0 {
                return Sides::at_ends(left, right, to.len());
            }
        }
        // All middles are the same, as far as bins can tell.
        let Some(split) = objects else { return halves(references, to) };
        partition(references, to, &grid, &split)
    }
}

/// Where the references of either side are, as places of their own rooms.
struct Sides {
    left: Range<usize>,
    right: Range<usize>,
    room_left: usize,
}

impl Sides {
    /// How much room the left side has: to spare in proportion to its references.
    fn room_left(left: usize, right: usize, room: usize) -> usize {
        let spare = (room - left - right) as u64;
        let share = spare * left as u64 / (left + right) as u64;
        left + usize::try_from(share).expect("below the room")
    }

    /// Each side at the beginning of its room.
    fn new(left: usize, right: usize, room: usize) -> Self {
        let room_left = Self::room_left(left, right, room);
        Self { left: 0..left, right: 0..right, room_left }
    }

    /// The left side at the beginning, the right side at the end of the whole room.
    fn at_ends(left: usize, right: usize, room: usize) -> Self {
        let room_left = Self::room_left(left, right, room);
        let room_right = room - room_left;
        Self { left: 0..left, right: room_right - right..room_right, room_left }
    }
}

/// In whole blocks.
fn halves(references: &[Reference], to: &mut [Reference]) -> Sides {
    let left = (references.len() / 2).next_multiple_of(WIDTH);
    let sides = Sides::new(left, references.len() - left, to.len());
    to[..left].copy_from_slice(&references[..left]);
    to[sides.room_left..][sides.right.clone()].copy_from_slice(&references[left..]);
    sides
}

/// Without branches, which could not be foreseen.
fn partition(references: &[Reference], to: &mut [Reference], grid: &Grid, split: &Split) -> Sides {
    let sides = Sides::new(split.left.count, split.right.count, to.len());
    let (mut left, mut right) = (0, sides.room_left);
    for reference in references {
        let is_left = grid.bins(&Corners(*reference))[split.axis] < split.border;
        to[if is_left { left } else { right }] = *reference;
        left += usize::from(is_left);
        right += usize::from(!is_left);
    }
    sides
}
