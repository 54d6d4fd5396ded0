//! Bounds of the rays of a packet that go together: an interval for each coordinate of their origins and inverse
//! directions, which tests boxes for all of them at once.
//!
//! Boulos, Wald, Shirley: Geometric and Arithmetic Culling Methods for Entire Ray Packets. University of
//! Utah, UUCS-06-10, 2006.

use trisect_core::{Lanes, Vec3};

use super::batch::{RAYS, RayBatch};
use super::slabs::{margin, within};
use crate::bvh::node::Node;
use crate::vectors::{WIDTH, least, splat};

/// The octant of directions: along each axis, which end of a box is nearer.
#[derive(Clone, Copy)]
pub(crate) struct Octant([usize; 3]);

impl Octant {
    /// That of an inverse direction.
    #[inline(always)]
    pub(crate) fn of(inverse: Vec3<f32>) -> Self {
        let Vec3 { x, y, z } = inverse;
        Self([usize::from(x < 0.0), usize::from(y < 0.0), usize::from(z < 0.0)])
    }

    /// The nearer and the farther planes of as many boxes as there are lanes, from box `lane` on.
    #[inline(always)]
    pub(crate) fn planes<L: Lanes<Elem = f32>>(
        self,
        token: L::Token,
        node: &Node,
        lane: usize,
    ) -> (Vec3<L>, Vec3<L>) {
        let near = self.0;
        let far = [near[0] ^ 1, near[1] ^ 1, near[2] ^ 1];
        (node.planes(token, near, lane), node.planes(token, far, lane))
    }
}

/// Bounds of rays, see the module.
pub(crate) struct PacketBounds {
    /// The rays, in bits.
    pub(crate) rays: u64,
    /// Their octant.
    pub(crate) octant: Octant,
    /// The ends of the interval of origins: from which nearer planes are nearest, and farther planes farthest.
    nearest: Vec3<f32>,
    farthest: Vec3<f32>,
    /// The ends of the interval of inverse directions, of smaller and of larger magnitude.
    small: Vec3<f32>,
    large: Vec3<f32>,
    /// How far sides are moved outwards.
    margin: Vec3<f32>,
    tmin: f32,
    /// Where the last of their intervals ends.
    pub(crate) tmax: f32,
}

impl PacketBounds {
    /// Of those of some rays, in bits, whose directions are in the octant of the first of them: of that ray alone,
    /// where its inverse is NaN along an axis.
    #[inline(always)]
    pub(crate) fn new<L: Lanes<Elem = f32>>(
        token: L::Token,
        batch: &RayBatch,
        some: u64,
        reach: f32,
    ) -> Self {
        let zero = L::splat(token, 0.0);
        let first = some.trailing_zeros() as usize;
        let octant_of = batch.slabs::<L>(token, first).inverse;
        let infinite = zero.constant(f32::INFINITY);
        let none = Vec3 { x: infinite, y: infinite, z: infinite };
        // Numbers and their negatives, so that only least numbers are sought.
        let (mut o, mut minus_o, mut r, mut minus_r) = (none, none, none, none);
        let (mut tmin, mut minus_tmax) = (infinite, infinite);
        let (mut rays, mut at) = (0, 0);
        while at < RAYS {
            let origins = batch.many_origins::<L>(token, at);
            let inverse = batch.many_slabs::<L>(token, at).inverse;
            let interval = batch.many_intervals::<L>(token, at);
            let here = inverse.x.xor_sign(octant_of.x).ge(zero)
                & inverse.y.xor_sign(octant_of.y).ge(zero)
                & inverse.z.xor_sign(octant_of.z).ge(zero)
                & interval.0.le(interval.1);
            rays |= L::bits(here) << at;
            o = lesser(o, origins, here);
            minus_o = lesser(minus_o, -origins, here);
            r = lesser(r, inverse, here);
            minus_r = lesser(minus_r, -inverse, here);
            tmin = L::select(here, tmin.min(interval.0), tmin);
            minus_tmax = L::select(here, minus_tmax.min(-interval.1), minus_tmax);
            at += L::N;
        }
        if rays & some == 0 {
            return Self::of_one(batch, first, reach);
        }
        let (o_min, o_max) = (across(o), -across(minus_o));
        let (r_min, r_max) = (across(r), -across(minus_r));
        let (x, y, z) = (r_min.x < 0.0, r_min.y < 0.0, r_min.z < 0.0);
        let pick = |a: Vec3<f32>, b: Vec3<f32>| {
            Vec3::new(
                if x { a.x } else { b.x },
                if y { a.y } else { b.y },
                if z { a.z } else { b.z },
            )
        };
        let large = pick(r_min, r_max);
        Self {
            rays: rays & some,
            octant: Octant::of(r_min),
            nearest: pick(o_min, o_max),
            farthest: pick(o_max, o_min),
            small: pick(r_max, r_min),
            large,
            margin: margin(reach, o_min.largest_magnitude().max(o_max.largest_magnitude()), large),
            tmin: least(tmin),
            tmax: -least(minus_tmax),
        }
    }

    /// Of one ray.
    fn of_one(batch: &RayBatch, index: usize, reach: f32) -> Self {
        let inverse = batch.slabs::<f32>((), index).inverse;
        let (tmin, tmax) = batch.interval::<f32>((), index);
        let o = batch.ray(index).o;
        Self {
            rays: 1 << index,
            octant: Octant::of(inverse),
            nearest: o,
            farthest: o,
            small: inverse,
            large: inverse,
            margin: margin(reach, o.largest_magnitude(), inverse),
            tmin,
            tmax,
        }
    }

    /// The children whose boxes any of the rays may meet, in bits, and the least distance at which one may enter
    /// each.
    #[inline(always)]
    pub(crate) fn meet<L: Lanes<Elem = f32>>(
        &self,
        token: L::Token,
        node: &Node,
        distances: &mut [f32; WIDTH],
    ) -> u64 {
        let (nearest, farthest) =
            (splat::<L>(token, self.nearest), splat::<L>(token, self.farthest));
        let (small, large) = (splat::<L>(token, self.small), splat::<L>(token, self.large));
        let margin = splat::<L>(token, self.margin);
        let interval = (L::splat(token, self.tmin), L::splat(token, self.tmax));
        let (mut met, mut lane) = (0, 0);
        while lane < WIDTH {
            let (near, far) = self.octant.planes::<L>(token, node, lane);
            let (near, far) = (near - nearest, far - farthest);
            let near = Vec3::new(
                least_product(near.x, small.x, large.x),
                least_product(near.y, small.y, large.y),
                least_product(near.z, small.z, large.z),
            );
            let far = Vec3::new(
                largest_product(far.x, small.x, large.x),
                largest_product(far.y, small.y, large.y),
                largest_product(far.z, small.z, large.z),
            );
            // Always robust: this rounds what the tests of single rays do not round.
            let (from, to) = within(near - margin, far + margin, interval);
            met |= L::bits(from.le(to)) << lane;
            from.store(&mut distances[lane..]);
            lane += L::N;
        }
        met
    }

    /// Updates where the last of the intervals ends.
    #[inline(always)]
    pub(crate) fn shorten<L: Lanes<Elem = f32>>(&mut self, token: L::Token, batch: &RayBatch) {
        let (mut minus_tmax, mut at) = (L::splat(token, f32::INFINITY), 0);
        while at < RAYS {
            let (_, tmax) = batch.many_intervals::<L>(token, at);
            minus_tmax = (-tmax).min(minus_tmax);
            at += L::N;
        }
        self.tmax = -least(minus_tmax);
    }
}

/// The least product with a number between two of one sign.
#[inline(always)]
fn least_product<L: Lanes>(x: L, small: L, large: L) -> L {
    (x * small).min(x * large)
}

/// The largest one, likewise.
#[inline(always)]
fn largest_product<L: Lanes>(x: L, small: L, large: L) -> L {
    (x * small).max(x * large)
}

/// The lesser coordinates, in those lanes that count.
#[inline(always)]
fn lesser<L: Lanes>(so_far: Vec3<L>, v: Vec3<L>, counts: L::Mask) -> Vec3<L> {
    Vec3::new(
        L::select(counts, so_far.x.min(v.x), so_far.x),
        L::select(counts, so_far.y.min(v.y), so_far.y),
        L::select(counts, so_far.z.min(v.z), so_far.z),
    )
}

/// The least of all lanes, coordinate by coordinate.
#[inline(always)]
fn across<L: Lanes<Elem = f32>>(v: Vec3<L>) -> Vec3<f32> {
    Vec3::new(least(v.x), least(v.y), least(v.z))
}
