//! Vectors of coordinates between memory and lanes.

use trisect_core::{Lanes, Vec3};

use crate::precision::Real;

/// Children of a node, triangles of a block, and at most so many lanes.
pub(crate) const WIDTH: usize = 8;

/// A vector for each lane, from index `at` of three rows on.
#[inline(always)]
pub(crate) fn load<L: Lanes<Elem = f32>, const N: usize>(
    token: L::Token,
    [x, y, z]: [&[f32; N]; 3],
    at: usize,
) -> Vec3<L> {
    Vec3::new(L::load(token, &x[at..]), L::load(token, &y[at..]), L::load(token, &z[at..]))
}

/// Writes the vector of each lane to three rows, from index `at` on.
#[inline(always)]
pub(crate) fn store<L: Lanes<Elem = f32>, const N: usize>(
    v: Vec3<L>,
    rows: &mut [[f32; N]; 3],
    at: usize,
) {
    v.x.store(&mut rows[0][at..]);
    v.y.store(&mut rows[1][at..]);
    v.z.store(&mut rows[2][at..]);
}

/// One vector in all lanes.
#[inline(always)]
pub(crate) fn splat<L: Lanes<Elem = f32>>(token: L::Token, v: Vec3<f32>) -> Vec3<L> {
    Vec3::new(L::splat(token, v.x), L::splat(token, v.y), L::splat(token, v.z))
}

/// The least of all lanes.
#[inline(always)]
pub(crate) fn least<L: Lanes<Elem: Real>>(x: L) -> L::Elem {
    let mut lanes = [L::Elem::INFINITY; WIDTH];
    x.store(&mut lanes);
    let [a, b, c, d, e, f, g, h] = lanes;
    let (a, b, c, d) = (Lanes::min(a, e), Lanes::min(b, f), Lanes::min(c, g), Lanes::min(d, h));
    Lanes::min(Lanes::min(a, c), Lanes::min(b, d))
}
