//! From triangles to a wide tree.

mod binary;
mod bins;
mod collapse;
mod corners;
mod descent;
mod emit;
mod linear;
mod refit;
mod spatial;
mod sweep;

use std::fmt;
use std::str::FromStr;

use rayon::prelude::*;
use trisect_core::{Method, Triangle, UnsuitableMesh, rows};

use self::corners::{Corners, Reference, number};
use self::emit::{Kinds, Layout, Members};
pub use self::refit::RefitError;
use self::refit::fit_boxes;
use self::spatial::Cuts;
use crate::bounds::Bounds;
use crate::bvh::{Block, Bvh, Origin, WIDTH};
use crate::parallel::each;

/// From so many references on, work is shared between threads: fewer are done before another thread
/// would have begun.
const PARALLEL: usize = 4096;

/// Below so many triangles space is not split: nothing is gained in a tree of few nodes.
const SCENE: usize = 256;

/// How a tree is built: the more time it takes, the faster it is traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Builder {
    /// Triangles in the order of a space-filling curve, split where the curve turns. The quickest to
    /// build: for scenes that move, or that few rays are traced through.
    Linear,
    /// The surface area heuristic, over bins: no triangle is in two leaves.
    Binned,
    /// The same, and large triangles are divided between leaves where that makes boxes smaller, up to
    /// half as many references again. The fastest to trace, most of all indoors.
    #[default]
    Spatial,
}

impl Builder {
    /// The builders, the quickest first.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Binned, Self::Spatial];

    /// The name that it is asked for by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Binned => "binned",
            Self::Spatial => "spatial",
        }
    }
}

impl fmt::Display for Builder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// When triangles that are together in the tree become a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leaves {
    /// Where that is cheaper than a node over them, up to sixteen: the fastest to trace. Eight always do,
    /// as they are tested at once.
    #[default]
    Cheapest,
    /// Sixteen always do: a smaller tree, in which more triangles are tested.
    Sixteen,
    /// Thirty-two always do.
    ThirtyTwo,
}

impl Leaves {
    /// All, those with the fewest triangles first.
    pub const ALL: [Self; 3] = [Self::Cheapest, Self::Sixteen, Self::ThirtyTwo];

    /// The name that records use.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cheapest => "cheapest",
            Self::Sixteen => "16",
            Self::ThirtyTwo => "32",
        }
    }

    /// Blocks of eight triangles of one kind, at most; triangles of several kinds may take two more.
    pub(crate) const fn blocks(self) -> usize {
        match self {
            Self::Cheapest | Self::Sixteen => 2,
            Self::ThirtyTwo => 4,
        }
    }

    /// Whether so many blocks become a leaf, given whether a node over them is cheaper.
    pub(crate) const fn take(self, blocks: usize, node_is_cheaper: bool) -> bool {
        blocks <= self.blocks() && !(matches!(self, Self::Cheapest) && node_is_cheaper)
    }
}

/// No builder has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no builder is called {0:?}: they are linear, binned and spatial")]
pub struct UnknownBuilder(pub String);

impl FromStr for Builder {
    type Err = UnknownBuilder;

    fn from_str(name: &str) -> Result<Self, UnknownBuilder> {
        let found = Self::ALL.into_iter().find(|builder| builder.name() == name);
        found.ok_or_else(|| UnknownBuilder(name.to_owned()))
    }
}

impl<M: Method> Bvh<M> {
    /// Prepares `triangles`, whose numbers are their places, and puts them in a tree. Triangles that
    /// are not finite or have no area are left out: nothing hits them.
    ///
    /// Shares the work between the threads of the pool that it is called in; the tree depends on the
    /// triangles and the builder alone, not on the number of threads.
    ///
    /// # Errors
    /// When the method cannot take the mesh.
    ///
    /// # Panics
    /// When there are more than `u32::MAX − 1` triangles, or more than 2²⁸ blocks.
    pub fn build(triangles: &[Triangle<f32>], builder: Builder) -> Result<Self, UnsuitableMesh> {
        Self::build_with(triangles, builder, Leaves::default())
    }

    /// The same with leaves of a size of choice.
    ///
    /// # Errors
    /// As [`Bvh::build`].
    ///
    /// # Panics
    /// As [`Bvh::build`].
    pub fn build_with(
        triangles: &[Triangle<f32>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Self, UnsuitableMesh> {
        let kinds = KindsOf::new::<M>(triangles)?;
        let Outline { layout, bounds, unit, left_out } =
            outline(triangles, builder, leaves, kinds.kinds());
        let Layout { nodes, blocks: members, depth, references } = layout;
        let (blocks, groups) = blocks::<M>(triangles, &members);
        let origin = Origin { builder, triangles: triangles.len(), left_out, references };
        let mut bvh = Self { nodes, blocks, groups, depth, bounds, origin };
        if unit != 1.0 {
            // Boxes were rounded when they were scaled.
            bvh.bounds = fit_boxes(&mut bvh.nodes, triangles, &members);
        }
        bvh.widen_boxes();
        Ok(bvh)
    }

    /// Moves the sides of all boxes outwards by eight units of roundoff of the tree's largest coordinate, for
    /// a method whose tests of boxes do not allow for their own rounding. They compute `v·r − o·r` for a side
    /// at `v`, and `r` is as large as 10¹⁸ along an axis that the ray runs across: there the rounding of
    /// `o·r` alone would decide about a ray that lies in the side. A point of the side is off by
    /// `u·|o| + 2u·|v − o|` at most, so no box loses a ray whose origin has no larger coordinates than the tree.
    fn widen_boxes(&mut self) {
        if const { M::INFO.claims.watertight } {
            return;
        }
        let margin = self.bounds.largest() * (4.0 * f32::EPSILON);
        // Not where there are no triangles.
        if margin.is_finite() {
            self.nodes.iter_mut().for_each(|node| node.widen(margin));
        }
    }
}

/// The kinds of a method's triangles.
enum KindsOf {
    All(u8),
    Of(Vec<u8>),
}

impl KindsOf {
    fn new<M: Method>(triangles: &[Triangle<f32>]) -> Result<Self, UnsuitableMesh> {
        let small = |group: usize| u8::try_from(group).expect("kinds are few");
        Ok(match M::mesh_group(triangles)? {
            Some(group) => Self::All(small(group)),
            None if const { M::GROUPS == 1 } => Self::All(0),
            None => Self::Of(each(triangles, 0, |triangle| small(M::group(triangle)))),
        })
    }

    fn kinds(&self) -> Kinds<'_> {
        match self {
            Self::All(kind) => Kinds::All(*kind),
            Self::Of(kinds) => Kinds::Of(kinds),
        }
    }
}

/// What is made of both sides of a split of so many references; by two threads where they are many.
fn both<X: Send>(
    count: usize,
    left: impl FnOnce() -> X + Send,
    right: impl FnOnce() -> X + Send,
) -> (X, X) {
    if count >= PARALLEL { rayon::join(left, right) } else { (left(), right()) }
}

/// The blocks of a tree, and their kinds where the method tells kinds apart.
fn blocks<M: Method>(triangles: &[Triangle<f32>], members: &[Members]) -> (Vec<Block<M>>, Vec<u8>) {
    let block = |members: &Members| Block {
        prepared: rows::<M::Prepared, f32, WIDTH>(|lane| {
            let number = members.triangles[lane];
            let triangle = triangles.get(number as usize);
            // Lanes that fill up a block are not to hit where each hit has a price.
            let is_filler = lane > 0 && number == members.triangles[lane - 1];
            let hides = const { M::INFO.claims.exact } && is_filler;
            let triangle = triangle.filter(|_| !hides);
            let triangle = triangle.map_or(Triangle::nothing(), Triangle::or_nothing);
            M::prepare(&triangle, usize::from(members.group))
        }),
        triangles: members.triangles,
    };
    let blocks = each(members, block(&Members::NOTHING), block);
    let groups =
        if M::GROUPS > 1 { members.iter().map(|members| members.group).collect() } else { vec![] };
    (blocks, groups)
}

/// A tree without the method's data.
struct Outline {
    layout: Layout,
    bounds: Bounds,
    /// What coordinates were multiplied by.
    unit: f32,
    /// Triangles that nothing hits.
    left_out: Vec<u32>,
}

fn outline(
    triangles: &[Triangle<f32>],
    builder: Builder,
    leaves: Leaves,
    kinds: Kinds<'_>,
) -> Outline {
    assert!(triangles.len() < u32::MAX as usize, "more triangles than numbers");
    let splits = builder == Builder::Spatial && triangles.len() >= SCENE;
    // Room for parts of triangles: half as many as there are triangles.
    let room = |count: usize| if splits { count + count / 2 } else { count };
    let mut references = vec![[0.0; 8]; room(triangles.len())];
    let bounds = refer(triangles, &mut references);
    let left_out = take_out(triangles.len(), &mut references);
    let count = triangles.len() - left_out.len();
    references.truncate(room(count));
    let largest = bounds.largest();
    let unit = unit(largest);
    if unit != 1.0 {
        for reference in &mut references[..count] {
            *reference = Corners(*reference).scaled(unit).reference(number(reference));
        }
    }
    // Eight units of roundoff on either side.
    let cuts = Cuts { triangles, margin: largest * (4.0 * f32::EPSILON) };
    let tree = match builder {
        Builder::Linear => linear::build(&references, leaves),
        Builder::Binned => descent::build(&mut references, count, None, leaves),
        Builder::Spatial => {
            let cuts = (splits && unit == 1.0).then_some(&cuts);
            descent::build(&mut references, count, cuts, leaves)
        }
    };
    let layout = emit::emit(&tree, kinds);
    Outline { layout, bounds: bounds.bounds(), unit, left_out }
}

/// Writes down the boxes of all triangles, those of triangles that nothing hits being empty, and gives
/// the box of all.
fn refer(triangles: &[Triangle<f32>], references: &mut [Reference]) -> Corners {
    let of_chunk = |first: usize, triangles: &[Triangle<f32>], references: &mut [Reference]| {
        let mut bounds = Corners::EMPTY;
        for ((place, triangle), reference) in (first..).zip(triangles).zip(references) {
            let mut corners = Corners::EMPTY;
            if triangle.can_be_hit() {
                corners = Corners::of_triangle(triangle);
                bounds.add(&corners);
            }
            let number = u32::try_from(place).expect("triangles are counted in u32");
            *reference = corners.reference(number);
        }
        bounds
    };
    if triangles.len() < PARALLEL {
        return of_chunk(0, triangles, references);
    }
    let chunks = triangles.par_chunks(PARALLEL).zip(references.par_chunks_mut(PARALLEL));
    chunks
        .enumerate()
        .map(|(chunk, (triangles, references))| of_chunk(chunk * PARALLEL, triangles, references))
        .reduce(|| Corners::EMPTY, |a, b| a.with(&b))
}

/// Takes out those of the first so many references whose boxes are empty; their numbers.
fn take_out(count: usize, references: &mut [Reference]) -> Vec<u32> {
    let mut left_out = Vec::new();
    for at in 0..count {
        let reference = references[at];
        if Corners(reference).is_empty() {
            left_out.push(number(&reference));
        } else if !left_out.is_empty() {
            references[at - left_out.len()] = reference;
        }
    }
    left_out
}

/// A power of two that brings coordinates of this size to where areas neither overflow nor underflow;
/// 1 where they are there already.
fn unit(largest: f32) -> f32 {
    // Zero where there are no triangles.
    if largest == 0.0 || (1e-9..1e9).contains(&largest) {
        return 1.0;
    }
    let mut unit = 1.0_f32;
    while largest * unit > 1.0 {
        unit *= 0.5;
    }
    while largest * unit < 0.5 && unit < 1e38 {
        unit *= 2.0;
    }
    unit
}

#[cfg(test)]
mod tests {
    use trisect_workloads::{Mesh, Stream};

    use super::*;

    /// A mesh that is worked on in several chunks, and long triangles across it that are divided.
    fn scene() -> Vec<Triangle<f32>> {
        let bunny = Mesh::bunny();
        let mut triangles = bunny.triangles.to_vec();
        let mut stream = Stream::new("long", 1);
        let center = bunny.bounds.center();
        for _ in 0..500 {
            let mut corner = || {
                #[allow(clippy::cast_possible_truncation, reason = "rounds")]
                let away = stream.cube().map(|x| x as f32);
                center + away.scale(bunny.bounds.diagonal())
            };
            triangles.push(Triangle { a: corner(), b: corner(), c: corner() });
        }
        triangles
    }

    #[test]
    fn trees_are_the_same_to_the_bit_for_any_number_of_threads() {
        let triangles = scene();
        for builder in Builder::ALL {
            let of_threads = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let layout = pool.expect("there are threads").install(|| {
                    outline(&triangles, builder, Leaves::default(), Kinds::All(0)).layout
                });
                let coordinates = layout.nodes.iter().flat_map(|node| node.bounds).flatten();
                let coordinates: Vec<u32> = coordinates.flatten().map(f32::to_bits).collect();
                let children: Vec<_> = layout.nodes.iter().map(|node| node.children).collect();
                let blocks: Vec<_> = layout.blocks.iter().map(|block| block.triangles).collect();
                (coordinates, children, blocks, layout.references)
            };
            let one = of_threads(1);
            assert!(one.1.len() > 1000, "{builder}");
            assert_eq!(one.3 > triangles.len(), builder == Builder::Spatial, "{builder}");
            assert!(one == of_threads(2), "{builder}");
            assert!(one == of_threads(3), "{builder}");
        }
    }

    #[test]
    fn every_triangle_is_in_a_leaf_and_none_twice() {
        let mut triangles = scene();
        triangles[1000].b = triangles[1000].a;
        for builder in Builder::ALL {
            let Outline { layout, left_out, .. } =
                outline(&triangles, builder, Leaves::default(), Kinds::All(0));
            assert_eq!(left_out, [1000], "{builder}");
            let mut found = vec![0_u32; triangles.len()];
            let mut references = 0;
            let leaves = layout.nodes.iter().flat_map(|node| node.children);
            for number in leaves {
                let crate::bvh::Child::Leaf(first, count) = crate::bvh::child(number) else {
                    continue;
                };
                let blocks = &layout.blocks[first..first + count];
                let mut members: Vec<u32> =
                    blocks.iter().flat_map(|block| block.triangles).collect();
                // Blocks are filled up by their last triangle.
                members.dedup();
                references += members.len();
                for &member in &members {
                    found[member as usize] += 1;
                }
                members.sort_unstable();
                assert!(members.windows(2).all(|pair| pair[0] != pair[1]), "{members:?}");
            }
            assert_eq!(references, layout.references);
            for (number, &times) in found.iter().enumerate() {
                assert_eq!(times == 0, number == 1000, "{builder}: {number}");
                assert!(times <= 1 || builder == Builder::Spatial, "{builder}: {number}");
            }
        }
    }
}
