//! The binary tree: single triangles at its leaves, split by the surface area heuristic.
//!
//! Wald: On fast Construction of SAH-based Bounding Volume Hierarchies. IEEE Symposium on Interactive
//! Ray Tracing, 2007. The references of a subtree stay together, and so do its nodes: a subtree over n
//! references has the 2n − 1 nodes from its root on, so that both can be built side by side in place.

use rayon::prelude::*;

use crate::bounds::Bounds;

/// A triangle, as the builder sees it.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Reference {
    pub(crate) bounds: Bounds,
    pub(crate) triangle: u32,
}

/// A node of the binary tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binary {
    pub(crate) bounds: Bounds,
    /// The place of its first reference.
    pub(crate) first: u32,
    /// How many references it has; one at a leaf.
    pub(crate) count: u32,
}

impl Binary {
    const NOTHING: Self = Self { bounds: Bounds::EMPTY, first: 0, count: 0 };
}

/// Bins along each axis.
const BINS: usize = 32;
/// Up to so many references every split is tried.
const SWEEP: usize = 16;
/// Beyond this depth references are halved, whatever it costs: depth stays bounded.
const DEEP: usize = 48;
/// From so many references on, both sides of a split are built side by side.
const PARALLEL: usize = 4096;
/// References that are binned in one go.
const CHUNK: usize = 1 << 16;

/// The tree over `references`, which are put in the order of the leaves. The left child of a node is
/// the next one, the right child follows the 2n − 1 nodes of the left.
pub(crate) fn build(references: &mut [Reference]) -> Vec<Binary> {
    if references.is_empty() {
        return Vec::new();
    }
    let mut nodes = vec![Binary::NOTHING; 2 * references.len() - 1];
    subtree(references, &mut nodes, 0, 0);
    nodes
}

fn subtree(references: &mut [Reference], nodes: &mut [Binary], first: u32, depth: usize) {
    let count = references.len();
    let Some((root, nodes)) = nodes.split_first_mut() else { return };
    let (bounds, middles) = extent(references);
    #[allow(clippy::cast_possible_truncation, reason = "references are counted in u32")]
    let (here, middle) = (count as u32, |half: usize| first + half as u32);
    *root = Binary { bounds, first, count: here };
    if count == 1 {
        return;
    }
    let half = if depth > DEEP { count / 2 } else { split(references, &middles) };
    let (left, right) = references.split_at_mut(half);
    let (left_nodes, right_nodes) = nodes.split_at_mut(2 * half - 1);
    let mut build_left = || subtree(left, left_nodes, first, depth + 1);
    let mut build_right = || subtree(right, right_nodes, middle(half), depth + 1);
    if count >= PARALLEL {
        rayon::join(build_left, build_right);
    } else {
        build_left();
        build_right();
    }
}

/// The bounds of the references, and of twice their middles.
fn extent(references: &[Reference]) -> (Bounds, Bounds) {
    let of_chunk = |chunk: &[Reference]| {
        let mut bounds = Bounds::EMPTY;
        let mut middles = Bounds::EMPTY;
        for reference in chunk {
            bounds.add(&reference.bounds);
            let point = reference.bounds.twice_middle();
            middles.add(&Bounds { min: point, max: point });
        }
        (bounds, middles)
    };
    let both = |mut a: (Bounds, Bounds), b: (Bounds, Bounds)| {
        a.0.add(&b.0);
        a.1.add(&b.1);
        a
    };
    if references.len() <= CHUNK {
        return of_chunk(references);
    }
    let empty = || (Bounds::EMPTY, Bounds::EMPTY);
    references.par_chunks(CHUNK).map(of_chunk).reduce(empty, both)
}

/// Puts the references of either side together, and says how many are on the left: at least one on
/// each side.
fn split(references: &mut [Reference], middles: &Bounds) -> usize {
    if references.len() <= SWEEP {
        return sweep(references);
    }
    let scale = [0, 1, 2].map(|axis| {
        let extent = middles.max[axis] - middles.min[axis];
        let scale = BINS as f32 * (1.0 - f32::EPSILON) / extent;
        // All in one bin where there is no extent, or none that a bin could tell.
        if scale.is_finite() { scale } else { 0.0 }
    });
    let bin = |reference: &Reference, axis: usize| {
        let at = (reference.bounds.twice_middle()[axis] - middles.min[axis]) * scale[axis];
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates, and NaN is the first bin"
        )]
        let place = at as usize;
        place.min(BINS - 1)
    };
    let bins = binned(references, &bin);
    let Some((axis, border)) = cheapest(&bins) else {
        // All middles are the same, as far as bins can tell.
        return references.len() / 2;
    };
    partition(references, |reference| bin(reference, axis) < border)
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: usize,
}

type Bins = [[Bin; BINS]; 3];

const NO_BINS: Bins = [[Bin { bounds: Bounds::EMPTY, count: 0 }; BINS]; 3];

fn binned(references: &[Reference], bin: &(impl Fn(&Reference, usize) -> usize + Sync)) -> Bins {
    let of_chunk = |chunk: &[Reference]| {
        let mut bins = NO_BINS;
        for reference in chunk {
            for (axis, bins) in bins.iter_mut().enumerate() {
                let bin = &mut bins[bin(reference, axis)];
                bin.bounds.add(&reference.bounds);
                bin.count += 1;
            }
        }
        bins
    };
    if references.len() <= CHUNK {
        return of_chunk(references);
    }
    let both = |mut a: Bins, b: Bins| {
        for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
            a.bounds.add(&b.bounds);
            a.count += b.count;
        }
        a
    };
    references.par_chunks(CHUNK).map(of_chunk).reduce(|| NO_BINS, both)
}

/// The axis, and the first bin of the right side, of the cheapest split.
fn cheapest(bins: &Bins) -> Option<(usize, usize)> {
    let mut best: Option<(f32, usize, usize)> = None;
    for (axis, bins) in bins.iter().enumerate() {
        // Cost of the right side of each border.
        let mut right = [0.0_f32; BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for border in (1..BINS).rev() {
            bounds.add(&bins[border].bounds);
            count += bins[border].count;
            right[border] = if count == 0 { f32::NAN } else { bounds.half_area() * count as f32 };
        }
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for border in 1..BINS {
            bounds.add(&bins[border - 1].bounds);
            count += bins[border - 1].count;
            let cost = bounds.half_area() * count as f32 + right[border];
            // A side without references is no split; NaN is no better than anything.
            if count > 0 && best.is_none_or(|(least, ..)| cost < least) && !cost.is_nan() {
                best = Some((cost, axis, border));
            }
        }
    }
    best.map(|(_, axis, border)| (axis, border))
}

/// Puts those that `is_left` says together at the front; how many they are. The order depends on
/// nothing but the order before.
fn partition(references: &mut [Reference], is_left: impl Fn(&Reference) -> bool) -> usize {
    let (mut low, mut high) = (0, references.len());
    loop {
        while low < high && is_left(&references[low]) {
            low += 1;
        }
        while low < high && !is_left(&references[high - 1]) {
            high -= 1;
        }
        if low >= high {
            return low;
        }
        references.swap(low, high - 1);
    }
}

/// Tries every split of a few references, sorted along each axis.
fn sweep(references: &mut [Reference]) -> usize {
    let count = references.len();
    let mut best = (f32::INFINITY, 2, count / 2);
    let mut right = [0.0_f32; SWEEP + 1];
    for axis in 0..3 {
        sort(references, axis);
        let mut bounds = Bounds::EMPTY;
        for place in (1..count).rev() {
            bounds.add(&references[place].bounds);
            right[place] = bounds.half_area() * (count - place) as f32;
        }
        let mut bounds = Bounds::EMPTY;
        for place in 1..count {
            bounds.add(&references[place - 1].bounds);
            let cost = bounds.half_area() * place as f32 + right[place];
            if cost < best.0 {
                best = (cost, axis, place);
            }
        }
    }
    let (_, axis, place) = best;
    if axis != 2 {
        sort(references, axis);
    }
    place
}

fn sort(references: &mut [Reference], axis: usize) {
    references.sort_unstable_by(|a, b| {
        let middle = |r: &Reference| r.bounds.min[axis] + r.bounds.max[axis];
        middle(a).total_cmp(&middle(b)).then(a.triangle.cmp(&b.triangle))
    });
}
