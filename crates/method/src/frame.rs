//! Where the constants of stored linear functions are measured from: the world's origin, as the
//! papers have it, or a corner of the triangle.

use crate::record;
use crate::record::{Of, Record};
use trisect_core::Vec3;
use trisect_core::{Lanes, Scalar};

record! {
    /// The values at the world's origin of the three functions of a triangle.
    pub struct Constants {
        /// Of the plane's function, which is zero on the plane.
        plane: number,
        /// Of `beta`.
        beta: number,
        /// Of `gamma`.
        gamma: number,
    }
}

record! {
    /// The corner at which the plane's function, `beta` and `gamma` are all zero.
    pub struct Corner {
        /// Corner `A`.
        a: vec3,
    }
}

record! {
    /// A plane's constant, and what is left of the corner where the triangle is projected along the
    /// third axis.
    pub struct Anchor {
        /// The slope of the plane times corner `A`.
        plane: number,
        /// First coordinate of corner `A`.
        au: number,
        /// Second coordinate of corner `A`.
        av: number,
    }
}

/// Where a ray starts, seen from corner `A`.
#[derive(Clone, Copy, Debug)]
pub struct Start<L> {
    /// The slope of the plane times `A − O`.
    pub height: L,
    /// First coordinate of `A − O`.
    pub u: L,
    /// Second coordinate of `A − O`.
    pub v: L,
}

/// One of the three functions of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// Zero on the plane.
    Plane,
    /// `beta` on the plane.
    Beta,
    /// `gamma` on the plane.
    Gamma,
}

/// How three linear functions that vanish at corner `A` are stored beside their slopes.
///
/// [`World`] stores a constant each, which grows with the distance from the world's origin and
/// cancels there; [`Vertex`] stores the corner and subtracts it from the ray's origin before any
/// product, so that only differences enter: three numbers either way.
pub trait Frame: Send + Sync + 'static {
    /// Whether constants are measured from corner `A`.
    const RELATIVE: bool;
    /// What is stored.
    type Stored: Record;

    /// What is stored for functions of the given slopes that vanish at `a`: plane, `beta`, `gamma`.
    fn store<X: Scalar>(a: Vec3<X>, slopes: [Vec3<X>; 3]) -> Of<Self::Stored, X>;

    /// A point as the functions take it.
    fn relative<L: Lanes>(stored: &Of<Self::Stored, L>, point: Vec3<L>) -> Vec3<L>;

    /// `slope · coordinate`, the last product of a function, with the function's constant times
    /// `weight` where there is one.
    fn last<L: Lanes>(
        stored: &Of<Self::Stored, L>,
        function: Function,
        slope: L,
        coordinate: L,
        weight: L,
    ) -> L;

    /// `value` with the function's constant, where there is one, added.
    fn plus<L: Lanes>(stored: &Of<Self::Stored, L>, function: Function, value: L) -> L;

    /// What is stored of the corner by a method that keeps no constant but the plane's.
    type Anchored: Record;

    /// What is stored for a plane of the given slope through `a`.
    fn anchor<X: Scalar>(a: Vec3<X>, slope: Vec3<X>) -> Of<Self::Anchored, X>;

    /// Where a ray from `o` starts, for a plane of the given slope.
    fn start<L: Lanes>(stored: &Of<Self::Anchored, L>, slope: Vec3<L>, o: Vec3<L>) -> Start<L>;

    /// A function of the point `p / weight`, times `weight`; `p` as [`relative`](Frame::relative)
    /// gives it.
    #[inline(always)]
    fn evaluate<L: Lanes>(
        stored: &Of<Self::Stored, L>,
        function: Function,
        slope: Vec3<L>,
        p: Vec3<L>,
        weight: L,
    ) -> L {
        let last = Self::last(stored, function, slope.z, p.z, weight);
        slope.x.mul_add(p.x, slope.y.mul_add(p.y, last))
    }
}

/// Measured from the world's origin.
pub struct World;

impl Frame for World {
    const RELATIVE: bool = false;
    type Stored = Constants<()>;

    #[inline(always)]
    fn store<X: Scalar>(a: Vec3<X>, [plane, beta, gamma]: [Vec3<X>; 3]) -> Constants<X> {
        Constants { plane: -plane.dot(a), beta: -beta.dot(a), gamma: -gamma.dot(a) }
    }

    #[inline(always)]
    fn relative<L: Lanes>(_stored: &Constants<L>, point: Vec3<L>) -> Vec3<L> {
        point
    }

    #[inline(always)]
    fn last<L: Lanes>(
        stored: &Constants<L>,
        function: Function,
        slope: L,
        coordinate: L,
        weight: L,
    ) -> L {
        slope.mul_add(coordinate, weight * constant(stored, function))
    }
    #[inline(always)]
    fn plus<L: Lanes>(stored: &Constants<L>, function: Function, value: L) -> L {
        value + constant(stored, function)
    }

    type Anchored = Anchor<()>;

    #[inline(always)]
    fn anchor<X: Scalar>(a: Vec3<X>, slope: Vec3<X>) -> Anchor<X> {
        Anchor { plane: slope.dot(a), au: a.x, av: a.y }
    }

    #[inline(always)]
    fn start<L: Lanes>(stored: &Anchor<L>, slope: Vec3<L>, o: Vec3<L>) -> Start<L> {
        Start { height: stored.plane - slope.dot(o), u: stored.au - o.x, v: stored.av - o.y }
    }
}

#[inline(always)]
fn constant<L: Lanes>(stored: &Constants<L>, function: Function) -> L {
    match function {
        Function::Plane => stored.plane,
        Function::Beta => stored.beta,
        Function::Gamma => stored.gamma,
    }
}

/// Measured from corner `A`.
pub struct Vertex;

impl Frame for Vertex {
    const RELATIVE: bool = true;
    type Stored = Corner<()>;

    #[inline(always)]
    fn store<X: Scalar>(a: Vec3<X>, _slopes: [Vec3<X>; 3]) -> Corner<X> {
        Corner { a }
    }

    #[inline(always)]
    fn relative<L: Lanes>(stored: &Corner<L>, point: Vec3<L>) -> Vec3<L> {
        point - stored.a
    }

    #[inline(always)]
    fn last<L: Lanes>(
        _stored: &Corner<L>,
        _function: Function,
        slope: L,
        coordinate: L,
        _weight: L,
    ) -> L {
        slope * coordinate
    }

    #[inline(always)]
    fn plus<L: Lanes>(_stored: &Corner<L>, _function: Function, value: L) -> L {
        value
    }

    type Anchored = Corner<()>;

    #[inline(always)]
    fn anchor<X: Scalar>(a: Vec3<X>, _slope: Vec3<X>) -> Corner<X> {
        Corner { a }
    }

    #[inline(always)]
    fn start<L: Lanes>(stored: &Corner<L>, slope: Vec3<L>, o: Vec3<L>) -> Start<L> {
        let s = stored.a - o;
        Start { height: slope.dot(s), u: s.x, v: s.y }
    }
}
