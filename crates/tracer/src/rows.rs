//! Rays on their way through the tree, number by number, so that what is computed once per ray is computed
//! for as many as there are lanes.

use trisect_core::{Interval, Lanes, Ray, Triangle, Vec3};

use crate::bvh::WIDTH;
use crate::hit::{NO_HIT, TriangleHit};
use crate::slabs::Slabs;

/// How many rays: one for each bit of a mask.
pub(crate) const RAYS: usize = 64;

/// Stands for a ray where there is none.
const NO_RAY: Ray<f32> =
    Ray { o: Vec3::new(0.0, 0.0, 0.0), d: Vec3::new(0.0, 0.0, 0.0), tmin: 0.0, tmax: 0.0 };

/// A number of each ray.
pub(crate) type Row = [f32; RAYS];

const ZEROS: Vec3<Row> = Vec3::new([0.0; RAYS], [0.0; RAYS], [0.0; RAYS]);

/// Rays, what their tests of boxes need, and what they have found.
#[repr(align(64))]
pub(crate) struct Rows {
    /// Rays as they were given, where they are [kept so](Rows::fill).
    lines: [Ray<f32>; RAYS],
    o: [Row; 3],
    d: [Row; 3],
    /// The ends of their intervals, the last of which is at the best hit, where there is one.
    tmin: Row,
    tmax: Row,
    inverse: [Row; 3],
    start: [Row; 3],
    pub(crate) best: [TriangleHit; RAYS],
    /// The triangles that they hit, for who computes values of all at once; where there is none, anything.
    /// Here, so that they need not be set to anything.
    pub(crate) corners: Triangle<Row>,
}

impl Rows {
    pub(crate) const EMPTY: Self = Self {
        lines: [NO_RAY; RAYS],
        o: [[0.0; RAYS]; 3],
        d: [[0.0; RAYS]; 3],
        tmin: [0.0; RAYS],
        tmax: [0.0; RAYS],
        inverse: [[0.0; RAYS]; 3],
        start: [[0.0; RAYS]; 3],
        best: [NO_HIT; RAYS],
        corners: Triangle { a: ZEROS, b: ZEROS, c: ZEROS },
    };

    /// Takes up to [`RAYS`] rays, whose interval is empty where they have nothing, so where they are
    /// not finite. Those that have anything to find, in bits. With `lines` the numbers of a ray are kept
    /// together as well, for [`line`](Rows::line).
    #[inline(always)]
    pub(crate) fn fill<'a, L: Lanes<Elem = f32>, const ROBUST: bool>(
        &mut self,
        token: L::Token,
        rays: impl ExactSizeIterator<Item = &'a Ray<f32>>,
        lines: bool,
    ) -> u64 {
        let count = rays.len();
        for (place, ray) in rays.enumerate().take(RAYS) {
            if lines {
                self.lines[place] = *ray;
            }
            self.o[0][place] = ray.o.x;
            self.o[1][place] = ray.o.y;
            self.o[2][place] = ray.o.z;
            self.d[0][place] = ray.d.x;
            self.d[1][place] = ray.d.y;
            self.d[2][place] = ray.d.z;
            self.tmin[place] = ray.tmin;
            self.tmax[place] = ray.tmax;
        }
        // Whatever was there before finds nothing.
        self.tmin[count..].fill(1.0);
        self.tmax[count..].fill(0.0);
        let (mut some, mut at) = (0, 0);
        while at < RAYS {
            let ray = Ray {
                o: load(token, self.o.each_ref(), at),
                d: load(token, self.d.each_ref(), at),
                tmin: L::load(token, &self.tmin[at..]),
                tmax: L::load(token, &self.tmax[at..]),
            };
            let Interval { tmin, tmax } = Interval::of(&ray);
            tmin.store(&mut self.tmin[at..]);
            tmax.store(&mut self.tmax[at..]);
            let Slabs { inverse, start } = Slabs::new::<ROBUST>(&ray);
            store(inverse, &mut self.inverse, at);
            store(start, &mut self.start, at);
            some |= L::bits(tmin.le(tmax)) << at;
            at += L::N;
        }
        self.best = [NO_HIT; RAYS];
        some
    }

    /// A ray.
    #[inline(always)]
    pub(crate) fn ray(&self, place: usize) -> Ray<f32> {
        let at = place % RAYS;
        Ray {
            o: Vec3::new(self.o[0][at], self.o[1][at], self.o[2][at]),
            d: Vec3::new(self.d[0][at], self.d[1][at], self.d[2][at]),
            tmin: self.tmin[at],
            tmax: self.tmax[at],
        }
    }

    /// All rays, number by number.
    #[inline(always)]
    pub(crate) fn rays(&self) -> Ray<&Row> {
        let ([ox, oy, oz], [dx, dy, dz]) = (&self.o, &self.d);
        let (o, d) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
        Ray { o, d, tmin: &self.tmin, tmax: &self.tmax }
    }

    /// A ray that is kept as a line: where much is computed with it, the compiler gathers its numbers from
    /// rows, which takes longer than to read them here; where little is, it is not worth its keeping.
    #[inline(always)]
    pub(crate) fn line(&self, place: usize) -> Ray<f32> {
        let at = place % RAYS;
        Ray { tmin: self.tmin[at], tmax: self.tmax[at], ..self.lines[at] }
    }

    /// Where a ray's interval ends.
    #[inline(always)]
    pub(crate) fn tmax(&self, place: usize) -> f32 {
        self.tmax[place % RAYS]
    }

    /// Ends a ray's interval.
    #[inline(always)]
    pub(crate) fn end(&mut self, place: usize, tmax: f32) {
        self.tmax[place % RAYS] = tmax;
    }

    /// Of one ray, in all lanes: for its tests of boxes.
    #[inline(always)]
    pub(crate) fn slabs<L: Lanes<Elem = f32>>(&self, token: L::Token, place: usize) -> Slabs<L> {
        let at = place % RAYS;
        let of = Slabs {
            inverse: Vec3::new(self.inverse[0][at], self.inverse[1][at], self.inverse[2][at]),
            start: Vec3::new(self.start[0][at], self.start[1][at], self.start[2][at]),
        };
        Slabs { inverse: splat(token, of.inverse), start: splat(token, of.start) }
    }

    /// Its interval likewise.
    #[inline(always)]
    pub(crate) fn interval<L: Lanes<Elem = f32>>(&self, token: L::Token, place: usize) -> (L, L) {
        let at = place % RAYS;
        (L::splat(token, self.tmin[at]), L::splat(token, self.tmax[at]))
    }

    /// Of as many rays as there are lanes, from one on.
    #[inline(always)]
    pub(crate) fn many_slabs<L: Lanes<Elem = f32>>(&self, token: L::Token, at: usize) -> Slabs<L> {
        Slabs {
            inverse: load(token, self.inverse.each_ref(), at),
            start: load(token, self.start.each_ref(), at),
        }
    }

    /// Their intervals.
    #[inline(always)]
    pub(crate) fn many_intervals<L: Lanes<Elem = f32>>(
        &self,
        token: L::Token,
        at: usize,
    ) -> (L, L) {
        (L::load(token, &self.tmin[at..]), L::load(token, &self.tmax[at..]))
    }

    /// Their origins.
    #[inline(always)]
    pub(crate) fn many_origins<L: Lanes<Elem = f32>>(&self, token: L::Token, at: usize) -> Vec3<L> {
        load(token, self.o.each_ref(), at)
    }
}

/// A vector for each lane, from a place of three rows on.
#[inline(always)]
pub(crate) fn load<L: Lanes<Elem = f32>, const N: usize>(
    token: L::Token,
    [x, y, z]: [&[f32; N]; 3],
    at: usize,
) -> Vec3<L> {
    Vec3::new(L::load(token, &x[at..]), L::load(token, &y[at..]), L::load(token, &z[at..]))
}

#[inline(always)]
fn store<L: Lanes<Elem = f32>>(v: Vec3<L>, rows: &mut [Row; 3], at: usize) {
    v.x.store(&mut rows[0][at..]);
    v.y.store(&mut rows[1][at..]);
    v.z.store(&mut rows[2][at..]);
}

/// A vector in all lanes.
#[inline(always)]
pub(crate) fn splat<L: Lanes<Elem = f32>>(token: L::Token, v: Vec3<f32>) -> Vec3<L> {
    Vec3::new(L::splat(token, v.x), L::splat(token, v.y), L::splat(token, v.z))
}

/// The least of all lanes.
#[inline(always)]
pub(crate) fn least<L: Lanes<Elem = f32>>(x: L) -> f32 {
    let mut lanes = [f32::INFINITY; WIDTH];
    x.store(&mut lanes);
    let [a, b, c, d, e, f, g, h] = lanes;
    let (a, b, c, d) = (Lanes::min(a, e), Lanes::min(b, f), Lanes::min(c, g), Lanes::min(d, h));
    Lanes::min(Lanes::min(a, c), Lanes::min(b, d))
}
