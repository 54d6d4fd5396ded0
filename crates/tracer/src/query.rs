//! What is asked of each ray, as a type: the loops are compiled for it, and ask nothing while they run.

use std::marker::PhantomData;

use trisect_method::{Culling, Method};

use crate::hit::TriangleHit;
use crate::precision::Real;

/// What is asked of each ray.
pub(crate) trait Query: Copy + Send + Sync {
    /// Whether any hit will do: the first one that is found ends the ray.
    const ANY: bool;
    /// How boxes are tested.
    type Boxes: Boxes;
    /// What is known of a ray that has left the tree.
    type Found: Copy;
    /// What a caller gets for it.
    type Output: Send;

    /// From the one to the other.
    fn output(found: &Self::Found) -> Self::Output;
}

/// How boxes are tested.
pub(crate) trait Boxes: Copy + Send + Sync {
    /// Whether tests allow for their own rounding, so that no true hit is lost.
    const ROBUST: bool;
    /// Whether an interval ends a little later than at the best hit.
    const LATE: bool;
}

/// Tests allow for their own rounding.
#[derive(Clone, Copy)]
pub(crate) struct Robust;

impl Boxes for Robust {
    const ROBUST: bool = true;
    const LATE: bool = true;
}

/// Tests do not: boxes were made larger when they were built.
#[derive(Clone, Copy)]
pub(crate) struct Tight;

impl Boxes for Tight {
    const ROBUST: bool = false;
    const LATE: bool = false;
}

/// Nor do these: boxes are so much larger that [no true hit is lost](crate::bvh::frame).
#[derive(Clone, Copy)]
pub(crate) struct Widened;

impl Boxes for Widened {
    const ROBUST: bool = false;
    const LATE: bool = true;
}

/// Tests keep the promise of a method.
pub(crate) struct Promised<M>(PhantomData<M>);

impl<M> Clone for Promised<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Promised<M> {}

impl<M: Method> Boxes for Promised<M> {
    const ROBUST: bool = M::INFO.claims.watertight;
    const LATE: bool = Self::ROBUST;
}

/// Which faces are seen: a type where a loop is compiled for both, and otherwise a value.
pub(crate) trait Faces: Copy + Send + Sync {
    /// The faces that are not seen.
    fn culling(self) -> Culling;
}

/// Both faces are seen.
#[derive(Clone, Copy)]
pub(crate) struct Both;

impl Faces for Both {
    #[inline(always)]
    fn culling(self) -> Culling {
        Culling::None
    }
}

impl Faces for Culling {
    #[inline(always)]
    fn culling(self) -> Culling {
        self
    }
}

/// The nearest hit, of equally near ones that of the lowest id.
#[derive(Clone, Copy)]
pub(crate) struct Closest<B, F, P = f32> {
    pub(crate) faces: F,
    pub(crate) boxes: PhantomData<(B, P)>,
}

impl<B: Boxes, F: Faces, P: Real> Query for Closest<B, F, P> {
    const ANY: bool = false;
    type Boxes = B;
    type Found = TriangleHit<P>;
    type Output = Option<TriangleHit<P>>;

    #[inline(always)]
    fn output(found: &TriangleHit<P>) -> Option<TriangleHit<P>> {
        found.is_hit().then_some(*found)
    }
}

/// Whether there is a hit.
#[derive(Clone, Copy)]
pub(crate) struct Any<B, F> {
    pub(crate) faces: F,
    pub(crate) boxes: PhantomData<B>,
}

impl<B: Boxes, F: Faces> Query for Any<B, F> {
    const ANY: bool = true;
    type Boxes = B;
    type Found = bool;
    type Output = bool;

    #[inline(always)]
    fn output(found: &bool) -> bool {
        *found
    }
}

/// Whether there is a nearest hit: as [`Any`], decided as [`Closest`] decides.
#[derive(Clone, Copy)]
pub(crate) struct HasClosest;

impl Query for HasClosest {
    const ANY: bool = false;
    type Boxes = Robust;
    type Found = TriangleHit;
    type Output = bool;

    #[inline(always)]
    fn output(found: &TriangleHit) -> bool {
        found.is_hit()
    }
}

impl<B, F, P> Closest<B, F, P> {
    pub(crate) const fn new(faces: F) -> Self {
        Self { faces, boxes: PhantomData }
    }
}

impl<B, F> Any<B, F> {
    pub(crate) const fn new(faces: F) -> Self {
        Self { faces, boxes: PhantomData }
    }
}
