//! Where a test has a triangle's normal from.

use trisect_core::{Lanes, Scalar, Vec3};
use trisect_method::{Of, Record, Value, record};

use crate::filter::SizedTriangle;

record! {
    /// A normal of no particular length.
    pub struct Normal {
        /// Its coordinates.
        n: vec3,
    }
}

/// Where a test has a triangle's normal from.
pub trait Normals: Send + Sync + 'static {
    /// What is stored per triangle.
    type Prepared: Record;

    /// Prepares a triangle.
    fn prepare<X: Scalar>(triangle: SizedTriangle<X>) -> Of<Self::Prepared, X>;

    /// Its corners and its size.
    fn sized<X: Value>(prepared: &Of<Self::Prepared, X>) -> &SizedTriangle<X>;

    /// Its normal, `(C − A) × (B − A)`.
    fn normal<L: Lanes>(prepared: &Of<Self::Prepared, L>) -> Vec3<L>;
}

/// It is computed by each test: 10 numbers a triangle, for who tests so many triangles that they have to be
/// fetched from afar.
pub struct Computed;

impl Normals for Computed {
    type Prepared = SizedTriangle<()>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: SizedTriangle<X>) -> SizedTriangle<X> {
        triangle
    }

    #[inline(always)]
    fn sized<X: Value>(prepared: &SizedTriangle<X>) -> &SizedTriangle<X> {
        prepared
    }

    #[inline(always)]
    fn normal<L: Lanes>(prepared: &SizedTriangle<L>) -> Vec3<L> {
        prepared.normal()
    }
}

/// It is stored: 13 numbers a triangle, and fewer operations, for the leaves of a tree.
pub struct Stored;

impl Normals for Stored {
    type Prepared = (SizedTriangle<()>, Normal<()>);

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: SizedTriangle<X>) -> (SizedTriangle<X>, Normal<X>) {
        (triangle, Normal { n: triangle.normal() })
    }

    #[inline(always)]
    fn sized<X: Value>((sized, _): &(SizedTriangle<X>, Normal<X>)) -> &SizedTriangle<X> {
        sized
    }

    #[inline(always)]
    fn normal<L: Lanes>((_, normal): &(SizedTriangle<L>, Normal<L>)) -> Vec3<L> {
        normal.n
    }
}
