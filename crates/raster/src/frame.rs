//! The rasteriser: from triangles to what is seen at each pixel.

use std::marker::PhantomData;

use prefetch_index::prefetch_index;
use rayon::prelude::*;
use trisect_core::{Lanes, Ray, Token as _};
use trisect_method::Culling;
use trisect_scene::PixelRays;
use trisect_tracer::{Job, TriangleHit, on_lanes};

use crate::bins::{Entry, Fill, Share};
use crate::blocks::{BLOCK, Object};
use crate::judge::{Judge, locate, values};
use crate::options::{CullBy, Culls, Edges, Filtered, NoCulling};
use crate::setup::{Affines, Eye, Spans};
use crate::tile::{Drawn, NOTHING, STRIDE, TILE, Tile};
use crate::view::View;

/// Shares of all triangles for each thread.
const SHARES: usize = 4;

/// Finds what is seen at each pixel of a picture. Its memory is kept from picture to picture: once it has
/// room, a picture allocates nothing.
///
/// [`Filtered`] it is what the exact caster sees; what it sees does not depend on the number of threads.
pub struct Rasteriser<C = NoCulling, E = Filtered> {
    size: [u32; 2],
    tiles: Vec<Tile>,
    shares: Vec<Share>,
    views: Vec<View>,
    firsts: Vec<u32>,
    options: PhantomData<(C, E)>,
}

/// Compiled here, once, not by whoever names a type of rasteriser and with the optimisation of that.
#[inline(never)]
fn fill_share(job: Fill<'_>) {
    on_lanes(job);
}

/// The same.
#[inline(never)]
fn scan_tile(is_filtered: bool, job: ScanTile<'_>) {
    if is_filtered {
        on_lanes(Scanned::<true>(job));
    } else {
        on_lanes(Scanned::<false>(job));
    }
}

impl<C: Culls, E: Edges> Default for Rasteriser<C, E> {
    fn default() -> Self {
        Self::new()
    }
}

impl<C: Culls, E: Edges> Rasteriser<C, E> {
    /// Without memory yet.
    pub fn new() -> Self {
        Self {
            size: [0, 0],
            tiles: Vec::new(),
            shares: Vec::new(),
            views: Vec::new(),
            firsts: Vec::new(),
            options: PhantomData,
        }
    }

    /// Finds what is seen of some objects, on the threads of the pool that it is called in. Triangles are numbered
    /// through all objects, one after another.
    ///
    /// Whether it did: not where the camera has a lens, through all of which rays go.
    ///
    /// # Panics
    /// When there are 2³² triangles or more, or more than 65,536 pixels across or down.
    pub fn draw(&mut self, objects: &[Object], rays: &PixelRays) -> bool {
        self.views.clear();
        self.firsts.clear();
        let (mut blocks, mut triangles) = (0, 0_u32);
        for object in objects {
            let Some(view) = View::new(rays, object.transform()) else { return false };
            self.views.push(view);
            self.firsts.push(triangles);
            let own = object.triangles();
            blocks += own.blocks.len();
            triangles = u32::try_from(own.len())
                .ok()
                .and_then(|count| triangles.checked_add(count))
                .expect("triangles are counted in u32");
        }
        self.resize(rays.size());
        let across = (self.size[0] as usize).div_ceil(TILE[0]);
        let tiles = [across, self.tiles.len() / across];
        let threads = rayon::current_num_threads();
        let count = if threads == 1 { 1 } else { threads * SHARES };
        self.shares.resize_with(count, Share::default);
        for (number, share) in self.shares.iter_mut().enumerate() {
            share.blocks = [number, number + 1].map(|part| blocks * part / count);
        }
        let views = &self.views;
        let fill = |share: &mut Share| {
            fill_share(Fill { share, objects, views, cull: C::BY, tiles });
        };
        let judge = Judge {
            objects,
            firsts: &self.firsts,
            rays,
            culling: if C::BY == CullBy::Eye { Culling::Back } else { Culling::None },
            half: self.size.map(|side| side as f32 / 2.0),
            limit: if views.first().is_some_and(|view| view.is_parallel) {
                0.0
            } else {
                f32::INFINITY
            },
        };
        let scan = |shares: &[Share], number: usize, tile: &mut Tile| {
            scan_tile(
                E::FILTERED,
                ScanTile { shares, number, tile, objects, views, judge: &judge },
            );
        };
        if threads == 1 {
            self.shares.iter_mut().for_each(fill);
            let shares = &self.shares;
            self.tiles.iter_mut().enumerate().for_each(|(number, tile)| scan(shares, number, tile));
        } else {
            self.shares.par_iter_mut().for_each(fill);
            let shares = &self.shares;
            let tiles = self.tiles.par_iter_mut().enumerate();
            tiles.for_each(|(number, tile)| scan(shares, number, tile));
        }
        true
    }

    fn resize(&mut self, size: [u32; 2]) {
        if self.size == size {
            return;
        }
        assert!(size.iter().all(|side| (1..=65_536).contains(side)), "a picture of {size:?}");
        self.size = size;
        let [width, height] = size.map(|side| side as usize);
        self.tiles.clear();
        for y in (0..height).step_by(TILE[1]) {
            for x in (0..width).step_by(TILE[0]) {
                let size = [TILE[0].min(width - x), TILE[1].min(height - y)];
                self.tiles.push(Tile::new([x, y], size));
            }
        }
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    pub(crate) fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    pub(crate) fn firsts(&self) -> &[u32] {
        &self.firsts
    }

    /// The number of the triangle that is seen at a pixel.
    ///
    /// # Panics
    /// When the picture has no such pixel.
    pub fn seen(&self, [x, y]: [u32; 2]) -> Option<u32> {
        let [x, y] = [x as usize, y as usize];
        let across = (self.size[0] as usize).div_ceil(TILE[0]);
        let tile = &self.tiles[y / TILE[1] * across + x / TILE[0]];
        let seen = tile.seen(x % TILE[0], y % TILE[1]);
        (seen != NOTHING).then_some(seen)
    }

    /// The object that a triangle belongs to, and its place there.
    ///
    /// # Panics
    /// When nothing was drawn.
    pub fn locate(&self, number: u32) -> (usize, usize) {
        locate(&self.firsts, number)
    }

    /// How many pairs of a pixel and a triangle exact arithmetic decided.
    pub fn judged(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.judged).sum()
    }

    /// What the caster's rays hit, row by row: triangles as they are numbered, and values of exact arithmetic,
    /// rounded once. The objects and the rays must be those that were drawn.
    pub fn hits(&self, objects: &[Object], rays: &PixelRays) -> Vec<Option<TriangleHit>> {
        let [width, height] = self.size;
        let rows = (0..height).into_par_iter().flat_map_iter(|y| {
            (0..width).map(move |x| {
                let number = self.seen([x, y])?;
                let (object, place) = self.locate(number);
                let object = &objects[object];
                let (o, d) = rays.ray([x, y]);
                let ray = Ray { o: o.into(), d: d.into(), tmin: 0.0, tmax: f32::INFINITY };
                let hit = values(&object.carry(&ray), &object.triangles().triangle(place));
                Some(TriangleHit { triangle: number, hit })
            })
        });
        rows.collect()
    }
}

/// Blocks are fetched while so many before them are drawn.
const AHEAD: usize = 3;

/// Fetches what a block's triangles are drawn from, line by line.
#[inline(always)]
fn fetch(objects: &[Object], spans: &[Spans], entry: &Entry) {
    prefetch_index(spans, entry.spans as usize);
    let rows = &objects[entry.object as usize].triangles().blocks[entry.block as usize].rows;
    for row in [0, 2, 4, 6, 8] {
        prefetch_index(rows, row);
    }
}

/// Draws what there is in a tile.
struct ScanTile<'a> {
    shares: &'a [Share],
    number: usize,
    tile: &'a mut Tile,
    objects: &'a [Object],
    views: &'a [View],
    judge: &'a Judge<'a>,
}

/// The same, filtered or bare.
struct Scanned<'a, const FILTERED: bool>(ScanTile<'a>);

impl<const FILTERED: bool> Job for Scanned<'_, FILTERED> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        token.run(
            #[inline(always)]
            || scan::<L, FILTERED>(token, self.0),
        );
    }
}

#[inline(always)]
#[allow(clippy::cast_possible_truncation, reason = "triangles are numbered in u32")]
fn scan<L: Lanes<Elem = f32>, const FILTERED: bool>(token: L::Token, job: ScanTile<'_>) {
    let ScanTile { shares, number, tile, objects, views, judge } = job;
    tile.clear();
    let mut affines = Affines::NONE;
    let mut last = usize::MAX;
    let mut eye = None;
    for share in shares {
        let bin = &share.bins[number];
        for (at, entry) in bin.iter().enumerate() {
            if let Some(next) = bin.get(at + AHEAD) {
                fetch(objects, &share.spans, next);
            }
            let object = entry.object as usize;
            if object != last {
                eye = Some(Eye::<L>::new(token, &views[object]));
                last = object;
            }
            let Some(eye) = &eye else { continue };
            let view = &views[object];
            let block = entry.block as usize;
            affines.set::<L>(token, (view, eye), &objects[object].triangles().blocks[block]);
            let spans = &share.spans[entry.spans as usize];
            let mut lanes = entry.lanes;
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize % BLOCK;
                lanes &= lanes - 1;
                let place = block * BLOCK + lane;
                let number = judge.firsts[object] + place as u32;
                let drawn = Drawn { object, place, number };
                tile.draw::<L, FILTERED>(token, &affines, lane, spans, drawn, judge);
            }
        }
    }
}

const _: () = assert!(STRIDE >= TILE[0] + BLOCK);
