//! The order in which rays make good packets: those that start, or look, near each other together. A tile
//! of a picture that is as high as wide is in fewer boxes than a row of as many pixels.

use trisect_core::{Lanes, Ray, Vec3};

use crate::rows::RAYS;

/// Rows and columns of a tile, which a packet is.
pub(crate) const TILE: usize = 8;

/// How rays go through the tree.
pub(crate) enum Order {
    /// In packets, in the order of these numbers; as they are where there are none.
    Packets(Vec<u32>),
    /// Each on its own, as they have little in common.
    Singly,
}

/// How long the rows are, where rays seem to come row by row from a picture, or from tiles of one:
/// neighbours are much nearer than the last of a row and the first of the next one.
pub(crate) fn row_length(rays: &[Ray<f32>]) -> Option<usize> {
    let longest = rays.len().min(LONGEST_ROW);
    let mut before = distance(rays.first()?, rays.get(1)?);
    let is_jump = |before: f32, step: f32| step > JUMP * before;
    for at in 1..longest - 1 {
        let step = distance(&rays[at], &rays[at + 1]);
        if is_jump(before, step) {
            let length = at + 1;
            let below = distance(&rays[0], &rays[length]);
            let next = (rays.get(2 * length - 2), rays.get(2 * length - 1), rays.get(2 * length));
            let again = match next {
                (Some(a), Some(b), Some(c)) => is_jump(distance(a, b), distance(b, c)),
                _ => false,
            };
            let is_row = length >= TILE && below < step && again;
            let is_alike = is_row && rays[..TILE].iter().all(|ray| are_alike(ray, &rays[length]));
            return is_alike.then_some(length);
        }
        before = step;
    }
    None
}

/// A row is not longer than this.
const LONGEST_ROW: usize = 1 << 14;

/// So many times as far as between neighbours.
const JUMP: f32 = 3.0;

/// Rays whose directions in a packet differ by more than this share of their length have little in
/// common.
const DIFFERENT: f32 = 0.25;

/// How different two rays are.
fn distance(a: &Ray<f32>, b: &Ray<f32>) -> f32 {
    let (o, d) = (a.o - b.o, a.d - b.d);
    sum_of_magnitudes(o) + sum_of_magnitudes(d)
}

fn sum_of_magnitudes(v: Vec3<f32>) -> f32 {
    v.x.abs() + v.y.abs() + v.z.abs()
}

/// Whether two rays look into nearly the same direction.
fn are_alike(a: &Ray<f32>, b: &Ray<f32>) -> bool {
    sum_of_magnitudes(a.d - b.d) <= DIFFERENT * sum_of_magnitudes(a.d)
}

/// The order of so many rays that come in rows of a length: tile by tile.
pub(crate) fn of_rows(rays: usize, length: usize) -> Order {
    if length == TILE {
        return Order::Packets(Vec::new());
    }
    let rays = u32::try_from(rays).expect("few rays at a time");
    let length = u32::try_from(length).expect("no row is longer than the rays");
    let tile = u32::try_from(TILE).expect("it is small");
    let mut numbers = Vec::with_capacity(rays as usize);
    for band in (0..rays).step_by((tile * length) as usize) {
        for column in (0..length).step_by(tile as usize) {
            let end = (column + tile).min(length);
            for row in 0..tile {
                let from = (band + row * length + column).min(rays);
                let to = (band + row * length + end).min(rays);
                numbers.extend(from..to);
            }
        }
    }
    Order::Packets(numbers)
}

/// One ray in so many is looked at to see how far rays are apart: odd, so that not all are in one column
/// of a picture.
const SAMPLE: usize = 31;

/// One run of rays in so many is looked at to see whether they are near each other already, and one ray
/// in so many of a run.
const RUNS: usize = 8;
const OF_RUN: usize = 7;

/// The sides of a tile together are twice its side; a run of rays whose sides are together so many times
/// that is left as it is.
const AS_GOOD: f32 = 3.0;

/// Tiles along either side, at most.
const TILES: u16 = 64;

/// The order of rays that are in none: by where they start.
pub(crate) fn of_origins(rays: &[Ray<f32>]) -> Order {
    let as_they_are = || Order::Packets(Vec::new());
    if rays.len() < 2 * RAYS {
        return as_they_are();
    }
    let sample = rays.iter().step_by(SAMPLE).map(|ray| ray.o);
    let plane = Plane::of(sample.clone());
    let extent = Extent::of(sample.map(|o| plane.point(o)));
    let [width, height] = extent.sides();
    let side = (width * height * RAYS as f32 / rays.len() as f32).sqrt();
    let (mut sides, mut differ, mut runs) = (0.0, 0.0, 0.0);
    for run in rays.chunks_exact(RAYS).step_by(RUNS) {
        let run = run.iter().step_by(OF_RUN);
        let extent = Extent::of(run.clone().map(|ray| plane.point(ray.o)));
        let [width, height] = extent.sides();
        sides += width + height;
        let first = run.clone().next().map_or(Vec3::new(0.0, 0.0, 0.0), |ray| ray.d);
        let far = run.map(|ray| sum_of_magnitudes(ray.d - first)).fold(0.0, f32::max);
        differ += far / sum_of_magnitudes(first);
        runs += 1.0;
    }
    let is_alike = differ <= DIFFERENT * runs;
    if !is_alike {
        return Order::Singly;
    }
    if !(side > 0.0 && side.is_finite()) || sides <= AS_GOOD * side * runs {
        return as_they_are();
    }
    let tiles = |length: f32| (length / side).round().clamp(1.0, f32::from(TILES));
    let (columns, rows) = (tiles(width), tiles(height));
    let (to_column, to_row) = (columns / width, rows / height);
    let mut counts = [0_u32; TILES as usize * TILES as usize];
    let mut tile_of = Vec::with_capacity(rays.len());
    for ray in rays {
        let [u, v] = plane.point(ray.o);
        let column = whole((u - extent.min[0]) * to_column, columns);
        let row = whole((v - extent.min[1]) * to_row, rows);
        // To and fro, as some packets reach into the next row of tiles.
        let column = if row.is_multiple_of(2) { column } else { usize::from(TILES) - 1 - column };
        let tile = row * usize::from(TILES) + column;
        counts[tile] += 1;
        tile_of.push(tile);
    }
    let mut sum = 0;
    for count in &mut counts {
        sum += *count;
        *count = sum - *count;
    }
    let mut numbers = vec![0; rays.len()];
    for (number, tile) in (0..).zip(tile_of) {
        numbers[counts[tile] as usize] = number;
        counts[tile] += 1;
    }
    Order::Packets(numbers)
}

/// The whole number below a number, at least zero and below `end`, which is at most [`TILES`].
#[inline(always)]
fn whole(x: f32, end: f32) -> usize {
    // Half is taken off as adding rounds to the nearest.
    let x = Lanes::max(0.0, Lanes::min(x - 0.5, end - 1.0));
    // The last bits of a number of this size are the whole number.
    (x + 8_388_608.0).to_bits() as usize % usize::from(TILES)
}

/// A plane on which points are seen far apart: one axis is that along which they differ the most, the
/// other that along which they differ the most but for what the first explains.
#[derive(Clone, Copy)]
struct Plane {
    first: Vec3<f32>,
    second: Vec3<f32>,
}

impl Plane {
    fn of(points: impl Iterator<Item = Vec3<f32>> + Clone) -> Self {
        let (mut count, mut mean) = (0.0, Vec3::new(0.0, 0.0, 0.0));
        for point in points.clone() {
            count += 1.0;
            mean = mean + point;
        }
        let mean = mean.scale(1.0 / count);
        // Sums of products of two coordinates.
        let mut products = [[0.0; 3]; 3];
        for point in points {
            let x = (point - mean).to_array();
            for (row, a) in products.iter_mut().zip(x) {
                row.iter_mut().zip(x).for_each(|(sum, b)| *sum += a * b);
            }
        }
        let largest = |of: [f32; 3]| (0..3).max_by(|&a, &b| of[a].total_cmp(&of[b])).unwrap_or(0);
        let first = largest([0, 1, 2].map(|axis| products[axis][axis]));
        let slopes = products[first].map(|product| product / products[first][first]);
        let rest =
            [0, 1, 2].map(|axis| products[axis][axis] - slopes[axis] * products[first][axis]);
        let second = largest(rest);
        let unit = |axis: usize| {
            let [x, y, z] = [0, 1, 2].map(|at| f32::from(u8::from(at == axis)));
            Vec3::new(x, y, z)
        };
        Self { first: unit(first), second: unit(second) - unit(first).scale(slopes[second]) }
    }

    #[inline(always)]
    fn point(self, v: Vec3<f32>) -> [f32; 2] {
        [self.first.dot(v), self.second.dot(v)]
    }
}

/// How far points of a plane reach.
#[derive(Clone, Copy)]
struct Extent {
    min: [f32; 2],
    max: [f32; 2],
}

impl Extent {
    fn of(points: impl Iterator<Item = [f32; 2]>) -> Self {
        let mut extent = Self { min: [f32::INFINITY; 2], max: [f32::NEG_INFINITY; 2] };
        for point in points {
            for (axis, x) in point.into_iter().enumerate() {
                extent.min[axis] = Lanes::min(extent.min[axis], x);
                extent.max[axis] = Lanes::max(extent.max[axis], x);
            }
        }
        extent
    }

    fn sides(&self) -> [f32; 2] {
        [self.max[0] - self.min[0], self.max[1] - self.min[1]]
    }
}

#[cfg(test)]
mod tests {
    use trisect_workloads::{RayClass, hall, primary};

    use super::*;

    fn picture(columns: usize, rows: usize) -> Vec<Ray<f32>> {
        primary(&hall(), columns, rows).rays
    }

    /// The numbers, which are all of so many.
    fn numbers(order: Order, count: usize) -> Vec<u32> {
        let Order::Packets(numbers) = order else { panic!("they go together") };
        let mut sorted = numbers.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..u32::try_from(count).expect("few")));
        numbers
    }

    #[test]
    fn rows_of_a_picture_become_tiles() {
        for (columns, rows) in [(64, 64), (100, 40), (129, 70)] {
            let rays = picture(columns, rows);
            assert_eq!(row_length(&rays), Some(columns), "{columns} × {rows}");
            let numbers = numbers(of_rows(rays.len(), columns), rays.len());
            let tile = (0..8).flat_map(|row| (0..8).map(move |column| row * columns + column));
            assert!(tile.eq(numbers[..64].iter().map(|&number| number as usize)));
        }
    }

    #[test]
    fn what_is_in_tiles_stays_so() {
        let rays = RayClass::Primary.rays(1, &hall(), 64, &mut |_| None);
        assert_eq!(row_length(&rays), None, "rows of four are no tiles of eight");
        let Order::Packets(numbers) = of_origins(&rays) else { panic!("they go together") };
        assert!(numbers.is_empty());
    }

    #[test]
    fn rays_with_little_in_common_go_singly() {
        let rays = trisect_workloads::random_through_box(1, &hall(), 4096).rays;
        assert!(matches!(of_origins(&rays), Order::Singly));
        // Wherever they are taken from, no row is seen in them.
        assert!((0..2000).all(|from| row_length(&rays[from..]).is_none()));
    }

    #[test]
    fn rays_are_put_in_tiles_of_where_they_start() {
        // All look down, from a square, in no order.
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from(u16::try_from(state >> 16).expect("sixteen bits")) / 65_536.0
        };
        let rays: Vec<_> = (0..4096)
            .map(|_| Ray::<f32>::new([random(), 1.0, random()], [0.0, -1.0, 0.0]))
            .collect();
        assert_eq!(row_length(&rays), None);
        let numbers = numbers(of_origins(&rays), rays.len());
        for packet in numbers.chunks(RAYS) {
            let extent = Extent::of(packet.iter().map(|&number| {
                let o = rays[number as usize].o;
                [o.x, o.z]
            }));
            // An eighth, and what is counted to the next tile.
            let [width, height] = extent.sides();
            assert!(width * height < 0.1, "{width} × {height}");
        }
    }
}
