//! The programs of a launch, as traits: what they need is known when they are compiled, and what they do not is not there.

use trisect_core::Ray;
use trisect_method::Culling;
use trisect_tracer::Verdict;

use crate::buffer::Buffer;
use crate::place::Place;
use crate::scene::Scene;
use crate::waves::{Flow, Holds, QueuesOf};

/// A type of ray: as one of light, or one that asks for shadow.
pub trait RayType: Sized + Send + Sync + 'static {
    /// What a ray carries: all that is known when it arrives.
    type Payload: Copy + Send + Sync;
    /// Whether any hit ends the ray: nothing is asked about where.
    const ANY: bool = false;
    /// The faces that it does not see.
    const FACES: Culling = Culling::None;
}

/// An entry point: what a launch runs for each of its indices. Any number of them may be launched on a scene.
pub trait Entry: Sized + Sync {
    /// What the scene's materials are.
    type Material: Send + Sync;
    /// The types of its rays, in a tuple. Those of a type are traced together; of several types in this order.
    type Rays: Flow<Self>;
    /// What each index has in the buffer.
    type Out: Copy + Send;
    /// What programs append; `()` where they do not.
    type Append: Send;
    /// Whether exceptions are looked for. Else they are not in the code: a ray that is not finite hits nothing, and
    /// one of a round too many is not sent.
    const CATCHES: bool = false;
    /// So often rays may come of rays.
    const ROUNDS: u32 = u32::MAX;

    /// Sends the rays of an index.
    fn generate(&self, index: [u32; 3], on: &mut On<'_, Self>);

    /// What an index is given where there was an exception, the first one of it; whatever else came of its rays.
    fn exception(&self, _exception: Exception, _out: &mut Self::Out) {}
}

/// What becomes of rays of a type.
pub trait Traces<R: RayType>: Entry {
    /// Whether there is a program for any hit. Where there is not, the tracer's own loops find hits.
    const ANY_HIT: bool = false;
    /// Whether that program has effects, so that it must see a shape once. Where a tree has a shape in several leaves,
    /// it would be offered its hit in each.
    const ONCE: bool = false;

    /// For each hit that may be the closest one, in no particular order: whether it counts. Of equal rays the order is
    /// the same, whatever the threads.
    #[inline]
    fn any_hit(&self, _at: &Place<'_, Self::Material>, _payload: &mut R::Payload) -> Verdict {
        Verdict::Accept
    }

    /// For the closest hit. Not for rays that [any hit](RayType::ANY) ends.
    #[inline]
    fn closest_hit(
        &self,
        _at: &Place<'_, Self::Material>,
        _payload: R::Payload,
        _on: &mut On<'_, Self>,
    ) {
    }

    /// For a ray that any hit ends, where there is one.
    #[inline]
    fn blocked(&self, _ray: &Ray<f32>, _payload: R::Payload, _on: &mut On<'_, Self>) {}

    /// For a ray that hits nothing.
    #[inline]
    fn miss(&self, _ray: &Ray<f32>, _payload: R::Payload, _on: &mut On<'_, Self>) {}
}

/// What can go wrong in a launch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exception {
    /// A ray was sent whose origin, direction or interval is not a number, or whose direction or origin is infinite,
    /// or that has no direction.
    BadRay,
    /// A ray was sent in a round after the [last one](Entry::ROUNDS).
    TooDeep,
    /// A program threw it.
    Thrown(u32),
}

/// What a program acts on: the index that its ray belongs to.
pub struct On<'a, E: Entry> {
    pub(crate) scene: &'a Scene<E::Material>,
    pub(crate) queues: &'a mut QueuesOf<E>,
    pub(crate) cells: &'a mut Cells<E>,
    pub(crate) slot: u32,
    pub(crate) round: u32,
}

/// Where indices go together: what they have, and what they share.
pub(crate) struct Cells<E: Entry> {
    pub(crate) out: Vec<E::Out>,
    /// With the place of the index among all.
    pub(crate) appended: Vec<(usize, E::Append)>,
    /// Of each index, where they are looked for.
    pub(crate) caught: Vec<Option<Exception>>,
    /// The first index, and how many go along each dimension.
    pub(crate) start: [u32; 3],
    pub(crate) size: [u32; 3],
    /// How many there are along each dimension of the launch.
    pub(crate) all: [u32; 3],
}

impl<E: Entry> Cells<E> {
    #[inline]
    pub(crate) fn index(&self, slot: u32) -> [u32; 3] {
        let [x, y, z] = self.start;
        let [width, height, _] = self.size;
        [x + slot % width, y + slot / width % height, z + slot / width / height]
    }
}

impl<E: Entry> On<'_, E> {
    /// The scene.
    pub fn scene(&self) -> &Scene<E::Material> {
        self.scene
    }

    /// The index.
    #[inline]
    pub fn index(&self) -> [u32; 3] {
        self.cells.index(self.slot)
    }

    /// What the index has in the buffer.
    #[inline(always)]
    pub fn out(&mut self) -> &mut E::Out {
        &mut self.cells.out[self.slot as usize]
    }

    /// How often rays have come of rays: 0 while an index is generated and when those rays arrive.
    #[inline]
    pub fn round(&self) -> u32 {
        self.round.saturating_sub(1)
    }

    /// Sends a ray of a type, which is named by a value of it.
    #[inline(always)]
    pub fn send<R: RayType, I>(&mut self, _type: R, ray: Ray<f32>, payload: R::Payload)
    where
        QueuesOf<E>: Holds<R, I>,
    {
        if self.round > E::ROUNDS {
            return self.caught(Exception::TooDeep);
        }
        if E::CATCHES {
            if self.cells.caught[self.slot as usize].is_some() {
                return;
            }
            if is_bad(&ray) {
                return self.caught(Exception::BadRay);
            }
        }
        self.queues.queue().push(ray, self.slot, payload);
    }

    /// Appends something. What a launch appends is in the order of the indices that it belongs to, and of one index in
    /// the order in which its rays arrive: neither depends on threads or tiles.
    #[inline]
    pub fn append(&mut self, more: E::Append) {
        let at = Buffer::<()>::at(self.cells.all, self.index());
        self.cells.appended.push((at, more));
    }

    /// Throws an exception: the entry's program for it is run for the index, where there is one.
    #[inline]
    pub fn throw(&mut self, code: u32) {
        self.caught(Exception::Thrown(code));
    }

    #[inline]
    fn caught(&mut self, exception: Exception) {
        if E::CATCHES {
            self.cells.caught[self.slot as usize].get_or_insert(exception);
        }
    }
}

/// Whether nothing can come of a ray.
fn is_bad(ray: &Ray<f32>) -> bool {
    let d = ray.d.to_array();
    let all = ray.o.to_array().into_iter().chain(d);
    let is_finite = all.fold(true, |all, x| all & x.is_finite());
    !is_finite || ray.tmin.is_nan() || ray.tmax.is_nan() || d == [0.0; 3]
}
