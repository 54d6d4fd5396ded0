//! One ray against one triangle, pair by pair.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use trisect_catalog::{Entry, Finder, Kernels};
use trisect_core::{Float, FloatFormat, Hit, Precision, Ray, Scalar, Triangle, Vec3};
use trisect_method::Culling;
use trisect_oracle::{Class, Condition, Oracle, Truth};
use trisect_workloads::Stress;

use super::measure::{Set, flushing_variant, spread, weighs};
use super::record::{Bin, ByCondition, Errors, FusedDifference, StressFamily, StressLevel};
use crate::answers::unit_in_last_place;
use crate::record::{Line, Variant};

/// Beyond this an answer is wrong to whom three digits are enough: of a decision, the distance of a
/// weight from 0, or of `t` from an end of the interval relative to itself; of a value, the error of
/// `t` relative to itself, or of a weight.
pub(super) const THOUSANDTH: f64 = 1.0 / 1024.0;

/// A pair with what is true of it.
#[derive(Clone)]
pub(super) struct TruePair<E> {
    ray: Ray<E>,
    triangle: Triangle<E>,
    truth: Truth,
    /// The true hit, rounded to f64 once.
    hit: Option<Hit<f64>>,
}

/// What a variant says of a pair.
pub(super) type Answer = Option<Hit<f64>>;

impl<E: Float> TruePair<E> {
    pub(super) fn new((ray, triangle): (Ray<E>, Triangle<E>)) -> Self {
        let mut oracle = Oracle::default();
        let truth = oracle.truth(&ray, &triangle);
        let (wide_ray, wide_triangle) = widen(&ray, &triangle);
        let hit = oracle.intersect(&wide_ray, &wide_triangle).hit;
        Self { ray, triangle, truth, hit }
    }

    pub(super) fn widened(&self) -> TruePair<f64> {
        let (ray, triangle) = widen(&self.ray, &self.triangle);
        TruePair { ray, triangle, truth: self.truth, hit: self.hit }
    }

    /// Hands out what each finder says. A method that cannot take the triangle says nothing.
    pub(super) fn ask(
        &self,
        kernels: &Kernels<E>,
        finders: &[&Finder],
        mut said: impl FnMut(usize, Answer),
    ) where
        E: Precision,
    {
        let scene = (kernels.prepare)(&[self.triangle], &[self.ray]);
        for (number, finder) in finders.iter().enumerate() {
            let mut answer = None;
            if let Ok(scene) = &scene {
                finder.find(scene, Culling::None, &mut |_, _, hit| {
                    answer = Some(hit);
                    ControlFlow::Break(())
                });
            }
            said(number, answer);
        }
    }

    /// How far the decision is from another one: the smallest distance of a weight from 0, or of `t`
    /// from an end of the interval relative to `t`; nothing where the ray is parallel to the plane.
    fn clearance(&self) -> f64 {
        let Truth { class, t, beta, gamma, .. } = self.truth;
        if matches!(class, Class::Degenerate | Class::NonFinite) {
            return f64::INFINITY;
        }
        if class == Class::Coplanar {
            return 0.0;
        }
        let ends = [self.ray.tmin, self.ray.tmax].map(Scalar::to_f64);
        let from_ends = ends.map(|end| if end == t { 0.0 } else { (t - end).abs() / t.abs() });
        let weights = [1.0 - beta - gamma, beta, gamma];
        let distances = weights.into_iter().map(f64::abs).chain(from_ends);
        // Of a miss, the bound that is missed most decides; of a hit, the nearest one.
        if class.is_hit() {
            distances.fold(f64::INFINITY, f64::min)
        } else {
            let outside = weights.into_iter().map(|x| -x);
            let out_of_time = [(ends[0] - t) / t.abs(), (t - ends[1]) / t.abs()];
            outside.chain(out_of_time).fold(0.0, f64::max)
        }
    }

    /// Whether an answer is wrong by more than a [`THOUSANDTH`].
    pub(super) fn is_wrong(&self, answer: Answer, weighs: bool) -> bool {
        match (answer, self.hit) {
            (Some(found), Some(hit)) => {
                let off = |found: f64, exact: f64, unit: f64| {
                    let error = (found - exact).abs();
                    error > THOUSANDTH * unit
                };
                off(found.t, hit.t, hit.t.abs())
                    || weighs
                        && (off(found.beta, hit.beta, 1.0) || off(found.gamma, hit.gamma, 1.0))
            }
            (None, None) => false,
            _ => self.clearance() > THOUSANDTH,
        }
    }

    /// Absolute errors of `t`, `beta`, `gamma` where both say hit, with the true values and their
    /// condition numbers.
    fn errors(&self, answer: Answer) -> Option<[Deviation; 3]> {
        let (found, hit) = (answer?, self.hit?);
        let Condition { t, beta, gamma } = self.truth.condition;
        Some([
            Deviation::new(found.t, hit.t, t),
            Deviation::new(found.beta, hit.beta, beta),
            Deviation::new(found.gamma, hit.gamma, gamma),
        ])
    }

    /// Distances of the points that the answer gives, along the ray and by the weights, from the true
    /// one, as shares of the longest edge.
    fn point_errors(&self, [t, beta, gamma]: &[Deviation; 3]) -> [f64; 2] {
        let (ray, Triangle { a, b, c }) = widen(&self.ray, &self.triangle);
        let (e1, e2) = (b - a, c - a);
        let length = |v: Vec3<f64>| {
            let largest = v.map(f64::abs).to_array()[v.largest_axis()];
            if largest == 0.0 {
                return 0.0;
            }
            let v = v.map(|x| x / largest);
            v.dot(v).sqrt() * largest
        };
        let size = length(e1).max(length(e2)).max(length(c - b));
        let across = e1.mul_add(beta.signed, e2.scale(gamma.signed));
        [length(ray.d) * (t.signed.abs() / size), length(across) / size]
    }
}

fn widen<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> (Ray<f64>, Triangle<f64>) {
    (ray.map(|x| x.to_f64()), triangle.map(|x| x.to_f64()))
}

/// How far a number is from the true one.
#[derive(Clone, Copy)]
struct Deviation {
    exact: f64,
    signed: f64,
    condition: f64,
}

impl Deviation {
    fn new(found: f64, exact: f64, condition: f64) -> Self {
        Self { exact, signed: found - exact, condition }
    }

    fn absolute(&self) -> f64 {
        self.signed.abs()
    }

    /// 0 where both are 0; none where the true value alone is.
    fn per(&self, unit: impl Fn(f64) -> f64) -> Option<f64> {
        match (self.signed, self.exact) {
            (0.0, _) => Some(0.0),
            (_, 0.0) => None,
            (error, exact) => Some(error.abs() / unit(exact)),
        }
    }

    /// The error over `κ·u`; 0 where both are 0.
    fn over_condition<E: Float>(&self) -> f64 {
        if self.signed == 0.0 { 0.0 } else { self.absolute() / (self.condition * E::UNIT_ROUNDOFF) }
    }
}

const QUANTITIES: [&str; 3] = ["t", "beta", "gamma"];

fn errors<E: Float>(deviations: &[Deviation]) -> Errors {
    let all =
        |of: &dyn Fn(&Deviation) -> Option<f64>| spread(deviations.iter().filter_map(of).collect());
    Errors {
        relative: all(&|d| d.per(f64::abs)),
        absolute: all(&|d| Some(d.absolute())),
        ulps: all(&|d| d.per(|exact| unit_in_last_place(exact, E::SIGNIFICANT_BITS))),
        over_condition: all(&|d| Some(d.over_condition::<E>())),
    }
}

/// The record of a variant on each family.
pub(super) fn score<'a, E: Float>(
    variant: &Variant,
    weighs: bool,
    asked: impl Iterator<Item = (&'a Set<E>, &'a [Answer])>,
    inputs: FloatFormat,
    flush_to_zero: bool,
) -> Vec<Line> {
    let mut families: Vec<StressFamily> = Vec::new();
    for (set, answers) in asked {
        let level = level::<E>(set, answers, weighs);
        let name = set.family.name();
        if families.last().is_none_or(|family| family.family != name) {
            families.push(StressFamily {
                variant: variant.clone(),
                family: name.to_owned(),
                knob: set.family.knob().to_owned(),
                inputs,
                flush_to_zero,
                levels: Vec::new(),
            });
        }
        families.last_mut().expect("there is one at least").levels.push(level);
    }
    families.into_iter().map(Line::from).collect()
}

fn level<E: Float>(set: &Set<E>, answers: &[Answer], weighs: bool) -> StressLevel {
    let mut classes: BTreeMap<String, [u64; 2]> = BTreeMap::new();
    let (mut false_hits, mut false_misses, mut wrong) = (0, 0, 0);
    let mut deviations: [Vec<Deviation>; 3] = Default::default();
    let mut points: [Vec<f64>; 2] = Default::default();
    for (pair, &answer) in set.pairs.iter().zip(answers) {
        let class = pair.truth.class;
        let said = classes.entry(class.name().to_owned()).or_default();
        said[usize::from(answer.is_none())] += 1;
        false_hits += u64::from(answer.is_some() && !class.is_hit());
        false_misses += u64::from(answer.is_none() && class.is_hit());
        wrong += u64::from(pair.is_wrong(answer, weighs));
        if let Some(errors) = pair.errors(answer) {
            for (all, error) in deviations.iter_mut().zip(errors) {
                all.push(error);
            }
            for (all, error) in points.iter_mut().zip(pair.point_errors(&errors)) {
                all.push(error);
            }
        }
    }
    let [t, beta, gamma] = deviations;
    let [along, by_weights] = points;
    StressLevel {
        level: set.level,
        classes,
        false_hits,
        false_misses,
        wrong,
        t: errors::<E>(&t),
        beta: weighs.then(|| errors::<E>(&beta)),
        gamma: weighs.then(|| errors::<E>(&gamma)),
        point_along_ray: spread(along),
        point_by_weights: weighs.then(|| spread(by_weights)),
    }
}

/// The tests in flushing arithmetic, on the families in which numbers grow small.
pub(super) fn flushing(entry: &Entry, sets: &[Set<f32>]) -> Vec<Line> {
    let small: Vec<&Set<f32>> = sets.iter().filter(|set| is_about_range(set.family)).collect();
    let mut lines = Vec::new();
    for (division, test) in &entry.flushing {
        let answers: Vec<Vec<Answer>> = small
            .iter()
            .map(|set| set.pairs.iter().map(|pair| test(&pair.ray, &pair.triangle)).collect())
            .collect();
        let asked = small.iter().copied().zip(answers.iter().map(Vec::as_slice));
        let named = flushing_variant(entry, *division);
        lines.extend(score(&named, weighs(entry), asked, FloatFormat::F32, true));
    }
    lines
}

/// Pairs by how well conditioned they are.
const STRATA: [(f64, f64); 3] = [(0.0, 1e2), (1e2, 1e6), (1e6, f64::MAX)];

/// Families whose errors come from the range of the numbers, which no condition number tells.
fn is_about_range(family: Stress) -> bool {
    matches!(
        family,
        Stress::Scale | Stress::DirectionLength | Stress::Subnormal | Stress::RandomBits
    )
}

/// The errors of a variant against the condition number, over all families but those about range:
/// those of `t` and their condition number relative to `t`, those of the weights as they are.
pub(super) fn by_condition<'a, E: Float>(
    variant: &Variant,
    weighs: bool,
    asked: impl Iterator<Item = (&'a Set<E>, &'a [Answer])>,
    inputs: FloatFormat,
) -> Vec<Line> {
    let mut found: [Vec<(f64, f64, f64)>; 3] = Default::default();
    for (set, answers) in asked.filter(|(set, _)| !is_about_range(set.family)) {
        for (pair, &answer) in set.pairs.iter().zip(answers) {
            let Some(errors) = pair.errors(answer) else { continue };
            for (quantity, error) in errors.iter().enumerate() {
                let unit = if quantity == 0 { error.exact.abs() } else { 1.0 };
                let point =
                    (error.condition / unit, error.absolute() / unit, error.over_condition::<E>());
                if point.0.is_finite() && !point.1.is_nan() {
                    found[quantity].push(point);
                }
            }
        }
    }
    let quantities = QUANTITIES.into_iter().zip(found).take(if weighs { 3 } else { 1 });
    quantities
        .map(|(quantity, points)| {
            let decades = (0..20).map(|k| (10_f64.powi(k), 10_f64.powi(k + 1)));
            Line::from(ByCondition {
                variant: variant.clone(),
                inputs,
                quantity: quantity.to_owned(),
                decades: decades.filter_map(|range| bin(&points, range)).collect(),
                strata: STRATA.into_iter().filter_map(|range| bin(&points, range)).collect(),
            })
        })
        .collect()
}

/// The errors of the pairs whose condition number is in a range; none where there are none.
fn bin(points: &[(f64, f64, f64)], (from, to): (f64, f64)) -> Option<Bin> {
    let inside = || points.iter().filter(|(condition, ..)| (from..to).contains(condition));
    let count = inside().count() as u64;
    (count > 0).then(|| Bin {
        from,
        to,
        count,
        error: spread(inside().map(|point| point.1).collect()),
        over_condition: spread(inside().map(|point| point.2).collect()),
    })
}

/// What fused multiply-add changes, over all families but those about range.
pub(super) fn difference<'a, E: Float>(
    variant: Variant,
    weighs: bool,
    asked: impl Iterator<Item = ((&'a Set<E>, &'a [Answer]), &'a [Answer])>,
    inputs: FloatFormat,
) -> Line {
    let (mut pairs, mut decisions) = (0, 0);
    let mut differences: [Vec<f64>; 3] = Default::default();
    for ((set, fused), plain) in asked.filter(|((set, _), _)| !is_about_range(set.family)) {
        for ((pair, fused), plain) in set.pairs.iter().zip(fused).zip(plain) {
            pairs += 1;
            decisions += u64::from(fused.is_some() != plain.is_some());
            let (Some(fused), Some(plain)) = (fused, plain) else { continue };
            let Condition { t, beta, gamma } = pair.truth.condition;
            let each = [
                (fused.t - plain.t, t),
                (fused.beta - plain.beta, beta),
                (fused.gamma - plain.gamma, gamma),
            ];
            for (all, (difference, condition)) in differences.iter_mut().zip(each) {
                let over = difference.abs() / (condition * E::UNIT_ROUNDOFF);
                if difference == 0.0 {
                    all.push(0.0);
                } else if over.is_finite() {
                    all.push(over);
                }
            }
        }
    }
    let [t, beta, gamma] = differences.map(spread);
    Line::from(FusedDifference {
        variant,
        inputs,
        pairs,
        decisions,
        t,
        beta: weighs.then_some(beta),
        gamma: weighs.then_some(gamma),
    })
}
