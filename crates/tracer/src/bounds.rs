//! Boxes whose sides are parallel to the axes.

use trisect_core::{Triangle, Vec3};

/// The points between two corners; of the empty box the smaller one is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min: [f32; 3],
    pub(crate) max: [f32; 3],
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    pub(crate) fn of_triangle(triangle: &Triangle<f32>) -> Self {
        let mut bounds = Self::EMPTY;
        for corner in triangle.corners() {
            bounds.add_point(corner);
        }
        bounds
    }

    #[inline]
    fn add_point(&mut self, point: Vec3<f32>) {
        for (axis, x) in point.to_array().into_iter().enumerate() {
            self.min[axis] = self.min[axis].min(x);
            self.max[axis] = self.max[axis].max(x);
        }
    }

    #[inline]
    pub(crate) fn add(&mut self, other: &Self) {
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
    }

    /// Half the area of the surface; zero for the empty box, infinite where it overflows.
    #[inline]
    pub(crate) fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| (self.max[axis] - self.min[axis]).max(0.0));
        x * y + y * z + z * x
    }

    /// Twice the middle: the order of middles is all that matters.
    #[inline]
    pub(crate) fn twice_middle(&self) -> [f32; 3] {
        [0, 1, 2].map(|axis| self.min[axis] + self.max[axis])
    }
}
