//! Triangles made ready, eight at a time: where they may be in the picture, and what their edges and their depth
//! are as affine functions of the pixel, with bounds.
//!
//! `docs/derivations/raster.md` derives every formula and every bound here.

use trisect_core::{Lanes, Vec3};

use crate::blocks::{BLOCK, Block};
use crate::options::CullBy;
use crate::view::View;

/// A power of two.
const fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits((127 + exponent).cast_unsigned() << 23)
}

/// The unit roundoff, and what pays for the rounding of the bounds themselves and for underflow.
const U: f32 = power_of_two(-24) * SLACK;
const SLACK: f32 = 1.0 + power_of_two(-9);
/// An edge counts as no shorter than this: what underflow takes is nothing beside it.
const SHORTEST: f32 = power_of_two(-34);
/// Likewise for the distance of a corner.
const NEAREST: f32 = power_of_two(-20);
/// Triangles that are farther away or larger have no bounds: products may overflow.
const FARTHEST: f32 = power_of_two(30);

/// A view in all lanes.
#[derive(Clone, Copy)]
pub(crate) struct Eye<L> {
    o: Vec3<L>,
    g: [Vec3<L>; 3],
    dual: [Vec3<L>; 3],
    reach: L,
    error: L,
    margin: [L; 2],
    depth_error: L,
    half: [L; 2],
    /// 1 for a pinhole and 0 for parallel rays, and the other way round.
    is_central: L,
    is_parallel: L,
    /// The largest coordinate of the direction of parallel rays.
    direction: L,
}

#[inline(always)]
fn splat<L: Lanes<Elem = f32>>(token: L::Token, v: Vec3<f32>) -> Vec3<L> {
    Vec3::new(L::splat(token, v.x), L::splat(token, v.y), L::splat(token, v.z))
}

/// The corners of a block's triangles.
#[inline(always)]
fn corners<L: Lanes<Elem = f32>>(token: L::Token, block: &Block, at: usize) -> [Vec3<L>; 3] {
    [corner(token, block, at, 0), corner(token, block, at, 3), corner(token, block, at, 6)]
}

#[inline(always)]
fn corner<L: Lanes<Elem = f32>>(token: L::Token, block: &Block, at: usize, row: usize) -> Vec3<L> {
    let [x, y, z] = [&block.rows[row], &block.rows[row + 1], &block.rows[row + 2]];
    Vec3::new(L::load(token, &x[at..]), L::load(token, &y[at..]), L::load(token, &z[at..]))
}

impl<L: Lanes<Elem = f32>> Eye<L> {
    #[inline(always)]
    pub(crate) fn new(token: L::Token, view: &View) -> Self {
        let is_parallel = if view.is_parallel { 1.0 } else { 0.0 };
        let [g0, g1, g2] = view.g;
        let [d0, d1, d2] = view.dual;
        Self {
            o: splat(token, view.origin),
            g: [splat(token, g0), splat(token, g1), splat(token, g2)],
            dual: [splat(token, d0), splat(token, d1), splat(token, d2)],
            reach: L::splat(token, view.reach),
            error: L::splat(token, view.error),
            margin: [L::splat(token, view.margin[0]), L::splat(token, view.margin[1])],
            depth_error: L::splat(token, view.depth_error),
            half: [L::splat(token, view.half[0]), L::splat(token, view.half[1])],
            is_central: L::splat(token, 1.0 - is_parallel),
            is_parallel: L::splat(token, is_parallel),
            direction: L::splat(token, g0.largest_magnitude() * is_parallel),
        }
    }

    /// The ways from the origin to the corners.
    #[inline(always)]
    fn ways(&self, token: L::Token, block: &Block, at: usize) -> [Vec3<L>; 3] {
        let [a, b, c] = corners(token, block, at);
        [a - self.o, b - self.o, c - self.o]
    }

    /// The pixel of what is at the end of a way, from the middle of the picture, and its depth.
    #[inline(always)]
    fn project(&self, s: Vec3<L>) -> (L, L, L) {
        let z = s.dot(self.dual[0]) + self.is_parallel;
        let r = z.constant(1.0) / z;
        (s.dot(self.dual[1]) * r, s.dot(self.dual[2]) * r, z)
    }

    /// What is the same for all rays, and has the sign of the side of the triangle's plane that they come from, and
    /// what is affine: `T` and `det` of a pinhole, and the other way round.
    #[inline(always)]
    fn facing(&self, s: Vec3<L>, n: Vec3<L>) -> (L, L) {
        let (volume, det) = (s.dot(n), self.g[0].dot(n));
        let (central, parallel) = (self.is_central, self.is_parallel);
        (volume.mul_add(central, det * parallel), det.mul_add(central, volume * parallel))
    }

    /// By how much [`facing`](Eye::facing) may be off, twice.
    #[inline(always)]
    fn facing_bound(&self, distance: L, h: L) -> L {
        self.per_edge(distance) * (h * h) * self.o.x.constant(84.0 * U)
    }

    /// The largest coordinate of what edges are multiplied by.
    #[inline(always)]
    fn per_edge(&self, distance: L) -> L {
        distance.mul_add(self.is_central, self.direction)
    }
}

#[inline(always)]
fn largest<L: Lanes<Elem = f32>>([a, b, c]: [Vec3<L>; 3], least: f32) -> L {
    let all = a.largest_magnitude().max(b.largest_magnitude().max(c.largest_magnitude()));
    all.constant(least).max(all)
}

#[inline(always)]
fn edges<L: Lanes<Elem = f32>>([a, b, c]: [Vec3<L>; 3]) -> [Vec3<L>; 3] {
    [c - b, a - c, b - a]
}

/// Where the triangles of a block may be: of each the first pixel across, and down, and the last ones.
pub(crate) type Spans = [[u16; BLOCK]; 4];

/// Added to a number of less than 2²² and taken away again, it leaves a whole number.
const WHOLE: f32 = 1.5 * power_of_two(23);

/// The first whole number from here.
#[inline(always)]
fn up<L: Lanes<Elem = f32>>(x: L) -> L {
    let whole = (x + x.constant(WHOLE)) - x.constant(WHOLE);
    L::select(whole.lt(x), whole + x.constant(1.0), whole)
}

/// The last whole number up to here.
#[inline(always)]
fn down<L: Lanes<Elem = f32>>(x: L) -> L {
    let whole = (x + x.constant(WHOLE)) - x.constant(WHOLE);
    L::select(whole.gt(x), whole - x.constant(1.0), whole)
}

/// The pixels where the triangles of a block may be seen, and which may be seen at all, in bits.
#[inline(always)]
pub(crate) fn spans<L: Lanes<Elem = f32>>(
    token: L::Token,
    (view, eye): (&View, &Eye<L>),
    cull: CullBy,
    block: &Block,
    spans: &mut Spans,
) -> u32 {
    let mut rows = [[0.0_f32; BLOCK]; 4];
    let mut seen = 0_u64;
    let (zero, one) = (L::splat(token, 0.0), L::splat(token, 1.0));
    let last_right = L::splat(token, view.half[0] * 2.0 - 1.0);
    let last_down = L::splat(token, view.half[1] * 2.0 - 1.0);
    let is_known_at_all = L::splat(token, if view.is_invertible { 0.25 } else { f32::NAN });
    let mut at = 0;
    while at < BLOCK {
        let s = eye.ways(token, block, at);
        let distance = largest(s, NEAREST);
        let (x0, y0, z0) = eye.project(s[0]);
        let (x1, y1, z1) = eye.project(s[1]);
        let (x2, y2, z2) = eye.project(s[2]);
        let (nearest, farthest) = (z0.min(z1).min(z2), z0.max(z1).max(z2));
        let off = eye.margin[1] * distance;
        let is_bounded = distance.le(L::splat(token, FARTHEST));
        let is_known = off.le(nearest * is_known_at_all) & is_bounded & nearest.gt(zero);
        let mut hidden = farthest.lt(-(eye.depth_error * distance)) & is_bounded;
        if cull != CullBy::Nothing {
            let e = [s[1] - s[0], s[2] - s[0], s[2] - s[1]];
            let (n, h) = (e[0].cross(e[1]), largest(e, SHORTEST));
            let (facing, bound) = if cull == CullBy::Eye {
                (eye.facing(s[0], n).0, eye.facing_bound(distance, h))
            } else {
                (eye.g[0].dot(n), zero)
            };
            hidden = hidden | facing.ge(bound) & is_bounded & h.le(L::splat(token, FARTHEST));
        }
        let margin = off.mul_add(one / nearest, eye.margin[0]);
        let half = L::splat(token, 0.5);
        let (left, top) = (eye.half[0] - half, eye.half[1] - half);
        // The second operand is what is left of a NaN.
        let first_right = up(((x0.min(x1).min(x2) - margin) + left).max(zero));
        let first_down = up(((y0.min(y1).min(y2) - margin) + top).max(zero));
        let to_right = ((x0.max(x1).max(x2) + margin) + left).min(last_right);
        let to_down = ((y0.max(y1).max(y2) + margin) + top).min(last_down);
        let (to_right, to_down) = (down(to_right.max(-one)), down(to_down.max(-one)));
        let first_right = L::select(is_known, first_right, zero);
        let first_down = L::select(is_known, first_down, zero);
        let to_right = L::select(is_known, to_right, last_right);
        let to_down = L::select(is_known, to_down, last_down);
        first_right.store(&mut rows[0][at..]);
        first_down.store(&mut rows[1][at..]);
        to_right.store(&mut rows[2][at..]);
        to_down.store(&mut rows[3][at..]);
        let is_somewhere = first_right.le(to_right) & first_down.le(to_down);
        seen |= (L::bits(is_somewhere) & !L::bits(hidden)) << at;
        at += L::N;
    }
    if !view.is_bounded {
        seen = u64::MAX;
        for (row, last) in rows.iter_mut().zip([0.0, 0.0, view.half[0], view.half[1]]) {
            *row = [(last * 2.0 - 1.0_f32).max(0.0); BLOCK];
        }
    }
    for (to, row) in spans.iter_mut().zip(&rows) {
        let mut lane = 0;
        while lane < BLOCK {
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "of what is seen it is a pixel"
            )]
            {
                to[lane] = row[lane] as i32 as u16;
            }
            lane += 1;
        }
    }
    #[allow(clippy::cast_possible_truncation, reason = "there are eight")]
    let seen = seen as u32;
    seen & block.live
}

/// What eight triangles are as affine functions of the pixel.
pub(crate) struct Affines {
    /// For each edge at the middle of the picture, and by pixels right and down: not negative where a ray hits.
    pub(crate) edges: [[[f32; BLOCK]; 3]; 3],
    /// The nearness: the larger, the nearer. 1/t of a pinhole's rays, −t of parallel ones, up to what is the
    /// same for all triangles at a pixel.
    pub(crate) near: [[f32; BLOCK]; 3],
    /// By how much the edges may be off, and the nearness.
    pub(crate) bounds: [[f32; BLOCK]; 2],
    /// Triangles whose side is known, in bits: the signs of their edges are those of hits.
    pub(crate) sided: u32,
    /// Triangles that have bounds at all.
    pub(crate) bounded: u32,
}

impl Affines {
    pub(crate) const NONE: Self = Self {
        edges: [[[0.0; BLOCK]; 3]; 3],
        near: [[0.0; BLOCK]; 3],
        bounds: [[0.0; BLOCK]; 2],
        sided: 0,
        bounded: 0,
    };

    /// Those of a block.
    #[inline(always)]
    pub(crate) fn set<L: Lanes<Elem = f32>>(
        &mut self,
        token: L::Token,
        (view, eye): (&View, &Eye<L>),
        block: &Block,
    ) {
        let (mut sided, mut bounded) = (0_u64, 0_u64);
        let mut at = 0;
        while at < BLOCK {
            let s = eye.ways(token, block, at);
            let e = edges(corners(token, block, at));
            let (distance, h) = (largest(s, NEAREST), largest(e, SHORTEST));
            let n = e[1].cross(e[2]);
            let (facing, at_middle) = eye.facing(s[0], n);
            let reciprocal = L::splat(token, 1.0) / facing;
            let starts = [s[1], s[2], s[0]];
            let mut widest = L::splat(token, 0.0);
            let mut index = 0;
            while index < 3 {
                let (start, edge) = (starts[index], e[index]);
                // Parallel rays: the edge times the direction; else the way to the corner times the edge.
                let (m, middle) = if view.is_parallel {
                    let m = edge.cross(eye.g[0]);
                    (m, start.dot(m))
                } else {
                    let m = start.cross(edge);
                    (m, m.dot(eye.g[0]))
                };
                widest = widest.max(m.largest_magnitude());
                let [to, right, down] = &mut self.edges[index];
                middle.xor_sign(facing).store(&mut to[at..]);
                m.dot(eye.g[1]).xor_sign(facing).store(&mut right[at..]);
                m.dot(eye.g[2]).xor_sign(facing).store(&mut down[at..]);
                index += 1;
            }
            // 3·S is added to the reach of parallel rays.
            let reach = (distance * L::splat(token, 3.0)).mul_add(eye.is_parallel, eye.reach);
            let per_edge = eye.per_edge(distance);
            let of_evaluation = reach.mul_add(L::splat(token, 7.0 * U), eye.error);
            let of_normals = (h * per_edge) * (reach * L::splat(token, 8.0 * U));
            let bound = (widest * L::splat(token, SLACK)).mul_add(of_evaluation, of_normals);
            bound.store(&mut self.bounds[0][at..]);
            let signed = reciprocal.mul_add(eye.is_central, -(reciprocal * eye.is_parallel));
            let [to, right, down] = &mut self.near;
            (at_middle * signed).store(&mut to[at..]);
            (n.dot(eye.g[1]) * signed).store(&mut right[at..]);
            (n.dot(eye.g[2]) * signed).store(&mut down[at..]);
            let size = reciprocal.magnitude();
            let most = (n.largest_magnitude() * reach) * (size * L::splat(token, 2.0));
            let of_all =
                reach.mul_add(L::splat(token, 24.0 * U), eye.error * L::splat(token, 2.01));
            let numerators = (per_edge * L::splat(token, 42.0 * U)).mul_add(most, of_all);
            ((h * h) * size)
                .mul_add(numerators, most * L::splat(token, 4.0 * U))
                .store(&mut self.bounds[1][at..]);
            let is_bounded =
                distance.le(L::splat(token, FARTHEST)) & h.le(L::splat(token, FARTHEST));
            bounded |= L::bits(is_bounded) << at;
            let is_sided = is_bounded & facing.magnitude().ge(eye.facing_bound(distance, h));
            sided |= L::bits(is_sided) << at;
            at += L::N;
        }
        let all = if view.is_bounded { u64::MAX } else { 0 };
        #[allow(clippy::cast_possible_truncation, reason = "there are eight")]
        {
            self.sided = (sided & all) as u32;
            self.bounded = (bounded & all) as u32;
        }
    }
}
