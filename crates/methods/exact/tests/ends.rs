//! The exact method and the oracle agree on where intervals end.

use trisect_core::{Float, Hit, Ray, Triangle, Vec3};
use trisect_exact::Exact;
use trisect_kernels::{PreparedTriangles, one_ray};
use trisect_method::{Culling, Deferred, TrueDivision};
use trisect_oracle::Oracle;

/// The hit of the kernel, in plain arithmetic.
fn kernel<E: Float>(ray: &Ray<E>, triangle: Triangle<E>) -> Option<Hit<E>> {
    let prepared = PreparedTriangles::<Exact, E>::new(&[triangle]).expect("it takes all meshes");
    let mut found = None;
    one_ray::<Exact, E, Deferred<TrueDivision, true>>(
        (),
        ray,
        &prepared,
        Culling::None,
        |_, met, hit| found = met.then_some(hit).or(found),
    );
    found
}

#[test]
fn the_interval_ends_at_half_the_largest_number() {
    fn check<E: Float + std::fmt::Debug>() {
        let number = E::from_f64;
        let zero = number(0.0);
        let one = number(1.0);
        let triangle = Triangle {
            a: Vec3::new(zero, zero, zero),
            b: Vec3::new(one, zero, zero),
            c: Vec3::new(zero, one, zero),
        };
        let end = E::largest_t();
        let above = end.to_f64() / (1.0 - E::UNIT_ROUNDOFF);
        // `t` is the distance times 2 to the 125th or the 1021st.
        let speed = 4.0 / above;
        let (mut hits, mut misses) = (0, 0);
        for units in [-3.0, -2.0, -1.0, 0.0, 2.0, 4.0] {
            for side in [1.0, -1.0] {
                let distance = 4.0 * (1.0 + units * E::UNIT_ROUNDOFF) * side;
                let quarter = number(0.25);
                let o = Vec3::new(quarter, quarter, number(-distance));
                let d = Vec3::new(zero, zero, number(speed));
                for tau in [f64::INFINITY, above, end.to_f64()] {
                    let ray = Ray { o, d, tmin: number(-tau), tmax: number(tau) };
                    let truth = Oracle::default().intersect(&ray, &triangle).hit;
                    assert_eq!(kernel(&ray, triangle), truth, "{ray:?}");
                    let is_hit = truth.is_some();
                    assert_eq!(is_hit, units < 0.0, "{ray:?}");
                    assert!(truth.is_none_or(|hit| hit.t.to_f64().abs() <= end.to_f64()));
                    hits += usize::from(is_hit);
                    misses += usize::from(!is_hit);
                }
            }
        }
        assert_eq!((hits, misses), (18, 18));
    }
    check::<f32>();
    check::<f64>();
    // As files may have them, with a subnormal direction: `t` would be 10⁴⁰ and more.
    let triangle = Triangle::<f32>::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    for along in [1e-40, 1e-45] {
        let ray = Ray::<f32>::new([0.25, 0.25, -1.0], [0.0, 0.0, along]);
        assert_eq!(kernel(&ray, triangle), None);
        assert_eq!(Oracle::default().intersect(&ray, &triangle).hit, None);
    }
}
