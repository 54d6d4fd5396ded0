//! Scenes of instances: a tree over shared trees, each in its places.
//!
//! A ray goes down the top tree, near instances first; at each it is [carried](Transform::carry) to the space of what is
//! placed there, and goes through that tree as any ray does. Trees over instances are [`Tree`]s themselves, so that
//! they can be placed in turn. Their triangles are numbered as if each instance had triangles of its own, one
//! instance after another: [`Instances::locate`] leads back.

mod batch;
mod build;
mod queries;
mod room;
mod transform;

use std::ops::Range;
use std::slice::from_ref;
use std::sync::Arc;

use glam::Affine3A;
use trisect_core::{Ray, Triangle, Vec3};

pub use self::build::Update;
pub use self::transform::{BadTransform, Transform};
use crate::bvh::builders::corners::Corners;
use crate::bvh::wide::WideTree;
use crate::dispatch::Tracing;
use crate::hits::lanes_of;
use crate::lanes::on_fast_lanes;
use crate::traverse::walk::WideWalks;
use crate::tree::Tree;

/// What can be placed: it has a tree.
pub trait HasTree: Send + Sync + 'static {
    /// The tree.
    fn tree(&self) -> &dyn Tree;
}

impl HasTree for Box<dyn Tree> {
    fn tree(&self) -> &dyn Tree {
        &**self
    }
}

/// What a tree over instances has to know of a tree that it places.
#[derive(Clone, Debug)]
pub struct Extent {
    /// How many triangles there are, hit or not: ids are below that.
    pub(crate) triangles: usize,
    /// Boxes around all triangles that can be hit: several, as what is around them once they are turned is smaller then
    /// than what is around a turned box.
    pub(crate) boxes: Vec<[Vec3<f32>; 2]>,
    /// By how much of the largest coordinate of its origin a ray may pass by the boxes in which it has hits.
    pub(crate) per_origin: f64,
    /// That holds for rays whose directions have a coordinate as large as this.
    pub(crate) least_direction: f64,
    /// Trees over instances, one in another.
    pub(crate) levels: usize,
}

impl Extent {
    /// That of a tree which has just these triangles.
    pub fn of(triangles: &[Triangle<f32>]) -> Self {
        let hit = triangles.iter().filter(|triangle| triangle.can_be_hit());
        let around =
            hit.fold(Corners::EMPTY, |all, triangle| all.with(&Corners::of_triangle(triangle)));
        let boxes = if around.is_empty() { vec![] } else { vec![around.corners()] };
        Self { triangles: triangles.len(), boxes, per_origin: 0.0, least_direction: 0.0, levels: 0 }
    }

    /// That of several trees in one space, whose triangles are numbered one tree after another.
    pub fn of_all(trees: impl IntoIterator<Item = Self>) -> Self {
        trees.into_iter().fold(Self::of(&[]), |mut all, tree| {
            all.triangles += tree.triangles;
            all.boxes.extend(tree.boxes);
            all.per_origin = all.per_origin.max(tree.per_origin);
            all.least_direction = all.least_direction.max(tree.least_direction);
            all.levels = all.levels.max(tree.levels);
            all
        })
    }

    /// How many triangles there are, hit or not.
    pub fn triangles(&self) -> usize {
        self.triangles
    }

    pub(crate) fn of_tree(tree: &WideTree) -> Self {
        Self {
            triangles: tree.origin.triangles,
            boxes: tree.boxes().map(|bounds| bounds.corners()).collect(),
            per_origin: 0.0,
            least_direction: 0.0,
            levels: 0,
        }
    }
}

/// Something in its place.
pub struct Instance<T> {
    of: Arc<T>,
    transform: Transform,
    /// The id of its first triangle.
    first: u32,
    /// What hits it is in here, in the world, but for rays [from afar](Instances::margin).
    bounds: Corners,
}

impl<T> Instance<T> {
    /// What is placed.
    pub fn of(&self) -> &Arc<T> {
        &self.of
    }

    /// Where.
    pub fn transform(&self) -> &Transform {
        &self.transform
    }
}

/// Instances cannot be placed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InstanceError {
    /// A number of a transform is infinite or NaN.
    #[error("the transform of instance {instance} is not finite: its rows are {rows:?}")]
    NotFinite {
        /// The index of the instance.
        instance: usize,
        /// The rows of its transform.
        rows: [[f32; 4]; 3],
    },
    /// A transform has no inverse, or none that f32 can tell from rounding.
    #[error(
        "the transform of instance {instance} is singular, as far as f32 can tell: it flattens what it places; its \
         rows are {rows:?}"
    )]
    Singular {
        /// The index of the instance.
        instance: usize,
        /// The rows of its transform.
        rows: [[f32; 4]; 3],
    },
    /// Together they have more triangles than can be numbered.
    #[error(
        "with instance {instance} there are 2³² triangles or more, those of each instance counted: divide the scene"
    )]
    TooMany {
        /// The index of the instance.
        instance: usize,
    },
    /// Instances of instances of instances …
    #[error(
        "instance {instance} is {LEVELS} levels of instances deep already, the most there may be"
    )]
    TooDeep {
        /// The index of the instance.
        instance: usize,
    },
    /// There is no such instance.
    #[error("there is no instance {instance}: there are {instances}, numbered from 0")]
    NoInstance {
        /// The index.
        instance: usize,
        /// How many there are.
        instances: usize,
    },
    /// There are more or fewer transforms than instances.
    #[error("there are {instances} instances, and {given} transforms are given: give each its own")]
    Count {
        /// How many instances there are.
        instances: usize,
        /// How many transforms.
        given: usize,
    },
}

/// Levels of instances at most: each takes room on the stack of a ray.
const LEVELS: usize = 16;

/// A tree over instances. Its answers are those of asking every instance with its carried ray, and taking the nearest
/// hit; of equally near ones, by their rounded `t`, that of the first instance.
pub struct Instances<T> {
    placed: Vec<Instance<T>>,
    top: WideTree,
    /// The cost of the top tree when it was built.
    built: f64,
    /// Rays from within this, along each axis, meet the boxes of what they hit.
    reach: f32,
    /// How much wider boxes are for others, per length that they are farther away.
    per_length: f32,
    /// For rays with shorter directions nothing is known.
    least_direction: f32,
    levels: usize,
    /// Whether a point can be inside: all methods are exact.
    is_exact: bool,
}

impl<T: HasTree> Instances<T> {
    /// Places things, each by the transform from its own space to the world.
    ///
    /// # Errors
    /// When a transform is not finite or is singular, or there are too many triangles or levels: the message names the
    /// instance.
    pub fn new(
        instances: impl IntoIterator<Item = (Arc<T>, Affine3A)>,
    ) -> Result<Self, InstanceError> {
        build::build(instances.into_iter())
    }

    /// The instances, in order.
    pub fn instances(&self) -> &[Instance<T>] {
        &self.placed
    }

    /// The instance that a triangle belongs to, by index, and the triangle's id there.
    ///
    /// # Panics
    /// When there is no such triangle.
    #[inline]
    pub fn locate(&self, triangle: u32) -> (usize, u32) {
        // Those without triangles begin where the next one does, and own nothing.
        let after = self.placed.partition_point(|instance| instance.first <= triangle);
        let instance = after - 1;
        (instance, triangle - self.placed[instance].first)
    }

    /// The instances that a ray may hit, near ones first, and the ray as it is carried to each.
    pub fn sights(&self, ray: &Ray<f32>) -> impl Iterator<Item = (usize, Ray<f32>)> + use<T> {
        let mut met = vec![];
        self.walk(Tracing::Plain, ray, &mut |at| {
            met.push((at, self.placed[at].transform.carry(ray)));
            ray.tmax
        });
        met.into_iter()
    }

    /// Calls `take` for each instance that a ray may hit, near ones first; it says where the interval of the ray ends
    /// from then on.
    #[inline]
    fn walk(&self, tracing: Tracing, ray: &Ray<f32>, take: &mut dyn FnMut(usize) -> f32) {
        self.walk_all(tracing, from_ref(ray), &mut |_, instance| take(instance));
    }

    /// The same for many rays, one after another; `take` gets the index of the ray as well.
    #[inline]
    fn walk_all(
        &self,
        tracing: Tracing,
        rays: &[Ray<f32>],
        take: &mut dyn FnMut(usize, usize) -> f32,
    ) {
        let leaf = &mut |ray: usize, instances: Range<usize>| {
            // A place without a child is a leaf of nothing.
            if instances.is_empty() { rays[ray].tmax } else { take(ray, instances.start) }
        };
        let margin = &|ray: &Ray<f32>| self.margin(ray);
        let walks = WideWalks { tree: &self.top, rays, margin, leaf };
        match lanes_of(tracing) {
            Some(plain) => plain.run(walks),
            None => on_fast_lanes(walks).unwrap_or_default(),
        }
    }

    /// By how much boxes have to be larger for a ray.
    ///
    /// With `k` the largest of [`Off::relative`](transform::Off) and boxes that are widened for origins within `reach`, a
    /// ray from farther away may be off by `4k` more per length: `2·k·2·|o|`. Adding the margin to what moves the sides
    /// of all boxes rounds as well, within `u·(|o| + margin)`, for which `4u·|o|` is taken; `4k ≤ 1`.
    #[inline]
    fn margin(&self, ray: &Ray<f32>) -> f32 {
        if self.per_length == 0.0 {
            return 0.0;
        }
        if ray.d.largest_magnitude() < self.least_direction {
            return f32::INFINITY;
        }
        let away = ray.o.largest_magnitude();
        if away > self.reach {
            (away - self.reach) * self.per_length + away * (2.0 * f32::EPSILON)
        } else {
            0.0
        }
    }
}
