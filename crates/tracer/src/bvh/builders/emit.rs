//! From the binary tree to the wide one: what is in each node and block, before either is filled.

use std::cmp::Reverse;

use rayon::prelude::*;

use super::binary::{Binary, Tree, places};
use super::members::{Kinds, LEAF, Members, blocks};
use crate::bvh::node::{Child, Node, child, leaf};
use crate::parallel::PARALLEL;
use crate::vectors::WIDTH;

/// The wide tree, without the method's data.
pub(crate) struct Layout {
    pub(crate) nodes: Vec<Node>,
    pub(crate) blocks: Vec<Members>,
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    /// Triangles in leaves, in each one of them once.
    pub(crate) references: usize,
}

/// A wide node: its children, and where their boxes are in the binary tree.
#[derive(Clone, Copy)]
struct Wide {
    children: [u32; WIDTH],
    binary: [u32; WIDTH],
    count: usize,
}

impl Wide {
    const EMPTY: Self = Self { children: [0; WIDTH], binary: [0; WIDTH], count: 0 };

    /// With so many nodes and blocks before those that it counts.
    fn moved(mut self, nodes: usize, blocks: usize) -> Self {
        for reference in &mut self.children[..self.count] {
            *reference = match child(*reference) {
                Child::Node(index) => index_of(index + nodes),
                Child::Leaf(first, count) => leaf(first + blocks..first + blocks + count),
            };
        }
        self
    }
}

/// A subtree of the binary tree: its root, its first reference, and its room.
#[derive(Clone, Copy)]
struct Subtree {
    root: usize,
    first: usize,
    room: usize,
}

/// Part of the wide tree; its nodes and blocks count from its own beginning on.
struct Piece {
    nodes: Vec<Wide>,
    blocks: Vec<Members>,
    depth: usize,
    references: usize,
    /// Subtrees that are pieces of their own: the place and depth of each.
    later: Vec<(usize, usize, Subtree)>,
}

/// The wide tree; of no references a node without children.
pub(crate) fn emit(tree: &Tree, kinds: &Kinds) -> Layout {
    let emit = Emit { tree, kinds };
    let whole = Subtree { root: 0, first: 0, room: tree.ids.len() };
    let is_large = whole.room > PARALLEL;
    let mut all = Piece::new();
    if !tree.nodes.is_empty() {
        if emit.is_leaf(whole) {
            let child = emit.leaf(&mut all, whole);
            let mut root = Wide { count: 1, ..Wide::EMPTY };
            root.children[0] = child;
            all.nodes[0] = root;
        } else {
            emit.node(&mut all, whole, 0, 1, is_large);
        }
    }
    let later = std::mem::take(&mut all.later);
    let piece = |&(_, depth, below): &(usize, usize, Subtree)| {
        let mut piece = Piece::new();
        emit.node(&mut piece, below, 0, depth, false);
        piece
    };
    if !later.is_empty() {
        let pieces: Vec<Piece> = later.par_iter().map(piece).collect();
        for ((at, ..), piece) in later.into_iter().zip(pieces) {
            all.append(at, piece);
        }
    }
    let node = |wide: &Wide| {
        let mut node = Node::EMPTY;
        for lane in 0..wide.count {
            let binary = Binary::load(&tree.nodes[wide.binary[lane] as usize]);
            node.set(lane, &binary.bounds.bounds(), wide.children[lane]);
        }
        node
    };
    let nodes = if is_large {
        all.nodes.par_iter().map(node).collect()
    } else {
        all.nodes.iter().map(node).collect()
    };
    Layout { nodes, blocks: all.blocks, depth: all.depth, references: all.references }
}

impl Piece {
    /// With a root that has no children yet.
    fn new() -> Self {
        let nodes = vec![Wide::EMPTY];
        Self { nodes, blocks: Vec::new(), depth: 1, references: 0, later: Vec::new() }
    }

    /// Takes in a piece whose root is to be at `at`; what is below comes last.
    fn append(&mut self, at: usize, piece: Self) {
        let before = self.nodes.len() - 1;
        let blocks = self.blocks.len();
        self.nodes[at] = piece.nodes[0].moved(before, blocks);
        self.nodes.extend(piece.nodes[1..].iter().copied().map(|wide| wide.moved(before, blocks)));
        self.blocks.extend(piece.blocks);
        self.depth = self.depth.max(piece.depth);
        self.references += piece.references;
    }
}

fn index_of(index: usize) -> u32 {
    u32::try_from(index).expect("nodes are fewer than triangles")
}

struct Emit<'a> {
    tree: &'a Tree,
    kinds: &'a Kinds,
}

/// Up to eight children of a wide node.
struct Found {
    subtrees: [Subtree; WIDTH],
    count: usize,
}

impl Emit<'_> {
    fn is_leaf(&self, subtree: Subtree) -> bool {
        Binary::load(&self.tree.nodes[subtree.root]).choices.is_leaf()
    }

    /// Fills in the wide node at `at`. Its inner children stand side by side, each followed by what is
    /// below it; where this is the top of a large tree, what is below small ones comes later.
    fn node(&self, piece: &mut Piece, subtree: Subtree, at: usize, depth: usize, is_top: bool) {
        piece.depth = piece.depth.max(depth);
        let nothing = Subtree { root: 0, first: 0, room: 0 };
        let mut found = Found { subtrees: [nothing; WIDTH], count: 0 };
        self.forest(subtree, WIDTH, &mut found);
        self.likely_first(&mut found.subtrees[..found.count]);
        let mut wide = Wide { count: found.count, ..Wide::EMPTY };
        let first = piece.nodes.len();
        for (lane, &below) in found.subtrees[..found.count].iter().enumerate() {
            wide.binary[lane] = index_of(below.root);
            if self.is_leaf(below) {
                wide.children[lane] = self.leaf(piece, below);
            } else {
                wide.children[lane] = index_of(piece.nodes.len());
                piece.nodes.push(Wide::EMPTY);
            }
        }
        piece.nodes[at] = wide;
        let mut next = first;
        for &below in &found.subtrees[..found.count] {
            if !self.is_leaf(below) {
                if is_top && below.room <= PARALLEL {
                    piece.later.push((next, depth + 1, below));
                } else {
                    self.node(piece, below, next, depth + 1, is_top);
                }
                next += 1;
            }
        }
    }

    /// Any hit will do for many rays, and those visit children in the order of their lanes: a leaf is
    /// soon tested, and a large box is hit by many.
    fn likely_first(&self, subtrees: &mut [Subtree]) {
        subtrees.sort_by_key(|&below| {
            let area = Binary::load(&self.tree.nodes[below.root]).bounds.half_area();
            (!self.is_leaf(below), Reverse(area.to_bits()))
        });
    }

    /// The best forest of up to so many roots.
    fn forest(&self, subtree: Subtree, roots: usize, found: &mut Found) {
        let binary = Binary::load(&self.tree.nodes[subtree.root]);
        let (in_left, in_right) = binary.choices.roots(roots);
        let room = binary.left;
        let left = Subtree { root: subtree.root + 1, first: subtree.first, room };
        let right = Subtree {
            root: left.root + places(room),
            first: subtree.first + room,
            room: subtree.room - room,
        };
        for (below, roots) in [(left, in_left), (right, in_right)] {
            if roots == 1 || Binary::load(&self.tree.nodes[below.root]).choices.is_one(roots) {
                found.subtrees[found.count] = below;
                found.count += 1;
            } else {
                self.forest(below, roots, found);
            }
        }
    }

    /// Writes the blocks of a leaf, one kind after the other, no triangle twice.
    fn leaf(&self, piece: &mut Piece, subtree: Subtree) -> u32 {
        let count = Binary::load(&self.tree.nodes[subtree.root]).choices.count();
        let mut members = [(0, 0); LEAF];
        let members = &mut members[..count];
        for (member, &triangle) in members.iter_mut().zip(&self.tree.ids[subtree.first..]) {
            *member = (self.kinds.of(triangle), triangle);
        }
        let start = piece.blocks.len();
        piece.references += blocks(members, &mut piece.blocks);
        leaf(start..piece.blocks.len())
    }
}
