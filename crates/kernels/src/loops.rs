//! The loops around a method: every ray against every triangle, in four arrangements.
#![allow(
    clippy::redundant_closure,
    reason = "the call of a reference to a closure, `&mut found`, would stay out of line"
)]

use crate::prepared::{BLOCK, Packet, Packets, PreparedTriangles, turning_axis};
use trisect_core::Lanes;
use trisect_core::{Hit, Ray};
use trisect_method::{Culling, Division, Interval};
use trisect_method::{Method, RayParts};
use trisect_method::{Of, Record};

/// Packets that are tested against a triangle while what they share is at hand.
const BUNDLE: usize = 16;

/// The vector of pairs that a test is about.
pub struct Tested<'a, M: Method, L: Lanes> {
    /// The place of the first lane's ray, see [`Packets::number`]; 0 where there is one ray.
    pub ray_place: usize,
    /// The place of the first lane's triangle, see [`PreparedTriangles::number`].
    pub triangle_place: usize,
    /// The rays, as the method sees them: with the axis renamed for one that turns space.
    pub ray: &'a Ray<L>,
    /// The triangles, likewise: a normal that is taken from them has the axes renamed, too.
    pub triangle: &'a Of<M::Prepared, L>,
    /// The kind of the triangles.
    pub group: usize,
}

/// Calls `$body` with the constant `$axis` that method `$M` renames to the last for a run-time
/// `$value`: three instances for a method that turns space, one for all others.
macro_rules! for_axis {
    ($M:ty, $value:expr, |$axis:ident| $body:expr) => {
        if const { <$M>::TURNS } {
            match $value {
                0 => {
                    const $axis: usize = 0;
                    $body
                }
                1 => {
                    const $axis: usize = 1;
                    $body
                }
                _ => {
                    const $axis: usize = 2;
                    $body
                }
            }
        } else {
            const $axis: usize = 2;
            $body
        }
    };
}

/// Tests one ray against every triangle: the ray in all lanes, N triangles at a time.
///
/// `found` is called for each vector with a hit, or for every vector where `D` has no early-out.
#[inline(always)]
pub fn one_ray<M: Method, L: Lanes, D: Division>(
    token: L::Token,
    ray: &Ray<L::Elem>,
    triangles: &PreparedTriangles<M, L::Elem>,
    culling: Culling,
    mut found: impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
) {
    one_ray_until::<M, L, D>(
        token,
        ray,
        triangles,
        culling,
        #[inline(always)]
        |tested, mask, hit| {
            found(tested, mask, hit);
            None
        },
    );
}

/// [`one_ray`] for who looks for the first hit: where `found` gives a number, the interval ends there
/// from then on.
#[inline(always)]
pub fn one_ray_until<M: Method, L: Lanes, D: Division>(
    token: L::Token,
    ray: &Ray<L::Elem>,
    triangles: &PreparedTriangles<M, L::Elem>,
    culling: Culling,
    mut found: impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>) -> Option<L::Elem>,
) {
    let axis = turning_axis::<M, L::Elem>(ray);
    for_axis!(M, axis, |AXIS| one_ray_along::<M, L, D, AXIS>(
        token, ray, triangles, culling, &mut found
    ));
}

// The loops borrow `found`: what is passed by value is dropped when a call in the loop panics, which is code around
// each of a thousand calls, and takes longer to compile than the test.
#[inline(always)]
fn one_ray_along<M: Method, L: Lanes, D: Division, const AXIS: usize>(
    token: L::Token,
    ray: &Ray<L::Elem>,
    triangles: &PreparedTriangles<M, L::Elem>,
    culling: Culling,
    found: &mut impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>) -> Option<L::Elem>,
) {
    let ray = Ray::<L>::splat(token, ray).with_axis_last(AXIS);
    let mut interval = Interval::of(&ray);
    for (group, places) in triangles.groups().iter().enumerate() {
        let prepared = M::prepare_ray(&ray, group);
        let blocks = triangles.blocks(places);
        // One loop, not two: a loop over the vectors of a block would be unrolled, and its
        // vectors interleaved until they spill. It steps from block to block, since dividing a place
        // into block and lane, and checking the block's bounds, costs a vector up to a tenth.
        let mut rest = blocks.iter();
        let mut current = rest.next();
        let (mut place, mut lane) = (places.start, 0);
        while let Some(block) = current {
            let triangle = block.lanes::<L>(token, lane);
            let triangle = M::Prepared::with_axis_last(&triangle, AXIS);
            lane = (lane + L::N) % BLOCK;
            if lane == 0 {
                current = rest.next();
            }
            let triangle_place = place;
            place += L::N;
            let mut end = None;
            M::test::<L, D>(
                &prepared,
                &triangle,
                interval,
                culling,
                #[inline(always)]
                |mask, hit| {
                    let (ray, triangle) = (&ray, &triangle);
                    let tested = Tested { ray_place: 0, triangle_place, ray, triangle, group };
                    end = (*found)(tested, mask, hit);
                },
            );
            if let Some(end) = end {
                interval.tmax = L::splat(token, end);
            }
        }
    }
}

/// Tests every ray of the packets against every triangle: the triangle in all lanes, N rays at a
/// time, which stay at hand while the triangles go by.
///
/// `found` is called as by [`one_ray`].
#[inline(always)]
pub fn one_triangle<M: Method, L: Lanes, D: Division>(
    token: L::Token,
    packets: &Packets<L::Elem>,
    triangles: &PreparedTriangles<M, L::Elem>,
    culling: Culling,
    mut found: impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
) {
    for axis in 0..3 {
        for_axis!(M, axis, |AXIS| one_triangle_along::<M, L, D, AXIS>(
            token,
            packets.along(axis),
            triangles,
            culling,
            &mut found
        ));
    }
}

#[inline(always)]
fn one_triangle_along<M: Method, L: Lanes, D: Division, const AXIS: usize>(
    token: L::Token,
    (first, packets): (usize, &[Packet<L::Elem>]),
    triangles: &PreparedTriangles<M, L::Elem>,
    culling: Culling,
    found: &mut impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
) {
    for (number, packet) in packets.iter().enumerate() {
        for lane in (0..BLOCK).step_by(L::N) {
            let ray_place = (first + number) * BLOCK + lane;
            let ray = packet.lanes::<L>(token, lane).with_axis_last(AXIS);
            let interval = Interval::of(&ray);
            for (group, places) in triangles.groups().iter().enumerate() {
                let prepared = M::prepare_ray(&ray, group);
                for (triangle_place, triangle) in places.clone().zip(triangles.singles(places)) {
                    let triangle = splat::<M, L, AXIS>(token, triangle);
                    M::test::<L, D>(
                        &prepared,
                        &triangle,
                        interval,
                        culling,
                        #[inline(always)]
                        |mask, hit| {
                            let (ray, triangle) = (&ray, &triangle);
                            (*found)(
                                Tested { ray_place, triangle_place, ray, triangle, group },
                                mask,
                                hit,
                            );
                        },
                    );
                }
            }
        }
    }
}

/// A triangle in all lanes.
#[inline(always)]
fn splat<M: Method, L: Lanes, const AXIS: usize>(
    token: L::Token,
    triangle: &Of<M::Prepared, L::Elem>,
) -> Of<M::Prepared, L> {
    let triangle = M::Prepared::map(
        triangle,
        #[inline(always)]
        |&x| L::splat(token, x),
    );
    M::Prepared::with_axis_last(&triangle, AXIS)
}

/// What the rays of packets share, see [`shared_packets`].
pub trait Shared: 'static {
    /// Makes `ray` take over what the rays share.
    fn take<R: RayParts>(ray: &mut R, from: &R);
}

/// All rays have one origin: what depends on origin and triangle alone is computed once.
pub struct CommonOrigin;

impl Shared for CommonOrigin {
    #[inline(always)]
    fn take<R: RayParts>(ray: &mut R, from: &R) {
        ray.take_origin(from);
    }
}

/// All rays have one direction: what depends on direction and triangle alone is computed once.
pub struct CommonDirection;

impl Shared for CommonDirection {
    #[inline(always)]
    fn take<R: RayParts>(ray: &mut R, from: &R) {
        ray.take_direction(from);
    }
}

/// A vector of rays of a bundle.
#[derive(Clone, Copy)]
struct Row<R, L> {
    ray: Ray<L>,
    prepared: R,
    interval: Interval<L>,
}

/// [`one_triangle`] for packets whose rays have something in common, the other way round: each
/// triangle stays at hand while the rays go by, and what depends on it and on what the rays share
/// is computed once for all of them, the compiler moving it out of the loop over the rays.
///
/// The rays must share what `S` says ([`Packets::common`]); the answers are those of the first ray's
/// share otherwise.
#[inline(always)]
pub fn shared_packets<M: Method, L: Lanes, D: Division, S: Shared>(
    token: L::Token,
    packets: &Packets<L::Elem>,
    triangles: &PreparedTriangles<M, L::Elem>,
    culling: Culling,
    mut found: impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
) {
    for axis in 0..3 {
        for_axis!(M, axis, |AXIS| shared_along::<M, L, D, S, AXIS>(
            token,
            packets.along(axis),
            triangles,
            culling,
            &mut found
        ));
    }
}

#[inline(always)]
fn shared_along<M: Method, L: Lanes, D: Division, S: Shared, const AXIS: usize>(
    token: L::Token,
    (first, packets): (usize, &[Packet<L::Elem>]),
    triangles: &PreparedTriangles<M, L::Elem>,
    culling: Culling,
    found: &mut impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
) {
    let mut rows = Vec::with_capacity(BUNDLE * BLOCK / L::N);
    for (bundle, packets) in packets.chunks(BUNDLE).enumerate() {
        let first = (first + bundle * BUNDLE) * BLOCK;
        for (group, places) in triangles.groups().iter().enumerate() {
            rows.clear();
            for packet in packets {
                for lane in (0..BLOCK).step_by(L::N) {
                    let ray = packet.lanes::<L>(token, lane).with_axis_last(AXIS);
                    let prepared = M::prepare_ray(&ray, group);
                    let interval = Interval::of(&ray);
                    rows.push(Row { ray, prepared, interval });
                }
            }
            let Some(&common) = rows.first() else { continue };
            for (triangle_place, triangle) in places.clone().zip(triangles.singles(places)) {
                let triangle = splat::<M, L, AXIS>(token, triangle);
                for (number, row) in rows.iter().enumerate() {
                    let ray_place = first + number * L::N;
                    let mut prepared = row.prepared;
                    S::take(&mut prepared, &common.prepared);
                    M::test::<L, D>(
                        &prepared,
                        &triangle,
                        row.interval,
                        culling,
                        #[inline(always)]
                        |mask, hit| {
                            let (ray, triangle) = (&row.ray, &triangle);
                            (*found)(
                                Tested { ray_place, triangle_place, ray, triangle, group },
                                mask,
                                hit,
                            );
                        },
                    );
                }
            }
        }
    }
}
