//! The oracle: the fast path where it is certain, the exact path where it is not.

use core::cmp::Ordering;

use dashu_ratio::RBig;
use trisect_core::{Float, Hit, Ray, Triangle};

use crate::class::Class;
use crate::exact::Volumes;
use crate::fast::{self, Estimate, FastRay, UNIT};

/// How far the rounding of one operation can move `t`, `beta` and `gamma`: `κ` such that a
/// backward-stable method errs by a small multiple of `κ·ε`, absolutely.
///
/// With `P_x` the volume `x` summed over absolute values, `κ_beta = (P_U + |beta|·P_det)/|det|`,
/// and likewise for `gamma` (`P_V`) and `t` (`P_T`). NaN where `det = 0` or the input is not
/// finite; infinite where it overflows f64. The fast path computes it to a few units in the last
/// place where the value itself is not near zero, and to 2⁻³⁰ relative otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Of `t`, in units of `t`.
    pub t: f64,
    /// Of `beta`, a pure number.
    pub beta: f64,
    /// Of `gamma`, a pure number.
    pub gamma: f64,
}

impl Condition {
    /// Where there is none.
    pub(crate) const NAN: Self = Self { t: f64::NAN, beta: f64::NAN, gamma: f64::NAN };

    /// The largest of the three; NaN when all are.
    pub fn max(&self) -> f64 {
        self.t.max(self.beta).max(self.gamma)
    }
}

/// All there is to know of a ray and a triangle, in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// How they meet.
    pub class: Class,
    /// Where the line of the ray meets the plane, as a ray parameter, to a relative 2⁻³⁰.
    ///
    /// Like `beta` and `gamma` it is there whenever `det ≠ 0`, for misses too, and NaN otherwise.
    /// Each is the true number where that is zero.
    pub t: f64,
    /// The weight of corner `b` there, to a relative 2⁻³⁰.
    pub beta: f64,
    /// The weight of corner `c` there, to a relative 2⁻³⁰.
    pub gamma: f64,
    /// How far rounding can move the three.
    pub condition: Condition,
}

impl Truth {
    /// The condition numbers divided by the magnitudes of what they belong to: what to hold
    /// relative errors against. Infinite where a value is zero.
    pub fn relative_condition(&self) -> Condition {
        Condition {
            t: self.condition.t / self.t.abs(),
            beta: self.condition.beta / self.beta.abs(),
            gamma: self.condition.gamma / self.gamma.abs(),
        }
    }
}

/// The best answer that a method could give in precision `E`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer<E> {
    /// How the ray and the triangle meet.
    pub class: Class,
    /// The hit, each value the true one rounded once to the nearest of `E`, ties to even; `None`
    /// when the class is no hit. All three are finite.
    pub hit: Option<Hit<E>>,
}

/// Answers truly, and counts how often that took exact arithmetic.
///
/// Threads each take their own and [`merge`](Oracle::merge) them at the end.
///
/// Every question asks about the closed triangle and the closed interval `[tmin, tmax]`, its ends
/// brought within half the largest number of the precision ([`Interval::new`](trisect_method::Interval::new)), of the numbers as
/// they are given; nothing is rounded before the last step. See [`Class`] for what
/// degenerate and non-finite input gives; nothing here panics.
#[derive(Clone, Debug)]
pub struct Oracle {
    tests: u64,
    exact: u64,
    /// The unit roundoff that the bounds are multiples of.
    unit: f64,
}

impl Default for Oracle {
    fn default() -> Self {
        Self { tests: 0, exact: 0, unit: UNIT }
    }
}

impl Oracle {
    /// Tests of one ray against one triangle so far.
    pub fn tests(&self) -> u64 {
        self.tests
    }

    /// Those of the tests that took exact arithmetic, and comparisons of two hits that did.
    pub fn exact(&self) -> u64 {
        self.exact
    }

    /// Adds the counts of another.
    pub fn merge(&mut self, other: &Self) {
        self.tests += other.tests;
        self.exact += other.exact;
    }

    /// An oracle with wrong error bounds, to show that the right ones matter.
    #[cfg(test)]
    pub(crate) fn with_bounds_scaled(factor: f64) -> Self {
        Self { unit: UNIT * factor, ..Self::default() }
    }

    /// The class alone: the cheapest question.
    #[inline]
    pub fn classify<E: Float>(&mut self, ray: &Ray<E>, triangle: &Triangle<E>) -> Class {
        self.tests += 1;
        let fast = FastRay::new(ray);
        Estimate::new(&fast, triangle, self.unit)
            .and_then(|estimate| estimate.class(&fast))
            .unwrap_or_else(|| self.exact_class(ray, triangle))
    }

    #[cold]
    fn exact_class<E: Float>(&mut self, ray: &Ray<E>, triangle: &Triangle<E>) -> Class {
        self.exact += 1;
        exact_class(ray, triangle)
    }

    /// Class, values to a relative 2⁻³⁰, and condition numbers, all in f64.
    #[inline]
    pub fn truth<E: Float>(&mut self, ray: &Ray<E>, triangle: &Triangle<E>) -> Truth {
        self.tests += 1;
        let fast = FastRay::new(ray);
        let certain = Estimate::new(&fast, triangle, self.unit).and_then(|estimate| {
            let class = estimate.class(&fast)?;
            if class == Class::Coplanar {
                return Some(without_values(class));
            }
            let [(t, _), (beta, _), (gamma, _)] = estimate.values()?;
            Some(Truth { class, t, beta, gamma, condition: estimate.condition() })
        });
        certain.unwrap_or_else(|| self.exact_truth(ray, triangle))
    }

    #[cold]
    fn exact_truth<E: Float>(&mut self, ray: &Ray<E>, triangle: &Triangle<E>) -> Truth {
        self.exact += 1;
        let Some(volumes) = Volumes::new(ray, triangle) else {
            return without_values(Class::NonFinite);
        };
        let class = volumes.class(ray);
        volumes.values().map_or(without_values(class), |[t, beta, gamma]| Truth {
            class,
            t,
            beta,
            gamma,
            condition: volumes.condition(),
        })
    }

    /// Class and, for a hit, its values correctly rounded to `E`.
    ///
    /// The fast path answers for f32 nearly always; a hit of f64 is always computed exactly, as
    /// f64 arithmetic cannot certify its own last bit.
    #[inline]
    pub fn intersect<E: Float>(&mut self, ray: &Ray<E>, triangle: &Triangle<E>) -> Answer<E> {
        self.tests += 1;
        self.answer(&FastRay::new(ray), ray, triangle)
    }

    fn answer<E: Float>(
        &mut self,
        fast: &FastRay,
        ray: &Ray<E>,
        triangle: &Triangle<E>,
    ) -> Answer<E> {
        let certain = Estimate::new(fast, triangle, self.unit).and_then(|estimate| {
            let class = estimate.class(fast)?;
            if !class.is_hit() {
                return Some(Answer { class, hit: None });
            }
            let [t, beta, gamma] = estimate.values()?.map(fast::rounded);
            Some(Answer { class, hit: Some(Hit { t: t?, beta: beta?, gamma: gamma? }) })
        });
        certain.unwrap_or_else(|| self.exact_answer(ray, triangle))
    }

    #[cold]
    fn exact_answer<E: Float>(&mut self, ray: &Ray<E>, triangle: &Triangle<E>) -> Answer<E> {
        self.exact += 1;
        let Some(volumes) = Volumes::new(ray, triangle) else {
            return Answer { class: Class::NonFinite, hit: None };
        };
        let class = volumes.class(ray);
        let hit = if class.is_hit() { volumes.values() } else { None };
        Answer { class, hit: hit.map(|[t, beta, gamma]| Hit { t, beta, gamma }) }
    }

    /// The hit of truly smallest `t` and its place in `triangles`; the lowest place among exactly
    /// equal ones. `None` when nothing is hit.
    ///
    /// A blunt filter discards nearly every triangle at the cost of one f64 intersection; each
    /// triangle counts as one test.
    pub fn closest<E: Float>(
        &mut self,
        ray: &Ray<E>,
        triangles: &[Triangle<E>],
    ) -> Option<(usize, Answer<E>)> {
        self.tests += triangles.len() as u64;
        let fast = FastRay::new(ray);
        let mut limit = fast.tmax;
        let mut best: Option<(usize, [f64; 2])> = None;
        for (index, triangle) in triangles.iter().enumerate() {
            if fast::rejects(&fast, triangle, limit, self.unit) {
                continue;
            }
            let Some(interval) = self.hit_interval(&fast, ray, triangle) else { continue };
            let nearer = best.is_none_or(|(other, other_interval)| {
                if interval[1] < other_interval[0] {
                    true
                } else if interval[0] > other_interval[1] {
                    false
                } else {
                    self.exact += 1;
                    compare_t(ray, triangle, &triangles[other]) == Some(Ordering::Less)
                }
            });
            if nearer {
                best = Some((index, interval));
                limit = fast::usable_limit(interval[1]);
            }
        }
        best.map(|(index, _)| (index, self.answer(&fast, ray, &triangles[index])))
    }

    /// An interval that holds `t`, for a hit.
    fn hit_interval<E: Float>(
        &mut self,
        fast: &FastRay,
        ray: &Ray<E>,
        triangle: &Triangle<E>,
    ) -> Option<[f64; 2]> {
        let certain = Estimate::new(fast, triangle, self.unit).and_then(|estimate| {
            let class = estimate.class(fast)?;
            if class.is_hit() { estimate.t_interval().map(Some) } else { Some(None) }
        });
        certain.unwrap_or_else(|| {
            self.exact += 1;
            let volumes = Volumes::new(ray, triangle)?;
            if volumes.class(ray).is_hit() { volumes.t_interval() } else { None }
        })
    }
}

fn without_values(class: Class) -> Truth {
    Truth { class, t: f64::NAN, beta: f64::NAN, gamma: f64::NAN, condition: Condition::NAN }
}

/// The class by exact arithmetic alone.
pub fn exact_class<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> Class {
    Volumes::new(ray, triangle).map_or(Class::NonFinite, |volumes| volumes.class(ray))
}

/// `t`, `beta` and `gamma` where the line of the ray meets the plane of the triangle, exactly.
///
/// `None` when `det = 0` or the input is not finite. The interval of the ray plays no part.
pub fn exact_rationals<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> Option<[RBig; 3]> {
    Volumes::new(ray, triangle)?.rationals()
}

/// The exact order of the `t` at which one line meets the planes of two triangles.
///
/// `None` when either `det` is zero or the input is not finite. The interval of the ray plays no
/// part, nor do the outlines of the triangles.
pub fn compare_t<E: Float>(
    ray: &Ray<E>,
    first: &Triangle<E>,
    second: &Triangle<E>,
) -> Option<Ordering> {
    let (first, second) = (Volumes::new(ray, first)?, Volumes::new(ray, second)?);
    first.order(&second)
}

#[cfg(test)]
mod tests {
    use trisect_core::Vec3;

    use super::*;

    /// A small generator, so that the cases are the same everywhere.
    struct Draw(u64);

    impl Draw {
        /// Uniform in `[−1, 1)`.
        fn number(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn point(&mut self) -> Vec3<f64> {
            Vec3::new(self.number(), self.number(), self.number())
        }

        fn triangle(&mut self) -> Triangle<f64> {
            Triangle { a: self.point(), b: self.point(), c: self.point() }
        }

        /// A ray aimed, but for rounding, at a point of edge AB.
        fn at_edge(&mut self, triangle: &Triangle<f64>) -> Ray<f64> {
            let target = triangle.a + (triangle.b - triangle.a).scale(self.number().abs());
            let o = self.point();
            Ray { o, d: target - o, tmin: 0.0, tmax: f64::INFINITY }
        }
    }

    #[allow(clippy::cast_possible_truncation, reason = "rounding to f32 is the point")]
    fn narrow(v: Vec3<f64>) -> Vec3<f32> {
        v.map(|x| x as f32)
    }

    /// Wrong classes among rays aimed at edges, of triangles with corners on a grid in the second
    /// half so that many pass exactly through, and how often the exact path was taken.
    fn wrong_near_edges(oracle: &mut Oracle) -> usize {
        let mut draw = Draw(1);
        let mut wrong = 0;
        for i in 0..10_000 {
            let mut triangle = draw.triangle();
            let mut ray = draw.at_edge(&triangle);
            if i % 2 == 1 {
                let grid = |v: Vec3<f64>| v.map(|x| (x * 64.0).round() / 48.0);
                triangle =
                    Triangle { a: grid(triangle.a), b: grid(triangle.b), c: grid(triangle.c) };
                let target = (triangle.a + triangle.b).scale(0.5);
                ray.o = grid(ray.o);
                ray.d = target - ray.o;
            }
            wrong += usize::from(oracle.classify(&ray, &triangle) != exact_class(&ray, &triangle));
        }
        wrong
    }

    #[test]
    fn near_edges_the_bounds_send_to_the_exact_path_and_are_needed() {
        let mut oracle = Oracle::default();
        assert_eq!(wrong_near_edges(&mut oracle), 0);
        assert!(oracle.exact() > oracle.tests() / 2, "{oracle:?}");
        let wrong = wrong_near_edges(&mut Oracle::with_bounds_scaled(0.01));
        assert!(wrong > 100, "bounds a hundredth as wide gave {wrong} wrong classes");
    }

    #[test]
    fn f32_near_edges_is_right_and_seldom_exact() {
        let mut oracle = Oracle::default();
        let mut draw = Draw(2);
        for _ in 0..10_000 {
            let wide = draw.triangle();
            let aimed = draw.at_edge(&wide);
            let triangle = Triangle { a: narrow(wide.a), b: narrow(wide.b), c: narrow(wide.c) };
            let ray = Ray { o: narrow(aimed.o), d: narrow(aimed.d), tmin: 0.0, tmax: 9.0 };
            assert_eq!(oracle.classify(&ray, &triangle), exact_class(&ray, &triangle));
        }
        assert!(oracle.exact() < 100, "{oracle:?}");
    }
}
