//! Triangles in blocks and rays in packets: structures of arrays of [`BLOCK`] that serve as
//! 1×16, 2×8, 4×4 or 16×1 lanes.

use core::ops::Range;

use crate::geometry::{Ray, Triangle, Vec3};
use crate::lanes::{Lanes, Scalar};
use crate::method::Method;
use crate::record::{Of, Record};

/// Triangles in a block and rays in a packet.
pub const BLOCK: usize = 16;

/// The number of a lane that holds no triangle.
pub const PADDING: u32 = u32::MAX;

/// Prepared data of [`BLOCK`] triangles, number by number.
#[repr(align(64))]
pub(crate) struct Block<R: Record, E: Copy>(R::Of<[E; BLOCK]>);

/// The triangles of a mesh, prepared for a method: sorted by the method's groups, in order of
/// index within each.
pub struct PreparedTriangles<M: Method, E: Scalar> {
    blocks: Vec<Block<M::Prepared, E>>,
    singles: Vec<Of<M::Prepared, E>>,
    numbers: Vec<u32>,
    groups: Vec<Range<usize>>,
}

impl<M: Method, E: Scalar> PreparedTriangles<M, E> {
    /// Prepares `triangles`; their numbers are their places in the slice.
    ///
    /// # Panics
    /// When there are more than `u32::MAX − 1` triangles.
    pub fn new(triangles: &[Triangle<E>]) -> Self {
        let zero = Vec3::new(E::from_f64(0.0), E::from_f64(0.0), E::from_f64(0.0));
        let degenerate = Triangle { a: zero, b: zero, c: zero };
        let mut order: Vec<Vec<u32>> = vec![Vec::new(); M::GROUPS];
        for (number, triangle) in (0..PADDING).zip(triangles) {
            order[M::group(triangle)].push(number);
        }
        assert!(
            order.iter().map(Vec::len).sum::<usize>() == triangles.len(),
            "more triangles than numbers"
        );
        let mut prepared = Self {
            blocks: Vec::new(),
            singles: Vec::new(),
            numbers: Vec::new(),
            groups: Vec::new(),
        };
        for (group, members) in order.iter().enumerate() {
            let start = prepared.blocks.len();
            for chunk in members.chunks(BLOCK) {
                let padding = M::prepare(&degenerate, group);
                let mut block = M::Prepared::map(&padding, |&x| [x; BLOCK]);
                for lane in 0..BLOCK {
                    let single = chunk
                        .get(lane)
                        .map_or(padding, |&i| M::prepare(&triangles[i as usize], group));
                    M::Prepared::zip(&mut block, &single, |row, &x| row[lane] = x);
                    prepared.singles.push(single);
                    prepared.numbers.push(chunk.get(lane).copied().unwrap_or(PADDING));
                }
                prepared.blocks.push(Block(block));
            }
            let start = start * BLOCK;
            prepared.groups.push(start..start + members.len());
        }
        prepared
    }

    /// The number of the triangle in a place, or [`PADDING`].
    #[inline(always)]
    pub fn number(&self, place: usize) -> u32 {
        self.numbers[place]
    }

    /// Bytes of prepared data per triangle.
    pub fn bytes_per_triangle() -> usize {
        M::Prepared::NUMBERS * size_of::<E>()
    }

    /// The places of each group; each starts at a whole block.
    #[inline(always)]
    pub(crate) fn groups(&self) -> &[Range<usize>] {
        &self.groups
    }

    /// The blocks that hold a group.
    #[inline(always)]
    pub(crate) fn blocks(&self, group: &Range<usize>) -> &[Block<M::Prepared, E>] {
        &self.blocks[group.start / BLOCK..group.end.div_ceil(BLOCK)]
    }

    /// The triangles of a group, one by one.
    #[inline(always)]
    pub(crate) fn singles(&self, group: &Range<usize>) -> &[Of<M::Prepared, E>] {
        &self.singles[group.clone()]
    }
}

impl<R: Record, E: Scalar> Block<R, E> {
    /// N triangles from lane `start` on, a multiple of N.
    #[inline(always)]
    pub(crate) fn lanes<L: Lanes<Elem = E>>(&self, token: L::Token, start: usize) -> R::Of<L> {
        // Says to the compiler that the lanes end within the block.
        let start = start & (BLOCK - L::N);
        R::map(
            &self.0,
            #[inline(always)]
            |row: &[E; BLOCK]| L::load(token, &row[start..]),
        )
    }
}

/// [`BLOCK`] rays, coordinate by coordinate.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Packet<E> {
    ray: Ray<[E; BLOCK]>,
}

impl<E: Scalar> Packet<E> {
    /// Packs `rays`; the last packet is filled up with rays that never hit (`tmin > tmax`).
    pub fn pack(rays: &[Ray<E>]) -> Vec<Self> {
        let number = |x| E::from_f64(x);
        let zero = Vec3::new(number(0.0), number(0.0), number(0.0));
        let miss = Ray { o: zero, d: zero, tmin: number(1.0), tmax: number(0.0) };
        rays.chunks(BLOCK)
            .map(|chunk| {
                let lane = |i: usize| chunk.get(i).copied().unwrap_or(miss);
                let row = |of: &dyn Fn(Ray<E>) -> E| core::array::from_fn(|i| of(lane(i)));
                Self {
                    ray: Ray {
                        o: Vec3::new(row(&|r| r.o.x), row(&|r| r.o.y), row(&|r| r.o.z)),
                        d: Vec3::new(row(&|r| r.d.x), row(&|r| r.d.y), row(&|r| r.d.z)),
                        tmin: row(&|r| r.tmin),
                        tmax: row(&|r| r.tmax),
                    },
                }
            })
            .collect()
    }

    #[inline(always)]
    pub(crate) fn lanes<L: Lanes<Elem = E>>(&self, token: L::Token, start: usize) -> Ray<L> {
        self.ray.map(
            #[inline(always)]
            |row| L::load(token, &row[start..]),
        )
    }
}
