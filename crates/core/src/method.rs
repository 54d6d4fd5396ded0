//! What a ray–triangle method is.

use crate::geometry::{Hit, Ray, Triangle};
use crate::lanes::{Lanes, Scalar};
use crate::record::{Of, Record};

/// Where a line meets a plane, before division: `t = t/det`, `beta = beta/det`,
/// `gamma = gamma/det`. `det = 0` where the ray is parallel to the plane.
#[derive(Clone, Copy, Debug)]
pub struct Homogeneous<L> {
    /// The common denominator; its sign is the method's own.
    pub det: L,
    /// Numerator of `t`.
    pub t: L,
    /// Numerator of `beta`.
    pub beta: L,
    /// Numerator of `gamma`.
    pub gamma: L,
}

/// Facts about a method, for lists, pages and records.
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    /// Name as typed on the command line: lower case, hyphens.
    pub name: &'static str,
    /// Name in prose.
    pub title: &'static str,
    /// Year of publication.
    pub year: u16,
    /// Authors, title, place, section.
    pub source: &'static str,
    /// What it can return, of `hit`, `t`, `beta`, `gamma`.
    pub outputs: &'static [&'static str],
    /// The claim behind its error bound in well-conditioned cases, as a multiple of
    /// `κ · unit roundoff`: the conformance tests hold the method to it.
    pub error_factor: f64,
}

/// A ray–triangle method: how a triangle is prepared and one formula over lanes.
///
/// Everything under a kernel is inlined by hand, since a function that stays out of line does not
/// get the instruction set of its caller: mark each function and closure `#[inline(always)]`.
pub trait Method: Send + Sync + 'static {
    /// Facts for lists and pages.
    const INFO: MethodInfo;
    /// How many kinds of triangles the formula tells apart. Triangles are stored sorted by kind,
    /// and a ray is prepared once per kind: a projected axis costs nothing per test.
    const GROUPS: usize = 1;
    /// What is stored per triangle.
    type Prepared: Record;
    /// What is computed once per ray (and group).
    type PreparedRay<L: Lanes>: Copy;

    /// The kind of a triangle, below [`GROUPS`](Method::GROUPS).
    #[inline(always)]
    fn group<X: Scalar>(_triangle: &Triangle<X>) -> usize {
        0
    }

    /// What is stored for a triangle of kind `group`. A degenerate triangle gets data that never
    /// hit.
    fn prepare<X: Scalar>(triangle: &Triangle<X>, group: usize) -> Of<Self::Prepared, X>;

    /// What is computed once per ray for triangles of kind `group`.
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, group: usize) -> Self::PreparedRay<L>;

    /// The formula.
    fn intersect<L: Lanes>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
    ) -> Homogeneous<L>;

    /// The formula with the division first: `reciprocal(det)` is the only division allowed.
    /// Returns the denominator and the quotients. Override where that saves products.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> (L, Hit<L>) {
        let h = Self::intersect(ray, triangle);
        let r = reciprocal(h.det);
        (h.det, Hit { t: h.t * r, beta: h.beta * r, gamma: h.gamma * r })
    }

    /// Positive where the ray meets the front face (from which the corners run
    /// counter-clockwise), negative at the back. The default holds for `det = −D·N`.
    #[inline(always)]
    fn facing<L: Lanes>(_triangle: &Of<Self::Prepared, L>, det: L) -> L {
        det
    }
}

/// Something to do for each of a list of methods.
pub trait MethodVisitor {
    /// One method.
    fn visit<M: Method>(&mut self);
}

/// Names the methods of a crate: declares `pub fn methods`, which the catalogue calls.
#[macro_export]
macro_rules! methods {
    ($($method:ident),+ $(,)?) => {
        /// Visits the methods of this crate.
        pub fn methods(visitor: &mut impl $crate::MethodVisitor) {
            $(visitor.visit::<$method>();)+
        }
    };
}
