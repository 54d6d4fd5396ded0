//! The same tree over a mesh that has moved.

use trisect_core::{Method, Triangle, UnsuitableMesh};

use super::corners::Corners;
use super::emit::{self, Kinds, Members, PLACES};
use super::{KindsOf, blocks};
use crate::bounds::Bounds;
use crate::bvh::{Block, Bvh, Child, Node, WIDTH, child, leaf};
use crate::parallel::each;

/// A tree cannot be fitted to these triangles: it has to be built anew.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RefitError {
    /// There are more or fewer than before.
    #[error("the tree was built over {built} triangles and there are {given} now: build it anew")]
    Count {
        /// How many the tree was built over.
        built: usize,
        /// How many there are now.
        given: usize,
    },
    /// A triangle is in no leaf.
    #[error(
        "triangle {triangle} could not be hit when the tree was built, being degenerate or not \
         finite, and can be hit now: build the tree anew"
    )]
    Appeared {
        /// Its number.
        triangle: u32,
    },
    /// The method cannot take the mesh any more.
    #[error(transparent)]
    Unsuitable(#[from] UnsuitableMesh),
}

impl<M: Method> Bvh<M> {
    /// Fits the tree to triangles that have moved since it was built: prepares them anew and computes
    /// the boxes, in the same tree. It answers as a new one would; how fast depends on how far they
    /// moved relative to each other. The box of a triangle that was divided between leaves is whole
    /// again in each, so build trees to be refitted without spatial splits.
    ///
    /// Triangles that nothing can hit any more are kept, and may come back later.
    ///
    /// # Errors
    /// When there are not as many triangles as before, when one can be hit that could not be when the
    /// tree was built, or when the method cannot take the mesh. The tree is as before then.
    pub fn refit(&mut self, triangles: &[Triangle<f32>]) -> Result<(), RefitError> {
        let (built, given) = (self.origin.triangles, triangles.len());
        if built != given {
            return Err(RefitError::Count { built, given });
        }
        let mut left_out = self.origin.left_out.iter();
        if let Some(&triangle) = left_out.find(|&&number| triangles[number as usize].can_be_hit()) {
            return Err(RefitError::Appeared { triangle });
        }
        let kinds = KindsOf::new::<M>(triangles)?;
        let members = self.members(kinds.kinds());
        (self.blocks, self.groups) = blocks::<M>(triangles, &members);
        self.bounds = fit_boxes(&mut self.nodes, triangles, &members);
        self.widen_boxes();
        Ok(())
    }

    /// What is in the blocks; where kinds have changed, triangles change blocks within their leaves,
    /// and leaves the number of their blocks.
    fn members(&mut self, kinds: Kinds<'_>) -> Vec<Members> {
        if let Kinds::All(group) = kinds {
            let members = |block: &Block<M>| Members { triangles: block.triangles, group };
            return each(&self.blocks, Members::NOTHING, members);
        }
        let mut members = Vec::with_capacity(self.blocks.len());
        for node in &mut self.nodes {
            for number in &mut node.children {
                let Child::Leaf(first, count) = child(*number) else { continue };
                let mut of_leaf = [(0, 0); PLACES];
                let triangles =
                    self.blocks[first..first + count].iter().flat_map(|block| block.triangles);
                let of_leaf = &mut of_leaf[..count * WIDTH];
                for (to, triangle) in of_leaf.iter_mut().zip(triangles) {
                    *to = (kinds.of(triangle), triangle);
                }
                let start = members.len();
                emit::blocks(of_leaf, &mut members);
                *number = leaf(start..members.len());
            }
        }
        members
    }
}

/// Computes all boxes from the triangles; the box around them.
pub(super) fn fit_boxes(
    nodes: &mut [Node],
    triangles: &[Triangle<f32>],
    members: &[Members],
) -> Bounds {
    let boxes = each(members, Corners::EMPTY, |members: &Members| {
        let mut corners = Corners::EMPTY;
        for &number in &members.triangles {
            let triangle = &triangles[number as usize];
            if triangle.can_be_hit() {
                corners.add(&Corners::of_triangle(triangle));
            }
        }
        corners
    });
    // What is below a node has higher numbers.
    let mut of_nodes = vec![Corners::EMPTY; nodes.len()];
    for at in (0..nodes.len()).rev() {
        for lane in 0..WIDTH {
            let number = nodes[at].children[lane];
            let corners = match child(number) {
                // The root is below nothing: its number stands for no child.
                Child::Node(0) => continue,
                Child::Node(place) => of_nodes[place],
                Child::Leaf(first, count) => boxes[first..first + count]
                    .iter()
                    .fold(Corners::EMPTY, |all, corners| all.with(corners)),
            };
            of_nodes[at].add(&corners);
            nodes[at].set(lane, &corners.bounds(), number);
        }
    }
    of_nodes[0].bounds()
}
