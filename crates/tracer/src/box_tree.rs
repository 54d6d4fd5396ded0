//! A tree over boxes: for shapes that are not triangles, whose tests are somewhere else.

use trisect_core::{Ray, Vec3};

use crate::bvh::builders::boxes;
use crate::bvh::builders::corners::Corners;
use crate::bvh::wide::{Statistics, WideTree};
use crate::dispatch::Tracing;
use crate::hits::lanes_of;
use crate::instances::{Extent, Update};
use crate::lanes::on_fast_lanes;
use crate::traverse::walk::Walk;

/// A tree over boxes. It names the boxes that a ray may meet, and leaves what is in them to the caller.
pub struct BoxTree {
    tree: WideTree,
    boxes: Vec<Corners>,
    /// Its cost when it was built.
    built: f64,
}

/// Boxes as builders take them; one that is NaN anywhere is empty.
fn all_corners(boxes: &[[Vec3<f32>; 2]]) -> Vec<Corners> {
    let corners = |&[low, high]: &[Vec3<f32>; 2]| {
        let (low, high) = (low.to_array(), high.to_array());
        if (0..3).all(|axis| low[axis] <= high[axis]) {
            Corners::of_point(low).with(&Corners::of_point(high))
        } else {
            Corners::EMPTY
        }
    };
    boxes.iter().map(corners).collect()
}

impl BoxTree {
    /// Builds a tree over boxes, each given by its lowest and its highest corner. A box whose corners are not so
    /// ordered is empty: no ray meets it.
    ///
    /// # Panics
    /// When there are 2²⁸ boxes or more.
    pub fn new(boxes: &[[Vec3<f32>; 2]]) -> Self {
        let boxes = all_corners(boxes);
        let tree = boxes::build(&boxes);
        Self { built: tree.cost(), tree, boxes }
    }

    /// Fits the tree to boxes that have moved, or builds it anew: where it has become worn, see
    /// [`is_worn`](crate::is_worn), where there are more boxes or fewer, or where one appeared that was empty.
    pub fn update(&mut self, boxes: &[[Vec3<f32>; 2]]) -> Update {
        let boxes = all_corners(boxes);
        let pairs = self.boxes.iter().zip(&boxes);
        let are_alike = self.boxes.len() == boxes.len()
            && pairs.into_iter().all(|(old, new)| old.is_empty() == new.is_empty());
        self.boxes = boxes;
        if are_alike {
            boxes::refit(&mut self.tree, &self.boxes);
            let update = Update::of_cost(self.built, self.tree.cost());
            if update != Update::Rebuilt {
                return update;
            }
        }
        self.tree = boxes::build(&self.boxes);
        self.built = self.tree.cost();
        Update::Rebuilt
    }

    /// Calls `take` with the index of each box that a ray may meet within its interval, near ones first; it says where
    /// the interval ends from then on. No box is left out that the ray truly meets before that. Nothing is allocated.
    #[inline]
    pub fn visit(&self, tracing: Tracing, ray: &Ray<f32>, take: &mut dyn FnMut(usize) -> f32) {
        let mut end = ray.tmax;
        let leaf = &mut |boxes: std::ops::Range<usize>| {
            // A place without a child is a leaf of nothing.
            if !boxes.is_empty() {
                end = take(boxes.start);
            }
            end
        };
        let walk = Walk { tree: &self.tree, ray, leaf };
        let _ = match lanes_of(tracing) {
            Some(plain) => plain.run(walk),
            None => on_fast_lanes(walk).unwrap_or_default(),
        };
    }

    /// What a tree over [`Instances`](crate::Instances) has to know of it: boxes count as triangles.
    pub fn extent(&self) -> Extent {
        Extent::of_tree(&self.tree)
    }

    /// Facts about the tree; its blocks and references are boxes.
    pub fn statistics(&self) -> Statistics {
        self.tree.statistics(self.tree.origin.references, size_of_val(&self.boxes[..]))
    }
}
