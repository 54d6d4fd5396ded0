//! The first triangle along a ray.

use core::cmp::Ordering;

use trisect_core::{Hit, Lanes, Ray, Scalar, Token, Triangle};
use trisect_kernels::{BLOCK, PreparedTriangles, one_ray_until};
use trisect_method::{Culling, Deferred, TrueDivision};

use crate::ladder::{self, Precision};
use crate::{Exact, double, lanes_of, widened};

/// Which of two triangles that `ray` hits comes first along it: exactly so, however near they are.
/// Everything must be finite, and neither triangle parallel to the ray.
pub fn order<X: Scalar>(ray: &Ray<X>, first: &Triangle<X>, second: &Triangle<X>) -> Ordering {
    order_within(ray, [first, second], double::UNIT)
}

/// The same, by f64 with bounds of that width first.
pub(crate) fn order_within<X: Scalar>(
    ray: &Ray<X>,
    [first, second]: [&Triangle<X>; 2],
    unit: f64,
) -> Ordering {
    let precision = const { Precision::of_size(size_of::<X>()) };
    let ray = ray.map(|x| x.to_f64());
    ladder::order(precision, &ray, [&widened(first), &widened(second)], unit)
}

/// The triangle that `ray` hits first, of those that it hits at the very same point the one of the
/// lowest number: its number and the hit. `prepared` must be prepared from `triangles`.
///
/// # Panics
/// When there are fewer `triangles` than prepared ones.
pub fn closest<L: Lanes>(
    token: L::Token,
    ray: &Ray<L::Elem>,
    triangles: &[Triangle<L::Elem>],
    prepared: &PreparedTriangles<Exact, L::Elem>,
) -> Option<(u32, Hit<L::Elem>)> {
    let mut best = None;
    token.run(
        #[inline(always)]
        || {
            one_ray_until::<Exact, L, Deferred<TrueDivision, true>>(
                token,
                ray,
                prepared,
                Culling::None,
                #[inline(always)]
                |tested, mask, hit| {
                    let numbers = prepared.numbers(tested.triangle_place);
                    take::<L>(ray, triangles, numbers, L::bits(mask), hit, &mut best);
                    best.and_then(|(_, hit)| end_after(hit.t, ray.tmax))
                },
            );
        },
    );
    best
}

/// Takes the first of the lanes that hit, where it is before the best. Rounded values are in order, so
/// that only equal ones have to be looked at again.
#[inline(never)]
fn take<L: Lanes>(
    ray: &Ray<L::Elem>,
    triangles: &[Triangle<L::Elem>],
    numbers: &[u32],
    hits: u64,
    hit: Hit<L>,
    best: &mut Option<(u32, Hit<L::Elem>)>,
) {
    let mut rows = [[L::Elem::from_f64(0.0); BLOCK]; 3];
    hit.t.store(&mut rows[0]);
    hit.beta.store(&mut rows[1]);
    hit.gamma.store(&mut rows[2]);
    for lane in lanes_of(hits) {
        let number = numbers[lane];
        let hit = Hit { t: rows[0][lane], beta: rows[1][lane], gamma: rows[2][lane] };
        let is_first = best.is_none_or(|(other, other_hit)| {
            let [this, that] = [number, other].map(|number| &triangles[number as usize]);
            hit.t < other_hit.t
                || hit.t == other_hit.t
                    && order(ray, this, that).then(number.cmp(&other)) == Ordering::Less
        });
        if is_first {
            *best = Some((number, hit));
        }
    }
}

/// Where the interval may end after a hit at `t`: a little later, since one whose rounded `t` is the same
/// may be before it. Nowhere else than now where that is beyond the interval.
fn end_after<X: Scalar>(t: X, tmax: X) -> Option<X> {
    let ulp = X::unit_roundoff() + X::unit_roundoff();
    let end = (t + t.abs() * ulp) + X::smallest_det();
    (end < tmax && end < X::largest_t()).then_some(end)
}
