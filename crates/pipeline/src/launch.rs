//! Launches: an entry point, run for every index of a buffer.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use trisect_tracer::Tracing;

use crate::buffer::Buffer;
use crate::programs::{Cells, Entry, On};
use crate::scene::Scene;
use crate::waves::{Answers, Flow, QueuesOf, RayTypes, Wave};

/// How a launch goes about its work. What comes of it does not depend on that, where `tracing` is [`Tracing::Single`] or
/// [`Tracing::Plain`].
#[derive(Clone, Copy)]
pub struct Launch<'a> {
    /// How the tracer goes through its trees.
    pub tracing: Tracing,
    /// Indices across and down of what a thread takes at a time, at least 1; as many in a row where there is one row.
    pub tile: u32,
    /// Set, it ends the work within a wave of rays.
    pub stop: Option<&'a AtomicBool>,
}

impl Default for Launch<'_> {
    /// Rays go singly, 64 by 64 at a time, and nothing stops them.
    fn default() -> Self {
        Self { tracing: Tracing::Single, tile: 64, stop: None }
    }
}

/// What came of a launch, beside what is in the buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Launched<A> {
    /// What was appended, in the order of indices.
    pub appended: Vec<A>,
    /// How many rays there were, of each type in its order.
    pub rays: Vec<u64>,
    /// Whether it was stopped: what is in the buffer is not complete then.
    pub is_stopped: bool,
}

/// Some indices that go together.
#[derive(Clone, Copy)]
struct Tile {
    start: [u32; 3],
    size: [u32; 3],
}

/// What was appended, each with the place of its index, and how many rays there were.
type OfTile<E> = (Vec<(usize, <E as Entry>::Append)>, Vec<u64>);

/// What a thread works with.
struct Room<E: Entry> {
    queues: QueuesOf<E>,
    out: Vec<E::Out>,
    answers: Answers,
}

impl<E: Entry> Default for Room<E> {
    fn default() -> Self {
        Self { queues: QueuesOf::<E>::default(), out: vec![], answers: Answers::default() }
    }
}

/// The tiles of a buffer.
fn tiles(size: [u32; 3], side: u32) -> Vec<Tile> {
    assert!(side > 0, "a tile has indices");
    let sides = match size {
        [_, 1, 1] => [side.saturating_mul(side), 1, 1],
        _ => [side, side, 1],
    };
    let starts = |axis: usize| (0..size[axis]).step_by(sides[axis] as usize);
    let mut tiles = vec![];
    for z in starts(2) {
        for y in starts(1) {
            tiles.extend(starts(0).map(|x| {
                let start = [x, y, z];
                let size = [0, 1, 2].map(|axis| sides[axis].min(size[axis] - start[axis]));
                Tile { start, size }
            }));
        }
    }
    tiles
}

impl<M: Send + Sync> Scene<M> {
    /// Runs an entry point for every index of a buffer, on the threads of the pool that it is called in. What an index has
    /// in the buffer is there when its programs run, so that launches may add to it.
    ///
    /// # Panics
    /// When a tile has no side.
    pub fn launch<E: Entry<Material = M>>(
        &self,
        entry: &E,
        launch: &Launch<'_>,
        buffer: &mut Buffer<E::Out>,
    ) -> Launched<E::Append> {
        let size = buffer.size();
        let cells = Mutex::new(buffer.cells_mut());
        // What threads work with, kept from tile to tile.
        let rooms = Mutex::new(Vec::<Room<E>>::new());
        let tiles = tiles(size, launch.tile);
        let done: Vec<OfTile<E>> = tiles
            .into_par_iter()
            .with_max_len(1)
            .map(|tile| {
                let mut room = lock(&rooms).pop().unwrap_or_default();
                room.out.clear();
                each_row(&lock(&cells), size, tile, |row| room.out.extend_from_slice(row));
                let of_tile = self.run(entry, launch, tile, size, &mut room);
                let mut out = &room.out[..];
                each_row_mut(&mut lock(&cells), size, tile, |row| {
                    let (own, rest) = out.split_at(row.len());
                    row.copy_from_slice(own);
                    out = rest;
                });
                lock(&rooms).push(room);
                of_tile
            })
            .collect();
        let is_stopped = is_set(launch.stop);
        let mut launched = Launched { appended: vec![], rays: vec![0; E::Rays::COUNT], is_stopped };
        let mut appended = vec![];
        for (of_tile, rays) in done {
            appended.extend(of_tile);
            launched.rays.iter_mut().zip(rays).for_each(|(all, own)| *all += own);
        }
        // Those of one index are of one tile, and stay in their order.
        appended.par_sort_by_key(|(at, _)| *at);
        launched.appended.extend(appended.into_iter().map(|(_, appended)| appended));
        launched
    }

    /// Runs an entry point for the indices of a tile.
    fn run<E: Entry<Material = M>>(
        &self,
        entry: &E,
        launch: &Launch<'_>,
        Tile { start, size }: Tile,
        all: [u32; 3],
        room: &mut Room<E>,
    ) -> OfTile<E> {
        let Room { queues, out, answers } = room;
        let mut rays = vec![0; E::Rays::COUNT];
        let caught = if E::CATCHES { vec![None; out.len()] } else { vec![] };
        let mut cells =
            Cells::<E> { out: std::mem::take(out), appended: vec![], caught, start, size, all };
        let mut slot = 0;
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let cells = &mut cells;
                    let on = &mut On { scene: self, queues, cells, slot, round: 0 };
                    entry.generate([start[0] + x, start[1] + y, start[2] + z], on);
                    slot += 1;
                }
            }
        }
        for round in 1.. {
            let wave = &mut Wave {
                entry,
                scene: self,
                tracing: launch.tracing,
                queues,
                cells: &mut cells,
                room: answers,
                round,
                rays: &mut rays,
            };
            if is_set(launch.stop) {
                // Rays that wait are forgotten.
                *queues = QueuesOf::<E>::default();
                break;
            }
            if !E::Rays::flow(wave) {
                break;
            }
        }
        for (out, caught) in cells.out.iter_mut().zip(&cells.caught) {
            if let Some(exception) = caught {
                entry.exception(*exception, out);
            }
        }
        *out = cells.out;
        (cells.appended, rays)
    }
}

fn is_set(stop: Option<&AtomicBool>) -> bool {
    stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
}

/// The rows of a tile among all cells.
fn rows(size: [u32; 3], tile: Tile) -> impl Iterator<Item = std::ops::Range<usize>> {
    let [x, y, z] = tile.start;
    (z..z + tile.size[2]).flat_map(move |z| {
        (y..y + tile.size[1]).map(move |y| {
            let start = Buffer::<()>::at(size, [x, y, z]);
            start..start + tile.size[0] as usize
        })
    })
}

fn each_row<T>(cells: &[T], size: [u32; 3], tile: Tile, mut take: impl FnMut(&[T])) {
    rows(size, tile).for_each(|row| take(&cells[row]));
}

fn each_row_mut<T>(cells: &mut [T], size: [u32; 3], tile: Tile, mut take: impl FnMut(&mut [T])) {
    rows(size, tile).for_each(|row| take(&mut cells[row]));
}

/// What a mutex holds; a panic elsewhere ends the launch anyway.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
