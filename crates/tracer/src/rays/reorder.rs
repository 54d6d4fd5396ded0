//! The order in which rays make good packets: rays whose origins and directions are near each other belong
//! together. A square tile of a picture meets fewer boxes than a row of as many pixels.

use trisect_core::{Lanes, Ray, Vec3};

use super::batch::RAYS;
use crate::precision::Real;

/// Rows and columns of a tile, which a packet is.
pub(crate) const TILE: usize = 8;

/// How rays go through the tree.
pub(crate) enum Order {
    /// In packets, in the order given.
    Packets,
    /// In packets, in the order of these indices.
    Reordered(Vec<u32>),
    /// Each on its own, since they have little in common.
    Singly,
}

/// The length of a row, where rays seem to come row by row from a picture, or from tiles of one: neighbours are
/// much nearer to each other than the last of a row is to the first of the next.
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

/// A row has at most so many rays.
const LONGEST_ROW: usize = 1 << 14;

/// A jump is so many times the distance between neighbours.
const JUMP: f32 = 3.0;

/// Rays have little in common whose directions differ by more than this share of their length.
const DIFFERENT: f32 = 0.25;

/// How different two rays are.
fn distance(a: &Ray<f32>, b: &Ray<f32>) -> f32 {
    let (o, d) = (a.o - b.o, a.d - b.d);
    sum_of_magnitudes(o) + sum_of_magnitudes(d)
}

fn sum_of_magnitudes(v: Vec3<f32>) -> f32 {
    v.x.abs() + v.y.abs() + v.z.abs()
}

/// Whether two rays have nearly the same direction.
fn are_alike(a: &Ray<f32>, b: &Ray<f32>) -> bool {
    sum_of_magnitudes(a.d - b.d) <= DIFFERENT * sum_of_magnitudes(a.d)
}

/// The order of so many rays that come in rows of that length: tile by tile.
pub(crate) fn of_rows(rays: usize, length: usize) -> Order {
    if length == TILE {
        return Order::Packets;
    }
    let rays = u32::try_from(rays).expect("few rays at a time");
    let length = u32::try_from(length).expect("no row is longer than the rays");
    let tile = u32::try_from(TILE).expect("it is small");
    let mut indices = Vec::with_capacity(rays as usize);
    for band in (0..rays).step_by((tile * length) as usize) {
        for column in (0..length).step_by(tile as usize) {
            let end = (column + tile).min(length);
            for row in 0..tile {
                let from = (band + row * length + column).min(rays);
                let to = (band + row * length + end).min(rays);
                indices.extend(from..to);
            }
        }
    }
    Order::Reordered(indices)
}

/// One ray in so many is a sample of how far rays are apart; an odd number, so that samples are not all in one
/// column of a picture.
const SAMPLE: usize = 31;

/// One run of rays in so many is a sample of whether neighbours are near each other already, and of a run one ray
/// in so many.
const RUNS: usize = 8;
const OF_RUN: usize = 7;

/// Width and height of a square tile add up to twice its side. Runs of rays are left as they are whose width and
/// height add up to at most so many times the side.
const AS_GOOD: f32 = 3.0;

/// Tiles along either side, at most.
const TILES: u16 = 64;

/// The order of rays that come in none: by their origins.
pub(crate) fn of_origins(rays: &[Ray<f32>]) -> Order {
    if rays.len() < 2 * RAYS {
        return Order::Packets;
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
        return Order::Packets;
    }
    let tiles = |length: f32| (length / side).round().clamp(1.0, f32::from(TILES));
    let counts = extent.sides().map(tiles);
    Order::Reordered(in_tiles(rays.iter().map(|ray| plane.point(ray.o)), &extent, counts))
}

/// The order of points by what is above them, along the last axis: those that are near each other meet the same boxes.
pub(crate) fn of_columns<P: Real>(points: &[Vec3<P>]) -> Vec<u32> {
    let first = points.first().map_or([P::ZERO; 2], |point| [point.x, point.y]);
    #[allow(clippy::cast_possible_truncation, reason = "rounds")]
    let across = |point: &Vec3<P>| {
        [(point.x - first[0]).to_f64() as f32, (point.y - first[1]).to_f64() as f32]
    };
    let points = points.iter().map(across);
    in_tiles(points.clone(), &Extent::of(points), [f32::from(TILES); 2])
}

/// The order of points, tile by tile of so many columns and rows.
fn in_tiles(
    points: impl ExactSizeIterator<Item = [f32; 2]>,
    extent: &Extent,
    [columns, rows]: [f32; 2],
) -> Vec<u32> {
    let [width, height] = extent.sides();
    let (to_column, to_row) = (columns / width, rows / height);
    let mut counts = [0_u32; TILES as usize * TILES as usize];
    let mut tile_of = Vec::with_capacity(points.len());
    for [u, v] in points {
        let column = whole((u - extent.min[0]) * to_column, columns);
        let row = whole((v - extent.min[1]) * to_row, rows);
        // To and fro, since some packets reach into the next row of tiles.
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
    let mut indices = vec![0; tile_of.len()];
    for (index, tile) in (0..).zip(tile_of) {
        indices[counts[tile] as usize] = index;
        counts[tile] += 1;
    }
    indices
}

/// A number rounded down, brought to at least zero and less than `end`, which is at most [`TILES`].
#[inline(always)]
fn whole(x: f32, end: f32) -> usize {
    // Adding rounds to the nearest, so half is subtracted first.
    let x = Lanes::max(0.0, Lanes::min(x - 0.5, end - 1.0));
    // The last bits of a number of this size are its whole part.
    (x + 8_388_608.0).to_bits() as usize % usize::from(TILES)
}

/// A plane onto which points project far apart: one axis is the one along which they vary the most, the other the
/// one along which they vary the most once what the first explains is subtracted.
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

/// The extent of points of a plane.
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

    /// The indices, which must be all of so many.
    fn indices(order: Order, count: usize) -> Vec<u32> {
        let Order::Reordered(indices) = order else { panic!("they go together") };
        let mut sorted = indices.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..u32::try_from(count).expect("few")));
        indices
    }

    #[test]
    fn rows_of_a_picture_become_tiles() {
        for (columns, rows) in [(64, 64), (100, 40), (129, 70)] {
            let rays = picture(columns, rows);
            assert_eq!(row_length(&rays), Some(columns), "{columns} × {rows}");
            let indices = indices(of_rows(rays.len(), columns), rays.len());
            let tile = (0..8).flat_map(|row| (0..8).map(move |column| row * columns + column));
            assert!(tile.eq(indices[..64].iter().map(|&index| index as usize)));
        }
    }

    #[test]
    fn what_is_in_tiles_stays_so() {
        let rays = RayClass::Primary.rays(1, &hall(), 64, &mut |_| None);
        assert_eq!(row_length(&rays), None, "rows of four are no tiles of eight");
        assert!(matches!(of_origins(&rays), Order::Packets));
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
        let indices = indices(of_origins(&rays), rays.len());
        for packet in indices.chunks(RAYS) {
            let extent = Extent::of(packet.iter().map(|&index| {
                let o = rays[index as usize].o;
                [o.x, o.z]
            }));
            // An eighth, and what is counted to the next tile.
            let [width, height] = extent.sides();
            assert!(width * height < 0.1, "{width} × {height}");
        }
    }
}
