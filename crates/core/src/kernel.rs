//! The loops around a method: every ray against every triangle, in two arrangements.

use crate::block::{BLOCK, Packet, PreparedTriangles};
use crate::division::{Culling, Division, Interval};
use crate::geometry::{Hit, Ray};
use crate::lanes::Lanes;
use crate::method::Method;
use crate::record::Record;

/// Tests one ray against every triangle: the ray in all lanes, N triangles at a time.
///
/// `found(place, mask, hit)` is called with the place of the first lane (see
/// [`PreparedTriangles::number`]) for each vector with a hit, or for every vector where `D` has no
/// early-out.
#[inline(always)]
pub fn one_ray<M: Method, L: Lanes, D: Division>(
    token: L::Token,
    ray: &Ray<L::Elem>,
    triangles: &PreparedTriangles<M, L::Elem>,
    culling: Culling,
    mut found: impl FnMut(usize, L::Mask, Hit<L>),
) {
    let ray = ray.map(
        #[inline(always)]
        |&x| L::splat(token, x),
    );
    let interval = Interval::new(ray.tmin, ray.tmax);
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
            lane = (lane + L::N) % BLOCK;
            if lane == 0 {
                current = rest.next();
            }
            let first = place;
            place += L::N;
            D::test::<M, L>(
                &prepared,
                &triangle,
                interval,
                culling,
                #[inline(always)]
                |mask, hit| found(first, mask, hit),
            );
        }
    }
}

/// Tests every ray of a packet against every triangle: the triangle in all lanes, N rays at a
/// time.
///
/// `found(lane, place, mask, hit)` is called with the first ray's lane in the packet and the
/// triangle's place, as in [`one_ray`].
#[inline(always)]
pub fn one_triangle<M: Method, L: Lanes, D: Division>(
    token: L::Token,
    packet: &Packet<L::Elem>,
    triangles: &PreparedTriangles<M, L::Elem>,
    culling: Culling,
    mut found: impl FnMut(usize, usize, L::Mask, Hit<L>),
) {
    for lane in (0..BLOCK).step_by(L::N) {
        let ray = packet.lanes::<L>(token, lane);
        let interval = Interval::new(ray.tmin, ray.tmax);
        for (group, places) in triangles.groups().iter().enumerate() {
            let prepared = M::prepare_ray(&ray, group);
            for (place, triangle) in places.clone().zip(triangles.singles(places)) {
                let triangle = M::Prepared::map(
                    triangle,
                    #[inline(always)]
                    |&x| L::splat(token, x),
                );
                D::test::<M, L>(
                    &prepared,
                    &triangle,
                    interval,
                    culling,
                    #[inline(always)]
                    |mask, hit| found(lane, place, mask, hit),
                );
            }
        }
    }
}
