#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Corners, Homogeneous, Implied, Input, Method, MethodInfo, Of, Output, Record, record,
};

record! {
    /// A corner and the two edges at it, one leaving, one arriving.
    pub struct CornerTriangle {
        /// Corner `A`.
        a: vec3,
        /// Edge `ab = B − A`.
        ab: vec3,
        /// Edge `ca = A − C`.
        ca: vec3,
    }
}

record! {
    /// The normal `n = ab × ca`.
    pub struct StoredNormal {
        /// `ab × ca`, which points from the back.
        n: vec3,
    }
}

/// What is stored, and how the formula gets its vectors from it.
pub trait Storage: Send + Sync + 'static {
    /// Facts about the method that stores this.
    const INFO: MethodInfo;
    /// What is stored.
    type Stored: Record;
    /// What is stored for a triangle.
    fn store<X: Scalar>(triangle: &Triangle<X>) -> Of<Self::Stored, X>;
    /// The corner and the edges, and `n`.
    fn vectors<L: Lanes>(stored: &Of<Self::Stored, L>) -> (CornerTriangle<L>, Vec3<L>);
}

const INFO: MethodInfo = MethodInfo {
    name: "kensler-shirley",
    title: "Kensler–Shirley",
    year: 2006,
    source: "A. Kensler, P. Shirley: Optimizing Ray-Triangle Intersection via Automated \
             Search. IEEE Symposium on Interactive Ray Tracing, 2006",
    outputs: Output::ALL,
    // As Möller–Trumbore's: the same six products in each volume, rounded as often.
    error_factor: 9.0,
    ..MethodInfo::USUAL
};

/// The corner and the edges.
#[inline(always)]
fn corner_triangle<X: Scalar>(triangle: &Triangle<X>) -> CornerTriangle<X> {
    let a = triangle.a;
    CornerTriangle { a, ab: triangle.b - a, ca: a - triangle.c }
}

#[inline(always)]
fn from_points<L: Lanes>(corners: &Corners<L>) -> CornerTriangle<L> {
    CornerTriangle { a: corners.a, ab: corners.b - corners.a, ca: corners.a - corners.c }
}

/// A corner and the edges.
pub struct Edges;

impl Storage for Edges {
    const INFO: MethodInfo = INFO;
    type Stored = CornerTriangle<()>;
    #[inline(always)]
    fn store<X: Scalar>(triangle: &Triangle<X>) -> CornerTriangle<X> {
        corner_triangle(triangle)
    }
    #[inline(always)]
    fn vectors<L: Lanes>(stored: &CornerTriangle<L>) -> (CornerTriangle<L>, Vec3<L>) {
        // The normal depends on the triangle alone: a packet of rays shares it.
        (*stored, stored.ab.cross(stored.ca))
    }
}

/// The three points.
pub struct Points;

impl Storage for Points {
    const INFO: MethodInfo = MethodInfo {
        name: "kensler-shirley-points",
        title: "Kensler–Shirley from points",
        input: Input::Points,
        ..INFO
    };
    type Stored = Corners<()>;
    #[inline(always)]
    fn store<X: Scalar>(triangle: &Triangle<X>) -> Corners<X> {
        Corners::new(triangle)
    }
    #[inline(always)]
    fn vectors<L: Lanes>(stored: &Corners<L>) -> (CornerTriangle<L>, Vec3<L>) {
        Edges::vectors(&from_points(stored))
    }
}

/// The three points and the normal.
pub struct PointsAndNormal;

impl Storage for PointsAndNormal {
    const INFO: MethodInfo = MethodInfo {
        name: "kensler-shirley-normal",
        title: "Kensler–Shirley with the normal",
        input: Input::PointsAndNormal,
        ..INFO
    };
    type Stored = (Corners<()>, StoredNormal<()>);
    #[inline(always)]
    fn store<X: Scalar>(triangle: &Triangle<X>) -> Of<Self::Stored, X> {
        (Corners::new(triangle), StoredNormal { n: -triangle.normal() })
    }
    #[inline(always)]
    fn vectors<L: Lanes>(stored: &Of<Self::Stored, L>) -> (CornerTriangle<L>, Vec3<L>) {
        (from_points(&stored.0), stored.1.n)
    }
}

/// A corner, the edges and the normal.
pub struct Everything;

impl Storage for Everything {
    const INFO: MethodInfo =
        MethodInfo {
            name: "kensler-shirley-stored", title: "Kensler–Shirley, all stored", ..INFO
        };
    type Stored = (CornerTriangle<()>, StoredNormal<()>);
    #[inline(always)]
    fn store<X: Scalar>(triangle: &Triangle<X>) -> Of<Self::Stored, X> {
        (corner_triangle(triangle), StoredNormal { n: -triangle.normal() })
    }
    #[inline(always)]
    fn vectors<L: Lanes>(stored: &Of<Self::Stored, L>) -> (CornerTriangle<L>, Vec3<L>) {
        (stored.0, stored.1.n)
    }
}

/// Kensler–Shirley 2006.
pub struct KenslerShirley<S = Edges>(core::marker::PhantomData<S>);

impl<S: Storage> Method for KenslerShirley<S> {
    const INFO: MethodInfo = S::INFO;
    type Prepared = S::Stored;
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Implied;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        S::store(triangle)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, stored: &Of<Self::Prepared, L>) -> Homogeneous<L> {
        let (CornerTriangle { a, ab, ca }, n) = S::vectors(stored);
        let oa = a - ray.o;
        let i = oa.cross(ray.d);
        Homogeneous {
            det: ray.d.dot(n),
            t: n.dot(oa),
            alpha: Implied,
            beta: i.dot(ca),
            gamma: i.dot(ab),
        }
    }

    #[inline(always)]
    fn normal<L: Lanes>(stored: &Of<Self::Prepared, L>, _group: usize) -> Option<Vec3<L>> {
        Some(-S::vectors(stored).1)
    }
}

trisect_method::methods!(
    KenslerShirley<Edges>,
    KenslerShirley<Points>,
    KenslerShirley<PointsAndNormal>,
    KenslerShirley<Everything>,
);
