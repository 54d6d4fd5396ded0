//! From two children to eight: the cheapest way to cut a binary tree into wide nodes and leaves.
//!
//! Ylitie, Karras, Laine: Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs. High
//! Performance Graphics 2017, section 3.1, with costs of a CPU with lanes: a node is tested at once, and
//! so is a block of triangles.

use super::binary::Binary;
use crate::bvh::WIDTH;

/// Blocks of a leaf, at most.
const BLOCKS: usize = 2;

/// What a subtree of the binary tree becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Root {
    /// A wide node; the place of its binary root.
    Node(usize),
    /// A leaf; the place of its binary root.
    Leaf(usize),
}

/// The costs of the subtrees of each binary node, and what made them.
pub(crate) struct Collapse<'a> {
    nodes: &'a [Binary],
    /// Of each node the cost as a forest of 1 to 7 roots.
    costs: Vec<[f32; WIDTH]>,
    /// Of each node, by the number of roots, how many go to the left child; 0 where one root fewer is
    /// as good. In the first place whether it is a leaf.
    choices: Vec<[u8; WIDTH + 1]>,
}

impl<'a> Collapse<'a> {
    /// Costs are found from the leaves up.
    pub(crate) fn new(nodes: &'a [Binary]) -> Self {
        let mut collapse = Self {
            nodes,
            costs: vec![[0.0; WIDTH]; nodes.len()],
            choices: vec![[0; WIDTH + 1]; nodes.len()],
        };
        for place in (0..nodes.len()).rev() {
            collapse.node(place);
        }
        collapse
    }

    fn node(&mut self, place: usize) {
        let node = &self.nodes[place];
        let area = node.bounds.half_area();
        let blocks = (node.count as usize).div_ceil(WIDTH);
        let leaf = if blocks <= BLOCKS { area * blocks as f32 } else { f32::INFINITY };
        let mut costs = [leaf; WIDTH];
        let mut choices = [0_u8; WIDTH + 1];
        choices[0] = 1;
        if node.count > 1 {
            let (left, right) = self.children(place);
            let (left, right) = (self.costs[left], self.costs[right]);
            let mut forests = [f32::INFINITY; WIDTH + 1];
            // Where areas overflow no cost is less than another, and any choice will do.
            choices[2..].fill(1);
            for roots in 2..=WIDTH {
                for to_left in 1..roots.min(WIDTH) {
                    if roots - to_left < WIDTH {
                        let cost = left[to_left] + right[roots - to_left];
                        if cost < forests[roots] {
                            forests[roots] = cost;
                            #[allow(clippy::cast_possible_truncation, reason = "below eight")]
                            let to_left = to_left as u8;
                            choices[roots] = to_left;
                        }
                    }
                }
            }
            let inner = forests[WIDTH] + area;
            if inner < leaf || blocks > BLOCKS {
                costs[1] = inner;
                choices[0] = 0;
            }
            for roots in 2..WIDTH {
                costs[roots] = forests[roots];
                if costs[roots - 1] <= forests[roots] && costs[roots - 1] < f32::INFINITY {
                    costs[roots] = costs[roots - 1];
                    choices[roots] = 0;
                }
            }
        }
        self.costs[place] = costs;
        self.choices[place] = choices;
    }

    /// The children of a binary node that has some.
    fn children(&self, place: usize) -> (usize, usize) {
        let left = place + 1;
        (left, left + 2 * self.nodes[left].count as usize - 1)
    }

    /// What the whole tree becomes.
    pub(crate) fn root(&self) -> Root {
        self.one(0)
    }

    /// The children of a wide node, given the place of its binary root.
    pub(crate) fn wide(&self, place: usize, found: &mut Vec<Root>) {
        self.forest(place, WIDTH, found);
    }

    fn one(&self, place: usize) -> Root {
        if self.choices[place][0] == 1 { Root::Leaf(place) } else { Root::Node(place) }
    }

    fn forest(&self, place: usize, roots: usize, found: &mut Vec<Root>) {
        let mut roots = roots;
        while roots > 1 && self.choices[place][roots] == 0 && roots < WIDTH {
            roots -= 1;
        }
        let to_left = usize::from(self.choices[place][roots]);
        if roots == 1 || to_left == 0 {
            found.push(self.one(place));
            return;
        }
        let (left, right) = self.children(place);
        self.forest(left, to_left, found);
        self.forest(right, roots - to_left, found);
    }
}
