//! A part of the picture: what is seen at its pixels so far, and how triangles are drawn into it.

use trisect_core::Lanes;

use crate::blocks::BLOCK;
use crate::judge::Judge;
use crate::setup::{Affines, Spans};

/// Pixels across and down of a tile: what is kept of them fits into the first cache.
pub(crate) const TILE: [usize; 2] = [64, 32];

/// Room for a row: what lanes reach beyond its end.
pub(crate) const STRIDE: usize = TILE[0] + BLOCK;

/// What no triangle has for a number.
pub(crate) const NOTHING: u32 = u32::MAX;

/// A part of the picture.
pub(crate) struct Tile {
    /// Its first pixel.
    pub(crate) corner: [usize; 2],
    /// Pixels across and down.
    pub(crate) size: [usize; 2],
    /// Between which numbers the nearness of what is seen lies.
    pub(crate) low: Vec<f32>,
    pub(crate) high: Vec<f32>,
    /// The numbers of the triangles that are seen, as bits.
    pub(crate) seen: Vec<f32>,
    /// Pairs of a pixel and a triangle that were judged.
    pub(crate) judged: u64,
    /// Whether the last picture left anything here.
    is_clear: bool,
}

/// A triangle on its way to a tile.
#[derive(Clone, Copy)]
pub(crate) struct Drawn {
    /// The object, and the triangle's place there.
    pub(crate) object: usize,
    pub(crate) place: usize,
    /// Its number in the picture.
    pub(crate) number: u32,
}

impl Tile {
    pub(crate) fn new(corner: [usize; 2], size: [usize; 2]) -> Self {
        let room = STRIDE * TILE[1];
        let rows = || vec![0.0; room];
        let (low, high, seen) = (rows(), rows(), rows());
        Self { corner, size, low, high, seen, judged: 0, is_clear: false }
    }

    /// Forgets what is seen.
    pub(crate) fn clear(&mut self) {
        self.judged = 0;
        if !self.is_clear {
            self.low.fill(f32::NEG_INFINITY);
            self.high.fill(f32::NEG_INFINITY);
            self.seen.fill(f32::from_bits(NOTHING));
            self.is_clear = true;
        }
    }

    /// The number of the triangle that is seen at a pixel of the tile.
    #[inline]
    pub(crate) fn seen(&self, x: usize, y: usize) -> u32 {
        self.seen[y * STRIDE + x].to_bits()
    }

    /// Whether nothing is seen anywhere.
    pub(crate) fn is_clear(&self) -> bool {
        self.is_clear
    }

    /// The part of a span in the tile: first and last pixel across and down, from the tile's corner.
    #[inline(always)]
    fn part(&self, spans: &Spans, lane: usize) -> Option<[usize; 4]> {
        let [right, down, last_right, last_down] = spans;
        let (x0, y0) = (usize::from(right[lane]), usize::from(down[lane]));
        let (x1, y1) = (usize::from(last_right[lane]), usize::from(last_down[lane]));
        let ([x, y], [width, height]) = (self.corner, self.size);
        if x1 < x || y1 < y || x0 >= x + width || y0 >= y + height {
            return None;
        }
        let first = |from: usize, corner: usize| from.max(corner) - corner;
        Some([first(x0, x), first(y0, y), (x1 - x).min(width - 1), (y1 - y).min(height - 1)])
    }

    /// Draws a triangle of a block.
    #[inline(always)]
    pub(crate) fn draw<L: Lanes<Elem = f32>, const FILTERED: bool>(
        &mut self,
        token: L::Token,
        affines: &Affines,
        lane: usize,
        spans: &Spans,
        drawn: Drawn,
        judge: &Judge<'_>,
    ) {
        let Some(part) = self.part(spans, lane) else { return };
        if FILTERED && affines.sided >> lane & 1 == 0 {
            self.is_clear = false;
            let edges = (affines.bounded >> lane & 1 != 0).then_some(affines);
            return self.search(edges, lane, part, drawn, judge);
        }
        let [x0, y0, x1, y1] = part;
        let at = |affine: &[[f32; BLOCK]; 3]| [affine[0][lane], affine[1][lane], affine[2][lane]];
        let [a, b, c] = [at(&affines.edges[0]), at(&affines.edges[1]), at(&affines.edges[2])];
        let (bound, near) = (affines.bounds[0][lane], at(&affines.near));
        // From the middle of the picture.
        let left = (self.corner[0] + x0) as f32 + 0.5 - judge.half[0];
        let top = (self.corner[1] + y0) as f32 + 0.5 - judge.half[1];
        let (wide, high) = ((x1 - x0) as f32, (y1 - y0) as f32);
        if x1 - x0 >= BLOCK && y1 - y0 >= 4 {
            // Nowhere in the part, if it is not on the side of an edge where that is largest.
            let most = |[to, right, down]: [f32; 3]| {
                (to + right * left + down * top) + (right * wide).max(0.0) + (down * high).max(0.0)
            };
            let least = if FILTERED { -4.0 * bound } else { -bound };
            if most(a) < least || most(b) < least || most(c) < least {
                return;
            }
        }
        self.is_clear = false;
        let ramp = L::load(token, &RAMP);
        let number = L::splat(token, f32::from_bits(drawn.number));
        let (limit, error) =
            (L::splat(token, judge.limit), L::splat(token, affines.bounds[1][lane]));
        let (inside, outside) =
            (L::splat(token, if FILTERED { bound } else { 0.0 }), L::splat(token, -bound));
        let mut x = x0;
        while x <= x1 {
            let across = ramp + L::splat(token, (x - x0) as f32 + left);
            let a_row = across.mul_add(L::splat(token, a[1]), L::splat(token, a[0]));
            let b_row = across.mul_add(L::splat(token, b[1]), L::splat(token, b[0]));
            let c_row = across.mul_add(L::splat(token, c[1]), L::splat(token, c[0]));
            let near_row = across.mul_add(L::splat(token, near[1]), L::splat(token, near[0]));
            let (a_down, b_down, c_down) =
                (L::splat(token, a[2]), L::splat(token, b[2]), L::splat(token, c[2]));
            let near_down = L::splat(token, near[2]);
            let one = L::splat(token, 1.0);
            let mut down = L::splat(token, top);
            let mut place = y0 * STRIDE + x;
            let last = y1 * STRIDE + x;
            while place <= last {
                let least = down
                    .mul_add(a_down, a_row)
                    .min(down.mul_add(b_down, b_row))
                    .min(down.mul_add(c_down, c_row));
                if FILTERED {
                    let candidates = least.ge(outside);
                    if L::any(candidates) {
                        let nearness = down.mul_add(near_down, near_row);
                        let (low, high) = (nearness - error, nearness + error);
                        let old_low = L::load(token, &self.low[place..]);
                        let old_high = L::load(token, &self.high[place..]);
                        let kept = candidates & high.ge(old_low) & low.le(limit);
                        let wins = kept & least.gt(inside) & low.gt(old_high) & high.le(limit);
                        L::select(wins, low, old_low).store(&mut self.low[place..]);
                        L::select(wins, high, old_high).store(&mut self.high[place..]);
                        let old = L::load(token, &self.seen[place..]);
                        L::select(wins, number, old).store(&mut self.seen[place..]);
                        let open = L::bits(kept) & !L::bits(wins) & first_bits(x1 - x + 1);
                        if open != 0 {
                            let mut rows = [[0.0; 16]; 2];
                            low.store(&mut rows[0]);
                            high.store(&mut rows[1]);
                            judge.settle(self, place, open, &rows, drawn);
                        }
                    }
                } else {
                    let covered = least.ge(inside);
                    if L::any(covered) {
                        let nearness = down.mul_add(near_down, near_row);
                        let old_low = L::load(token, &self.low[place..]);
                        let wins = covered & nearness.gt(old_low) & nearness.le(limit);
                        L::select(wins, nearness, old_low).store(&mut self.low[place..]);
                        let old = L::load(token, &self.seen[place..]);
                        L::select(wins, number, old).store(&mut self.seen[place..]);
                    }
                }
                down = down + one;
                place += STRIDE;
            }
            x += L::N;
        }
    }

    /// Draws a triangle whose side is not known: judges every pixel that its edges do not rule out, if it has bounds
    /// at all.
    #[cold]
    #[inline(never)]
    fn search(
        &mut self,
        edges: Option<&Affines>,
        lane: usize,
        [x0, y0, x1, y1]: [usize; 4],
        drawn: Drawn,
        judge: &Judge<'_>,
    ) {
        let rows = [[f32::NEG_INFINITY; 16], [f32::INFINITY; 16]];
        for y in y0..=y1 {
            let down = (self.corner[1] + y) as f32 + 0.5 - judge.half[1];
            for x in x0..=x1 {
                let right = (self.corner[0] + x) as f32 + 0.5 - judge.half[0];
                let is_ruled_out = edges.is_some_and(|affines| {
                    let bound = affines.bounds[0][lane];
                    let at = |[to, across, along]: &[[f32; BLOCK]; 3]| {
                        right.mul_add(across[lane], to[lane]) + down * along[lane]
                    };
                    let [a, b, c] =
                        [at(&affines.edges[0]), at(&affines.edges[1]), at(&affines.edges[2])];
                    a.max(b).max(c) > bound && a.min(b).min(c) < -bound
                });
                if !is_ruled_out {
                    judge.settle(self, y * STRIDE + x, 1, &rows, drawn);
                }
            }
        }
    }
}

/// The numbers of lanes.
const RAMP: [f32; 16] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// So many bits.
#[inline(always)]
fn first_bits(count: usize) -> u64 {
    if count < 64 { (1 << count) - 1 } else { u64::MAX }
}
