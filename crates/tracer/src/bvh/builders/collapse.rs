//! From two children to eight: the cheapest way to cut a binary tree into wide nodes and leaves.
//!
//! Ylitie, Karras, Laine: Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs. High
//! Performance Graphics 2017, section 3.1, with costs of a CPU with lanes: a node is tested at once, and
//! so is a block of triangles. Costs pass from the children to their parent as the binary tree is built;
//! what is kept of them is the choice, in one number per node.

use super::corners::Corners;
use super::settings::Leaves;
use crate::vectors::WIDTH;

/// The costs of a subtree, by the number of roots (1 to 7) that it may become: the more roots, the less.
pub(crate) type Costs = [f32; WIDTH];

/// How a subtree becomes a forest.
///
/// From the lowest bit: whether it is a leaf where it has one root (1 bit); up to how many roots one is
/// as good (3 bits); for 3 to 8 roots, how many go to the left child, 0 where one root fewer is as good
/// (3 bits each); how many references there are, the largest number for more (10 bits).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choices(pub(crate) u32);

const ONE_SHIFT: u32 = 1;
const ROOTS_SHIFT: u32 = 4;
const COUNT_SHIFT: u32 = 22;
const MANY: usize = (1 << (32 - COUNT_SHIFT)) - 1;

impl Choices {
    pub(crate) fn is_leaf(self) -> bool {
        self.0 & 1 == 1
    }

    /// How many references there are, where that is few.
    pub(crate) fn count(self) -> usize {
        (self.0 >> COUNT_SHIFT) as usize
    }

    /// Whether the best forest of up to `roots` has one root.
    pub(crate) fn is_one(self, roots: usize) -> bool {
        roots <= (self.0 >> ONE_SHIFT & 7) as usize
    }

    /// The best forest of 2 to `roots` roots: how many are in the left child, and in the right one.
    pub(crate) fn roots(self, mut roots: usize) -> (usize, usize) {
        while roots > 2 {
            let to_left = (self.0 >> roots_shift(roots) & 7) as usize;
            if to_left > 0 {
                return (to_left, roots - to_left);
            }
            roots -= 1;
        }
        (1, 1)
    }
}

const fn roots_shift(roots: usize) -> usize {
    ROOTS_SHIFT as usize + 3 * (roots - 3)
}

#[allow(clippy::cast_possible_truncation, reason = "up to ten bits")]
fn count_bits(count: usize) -> u32 {
    (count.min(MANY) as u32) << COUNT_SHIFT
}

/// A node of the binary tree without children: a leaf.
pub(crate) fn leaf(bounds: &Corners, count: usize) -> (Costs, Choices) {
    debug_assert!(count <= WIDTH, "a block fits in every leaf");
    let cost = bounds.half_area() * count.div_ceil(WIDTH) as f32;
    ([cost; WIDTH], Choices(1 | 7 << ONE_SHIFT | count_bits(count)))
}

/// A node of the binary tree, from the costs of its children and how many references each has; it may
/// become one of these leaves.
pub(crate) fn inner(
    leaves: Leaves,
    bounds: &Corners,
    (left, left_count): (&Costs, usize),
    (right, right_count): (&Costs, usize),
) -> (Costs, Choices) {
    let mut forests = [f32::INFINITY; WIDTH + 1];
    let mut to_left = [0_u32; WIDTH + 1];
    // No forest has more roots than references.
    let most = |count: usize| count.min(WIDTH - 1);
    for (in_left, of_left) in (1_u32..).zip(&left[1..=most(left_count)]) {
        let from = in_left as usize + 1;
        let forests = forests[from..].iter_mut().zip(&mut to_left[from..]);
        for ((forest, to_left), of_right) in forests.zip(&right[1..=most(right_count)]) {
            let cost = of_left + of_right;
            if cost < *forest {
                (*forest, *to_left) = (cost, in_left);
            }
        }
    }
    let mut choices = 0;
    for roots in 3..=WIDTH {
        if forests[roots] < forests[roots - 1] {
            choices |= to_left[roots] << roots_shift(roots);
        } else {
            forests[roots] = forests[roots - 1];
        }
    }
    let (area, count) = (bounds.half_area(), left_count + right_count);
    let blocks = count.div_ceil(WIDTH);
    // Where areas overflow no cost is less than another, and leaves are as large as they may be.
    let mut one = forests[WIDTH] + area;
    let leaf = area * blocks as f32;
    let is_cheaper = one < leaf;
    let is_leaf = leaves.take(blocks, is_cheaper);
    if is_leaf {
        one = leaf;
    }
    let mut costs = [one; WIDTH];
    let mut as_good = 1;
    // What is a leaf at any price is not divided between children of a node above either.
    let stays_whole = leaves.take(blocks, true);
    for roots in 2..WIDTH {
        if forests[roots] < one && !stays_whole {
            costs[roots] = forests[roots];
        } else {
            as_good += 1;
        }
    }
    (costs, Choices(u32::from(is_leaf) | as_good << ONE_SHIFT | choices | count_bits(count)))
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    /// The least cost of a forest of up to so many roots, of all there are.
    fn least(
        leaves: Leaves,
        nodes: &[(Corners, usize)],
        known: &mut HashMap<(usize, usize), f32>,
        at: usize,
        roots: usize,
    ) -> f32 {
        if let Some(&cost) = known.get(&(at, roots)) {
            return cost;
        }
        let (bounds, count) = nodes[at];
        let area = bounds.half_area();
        let mut best = if leaves.take(count.div_ceil(WIDTH), false) {
            area * count.div_ceil(WIDTH) as f32
        } else {
            f32::INFINITY
        };
        // Where it has a choice.
        if count > 1 && !leaves.take(count.div_ceil(WIDTH), true) {
            let left = at + 1;
            let right = left + 2 * nodes[left].1 - 1;
            // As a forest, or as one root with eight children.
            for (roots, more) in [(roots, 0.0), (WIDTH, area)] {
                for to_left in 1..roots {
                    let cost = least(leaves, nodes, known, left, to_left)
                        + least(leaves, nodes, known, right, roots - to_left);
                    best = best.min(cost + more);
                }
            }
        }
        known.insert((at, roots), best);
        best
    }

    /// A random binary tree over boxes along a line, and the costs of its root.
    fn tree(
        leaves: Leaves,
        nodes: &mut Vec<(Corners, usize)>,
        sizes: &mut impl FnMut() -> f32,
        count: usize,
    ) -> (Corners, Costs) {
        let at = nodes.len();
        nodes.push((Corners::EMPTY, count));
        if count == 1 {
            let size = sizes();
            let mut corners = Corners::of_point([sizes(), sizes(), sizes()]);
            corners.add(&Corners::of_point([size; 3]));
            nodes[at].0 = corners;
            return (corners, leaf(&corners, 1).0);
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
        let on_left = 1 + (sizes() * (count - 1) as f32) as usize % (count - 1);
        let (left, left_costs) = tree(leaves, nodes, sizes, on_left);
        let (right, right_costs) = tree(leaves, nodes, sizes, count - on_left);
        let bounds = left.with(&right);
        nodes[at].0 = bounds;
        let (costs, _) =
            inner(leaves, &bounds, (&left_costs, on_left), (&right_costs, count - on_left));
        (bounds, costs)
    }

    #[test]
    fn no_cut_is_cheaper() {
        let mut stream = trisect_workloads::Stream::new("cuts", 1);
        #[allow(clippy::cast_possible_truncation, reason = "rounds")]
        let mut sizes = || stream.unit_f64() as f32;
        for (count, leaves) in [2, 3, 8, 9, 17, 40, 200]
            .into_iter()
            .flat_map(|count| Leaves::ALL.map(|leaves| (count, leaves)))
        {
            let mut nodes = Vec::new();
            let (_, costs) = tree(leaves, &mut nodes, &mut sizes, count);
            let least = least(leaves, &nodes, &mut HashMap::new(), 0, 1);
            assert!((costs[1] - least).abs() <= 1e-4 * least, "{count}: {costs:?} {least}");
        }
    }
}
