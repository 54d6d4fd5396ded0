//! What a method costs, counted from the very formula that runs.

use crate::counting::{Counting, Ops, counted};
use trisect_core::{Ray, Triangle, Vec3};
use trisect_method::Method;
use trisect_method::{Culling, Deferred, Division, Early, Interval, TrueDivision};
use trisect_method::{Of, Record};

/// Operations of each part of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost {
    /// Finding a triangle's kind and preparing it.
    pub prepare: Ops,
    /// Preparing a ray for triangles of one kind.
    pub per_ray: Ops,
    /// The test that divides first, to the hit; where the method has it.
    pub test_early: Option<Ops>,
    /// The test that divides last, to the decision; where the method has it.
    pub test_deferred: Option<Ops>,
    /// From the deferred decision to the hit.
    pub finish_deferred: Option<Ops>,
    /// Numbers stored per triangle.
    pub stored_numbers: usize,
    /// Numbers kept per ray.
    pub ray_numbers: usize,
}

/// Counts the operations of method `M`, with the true division and without culling.
///
/// # Panics
/// When `M` decides the sample pair wrongly.
pub fn cost<M: Method>() -> Cost {
    let number = Counting::data;
    let vector = |x, y, z| Vec3::new(number(x), number(y), number(z));
    let triangle =
        Triangle::new(vector(0.0, 0.0, 1.0), vector(4.0, 0.0, 2.0), vector(0.0, 4.0, 3.0));
    // Meets the triangle inside, at t = 2.75; longest along z, where a method that turns space
    // leaves it.
    let ray = |tmax| Ray {
        o: vector(1.0, 1.0, -1.0),
        d: vector(0.0, 0.0, 1.0),
        tmin: number(0.0),
        tmax: number(tmax),
    };
    let (prepare, (group, prepared)) = counted(|| {
        let group = M::group(&triangle);
        (group, M::prepare(&triangle, group))
    });
    // What is stored is data: a test that loads a 1 cannot leave out the product with it.
    let prepared = M::Prepared::map(&prepared, |&number| number.into_data());
    let (per_ray, prepared_ray) = counted(|| M::prepare_ray(&ray(4.0), group));
    // The interval is made ready once per ray, outside the count.
    let interval = |tmax| Interval { tmin: number(0.0), tmax: number(tmax) };
    let test = |tmax, test: TestOf<M>| {
        let mut hit = false;
        let (ops, ()) = counted(|| test(&prepared_ray, &prepared, interval(tmax), &mut hit));
        (ops, hit)
    };
    let test_early = M::INFO.forms.early().then(|| {
        let (ops, hit) = test(4.0, run::<M, Early<TrueDivision, true>>);
        assert!(hit, "the sample pair is decided wrongly");
        ops
    });
    let deferred = M::INFO.forms.deferred().then(|| {
        let (whole, hit) = test(4.0, run::<M, Deferred<TrueDivision, true>>);
        // Everything but t is in range: the early-out falls after the last comparison.
        let (decision, missed) = test(2.0, run::<M, Deferred<TrueDivision, true>>);
        assert!(hit && !missed, "the sample pair is decided wrongly");
        (decision, whole - decision)
    });
    Cost {
        prepare,
        per_ray,
        test_early,
        test_deferred: deferred.map(|(decision, _)| decision),
        finish_deferred: deferred.map(|(_, finish)| finish),
        stored_numbers: M::Prepared::NUMBERS,
        ray_numbers: size_of::<M::PreparedRay<f32>>() / size_of::<f32>(),
    }
}

type TestOf<M> = fn(
    &<M as Method>::PreparedRay<Counting>,
    &Of<<M as Method>::Prepared, Counting>,
    Interval<Counting>,
    &mut bool,
);

fn run<M: Method, D: Division>(
    ray: &M::PreparedRay<Counting>,
    triangle: &Of<M::Prepared, Counting>,
    interval: Interval<Counting>,
    hit: &mut bool,
) {
    M::test::<Counting, D>(ray, triangle, interval, Culling::None, |mask, _| *hit = mask);
}

impl Cost {
    /// The parts that the method has, by name.
    pub fn parts(&self) -> impl Iterator<Item = (&'static str, Ops)> {
        [
            ("prepare a triangle", Some(self.prepare)),
            ("prepare a ray", Some(self.per_ray)),
            ("test, early division", self.test_early),
            ("test, deferred division", self.test_deferred),
            ("finish a hit, deferred division", self.finish_deferred),
        ]
        .into_iter()
        .filter_map(|(part, ops)| Some((part, ops?)))
    }
}
