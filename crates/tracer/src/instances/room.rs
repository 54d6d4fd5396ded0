//! Where hits of several instances are gathered: kept by each thread, so that no ray allocates.

use std::cell::Cell;

use crate::hit::TriangleHit;

/// A hit's `t`, the first id of its instance, and its place among those that were gathered.
pub(super) type Key = (f32, u32, u32);

/// Room for the hits of one tree over instances.
#[derive(Default)]
pub(super) struct Room {
    /// Of one instance.
    pub(super) found: Vec<TriangleHit>,
    pub(super) gathered: Vec<TriangleHit>,
    pub(super) keys: Vec<Key>,
}

thread_local! {
    /// Those that no ray uses now: one for each level of instances.
    static ROOMS: Cell<Vec<Room>> = const { Cell::new(Vec::new()) };
}

impl Room {
    /// Has something done with room, which is empty.
    pub(super) fn with<X>(work: impl FnOnce(&mut Self) -> X) -> X {
        let change = |change: &mut dyn FnMut(&mut Vec<Self>)| {
            let mut rooms = ROOMS.take();
            change(&mut rooms);
            ROOMS.set(rooms);
        };
        let mut room = Self::default();
        change(&mut |rooms| room = rooms.pop().unwrap_or_default());
        room.gathered.clear();
        room.keys.clear();
        let done = work(&mut room);
        change(&mut |rooms| rooms.push(std::mem::take(&mut room)));
        done
    }
}
