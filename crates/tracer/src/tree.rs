//! Trees over meshes: one type for each way of compiling a method into them.

use std::any::Any;
use std::collections::BTreeSet;
use std::marker::PhantomData;
use std::slice::{from_mut, from_ref};

use trisect_core::{Ray, Triangle, Vec3};
use trisect_method::{Culling, Method, Place, UnsuitableMesh};

use crate::bvh::builders::settings::{Builder, Leaves};
use crate::bvh::builders::{self, RefitError};
use crate::bvh::wide::Statistics;
use crate::dispatch::{self, Traced, Tracing, assert_room};
use crate::hit::{MaybeHit, TriangleHit};
use crate::hits::{AllHits, Crossings, NotExact, Source, Verdict, all_of, lanes_of};
use crate::instances::Extent;
use crate::lanes::PlainLanes;
use crate::parallel::{self, PART, Task, fill};
use crate::precision::Precision;
use crate::query::HasClosest;
use crate::rays::reorder::of_columns;
use crate::traced::{self, Built, TracedIn};
use crate::traverse::inspect::{self, Counted};
use crate::vectors::WIDTH;

/// A tree over a mesh, whatever its method, in f32 or in f64.
pub trait Tree<P: Precision = f32>: Any + Send + Sync {
    /// The closest hit of each ray: smallest `t`, then lowest id. On the threads of the pool that it is called
    /// in.
    ///
    /// # Panics
    /// When there are fewer places in `found` than rays.
    fn closest(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<P>],
        found: &mut [Option<TriangleHit<P>>],
    );

    /// Whether each ray hits anything. On the threads of the pool that it is called in.
    ///
    /// # Panics
    /// When there are fewer places in `found` than rays.
    fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<P>], found: &mut [bool]);

    /// The closest hit of one ray: that of [`Tree::closest`] with [`Tracing::Single`], to the bit. In a tree that is
    /// [compiled for a method](Bvh), on a processor with [fast lanes](crate::fast_lanes), it allocates nothing.
    fn closest_hit(&self, culling: Culling, ray: &Ray<P>) -> MaybeHit<P> {
        let mut found = None;
        self.closest(Tracing::Single, culling, from_ref(ray), from_mut(&mut found));
        found.into()
    }

    /// Whether one ray hits anything: as [`Tree::closest_hit`], of [`Tree::any`].
    fn any_hit(&self, culling: Culling, ray: &Ray<P>) -> bool {
        let mut found = false;
        self.any(Tracing::Single, culling, from_ref(ray), from_mut(&mut found));
        found
    }

    /// All hits of a ray, by `t`, then by id: every triangle once. An exact method orders them by their true `t`, however
    /// near they are to each other. `hits` is cleared before; nothing is allocated once it has room.
    ///
    /// No hit is lost, however the ray is traced; [`Tracing::Packets`] stands for [`Tracing::Single`] here.
    fn all(
        &self,
        tracing: Tracing,
        culling: Culling,
        crossings: Crossings,
        ray: &Ray<P>,
        hits: &mut Vec<TriangleHit<P>>,
    );

    /// How many hits [`all`](Tree::all) finds, without storing or sorting them.
    fn count(&self, tracing: Tracing, culling: Culling, crossings: Crossings, ray: &Ray<P>) -> u32;

    /// The closest hit that a program accepts. It is offered hits in no particular order, and some more than once where
    /// space was split, but none behind one that it has accepted.
    fn filtered(
        &self,
        tracing: Tracing,
        culling: Culling,
        ray: &Ray<P>,
        program: &mut dyn FnMut(&TriangleHit<P>) -> Verdict,
    ) -> Option<TriangleHit<P>>;

    /// Where a point is with respect to the solid that the triangles bound: exactly so, on any input that is finite,
    /// in the tree. A ray goes up from the point, along the last axis, and the crossings that triangles
    /// [own](Crossings::Owned) are counted: inside is what is enclosed an odd number of times, so that a surface
    /// in another one bounds a cavity. Which way triangles face plays no part. Where the surface is not closed
    /// that number says what is above the point, and no more. A point that is not finite is outside.
    ///
    /// # Errors
    /// When the method is not exact.
    fn contains(&self, point: Vec3<P>) -> Result<Place, NotExact>;

    /// The closest hit, one triangle left out: the one that a ray starts from.
    fn closest_but(
        &self,
        tracing: Tracing,
        culling: Culling,
        ray: &Ray<P>,
        triangle: u32,
    ) -> Option<TriangleHit<P>> {
        self.filtered(tracing, culling, ray, &mut |hit| {
            if hit.triangle == triangle { Verdict::Ignore } else { Verdict::Accept }
        })
    }

    /// [`all`](Tree::all) of each ray, on the threads of the pool that it is called in.
    fn all_of(
        &self,
        tracing: Tracing,
        culling: Culling,
        crossings: Crossings,
        rays: &[Ray<P>],
        hits: &mut AllHits<P>,
    ) {
        all_of(&|ray, hits| self.all(tracing, culling, crossings, ray, hits), rays, hits);
    }

    /// [`count`](Tree::count) of each ray, on the threads of the pool that it is called in.
    ///
    /// # Panics
    /// When there are fewer places in `counts` than rays.
    fn count_of(
        &self,
        tracing: Tracing,
        culling: Culling,
        crossings: Crossings,
        rays: &[Ray<P>],
        counts: &mut [u32],
    ) {
        each(&|_, ray| self.count(tracing, culling, crossings, ray), rays, counts);
    }

    /// [`filtered`](Tree::filtered) of each ray, on the threads of the pool that it is called in. The program gets
    /// the index of the ray as well.
    ///
    /// # Panics
    /// When there are fewer places in `found` than rays.
    fn filtered_of(
        &self,
        tracing: Tracing,
        culling: Culling,
        rays: &[Ray<P>],
        program: &(dyn Fn(usize, &TriangleHit<P>) -> Verdict + Sync),
        found: &mut [Option<TriangleHit<P>>],
    ) {
        let of = |index: usize, ray: &Ray<P>| {
            self.filtered(tracing, culling, ray, &mut |hit| program(index, hit))
        };
        each(&of, rays, found);
    }

    /// [`contains`](Tree::contains) of each point, by the calling thread: quicker where neighbours are near each other.
    ///
    /// # Errors
    /// When the method is not exact.
    fn contains_each(&self, points: &[Vec3<P>], places: &mut [Place]) -> Result<(), NotExact> {
        for (point, place) in points.iter().zip(places) {
            *place = self.contains(*point)?;
        }
        Ok(())
    }

    /// [`contains`](Tree::contains) of each point, on the threads of the pool that it is called in.
    ///
    /// # Errors
    /// When the method is not exact.
    ///
    /// # Panics
    /// When there are fewer places in `places` than points.
    fn contains_of(&self, points: &[Vec3<P>], places: &mut [Place]) -> Result<(), NotExact> {
        let nan = P::from_f64(f64::NAN);
        // Whether the method is exact does not depend on the point.
        self.contains(Vec3::new(nan, nan, nan))?;
        assert_room(points, places);
        for (points, places) in points.chunks(POINTS).zip(places.chunks_mut(POINTS)) {
            let order = of_columns(points);
            let asked: Vec<Vec3<P>> = order.iter().map(|&at| points[at as usize]).collect();
            let mut found = vec![Place::Outside; points.len()];
            let parts = asked.chunks(PART).zip(found.chunks_mut(PART));
            parallel::all(parts.map(|(asked, found)| -> Task<'_> {
                Box::new(move || self.contains_each(asked, found).unwrap_or_default())
            }));
            for (at, place) in order.into_iter().zip(found) {
                places[at as usize] = place;
            }
        }
        Ok(())
    }

    /// A ray's closest hit, and how many tests it takes to find it, eight boxes and one triangle at a time. The hit is that
    /// of [`Tracing::Plain`].
    fn inspect(&self, ray: &Ray<P>) -> Counted<P>;

    /// Visits the triangles that a ray may hit, near ones first and some of them several times: `visit` gets the
    /// id of one, and says where the ray's interval ends from then on. None that the ray truly hits before
    /// that end is left out.
    fn candidates(&self, ray: &Ray<P>, visit: &mut dyn FnMut(u32) -> P);

    /// Fits the tree to triangles that have moved since it was built: prepares them anew and computes
    /// the boxes, in the same tree. It answers as a new one would; how fast depends on how far they
    /// moved relative to each other. The box of a triangle that was divided between leaves is whole
    /// again in each, so build trees to be refitted without spatial splits.
    ///
    /// Triangles that nothing can hit any more are kept, and may come back later.
    ///
    /// # Errors
    /// When there are not as many triangles as before, when one can be hit that could not be when the
    /// tree was built, or when the method cannot take the mesh. The tree is as before then.
    fn refit(&mut self, triangles: &[Triangle<P>]) -> Result<(), RefitError>;

    /// Facts about the tree.
    fn statistics(&self) -> Statistics;

    /// What a tree over [`Instances`](crate::Instances) has to know of it.
    fn extent(&self) -> Extent;

    /// Bytes of nodes and blocks, but those of shared trees whose addresses are among the counted.
    fn bytes(&self, _counted: &mut BTreeSet<usize>) -> usize {
        self.statistics().bytes
    }
}

/// A mesh in a tree whose loops are compiled for a method: the fastest to trace, and the slowest to compile.
/// [`ErasedBvh`] has the method behind calls.
///
/// In f64 rays and triangles are tested as they are given; boxes are in f32, and so much larger that no true hit is lost,
/// wherever it is in the range of f64. [`Tracing::Packets`] stands for [`Tracing::Single`] there.
pub struct Bvh<M, P: Precision = f32> {
    traced: Box<dyn TracedIn<P>>,
    method: PhantomData<fn() -> M>,
}

/// A mesh in a tree whose leaves are behind calls. The loops through its nodes are compiled once for all methods, and
/// of a method the tests in a leaf alone. The answers are those of [`Bvh`], which is faster by what the calls
/// cost.
pub struct ErasedBvh {
    traced: Box<dyn Traced>,
}

/// A tree whose boxes and triangles are tested one at a time, by the calling thread, in plain arithmetic, however it
/// is asked to trace: what the tracer's techniques are measured against. Its answers are those of
/// [`Tracing::Plain`].
pub struct ScalarBvh<M> {
    traced: Box<dyn Traced>,
    method: PhantomData<fn() -> M>,
}

impl<M: Method, P: Precision> Bvh<M, P> {
    /// Prepares `triangles`, whose ids are their places in the slice, and puts them in a tree. Triangles that are
    /// not finite or have no area are left out: nothing hits them.
    ///
    /// Shares the work between the threads of the pool that it is called in; the tree depends on the
    /// triangles and the builder alone, not on the number of threads.
    ///
    /// # Errors
    /// When the method cannot take the mesh.
    ///
    /// # Panics
    /// When there are more than `u32::MAX − 1` triangles, or more than 2²⁸ blocks.
    pub fn build(triangles: &[Triangle<P>], builder: Builder) -> Result<Self, UnsuitableMesh> {
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
        triangles: &[Triangle<P>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Self, UnsuitableMesh> {
        let Built(traced) = P::traced::<M>(triangles, builder, leaves)?;
        Ok(Self { traced, method: PhantomData })
    }
}

impl ErasedBvh {
    /// As [`Bvh::build`].
    ///
    /// # Errors
    /// As [`Bvh::build`].
    ///
    /// # Panics
    /// As [`Bvh::build`].
    pub fn build<M: Method>(
        triangles: &[Triangle<f32>],
        builder: Builder,
    ) -> Result<Self, UnsuitableMesh> {
        Self::build_with::<M>(triangles, builder, Leaves::default())
    }

    /// As [`Bvh::build_with`].
    ///
    /// # Errors
    /// As [`Bvh::build`].
    ///
    /// # Panics
    /// As [`Bvh::build`].
    pub fn build_with<M: Method>(
        triangles: &[Triangle<f32>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Self, UnsuitableMesh> {
        Ok(Self { traced: traced::in_f32::<M, false>(triangles, builder, leaves)? })
    }
}

impl<M: Method> ScalarBvh<M> {
    /// As [`Bvh::build`].
    ///
    /// # Errors
    /// As [`Bvh::build`].
    ///
    /// # Panics
    /// As [`Bvh::build`].
    pub fn build(triangles: &[Triangle<f32>], builder: Builder) -> Result<Self, UnsuitableMesh> {
        let ErasedBvh { traced } = ErasedBvh::build::<M>(triangles, builder)?;
        Ok(Self { traced, method: PhantomData })
    }
}

/// Points that are put in order together: enough that neighbours share what is above them.
const POINTS: usize = 1 << 18;

/// Computes what is asked of each ray or point, on the threads of the pool that it is called in.
fn each<I: Sync, X: Send>(of: &(dyn Fn(usize, &I) -> X + Sync), inputs: &[I], found: &mut [X]) {
    assert_room(inputs, found);
    fill(inputs, found, of);
}

/// As [`Tree::refit`].
fn refit<P: Precision>(
    traced: &mut dyn TracedIn<P>,
    triangles: &[Triangle<P>],
) -> Result<(), RefitError> {
    let (tree, leaves) = traced.parts();
    let blocks: Vec<[u32; WIDTH]> =
        (0..leaves.count()).map(|block| *leaves.triangles(block)).collect();
    let (in_boxes, frame) = P::in_frame(triangles);
    let members = builders::refit(tree, &blocks, &in_boxes, frame, || leaves.kinds(triangles))?;
    leaves.prepare(triangles, &members);
    Ok(())
}

/// What all trees do alike.
macro_rules! inspections {
    ($p:ty) => {
        fn inspect(&self, ray: &Ray<$p>) -> Counted<$p> {
            inspect::inspect(&*self.traced, ray)
        }

        fn candidates(&self, ray: &Ray<$p>, visit: &mut dyn FnMut(u32) -> $p) {
            inspect::candidates(&*self.traced, ray, visit);
        }

        fn refit(&mut self, triangles: &[Triangle<$p>]) -> Result<(), RefitError> {
            refit(&mut *self.traced, triangles)
        }

        fn statistics(&self) -> Statistics {
            let leaves = self.traced.leaves();
            self.traced.tree().statistics(leaves.count(), leaves.bytes())
        }

        fn extent(&self) -> Extent {
            Extent::of_tree(self.traced.tree())
        }
    };
}

/// What trees do alike whose `traced` says how it is traced.
macro_rules! queries {
    ($p:ty) => {
        fn closest(
            &self,
            tracing: Tracing,
            culling: Culling,
            rays: &[Ray<$p>],
            found: &mut [Option<TriangleHit<$p>>],
        ) {
            self.traced.closest(tracing, culling, rays, found);
        }

        fn any(&self, tracing: Tracing, culling: Culling, rays: &[Ray<$p>], found: &mut [bool]) {
            self.traced.any(tracing, culling, rays, found);
        }
    };
}

/// Queries for more than the nearest hit, on the lanes of a way of tracing.
macro_rules! hits {
    ($p:ty, $lanes:expr) => {
        fn all(
            &self,
            tracing: Tracing,
            culling: Culling,
            crossings: Crossings,
            ray: &Ray<$p>,
            hits: &mut Vec<TriangleHit<$p>>,
        ) {
            let traced = &*self.traced;
            Source { traced, lanes: $lanes(tracing), culling, crossings, counted: None }
                .all(ray, hits);
        }

        fn count(
            &self,
            tracing: Tracing,
            culling: Culling,
            crossings: Crossings,
            ray: &Ray<$p>,
        ) -> u32 {
            let traced = &*self.traced;
            Source { traced, lanes: $lanes(tracing), culling, crossings, counted: None }.count(ray)
        }

        fn filtered(
            &self,
            tracing: Tracing,
            culling: Culling,
            ray: &Ray<$p>,
            program: &mut dyn FnMut(&TriangleHit<$p>) -> Verdict,
        ) -> Option<TriangleHit<$p>> {
            let (traced, crossings) = (&*self.traced, Crossings::Every);
            Source { traced, lanes: $lanes(tracing), culling, crossings, counted: None }
                .filtered(ray, program)
        }

        fn contains(&self, point: Vec3<$p>) -> Result<Place, NotExact> {
            let mut place = Place::Outside;
            self.contains_each(&[point], from_mut(&mut place))?;
            Ok(place)
        }

        fn contains_each(&self, points: &[Vec3<$p>], places: &mut [Place]) -> Result<(), NotExact> {
            let (traced, lanes) = (&*self.traced, $lanes(Tracing::Single));
            let (culling, crossings) = (Culling::None, Crossings::Owned);
            Source { traced, lanes, culling, crossings, counted: None }.places(points, places)
        }
    };
}

impl<M: Method, P: Precision> Tree<P> for Bvh<M, P> {
    fn closest_hit(&self, culling: Culling, ray: &Ray<P>) -> MaybeHit<P> {
        self.traced.closest_hit(culling, ray)
    }

    fn any_hit(&self, culling: Culling, ray: &Ray<P>) -> bool {
        self.traced.any_hit(culling, ray)
    }

    queries!(P);
    hits!(P, lanes_of);
    inspections!(P);
}

impl Tree for ErasedBvh {
    queries!(f32);
    hits!(f32, lanes_of);
    inspections!(f32);
}

impl<M: Method> Tree for ScalarBvh<M> {
    fn closest(
        &self,
        _: Tracing,
        culling: Culling,
        rays: &[Ray<f32>],
        found: &mut [Option<TriangleHit>],
    ) {
        let traced = &*self.traced;
        dispatch::plain(traced, dispatch::PLAIN, PlainLanes::Scalar, culling, rays, found);
    }

    fn any(&self, _: Tracing, culling: Culling, rays: &[Ray<f32>], found: &mut [bool]) {
        dispatch::plain(&*self.traced, HasClosest, PlainLanes::Scalar, culling, rays, found);
    }

    hits!(f32, |_| Some(PlainLanes::Scalar));
    inspections!(f32);
}
