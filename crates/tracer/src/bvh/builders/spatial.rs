//! Splits of space: a triangle that spans the plane is on both sides, in part.
//!
//! Stich, Friedrich, Dietrich: Spatial Splits in Bounding Volume Hierarchies. High Performance Graphics
//! 2009: bins of space (section 4.2), and triangles that are better left whole (section 4.4).

use std::ops::Range;

use rayon::prelude::*;
use trisect_core::Triangle;

use super::bins::{BINS, Bins, Split, whole};
use super::corners::{Corners, Reference, id};
use crate::parallel::PARALLEL;

/// References that are put in bins in one go, where there are many.
const CHUNK: usize = 1 << 11;

/// References for each bin, within the limits: about as many as there are bins where there are few.
const PER_BIN: usize = 64;
const FEWEST: usize = 8;

/// What parts of triangles are cut from.
pub(crate) struct Cuts<'a> {
    pub(crate) triangles: &'a [Triangle<f32>],
    /// How much the box of a part is larger than the part on each side.
    pub(crate) margin: f32,
}

impl Cuts<'_> {
    /// The boxes of the parts of a reference on either side of a plane; one may be empty.
    ///
    /// What is cut is computed in f64, so that it is off by little more than half a unit in the last
    /// place of f32; the margin is larger, and gives room to methods that see triangles larger than they
    /// are. Nothing is outside the reference that is cut.
    fn cut(&self, reference: &Reference, axis: usize, plane: f32) -> (Corners, Corners) {
        let Triangle { a, b, c } = self.triangles[id(reference) as usize];
        let corners = [a.to_array(), b.to_array(), c.to_array()];
        let (mut left, mut right) = (Corners::EMPTY, Corners::EMPTY);
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (corners[from], corners[to]);
            let point = Corners::of_point(from);
            if from[axis] <= plane {
                left.add(&point);
            }
            if from[axis] >= plane {
                right.add(&point);
            }
            if from[axis] < plane && plane < to[axis] || to[axis] < plane && plane < from[axis] {
                let start = f64::from(from[axis]);
                let share = (f64::from(plane) - start) / (f64::from(to[axis]) - start);
                let mut point = [0.0; 3];
                for ((x, from), to) in point.iter_mut().zip(from).zip(to) {
                    let (from, to) = (f64::from(from), f64::from(to));
                    #[allow(
                        clippy::cast_possible_truncation,
                        reason = "rounds, and stays below to"
                    )]
                    let between = (from + share * (to - from)) as f32;
                    *x = between;
                }
                point[axis] = plane;
                let point = Corners::of_point(point);
                left.add(&point);
                right.add(&point);
            }
        }
        let whole = Corners(*reference);
        (left.widened(self.margin).common(&whole), right.widened(self.margin).common(&whole))
    }
}

impl Corners {
    #[inline]
    fn widened(mut self, margin: f32) -> Self {
        for x in &mut self.0 {
            *x -= margin;
        }
        self
    }
}

/// Parts of a triangle: one in each bin, and one on either side.
const PARTS: usize = BINS + 2;

/// Planes between bins of equal width along each axis.
#[derive(Clone, Copy)]
struct Planes {
    base: [f32; 3],
    width: [f32; 3],
    /// One over the width, 0 along an axis that space is not split along.
    inverse: [f32; 3],
    /// The last bin.
    last: f32,
}

impl Planes {
    /// Between bounds, for so many references: fewer of them are told apart by fewer bins. Along the
    /// axis of the split of objects and the longest one: of the third little is gained, indoors even.
    fn new(bounds: &Corners, references: usize, of_objects: usize) -> Self {
        let bins = (references / PER_BIN).clamp(FEWEST, BINS);
        let mut planes =
            Self { base: [0.0; 3], width: [0.0; 3], inverse: [0.0; 3], last: bins as f32 - 1.0 };
        let extents = bounds.extents();
        let longest = extents.iter().fold(0.0_f32, |most, &x| most.max(x));
        for (axis, extent) in extents.into_iter().enumerate() {
            if axis != of_objects && extent < longest {
                continue;
            }
            let width = extent / bins as f32;
            let inverse = 1.0 / width;
            if inverse.is_finite() {
                planes.base[axis] = bounds.min(axis);
                planes.width[axis] = width;
                planes.inverse[axis] = inverse;
            }
        }
        planes
    }

    #[inline]
    fn plane(&self, axis: usize, border: usize) -> f32 {
        self.base[axis] + self.width[axis] * border as f32
    }

    #[inline]
    fn bin(&self, axis: usize, x: f32) -> usize {
        let place = (x - self.base[axis]) * self.inverse[axis] - 0.5;
        let place = if place > 0.0 { place } else { 0.0 };
        let place = if place < self.last { place } else { self.last };
        whole(place)
    }

    /// Adds to each of the bins what of the triangle is in it, and in `whole`. Along each edge once;
    /// as it rounds: what is found is no more than an estimate. `parts` are empty, and are left so:
    /// those of the bins are one place further, and those on either side are for what is outside.
    fn slice(
        &self,
        axis: usize,
        triangle: &Triangle<f32>,
        whole: &Corners,
        places: Range<usize>,
        bins: &mut [Corners; BINS],
        parts: &mut [Corners; PARTS],
    ) {
        let Triangle { a, b, c } = *triangle;
        let corners = [a.to_array(), b.to_array(), c.to_array()];
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (mut from, mut to) = (corners[from], corners[to]);
            if from[axis] > to[axis] {
                (from, to) = (to, from);
            }
            let (low, high) = (self.bin(axis, from[axis]), self.bin(axis, to[axis]));
            let within = |place: usize| (place + 1).clamp(places.start, places.end + 1);
            let (low, high) = (within(low), within(high));
            parts[low % PARTS].add(&Corners::of_point(from));
            parts[high % PARTS].add(&Corners::of_point(to));
            if low == high {
                continue;
            }
            let inverse = 1.0 / (to[axis] - from[axis]);
            let mut slope = [0.0; 3];
            for at in 0..3 {
                slope[at] = (to[at] - from[at]) * inverse;
            }
            for border in low..high {
                let plane = self.plane(axis, border);
                let along = plane - from[axis];
                let mut point = [0.0; 3];
                for at in 0..3 {
                    point[at] = from[at] + slope[at] * along;
                }
                point[axis] = plane;
                let point = Corners::of_point(point);
                parts[border % PARTS].add(&point);
                parts[(border + 1) % PARTS].add(&point);
            }
        }
        for place in places.clone() {
            let part = parts[(place + 1) % PARTS].common(whole);
            if !part.is_empty() {
                bins[place % BINS].add(&part);
            }
        }
        parts[places.start..places.end + 2].fill(Corners::EMPTY);
    }
}

/// Bins of space.
struct SpatialBins {
    /// The parts in each bin, and how many references begin in it.
    bins: Bins,
    /// How many end in it.
    ends: [[u32; BINS]; 3],
}

impl SpatialBins {
    const EMPTY: Self = Self { bins: Bins::EMPTY, ends: [[0; BINS]; 3] };

    fn new(references: &[Reference], planes: Planes, cuts: &Cuts<'_>) -> Self {
        if references.len() < PARALLEL {
            return Self::of_chunk(references, planes, cuts);
        }
        let chunks = references.par_chunks(CHUNK);
        let bins = chunks.map(|chunk| Self::of_chunk(chunk, planes, cuts));
        bins.reduce(|| Self::EMPTY, |a, b| a.with(&b))
    }

    fn of_chunk(references: &[Reference], planes: Planes, cuts: &Cuts<'_>) -> Self {
        let mut all = Self::EMPTY;
        let mut parts = [Corners::EMPTY; PARTS];
        for reference in references {
            let corners = Corners(*reference);
            for axis in 0..3 {
                if planes.inverse[axis] == 0.0 {
                    continue;
                }
                let bins = &mut all.bins.corners[axis];
                let first = planes.bin(axis, corners.min(axis));
                let last = planes.bin(axis, corners.max(axis)).max(first);
                all.bins.counts[axis][first] += 1;
                all.ends[axis][last] += 1;
                if first == last {
                    bins[first].add(&corners);
                } else {
                    let triangle = &cuts.triangles[id(reference) as usize];
                    planes.slice(axis, triangle, &corners, first..last + 1, bins, &mut parts);
                }
            }
        }
        all
    }

    fn with(mut self, other: &Self) -> Self {
        self.bins = self.bins.with(&other.bins);
        for (a, b) in self.ends.iter_mut().flatten().zip(other.ends.iter().flatten()) {
            *a += b;
        }
        self
    }
}

/// The cheapest split of space, and its plane, if there is room for what is on both sides; the cheapest
/// split of objects is along an axis.
pub(crate) fn cheapest(
    references: &[Reference],
    bounds: &Corners,
    room: usize,
    of_objects: usize,
    cuts: &Cuts<'_>,
) -> Option<(Split, f32)> {
    let planes = Planes::new(bounds, references.len(), of_objects);
    let SpatialBins { bins, ends } = SpatialBins::new(references, planes, cuts);
    let split = bins.cheapest_of(&bins.counts, &ends)?;
    // What has no room for all its parts would not be the split that the cost is of.
    if split.left.count + split.right.count > room {
        return None;
    }
    let plane = planes.plane(split.axis, split.border);
    Some((split, plane))
}

/// Puts the parts on the left of the plane at the beginning of `to`, the others at its end; how many
/// there are on either side. What spans the plane stays whole where that is cheaper, or where there is
/// no room for two parts.
pub(crate) fn partition(
    references: &[Reference],
    to: &mut [Reference],
    (mut split, plane): (Split, f32),
    cuts: &Cuts<'_>,
) -> (usize, usize) {
    let axis = split.axis;
    let (mut on_left, mut on_right) = (0, 0);
    let mut spare = to.len() - references.len();
    for reference in references {
        let corners = Corners(*reference);
        let (mut left, mut right) = (Some(corners), Some(corners));
        if corners.max(axis) <= plane {
            right = None;
        } else if corners.min(axis) >= plane {
            left = None;
        } else {
            let (cut_left, cut_right) = cuts.cut(reference, axis, plane);
            if cut_left.is_empty() && !cut_right.is_empty() {
                left = None;
            } else if cut_right.is_empty() {
                right = None;
            } else {
                match cheapest_side(&split, &corners, spare) {
                    Some(true) => {
                        split.left.bounds.add(&corners);
                        split.right.count = split.right.count.saturating_sub(1);
                        right = None;
                    }
                    Some(false) => {
                        split.right.bounds.add(&corners);
                        split.left.count = split.left.count.saturating_sub(1);
                        left = None;
                    }
                    None => {
                        spare -= 1;
                        (left, right) = (Some(cut_left), Some(cut_right));
                    }
                }
            }
        }
        if let Some(left) = left {
            to[on_left] = left.reference(id(reference));
            on_left += 1;
        }
        if let Some(right) = right {
            on_right += 1;
            to[to.len() - on_right] = right.reference(id(reference));
        }
    }
    (on_left, on_right)
}

/// The side on which a reference stays whole, the left one being true; nothing where two parts are
/// cheaper.
fn cheapest_side(split: &Split, corners: &Corners, spare: usize) -> Option<bool> {
    let cost = |bounds: &Corners, count: usize| bounds.half_area() * count as f32;
    let Split { left, right, .. } = split;
    let (left_cost, right_cost) =
        (cost(&left.bounds, left.count), cost(&right.bounds, right.count));
    let less = |count: usize| count.saturating_sub(1);
    let whole_left =
        cost(&left.bounds.with(corners), left.count) + cost(&right.bounds, less(right.count));
    let whole_right =
        cost(&left.bounds, less(left.count)) + cost(&right.bounds.with(corners), right.count);
    if spare > 0 && left_cost + right_cost <= whole_left.min(whole_right) {
        return None;
    }
    Some(whole_left <= whole_right)
}

#[cfg(test)]
mod tests {
    use trisect_workloads::Stream;

    use super::*;

    /// Points of a triangle are in the box of the part that they are in, and boxes stay within what is
    /// cut, however often.
    #[test]
    fn parts_hold_all_points_of_a_triangle() {
        let mut stream = Stream::new("parts", 1);
        for _ in 0..2000 {
            let mut corner = || {
                #[allow(clippy::cast_possible_truncation, reason = "rounds")]
                let corner = stream.cube().map(|x| x as f32 + 10.0);
                corner
            };
            let triangle = Triangle { a: corner(), b: corner(), c: corner() };
            let cuts = Cuts { triangles: &[triangle], margin: 11.0 * 4.0 * f32::EPSILON };
            let mut parts = vec![Corners::of_triangle(&triangle)];
            let exact = triangle.corners().map(|corner| corner.map(f64::from).to_array());
            let between = |a: [f64; 3], b: [f64; 3], share: f64| -> [f64; 3] {
                std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
            };
            // Where planes cut the edges: at the corners of parts, to the last bit.
            let mut points = Vec::new();
            for axis in [0, 1, 2, 0] {
                let plane = corner().x;
                for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                    let (from, to): ([f64; 3], [f64; 3]) = (exact[from], exact[to]);
                    let share = (f64::from(plane) - from[axis]) / (to[axis] - from[axis]);
                    if (0.0..=1.0).contains(&share) {
                        points.push(between(from, to, share));
                    }
                }
                let mut cut = Vec::new();
                for part in parts {
                    if part.min(axis) < plane && plane < part.max(axis) {
                        let (left, right) = cuts.cut(&part.reference(0), axis, plane);
                        for side in [left, right] {
                            if !side.is_empty() {
                                assert!(!side.with(&part).is_empty());
                                assert_eq!(side.with(&part).0, part.0, "{side:?} {part:?}");
                                cut.push(side);
                            }
                        }
                    } else {
                        cut.push(part);
                    }
                }
                parts = cut;
            }
            for _ in 0..50 {
                let (mut beta, mut gamma) = (stream.unit_f64(), stream.unit_f64());
                if beta + gamma > 1.0 {
                    (beta, gamma) = (1.0 - beta, 1.0 - gamma);
                }
                let [a, b, c] = exact;
                points.push(between(a, between(b, c, gamma / (beta + gamma)), beta + gamma));
            }
            for point in points {
                let holds = |part: &Corners| {
                    (0..3).all(|axis| {
                        let (from, to) = (part.min(axis), part.max(axis));
                        f64::from(from) <= point[axis] && point[axis] <= f64::from(to)
                    })
                };
                assert!(parts.iter().any(holds), "{triangle:?} {point:?} {parts:?}");
            }
        }
    }
}
