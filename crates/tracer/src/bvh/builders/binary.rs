//! The binary tree: nodes in depth-first order, in room that is known before they are.
//!
//! A subtree over n references, or with room for n, has 2n − 1 places for nodes from its root on: the
//! left child is next, the right one follows the places of the left. So both sides of a split can be
//! built side by side in place, whatever the number of threads.

use super::collapse::{Choices, Costs};
use super::corners::{Corners, Reference};
use super::settings::Leaves;

/// A node as it is stored: numbers alone, so that room for many is had from the system as zeros,
/// untouched until used.
pub(crate) type Stored = [u32; 8];

/// A node of the binary tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binary {
    pub(crate) bounds: Corners,
    /// For how many references there is room on the left; 0 where there are no children.
    pub(crate) left: usize,
    pub(crate) choices: Choices,
}

impl Binary {
    #[inline]
    pub(crate) fn store(&self) -> Stored {
        let mut stored = [0; 8];
        for (to, from) in stored.iter_mut().zip(&self.bounds.0) {
            *to = from.to_bits();
        }
        stored[3] = u32::try_from(self.left).expect("references are counted in u32");
        stored[7] = self.choices.0;
        stored
    }

    #[inline]
    pub(crate) fn load(stored: &Stored) -> Self {
        let mut bounds = Corners::EMPTY;
        for (to, &from) in bounds.0.iter_mut().zip(stored) {
            *to = f32::from_bits(from);
        }
        Self { bounds, left: stored[3] as usize, choices: Choices(stored[7]) }
    }
}

/// How many nodes there is room for over so many references.
pub(crate) fn places(references: usize) -> usize {
    (2 * references).saturating_sub(1)
}

/// The binary tree over a mesh.
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Stored>,
    /// Triangles in the order of the leaves, as many as there is room for references.
    pub(crate) ids: Vec<u32>,
}

/// What there is of a subtree, as far as its parent needs it.
pub(crate) struct Built {
    pub(crate) bounds: Corners,
    pub(crate) costs: Costs,
    pub(crate) count: usize,
}

/// Where a subtree is built.
pub(crate) struct Room<'a> {
    pub(crate) nodes: &'a mut [Stored],
    pub(crate) ids: &'a mut [u32],
    /// What may become of it.
    pub(crate) leaves: Leaves,
}

impl<'a> Room<'a> {
    /// The root, and the room of the children, the left one having so much.
    pub(crate) fn split(self, left: usize) -> (&'a mut Stored, Self, Room<'a>) {
        let (root, below) = self.nodes.split_first_mut().expect("a subtree has a root");
        let (left_nodes, right_nodes) = below.split_at_mut(places(left));
        let (left_ids, right_ids) = self.ids.split_at_mut(left);
        let leaves = self.leaves;
        let left = Self { nodes: left_nodes, ids: left_ids, leaves };
        (root, left, Room { nodes: right_nodes, ids: right_ids, leaves })
    }
}

/// A node over two children, stored at `root`.
pub(crate) fn join(
    leaves: Leaves,
    root: &mut Stored,
    room_left: usize,
    left: &Built,
    right: &Built,
) -> Built {
    let bounds = left.bounds.with(&right.bounds);
    let of_left = (&left.costs, left.count);
    let of_right = (&right.costs, right.count);
    let (costs, choices) = super::collapse::inner(leaves, &bounds, of_left, of_right);
    *root = Binary { bounds, left: room_left, choices }.store();
    Built { bounds, costs, count: left.count + right.count }
}

/// A node without children, stored at `root`.
pub(crate) fn leaf(root: &mut Stored, bounds: Corners, count: usize) -> Built {
    let (costs, choices) = super::collapse::leaf(&bounds, count);
    *root = Binary { bounds, left: 0, choices }.store();
    Built { bounds, costs, count }
}

/// The bounds of references, and of twice their middles.
pub(crate) fn extent(references: &[Reference]) -> (Corners, Corners) {
    let (mut bounds, mut middles) = (Corners::EMPTY, Corners::EMPTY);
    for reference in references {
        let corners = Corners(*reference);
        bounds.add(&corners);
        let [x, y, z, _] = corners.twice_middle();
        middles.add(&Corners::of_point([x, y, z]));
    }
    (bounds, middles)
}
