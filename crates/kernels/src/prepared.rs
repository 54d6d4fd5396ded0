//! Triangles in blocks and rays in packets: structures of arrays of [`BLOCK`] that serve as
//! 1×16, 2×8, 4×4 or 16×1 lanes.

use core::ops::Range;

use trisect_core::{Lanes, Scalar};
use trisect_core::{Ray, Triangle, Vec3};
use trisect_method::{Method, UnsuitableMesh};
use trisect_method::{Of, Record, Value, rows};

/// Triangles in a block and rays in a packet.
pub const BLOCK: usize = 16;

/// The number of a lane that holds no triangle.
pub const PADDING: u32 = u32::MAX;

/// Prepared data of [`BLOCK`] triangles, number by number.
#[repr(align(64))]
pub(crate) struct Block<R: Record, E: Value>(R::Of<[E; BLOCK]>);

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
    /// # Errors
    /// When the method cannot take the mesh.
    ///
    /// # Panics
    /// When there are more than `u32::MAX − 1` triangles.
    pub fn new(triangles: &[Triangle<E>]) -> Result<Self, UnsuitableMesh> {
        let fixed = M::mesh_group(triangles)?;
        let mut order: Vec<Vec<u32>> = vec![Vec::new(); M::GROUPS];
        for (number, triangle) in (0..PADDING).zip(triangles) {
            order[fixed.unwrap_or_else(|| M::group(triangle))].push(number);
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
                let padding = M::prepare(&Triangle::nothing(), group);
                let first = prepared.singles.len();
                for lane in 0..BLOCK {
                    prepared.singles.push(chunk.get(lane).map_or(padding, |&i| {
                        M::prepare(&triangles[i as usize].or_nothing(), group)
                    }));
                    prepared.numbers.push(chunk.get(lane).copied().unwrap_or(PADDING));
                }
                let singles = &prepared.singles[first..];
                prepared.blocks.push(Block(rows::<M::Prepared, E, BLOCK>(|lane| singles[lane])));
            }
            let start = start * BLOCK;
            prepared.groups.push(start..start + members.len());
        }
        Ok(prepared)
    }

    /// The number of the triangle in a place, or [`PADDING`].
    #[inline(always)]
    pub fn number(&self, place: usize) -> u32 {
        self.numbers[place]
    }

    /// The numbers of the triangles from a place on.
    #[inline(always)]
    pub fn numbers(&self, place: usize) -> &[u32] {
        &self.numbers[place..]
    }

    /// The triangle in a place, as it was prepared.
    #[inline(always)]
    pub fn prepared(&self, place: usize) -> &Of<M::Prepared, E> {
        &self.singles[place]
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
pub(crate) struct Packet<E> {
    ray: Ray<[E; BLOCK]>,
}

impl<E: Scalar> Packet<E> {
    /// Up to [`BLOCK`] rays, filled up with rays that never hit (`tmin > tmax`) but have origin and
    /// direction of the first.
    fn new(rays: &[Ray<E>]) -> Self {
        let miss = Ray { tmin: E::from_f64(1.0), tmax: E::from_f64(0.0), ..rays[0] };
        let lane = |i: usize| rays.get(i).copied().unwrap_or(miss);
        let row = |of: &dyn Fn(Ray<E>) -> E| core::array::from_fn(|i| of(lane(i)));
        Self {
            ray: Ray {
                o: Vec3::new(row(&|r| r.o.x), row(&|r| r.o.y), row(&|r| r.o.z)),
                d: Vec3::new(row(&|r| r.d.x), row(&|r| r.d.y), row(&|r| r.d.z)),
                tmin: row(&|r| r.tmin),
                tmax: row(&|r| r.tmax),
            },
        }
    }

    #[inline(always)]
    pub(crate) fn lanes<L: Lanes<Elem = E>>(&self, token: L::Token, start: usize) -> Ray<L> {
        // Says to the compiler that the lanes end within the packet.
        let start = start & (BLOCK - L::N);
        self.ray.map(
            #[inline(always)]
            |row: &[E; BLOCK]| L::load(token, &row[start..]),
        )
    }
}

/// What all rays of a packet have in common, to the bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Common {
    /// The origin.
    pub origin: bool,
    /// The direction.
    pub direction: bool,
}

impl Common {
    /// What all of `rays` have in common.
    pub fn of<E: Scalar>(rays: &[Ray<E>]) -> Self {
        let Some(first) = rays.first() else { return Self::default() };
        Self {
            origin: rays.iter().all(|ray| ray.o == first.o),
            direction: rays.iter().all(|ray| ray.d == first.d),
        }
    }
}

/// Rays in packets of [`BLOCK`], in order, or, for a method that turns space, in order within each
/// longest axis of their directions.
pub struct Packets<E> {
    rows: Vec<Packet<E>>,
    numbers: Vec<u32>,
    /// The packets whose rays have each longest axis; all under the last for other methods.
    axes: [Range<usize>; 3],
    common: Common,
}

impl<E: Scalar> Packets<E> {
    /// Packs `rays`, as method `M` takes them; their numbers are their places in the slice.
    ///
    /// # Panics
    /// When there are more than `u32::MAX − 1` rays.
    pub fn new<M: Method>(rays: &[Ray<E>]) -> Self {
        let mut order: [Vec<u32>; 3] = Default::default();
        for (number, ray) in (0..PADDING).zip(rays) {
            order[turning_axis::<M, E>(ray)].push(number);
        }
        assert!(order.iter().map(Vec::len).sum::<usize>() == rays.len(), "more rays than numbers");
        let mut packed = Self {
            rows: Vec::new(),
            numbers: Vec::new(),
            axes: [0..0, 0..0, 0..0],
            common: Common::of(rays),
        };
        for (axis, members) in order.iter().enumerate() {
            let start = packed.rows.len();
            for chunk in members.chunks(BLOCK) {
                let members: Vec<_> = chunk.iter().map(|&i| rays[i as usize]).collect();
                packed.rows.push(Packet::new(&members));
                packed.numbers.extend(chunk);
                packed.numbers.resize(packed.rows.len() * BLOCK, PADDING);
            }
            packed.axes[axis] = start..packed.rows.len();
        }
        packed
    }

    /// The number of the ray in a place, or [`PADDING`].
    #[inline(always)]
    pub fn number(&self, place: usize) -> u32 {
        self.numbers[place]
    }

    /// What all rays have in common.
    pub fn common(&self) -> Common {
        self.common
    }

    /// The packets whose rays share a longest axis.
    #[inline(always)]
    pub(crate) fn along(&self, axis: usize) -> (usize, &[Packet<E>]) {
        let range = self.axes[axis].clone();
        (range.start, &self.rows[range])
    }
}

/// The axis that method `M` renames to the last for `ray`; the last as it is for a method that does
/// not turn space.
#[inline(always)]
pub(crate) fn turning_axis<M: Method, E: Scalar>(ray: &Ray<E>) -> usize {
    if M::TURNS { ray.d.largest_axis() } else { 2 }
}
