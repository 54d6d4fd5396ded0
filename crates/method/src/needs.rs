//! What a caller asks of a hit. A kernel computes what is asked and nothing else.

use crate::division::{DecisionOnly, Division};
use crate::info::Output;
use crate::method::Method;
use crate::record::Of;
use trisect_core::Lanes;
use trisect_core::{Hit, Ray};

/// What a caller asks of a hit.
pub trait Needs: 'static {
    /// What is asked.
    const OUTPUT: Output;
    /// Division `D` for who asks this: [`DecisionOnly`] where no value is asked for.
    type Asks<D: Division>: Division;
    /// Everything asked, folded into one number, so that a measured kernel can neither leave out
    /// what is asked nor be made to compute what is not; nothing where nothing is asked.
    fn fold<M: Method, L: Lanes>(
        ray: &Ray<L>,
        triangle: &Of<M::Prepared, L>,
        group: usize,
        hit: Hit<L>,
    ) -> Option<L>;
}

macro_rules! needs {
    ($(#[$doc:meta])* $name:ident, $output:ident, $division:ty, |$ray:pat_param, $triangle:pat_param, $group:pat_param, $hit:pat_param| $fold:expr) => {
        $(#[$doc])*
        pub struct $name;

        impl Needs for $name {
            const OUTPUT: Output = Output::$output;
            type Asks<D: Division> = $division;
            #[inline(always)]
            fn fold<M: Method, L: Lanes>(
                $ray: &Ray<L>,
                $triangle: &Of<M::Prepared, L>,
                $group: usize,
                $hit: Hit<L>,
            ) -> Option<L> {
                $fold
            }
        }
    };
}

needs!(
    /// Whether there is a hit; no division, no `t`.
    Occlusion, Occlusion, DecisionOnly<D>, |_, _, _, _| None
);
needs!(
    /// `t` alone.
    Distance, T, D, |_, _, _, hit| Some(hit.t)
);
needs!(
    /// `t`, `beta` and `gamma`.
    Barycentrics, Barycentrics, D, |_, _, _, hit| Some(hit.t + (hit.beta + hit.gamma))
);
needs!(
    /// The point `o + t·d`.
    Point, Point, D, |ray, _, _, hit| Some(ray.at(hit.t).sum())
);
needs!(
    /// `t`, and the normal of the triangle.
    Normal, Normal, D, |_, triangle, group, hit| {
        Some(hit.t + M::normal::<L>(triangle, group)?.sum())
    }
);
