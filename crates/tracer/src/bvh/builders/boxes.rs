//! A tree over boxes, one to a leaf: over what is larger than a triangle.

use super::corners::{Corners, Reference};
use super::emit::{Layout, emit};
use super::members::Kinds;
use super::refit::fit;
use super::settings::{Builder, Leaves};
use super::{descent, unit};
use crate::bvh::bounds::Bounds;
use crate::bvh::node::{Child, Node, child, leaf};
use crate::bvh::wide::{Origin, WideTree};
use crate::vectors::WIDTH;

/// Builds a tree. A leaf is one box: its blocks are from the index of the box to the next. Those that are empty are
/// left out.
pub(crate) fn build(boxes: &[Corners]) -> WideTree {
    let references = (0_u32..).zip(boxes).filter(|(_, corners)| !corners.is_empty());
    let mut references: Vec<Reference> =
        references.map(|(id, corners)| corners.reference(id)).collect();
    let largest = references.iter().fold(0.0, |most: f32, reference| {
        let reference = Corners(*reference);
        most.max(reference.largest())
    });
    let unit = unit(largest);
    if unit != 1.0 {
        for reference in &mut references {
            let id = super::corners::id(reference);
            *reference = Corners(*reference).scaled(unit).reference(id);
        }
    }
    let count = references.len();
    let tree = descent::build(&mut references, count, None, Leaves::default());
    let Layout { mut nodes, blocks, depth, references } = emit(&tree, &Kinds::All(0));
    let mut more = 0;
    for at in 0..nodes.len() {
        for lane in 0..WIDTH {
            let Child::Leaf(first, count @ 1..) = child(nodes[at].children[lane]) else { continue };
            let of_leaf = blocks[first..first + count].iter().flat_map(|block| block.triangles);
            let mut of_leaf: Vec<u32> = of_leaf.collect();
            // Blocks are filled up by their last box.
            of_leaf.dedup();
            let (reference, levels) = over(&mut nodes, &of_leaf);
            nodes[at].children[lane] = reference;
            more = more.max(levels);
        }
    }
    let triangles = boxes.len();
    let origin = Origin { builder: Builder::Binned, triangles, left_out: vec![], references };
    let depth = depth + more;
    let bounds = Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };
    let mut tree =
        WideTree { nodes, depth, bounds, reach: 0.0, is_robust: true, frame: None, origin };
    refit(&mut tree, boxes);
    tree
}

/// Fits a tree to boxes that have moved. Those that were left out are empty still.
pub(crate) fn refit(tree: &mut WideTree, boxes: &[Corners]) {
    tree.bounds = fit(&mut tree.nodes, boxes);
    tree.widen_boxes();
}

/// The reference of what is over the boxes of a leaf, and how many levels of nodes that is.
fn over(nodes: &mut Vec<Node>, boxes: &[u32]) -> (u32, usize) {
    if let [only] = *boxes {
        let at = only as usize;
        return (leaf(at..at + 1), 0);
    }
    let at = nodes.len();
    nodes.push(Node::EMPTY);
    let mut most = 0;
    let each = if boxes.len() <= WIDTH { 1 } else { WIDTH };
    for (lane, boxes) in boxes.chunks(each).enumerate() {
        let (reference, levels) = over(nodes, boxes);
        nodes[at].children[lane] = reference;
        most = most.max(levels);
    }
    (u32::try_from(at).expect("nodes are fewer than boxes"), most + 1)
}
