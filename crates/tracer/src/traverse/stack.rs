//! The traversal stack: what is still to be visited, the nearer above the farther.

use std::cell::RefCell;
use std::hint::select_unpredictable;

use crate::vectors::WIDTH;

/// The distance of an item in bits, and below it the item, so that keys are in the order of distances. Negative
/// distances are in no order; all of them are near enough.
#[inline(always)]
pub(crate) fn key(distance: f32, item: u32) -> u64 {
    u64::from(distance.to_bits()) << 32 | u64::from(item)
}

/// The distance in a [`key`].
#[allow(clippy::cast_possible_truncation, reason = "the upper half")]
#[inline(always)]
pub(crate) fn distance(key: u64) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

/// The item in a [`key`].
#[allow(clippy::cast_possible_truncation, reason = "the lower half")]
#[inline(always)]
pub(crate) fn item(key: u64) -> u32 {
    key as u32
}

/// Room for all children that may wait in a tree with so many nodes on the longest way down: seven for each node,
/// rounded up to a power of two.
pub(crate) fn room(depth: usize) -> usize {
    (depth * (WIDTH - 1) + WIDTH).next_power_of_two()
}

/// Room for the stack of any tree: builders halve what is below a depth of 48, so none is 145 deep.
pub(crate) const ROOM: usize = 1024;

thread_local! {
    /// Room that is cleared once for all rays of a thread.
    static ITEMS: RefCell<[u64; ROOM]> = const { RefCell::new([0; ROOM]) };
}

/// Does something with room for the stack of any tree. It must not ask for room again, so it calls nothing of a
/// caller's; what does [declares](declare_room) room of its own.
#[inline(always)]
pub(crate) fn with_room<T>(work: impl FnOnce(&mut [u64; ROOM]) -> T) -> T {
    ITEMS.with_borrow_mut(work)
}

/// Declares room for a stack, so many items or more, on the stack of the thread: nothing is allocated for a ray. Little
/// room is cleared sooner. The largest does for any tree. The middle one does for trees of up to seventeen nodes deep;
/// trees of millions of triangles are eleven.
macro_rules! declare_room {
    ($items:ident, $room:expr) => {
        let room: usize = $room;
        let (mut least, mut usual, mut largest);
        let $items: &mut [u64] = if room <= 32 {
            least = [0; 32];
            &mut least
        } else if room <= 128 {
            usual = [0; 128];
            &mut usual
        } else {
            assert!(room <= stack::ROOM, "builders bound the depth");
            largest = [0; stack::ROOM];
            &mut largest
        };
    };
}
pub(crate) use declare_room;

/// A stack whose room is a power of two that the tree cannot exceed, so that a mask does for a bounds check.
pub(crate) struct Stack<'a, T> {
    items: &'a mut [T],
    count: usize,
}

impl<'a, T: Copy> Stack<'a, T> {
    /// An empty one.
    pub(crate) fn new(items: &'a mut [T]) -> Self {
        Self { items, count: 0 }
    }

    /// How many items there are.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Removes all items.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, item: T) {
        self.push_if(true, item);
    }

    /// Pushes an item where `is_pushed`, without a branch.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, is_pushed: bool, item: T) {
        let mask = self.items.len() - 1;
        self.items[self.count & mask] = item;
        self.count += usize::from(is_pushed);
    }

    /// Inserts an item among those above `base`, which are in order, below those of smaller keys.
    #[inline(always)]
    pub(crate) fn insert(&mut self, base: usize, item: T, key: impl Fn(T) -> u64) {
        let mask = self.items.len() - 1;
        let mut at = self.count;
        while at > base && key(self.items[(at - 1) & mask]) < key(item) {
            self.items[at & mask] = self.items[(at - 1) & mask];
            at -= 1;
        }
        self.items[at & mask] = item;
        self.count += 1;
    }

    /// Pops the topmost item, or returns the given one instead, without a branch. There is an item, or one is
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
