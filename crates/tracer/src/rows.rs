//! Rays on their way through the tree, number by number, so that what is computed once per ray is computed
//! for as many as there are lanes.

use prefetch_index::prefetch_index;
use trisect_core::{Interval, Lanes, Ray, Triangle, Vec3};

use crate::bounds::Bounds;
use crate::bvh::WIDTH;
use crate::hit::{NO_HIT, TriangleHit};
use crate::slabs::Slabs;

/// How many rays: one for each bit of a mask.
pub(crate) const RAYS: usize = 64;

/// Numbers of a ray.
const NUMBERS: usize = 8;

/// A ray that finds nothing.
const NO_RAY: Ray<f32> =
    Ray { o: Vec3::new(0.0, 0.0, 0.0), d: Vec3::new(0.0, 0.0, 0.0), tmin: 1.0, tmax: 0.0 };

/// A number of each ray.
pub(crate) type Row = [f32; RAYS];

const ZEROS: Vec3<Row> = Vec3::new([0.0; RAYS], [0.0; RAYS], [0.0; RAYS]);

/// Rays, what their tests of boxes need, and what they have found.
#[repr(align(64))]
pub(crate) struct Rows {
    /// The numbers of each ray together, where they are [kept so](Rows::fill). The interval is the given
    /// one, but for its end once it is [shortened](Rows::shorten).
    together: [[f32; NUMBERS]; RAYS],
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
        together: [[0.0; NUMBERS]; RAYS],
        o: [[0.0; RAYS]; 3],
        d: [[0.0; RAYS]; 3],
        tmin: [0.0; RAYS],
        tmax: [0.0; RAYS],
        inverse: [[0.0; RAYS]; 3],
        start: [[0.0; RAYS]; 3],
        best: [NO_HIT; RAYS],
        corners: Triangle { a: ZEROS, b: ZEROS, c: ZEROS },
    };

    /// Takes up to [`RAYS`] rays, whose interval is empty where they have nothing to find: where they are
    /// not finite, or miss the `whole`, a box around all others, which of a camera's rays every second one
    /// does. Those that have anything to find, in bits. The numbers of a ray are kept `together` as well,
    /// for [`line`](Rows::line) and [`abreast`](Rows::abreast).
    #[inline(always)]
    pub(crate) fn fill<'a, L: Lanes<Elem = f32>, const ROBUST: bool>(
        &mut self,
        token: L::Token,
        mut rays: impl ExactSizeIterator<Item = &'a Ray<f32>>,
        whole: &Bounds,
        together: bool,
    ) -> u64 {
        let count = rays.len().min(RAYS);
        let Bounds { min: [x, y, z], max } = *whole;
        let from = splat::<L>(token, Vec3::new(x, y, z));
        let to = splat::<L>(token, Vec3::new(max[0], max[1], max[2]));
        let (mut some, mut at) = (0, 0);
        while at < count {
            let mut numbers = [[0.0; NUMBERS]; WIDTH];
            let mut lane = 0;
            while lane < L::N {
                let ray = rays.next().unwrap_or(&NO_RAY);
                let Ray { o, d, tmin, tmax } = *ray;
                numbers[lane] = [o.x, o.y, o.z, d.x, d.y, d.z, tmin, tmax];
                if together {
                    self.together[(at + lane) % RAYS] = numbers[lane];
                }
                lane += 1;
            }
            let ray = by_number::<L>(token, numbers.as_flattened());
            store(ray.o, &mut self.o, at);
            store(ray.d, &mut self.d, at);
            let Interval { tmin, tmax } = Interval::of(&ray);
            let slabs = Slabs::new::<ROBUST>(&ray);
            store(slabs.inverse, &mut self.inverse, at);
            store(slabs.start, &mut self.start, at);
            let (enters, leaves) = slabs.cross_either_way::<ROBUST>(from, to, (tmin, tmax));
            let meets = enters.le(leaves) & tmin.le(tmax);
            tmin.store(&mut self.tmin[at..]);
            L::select(meets, tmax, tmax.constant(f32::NEG_INFINITY)).store(&mut self.tmax[at..]);
            some |= L::bits(meets) << at;
            at += L::N;
        }
        // Whatever was there before finds nothing.
        self.tmin[at..].fill(1.0);
        self.tmax[at..].fill(0.0);
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
        let [ox, oy, oz, dx, dy, dz, ..] = self.together[at];
        let (o, d) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
        Ray { o, d, tmin: self.tmin[at], tmax: self.tmax[at] }
    }

    /// Takes as many of some rays, in bits, as there are lanes, which are kept together: them, number by
    /// number, and their places. Lanes that are left over have a ray that finds nothing.
    #[inline(always)]
    pub(crate) fn abreast<L: Lanes<Elem = f32>>(
        &self,
        token: L::Token,
        rays: &mut u64,
    ) -> (Ray<L>, [u8; WIDTH]) {
        let Ray { o, d, tmin, tmax } = NO_RAY;
        let mut numbers = [[o.x, o.y, o.z, d.x, d.y, d.z, tmin, tmax]; WIDTH];
        let mut places = [0; WIDTH];
        let mut count = 0;
        while count < L::N && *rays != 0 {
            let place = rays.trailing_zeros() as usize % RAYS;
            *rays &= *rays - 1;
            numbers[count] = self.together[place];
            #[allow(clippy::cast_possible_truncation, reason = "there are few rays")]
            let place = place as u8;
            places[count] = place;
            count += 1;
        }
        (by_number::<L>(token, numbers.as_flattened()), places)
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

    /// The same of a ray that is kept together.
    #[inline(always)]
    pub(crate) fn shorten(&mut self, place: usize, tmax: f32) {
        self.end(place, tmax);
        self.together[place % RAYS][NUMBERS - 1] = tmax;
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

/// Has the rays fetched that are taken in next, and the places where it is written what they find.
#[inline(always)]
pub(crate) fn prefetch<T>(rays: &[Ray<f32>], found: &[T], start: usize) {
    let end = rays.len().min(start + RAYS);
    let mut at = start;
    while at < end {
        // A cache line holds two rays, and hardly more of what they find.
        prefetch_index(rays, at);
        prefetch_index(found, at);
        at += 2;
    }
}

/// As many rays as there are lanes, number by number, from the numbers of one after another.
#[inline(always)]
fn by_number<L: Lanes<Elem = f32>>(token: L::Token, numbers: &[f32]) -> Ray<L> {
    // In vectors as they come. The place of a number, in bits, is the ray's and then the number's own; to
    // interleave those of the first half with those of the second rotates it by a bit: once for each bit
    // of the ray's place, and a vector has a number of all rays.
    let mut vectors = [
        L::load(token, numbers),
        L::load(token, &numbers[L::N..]),
        L::load(token, &numbers[2 * L::N..]),
        L::load(token, &numbers[3 * L::N..]),
        L::load(token, &numbers[4 * L::N..]),
        L::load(token, &numbers[5 * L::N..]),
        L::load(token, &numbers[6 * L::N..]),
        L::load(token, &numbers[7 * L::N..]),
    ];
    let mut rays = 1;
    while rays < L::N {
        let [a, b, c, d, e, f, g, h] = vectors;
        let ((a, e), (b, f)) = (a.interleave(e), b.interleave(f));
        let ((c, g), (d, h)) = (c.interleave(g), d.interleave(h));
        vectors = [a, e, b, f, c, g, d, h];
        rays *= 2;
    }
    let [ox, oy, oz, dx, dy, dz, tmin, tmax] = vectors;
    Ray { o: Vec3::new(ox, oy, oz), d: Vec3::new(dx, dy, dz), tmin, tmax }
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
