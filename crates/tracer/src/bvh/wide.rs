//! The wide tree, without what a method stores per triangle.

use trisect_core::Triangle;

use super::bounds::Bounds;
use super::builders::settings::Builder;
use super::frame::Frame;
use super::node::{Child, Node, child};
use crate::vectors::WIDTH;

/// Nodes, and what is known of them.
pub(crate) struct WideTree {
    pub(crate) nodes: Vec<Node>,
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    pub(crate) bounds: Bounds,
    /// The largest coordinate of a box, in magnitude.
    pub(crate) reach: f32,
    /// Whether tests of boxes must allow for their own rounding.
    pub(crate) is_robust: bool,
    /// Where boxes are in relation to triangles and rays; nowhere else where there is none.
    pub(crate) frame: Option<Frame>,
    pub(crate) origin: Origin,
}

/// What a tree was built from.
pub(crate) struct Origin {
    pub(crate) builder: Builder,
    /// How many triangles there were.
    pub(crate) triangles: usize,
    /// The ids of those that nothing can hit.
    pub(crate) left_out: Vec<u32>,
    /// Triangles in leaves; one that is in several leaves counts in each.
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
    /// Triangles in leaves; one whose space was split counts in each leaf that it is in.
    pub references: usize,
    /// Nodes on the longest way down.
    pub depth: usize,
    /// Bytes of nodes and blocks.
    pub bytes: usize,
    /// Expected cost of a ray that meets the root, in tests of a node or a block (the surface area
    /// heuristic).
    pub cost: f64,
}

impl WideTree {
    /// Facts about the tree, given how many blocks there are, and their bytes.
    pub(crate) fn statistics(&self, blocks: usize, bytes: usize) -> Statistics {
        Statistics {
            builder: self.origin.builder,
            nodes: self.nodes.len(),
            blocks,
            references: self.origin.references,
            depth: self.depth,
            bytes: size_of_val(&self.nodes[..]) + bytes,
            cost: self.cost(),
        }
    }

    /// The boxes two levels below the root, or one where that is a leaf.
    pub(crate) fn boxes(&self) -> impl Iterator<Item = Bounds> + '_ {
        self.nodes[0].boxes().flat_map(|(bounds, reference)| {
            let below = match child(reference) {
                Child::Node(at) => Some(self.nodes[at].boxes().map(|(bounds, _)| bounds)),
                Child::Leaf(..) => None,
            };
            let own = below.is_none().then_some(bounds);
            below.into_iter().flatten().chain(own)
        })
    }

    /// The expected cost of a ray that meets the root.
    pub(crate) fn cost(&self) -> f64 {
        let whole = f64::from(self.bounds.half_area());
        let mut cost = 1.0;
        for node in &self.nodes {
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

    /// Moves the sides of all boxes outwards by eight units of roundoff of the tree's largest coordinate, unless
    /// tests of boxes are robust. They compute `v·r − o·r` for a side at `v`, and `r` is as large as 10¹⁸ along
    /// an axis that the ray runs across: there the rounding of `o·r` alone would decide about a ray that lies
    /// in the side. A point of the side is off by `u·|o| + 2u·|v − o|` at most, so no box loses a ray whose
    /// origin has no larger coordinates than the tree. In a [frame](super::frame) that says how much larger they
    /// are.
    pub(crate) fn widen_boxes(&mut self) {
        self.widen();
        self.reach = self.nodes[0].whole().largest();
    }

    fn widen(&mut self) {
        let margin = match &self.frame {
            Some(frame) => frame.margin,
            None if self.is_robust => return,
            None => self.bounds.largest() * (4.0 * f32::EPSILON),
        };
        // It is infinite where there are no triangles.
        if margin.is_finite() {
            self.nodes.iter_mut().for_each(|node| node.widen(margin));
        }
    }
}

/// Says which triangles are in a tree, of those that boxes are built around.
pub(crate) type CanBeHit = fn(&Triangle<f32>) -> bool;

/// That of a tree in a frame or in none: in a frame triangles are rounded, and those that nothing hits are NaN all over.
pub(crate) fn can_be_hit(frame: Option<&Frame>) -> CanBeHit {
    match frame {
        Some(_) => |triangle| triangle.a.x.is_finite(),
        None => Triangle::can_be_hit,
    }
}
