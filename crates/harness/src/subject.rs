//! A workload with the oracle's answers: what variants are measured against.

use rayon::prelude::*;
use trisect_core::{Hit, Ray, Triangle};
use trisect_oracle::{Class, Oracle};

use crate::record::{Family, Workload};

/// A pair that truly hits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth {
    pub ray: u32,
    pub triangle: u32,
    pub class: Class,
    /// Each number is the true one, rounded to f64 once.
    pub hit: Hit<f64>,
}

/// Rays and triangles in both precisions, with the truth about every pair.
pub(crate) struct Subject {
    pub workload: Workload,
    pub rays32: Vec<Ray<f32>>,
    pub triangles32: Vec<Triangle<f32>>,
    pub rays64: Vec<Ray<f64>>,
    pub triangles64: Vec<Triangle<f64>>,
    /// The pairs that truly hit, by ray, then triangle.
    pub truth: Vec<Truth>,
    /// Pairs per class, in the order of [`Class::ALL`].
    pub class_counts: Vec<u64>,
    /// The true closest triangle of each ray.
    pub closest: Vec<Option<u32>>,
}

/// What one ray contributes.
#[derive(Default)]
struct Answers {
    truth: Vec<Truth>,
    classes: Vec<u64>,
    closest: Option<u32>,
    tests: u64,
    exact: u64,
}

impl Subject {
    /// Asks the oracle about every pair, on all processors.
    pub(crate) fn new(
        name: String,
        description: String,
        family: Family,
        rays: Vec<Ray<f32>>,
        triangles: Vec<Triangle<f32>>,
    ) -> Self {
        let per_ray: Vec<Answers> = (0_u32..)
            .zip(&rays)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(number, ray)| ask(number, ray, &triangles))
            .collect();
        let mut class_counts = vec![0; Class::ALL.len()];
        let mut truth = Vec::new();
        let mut closest = Vec::new();
        let (mut tests, mut exact) = (0, 0);
        for answers in per_ray {
            for (sum, count) in class_counts.iter_mut().zip(&answers.classes) {
                *sum += count;
            }
            truth.extend(answers.truth);
            closest.push(answers.closest);
            tests += answers.tests;
            exact += answers.exact;
        }
        let pairs = (rays.len() * triangles.len()).max(1) as f64;
        Self {
            workload: Workload {
                name,
                description,
                family,
                rays: rays.len(),
                triangles: triangles.len(),
                hit_rate: truth.len() as f64 / pairs,
                oracle_tests: tests,
                oracle_exact: exact,
            },
            rays64: rays.iter().map(|&ray| ray.into()).collect(),
            triangles64: triangles.iter().map(|&triangle| triangle.into()).collect(),
            rays32: rays,
            triangles32: triangles,
            truth,
            class_counts,
            closest,
        }
    }

    /// The oracle's class of a pair.
    pub(crate) fn class(&self, ray: u32, triangle: u32) -> Class {
        match self.truth.binary_search_by_key(&(ray, triangle), |t| (t.ray, t.triangle)) {
            Ok(place) => self.truth[place].class,
            Err(_) => Oracle::default()
                .classify(&self.rays32[ray as usize], &self.triangles32[triangle as usize]),
        }
    }
}

fn ask(number: u32, ray: &Ray<f32>, triangles: &[Triangle<f32>]) -> Answers {
    let mut oracle = Oracle::default();
    let mut answers = Answers { classes: vec![0; Class::ALL.len()], ..Answers::default() };
    let mut hit_triangles = Vec::new();
    for (triangle_number, triangle) in (0_u32..).zip(triangles) {
        let class = oracle.classify(ray, triangle);
        answers.classes[class as usize] += 1;
        if class.is_hit() {
            hit_triangles.push((triangle_number, *triangle, class));
        }
    }
    answers.tests = oracle.tests();
    answers.exact = oracle.exact();
    // Values rounded to f64 need exact arithmetic as a rule: not counted as a fallback.
    let mut oracle = Oracle::default();
    let wide: Ray<f64> = (*ray).into();
    let triangles: Vec<Triangle<f64>> = hit_triangles.iter().map(|&(_, t, _)| t.into()).collect();
    for ((number_hit, _, class), triangle) in hit_triangles.iter().zip(&triangles) {
        if let Some(hit) = oracle.intersect(&wide, triangle).hit {
            answers.truth.push(Truth { ray: number, triangle: *number_hit, class: *class, hit });
        }
    }
    answers.closest = oracle.closest(&wide, &triangles).map(|(place, _)| hit_triangles[place].0);
    answers
}
