#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use core::cmp::Ordering;
use core::marker::PhantomData;

use trisect_core::{Hit, Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_kernels::BLOCK;
use trisect_method::{
    Claims, Culling, Division, ExactMethod, Forms, Given, Homogeneous, Input, Interval, Method,
    MethodInfo, Of, Output, Refine, Screened, Value,
};

mod closest;
mod compensated;
mod double;
mod filter;
mod integer;
mod ladder;
mod normal;
mod outcome;
mod solid;
mod stage;
mod whole;

pub use closest::{closest, order};
pub use filter::{BoundedRay, SizedTriangle};
use filter::{Verdict, Volumes};
use ladder::Precision;
pub use normal::{Computed, Normal, Normals, Stored};
use outcome::Outcome;
pub use solid::point_in_solid;
pub use stage::Stage;
pub use trisect_method::Place;

/// How wide error bounds are, as multiples of what is proved: a test narrows them, to see errors.
pub trait Width: Send + Sync + 'static {
    /// Of the filter over lanes.
    const FILTER: f64;
    /// Of f64.
    const DOUBLE: f64;
}

/// As wide as is proved.
pub struct Proved;

impl Width for Proved {
    const FILTER: f64 = 1.0;
    const DOUBLE: f64 = 1.0;
}

/// Decides every pair as exact arithmetic does; values are rounded once. [`ExactInTrees`] is the same for
/// trees.
pub struct Exact<W = Proved, From = Computed>(PhantomData<(W, From)>);

/// [`Exact`] where a triangle's normal is stored, which is faster in the leaves of a tree.
pub type ExactInTrees = Exact<Proved, Stored>;

impl<W: Width, From: Normals> Method for Exact<W, From> {
    const INFO: MethodInfo = MethodInfo {
        name: "exact",
        title: "Exact",
        year: 2026,
        source: "This project, docs/derivations/exact.md; after J. R. Shewchuk: Adaptive Precision \
                 Floating-Point Arithmetic and Fast Robust Geometric Predicates. Discrete & \
                 Computational Geometry 18, 1997",
        input: Input::Prepared,
        outputs: Output::ALL,
        forms: Forms::Deferred,
        always_divides: false,
        claims: Claims { watertight: true, culls: true, unit_direction: false, exact: true },
        error_factor: 1.0,
    };
    const STAGES: &'static [&'static str] = &Stage::NAMES;
    type Prepared = From::Prepared;
    type PreparedRay<L: Lanes> = BoundedRay<L>;
    type Alpha<L: Lanes> = Given<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        From::prepare(SizedTriangle::new(triangle))
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> BoundedRay<L> {
        BoundedRay::new(ray.o, ray.d, W::FILTER)
    }

    #[inline(always)]
    fn intersect<L: Lanes>(
        ray: &BoundedRay<L>,
        triangle: &Of<Self::Prepared, L>,
    ) -> Homogeneous<L, Given<L>> {
        let volumes = Volumes::new(ray, From::sized(triangle), From::normal(triangle));
        let Volumes { det, u, v, w, .. } = volumes;
        Homogeneous { det, t: volumes.t, alpha: Given(w), beta: u, gamma: v }
    }

    #[inline(always)]
    fn normal<L: Lanes>(triangle: &Of<Self::Prepared, L>, _group: usize) -> Option<Vec3<L>> {
        Some(-From::normal(triangle))
    }

    #[inline(always)]
    fn refine<R: Refine<Self>>(with: R) -> R::Output {
        with.exact()
    }

    fn stage<X: Scalar>(ray: &Ray<X>, triangle: &Triangle<X>) -> usize {
        Stage::of(ray, triangle) as usize
    }

    /// The filter, and for the few lanes that it leaves open the ladder.
    #[inline(always)]
    fn test<L: Lanes, D: Division>(
        ray: &BoundedRay<L>,
        triangle: &Of<Self::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    ) {
        let n = From::normal(triangle);
        let triangle = From::sized(triangle);
        let volumes = Volumes::new(ray, triangle, n);
        let bound = filter::bound(ray, triangle, &volumes);
        let candidates = filter::candidates(&volumes, bound);
        if !L::any(candidates) {
            return;
        }
        let Verdict { hit: mut mask, open } =
            filter::verdict(ray, triangle, &volumes, (bound, candidates), &interval, W::FILTER);
        let zero = bound.constant(L::Elem::from_f64(0.0));
        // The sign of `det`, which all volumes of a hit have.
        let mut side = volumes.u;
        if open != 0 {
            // Lane by lane, out of line, and through copies in memory: a reference to the lanes
            // themselves would keep them out of registers in the loop around.
            let pairs = Unpacked::new(ray, triangle, [interval.tmin, interval.tmax]);
            let mut sides = [L::Elem::from_f64(0.0); BLOCK];
            settle(&pairs, open, double::UNIT * W::DOUBLE, &mut sides);
            let settled = L::load(ray.scale.token(), &sides);
            side = L::select(mask, side, settled);
            mask = mask | settled.lt(zero) | settled.gt(zero);
        }
        let mask = culling.seen::<L>(
            mask,
            #[inline(always)]
            || side,
        );
        if !L::any(mask) {
            return;
        }
        if D::VALUES {
            // Without the interval, which is settled.
            let pairs = Unpacked::new(ray, triangle, [zero; 2]);
            let hit = values(&pairs, L::bits(mask), double::UNIT * W::DOUBLE);
            let token = ray.scale.token();
            let (beta, gamma) = (L::load(token, &hit.beta), L::load(token, &hit.gamma));
            found(mask, Hit { t: L::load(token, &hit.t), beta, gamma });
        } else {
            found(mask, Hit { t: zero, beta: zero, gamma: zero });
        }
    }
}

impl<W: Width, From: Normals> ExactMethod for Exact<W, From> {
    #[inline(always)]
    fn screen<L: Lanes>(
        ray: &BoundedRay<L>,
        triangle: &Of<Self::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(Screened<L>),
    ) {
        let n = From::normal(triangle);
        let triangle = From::sized(triangle);
        let volumes = Volumes::new(ray, triangle, n);
        let bound = filter::bound(ray, triangle, &volumes);
        let candidates = filter::candidates(&volumes, bound);
        if !L::any(candidates) {
            return;
        }
        let bounds = (bound, candidates);
        let screened = filter::screened(triangle, &volumes, bounds, &interval, W::FILTER);
        let certain = culling.seen::<L>(
            screened.certain,
            #[inline(always)]
            || volumes.u,
        );
        found(Screened { certain, ..screened });
    }

    #[inline(always)]
    fn corners<X: Value>(triangle: &Of<Self::Prepared, X>) -> Triangle<X> {
        From::sized(triangle).corners()
    }

    #[inline(always)]
    fn values<L: Lanes, X: Scalar, const N: usize>(
        rays: &Ray<&[X; N]>,
        triangles: &Triangle<[X; N]>,
        hits: u64,
    ) -> Hit<[X; N]> {
        let Triangle { a, b, c } = triangles;
        ladder::values::<L, X, N>(
            #[inline(always)]
            |place| {
                let (o, d) = (vector_at(rays.o, place), vector_at(rays.d, place));
                let (a, b) = (vector_at(a.each_ref(), place), vector_at(b.each_ref(), place));
                let c = vector_at(c.each_ref(), place);
                // Without the interval, which is settled.
                (Ray { o, d, tmin: 0.0, tmax: 0.0 }, Triangle { a, b, c })
            },
            hits,
            double::UNIT * W::DOUBLE,
        )
    }

    fn order<X: Scalar>(
        ray: &Ray<X>,
        first: &Of<Self::Prepared, X>,
        second: &Of<Self::Prepared, X>,
    ) -> Ordering {
        let triangles = [&Self::corners(first), &Self::corners(second)];
        closest::order_within(ray, triangles, double::UNIT * W::DOUBLE)
    }

    fn owns<X: Scalar>(ray: &Ray<X>, triangle: &Of<Self::Prepared, X>) -> bool {
        let precision = const { Precision::of_size(size_of::<X>()) };
        let triangle = widened(&Self::corners(triangle));
        ladder::owns(precision, &ray.map(|x| x.to_f64()), &triangle, double::UNIT * W::DOUBLE)
    }

    fn is_on<X: Scalar>(point: Vec3<X>, triangle: &Of<Self::Prepared, X>) -> bool {
        let precision = const { Precision::of_size(size_of::<X>()) };
        solid::is_on(precision, point.map(X::to_f64), &widened(&Self::corners(triangle)))
    }
}

/// Vectors of pairs, number by number and lane by lane.
struct Unpacked<X> {
    rows: [[X; BLOCK]; 17],
}

/// Writes the lanes of a vector to three rows.
#[inline(always)]
fn store<L: Lanes>(vector: Vec3<L>, rows: &mut [[L::Elem; BLOCK]; 17], row: usize) {
    vector.x.store(&mut rows[row]);
    vector.y.store(&mut rows[row + 1]);
    vector.z.store(&mut rows[row + 2]);
}

impl<X: Scalar> Unpacked<X> {
    #[inline(always)]
    fn new<L: Lanes<Elem = X>>(
        ray: &BoundedRay<L>,
        triangle: &SizedTriangle<L>,
        [tmin, tmax]: [L; 2],
    ) -> Self {
        let mut rows = [[X::from_f64(0.0); BLOCK]; 17];
        let SizedTriangle { a, b, c, .. } = *triangle;
        // One by one: a loop over the vectors would keep them in memory, in the loop around as well.
        store(ray.o, &mut rows, 0);
        store(ray.d, &mut rows, 3);
        store(a, &mut rows, 6);
        store(b, &mut rows, 9);
        store(c, &mut rows, 12);
        tmin.store(&mut rows[15]);
        tmax.store(&mut rows[16]);
        Self { rows }
    }

    /// One pair, in f64, which holds it exactly.
    fn pair(&self, lane: usize) -> (Ray<f64>, Triangle<f64>) {
        let number = |row: usize| self.rows[row][lane].to_f64();
        let vector = |row: usize| Vec3::new(number(row), number(row + 1), number(row + 2));
        let ray = Ray { o: vector(0), d: vector(3), tmin: number(15), tmax: number(16) };
        (ray, Triangle { a: vector(6), b: vector(9), c: vector(12) })
    }
}

/// Settles the lanes that are open: 1 for a hit of the front, −1 for one of the back, 0 for a miss;
/// leaves all others.
#[inline(never)]
fn settle<X: Scalar>(pairs: &Unpacked<X>, open: u64, unit: f64, sides: &mut [X; BLOCK]) {
    let precision = const { Precision::of_size(size_of::<X>()) };
    for lane in lanes_of(open) {
        let (ray, triangle) = pairs.pair(lane);
        sides[lane] = X::from_f64(match ladder::outcome(precision, &ray, &triangle, unit) {
            Outcome::Miss => 0.0,
            Outcome::Front => 1.0,
            Outcome::Back => -1.0,
        });
    }
}

/// The values of the lanes that hit, each rounded once. They are few: one after the other.
#[inline(never)]
fn values<X: Scalar>(pairs: &Unpacked<X>, hits: u64, unit: f64) -> Hit<[X; BLOCK]> {
    let zeros = [X::from_f64(0.0); BLOCK];
    let mut all = Hit { t: zeros, beta: zeros, gamma: zeros };
    for lane in lanes_of(hits) {
        let hit = ladder::values::<X, X, 1>(|_| pairs.pair(lane), 1, unit);
        (all.t[lane], all.beta[lane], all.gamma[lane]) = (hit.t[0], hit.beta[0], hit.gamma[0]);
    }
    all
}

/// One of many vectors, in f64, which holds it exactly.
#[inline(always)]
fn vector_at<X: Scalar, const N: usize>(vectors: Vec3<&[X; N]>, place: usize) -> Vec3<f64> {
    let Vec3 { x, y, z } = vectors;
    Vec3::new(x[place].to_f64(), y[place].to_f64(), z[place].to_f64())
}

/// The places of the bits that are set, of the lanes of a block.
fn lanes_of(mut bits: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < BLOCK).then_some(lane)
    })
}

/// The same triangle, in f64, which holds it exactly.
fn widened<X: Scalar>(triangle: &Triangle<X>) -> Triangle<f64> {
    triangle.map(|x| x.to_f64())
}

trisect_method::methods!(Exact; in trees: ExactInTrees);
