//! Every form of every method, with the kernel that it is held to, and pairs to hold it to that with.

// Each test uses a part of it.
#![allow(dead_code, reason = "each test uses a part of it")]

use trisect_core::{Float, FloatFormat, Hit, Ray, Triangle};
use trisect_formula::Formula;
use trisect_kernels::intersect_with;
use trisect_method::{
    Culling, DecisionOnly, Deferred, Division, Early, Form, Method, MethodVisitor, TrueDivision,
};
use trisect_workloads::Stress;

/// A kernel of one ray and one triangle.
pub(crate) type Kernel<E> = fn(&Ray<E>, &Triangle<E>) -> Option<Hit<E>>;

/// A form of a method.
pub(crate) struct Subject<E> {
    /// The method as graphs.
    pub(crate) formula: Formula,
    /// When it divides.
    pub(crate) form: Form,
    /// What it is held to.
    pub(crate) kernel: Kernel<E>,
}

impl<E> Subject<E> {
    /// The method and the form, as part of a name.
    pub(crate) fn name(&self) -> String {
        format!("{}_{}", self.formula.info.name, self.form).replace('-', "_")
    }
}

struct Collect<E>(Vec<Subject<E>>);

fn kernel<M: Method, D: Division, E: Float>(
    ray: &Ray<E>,
    triangle: &Triangle<E>,
) -> Option<Hit<E>> {
    intersect_with::<M, D, E>(ray, triangle, Culling::None)
}

impl<E: Float> MethodVisitor for Collect<E> {
    fn visit<M: Method>(&mut self) {
        let formula = Formula::of::<M>(E::FORMAT);
        for test in &formula.tests {
            let kernel: Kernel<E> = match test.form {
                Form::Early => kernel::<M, Early<TrueDivision, true>, E>,
                Form::Deferred if M::INFO.claims.exact => {
                    kernel::<M, DecisionOnly<Deferred<TrueDivision, true>>, E>
                }
                Form::Deferred => kernel::<M, Deferred<TrueDivision, true>, E>,
            };
            self.0.push(Subject { formula: formula.clone(), form: test.form, kernel });
        }
    }
}

/// Every form of every method.
pub(crate) fn subjects<E: Float>() -> Vec<Subject<E>> {
    let mut collect = Collect(Vec::new());
    trisect_all_methods::each_method(&mut collect);
    collect.0
}

/// Pairs of every family of hard ones, a quarter of them aimed at edges and corners, `each` of a level.
pub(crate) fn pairs<E: Float>(each: usize) -> Vec<(Ray<E>, Triangle<E>)> {
    let mut pairs = Vec::new();
    for family in Stress::ALL {
        for level in family.levels::<E>() {
            pairs.extend(family.pairs::<E>(1, level, each));
        }
    }
    let hard = pairs.len();
    for family in [Stress::NearEdge, Stress::NearVertex] {
        // Aimed at them exactly, but for the rounding of the direction.
        pairs.extend(family.pairs::<E>(2, 0.0, hard / 6));
    }
    pairs
}

/// What an `f32` kernel and a program that was written answer: whether, and where.
pub(crate) const MISS: f32 = 0.0;
/// See [`MISS`].
pub(crate) const HIT: f32 = 1.0;
/// See [`MISS`].
pub(crate) const OPEN: f32 = 2.0;

/// The format that programs are written in here.
pub(crate) const FORMAT: FloatFormat = FloatFormat::F32;

/// The numbers of a pair in the order of a program's parameters, the triangle as kernels get it.
pub(crate) fn numbers((ray, triangle): &(Ray<f32>, Triangle<f32>)) -> [f32; 17] {
    let Triangle { a, b, c } = triangle.or_nothing();
    let mut numbers = [0.0; 17];
    numbers[..3].copy_from_slice(&ray.o.to_array());
    numbers[3..6].copy_from_slice(&ray.d.to_array());
    numbers[6..8].copy_from_slice(&[ray.tmin, ray.tmax]);
    for (place, corner) in [a, b, c].into_iter().enumerate() {
        numbers[8 + 3 * place..11 + 3 * place].copy_from_slice(&corner.to_array());
    }
    numbers
}
