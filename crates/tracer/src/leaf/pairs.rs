//! The test of pairs in a leaf, in the form that suits the query.

use trisect_core::{Hit, Lanes};
use trisect_method::{
    Culling, DecisionOnly, Deferred, Division, Early, Interval, Method, Of, TrueDivision,
};

use crate::query::Query;

/// Tests pairs in the form that decides without quotients, where the method has one, and without any values where
/// any hit will do. It does not ask whether there is a hit: in a leaf that a ray has reached that is as likely
/// as not, and a mispredicted branch costs as much as the rest of the test.
#[inline(always)]
pub(crate) fn test<M: Method, L: Lanes, Q: Query>(
    ray: &M::PreparedRay<L>,
    triangles: &Of<M::Prepared, L>,
    interval: Interval<L>,
    culling: Culling,
    found: impl FnOnce(L::Mask, Hit<L>),
) {
    // A method whose only published form divides first decides by numerators all the same, where it can.
    if const { M::INFO.forms.deferred() || (Q::ANY && !M::INFO.always_divides) } {
        in_form::<M, L, Deferred<TrueDivision, false>, Q>(ray, triangles, interval, culling, found);
    } else {
        in_form::<M, L, Early<TrueDivision, false>, Q>(ray, triangles, interval, culling, found);
    }
}

#[inline(always)]
fn in_form<M: Method, L: Lanes, D: Division, Q: Query>(
    ray: &M::PreparedRay<L>,
    triangles: &Of<M::Prepared, L>,
    interval: Interval<L>,
    culling: Culling,
    found: impl FnOnce(L::Mask, Hit<L>),
) {
    if const { Q::ANY } {
        M::test::<L, DecisionOnly<D>>(ray, triangles, interval, culling, found);
    } else {
        M::test::<L, D>(ray, triangles, interval, culling, found);
    }
}
