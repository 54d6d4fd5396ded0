//! Boxes whose sides are parallel to the axes.

use trisect_core::Vec3;

/// Coordinates and directions are trusted up to this, 2¹²⁶: differences do not overflow, and the inverse of a
/// direction is not subnormal.
pub(crate) const LARGEST: f32 = f32::MAX / 4.0;

/// The points between two corners; of the empty box the smaller one is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min: [f32; 3],
    pub(crate) max: [f32; 3],
}

impl Bounds {
    /// The least and the largest corner.
    pub(crate) fn corners(&self) -> [Vec3<f32>; 2] {
        [self.min.into(), self.max.into()]
    }

    /// The largest coordinate, in magnitude; infinite for the empty box.
    pub(crate) fn largest(&self) -> f32 {
        self.min.iter().chain(&self.max).fold(0.0, |largest: f32, x| largest.max(x.abs()))
    }

    /// Half the area of the surface; zero for the empty box, infinite where it overflows.
    #[inline]
    pub(crate) fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| (self.max[axis] - self.min[axis]).max(0.0));
        x * y + y * z + z * x
    }
}
