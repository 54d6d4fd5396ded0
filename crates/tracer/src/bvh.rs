//! The wide tree as it is traversed: nodes of eight children, leaves of blocks of eight triangles.

use rayon::prelude::*;
use trisect_core::{Method, Of, Triangle, UnsuitableMesh, rows};

use crate::binary::{self, Binary, Reference};
use crate::bounds::Bounds;
use crate::collapse::{Collapse, Root};

/// Children of a node, and triangles of a block.
pub(crate) const WIDTH: usize = 8;

/// A leaf: the uppermost bit, then how many blocks, then the first of them.
const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 28;
const FIRST_MASK: u32 = (1 << COUNT_SHIFT) - 1;

/// Eight boxes, coordinate by coordinate, and what is in them. A place without a child has a box that
/// is empty.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// `x` from and to, `y`, `z`; two rows more, so that a row is found by a mask.
    pub(crate) bounds: [[f32; WIDTH]; 6],
    /// A node's place, or a leaf.
    pub(crate) children: [u32; WIDTH],
    /// Fills up 256 bytes.
    spare: [u32; WIDTH],
}

impl Node {
    const EMPTY: Self = {
        let (from, to) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { bounds: [from, to, from, to, from, to], children: [0; WIDTH], spare: [0; WIDTH] }
    };

    fn set(&mut self, lane: usize, bounds: &Bounds, child: u32) {
        for axis in 0..3 {
            self.bounds[2 * axis][lane] = bounds.min[axis];
            self.bounds[2 * axis + 1][lane] = bounds.max[axis];
        }
        self.children[lane] = child;
    }
}

/// Eight triangles of one kind, prepared, number by number.
#[repr(align(64))]
pub(crate) struct Block<M: Method> {
    pub(crate) prepared: Of<M::Prepared, [f32; WIDTH]>,
    /// Their numbers.
    pub(crate) triangles: [u32; WIDTH],
    /// Their kind.
    pub(crate) group: u32,
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
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    pub(crate) bounds: Bounds,
}

/// Facts about a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Wide nodes.
    pub nodes: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
    /// Nodes on the longest way down.
    pub depth: usize,
    /// Bytes of nodes and blocks.
    pub bytes: usize,
    /// Expected cost of a ray that meets the root, in tests of a node or a block (the surface area
    /// heuristic).
    pub cost: f64,
}

impl<M: Method> Bvh<M> {
    /// Prepares `triangles`, whose numbers are their places, and puts them in a tree. Triangles that
    /// are not finite or have no area are left out: nothing hits them.
    ///
    /// The tree depends on the triangles alone, not on the number of threads.
    ///
    /// # Errors
    /// When the method cannot take the mesh.
    ///
    /// # Panics
    /// When there are more than `u32::MAX − 1` triangles, or more than 2²⁸ blocks.
    pub fn build(triangles: &[Triangle<f32>]) -> Result<Self, UnsuitableMesh> {
        let fixed = M::mesh_group(triangles)?;
        let mut references: Vec<Reference> = (0..u32::MAX)
            .zip(triangles)
            .collect::<Vec<_>>()
            .into_par_iter()
            .filter(|(_, triangle)| triangle.can_be_hit())
            .map(|(number, triangle)| Reference {
                bounds: Bounds::of_triangle(triangle),
                triangle: number,
            })
            .collect();
        let binary = binary::build(&mut references);
        let mut emit = Emit::<M> {
            triangles,
            references: &references,
            binary: &binary,
            fixed,
            bvh: Self {
                nodes: vec![Node::EMPTY],
                blocks: Vec::new(),
                depth: 1,
                bounds: Bounds::EMPTY,
            },
        };
        if let Some(root) = binary.first() {
            emit.bvh.bounds = root.bounds;
            let collapse = Collapse::new(&binary);
            match collapse.root() {
                Root::Node(place) => emit.node(&collapse, place, 0, 1),
                leaf @ Root::Leaf(_) => {
                    let child = emit.leaf(leaf);
                    emit.bvh.nodes[0].set(0, &root.bounds, child);
                }
            }
        }
        Ok(emit.bvh)
    }

    /// Facts about the tree.
    pub(crate) fn statistics_of(&self) -> Statistics {
        let whole = f64::from(self.bounds.half_area());
        let mut cost = 1.0;
        for node in &self.nodes {
            for lane in 0..WIDTH {
                let corner = |row: usize| [0, 2, 4].map(|axis| node.bounds[axis + row][lane]);
                let bounds = Bounds { min: corner(0), max: corner(1) };
                let share = f64::from(bounds.half_area()) / whole;
                if share.is_finite() {
                    cost += share
                        * match child(node.children[lane]) {
                            Child::Node(_) => 1.0,
                            Child::Leaf(_, count) => count as f64,
                        };
                }
            }
        }
        Statistics {
            nodes: self.nodes.len(),
            blocks: self.blocks.len(),
            depth: self.depth,
            bytes: size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..]),
            cost,
        }
    }
}

/// Writes the wide tree.
struct Emit<'a, M: Method> {
    triangles: &'a [Triangle<f32>],
    references: &'a [Reference],
    binary: &'a [Binary],
    fixed: Option<usize>,
    bvh: Bvh<M>,
}

impl<M: Method> Emit<'_, M> {
    /// Fills in the wide node at `at`, whose binary root is at `place`. Its inner children stand side
    /// by side, each followed by what is below it.
    fn node(&mut self, collapse: &Collapse<'_>, place: usize, at: usize, depth: usize) {
        self.bvh.depth = self.bvh.depth.max(depth);
        let mut roots = Vec::with_capacity(WIDTH);
        collapse.wide(place, &mut roots);
        let inner = roots.iter().filter(|root| matches!(root, Root::Node(_))).count();
        let first = self.bvh.nodes.len();
        self.bvh.nodes.resize(first + inner, Node::EMPTY);
        let mut next = first;
        for (lane, &root) in roots.iter().enumerate() {
            let (Root::Node(below) | Root::Leaf(below)) = root;
            let bounds = self.binary[below].bounds;
            let child = match root {
                Root::Node(_) => {
                    next += 1;
                    u32::try_from(next - 1).expect("nodes are fewer than triangles")
                }
                Root::Leaf(_) => self.leaf(root),
            };
            self.bvh.nodes[at].set(lane, &bounds, child);
        }
        let mut next = first;
        for root in roots {
            if let Root::Node(below) = root {
                self.node(collapse, below, next, depth + 1);
                next += 1;
            }
        }
    }

    /// Writes the blocks of a leaf, one kind after the other.
    fn leaf(&mut self, root: Root) -> u32 {
        let (Root::Node(place) | Root::Leaf(place)) = root;
        let Binary { first, count, .. } = self.binary[place];
        let (first, count) = (first as usize, count as usize);
        let mut members: Vec<(usize, u32)> = self.references[first..first + count]
            .iter()
            .map(|reference| {
                let triangle = &self.triangles[reference.triangle as usize];
                (self.fixed.unwrap_or_else(|| M::group(triangle)), reference.triangle)
            })
            .collect();
        members.sort_unstable();
        let start = self.bvh.blocks.len();
        for of_group in members.chunk_by(|a, b| a.0 == b.0) {
            for chunk in of_group.chunks(WIDTH) {
                let block = self.block(chunk);
                self.bvh.blocks.push(block);
            }
        }
        let blocks = u32::try_from(self.bvh.blocks.len() - start).expect("a leaf has few blocks");
        let start = u32::try_from(start).expect("blocks are fewer than triangles");
        assert!(start <= FIRST_MASK, "more blocks than the tree can number");
        LEAF | blocks << COUNT_SHIFT | start
    }

    /// Up to eight triangles of one kind; the last one fills up the block.
    fn block(&self, members: &[(usize, u32)]) -> Block<M> {
        let group = members[0].0;
        let number = |lane: usize| members[lane.min(members.len() - 1)].1;
        let triangles = std::array::from_fn(number);
        let prepared = rows::<M::Prepared, f32, WIDTH>(|lane| {
            M::prepare(&self.triangles[number(lane) as usize], group)
        });
        Block { prepared, triangles, group: u32::try_from(group).expect("kinds are few") }
    }
}
