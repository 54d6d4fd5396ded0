//! Along a curve: the tree that the order of the middles' bits makes.
//!
//! Lauterbach, Garland, Sengupta, Luebke, Manocha: Fast BVH Construction on GPUs. Eurographics 2009: the
//! bits of the three coordinates of a middle in turn make its code; in the order of codes a node splits
//! where the highest bit changes that is not the same in all of it.

use rayon::prelude::*;

use super::binary::{self, Built, Room, Tree, extent, places};
use super::corners::{Corners, Reference, id};
use super::settings::Leaves;
use crate::parallel::{PARALLEL, both};
use crate::vectors::WIDTH;

/// The tree over `references`, down to what fits in a block.
pub(crate) fn build(references: &[Reference], leaves: Leaves) -> Tree {
    let count = references.len();
    let mut tree = Tree { nodes: vec![[0; 8]; places(count)], ids: vec![0; count] };
    if count > 0 {
        let keys = keys(references);
        let room = Room { nodes: &mut tree.nodes, ids: &mut tree.ids, leaves };
        Linear { references, place_bits: place_bits(count) }.subtree(&keys, room);
    }
    tree
}

/// How many bits of a key are for the place of its reference.
fn place_bits(count: usize) -> u32 {
    usize::BITS - (count - 1).leading_zeros()
}

/// Of each reference its code, and in the lowest bits its place; in order.
fn keys(references: &[Reference]) -> Vec<u64> {
    let place_bits = place_bits(references.len());
    // As many bits of each coordinate as the key has room for.
    let bits = ((u64::BITS - place_bits) / 3).min(21);
    let (_, middles) = extent(references);
    let (mut base, mut scale) = ([0.0_f32; 4], [0.0_f32; 4]);
    for axis in 0..3 {
        base[axis] = middles.min(axis);
        let cells = (1_u32 << bits) as f32;
        let factor = cells * (1.0 - f32::EPSILON) / (middles.max(axis) - middles.min(axis));
        scale[axis] = if factor.is_finite() { factor } else { 0.0 };
    }
    let key = |(place, reference): (u64, &Reference)| {
        let middle = Corners(*reference).twice_middle();
        let mut code = 0;
        for axis in 0..3 {
            let cell = (middle[axis] - base[axis]) * scale[axis];
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a whole number from zero on; saturates where it rounds beyond"
            )]
            let cell = (cell as u32).min((1 << bits) - 1);
            code |= spread(cell) << axis;
        }
        code << place_bits | place
    };
    let count = references.len();
    if count < PARALLEL {
        let mut keys: Vec<u64> = (0..).zip(references).map(key).collect();
        keys.sort_unstable();
        return keys;
    }
    let mut keys: Vec<u64> =
        (0..count).into_par_iter().map(|at| key((at as u64, &references[at]))).collect();
    // Any sort gives the same order, as no two keys are the same.
    keys.par_sort_unstable();
    keys
}

/// 21 bits, two zeros between each.
#[inline]
fn spread(cell: u32) -> u64 {
    let mut bits = u64::from(cell);
    bits = (bits | bits << 32) & 0x001f_0000_0000_ffff;
    bits = (bits | bits << 16) & 0x001f_0000_ff00_00ff;
    bits = (bits | bits << 8) & 0x100f_00f0_0f00_f00f;
    bits = (bits | bits << 4) & 0x10c3_0c30_c30c_30c3;
    (bits | bits << 2) & 0x1249_2492_4924_9249
}

struct Linear<'a> {
    references: &'a [Reference],
    place_bits: u32,
}

impl Linear<'_> {
    fn subtree(&self, keys: &[u64], room: Room<'_>) -> Built {
        let count = keys.len();
        if count <= WIDTH {
            return self.leaf(keys, room);
        }
        let on_left = self.split(keys);
        let (left_keys, right_keys) = keys.split_at(on_left);
        let leaves = room.leaves;
        let (root, left_room, right_room) = room.split(on_left);
        let (left, right) = both(
            count,
            || self.subtree(left_keys, left_room),
            || self.subtree(right_keys, right_room),
        );
        binary::join(leaves, root, on_left, &left, &right)
    }

    /// How many are on the left: as the highest bit has it that differs, or half, in whole
    /// blocks, where codes are the same.
    fn split(&self, keys: &[u64]) -> usize {
        let differ = (keys[0] ^ keys[keys.len() - 1]) >> self.place_bits << self.place_bits;
        if differ == 0 {
            return (keys.len() / 2).next_multiple_of(WIDTH);
        }
        let highest = 1 << (u64::BITS - 1 - differ.leading_zeros());
        keys.partition_point(|key| key & highest == 0)
    }

    fn leaf(&self, keys: &[u64], Room { nodes, ids, .. }: Room<'_>) -> Built {
        let places = (1_u64 << self.place_bits) - 1;
        let mut bounds = Corners::EMPTY;
        for (to, key) in ids.iter_mut().zip(keys) {
            let place = usize::try_from(key & places).expect("the place of a reference");
            let reference = &self.references[place];
            bounds.add(&Corners(*reference));
            *to = id(reference);
        }
        binary::leaf(&mut nodes[0], bounds, keys.len())
    }
}
