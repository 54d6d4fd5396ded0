//! Waves: rays of a type wait in a queue until all that are there go together.
//!
//! A ray is its eight numbers, the index that it belongs to, and what it carries: all that is left of the program that
//! sent it. So nothing waits on a stack, and the tracer gets thousands of rays at a time.

use std::mem::{replace, take};

use trisect_core::Ray;
use trisect_tracer::{Tracing, Tree as _, TriangleHit, Verdict};

use crate::programs::{Cells, Entry, On, RayType, Traces};
use crate::scene::Scene;

/// Rays of a type that wait.
pub struct Queue<R: RayType> {
    waiting: Together<R>,
    /// Room from the last wave.
    spare: Together<R>,
}

/// Rays that go together.
struct Together<R: RayType> {
    rays: Vec<Ray<f32>>,
    /// The index that each belongs to, and what it carries.
    carried: Vec<(u32, R::Payload)>,
}

impl<R: RayType> Default for Together<R> {
    fn default() -> Self {
        Self { rays: vec![], carried: vec![] }
    }
}

impl<R: RayType> Default for Queue<R> {
    fn default() -> Self {
        Self { waiting: Together::default(), spare: Together::default() }
    }
}

impl<R: RayType> Queue<R> {
    #[inline(always)]
    pub(crate) fn push(&mut self, ray: Ray<f32>, slot: u32, payload: R::Payload) {
        self.waiting.rays.push(ray);
        self.waiting.carried.push((slot, payload));
    }
}

/// The queues of an entry's rays.
pub(crate) type QueuesOf<E> = <<E as Entry>::Rays as RayTypes>::Queues;

/// Types of rays, in a tuple.
pub trait RayTypes {
    /// A queue for each of them.
    type Queues: Default + Send;
    /// How many they are.
    const COUNT: usize;
}

/// Queues among which there is one for a type; `I` says where, and is found by the compiler.
pub trait Holds<R: RayType, I> {
    /// That queue.
    fn queue(&mut self) -> &mut Queue<R>;
}

/// Rays of several types that go through a scene in waves.
pub trait Flow<E: Entry>: RayTypes {
    /// Sends all rays that wait, type by type; whether there were any.
    #[doc(hidden)]
    fn flow(wave: &mut Wave<'_, E>) -> bool;
}

/// All that a wave works with.
pub struct Wave<'a, E: Entry> {
    pub(crate) entry: &'a E,
    pub(crate) scene: &'a Scene<E::Material>,
    pub(crate) tracing: Tracing,
    pub(crate) queues: &'a mut QueuesOf<E>,
    pub(crate) cells: &'a mut Cells<E>,
    pub(crate) room: &'a mut Answers,
    pub(crate) round: u32,
    /// Rays so far, of each type.
    pub(crate) rays: &'a mut [u64],
}

/// Room for what is known of rays.
#[derive(Default)]
pub(crate) struct Answers {
    found: Vec<Option<TriangleHit>>,
    blocked: Vec<bool>,
    /// The shapes that a ray was offered.
    offered: Vec<u32>,
}

impl<E: Entry> Wave<'_, E> {
    /// Sends all rays of a type; whether there were any.
    fn send<R: RayType, I>(&mut self, number: usize) -> bool
    where
        E: Traces<R>,
        QueuesOf<E>: Holds<R, I>,
    {
        let queue = self.queues.queue();
        if queue.waiting.rays.is_empty() {
            return false;
        }
        let spare = take(&mut queue.spare);
        let mut sent = replace(&mut queue.waiting, spare);
        let Together { rays, carried } = &mut sent;
        self.rays[number] += rays.len() as u64;
        if R::ANY {
            self.send_for_any(rays, carried);
        } else {
            self.send_for_closest(rays, carried);
        }
        rays.clear();
        carried.clear();
        self.queues.queue().spare = sent;
        true
    }

    fn send_for_closest<R: RayType>(&mut self, rays: &[Ray<f32>], carried: &mut [(u32, R::Payload)])
    where
        E: Traces<R>,
    {
        let mut found = take(&mut self.room.found);
        found.clear();
        if const { E::ANY_HIT } {
            let pairs = rays.iter().zip(&mut *carried);
            found.extend(pairs.map(|(ray, (_, payload))| self.filtered(ray, payload)));
        } else {
            found.resize(rays.len(), None);
            self.scene.top().closest(self.tracing, R::FACES, rays, &mut found);
        }
        let (entry, scene, round) = (self.entry, self.scene, self.round);
        let (queues, cells) = (&mut *self.queues, &mut *self.cells);
        for ((ray, &mut (slot, payload)), found) in rays.iter().zip(carried).zip(&found) {
            let on = &mut On { scene, queues, cells, slot, round };
            match found {
                Some(found) => entry.closest_hit(&scene.place(*ray, *found), payload, on),
                None => entry.miss(ray, payload, on),
            }
        }
        self.room.found = found;
    }

    fn send_for_any<R: RayType>(&mut self, rays: &[Ray<f32>], carried: &mut [(u32, R::Payload)])
    where
        E: Traces<R>,
    {
        let mut blocked = take(&mut self.room.blocked);
        blocked.clear();
        if const { E::ANY_HIT } {
            let pairs = rays.iter().zip(&mut *carried);
            blocked.extend(pairs.map(|(ray, (_, payload))| self.filtered(ray, payload).is_some()));
        } else {
            blocked.resize(rays.len(), false);
            self.scene.top().any(self.tracing, R::FACES, rays, &mut blocked);
        }
        let (entry, scene, round) = (self.entry, self.scene, self.round);
        let (queues, cells) = (&mut *self.queues, &mut *self.cells);
        for ((ray, &mut (slot, payload)), blocked) in rays.iter().zip(carried).zip(&blocked) {
            let on = &mut On { scene, queues, cells, slot, round };
            if *blocked { entry.blocked(ray, payload, on) } else { entry.miss(ray, payload, on) }
        }
        self.room.blocked = blocked;
    }

    /// The closest hit that the program for any hit accepts, or any one.
    fn filtered<R: RayType>(
        &mut self,
        ray: &Ray<f32>,
        payload: &mut R::Payload,
    ) -> Option<TriangleHit>
    where
        E: Traces<R>,
    {
        let (entry, scene) = (self.entry, self.scene);
        let offered = &mut self.room.offered;
        offered.clear();
        scene.top().filtered(self.tracing, R::FACES, ray, &mut |hit| {
            if const { E::ONCE } && scene.resolved.is_split {
                if offered.contains(&hit.triangle) {
                    return Verdict::Ignore;
                }
                offered.push(hit.triangle);
            }
            match entry.any_hit(&scene.place(*ray, *hit), payload) {
                Verdict::Accept if R::ANY => Verdict::End,
                verdict => verdict,
            }
        })
    }
}

/// The place of a type in a tuple.
pub struct Nth<const I: usize>;

macro_rules! ray_types {
    ($count:literal: $($type:ident $at:tt),+) => {
        impl<$($type: RayType),+> RayTypes for ($($type,)+) {
            type Queues = ($(Queue<$type>,)+);
            const COUNT: usize = $count;
        }

        impl<E, $($type),+> Flow<E> for ($($type,)+)
        where
            $($type: RayType,)+
            E: Entry<Rays = Self> $(+ Traces<$type>)+,
        {
            fn flow(wave: &mut Wave<'_, E>) -> bool {
                let mut any = false;
                $(any |= wave.send::<$type, Nth<$at>>($at);)+
                any
            }
        }
    };
}
ray_types!(1: A 0);
ray_types!(2: A 0, B 1);
ray_types!(3: A 0, B 1, C 2);
ray_types!(4: A 0, B 1, C 2, D 3);

macro_rules! holds {
    ($(($($type:ident)+): $own:ident $at:tt;)+) => {
        $(impl<$($type: RayType),+> Holds<$own, Nth<$at>> for ($(Queue<$type>,)+) {
            #[inline(always)]
            fn queue(&mut self) -> &mut Queue<$own> {
                &mut self.$at
            }
        })+
    };
}
holds! {
    (A): A 0;
    (A B): A 0;
    (A B): B 1;
    (A B C): A 0;
    (A B C): B 1;
    (A B C): C 2;
    (A B C D): A 0;
    (A B C D): B 1;
    (A B C D): C 2;
    (A B C D): D 3;
}
