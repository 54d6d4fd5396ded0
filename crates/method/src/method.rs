//! What a ray–triangle method is.

use core::cmp::Ordering;
use core::error::Error;
use core::fmt;
use std::sync::Arc;

use crate::division::{Culling, Division, Interval};
use crate::info::MethodInfo;
use crate::record::{Of, Record, Value};
use crate::weights::{Alpha, Implied};
use trisect_core::{Hit, Ray, Triangle, Vec3};
use trisect_core::{Lanes, Scalar};

/// Where a line meets a plane, before division: `t = t/det`, `beta = beta/det`,
/// `gamma = gamma/det`. `det = 0` where the ray is parallel to the plane.
///
/// A method that answers with a flag and `t` alone (see [`MethodInfo::outputs`]) gives as weights
/// any numbers that have the sign of `det`, or none, where the point is inside.
#[derive(Clone, Copy, Debug)]
pub struct Homogeneous<L, A = Implied> {
    /// The common denominator; its sign is the method's own.
    pub det: L,
    /// Numerator of `t`.
    pub t: L,
    /// Numerator of `alpha`, where the method computes it.
    pub alpha: A,
    /// Numerator of `beta`.
    pub beta: L,
    /// Numerator of `gamma`.
    pub gamma: L,
}

/// Where a line meets a plane, after division.
#[derive(Clone, Copy, Debug)]
pub struct Quotients<L, A = Implied> {
    /// The denominator that was divided by.
    pub det: L,
    /// `t`
    pub t: L,
    /// `alpha`, where the method computes it.
    pub alpha: A,
    /// `beta`
    pub beta: L,
    /// `gamma`
    pub gamma: L,
}

impl<L, A> Quotients<L, A> {
    /// What a hit returns of it.
    #[inline(always)]
    pub fn hit(self) -> Hit<L> {
        Hit { t: self.t, beta: self.beta, gamma: self.gamma }
    }
}

/// What is computed once per ray, in parts, so that rays of a packet may share what depends on a
/// common origin or direction alone: a loop over the rays then computes it once.
pub trait RayParts: Copy {
    /// Takes over what depends on the origin alone.
    fn take_origin(&mut self, from: &Self);
    /// Takes over what depends on the direction alone.
    fn take_direction(&mut self, from: &Self);
}

impl<L: Lanes> RayParts for Ray<L> {
    #[inline(always)]
    fn take_origin(&mut self, from: &Self) {
        self.o = from.o;
    }
    #[inline(always)]
    fn take_direction(&mut self, from: &Self) {
        self.d = from.d;
    }
}

/// A ray–triangle method: how a triangle is prepared and one formula over lanes.
///
/// Everything under a kernel is inlined by hand, since a function that stays out of line does not
/// get the instruction set of its caller: mark each function and closure `#[inline(always)]`.
pub trait Method: Send + Sync + Sized + 'static {
    /// Facts for lists and pages.
    const INFO: MethodInfo;
    /// How many kinds of triangles the formula tells apart. Triangles are stored sorted by kind,
    /// and a ray is prepared once per kind: a projected axis costs nothing per test.
    const GROUPS: usize = 1;
    /// Whether space is turned, by renaming its axes, so that the direction of a ray is longest
    /// along the last one before anything sees ray or triangle. Costs nothing per test: the rays of
    /// a packet are chosen to share the axis.
    const TURNS: bool = false;
    /// The stages of which one decides a pair, the cheapest first; none where all pairs go one way.
    const STAGES: &'static [&'static str] = &[];
    /// What is stored per triangle.
    type Prepared: Record;
    /// What is computed once per ray (and group).
    type PreparedRay<L: Lanes>: RayParts;
    /// Whether the weight of corner `A` is computed ([`Given`](crate::Given)) or implied by the
    /// two others ([`Implied`]).
    type Alpha<L: Lanes>: Alpha<L>;

    /// The kind of a triangle, below [`GROUPS`](Method::GROUPS).
    #[inline(always)]
    fn group<X: Scalar>(_triangle: &Triangle<X>) -> usize {
        0
    }

    /// The kind that all triangles of a mesh are prepared as, for methods that fix it for the whole
    /// mesh; by default each has its own.
    ///
    /// # Errors
    /// When the method cannot take the mesh.
    fn mesh_group<X: Scalar>(_triangles: &[Triangle<X>]) -> Result<Option<usize>, UnsuitableMesh> {
        Ok(None)
    }

    /// What is stored for a triangle of kind `group`. The triangle is finite and has an area, or is
    /// NaN all over: degenerate ones, and what fills up a block, are replaced by that before.
    fn prepare<X: Scalar>(triangle: &Triangle<X>, group: usize) -> Of<Self::Prepared, X>;

    /// What is computed once per ray for triangles of kind `group`.
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, group: usize) -> Self::PreparedRay<L>;

    /// The formula. A method that has the early form alone gives it for decisions without values, which are made
    /// by numerators; one that [always divides](MethodInfo::always_divides) gives it over a denominator of ±1.
    fn intersect<L: Lanes>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
    ) -> Homogeneous<L, Self::Alpha<L>>;

    /// The formula with the division first: `reciprocal(det)` is the only division allowed.
    /// Override where that saves products.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L, Self::Alpha<L>> {
        let Homogeneous { det, t, alpha, beta, gamma } = Self::intersect(ray, triangle);
        let r = reciprocal(det);
        Quotients { det, t: t * r, alpha: alpha.scale(r), beta: beta * r, gamma: gamma * r }
    }

    /// Positive where the ray meets the front face (from which the corners run
    /// counter-clockwise), negative at the back. The default holds for `det = −D·N`.
    #[inline(always)]
    fn facing<L: Lanes>(
        _ray: &Self::PreparedRay<L>,
        _triangle: &Of<Self::Prepared, L>,
        det: L,
    ) -> L {
        det
    }

    /// The normal `(B − A) × (C − A)`, with its length, of a triangle of kind `group`; `None` unless
    /// [`MethodInfo::outputs`] lists it.
    #[inline(always)]
    fn normal<L: Lanes>(_triangle: &Of<Self::Prepared, L>, _group: usize) -> Option<Vec3<L>> {
        None
    }

    /// Decides a vector of pairs as `D` says. Override where a paper's order of tests and division
    /// is the method; see [`Division::test`].
    #[inline(always)]
    fn test<L: Lanes, D: Division>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(L::Mask, Hit<L>),
    ) {
        D::test::<Self, L>(ray, triangle, interval, culling, found);
    }

    /// Calls `with` back as what the method is: one that rounds, unless it is an [`ExactMethod`], which says so
    /// here. What is generic over methods learns by it which of the two it has.
    #[inline(always)]
    fn refine<R: Refine<Self>>(with: R) -> R::Output {
        with.rounded()
    }

    /// The place among [`STAGES`](Method::STAGES) of the one that decides a pair in plain arithmetic.
    fn stage<X: Scalar>(_ray: &Ray<X>, _triangle: &Triangle<X>) -> usize {
        0
    }
}

/// A method cannot take a mesh: what stands in the way, and what to do about it, in the method's own error.
#[derive(Clone, Debug)]
pub struct UnsuitableMesh(Arc<dyn Error + Send + Sync>);

impl UnsuitableMesh {
    /// A mesh that a method cannot take for that reason.
    pub fn new(reason: impl Error + Send + Sync + 'static) -> Self {
        Self(Arc::new(reason))
    }
}

impl fmt::Display for UnsuitableMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Equal where they say the same.
impl PartialEq for UnsuitableMesh {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}

impl Eq for UnsuitableMesh {}

impl Error for UnsuitableMesh {
    // The reason is the message: its own cause is the next in the chain.
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.0.source()
    }
}

/// What is known of a vector of pairs before the doubtful ones are decided.
#[derive(Clone, Copy, Debug)]
pub struct Screened<L: Lanes> {
    /// Lanes that certainly hit a face that is seen.
    pub certain: L::Mask,
    /// Lanes, in bits, that neither certainly hit nor certainly miss; of either face.
    pub open: u64,
    /// A lower bound of `t` in lanes that are certain.
    pub low: L,
    /// An upper bound of `t` in lanes that are certain.
    pub high: L,
}

/// A method whose decisions, and whose order of hits along a ray, are those of exact arithmetic.
///
/// A tree rarely needs more than bounds of `t` to tell which of two hits is nearer. So such a method also screens
/// pairs without deciding all of them, orders two hits exactly, and computes the values of a hit by
/// themselves, once it is known which hit is the nearest.
pub trait ExactMethod: Method {
    /// Calls `found` with what is certain of a vector of pairs, unless all lanes certainly miss. The open ones
    /// are left to [`Method::test`].
    fn screen<L: Lanes>(
        ray: &Self::PreparedRay<L>,
        triangle: &Of<Self::Prepared, L>,
        interval: Interval<L>,
        culling: Culling,
        found: impl FnOnce(Screened<L>),
    );

    /// The corners of a triangle, as it was given.
    fn corners<X: Value>(triangle: &Of<Self::Prepared, X>) -> Triangle<X>;

    /// The values of the hits of ray `i` with triangle `i`, for each bit `i` of `hits`; other places hold
    /// arbitrary numbers. Rays and triangles as they were given. `L` are lanes whose instructions are at hand where
    /// this is inlined; numbers are themselves always.
    fn values<L: Lanes, X: Scalar, const N: usize>(
        rays: &Ray<&[X; N]>,
        triangles: &Triangle<[X; N]>,
        hits: u64,
    ) -> Hit<[X; N]>;

    /// Which of two triangles that a ray hits comes first along it; triangles as they were prepared, the ray as
    /// it was given.
    fn order<X: Scalar>(
        ray: &Ray<X>,
        first: &Of<Self::Prepared, X>,
        second: &Of<Self::Prepared, X>,
    ) -> Ordering;

    /// Whether a triangle that a ray hits owns that crossing. Every hit inside a triangle is its own. At an edge or
    /// a corner the ray is thought of as moved by `ε` along the first axis, `ε²` along the second and `ε³` along
    /// the third, less than any distance that there is, so that it meets neither: where a surface goes
    /// through the ray one of the triangles there owns the crossing, and where it turns back none or two do.
    ///
    /// H. Edelsbrunner, E. P. Mücke: Simulation of Simplicity. ACM Transactions on Graphics 9(1), 1990.
    fn owns<X: Scalar>(ray: &Ray<X>, triangle: &Of<Self::Prepared, X>) -> bool;

    /// Whether a point is on the closed triangle.
    fn is_on<X: Scalar>(point: Vec3<X>, triangle: &Of<Self::Prepared, X>) -> bool;
}

/// Code in two versions: for a method that rounds, and for one that is exact. [`Method::refine`] calls the one
/// that fits; the other is not compiled.
pub trait Refine<M: Method>: Sized {
    /// What both return.
    type Output;

    /// For a method that rounds.
    fn rounded(self) -> Self::Output;

    /// For a method that is exact.
    fn exact(self) -> Self::Output
    where
        M: ExactMethod;
}

/// Something to do for each of a list of methods.
pub trait MethodVisitor {
    /// One method.
    fn visit<M: Method>(&mut self);

    /// One that stores something else in trees: there it is `T`, which answers alike.
    fn visit_with_trees<M: Method, T: Method>(&mut self) {
        self.visit::<M>();
    }
}

/// Names the methods of a crate: declares `pub fn methods`, which the catalogue calls. For a method that stores
/// something else in trees, `methods!(Method; in trees: MethodInTrees)`.
#[macro_export]
macro_rules! methods {
    ($method:ty; in trees: $in_trees:ty) => {
        /// Visits the method of this crate.
        pub fn methods(visitor: &mut impl $crate::MethodVisitor) {
            visitor.visit_with_trees::<$method, $in_trees>();
        }
    };
    ($($method:ty),+ $(,)?) => {
        /// Visits the methods of this crate.
        pub fn methods(visitor: &mut impl $crate::MethodVisitor) {
            $(visitor.visit::<$method>();)+
        }
    };
}
