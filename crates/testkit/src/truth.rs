//! The exact values that a method is held to, and how well conditioned they are.

use dashu::base::Abs;
use dashu::rational::RBig;
use trisect_core::{Float, Hit, Ray, Triangle, Vec3};

/// A rational and its condition number.
pub(crate) struct Value {
    pub(crate) exact: RBig,
    /// `(P_x + |x|·P_det) / |det|`, `P` the permanent of the triple product.
    pub(crate) kappa: f64,
}

impl Value {
    /// `|computed − exact|`
    pub(crate) fn error(&self, computed: f64) -> f64 {
        RBig::try_from(computed)
            .map_or(f64::INFINITY, |x| (x - &self.exact).abs().to_f64().value())
    }

    /// The distance to `bound`, infinite where that is.
    pub(crate) fn distance(&self, bound: f64) -> f64 {
        self.error(bound)
    }
}

/// Where the line of a ray meets the plane of a triangle.
pub(crate) struct Truth {
    /// `−D·(e1 × e2)`: positive at the front.
    pub(crate) det: RBig,
    pub(crate) t: Value,
    pub(crate) beta: Value,
    pub(crate) gamma: Value,
}

fn exact<E: Float>(v: Vec3<E>) -> [RBig; 3] {
    // Generators hand over finite numbers; zero stands for others, and fails the test at hand.
    v.to_array().map(|x| RBig::try_from(x.to_f64()).unwrap_or_default())
}

fn minus(a: &[RBig; 3], b: &[RBig; 3]) -> [RBig; 3] {
    core::array::from_fn(|i| &a[i] - &b[i])
}

/// The determinant of the rows `a, b, c`, and the same six products over absolute values.
fn determinant(a: &[RBig; 3], b: &[RBig; 3], c: &[RBig; 3]) -> (RBig, RBig) {
    let (mut sum, mut permanent) = (RBig::ZERO, RBig::ZERO);
    for [i, j, k] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
        let (even, odd) = (&a[i] * &b[j] * &c[k], &a[i] * &b[k] * &c[j]);
        sum += &even - &odd;
        permanent += even.abs() + odd.abs();
    }
    (sum, permanent)
}

impl Truth {
    /// By Cramer's rule on `s = −t·d + beta·e1 + gamma·e2`; `None` where the ray is parallel to
    /// the plane or the triangle is degenerate.
    pub(crate) fn of<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> Option<Self> {
        let [o, d, a, b, c] = [ray.o, ray.d, triangle.a, triangle.b, triangle.c].map(exact);
        let (e1, e2, s) = (minus(&b, &a), minus(&c, &a), minus(&o, &a));
        let minus_d = d.map(|x| -x);
        let (det, det_permanent) = determinant(&minus_d, &e1, &e2);
        if det == RBig::ZERO {
            return None;
        }
        let value = |(numerator, permanent): (RBig, RBig)| {
            let exact = numerator / &det;
            let size = exact.clone().abs();
            let kappa = (permanent + size * &det_permanent) / det.clone().abs();
            Value { exact, kappa: kappa.to_f64().value() }
        };
        let t = value(determinant(&s, &e1, &e2));
        let beta = value(determinant(&minus_d, &s, &e2));
        let gamma = value(determinant(&minus_d, &e1, &s));
        Some(Self { det, t, beta, gamma })
    }

    /// Whether the point lies in the closed triangle and `t` in the closed interval of the ray.
    pub(crate) fn hits<E: Float>(&self, ray: &Ray<E>) -> bool {
        let bound = |x: E| RBig::try_from(x.to_f64()).ok();
        self.beta.exact >= RBig::ZERO
            && self.gamma.exact >= RBig::ZERO
            && &self.beta.exact + &self.gamma.exact <= RBig::ONE
            && bound(ray.tmin).is_some_and(|tmin| self.t.exact >= tmin)
            // An infinite end holds every t.
            && bound(ray.tmax).is_none_or(|tmax| self.t.exact <= tmax)
    }

    /// The distance of the decision from being another one, in units of `unit` times the
    /// condition number of what it hangs on.
    pub(crate) fn margin<E: Float>(&self, ray: &Ray<E>, unit: f64) -> f64 {
        let sum = Value {
            exact: &self.beta.exact + &self.gamma.exact,
            kappa: self.beta.kappa + self.gamma.kappa,
        };
        [
            (&self.beta, 0.0),
            (&self.gamma, 0.0),
            (&sum, 1.0),
            (&self.t, ray.tmin.to_f64()),
            (&self.t, ray.tmax.to_f64()),
        ]
        .into_iter()
        .map(|(value, bound)| value.distance(bound) / (value.kappa * unit))
        .fold(f64::INFINITY, f64::min)
    }

    /// The error of each number of `hit`, in units of its condition number times `unit`.
    pub(crate) fn errors<E: Float>(&self, hit: &Hit<E>, unit: f64) -> [(&'static str, f64); 3] {
        [("t", &self.t, hit.t), ("beta", &self.beta, hit.beta), ("gamma", &self.gamma, hit.gamma)]
            .map(|(name, value, computed)| {
                (name, value.error(computed.to_f64()) / (value.kappa * unit))
            })
    }
}
