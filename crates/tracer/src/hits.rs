//! Queries that want more than the nearest hit: all hits, how many there are, the nearest that a program accepts,
//! and whether a point is in a solid. One walk down the tree for all of them, which reports hits block by
//! block.

use std::cell::Cell;
use std::cmp::Ordering;
use std::ops::Range;

use trisect_core::{Ray, Vec3};
use trisect_method::{Culling, Interval, Place};

use crate::dispatch::Tracing;
use crate::hit::TriangleHit;
use crate::lanes::{Job, PlainLanes, has_fast_lanes, on_fast_lanes};
use crate::leaf::blocks::slot;
use crate::leaf::erased::LeafData;
use crate::leaf::query::end_after;
use crate::leaf::report::{BlockHits, ExactLeaves, LeafReporter};
use crate::parallel::{self, PART, Task};
use crate::precision::{Entry, Precision, Real};
use crate::query::Robust;
use crate::traced::TracedIn;
use crate::traverse::inspect::distinct;
use crate::traverse::walk::{Above, Points, Walk};
use crate::vectors::WIDTH;

/// Which triangles count where a ray meets an edge or a corner that several of them share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Crossings {
    /// Every triangle that the ray hits.
    #[default]
    Every,
    /// One owner: where a surface goes through the ray, one of the triangles there, and where it turns back none or
    /// two; see [`ExactMethod::owns`](trisect_method::ExactMethod::owns). So a closed surface is crossed an even
    /// number of times by a line. A method that is not exact has no such rule: every triangle counts.
    Owned,
}

/// What a program says of a hit that it is offered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It counts: what is behind it is not offered any more.
    Accept,
    /// The ray passes on as if there were no triangle.
    Ignore,
    /// It is the answer, however near others are, and the ray ends.
    End,
}

/// A method that rounds cannot say whether a point is in a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an exact method alone decides whether a point is inside; build the tree with one")]
pub struct NotExact;

/// All hits of each of many rays.
#[derive(Clone, Debug, PartialEq)]
pub struct AllHits<P = f32> {
    hits: Vec<TriangleHit<P>>,
    /// Where the hits of each ray end.
    ends: Vec<usize>,
}

impl<P> Default for AllHits<P> {
    /// Of no rays.
    fn default() -> Self {
        Self { hits: vec![], ends: vec![] }
    }
}

impl<P> AllHits<P> {
    /// The hits of a ray, in order.
    ///
    /// # Panics
    /// When there is no such ray.
    pub fn of(&self, ray: usize) -> &[TriangleHit<P>] {
        let start = if ray == 0 { 0 } else { self.ends[ray - 1] };
        &self.hits[start..self.ends[ray]]
    }

    /// The hits of all rays, one ray after another.
    pub fn hits(&self) -> &[TriangleHit<P>] {
        &self.hits
    }

    /// Where the hits of each ray end among those of all.
    pub fn ends(&self) -> &[usize] {
        &self.ends
    }
}

/// Finds all hits of a ray.
type FindAll<'a, P> = &'a (dyn Fn(&Ray<P>, &mut Vec<TriangleHit<P>>) + Sync);

/// Finds all hits of rays, on the threads of the pool that it is called in.
pub(crate) fn all_of<P: Precision>(find: FindAll<'_, P>, rays: &[Ray<P>], all: &mut AllHits<P>) {
    let mut parts = vec![AllHits::default(); rays.len().div_ceil(PART)];
    let tasks = rays.chunks(PART).zip(&mut parts).map(|(rays, part)| -> Task<'_> {
        Box::new(move || {
            let mut hits = vec![];
            for ray in rays {
                find(ray, &mut hits);
                part.hits.extend_from_slice(&hits);
                part.ends.push(part.hits.len());
            }
        })
    });
    parallel::all(tasks);
    all.hits.clear();
    all.ends.clear();
    for part in parts {
        let start = all.hits.len();
        all.hits.extend_from_slice(&part.hits);
        all.ends.extend(part.ends.iter().map(|end| start + end));
    }
}

/// The lanes of a way of tracing: those that are plain, or the fast ones.
pub(crate) fn lanes_of(tracing: Tracing) -> Option<PlainLanes> {
    (tracing == Tracing::Plain || !has_fast_lanes()).then_some(PlainLanes::Vector)
}

/// A tree, and how rays go through it.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a, P: Real = f32> {
    pub(crate) traced: &'a dyn TracedIn<P>,
    pub(crate) lanes: Option<PlainLanes>,
    pub(crate) culling: Culling,
    pub(crate) crossings: Crossings,
    /// How many nodes and triangles are tested, for who counts them.
    pub(crate) counted: Option<&'a Cell<Tests>>,
}

/// How many nodes and triangles are tested.
#[derive(Clone, Copy, Default)]
pub(crate) struct Tests {
    pub(crate) nodes: usize,
    pub(crate) triangles: usize,
}

impl<'a, P: Real> Source<'a, P> {
    fn leaves(&self) -> &'a dyn LeafData<P> {
        self.traced.leaves()
    }

    /// Does something on the lanes of choice.
    fn on_lanes<J: Job<Output: Default>>(&self, job: J) -> J::Output {
        match self.lanes {
            Some(plain) => plain.run(job),
            None => on_fast_lanes(job).unwrap_or_default(),
        }
    }

    /// Calls `take` for each block in which a ray may hit anything, until `end`, where its interval ends.
    fn blocks(&self, ray: &Ray<P>, end: &Cell<P>, take: &mut dyn FnMut(&BlockHits<'_, P>)) {
        let tree = self.traced.tree();
        let entry = P::enter(tree.frame.as_ref(), ray);
        self.leaves().reporter(self.lanes, self.culling, &mut |reporter| {
            let (boxed, span) = match &entry {
                Entry::Missed => return,
                Entry::Boxes(boxed, span) => (boxed, *span),
                Entry::Everywhere => return reporter.report(ray, 0..self.leaves().count(), take),
            };
            let leaf = &mut |blocks: Range<usize>| {
                self.count_triangles(blocks.clone());
                reporter.report(ray, blocks, take);
                P::end(span, end.get())
            };
            let nodes = self.on_lanes(Walk { tree, ray: boxed, leaf });
            if let Some(counted) = self.counted {
                counted.update(|tests| Tests { nodes: tests.nodes + nodes, ..tests });
            }
        });
    }

    fn count_triangles(&self, blocks: Range<usize>) {
        if let Some(counted) = self.counted {
            let more: usize =
                blocks.map(|block| distinct(self.leaves().triangles(block)).len()).sum();
            counted.update(|tests| Tests { triangles: tests.triangles + more, ..tests });
        }
    }

    /// The triangles of a block that a ray hits, in bits: what the filter leaves open is decided.
    fn met(
        &self,
        exact: Option<&dyn ExactLeaves<P>>,
        ray: &Ray<P>,
        block: &BlockHits<'_, P>,
    ) -> u64 {
        let mut met = block.met;
        if let (Some(exact), 1..) = (exact, block.open) {
            let owned = self.crossings == Crossings::Owned;
            for lane in lanes(block.open) {
                let is_hit = exact.is_hit(ray, self.culling, owned, slot(block.at, lane));
                met |= u64::from(is_hit) << lane;
            }
        }
        met
    }

    /// The id of the triangle in a slot.
    fn id(&self, slot: u32) -> u32 {
        self.leaves().triangles(slot as usize / WIDTH)[slot as usize % WIDTH]
    }

    /// All hits of a ray, in order.
    pub(crate) fn all(&self, ray: &Ray<P>, hits: &mut Vec<TriangleHit<P>>) {
        hits.clear();
        let (ray, exact) = (&as_tested(ray), self.leaves().exact());
        self.blocks(ray, &Cell::new(ray.tmax), &mut |block| {
            hits.extend(lanes(self.met(exact, ray, block)).map(|lane| found(block, lane)));
        });
        if let Some(exact) = exact {
            exact.values(ray, hits);
        }
        hits.sort_unstable_by(|a, b| self.order(exact, ray, a, b));
        for hit in &mut *hits {
            hit.triangle = self.id(hit.triangle);
        }
        // Where space was split a triangle is met in several leaves, with the same values.
        hits.dedup_by_key(|hit| hit.triangle);
    }

    /// The order of two hits, which have slots in the places of ids.
    fn order(
        &self,
        exact: Option<&dyn ExactLeaves<P>>,
        ray: &Ray<P>,
        a: &TriangleHit<P>,
        b: &TriangleHit<P>,
    ) -> Ordering {
        a.order_by_t(b).then_with(|| {
            let (first, second) = (self.id(a.triangle), self.id(b.triangle));
            match exact {
                Some(exact) if first != second => {
                    exact.order(ray, [a.triangle, b.triangle]).then(first.cmp(&second))
                }
                _ => first.cmp(&second),
            }
        })
    }

    /// How many hits there are.
    pub(crate) fn count(&self, ray: &Ray<P>) -> u32 {
        let (ray, exact) = (&as_tested(ray), self.leaves().exact());
        Tally::with(|tally| {
            self.blocks(ray, &Cell::new(ray.tmax), &mut |block| {
                tally.add(block, self.met(exact, ray, block));
            });
        })
    }

    /// The nearest hit that a program accepts.
    pub(crate) fn filtered(
        &self,
        ray: &Ray<P>,
        program: &mut dyn FnMut(&TriangleHit<P>) -> Verdict,
    ) -> Option<TriangleHit<P>> {
        let (ray, exact) = (&as_tested(ray), self.leaves().exact());
        let (mut best, mut best_slot) = (TriangleHit::NONE, 0);
        let end = Cell::new(ray.tmax);
        self.blocks(ray, &end, &mut |block| {
            let mut others = [TriangleHit::NONE; WIDTH];
            let mut count = 0;
            for lane in lanes(self.met(exact, ray, block)) {
                others[count] = found(block, lane);
                count += 1;
            }
            if let Some(exact) = exact {
                exact.values(ray, &mut others[..count]);
            }
            for other in &others[..count] {
                let slot = other.triangle;
                let order =
                    || exact.map_or(Ordering::Equal, |exact| exact.order(ray, [slot, best_slot]));
                let mut next = best;
                let is_nearer =
                    next.improve_by(TriangleHit { triangle: self.id(slot), ..*other }, order);
                if !is_nearer || end.get() == P::NEG_INFINITY {
                    continue;
                }
                let verdict = program(&next);
                if verdict == Verdict::Ignore {
                    continue;
                }
                (best, best_slot) = (next, slot);
                end.set(match verdict {
                    Verdict::End => P::NEG_INFINITY,
                    _ => end_after::<Robust, P>(best.hit.t, ray.tmax),
                });
            }
        });
        best.is_hit().then_some(best)
    }

    /// Where points are with respect to the solid that the triangles bound, in the order of the points.
    pub(crate) fn places(&self, points: &[Vec3<P>], places: &mut [Place]) -> Result<(), NotExact> {
        let exact = self.leaves().exact().ok_or(NotExact)?;
        let tree = self.traced.tree();
        Tally::with(|tally| {
            let (points, at) = (points.iter(), Vec3::new(P::ZERO, P::ZERO, P::ZERO));
            let column = Column { source: *self, exact, ray: upwards(at), is_on: false, tally };
            let mut rest = Some((column, points.zip(places)));
            self.leaves().reporter(self.lanes, self.culling, &mut |reporter| {
                let Some((column, rest)) = rest.take() else { return };
                let points = &mut Placing { column, reporter, rest, place: None };
                self.on_lanes(Above { tree, points });
            });
        });
        Ok(())
    }
}

/// What is above a point.
struct Column<'a, P: Real> {
    source: Source<'a, P>,
    exact: &'a dyn ExactLeaves<P>,
    ray: Ray<P>,
    /// Whether the point is on a triangle.
    is_on: bool,
    /// The triangles that the ray crosses.
    tally: &'a mut Tally,
}

impl<P: Real> Column<'_, P> {
    fn take(&mut self, block: &BlockHits<'_, P>) {
        let Self { source, exact, ray, is_on, tally } = self;
        // What the point is on is left open: either the ray lies in it, or hits it where it begins, which is within the
        // bounds of `t`, and never at their ends.
        let is_at = |lane| exact.is_on(ray.o, slot(block.at, lane));
        *is_on = *is_on || lanes(block.open).any(is_at);
        if !*is_on {
            tally.add(block, source.met(Some(*exact), ray, block));
        }
    }

    /// Where the point is, once all is taken.
    fn place(&mut self) -> Place {
        let crossings = self.tally.finish();
        match crossings % 2 {
            _ if self.is_on => Place::On,
            1 => Place::Inside,
            _ => Place::Outside,
        }
    }

    /// The same by any boxes that the ray may meet.
    fn walk(&mut self) -> Place {
        let (source, ray) = (self.source, self.ray);
        let end = Cell::new(ray.tmax);
        source.blocks(&ray, &end, &mut |block| {
            self.take(block);
            if self.is_on {
                end.set(P::NEG_INFINITY);
            }
        });
        self.place()
    }
}

/// Points that are placed one after another.
struct Placing<'a, P: Real, Rest> {
    column: Column<'a, P>,
    reporter: &'a dyn LeafReporter<P>,
    /// Those that are left, and where their places belong.
    rest: Rest,
    /// That of the point whose column is walked through.
    place: Option<&'a mut Place>,
}

impl<'a, P: Real, Rest> Points for Placing<'a, P, Rest>
where
    Rest: Iterator<Item = (&'a Vec3<P>, &'a mut Place)>,
{
    fn next(&mut self) -> Option<Vec3<f32>> {
        if let Some(place) = self.place.take() {
            *place = self.column.place();
        }
        loop {
            let (point, place) = self.rest.next()?;
            self.column.ray = as_tested(&upwards(*point));
            self.column.is_on = false;
            match P::enter(self.column.source.traced.tree().frame.as_ref(), &self.column.ray) {
                Entry::Missed => *place = Place::Outside,
                // One that was moved to the scene may begin later.
                Entry::Boxes(boxed, _) if boxed.tmin <= 0.0 => {
                    self.place = Some(place);
                    return Some(boxed.o);
                }
                _ => *place = self.column.walk(),
            }
        }
    }

    fn leaf(&mut self, blocks: Range<usize>) -> bool {
        let Self { column, reporter, .. } = self;
        let ray = column.ray;
        reporter.report(&ray, blocks, &mut |block| column.take(block));
        !column.is_on
    }
}

/// The ray whose crossings say whether a point is inside. Its direction is so long that no triangle is beyond the
/// largest `t`.
pub(crate) fn upwards<P: Real>(point: Vec3<P>) -> Ray<P> {
    let d = Vec3::new(P::ZERO, P::ZERO, P::from_f64(4.0));
    Ray { o: point, d, tmin: P::ZERO, tmax: P::INFINITY }
}

/// The ray with its interval as leaves take it.
pub(crate) fn as_tested<P: Real>(ray: &Ray<P>) -> Ray<P> {
    let Interval { tmin, tmax } = Interval::of(ray);
    Ray { tmin, tmax, ..*ray }
}

/// The lanes of some bits.
fn lanes(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < WIDTH).then_some(lane)
    })
}

/// A hit in a block, with its slot in the place of the id.
fn found<P: Real>(block: &BlockHits<'_, P>, lane: usize) -> TriangleHit<P> {
    TriangleHit { triangle: slot(block.at, lane), hit: block.hit(lane) }
}

/// Counts triangles, each once.
struct Tally {
    count: u32,
    /// The ids of those that are met in several places of the tree.
    repeated: Vec<u32>,
}

thread_local! {
    /// Kept from ray to ray, so that none allocates. Not there while a ray counts.
    static REPEATED: Cell<Vec<u32>> = const { Cell::new(Vec::new()) };
}

impl Tally {
    /// How many triangles are added, since they were counted last.
    fn with(add: impl FnOnce(&mut Self)) -> u32 {
        let mut tally = Self { count: 0, repeated: REPEATED.take() };
        add(&mut tally);
        let count = tally.finish();
        REPEATED.set(tally.repeated);
        count
    }

    /// Counts those that have been added, and begins anew.
    fn finish(&mut self) -> u32 {
        let Self { count, repeated } = self;
        if !repeated.is_empty() {
            repeated.sort_unstable();
            repeated.dedup();
            #[allow(clippy::cast_possible_truncation, reason = "there are fewer triangles")]
            let more = repeated.len() as u32;
            *count += more;
            repeated.clear();
        }
        std::mem::take(count)
    }

    fn add<P>(&mut self, block: &BlockHits<'_, P>, met: u64) {
        self.count += (met & !block.repeated).count_ones();
        self.repeated.extend(lanes(met & block.repeated).map(|lane| block.triangles[lane]));
    }
}
