//! What waits to be visited on the way down, the nearer above the farther.

use std::hint::select_unpredictable;

use crate::bvh::WIDTH;

/// A place with its distance in front, so that numbers are in the order of distances: of those that are
/// not negative; the others are near enough to be in any order.
#[inline(always)]
pub(crate) fn key(distance: f32, place: u32) -> u64 {
    u64::from(distance.to_bits()) << 32 | u64::from(place)
}

/// The distance in a [`key`].
#[allow(clippy::cast_possible_truncation, reason = "the upper half")]
#[inline(always)]
pub(crate) fn distance(key: u64) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

/// The place in a [`key`].
#[allow(clippy::cast_possible_truncation, reason = "the lower half")]
#[inline(always)]
pub(crate) fn place(key: u64) -> u32 {
    key as u32
}

/// Room for all children that may wait for a visit at a time in a tree of so many nodes on the way down: a
/// power of two, seven for each.
pub(crate) fn room(depth: usize) -> usize {
    (depth * (WIDTH - 1) + WIDTH).next_power_of_two()
}

/// A stack whose room is a power of two that the tree cannot exceed, so that a place is found by a mask.
pub(crate) struct Stack<'a, T> {
    items: &'a mut [T],
    count: usize,
}

impl<'a, T: Copy> Stack<'a, T> {
    /// An empty one.
    pub(crate) fn new(items: &'a mut [T]) -> Self {
        Self { items, count: 0 }
    }

    /// How many wait.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Nothing waits any more.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, item: T) {
        self.push_if(true, item);
    }

    /// Pushes an item, or does not, without a branch.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, is_pushed: bool, item: T) {
        let mask = self.items.len() - 1;
        self.items[self.count & mask] = item;
        self.count += usize::from(is_pushed);
    }

    /// Puts an item below those above `base`, which are in order, whose keys are less.
    #[inline(always)]
    pub(crate) fn insert(&mut self, base: usize, item: T, key: impl Fn(T) -> u64) {
        let mask = self.items.len() - 1;
        let mut place = self.count;
        while place > base && key(self.items[(place - 1) & mask]) < key(item) {
            self.items[place & mask] = self.items[(place - 1) & mask];
            place -= 1;
        }
        self.items[place & mask] = item;
        self.count += 1;
    }

    /// Pops the topmost item, or gives that one back instead, without a branch. Something waits, or is
    /// given.
    #[inline(always)]
    pub(crate) fn pop_unless(&mut self, is_given: bool, given: T) -> T {
        let mask = self.items.len() - 1;
        let below = self.count.wrapping_sub(1);
        let top = self.items[below & mask];
        self.count = select_unpredictable(is_given, self.count, below);
        select_unpredictable(is_given, given, top)
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        if self.count == 0 {
            return None;
        }
        self.count -= 1;
        let mask = self.items.len() - 1;
        Some(self.items[self.count & mask])
    }
}
