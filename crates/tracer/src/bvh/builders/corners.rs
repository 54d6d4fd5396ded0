//! Boxes as the builders see them: eight numbers of which the smaller ones win.

use trisect_core::{Triangle, Vec3};

use crate::bvh::bounds::Bounds;

/// The smaller corner of a box, and the larger one with its signs changed, each followed by a number to
/// spare: so the union of two is the smaller of eight numbers each, and the common part the larger.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Corners(pub(crate) [f32; 8]);

/// The box of a triangle, or of a part of it; the id of the triangle is in the first place to spare,
/// as bits. Numbers alone, so that room for many is had from the system as zeros, untouched until used.
pub(crate) type Reference = [f32; 8];

/// The id of the triangle.
#[inline]
pub(crate) fn id(reference: &Reference) -> u32 {
    reference[3].to_bits()
}

impl Corners {
    /// Without any point.
    pub(crate) const EMPTY: Self = Self([f32::INFINITY; 8]);

    pub(crate) fn of_triangle(triangle: &Triangle<f32>) -> Self {
        let Triangle { a, b, c } = *triangle;
        let mut corners = Self::of_point(a.to_array());
        corners.add(&Self::of_point(b.to_array()));
        corners.add(&Self::of_point(c.to_array()));
        corners
    }

    #[inline]
    pub(crate) fn of_point([x, y, z]: [f32; 3]) -> Self {
        Self([x, y, z, 0.0, -x, -y, -z, 0.0])
    }

    #[inline]
    pub(crate) fn reference(&self, id: u32) -> Reference {
        let mut reference = self.0;
        reference[3] = f32::from_bits(id);
        reference
    }

    /// Extends it to what is in the other as well.
    #[inline]
    pub(crate) fn add(&mut self, other: &Self) {
        // Not `f32::min`, which minds NaN and is no single instruction.
        for (a, &b) in self.0.iter_mut().zip(&other.0) {
            *a = if b < *a { b } else { *a };
        }
    }

    #[inline]
    pub(crate) fn with(&self, other: &Self) -> Self {
        let mut both = *self;
        both.add(other);
        both
    }

    /// What both have in common: may be empty.
    #[inline]
    pub(crate) fn common(&self, other: &Self) -> Self {
        let mut both = *self;
        for (a, &b) in both.0.iter_mut().zip(&other.0) {
            *a = if b > *a { b } else { *a };
        }
        both
    }

    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        let c = &self.0;
        c[0] > -c[4] || c[1] > -c[5] || c[2] > -c[6]
    }

    /// Half the area of the surface of a box that is not empty; infinite where it overflows.
    #[inline]
    pub(crate) fn half_area(&self) -> f32 {
        // The extents have the wrong sign, all of them, which no product of two shows.
        let c = &self.0;
        let (x, y, z) = (c[0] + c[4], c[1] + c[5], c[2] + c[6]);
        x * (y + z) + y * z
    }

    /// Twice the middle: the order of middles is all that matters.
    #[inline]
    pub(crate) fn twice_middle(&self) -> [f32; 4] {
        let c = &self.0;
        [c[0] - c[4], c[1] - c[5], c[2] - c[6], 0.0]
    }

    #[inline]
    pub(crate) fn min(&self, axis: usize) -> f32 {
        self.0[axis]
    }

    #[inline]
    pub(crate) fn max(&self, axis: usize) -> f32 {
        -self.0[axis + 4]
    }

    /// The largest magnitude of a coordinate.
    pub(crate) fn largest(&self) -> f32 {
        (0..3).fold(0.0, |most: f32, axis| most.max(-self.min(axis)).max(self.max(axis)))
    }

    /// Rounded, where coordinates become subnormal.
    pub(crate) fn scaled(&self, factor: f32) -> Self {
        Self(self.0.map(|x| x * factor))
    }

    pub(crate) fn extents(&self) -> [f32; 3] {
        [0, 1, 2].map(|axis| self.max(axis) - self.min(axis))
    }

    /// The least and the largest corner.
    pub(crate) fn corners(&self) -> [Vec3<f32>; 2] {
        self.bounds().corners()
    }

    pub(crate) fn bounds(&self) -> Bounds {
        let c = &self.0;
        Bounds { min: [c[0], c[1], c[2]], max: [-c[4], -c[5], -c[6]] }
    }
}
