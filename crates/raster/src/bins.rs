//! Which triangles go to which tile.

use trisect_core::{Lanes, Token as _};
use trisect_tracer::Job;

use crate::blocks::{BLOCK, Object};
use crate::options::CullBy;
use crate::setup::{Eye, Spans, spans};
use crate::tile::TILE;
use crate::view::View;

/// Triangles of a block that go to a tile.
#[derive(Clone, Copy)]
pub(crate) struct Entry {
    pub(crate) object: u32,
    /// The block among those of the object, and the lanes in bits.
    pub(crate) block: u32,
    pub(crate) lanes: u32,
    /// Where the spans of the block are.
    pub(crate) spans: u32,
}

/// A share of all blocks, and the tiles that they go to. Its memory is kept from picture to picture.
#[derive(Default)]
pub(crate) struct Share {
    /// The first block, of all objects, and the one after the last.
    pub(crate) blocks: [usize; 2],
    pub(crate) spans: Vec<Spans>,
    pub(crate) bins: Vec<Vec<Entry>>,
}

/// Fills a share.
pub(crate) struct Fill<'a> {
    pub(crate) share: &'a mut Share,
    pub(crate) objects: &'a [Object],
    pub(crate) views: &'a [View],
    pub(crate) cull: CullBy,
    /// Tiles across and down.
    pub(crate) tiles: [usize; 2],
}

impl Job for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        token.run(
            #[inline(always)]
            || fill::<L>(token, self),
        );
    }
}

#[inline(always)]
#[allow(clippy::cast_possible_truncation, reason = "blocks are numbered in u32")]
fn fill<L: Lanes<Elem = f32>>(token: L::Token, job: Fill<'_>) {
    let Fill { share, objects, views, cull, tiles } = job;
    let [mut start, end] = share.blocks;
    // Each is written over.
    share.spans.resize(end - start, [[0; BLOCK]; 4]);
    share.bins.resize_with(tiles[0] * tiles[1], Vec::new);
    for bin in &mut share.bins {
        bin.clear();
    }
    let (mut before, mut place) = (0, 0);
    for (number, (object, view)) in objects.iter().zip(views).enumerate() {
        let blocks = &object.triangles().blocks;
        let eye = Eye::<L>::new(token, view);
        while start < end && start < before + blocks.len() {
            let block = start - before;
            let seen =
                spans::<L>(token, (view, &eye), cull, &blocks[block], &mut share.spans[place]);
            let entry =
                Entry { object: number as u32, block: block as u32, lanes: 0, spans: place as u32 };
            put(&mut share.bins, tiles[0], entry, seen, &share.spans[place]);
            start += 1;
            place += 1;
        }
        before += blocks.len();
    }
}

/// Puts the triangles of a block that are seen into the bins of all tiles that they may be in.
#[inline(always)]
fn put(bins: &mut [Vec<Entry>], across: usize, entry: Entry, mut seen: u32, spans: &Spans) {
    while seen != 0 {
        let lane = seen.trailing_zeros() as usize % BLOCK;
        seen &= seen - 1;
        let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|row| usize::from(spans[row][lane]));
        for y in y0 / TILE[1]..=y1 / TILE[1] {
            for x in x0 / TILE[0]..=x1 / TILE[0] {
                let bin = &mut bins[y * across + x];
                match bin.last_mut() {
                    Some(last) if last.spans == entry.spans => last.lanes |= 1 << lane,
                    _ => bin.push(Entry { lanes: 1 << lane, ..entry }),
                }
            }
        }
    }
}
