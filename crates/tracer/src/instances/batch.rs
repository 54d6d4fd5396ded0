//! Batches of rays through instances: the rays that may meet an instance go through its tree together.
//!
//! Each ray's instances are listed first. Then all rays go to the nearest one that each has, and then to the others, as far
//! as they are not behind what was hit there: so most rays are short when they are carried farther, and those that go
//! to the same instance are a batch of it.

use trisect_core::Ray;
use trisect_method::Culling;

use super::queries::Best;
use super::{HasTree, Instance, Instances};
use crate::dispatch::{Tracing, assert_room};
use crate::hit::TriangleHit;
use crate::parallel::{self, Task};
use crate::rays::slabs::meets_wide_box;
use crate::vectors::WIDTH;

/// Rays that one thread takes at a time.
const CHUNK: usize = 4096;

/// So few rays are cheaper asked one by one.
const FEW: usize = 4;

/// Visits of rays to instances, in the order in which they are made.
struct Visits {
    /// The index of the ray in each.
    rays: Vec<u32>,
    /// Where those begin that are first visits, or later ones, to each instance.
    starts: Vec<u32>,
}

impl Visits {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "rays are few, and instances are numbered in u32"
    )]
    fn new<T: HasTree>(of: &Instances<T>, tracing: Tracing, rays: &[Ray<f32>]) -> Self {
        let count = of.placed.len();
        let (mut listed, mut last) = (vec![], usize::MAX);
        // Where they begin, one further on, so that they count up to where they are to be.
        let mut starts = vec![0_u32; 2 * count + 2];
        of.walk_all(tracing, rays, &mut |ray, instance| {
            let place = if ray == last { count + instance } else { instance };
            last = ray;
            starts[place + 2] += 1;
            listed.push((place as u32, ray as u32));
            rays[ray].tmax
        });
        for at in 2..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut rays = vec![0; listed.len()];
        for (place, ray) in listed {
            let next = &mut starts[place as usize + 1];
            rays[*next as usize] = ray;
            *next += 1;
        }
        Self { rays, starts }
    }

    /// The instance of each batch, and its rays.
    fn batches(&self) -> impl Iterator<Item = (usize, &[u32])> {
        let count = self.starts.len() / 2 - 1;
        let ends = self.starts.windows(2).take(2 * count).enumerate();
        ends.filter(|(_, ends)| ends[0] < ends[1]).map(move |(place, ends)| {
            (place % count, &self.rays[ends[0] as usize..ends[1] as usize])
        })
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
        let (Self(tracing, culling), tree) = (self, of.of.tree());
        if rays.len() > FEW || tracing == Tracing::Plain {
            return tree.closest(tracing, culling, rays, answers);
        }
        for (ray, answer) in rays.iter().zip(answers) {
            *answer = tree.closest_hit(culling, ray).found();
        }
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
        let (Self(tracing, culling), tree) = (self, of.of.tree());
        if rays.len() > FEW || tracing == Tracing::Plain {
            return tree.any(tracing, culling, rays, answers);
        }
        for (ray, answer) in rays.iter().zip(answers) {
            *answer = tree.any_hit(culling, ray);
        }
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
    if let [Instance { of, transform, .. }] = &of.placed[..]
        && transform.is_identity()
    {
        return of.tree().closest(tracing, culling, rays, found);
    }
    in_chunks(of, tracing, Closest(tracing, culling), rays, found, Best::found);
}

/// As [`Tree::any`](crate::Tree::any).
pub(super) fn any<T: HasTree>(
    of: &Instances<T>,
    tracing: Tracing,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [bool],
) {
    if let [Instance { of, transform, .. }] = &of.placed[..]
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
    let mut batch = Batch {
        question,
        rays,
        margins: rays.iter().map(|ray| of.margin(ray)).collect(),
        known: vec![Q::NOTHING; rays.len()],
        carried: vec![],
        which: vec![],
        answers: vec![],
    };
    if of.placed.len() <= WIDTH {
        // A tree of one node has no more to say than its boxes.
        for instance in &of.placed {
            batch.visit(instance, 0..rays.len(), false);
        }
    } else {
        for (instance, listed) in Visits::new(of, tracing, rays).batches() {
            let listed = listed.iter().map(|&ray| ray as usize);
            batch.visit(&of.placed[instance], listed, true);
        }
    }
    batch.known
}

/// Rays on their way from instance to instance.
struct Batch<'a, Q: Question> {
    question: Q,
    rays: &'a [Ray<f32>],
    /// By how much boxes are larger for each.
    margins: Vec<f32>,
    known: Vec<Q::Known>,
    /// Those that are carried to an instance, and which they are.
    carried: Vec<Ray<f32>>,
    which: Vec<u32>,
    answers: Vec<Q::Answer>,
}

impl<Q: Question> Batch<'_, Q> {
    /// Takes those of some rays to an instance that may meet it. Where they are listed, they are known to, unless they
    /// have become shorter.
    #[allow(clippy::cast_possible_truncation, reason = "rays are few")]
    fn visit<T: HasTree>(
        &mut self,
        instance: &Instance<T>,
        some: impl Iterator<Item = usize>,
        are_listed: bool,
    ) {
        let corners = instance.bounds.corners();
        self.carried.clear();
        self.which.clear();
        for at in some {
            let ray = &self.rays[at];
            let ray = Ray { tmax: Q::end(&self.known[at], ray.tmax), ..*ray };
            if are_listed && ray.tmax == self.rays[at].tmax
                || meets_wide_box(&ray, corners, self.margins[at])
            {
                self.carried.push(instance.transform.carry(&ray));
                self.which.push(at as u32);
            }
        }
        self.answers.clear();
        self.answers.resize(self.carried.len(), Q::NO_ANSWER);
        self.question.ask(instance, &self.carried, &mut self.answers);
        for (&at, answer) in self.which.iter().zip(&self.answers) {
            Q::take(&mut self.known[at as usize], instance, answer);
        }
    }
}
