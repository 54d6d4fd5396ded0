//! A workload with the oracle's answers: what variants are measured against.

use std::sync::Arc;

use rayon::prelude::*;
use trisect_core::{Float, FloatFormat, Hit, Ray, Triangle};
use trisect_oracle::{Class, Condition, Oracle};

use crate::comparison::record::{Family, Workload};

/// Rays and triangles, as the kernels of each precision get them.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    /// The rays in f32.
    pub rays: Vec<Ray<f32>>,
    /// The triangles in f32.
    pub triangles: Vec<Triangle<f32>>,
    /// What these were rounded from; none where nothing was rounded, and f64 kernels get the same numbers.
    pub unrounded: Option<Unrounded>,
}

/// Rays and triangles in f64, some number of which f32 does not have.
#[derive(Clone, Debug)]
pub struct Unrounded {
    /// The rays.
    pub rays: Vec<Ray<f64>>,
    /// The triangles, as many as in f32.
    pub triangles: Vec<Triangle<f64>>,
    /// By how much rounding moves a corner at most, relative to the size of the whole.
    pub rounding: f64,
}

impl Inputs {
    /// The same numbers for both precisions.
    pub fn new(rays: Vec<Ray<f32>>, triangles: Vec<Triangle<f32>>) -> Self {
        Self { rays, triangles, unrounded: None }
    }

    /// Numbers in f32, those that they were rounded from, and by how much that moves a corner at most,
    /// relative to the size of the whole.
    ///
    /// # Panics
    /// When there are not as many of both.
    pub fn rounded(
        (rays, triangles): (Vec<Ray<f32>>, Vec<Triangle<f32>>),
        from: (Vec<Ray<f64>>, Vec<Triangle<f64>>),
        rounding: f64,
    ) -> Self {
        assert_eq!((rays.len(), triangles.len()), (from.0.len(), from.1.len()));
        let is_same = rays.iter().zip(&from.0).all(|(ray, from)| Ray::from(*ray) == *from)
            && triangles.iter().zip(&from.1).all(|(t, from)| Triangle::from(*t) == *from);
        let (rays_f64, triangles_f64) = from;
        let unrounded = Unrounded { rays: rays_f64, triangles: triangles_f64, rounding };
        let unrounded = (!is_same).then_some(unrounded);
        Self { rays, triangles, unrounded }
    }
}

/// A pair that truly hits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth {
    pub ray: u32,
    pub triangle: u32,
    pub class: Class,
    /// Each number is the true one, rounded to f64 once.
    pub hit: Hit<f64>,
    /// How far rounding can move each.
    pub condition: Condition,
}

/// What the oracle says about rays and triangles.
#[derive(Default)]
pub(crate) struct Known {
    /// The pairs that truly hit, by ray, then triangle.
    pub truth: Vec<Truth>,
    /// Pairs per class, in the order of [`Class::ALL`].
    pub class_counts: Vec<u64>,
    /// The true closest triangle of each ray.
    pub closest: Vec<Option<u32>>,
    /// Pairs that the oracle was asked about, and those of them that needed exact arithmetic.
    tests: [u64; 2],
}

/// Rays and triangles in one precision, with what the oracle says about them.
pub(crate) struct Side<E> {
    pub rays: Vec<Ray<E>>,
    pub triangles: Vec<Triangle<E>>,
    known: Arc<Known>,
}

/// A [`Side`], whatever its precision.
pub(crate) trait Judged {
    /// A ray, as it is.
    fn ray(&self, number: u32) -> Ray<f64>;
    /// A triangle, as it is.
    fn triangle(&self, number: u32) -> Triangle<f64>;
    /// The oracle's class of a pair.
    fn class(&self, ray: u32, triangle: u32) -> Class;
    /// The oracle's answers.
    fn known(&self) -> &Known;
}

impl<E: Float> Judged for Side<E>
where
    Ray<f64>: From<Ray<E>>,
    Triangle<f64>: From<Triangle<E>>,
{
    fn ray(&self, number: u32) -> Ray<f64> {
        self.rays[number as usize].into()
    }

    fn triangle(&self, number: u32) -> Triangle<f64> {
        self.triangles[number as usize].into()
    }

    fn class(&self, ray: u32, triangle: u32) -> Class {
        let truth = &self.known.truth;
        match truth.binary_search_by_key(&(ray, triangle), |t| (t.ray, t.triangle)) {
            Ok(place) => truth[place].class,
            Err(_) => Oracle::default()
                .classify(&self.rays[ray as usize], &self.triangles[triangle as usize]),
        }
    }

    fn known(&self) -> &Known {
        &self.known
    }
}

/// A workload in both precisions. Each is judged by the numbers that its kernels get: those of f32
/// are what the input rounds to.
pub(crate) struct Subject {
    pub workload: Workload,
    pub single: Side<f32>,
    pub double: Side<f64>,
    /// Whether both hold the same numbers.
    pub is_same: bool,
}

impl Subject {
    /// Asks the oracle about every pair, on all processors.
    pub(crate) fn new(name: String, description: String, family: Family, inputs: Inputs) -> Self {
        let Inputs { rays, triangles, unrounded } = inputs;
        let known = Arc::new(Known::of(&rays, &triangles));
        let is_same = unrounded.is_none();
        let double = match unrounded {
            None => Side {
                rays: rays.iter().map(|&ray| ray.into()).collect(),
                triangles: triangles.iter().map(|&triangle| triangle.into()).collect(),
                known: Arc::clone(&known),
            },
            Some(Unrounded { rays, triangles, .. }) => {
                let known = Arc::new(Known::of(&rays, &triangles));
                Side { rays, triangles, known }
            }
        };
        let pairs = (rays.len() * triangles.len()).max(1) as f64;
        let [oracle_tests, oracle_exact] = known.tests;
        Self {
            workload: Workload {
                name,
                description,
                family,
                rays: rays.len(),
                triangles: triangles.len(),
                hit_rate: known.truth.len() as f64 / pairs,
                oracle_tests,
                oracle_exact,
            },
            single: Side { rays, triangles, known },
            double,
            is_same,
        }
    }

    /// What kernels of a precision are judged by.
    pub(crate) fn of(&self, precision: FloatFormat) -> &dyn Judged {
        match precision {
            FloatFormat::F32 => &self.single,
            FloatFormat::F64 => &self.double,
        }
    }
}

/// What one ray contributes.
#[derive(Default)]
pub(crate) struct OfRay {
    /// The pairs that hit, by triangle.
    pub truth: Vec<Truth>,
    pub closest: Option<u32>,
    classes: Vec<u64>,
    tests: [u64; 2],
}

impl Known {
    fn of<E: Float>(rays: &[Ray<E>], triangles: &[Triangle<E>]) -> Self
    where
        Ray<f64>: From<Ray<E>>,
        Triangle<f64>: From<Triangle<E>>,
    {
        let per_ray: Vec<OfRay> = (0_u32..)
            .zip(rays)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(number, ray)| ask(number, ray, (0..).zip(triangles)))
            .collect();
        let mut known = Self { class_counts: vec![0; Class::ALL.len()], ..Self::default() };
        for of_ray in per_ray {
            for (sum, count) in known.class_counts.iter_mut().zip(&of_ray.classes) {
                *sum += count;
            }
            known.truth.extend(of_ray.truth);
            known.closest.push(of_ray.closest);
            known.tests = [0, 1].map(|which| known.tests[which] + of_ray.tests[which]);
        }
        known
    }
}

/// Asks the oracle about a ray and each of some triangles, which come by number.
pub(crate) fn ask<'a, E: Float>(
    number: u32,
    ray: &Ray<E>,
    triangles: impl Iterator<Item = (u32, &'a Triangle<E>)>,
) -> OfRay
where
    Ray<f64>: From<Ray<E>>,
    Triangle<f64>: From<Triangle<E>>,
{
    let mut oracle = Oracle::default();
    let mut of_ray = OfRay { classes: vec![0; Class::ALL.len()], ..OfRay::default() };
    let mut hit = Vec::new();
    for (triangle_number, triangle) in triangles {
        let class = oracle.classify(ray, triangle);
        of_ray.classes[class as usize] += 1;
        if class.is_hit() {
            hit.push((triangle_number, Triangle::from(*triangle), class));
        }
    }
    of_ray.tests = [oracle.tests(), oracle.exact()];
    // Values rounded to f64 need exact arithmetic as a rule: not counted as a fallback.
    let mut oracle = Oracle::default();
    let wide: Ray<f64> = (*ray).into();
    for &(triangle, wide_triangle, class) in &hit {
        if let Some(hit) = oracle.intersect(&wide, &wide_triangle).hit {
            let condition = oracle.truth(&wide, &wide_triangle).condition;
            of_ray.truth.push(Truth { ray: number, triangle, class, hit, condition });
        }
    }
    let triangles: Vec<Triangle<f64>> = hit.iter().map(|&(_, triangle, _)| triangle).collect();
    of_ray.closest = oracle.closest(&wide, &triangles).map(|(place, _)| hit[place].0);
    of_ray
}

#[cfg(test)]
mod tests {
    use trisect_core::Vec3;

    use super::*;

    /// So far from the origin that f32 has no quarters left.
    #[test]
    fn each_precision_is_judged_by_its_own_numbers() {
        const FAR: f64 = 8_388_608.0;
        let corner = |x: f64, y: f64| Vec3::new(FAR + x, y, 0.0);
        let triangle = Triangle::new(corner(0.25, 0.0), corner(4.25, 0.0), corner(0.25, 4.0));
        let ray = Ray::<f64>::new([FAR + 1.75, 1.0, 3.0], [0.0, 0.0, -1.0]);
        let narrow = |v: Vec3<f64>| v.map(<f32 as trisect_core::Scalar>::from_f64);
        let [a, b, c] = triangle.corners().map(narrow);
        let rounded =
            Ray { o: narrow(ray.o), d: narrow(ray.d), tmin: 0.0_f32, tmax: f32::INFINITY };
        let inputs = Inputs::rounded(
            (vec![rounded], vec![Triangle::new(a, b, c)]),
            (vec![ray], vec![triangle]),
            0.1,
        );
        assert!(inputs.unrounded.is_some());
        let subject = Subject::new("far".into(), "far".into(), Family::Mesh, inputs);
        let beta = |precision| subject.of(precision).known().truth[0].hit.beta;
        assert_eq!((beta(FloatFormat::F32), beta(FloatFormat::F64)), (0.5, 0.375));
        let x = |precision| subject.of(precision).triangle(0).a.x - FAR;
        assert_eq!((x(FloatFormat::F32), x(FloatFormat::F64)), (0.0, 0.25));
    }

    #[test]
    fn nothing_is_kept_twice_that_was_not_rounded() {
        let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        let triangle = Triangle::new(corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0));
        let ray = Ray::<f32>::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
        let wide = (vec![Ray::from(ray)], vec![Triangle::from(triangle)]);
        let inputs = Inputs::rounded((vec![ray], vec![triangle]), wide, 0.0);
        assert!(inputs.unrounded.is_none());
    }
}
