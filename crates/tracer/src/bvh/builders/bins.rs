//! Many references: splits between bins of equal width are tried.
//!
//! Wald: On fast Construction of SAH-based Bounding Volume Hierarchies. IEEE Symposium on Interactive
//! Ray Tracing, 2007.

use rayon::prelude::*;

use super::corners::{Corners, Reference};

/// Bins along each axis.
pub(crate) const BINS: usize = 32;

/// References that are put in bins in one go.
const CHUNK: usize = 1 << 14;

/// Added to a number below 2²¹ it leaves the nearest whole number in the lowest bits.
const TO_BITS: f32 = 12_582_912.0;

/// The bin of the nearest whole number; of what is no number below the number of bins, any one.
#[inline]
pub(crate) fn whole(place: f32) -> usize {
    (place + TO_BITS).to_bits() as usize % BINS
}

/// Which bin a middle is in.
pub(crate) struct Grid {
    base: [f32; 4],
    scale: [f32; 4],
}

impl Grid {
    /// Bins between bounds of twice the middles.
    pub(crate) fn new(middles: &Corners) -> Self {
        let (mut base, mut scale) = ([0.0; 4], [0.0; 4]);
        for axis in 0..3 {
            base[axis] = middles.min(axis);
            let factor = (BINS as f32 - 0.02) / (middles.max(axis) - middles.min(axis));
            // All in one bin where there is no extent, or none that a bin could tell.
            scale[axis] = if factor.is_finite() { factor } else { 0.0 };
        }
        Self { base, scale }
    }

    /// Along each axis. The order of bins is that of the middles, whatever rounds.
    #[inline]
    pub(crate) fn bins(&self, corners: &Corners) -> [usize; 4] {
        let middle = corners.twice_middle();
        let mut bins = [0; 4];
        for axis in 0..4 {
            let place = (middle[axis] - self.base[axis]) * self.scale[axis] - 0.49;
            bins[axis] = whole(place);
        }
        bins
    }
}

/// What is in each bin along each axis.
pub(crate) struct Bins {
    pub(crate) corners: [[Corners; BINS]; 3],
    pub(crate) counts: [[u32; BINS]; 3],
}

impl Bins {
    pub(crate) const EMPTY: Self =
        Self { corners: [[Corners::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    pub(crate) fn new(references: &[Reference], grid: &Grid) -> Self {
        if references.len() <= CHUNK {
            return Self::of_chunk(references, grid);
        }
        let chunks = references.par_chunks(CHUNK).map(|chunk| Self::of_chunk(chunk, grid));
        chunks.reduce(|| Self::EMPTY, |a, b| a.with(&b))
    }

    fn of_chunk(references: &[Reference], grid: &Grid) -> Self {
        let mut bins = Self::EMPTY;
        for reference in references {
            let corners = Corners(*reference);
            let places = grid.bins(&corners);
            for ((corners_of, counts), place) in
                bins.corners.iter_mut().zip(&mut bins.counts).zip(places)
            {
                corners_of[place % BINS].add(&corners);
                counts[place % BINS] += 1;
            }
        }
        bins
    }

    pub(crate) fn with(mut self, other: &Self) -> Self {
        for (a, b) in self.corners.iter_mut().flatten().zip(other.corners.iter().flatten()) {
            a.add(b);
        }
        for (a, b) in self.counts.iter_mut().flatten().zip(other.counts.iter().flatten()) {
            *a += b;
        }
        self
    }

    /// The cheapest split between bins, if there is one that leaves something on either side.
    pub(crate) fn cheapest(&self) -> Option<Split> {
        self.cheapest_of(&self.counts, &self.counts)
    }

    /// The same where what spans some bins is counted on the left from the first of them on, and on the
    /// right up to the last.
    pub(crate) fn cheapest_of(
        &self,
        entering: &[[u32; BINS]; 3],
        leaving: &[[u32; BINS]; 3],
    ) -> Option<Split> {
        let mut best = (f32::INFINITY, 0, 0);
        for axis in 0..3 {
            let corners_of = &self.corners[axis];
            let mut right = [0.0_f32; BINS];
            let (mut corners, mut count) = (Corners::EMPTY, 0);
            for border in (1..BINS).rev() {
                corners.add(&corners_of[border]);
                count += leaving[axis][border];
                right[border] = corners.half_area() * count as f32;
            }
            let (mut corners, mut count) = (Corners::EMPTY, 0);
            for border in 1..BINS {
                corners.add(&corners_of[border - 1]);
                count += entering[axis][border - 1];
                // Without references a side costs NaN, which is less than nothing.
                let cost = corners.half_area() * count as f32 + right[border];
                if cost < best.0 {
                    best = (cost, axis, border);
                }
            }
        }
        let (cost, axis, border) = best;
        if cost == f32::INFINITY {
            return None;
        }
        let side = |corners: &[Corners], counts: &[u32]| Side {
            bounds: corners.iter().fold(Corners::EMPTY, |all, corners| all.with(corners)),
            count: counts.iter().sum::<u32>() as usize,
        };
        let (left, right) = self.corners[axis].split_at(border);
        let left = side(left, &entering[axis][..border]);
        let right = side(right, &leaving[axis][border..]);
        Some(Split { cost, axis, border, left, right })
    }
}

/// A split between two bins.
pub(crate) struct Split {
    pub(crate) cost: f32,
    pub(crate) axis: usize,
    /// The first bin of the right side.
    pub(crate) border: usize,
    pub(crate) left: Side,
    pub(crate) right: Side,
}

impl Split {
    /// Half the area of what the boxes of both sides have in common.
    pub(crate) fn overlap(&self) -> f32 {
        let common = self.left.bounds.common(&self.right.bounds);
        if common.is_empty() { 0.0 } else { common.half_area() }
    }
}

/// What is on one side of a split.
pub(crate) struct Side {
    pub(crate) bounds: Corners,
    pub(crate) count: usize,
}
