//! Which stage decides a pair.

use trisect_core::{Ray, Scalar, Triangle};
use trisect_method::Interval;

use crate::double::{Estimate, UNIT};
use crate::filter::{self, BoundedRay, SizedTriangle, Volumes};
use crate::widened;

/// The stages, cheapest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Over lanes, a miss: nothing more is computed.
    Miss,
    /// Over lanes, `t` and its bound included.
    Filter,
    /// One pair in f64.
    Double,
    /// One pair in whole numbers.
    Whole,
}

impl Stage {
    /// All of them, cheapest first.
    pub const ALL: [Self; 4] = [Self::Miss, Self::Filter, Self::Double, Self::Whole];

    /// Their names in records and tables.
    pub const NAMES: [&'static str; 4] = ["miss", "filter", "f64", "whole"];

    /// Which stage decides a pair in plain arithmetic. Fused arithmetic has the same bounds, and numbers
    /// that differ by less.
    pub fn of<X: Scalar>(ray: &Ray<X>, triangle: &Triangle<X>) -> Self {
        let interval = Interval::of(ray);
        let bounded = BoundedRay::new(ray.o, ray.d, 1.0);
        let sized = SizedTriangle::new(&triangle.or_nothing());
        let volumes = Volumes::new(&bounded, &sized, sized.normal());
        let bound = filter::bound(&bounded, &sized, &volumes);
        let candidate = filter::candidates(&volumes, bound);
        if !candidate {
            return Self::Miss;
        }
        let known = (bound, candidate);
        if filter::verdict(&bounded, &sized, &volumes, known, &interval, 1.0).open == 0 {
            return Self::Filter;
        }
        let ray = Ray { tmin: interval.tmin, tmax: interval.tmax, ..*ray }.map(|x| x.to_f64());
        let estimate = Estimate::new(&ray, &widened(triangle), UNIT);
        match estimate.and_then(|estimate| estimate.outcome(&ray)) {
            Some(_) => Self::Double,
            None => Self::Whole,
        }
    }
}
