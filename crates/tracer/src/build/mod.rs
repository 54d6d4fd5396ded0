//! From triangles to a wide tree.

mod binary;
mod collapse;

use rayon::prelude::*;
use trisect_core::{Method, Triangle, UnsuitableMesh, rows};

use self::binary::{Binary, Reference};
use self::collapse::{Collapse, Root};
use crate::bounds::Bounds;
use crate::bvh::{Block, Bvh, Node, WIDTH, leaf};

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
                groups: Vec::new(),
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
                if const { M::GROUPS > 1 } {
                    self.bvh.groups.push(u8::try_from(of_group[0].0).expect("kinds are few"));
                }
            }
        }
        leaf(start..self.bvh.blocks.len())
    }

    /// Up to eight triangles of one kind; the last one fills up the block.
    fn block(&self, members: &[(usize, u32)]) -> Block<M> {
        let group = members[0].0;
        let number = |lane: usize| members[lane.min(members.len() - 1)].1;
        let triangles = std::array::from_fn(number);
        let prepared = rows::<M::Prepared, f32, WIDTH>(|lane| {
            M::prepare(&self.triangles[number(lane) as usize], group)
        });
        Block { prepared, triangles }
    }
}
