//! The same tree over a mesh that has moved, and whether it is worth keeping.

use trisect_core::Triangle;
use trisect_method::UnsuitableMesh;

use super::corners::Corners;
use super::members::{Kinds, Members, PLACES, blocks as pack};
use crate::bvh::bounds::Bounds;
use crate::bvh::frame::Frame;
use crate::bvh::node::{Child, Node, child, leaf};
use crate::bvh::wide::{CanBeHit, WideTree, can_be_hit};
use crate::parallel::each;
use crate::vectors::WIDTH;

/// A tree cannot be fitted to these triangles and has to be built anew.
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
        /// Its id.
        triangle: u32,
    },
    /// The tree is over instances, and has no triangles of its own.
    #[error("the triangles belong to what the instances place: refit that, and place it anew")]
    Placed,
    /// The method cannot take the mesh any more.
    #[error(transparent)]
    Unsuitable(#[from] UnsuitableMesh),
}

/// Whether a tree that was refitted had better be built anew, given its [cost](crate::Statistics::cost)
/// when it was built and now: where it is more than 1.25 times as much.
pub fn is_worn(built: f64, now: f64) -> bool {
    // Neither is NaN, but where there is nothing in the tree.
    now > WORN * built
}

/// How much more a tree may cost than when it was built.
///
/// Measured on the bunny, by twisting it and by moving every triangle on its own: the time of a ray over that in a new tree
/// follows the cost over that of a new tree, within a quarter up to a factor of 17. Building takes about four times
/// as long as fitting, and as long as tracing 1.5 rays for each triangle. So at this much more, building has paid after six
/// rays a triangle: sooner than a picture is done. Just below it, at most that is lost.
const WORN: f64 = 1.25;

/// Fits a tree to triangles of those kinds that have moved since it was built, and are in that frame now. Says what is in
/// each block.
/// `blocks` are the ids of the triangles of each block so far. The tree is as before where it fails.
///
/// # Errors
/// When there are not as many triangles as before, or one can be hit that could not be when the tree was
/// built.
pub(crate) fn refit(
    tree: &mut WideTree,
    blocks: &[[u32; WIDTH]],
    triangles: &[Triangle<f32>],
    frame: Option<Frame>,
    kinds: impl FnOnce() -> Result<Kinds, UnsuitableMesh>,
) -> Result<Vec<Members>, RefitError> {
    let (built, given) = (tree.origin.triangles, triangles.len());
    if built != given {
        return Err(RefitError::Count { built, given });
    }
    let is_in = can_be_hit(frame.as_ref());
    let mut left_out = tree.origin.left_out.iter();
    if let Some(&triangle) = left_out.find(|&&id| is_in(&triangles[id as usize])) {
        return Err(RefitError::Appeared { triangle });
    }
    let members = members(&mut tree.nodes, blocks, &kinds()?);
    tree.bounds = fit_boxes(&mut tree.nodes, triangles, is_in, &members);
    tree.frame = frame;
    tree.widen_boxes();
    Ok(members)
}

/// What is in the blocks. Triangles whose kind has changed move to another block of their leaf, and the number of
/// its blocks may change.
fn members(nodes: &mut [Node], blocks: &[[u32; WIDTH]], kinds: &Kinds) -> Vec<Members> {
    if let Kinds::All(kind) = *kinds {
        return blocks.iter().map(|&triangles| Members { triangles, kind }).collect();
    }
    let mut members = Vec::with_capacity(blocks.len());
    for node in nodes {
        for reference in &mut node.children {
            let Child::Leaf(first, count) = child(*reference) else { continue };
            let mut of_leaf = [(0, 0); PLACES];
            let of_leaf = &mut of_leaf[..count * WIDTH];
            let triangles = blocks[first..first + count].as_flattened();
            for (to, &triangle) in of_leaf.iter_mut().zip(triangles) {
                *to = (kinds.of(triangle), triangle);
            }
            let start = members.len();
            pack(of_leaf, &mut members);
            *reference = leaf(start..members.len());
        }
    }
    members
}

/// Computes all boxes from the triangles; the box around them.
pub(super) fn fit_boxes(
    nodes: &mut [Node],
    triangles: &[Triangle<f32>],
    is_in: CanBeHit,
    members: &[Members],
) -> Bounds {
    let boxes = each(members, Corners::EMPTY, |members: &Members| {
        let mut corners = Corners::EMPTY;
        for &id in &members.triangles {
            let triangle = &triangles[id as usize];
            if is_in(triangle) {
                corners.add(&Corners::of_triangle(triangle));
            }
        }
        corners
    });
    fit(nodes, &boxes)
}

/// Computes the boxes of all nodes from those of the blocks; the box around them.
pub(super) fn fit(nodes: &mut [Node], boxes: &[Corners]) -> Bounds {
    // What is below a node has a higher index.
    let mut of_nodes = vec![Corners::EMPTY; nodes.len()];
    for at in (0..nodes.len()).rev() {
        for lane in 0..WIDTH {
            let reference = nodes[at].children[lane];
            let corners = match child(reference) {
                // The root is below nothing: its index stands for no child. A place without a child keeps its box.
                Child::Node(0) | Child::Leaf(_, 0) => continue,
                Child::Node(index) => of_nodes[index],
                Child::Leaf(first, count) => boxes[first..first + count]
                    .iter()
                    .fold(Corners::EMPTY, |all, corners| all.with(corners)),
            };
            of_nodes[at].add(&corners);
            nodes[at].set(lane, &corners.bounds(), reference);
        }
    }
    of_nodes[0].bounds()
}
