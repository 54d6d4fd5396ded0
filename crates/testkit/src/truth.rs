//! The exact values that a method is held to, and how well conditioned they are.

use trisect_core::{Float, Hit, Ray, Triangle};
use trisect_oracle::{Oracle, RBig, exact_class, exact_rationals};

/// A rational and its condition number.
pub(crate) struct Value {
    pub(crate) exact: RBig,
    pub(crate) kappa: f64,
}

impl Value {
    /// The distance of `x` from the exact value; infinite where `x` is not finite.
    pub(crate) fn error(&self, x: f64) -> f64 {
        RBig::try_from(x).map_or(f64::INFINITY, |x| (x - &self.exact).to_f64().value().abs())
    }
}

/// Where the line of a ray meets the plane of a triangle.
pub(crate) struct Truth {
    /// Whether the ray hits, its interval considered.
    pub(crate) hits: bool,
    pub(crate) t: Value,
    pub(crate) beta: Value,
    pub(crate) gamma: Value,
}

impl Truth {
    /// `None` where the ray is parallel to the plane or the triangle is degenerate.
    pub(crate) fn of<E: Float>(ray: &Ray<E>, triangle: &Triangle<E>) -> Option<Self> {
        let [t, beta, gamma] = exact_rationals(ray, triangle)?;
        let kappa = Oracle::default().truth(ray, triangle).condition;
        Some(Self {
            hits: exact_class(ray, triangle).is_hit(),
            t: Value { exact: t, kappa: kappa.t },
            beta: Value { exact: beta, kappa: kappa.beta },
            gamma: Value { exact: gamma, kappa: kappa.gamma },
        })
    }

    /// Whether the point is in the closed triangle, whatever the interval.
    pub(crate) fn is_inside(&self) -> bool {
        let (zero, one) = (RBig::ZERO, RBig::ONE);
        let (beta, gamma) = (&self.beta.exact, &self.gamma.exact);
        *beta >= zero && *gamma >= zero && beta + gamma <= one
    }

    /// How far the weight that is nearest to zero is from it.
    pub(crate) fn clearance(&self) -> f64 {
        let alpha = RBig::ONE - &self.beta.exact - &self.gamma.exact;
        [alpha.to_f64().value(), self.beta.error(0.0), self.gamma.error(0.0)]
            .into_iter()
            .map(f64::abs)
            .fold(f64::INFINITY, f64::min)
    }

    /// How far the decision is from another one: the smallest distance of a value from its bound,
    /// in units of `unit` times the condition number of the value.
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
        .map(|(value, bound)| value.error(bound) / (value.kappa * unit))
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
