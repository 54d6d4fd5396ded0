//! Batches of rays through instances: the rays that may meet an instance go through its tree together.
//!
//! Each ray's instances are listed first, near ones first; then, round by round, all rays go to the nearest instance that
//! each has left. So what is near shortens rays before they are carried farther, and those of one round that go to the
//! same instance are a batch of it. How a tree's batches are traced is up to the tree.

use trisect_core::Ray;
use trisect_method::Culling;

use super::queries::Best;
use super::{HasTree, Instance, Instances};
use crate::dispatch::{Tracing, assert_room};
use crate::hit::TriangleHit;
use crate::parallel::{self, Task};
use crate::rays::slabs::meets_box;

/// Rays that one thread takes at a time.
const CHUNK: usize = 4096;

/// The round, the instance and the ray, as one number that sorts so.
struct Visit(u64);

impl Visit {
    fn new(round: usize, instance: usize, ray: usize) -> Self {
        // Rounds that have no number of their own are one.
        Self((round.min(0xffff) as u64) << 48 | (instance as u64) << 16 | ray as u64)
    }

    fn round_and_instance(&self) -> u64 {
        self.0 >> 16
    }

    #[allow(clippy::cast_possible_truncation, reason = "of 32 bits")]
    fn instance(&self) -> usize {
        (self.0 >> 16) as u32 as usize
    }

    fn ray(&self) -> usize {
        self.0 as usize & 0xffff
    }
}

/// What rays are asked.
trait Question: Copy + Send + Sync {
    /// What is known of a ray.
    type Known: Copy + Send;
    /// What a tree says.
    type Answer: Clone;
    const NOTHING: Self::Known;
    const NO_ANSWER: Self::Answer;

    /// Where the interval of a ray ends now.
    fn end(known: &Self::Known, tmax: f32) -> f32;
    /// Asks a tree.
    fn ask<T: HasTree>(self, of: &Instance<T>, rays: &[Ray<f32>], answers: &mut [Self::Answer]);
    fn take<T>(known: &mut Self::Known, of: &Instance<T>, answer: &Self::Answer)
    where
        T: HasTree;
}

#[derive(Clone, Copy)]
struct Closest(Tracing, Culling);

impl Question for Closest {
    type Known = Best;
    type Answer = Option<TriangleHit>;
    const NOTHING: Best = Best::NONE;
    const NO_ANSWER: Option<TriangleHit> = None;

    fn end(known: &Best, tmax: f32) -> f32 {
        known.end(tmax)
    }

    fn ask<T: HasTree>(self, of: &Instance<T>, rays: &[Ray<f32>], answers: &mut [Self::Answer]) {
        of.of.tree().closest(self.0, self.1, rays, answers);
    }

    fn take<T: HasTree>(known: &mut Best, of: &Instance<T>, answer: &Option<TriangleHit>) {
        if let Some(hit) = answer {
            known.take(of.named(*hit));
        }
    }
}

#[derive(Clone, Copy)]
struct Any(Tracing, Culling);

impl Question for Any {
    type Known = bool;
    type Answer = bool;
    const NOTHING: bool = false;
    const NO_ANSWER: bool = false;

    fn end(known: &bool, tmax: f32) -> f32 {
        if *known { f32::NEG_INFINITY } else { tmax }
    }

    fn ask<T: HasTree>(self, of: &Instance<T>, rays: &[Ray<f32>], answers: &mut [bool]) {
        of.of.tree().any(self.0, self.1, rays, answers);
    }

    fn take<T: HasTree>(known: &mut bool, _: &Instance<T>, answer: &bool) {
        *known |= answer;
    }
}

/// As [`Tree::closest`](crate::Tree::closest).
pub(super) fn closest<T: HasTree>(
    of: &Instances<T>,
    tracing: Tracing,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [Option<TriangleHit>],
) {
    if let [Instance { of, transform, .. }] = &of.instances[..]
        && transform.is_identity()
    {
        return of.tree().closest(tracing, culling, rays, found);
    }
    in_chunks(of, tracing, Closest(tracing, culling), rays, found, |best| best.found());
}

/// As [`Tree::any`](crate::Tree::any).
pub(super) fn any<T: HasTree>(
    of: &Instances<T>,
    tracing: Tracing,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [bool],
) {
    if let [Instance { of, transform, .. }] = &of.instances[..]
        && transform.is_identity()
    {
        return of.tree().any(tracing, culling, rays, found);
    }
    in_chunks(of, tracing, Any(tracing, culling), rays, found, |known| known);
}

fn in_chunks<T: HasTree, Q: Question, X: Send>(
    of: &Instances<T>,
    tracing: Tracing,
    question: Q,
    rays: &[Ray<f32>],
    found: &mut [X],
    answer: impl Fn(Q::Known) -> X + Copy + Send + Sync,
) {
    assert_room(rays, found);
    let parts = rays.chunks(CHUNK).zip(found.chunks_mut(CHUNK));
    parallel::all(parts.map(|(rays, found)| -> Task<'_> {
        Box::new(move || {
            let known = chunk(of, tracing, question, rays);
            for (found, known) in found.iter_mut().zip(known) {
                *found = answer(known);
            }
        })
    }));
}

/// What is known of rays at their ends.
fn chunk<T: HasTree, Q: Question>(
    of: &Instances<T>,
    tracing: Tracing,
    question: Q,
    rays: &[Ray<f32>],
) -> Vec<Q::Known> {
    let mut known = vec![Q::NOTHING; rays.len()];
    let mut visits = vec![];
    for (number, ray) in rays.iter().enumerate() {
        let mut round = 0;
        of.walk(tracing, ray, &mut |instance| {
            visits.push(Visit::new(round, instance, number));
            round += 1;
            ray.tmax
        });
    }
    visits.sort_unstable_by_key(|visit| visit.0);
    let (mut carried, mut which, mut answers) = (vec![], vec![], vec![]);
    for visits in visits.chunk_by(|a, b| a.round_and_instance() == b.round_and_instance()) {
        let instance = &of.instances[visits[0].instance()];
        let [low, high] = instance.bounds.corners();
        carried.clear();
        which.clear();
        for number in visits.iter().map(Visit::ray) {
            let ray = Ray { tmax: Q::end(&known[number], rays[number].tmax), ..rays[number] };
            // What is in front may have ended it before the box.
            if ray.tmax == rays[number].tmax || of.margin(&ray) > 0.0 || meets_box(&ray, low, high)
            {
                carried.push(instance.transform.carry(&ray));
                which.push(number);
            }
        }
        answers.clear();
        answers.resize(carried.len(), Q::NO_ANSWER);
        question.ask(instance, &carried, &mut answers);
        for (&number, answer) in which.iter().zip(&answers) {
            Q::take(&mut known[number], instance, answer);
        }
    }
    known
}
