//! The precision of a tree: that of its triangles, its rays and its hits. Its boxes are in f32, whatever that is.

use std::borrow::Cow;

use trisect_core::{Float, Lanes, Ray, Token, Triangle};
use trisect_method::{Method, UnsuitableMesh};

use crate::bvh::builders::settings::{Builder, Leaves};
use crate::bvh::frame::{Frame, Span};
use crate::rays::slabs;
use crate::traced::{self, Built};
use crate::traced_f64;

/// `f32` or `f64`: the precision of a tree's triangles, rays and hits.
pub trait Precision: Real {}

impl Precision for f32 {}
impl Precision for f64 {}

/// What a tree knows of its precision.
pub trait Real: Float {
    /// Zero.
    const ZERO: Self;
    /// The largest finite number.
    const MAX: Self;
    /// Infinity.
    const INFINITY: Self;
    /// Minus infinity.
    const NEG_INFINITY: Self;
    /// How far beyond a hit an interval still ends, relative to its `t`.
    const ROUNDINGS: Self;
    /// The same, where that underflows.
    const UNDERFLOW: Self;

    /// Lanes of the precision, for who has lanes of f32.
    type Lanes<L: Lanes<Elem = f32>>: Lanes<Elem = Self, Token = L::Token>;

    /// From `t` along a ray to that along the same ray among the boxes.
    type Span: Copy;

    /// The triangles as boxes are built around them, and where they are for that.
    fn in_frame(triangles: &[Triangle<Self>]) -> (Cow<'_, [Triangle<f32>]>, Option<Frame>);

    /// A ray as it goes through the boxes. Its interval is [as leaves take it](trisect_method::Interval::of).
    fn enter(frame: Option<&Frame>, ray: &Ray<Self>) -> Entry<Self>;

    /// Where a ray ends among the boxes that ends at `t`; not before it.
    fn end(span: Self::Span, t: Self) -> f32;

    /// A whole number from 0 to 7.
    fn from_index(index: usize) -> Self;

    /// That number.
    fn index(self) -> usize;

    /// Builds a tree whose loops are compiled for the method.
    ///
    /// # Errors
    /// When the method cannot take the mesh.
    fn traced<M: Method>(
        triangles: &[Triangle<Self>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Built<Self>, UnsuitableMesh>;
}

/// How a ray goes through the boxes of a tree.
pub enum Entry<P: Real> {
    /// It meets none.
    Missed,
    /// As this ray does.
    Boxes(Ray<f32>, P::Span),
    /// They say nothing about it: it may meet every triangle.
    Everywhere,
}

macro_rules! numbers {
    ($float:ident) => {
        const ZERO: Self = 0.0;
        const MAX: Self = $float::MAX;
        const INFINITY: Self = $float::INFINITY;
        const NEG_INFINITY: Self = $float::NEG_INFINITY;

        #[inline(always)]
        fn from_index(index: usize) -> Self {
            index as $float
        }

        #[allow(clippy::cast_possible_truncation, reason = "a whole number below eight")]
        #[allow(clippy::cast_sign_loss, reason = "it has no sign")]
        #[inline(always)]
        fn index(self) -> usize {
            self as i32 as usize
        }
    };
}

/// Rays go through the boxes as they are.
impl Real for f32 {
    numbers!(f32);
    const ROUNDINGS: Self = slabs::ROUNDINGS;
    const UNDERFLOW: Self = slabs::UNDERFLOW;
    type Lanes<L: Lanes<Elem = f32>> = L;
    type Span = ();

    fn in_frame(triangles: &[Triangle<f32>]) -> (Cow<'_, [Triangle<f32>]>, Option<Frame>) {
        (Cow::Borrowed(triangles), None)
    }

    #[inline(always)]
    fn enter(_: Option<&Frame>, ray: &Ray<f32>) -> Entry<f32> {
        Entry::Boxes(*ray, ())
    }

    #[inline(always)]
    fn end((): (), t: f32) -> f32 {
        t
    }

    fn traced<M: Method>(
        triangles: &[Triangle<f32>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Built<f32>, UnsuitableMesh> {
        Ok(Built(traced::in_f32::<M, true>(triangles, builder, leaves)?))
    }
}

/// Rays and triangles are brought into the [frame](Frame) of the boxes.
impl Real for f64 {
    numbers!(f64);
    const ROUNDINGS: Self = 8.0 * (f64::EPSILON / 2.0);
    const UNDERFLOW: Self = 4.0 * f64::MIN_POSITIVE;
    type Lanes<L: Lanes<Elem = f32>> = <L::Token as Token>::Doubles;
    type Span = Span;

    fn in_frame(triangles: &[Triangle<f64>]) -> (Cow<'_, [Triangle<f32>]>, Option<Frame>) {
        let (triangles, frame) = Frame::around(triangles);
        (Cow::Owned(triangles), Some(frame))
    }

    #[inline(always)]
    fn enter(frame: Option<&Frame>, ray: &Ray<f64>) -> Entry<f64> {
        match frame {
            Some(frame) => frame.enter(ray),
            None => Entry::Everywhere,
        }
    }

    #[inline(always)]
    fn end(span: Span, t: f64) -> f32 {
        span.end(t)
    }

    fn traced<M: Method>(
        triangles: &[Triangle<f64>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Built<f64>, UnsuitableMesh> {
        Ok(Built(traced_f64::in_f64::<M>(triangles, builder, leaves)?))
    }
}
