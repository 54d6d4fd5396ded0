//! A method as values: pointers to functions that are compiled for it.

use trisect_core::{Float, Hit, Ray, Scalar, Triangle, Vec3};
use trisect_kernels::{PreparedPair, intersect_with};
use trisect_method::{
    Alpha as _, Culling, Deferred, Division, Early, Form, Method, MethodInfo, Output, TrueDivision,
};
use trisect_oracle::Exact;

use crate::kernels::Lists;

/// A test of one ray against one triangle, prepared on the spot.
pub(crate) type Test<E> = fn(&Ray<E>, &Triangle<E>, Culling) -> Option<Hit<E>>;

/// A method under test. Whatever holds it to something reaches it through these pointers, so that the tests
/// are compiled once and not for each method.
pub struct Subject {
    pub(crate) info: MethodInfo,
    f32: Vec<(Form, Test<f32>)>,
    f64: Vec<(Form, Test<f64>)>,
    /// What the formula answers over exact numbers, in each form that the method has.
    pub(crate) exact: fn(&Ray<Exact>, &Triangle<Exact>) -> Vec<ExactAnswer>,
    /// The normal, where the method gives one.
    pub(crate) normal: fn(&Ray<Exact>, &Triangle<Exact>) -> Option<Vec3<Exact>>,
    /// The kernels in f32 and f64.
    pub(crate) lists: [Lists; 2],
}

/// What a formula answers over exact numbers.
pub(crate) struct ExactAnswer {
    pub(crate) form: Form,
    pub(crate) hit: Hit<Exact>,
    /// Whether the point is in the closed triangle.
    pub(crate) inside: bool,
    /// Positive where the front is seen.
    pub(crate) facing: Exact,
}

impl Subject {
    /// The method `M`.
    pub fn of<M: Method>() -> Self {
        Self {
            info: M::INFO,
            f32: tests::<M, f32>(),
            f64: tests::<M, f64>(),
            exact: exact::<M>,
            normal: normal::<M>,
            lists: [Lists::of::<M, f32>(), Lists::of::<M, f64>()],
        }
    }

    /// Whether the method gives weights.
    pub(crate) fn weighs(&self) -> bool {
        self.info.gives(Output::Barycentrics)
    }

    /// What the method gives of a hit: zeros for weights that it does not give.
    pub(crate) fn given<E: Scalar>(&self, hit: Hit<E>) -> Hit<E> {
        if self.weighs() {
            return hit;
        }
        let zero = E::from_f64(0.0);
        Hit { t: hit.t, beta: zero, gamma: zero }
    }
}

/// A precision that methods are tested in.
pub(crate) trait Tests: Float {
    /// The forms that the method has, with the true division.
    fn tests(subject: &Subject) -> &[(Form, Test<Self>)];
}

impl Tests for f32 {
    fn tests(subject: &Subject) -> &[(Form, Test<Self>)] {
        &subject.f32
    }
}

impl Tests for f64 {
    fn tests(subject: &Subject) -> &[(Form, Test<Self>)] {
        &subject.f64
    }
}

fn tests<M: Method, E: Scalar>() -> Vec<(Form, Test<E>)> {
    let mut tests: Vec<(_, Test<E>)> = Vec::new();
    if const { M::INFO.forms.early() } {
        tests.push((Form::Early, test::<M, Early<TrueDivision, true>, E>));
    }
    if const { M::INFO.forms.deferred() } {
        tests.push((Form::Deferred, test::<M, Deferred<TrueDivision, true>, E>));
    }
    tests
}

fn test<M: Method, D: Division, E: Scalar>(
    ray: &Ray<E>,
    triangle: &Triangle<E>,
    culling: Culling,
) -> Option<Hit<E>> {
    let hit = intersect_with::<M, D, E>(ray, triangle, culling)?;
    let weights = |weight| {
        if const { M::INFO.gives(Output::Barycentrics) } { weight } else { E::from_f64(0.0) }
    };
    Some(Hit { t: hit.t, beta: weights(hit.beta), gamma: weights(hit.gamma) })
}

fn exact<M: Method>(ray: &Ray<Exact>, triangle: &Triangle<Exact>) -> Vec<ExactAnswer> {
    let one = Exact::from_f64(1.0);
    let prepared = PreparedPair::<M, Exact>::new(ray, triangle);
    let facing = |det| M::facing(&prepared.ray, &prepared.triangle, det);
    let mut answers = Vec::new();
    if const { M::INFO.forms.early() } {
        let q = M::intersect_early(&prepared.ray, &prepared.triangle, |x| one / x);
        let inside = q.alpha.inside(q.beta, q.gamma, one);
        answers.push(ExactAnswer {
            form: Form::Early,
            hit: q.hit(),
            inside,
            facing: facing(q.det),
        });
    }
    if const { M::INFO.forms.deferred() } {
        let h = M::intersect(&prepared.ray, &prepared.triangle);
        let hit = Hit { t: h.t / h.det, beta: h.beta / h.det, gamma: h.gamma / h.det };
        let facing = facing(h.det);
        let p = h.positive();
        let inside = p.alpha.inside(p.beta, p.gamma, p.det);
        answers.push(ExactAnswer { form: Form::Deferred, hit, inside, facing });
    }
    answers
}

fn normal<M: Method>(ray: &Ray<Exact>, triangle: &Triangle<Exact>) -> Option<Vec3<Exact>> {
    let axis = if M::TURNS { ray.d.largest_axis() } else { 2 };
    let pair = PreparedPair::<M, Exact>::new(ray, triangle);
    let normal = M::normal::<Exact>(&pair.triangle, pair.group);
    normal.map(|normal| normal.with_axis_restored(axis))
}
