//! A batch of rays on their way through the tree, stored coordinate by coordinate: what is computed once per ray is
//! computed for as many rays at a time as there are lanes.

use prefetch_index::prefetch_index;
use trisect_core::{Lanes, Ray, Vec3};
use trisect_method::Interval;

use super::slabs::{Slabs, moves};
use crate::bvh::bounds::Bounds;
use crate::query::Boxes;
use crate::vectors::{WIDTH, load, splat, store};

/// How many rays: one for each bit of a mask.
pub(crate) const RAYS: usize = 64;

/// Numbers of a ray.
const NUMBERS: usize = 8;

/// A ray that finds nothing.
pub(crate) const NO_RAY: Ray<f32> =
    Ray { o: Vec3::new(0.0, 0.0, 0.0), d: Vec3::new(0.0, 0.0, 0.0), tmin: 1.0, tmax: 0.0 };

/// One number of each ray.
pub(crate) type Row<const N: usize = RAYS> = [f32; N];

/// So many rays of a precision, as leaves ask for them.
pub(crate) trait Rays<P, const N: usize> {
    /// One of them.
    fn one(&self, index: usize) -> Ray<P>;

    /// All of them, coordinate by coordinate.
    fn rows(&self) -> Ray<&[P; N]>;
}

/// Rays of which as many go together as there are lanes.
pub(crate) trait Gather<P> {
    /// Takes as many of some rays, in bits, as there are lanes: the rays, one per lane, and their indices. Lanes that
    /// are left over have a ray that finds nothing. The numbers of the rays must be stored side by side.
    fn gather<L: Lanes<Elem = P>>(&self, token: L::Token, rays: &mut u64) -> (Ray<L>, [u8; WIDTH]);

    /// Where a ray's interval ends.
    fn tmax(&self, index: usize) -> P;

    /// Ends a ray's interval at `tmax`, of one that may be [gathered](Gather::gather).
    fn shorten(&mut self, index: usize, tmax: P);
}

/// Rays, and what their tests of boxes need: a batch of them, or one.
#[repr(align(64))]
pub(crate) struct RayBatch<const N: usize = RAYS> {
    /// The numbers of each ray side by side, where they are [kept so](RayBatch::fill). The interval is the
    /// given one, but its end moves once it is [shortened](Gather::shorten).
    lines: [[f32; NUMBERS]; N],
    o: [Row<N>; 3],
    d: [Row<N>; 3],
    tmin: Row<N>,
    /// Where intervals end: at the best hit, where there is one.
    tmax: Row<N>,
    inverse: [Row<N>; 3],
    near: [Row<N>; 3],
    /// Where tests are robust.
    far: [Row<N>; 3],
}

/// Rays, and what is known of their hits. Together, so that a loop has both behind one pointer, and in this
/// order, which was the faster one.
#[repr(C)]
pub(crate) struct Work<H, const N: usize = RAYS> {
    pub(crate) rays: RayBatch<N>,
    pub(crate) hits: H,
}

impl RayBatch {
    pub(crate) const EMPTY: Self = Self {
        lines: [[0.0; NUMBERS]; RAYS],
        o: [[0.0; RAYS]; 3],
        d: [[0.0; RAYS]; 3],
        tmin: [0.0; RAYS],
        tmax: [0.0; RAYS],
        inverse: [[0.0; RAYS]; 3],
        near: [[0.0; RAYS]; 3],
        far: [[0.0; RAYS]; 3],
    };

    /// Takes up to [`RAYS`] rays, and says in bits which of them have anything to find: not those that are not
    /// finite, or miss the `whole`, a box around all others, as every second ray of a camera does. With `lines`
    /// the numbers of a ray are stored side by side as well, for [`line`](RayBatch::line) and
    /// [`gather`](Gather::gather).
    #[inline(always)]
    pub(crate) fn fill<'a, L: Lanes<Elem = f32>, B: Boxes>(
        &mut self,
        token: L::Token,
        mut rays: impl ExactSizeIterator<Item = &'a Ray<f32>>,
        whole: &Bounds,
        lines: bool,
    ) -> u64 {
        let count = rays.len().min(RAYS);
        let reach = whole.largest();
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
                if lines {
                    self.lines[(at + lane) % RAYS] = numbers[lane];
                }
                lane += 1;
            }
            let ray = by_number::<L>(token, numbers.as_flattened());
            store(ray.o, &mut self.o, at);
            store(ray.d, &mut self.d, at);
            let Interval { tmin, tmax } = Interval::of(&ray);
            let slabs = Slabs::new::<B>(&ray, reach);
            store(slabs.inverse, &mut self.inverse, at);
            store(slabs.near, &mut self.near, at);
            if B::ROBUST {
                store(slabs.far, &mut self.far, at);
            }
            let (enters, leaves) = slabs.cross_either_way::<B>(from, to, (tmin, tmax));
            let meets = enters.le(leaves) & tmin.le(tmax) & moves(&ray);
            tmin.store(&mut self.tmin[at..]);
            L::select(meets, tmax, tmax.constant(f32::NEG_INFINITY)).store(&mut self.tmax[at..]);
            some |= L::bits(meets) << at;
            at += L::N;
        }
        // What was there before finds nothing.
        self.tmin[at..].fill(1.0);
        self.tmax[at..].fill(0.0);
        some
    }

    /// What the tests of boxes need of as many rays as there are lanes, from index `at` on.
    #[inline(always)]
    pub(crate) fn many_slabs<L: Lanes<Elem = f32>>(&self, token: L::Token, at: usize) -> Slabs<L> {
        Slabs {
            inverse: load(token, self.inverse.each_ref(), at),
            near: load(token, self.near.each_ref(), at),
            far: load(token, self.far.each_ref(), at),
        }
    }

    /// The intervals of those rays.
    #[inline(always)]
    pub(crate) fn many_intervals<L: Lanes<Elem = f32>>(
        &self,
        token: L::Token,
        at: usize,
    ) -> (L, L) {
        (L::load(token, &self.tmin[at..]), L::load(token, &self.tmax[at..]))
    }

    /// The origins of those rays.
    #[inline(always)]
    pub(crate) fn many_origins<L: Lanes<Elem = f32>>(&self, token: L::Token, at: usize) -> Vec3<L> {
        load(token, self.o.each_ref(), at)
    }
}

impl RayBatch<1> {
    /// One ray, without what tests of boxes need; `None` where it has nothing to find, as one has that is not finite.
    #[inline(always)]
    pub(crate) fn of(ray: &Ray<f32>) -> Option<Self> {
        let Interval { tmin, tmax } = Interval::of(ray);
        let Ray { o, d, .. } = *ray;
        let none = [[0.0]; 3];
        let of_one = Self {
            lines: [[o.x, o.y, o.z, d.x, d.y, d.z, tmin, tmax]],
            o: [[o.x], [o.y], [o.z]],
            d: [[d.x], [d.y], [d.z]],
            tmin: [tmin],
            tmax: [tmax],
            inverse: none,
            near: none,
            far: none,
        };
        // Not so where an end is NaN.
        (tmin <= tmax && moves(ray)).then_some(of_one)
    }
}

impl<const N: usize> RayBatch<N> {
    /// A ray.
    #[inline(always)]
    pub(crate) fn ray(&self, index: usize) -> Ray<f32> {
        let at = index % N;
        Ray {
            o: Vec3::new(self.o[0][at], self.o[1][at], self.o[2][at]),
            d: Vec3::new(self.d[0][at], self.d[1][at], self.d[2][at]),
            tmin: self.tmin[at],
            tmax: self.tmax[at],
        }
    }

    /// A ray whose numbers are stored side by side. Where much is computed with a ray, the compiler gathers its
    /// numbers from rows, which takes longer than reading them here; where little is, storing them is not worth
    /// its time.
    #[inline(always)]
    pub(crate) fn line(&self, index: usize) -> Ray<f32> {
        let at = index % N;
        let [ox, oy, oz, dx, dy, dz, ..] = self.lines[at];
        let (o, d) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
        Ray { o, d, tmin: self.tmin[at], tmax: self.tmax[at] }
    }

    /// Where a ray's interval ends.
    #[inline(always)]
    pub(crate) fn tmax(&self, index: usize) -> f32 {
        self.tmax[index % N]
    }

    /// Ends a ray's interval at `tmax`.
    #[inline(always)]
    pub(crate) fn end(&mut self, index: usize, tmax: f32) {
        self.tmax[index % N] = tmax;
    }

    /// What the tests of boxes of one ray need, in all lanes.
    #[inline(always)]
    pub(crate) fn slabs<L: Lanes<Elem = f32>>(&self, token: L::Token, index: usize) -> Slabs<L> {
        let at = index % N;
        let of = |rows: &[Row<N>; 3]| Vec3::new(rows[0][at], rows[1][at], rows[2][at]);
        Slabs {
            inverse: splat(token, of(&self.inverse)),
            near: splat(token, of(&self.near)),
            far: splat(token, of(&self.far)),
        }
    }

    /// The interval of one ray, in all lanes.
    #[inline(always)]
    pub(crate) fn interval<L: Lanes<Elem = f32>>(&self, token: L::Token, index: usize) -> (L, L) {
        let at = index % N;
        (L::splat(token, self.tmin[at]), L::splat(token, self.tmax[at]))
    }
}

impl<const N: usize> Rays<f32, N> for RayBatch<N> {
    #[inline(always)]
    fn one(&self, index: usize) -> Ray<f32> {
        self.ray(index)
    }

    #[inline(always)]
    fn rows(&self) -> Ray<&Row<N>> {
        let ([ox, oy, oz], [dx, dy, dz]) = (&self.o, &self.d);
        let (o, d) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
        Ray { o, d, tmin: &self.tmin, tmax: &self.tmax }
    }
}

impl Gather<f32> for RayBatch {
    #[inline(always)]
    fn gather<L: Lanes<Elem = f32>>(
        &self,
        token: L::Token,
        rays: &mut u64,
    ) -> (Ray<L>, [u8; WIDTH]) {
        let Ray { o, d, tmin, tmax } = NO_RAY;
        let mut numbers = [[o.x, o.y, o.z, d.x, d.y, d.z, tmin, tmax]; WIDTH];
        let mut indices = [0; WIDTH];
        let mut count = 0;
        while count < L::N && *rays != 0 {
            let index = rays.trailing_zeros() as usize % RAYS;
            *rays &= *rays - 1;
            numbers[count] = self.lines[index];
            #[allow(clippy::cast_possible_truncation, reason = "a batch has few rays")]
            let index = index as u8;
            indices[count] = index;
            count += 1;
        }
        (by_number::<L>(token, numbers.as_flattened()), indices)
    }

    #[inline(always)]
    fn tmax(&self, index: usize) -> f32 {
        self.tmax[index % RAYS]
    }

    #[inline(always)]
    fn shorten(&mut self, index: usize, tmax: f32) {
        self.end(index, tmax);
        self.lines[index % RAYS][NUMBERS - 1] = tmax;
    }
}

/// Prefetches the batch of rays from `start` on, and where their hits will be written.
#[inline(always)]
pub(crate) fn prefetch<T>(rays: &[Ray<f32>], found: &[T], start: usize) {
    let end = rays.len().min(start + RAYS);
    let mut at = start;
    while at < end {
        // A cache line holds two rays, and two hits.
        prefetch_index(rays, at);
        prefetch_index(found, at);
        at += 2;
    }
}

/// As many rays as there are lanes, one per lane, from their numbers, ray by ray.
#[inline(always)]
fn by_number<L: Lanes<Elem = f32>>(token: L::Token, numbers: &[f32]) -> Ray<L> {
    // The index of a number, in bits, is that of its ray and then that within the ray. Interleaving the first half
    // with the second rotates it by a bit. After one rotation for each bit of the ray's index, a vector has one
    // number of all rays.
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
