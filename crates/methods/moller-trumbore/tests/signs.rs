//! Tests by sign bits decide as comparisons do, but where a numerator is zero.

use trisect_core::{Hit, Ray, Triangle, Vec3};
use trisect_kernels::{PreparedPair, intersect_with};
use trisect_method::{
    Alpha as _, BySigns, Culling, Deferred, Division, Interval, Method as _, TrueDivision,
};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_oracle::Oracle;
use trisect_workloads::{Pair, Stress};

type Signs = BySigns<TrueDivision, true>;
type Compared = Deferred<TrueDivision, true>;
type TFirst = Deferred<TrueDivision, true, true>;

fn triangle() -> Triangle<f32> {
    Triangle::new(Vec3::new(0.0, 0.0, 0.0), Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0))
}

/// Along the third axis through a point, from one side or the other.
fn through(x: f32, y: f32, side: f32) -> Ray<f32> {
    Ray { o: Vec3::new(x, y, side), d: Vec3::new(0.0, 0.0, -side), tmin: 0.0, tmax: 10.0 }
}

fn hit<D: Division>(ray: &Ray<f32>, triangle: &Triangle<f32>) -> Option<Hit<f32>> {
    intersect_with::<MollerTrumbore, D, f32>(ray, triangle, Culling::None)
}

fn numbers(hit: Option<Hit<f32>>) -> Option<[f32; 3]> {
    hit.map(|Hit { t, beta, gamma }| [t, beta, gamma])
}

#[test]
fn points_off_the_edges_are_decided_alike() {
    let mut hits = 0;
    // No half of a whole number and a quarter lies on an edge.
    for (x, y) in (-4..12).flat_map(|x| (-4..12).map(move |y| (x, y))) {
        for side in [-1.0, 1.0] {
            let at = |i: i16| f32::from(i) / 2.0 + 0.125;
            let ray = through(at(x), at(y), side);
            let compared = hit::<Compared>(&ray, &triangle());
            hits += i32::from(compared.is_some());
            assert_eq!(numbers(hit::<Signs>(&ray, &triangle())), numbers(compared), "{ray:?}");
            assert_eq!(numbers(hit::<TFirst>(&ray, &triangle())), numbers(compared), "{ray:?}");
        }
    }
    assert!(hits > 50, "{hits} hits");
}

#[test]
fn an_edge_is_hit_from_one_side_alone() {
    // gamma is zero; what beta and gamma leave is not.
    let sides = [1.0, -1.0].map(|side| through(1.0, 0.0, side));
    let [compared, signs] = [hit::<Compared>, hit::<Signs>]
        .map(|hit| sides.iter().filter(|ray| hit(ray, &triangle()).is_some()).count());
    assert_eq!((compared, signs), (2, 1));
}

#[test]
fn nothing_is_hit_where_there_is_nothing() {
    let ray = through(1.0, 1.0, 1.0);
    assert!(hit::<Signs>(&ray, &triangle()).is_some());
    assert!(hit::<Signs>(&ray, &Triangle::nothing()).is_none());
    for (tmin, tmax) in [(2.0, 0.5), (f32::NAN, 10.0), (0.0, f32::NAN), (1.5, 9.0), (0.0, 0.5)] {
        assert!(hit::<Signs>(&Ray { tmin, tmax, ..ray }, &triangle()).is_none(), "{tmin} {tmax}");
    }
}

/// Whether a numerator of a pair is zero or NaN, so that its sign means nothing.
fn is_on_a_border(ray: &Ray<f32>, triangle: &Triangle<f32>) -> bool {
    let pair = PreparedPair::<MollerTrumbore, f32>::new(ray, triangle);
    let h = MollerTrumbore::intersect(&pair.ray, &pair.triangle);
    let Interval { tmin, tmax } = Interval::of(ray);
    let ends = [h.t - tmin * h.det, tmax * h.det - h.t];
    let alpha = h.alpha.weight(h.beta, h.gamma, h.det);
    [h.beta, h.gamma, alpha, ends[0], ends[1]].iter().any(|x| *x == 0.0 || x.is_nan())
}

/// False hits and false misses.
fn wrong<D: Division>(pairs: &[Pair<f32>]) -> [usize; 2] {
    let mut oracle = Oracle::default();
    let mut wrong = [0; 2];
    for (ray, triangle) in pairs {
        let (found, is_true) =
            (hit::<D>(ray, triangle).is_some(), oracle.classify(ray, triangle).is_hit());
        wrong[0] += usize::from(found && !is_true);
        wrong[1] += usize::from(!found && is_true);
    }
    wrong
}

/// Pairs with zeros for numerators: the decisions that differ from the oracle's, by comparisons and by signs.
#[test]
fn borders_are_decided_by_the_sign_of_zero() {
    let counted = [
        (Stress::NearEdge, &[0.0][..]),
        (Stress::NearVertex, &[0.0]),
        (Stress::IntervalEnd, &[0.0]),
        (Stress::NearCollinear, &[0.0]),
        // Coordinates on a lattice, where nothing is rounded: comparisons are right, and signs lose hits.
        (Stress::AxisAligned, &[0.0, 1.0, 2.0]),
        (Stress::RandomBits, &[0.0]),
    ]
    .map(|(family, levels)| {
        let pairs = levels.iter().flat_map(|&level| family.pairs::<f32>(1, level, 2048));
        let pairs: Vec<Pair<f32>> = pairs.collect();
        for (ray, triangle) in &pairs {
            let [compared, signs] =
                [hit::<Compared>, hit::<Signs>].map(|hit| hit(ray, triangle).is_some());
            assert!(compared == signs || is_on_a_border(ray, triangle), "{ray:?} {triangle:?}");
        }
        (family.name(), wrong::<Compared>(&pairs), wrong::<Signs>(&pairs))
    });
    assert_eq!(
        counted,
        [
            ("near-edge", [524, 245], [394, 401]),
            ("near-vertex", [645, 149], [414, 206]),
            ("interval-end", [429, 172], [292, 332]),
            ("near-collinear", [217, 243], [117, 291]),
            ("axis-aligned", [0, 0], [0, 943]),
            ("random-bits", [4, 453], [20, 452]),
        ]
    );
}
