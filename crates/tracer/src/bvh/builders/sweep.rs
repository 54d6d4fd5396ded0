//! A few references: every split between two middles along an axis is tried.
//!
//! Wald, Boulos, Shirley: Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies. ACM
//! Transactions on Graphics 26, 2007, section 4 (the sweep); sorted once, as in Wald, Havran: On building
//! fast kd-Trees for Ray Tracing, and on doing that in O(N log N). IEEE Symposium on Interactive Ray
//! Tracing, 2006.

use super::binary::{self, Built, Room, Stored};
use super::corners::{Corners, Reference, id};
use super::settings::Leaves;
use crate::vectors::WIDTH;

/// How many references are few.
pub(crate) const FEW: usize = 64;

/// A few references, and their orders along each axis.
struct Few {
    corners: [Corners; FEW],
    orders: [[u8; FEW]; 3],
}

/// The tree over a few references, down to one each.
pub(crate) fn build(references: &[Reference], room: Room<'_>) -> Built {
    let Room { nodes, ids, leaves } = room;
    let count = references.len();
    let mut few = Few { corners: [Corners::EMPTY; FEW], orders: [[0; FEW]; 3] };
    for (corners, reference) in few.corners.iter_mut().zip(references) {
        *corners = Corners(*reference);
    }
    for (axis, order) in few.orders.iter_mut().enumerate() {
        let mut keys = [0_u64; FEW];
        for ((key, corners), place) in keys.iter_mut().zip(&few.corners[..count]).zip(0..) {
            *key = u64::from(ordered(corners.twice_middle()[axis])) << 8 | place;
        }
        keys[..count].sort_unstable();
        for (place, key) in order.iter_mut().zip(&keys) {
            #[allow(clippy::cast_possible_truncation, reason = "the place is in the lowest byte")]
            let lowest = *key as u8;
            *place = lowest;
        }
    }
    let built = few.subtree(leaves, 0, count, nodes);
    for (to, &place) in ids.iter_mut().zip(&few.orders[0][..count]) {
        *to = id(&references[usize::from(place)]);
    }
    built
}

/// Bits in the order of the numbers.
fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

impl Few {
    #[inline]
    fn at(&self, axis: usize, place: usize) -> &Corners {
        &self.corners[usize::from(self.orders[axis][place % FEW]) % FEW]
    }

    fn subtree(
        &mut self,
        leaves: Leaves,
        first: usize,
        count: usize,
        nodes: &mut [Stored],
    ) -> Built {
        if count == 1 {
            return binary::leaf(&mut nodes[0], *self.at(0, first), 1);
        }
        let on_left = if count == 2 { 1 } else { self.split(first, count) };
        let (root, below) = nodes.split_first_mut().expect("a subtree has a root");
        let (left, right) = below.split_at_mut(binary::places(on_left));
        let left = self.subtree(leaves, first, on_left, left);
        let right = self.subtree(leaves, first + on_left, count - on_left, right);
        binary::join(leaves, root, on_left, &left, &right)
    }

    /// Puts both sides of the cheapest split together in every order; how many are on the left.
    fn split(&mut self, first: usize, count: usize) -> usize {
        // Of equals the one in the middle, in whole blocks, so that copies of a triangle fill theirs.
        let middle = if count > WIDTH { (count / 2).next_multiple_of(WIDTH) } else { count / 2 };
        let mut best = (f32::INFINITY, 0, middle);
        for axis in 0..3 {
            let mut right = [0.0_f32; FEW];
            let mut corners = Corners::EMPTY;
            for place in (1..count).rev() {
                corners.add(self.at(axis, first + place));
                right[place % FEW] = corners.half_area() * (count - place) as f32;
            }
            let mut corners = Corners::EMPTY;
            for place in 1..count {
                corners.add(self.at(axis, first + place - 1));
                let cost = corners.half_area() * place as f32 + right[place % FEW];
                let nearer = place.abs_diff(middle) < best.2.abs_diff(middle);
                if cost < best.0 || cost == best.0 && nearer {
                    best = (cost, axis, place);
                }
            }
        }
        let (_, along, on_left) = best;
        let mut is_left = 0_u64;
        for &place in &self.orders[along][first..first + on_left] {
            is_left |= 1 << place;
        }
        for (axis, order) in self.orders.iter_mut().enumerate() {
            if axis != along {
                let from = *order;
                let (mut left, mut right) = (first, first + on_left);
                for &place in &from[first..first + count] {
                    let here = is_left >> place & 1 == 1;
                    order[if here { left } else { right } % FEW] = place;
                    left += usize::from(here);
                    right += usize::from(!here);
                }
            }
        }
        on_left
    }
}
