//! What is in the blocks of a tree.

use trisect_core::{Scalar, Triangle};
use trisect_method::{Method, UnsuitableMesh};

use super::settings::Leaves;
use crate::parallel::each;
use crate::vectors::WIDTH;

/// The ids of the triangles of a block, all of one kind; the last one is repeated to fill the block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Members {
    pub(crate) triangles: [u32; WIDTH],
    pub(crate) kind: u8,
}

impl Members {
    /// No triangles.
    pub(crate) const NOTHING: Self = Self { triangles: [u32::MAX; WIDTH], kind: 0 };
}

/// Triangles of a leaf, at most.
pub(crate) const LEAF: usize = Leaves::ThirtyTwo.blocks() * WIDTH;

/// Places in the blocks of a leaf, at most: of the three kinds that there may be, two may leave their last block
/// in part empty.
pub(crate) const PLACES: usize = LEAF + 2 * WIDTH;

/// The kinds of a method's triangles.
pub(crate) enum Kinds {
    /// All are of one kind.
    All(u8),
    /// The kind of each.
    Of(Vec<u8>),
}

impl Kinds {
    /// Those that a method tells apart.
    ///
    /// # Errors
    /// When the method cannot take the mesh.
    pub(crate) fn new<M: Method, P: Scalar>(
        triangles: &[Triangle<P>],
    ) -> Result<Self, UnsuitableMesh> {
        let small = |kind: usize| u8::try_from(kind).expect("kinds are few");
        Ok(match M::mesh_group(triangles)? {
            Some(kind) => Self::All(small(kind)),
            None if const { M::GROUPS == 1 } => Self::All(0),
            None => Self::Of(each(triangles, 0, |triangle| small(M::group(triangle)))),
        })
    }

    /// That of a triangle.
    #[inline]
    pub(crate) fn of(&self, triangle: u32) -> u8 {
        match self {
            Self::All(kind) => *kind,
            Self::Of(kinds) => kinds[triangle as usize],
        }
    }
}

/// Puts triangles, given with their kinds, into blocks, one kind after the other and no triangle twice; how many
/// triangles there are.
pub(crate) fn blocks(members: &mut [(u8, u32)], blocks: &mut Vec<Members>) -> usize {
    members.sort_unstable();
    let mut count = 0;
    for at in 0..members.len() {
        if count == 0 || members[at] != members[count - 1] {
            members[count] = members[at];
            count += 1;
        }
    }
    for of_kind in members[..count].chunk_by(|a, b| a.0 == b.0) {
        for chunk in of_kind.chunks(WIDTH) {
            let mut triangles = [chunk[chunk.len() - 1].1; WIDTH];
            for (to, from) in triangles.iter_mut().zip(chunk) {
                *to = from.1;
            }
            blocks.push(Members { triangles, kind: chunk[0].0 });
        }
    }
    count
}
