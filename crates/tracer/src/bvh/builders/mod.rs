//! From triangles to a wide tree.

mod binary;
mod bins;
pub(crate) mod boxes;
mod collapse;
pub(crate) mod corners;
mod descent;
mod emit;
mod linear;
pub(crate) mod members;
mod refit;
pub(crate) mod settings;
mod spatial;
mod sweep;

use rayon::prelude::*;
use trisect_core::Triangle;

use self::corners::{Corners, Reference, id};
use self::emit::Layout;
use self::members::{Kinds, Members};
use self::refit::fit_boxes;
pub(crate) use self::refit::refit;
pub use self::refit::{RefitError, is_worn};
use self::settings::{Builder, Leaves};
use self::spatial::Cuts;
use super::bounds::Bounds;
use super::frame::Frame;
use super::wide::{CanBeHit, Origin, WideTree, can_be_hit};
use crate::parallel::PARALLEL;

/// Below so many triangles space is not split: nothing is gained in a tree of few nodes.
const SCENE: usize = 256;

/// Builds a tree over triangles of those kinds, which are in that frame, and says what is in each block. Where tests of
/// boxes are not `robust`, the boxes are larger instead.
pub(crate) fn build(
    triangles: &[Triangle<f32>],
    frame: Option<Frame>,
    builder: Builder,
    leaves: Leaves,
    kinds: &Kinds,
    is_robust: bool,
) -> (WideTree, Vec<Members>) {
    let is_in = can_be_hit(frame.as_ref());
    let Outline { layout, bounds, unit, left_out } =
        outline(triangles, is_in, builder, leaves, kinds);
    let Layout { nodes, blocks: members, depth, references } = layout;
    let origin = Origin { builder, triangles: triangles.len(), left_out, references };
    let mut tree = WideTree { nodes, depth, bounds, reach: 0.0, is_robust, frame, origin };
    if unit != 1.0 {
        // Boxes were rounded when they were scaled.
        tree.bounds = fit_boxes(&mut tree.nodes, triangles, is_in, &members);
    }
    tree.widen_boxes();
    (tree, members)
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
    is_in: CanBeHit,
    builder: Builder,
    leaves: Leaves,
    kinds: &Kinds,
) -> Outline {
    assert!(triangles.len() < u32::MAX as usize, "more triangles than ids");
    let splits = builder == Builder::Spatial && triangles.len() >= SCENE;
    // Room for parts of triangles: half as many as there are triangles.
    let room = |count: usize| if splits { count + count / 2 } else { count };
    let mut references = vec![[0.0; 8]; room(triangles.len())];
    let bounds = refer(triangles, is_in, &mut references);
    let left_out = take_out(triangles.len(), &mut references);
    let count = triangles.len() - left_out.len();
    references.truncate(room(count));
    let largest = bounds.largest();
    let unit = unit(largest);
    if unit != 1.0 {
        for reference in &mut references[..count] {
            *reference = Corners(*reference).scaled(unit).reference(id(reference));
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
fn refer(triangles: &[Triangle<f32>], is_in: CanBeHit, references: &mut [Reference]) -> Corners {
    let of_chunk = |first: usize, triangles: &[Triangle<f32>], references: &mut [Reference]| {
        let mut bounds = Corners::EMPTY;
        for ((place, triangle), reference) in (first..).zip(triangles).zip(references) {
            let mut corners = Corners::EMPTY;
            if is_in(triangle) {
                corners = Corners::of_triangle(triangle);
                bounds.add(&corners);
            }
            let id = u32::try_from(place).expect("triangles are counted in u32");
            *reference = corners.reference(id);
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

/// Takes out those of the first so many references whose boxes are empty; their ids.
fn take_out(count: usize, references: &mut [Reference]) -> Vec<u32> {
    let mut left_out = Vec::new();
    for at in 0..count {
        let reference = references[at];
        if Corners(reference).is_empty() {
            left_out.push(id(&reference));
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
    use trisect_workloads::{Stream, bunny};

    use super::*;
    use crate::bvh::node::{Child, child};

    /// A mesh that is worked on in several chunks, and long triangles across it that are divided.
    fn scene() -> Vec<Triangle<f32>> {
        let bunny = bunny();
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
                    outline(
                        &triangles,
                        can_be_hit(None),
                        builder,
                        Leaves::default(),
                        &Kinds::All(0),
                    )
                    .layout
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
                outline(&triangles, can_be_hit(None), builder, Leaves::default(), &Kinds::All(0));
            assert_eq!(left_out, [1000], "{builder}");
            let mut found = vec![0_u32; triangles.len()];
            let mut references = 0;
            let leaves = layout.nodes.iter().flat_map(|node| node.children);
            for reference in leaves {
                let Child::Leaf(first, count) = child(reference) else {
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
            for (id, &times) in found.iter().enumerate() {
                assert_eq!(times == 0, id == 1000, "{builder}: {id}");
                assert!(times <= 1 || builder == Builder::Spatial, "{builder}: {id}");
            }
        }
    }
}
