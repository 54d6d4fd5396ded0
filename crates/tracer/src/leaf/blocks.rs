//! The triangles of a tree, prepared for a method.

use prefetch_index::prefetch_index;
use trisect_core::{Lanes, Triangle};
use trisect_method::{Method, Of, Record as _, rows};

use crate::bvh::builders::members::Members;
use crate::parallel::each;
use crate::precision::Real;
use crate::vectors::WIDTH;

/// Eight triangles of one kind, prepared, number by number.
#[repr(align(64))]
pub(crate) struct Block<M: Method, P: Real = f32> {
    pub(crate) prepared: Of<M::Prepared, [P; WIDTH]>,
    /// Their ids. The last one is repeated to fill the block.
    pub(crate) triangles: [u32; WIDTH],
}

impl<M: Method, P: Real> Clone for Block<M, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Method, P: Real> Copy for Block<M, P> {}

impl<M: Method, P: Real> Block<M, P> {
    /// As many of its triangles as there are lanes, from `lane` on, with `AXIS` renamed to the last.
    #[inline(always)]
    pub(crate) fn lanes<L: Lanes<Elem = P>, const AXIS: usize>(
        &self,
        token: L::Token,
        lane: usize,
    ) -> Of<M::Prepared, L> {
        let triangles = M::Prepared::map(
            &self.prepared,
            #[inline(always)]
            |row: &[P; WIDTH]| L::load(token, &row[lane..]),
        );
        M::Prepared::with_axis_last(&triangles, AXIS)
    }
}

/// All blocks of a tree.
#[allow(clippy::struct_field_names, reason = "they are what it is named for")]
pub(crate) struct Blocks<M: Method, P: Real = f32> {
    pub(crate) blocks: Vec<Block<M, P>>,
    /// The kind of each block's triangles; empty for a method that has one kind.
    kinds: Vec<u8>,
    /// Per block, in bits, the triangles that are in other places as well; empty where there are none.
    repeated: Vec<u8>,
}

/// The slot of a triangle: its place among all blocks.
#[allow(clippy::cast_possible_truncation, reason = "a tree has fewer blocks than 2²⁸")]
#[inline(always)]
pub(crate) fn slot(block: usize, lane: usize) -> u32 {
    (block * WIDTH + lane) as u32
}

impl<M: Method, P: Real> Blocks<M, P> {
    /// Prepares the triangles of each block.
    pub(crate) fn new(triangles: &[Triangle<P>], members: &[Members]) -> Self {
        let block = |members: &Members| Block {
            prepared: rows::<M::Prepared, P, WIDTH>(|lane| {
                let id = members.triangles[lane];
                // What fills a block must not be hit: an exact method settles each hit.
                let is_filler = lane > 0 && id == members.triangles[lane - 1];
                let triangle = triangles.get(id as usize).filter(|_| !is_filler);
                let triangle = triangle.map_or(Triangle::nothing(), Triangle::or_nothing);
                M::prepare(&triangle, usize::from(members.kind))
            }),
            triangles: members.triangles,
        };
        let blocks = each(members, block(&Members::NOTHING), block);
        let kinds = if M::GROUPS > 1 {
            members.iter().map(|members| members.kind).collect()
        } else {
            vec![]
        };
        Self { blocks, kinds, repeated: repeated(triangles.len(), members) }
    }

    /// The kind of a block's triangles.
    #[inline(always)]
    pub(crate) fn kind(&self, block: usize) -> usize {
        if const { M::GROUPS > 1 } { usize::from(self.kinds[block]) } else { 0 }
    }

    /// The triangles of a block, in bits, that are in other places as well, since space was split.
    #[inline(always)]
    pub(crate) fn repeated(&self, block: usize) -> u64 {
        self.repeated.get(block).copied().map_or(0, u64::from)
    }

    /// The triangle in a slot, as it was prepared.
    #[inline(always)]
    pub(crate) fn prepared(&self, slot: u32) -> Of<M::Prepared, P> {
        let lane = slot as usize % WIDTH;
        M::Prepared::map(
            &self.blocks[slot as usize / WIDTH].prepared,
            #[inline(always)]
            |row: &[P; WIDTH]| row[lane],
        )
    }

    /// The id of the triangle in a slot.
    #[inline(always)]
    pub(crate) fn triangle(&self, slot: u32) -> u32 {
        self.blocks[slot as usize / WIDTH].triangles[slot as usize % WIDTH]
    }

    /// Prefetches a block.
    #[inline(always)]
    pub(crate) fn prefetch(&self, block: usize) {
        let Some(block) = self.blocks.get(block) else { return };
        M::Prepared::map(
            &block.prepared,
            #[inline(always)]
            |row: &[P; WIDTH]| prefetch_index(row, 0),
        );
        prefetch_index(block.triangles.as_slice(), 0);
    }

    /// Bytes of all of it.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.blocks[..])
            + size_of_val(&self.kinds[..])
            + size_of_val(&self.repeated[..])
    }
}

/// Per block, in bits, those of so many triangles that are in other places as well; empty where there are none.
fn repeated(count: usize, members: &[Members]) -> Vec<u8> {
    let mut places = vec![0_u8; count];
    let mut is_any = false;
    for block in members {
        for (lane, &id) in block.triangles.iter().enumerate() {
            // A block without triangles has ids beyond all.
            let is_filler = lane > 0 && id == block.triangles[lane - 1];
            if let (Some(places), false) = (places.get_mut(id as usize), is_filler) {
                *places = places.saturating_add(1);
                is_any |= *places > 1;
            }
        }
    }
    if !is_any {
        return vec![];
    }
    let is_repeated = |&id: &u32| places.get(id as usize).is_some_and(|&places| places > 1);
    let bits = |block: &Members| {
        let lanes = block.triangles.iter().enumerate();
        lanes.fold(0, |bits, (lane, id)| bits | u8::from(is_repeated(id)) << lane)
    };
    members.iter().map(bits).collect()
}
