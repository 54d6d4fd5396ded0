//! Triangles as they are given: what methods store that prepare nothing, or little.

use crate::record;
use trisect_core::Scalar;
use trisect_core::{Triangle, Vec3};

record! {
    /// The three points of a triangle.
    pub struct Corners {
        /// Corner `A`.
        a: vec3,
        /// Corner `B`.
        b: vec3,
        /// Corner `C`.
        c: vec3,
    }
}

impl<X: Scalar> Corners<X> {
    /// The points as they are.
    #[inline(always)]
    pub fn new(triangle: &Triangle<X>) -> Self {
        let Triangle { a, b, c } = *triangle;
        Self { a, b, c }
    }
}

impl<X: Copy> Corners<X> {
    /// The edges `e1 = B − A` and `e2 = C − A`.
    #[inline(always)]
    pub fn edges(&self) -> (Vec3<X>, Vec3<X>)
    where
        X: trisect_core::Number,
    {
        (self.b - self.a, self.c - self.a)
    }

    /// The normal `(B − A) × (C − A)`, with its length.
    #[inline(always)]
    pub fn normal(&self) -> Vec3<X>
    where
        X: trisect_core::Number,
    {
        let (e1, e2) = self.edges();
        e1.cross(e2)
    }
}
