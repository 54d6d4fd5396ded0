//! What launches run, and what they leave out.
#![allow(missing_docs, reason = "tests")]

mod common;

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use common::{mesh, square};
use glam::{Affine3A, Vec3};
use trisect_core::Ray;
use trisect_method::Culling;
use trisect_pipeline::{
    Buffer, Builder, Entry, Exception, Geometry, Graph, Launch, Leaves, On, Place, Primitive,
    RayType, Scene, Sphere, Traces, Tracing, Verdict,
};
use trisect_tracer::Crossings;

/// Squares above each other, at 0, 1, 2 …, seen from above.
fn layers(count: u8) -> Scene<()> {
    let mut graph = Graph::new();
    let flat = graph.geometry(mesh(square(0.0, 1.0), Builder::Binned));
    let material = graph.material(());
    let flat = graph.instance(flat, material);
    let placed: Vec<_> = (0..count)
        .map(|y| graph.transform(Affine3A::from_translation(Vec3::Y * f32::from(y)), flat))
        .collect();
    let root = graph.group(placed);
    graph.commit(root).expect("it is placed")
}

fn down() -> Ray<f32> {
    Ray::new([0.3, 50.0, 0.1], [0.0, -1.0, 0.0])
}

struct Seen<const ANY: bool>;

impl<const ANY: bool> RayType for Seen<ANY> {
    /// How many hits were offered.
    type Payload = u32;
    const ANY: bool = ANY;
}

/// What a program for any hit answers, and what comes of it: the distance, and how many hits were offered.
struct Asks<V>(V);

impl<V: Fn(f32) -> Verdict + Sync> Entry for Asks<V> {
    type Material = ();
    type Rays = (Seen<false>, Seen<true>);
    /// Of each type; none where nothing was hit.
    type Out = [Option<(f32, u32)>; 2];
    type Append = ();

    fn generate(&self, _: [u32; 3], on: &mut On<'_, Self>) {
        on.send(Seen::<false>, down(), 0);
        on.send(Seen::<true>, down(), 0);
    }
}

impl<V: Fn(f32) -> Verdict + Sync> Traces<Seen<false>> for Asks<V> {
    const ANY_HIT: bool = true;

    fn any_hit(&self, at: &Place<'_, ()>, offered: &mut u32) -> Verdict {
        *offered += 1;
        (self.0)(at.t())
    }

    fn closest_hit(&self, at: &Place<'_, ()>, offered: u32, on: &mut On<'_, Self>) {
        on.out()[0] = Some((at.t(), offered));
    }
}

impl<V: Fn(f32) -> Verdict + Sync> Traces<Seen<true>> for Asks<V> {
    const ANY_HIT: bool = true;

    fn any_hit(&self, at: &Place<'_, ()>, offered: &mut u32) -> Verdict {
        *offered += 1;
        (self.0)(at.t())
    }

    fn blocked(&self, _: &Ray<f32>, offered: u32, on: &mut On<'_, Self>) {
        on.out()[1] = Some((0.0, offered));
    }
}

#[test]
fn any_hit_accepts_ignores_or_ends() {
    let scene = layers(4);
    let ask = |verdict: fn(f32) -> Verdict| {
        let mut out = Buffer::line(1, [None; 2]);
        scene.launch(&Asks(verdict), &Launch::default(), &mut out);
        out[[0; 3]]
    };
    // At 50, 49, 48 and 47.
    let [closest, any] = ask(|_| Verdict::Accept);
    assert_eq!(closest.map(|(t, _)| t), Some(47.0));
    assert_eq!(any, Some((0.0, 1)), "one is enough");
    assert_eq!(ask(|_| Verdict::Ignore), [None, None]);
    let [closest, any] = ask(|t| if t < 49.0 { Verdict::Ignore } else { Verdict::Accept });
    assert_eq!(closest.map(|(t, _)| t), Some(49.0));
    assert!(any.is_some());
    // Ended wherever it is: near ones come first, and no other is asked.
    let [closest, any] = ask(|_| Verdict::End);
    assert_eq!((closest.map(|(_, offered)| offered), any), (Some(1), Some((0.0, 1))));
    // All are offered where none is accepted.
    let count = AtomicU32::new(0);
    let counting = |_| {
        count.fetch_add(1, Ordering::Relaxed);
        Verdict::Ignore
    };
    let mut out = Buffer::line(1, [None; 2]);
    scene.launch(&Asks(counting), &Launch::default(), &mut out);
    assert_eq!(count.into_inner(), 8, "four for each of two rays");
}

/// Counts what it is offered: as light through panes, each of which may count once.
struct Counting<const ONCE: bool>(Ray<f32>);

impl<const ONCE: bool> Entry for Counting<ONCE> {
    type Material = ();
    type Rays = (Seen<true>,);
    type Out = u32;
    type Append = ();

    fn generate(&self, _: [u32; 3], on: &mut On<'_, Self>) {
        on.send(Seen::<true>, self.0, 0);
    }
}

impl<const ONCE: bool> Traces<Seen<true>> for Counting<ONCE> {
    const ANY_HIT: bool = true;
    const ONCE: bool = ONCE;

    fn any_hit(&self, _: &Place<'_, ()>, offered: &mut u32) -> Verdict {
        *offered += 1;
        Verdict::Ignore
    }

    fn miss(&self, _: &Ray<f32>, offered: u32, on: &mut On<'_, Self>) {
        *on.out() = offered;
    }
}

#[test]
fn where_space_is_split_a_program_with_effects_sees_each_shape_once() {
    let hall = trisect_workloads::hall();
    let mut graph = Graph::new();
    let geometry = mesh(hall.triangles.to_vec(), Builder::Spatial);
    let (references, triangles) = (geometry.tree().statistics().references, hall.triangles.len());
    assert!(references > triangles, "some are in several leaves");
    let geometry = graph.geometry(geometry);
    let material = graph.material(());
    let root = graph.instance(geometry, material);
    let scene = graph.commit(root).expect("it is placed");
    let mut more = 0;
    for ray in trisect_workloads::random_through_box(1, &hall, 300).rays {
        let hits = scene.tree().count(Tracing::Single, Culling::None, Crossings::Every, &ray);
        let launch = &Launch::default();
        let (mut once, mut often) = (Buffer::line(1, 0), Buffer::line(1, 0));
        scene.launch(&Counting::<true>(ray), launch, &mut once);
        scene.launch(&Counting::<false>(ray), launch, &mut often);
        assert_eq!(once.cells(), [hits]);
        assert!(often.cells()[0] >= hits);
        more += u32::from(often.cells()[0] > hits);
    }
    assert!(more > 0, "some would have been seen twice");
}

/// Throws where it is told to.
struct Throwing;

impl Entry for Throwing {
    type Material = ();
    type Rays = (Seen<false>,);
    type Out = Result<u32, Exception>;
    type Append = ();
    const CATCHES: bool = true;
    const ROUNDS: u32 = 2;

    fn generate(&self, [x, ..]: [u32; 3], on: &mut On<'_, Self>) {
        match x {
            0 => on.throw(42),
            1 => on.send(Seen, Ray::new([f32::NAN, 0.0, 0.0], [0.0, 1.0, 0.0]), 0),
            2 => on.send(Seen, Ray::new([0.0; 3], [0.0; 3]), 0),
            _ => on.send(Seen, down(), x),
        }
    }

    fn exception(&self, exception: Exception, out: &mut Self::Out) {
        *out = Err(exception);
    }
}

impl Traces<Seen<false>> for Throwing {
    fn closest_hit(&self, at: &Place<'_, ()>, left: u32, on: &mut On<'_, Self>) {
        *on.out() = Ok(on.round());
        if left > 3 {
            on.send(Seen, *at.ray(), left - 1);
        }
    }
}

#[test]
fn exceptions_are_caught_index_by_index() {
    let mut out = Buffer::line(8, Ok(99));
    layers(1).launch(&Throwing, &Launch::default(), &mut out);
    let expected = [
        Err(Exception::Thrown(42)),
        Err(Exception::BadRay),
        Err(Exception::BadRay),
        Ok(0),
        Ok(1),
        Ok(2),
        Err(Exception::TooDeep),
        Err(Exception::TooDeep),
    ];
    assert_eq!(out.cells(), expected);
}

/// In three dimensions: each index sends as many rays as its numbers say, and appends where they arrive.
struct Cube;

impl Entry for Cube {
    type Material = ();
    type Rays = (Seen<false>,);
    type Out = u32;
    type Append = ([u32; 3], u32);

    fn generate(&self, index: [u32; 3], on: &mut On<'_, Self>) {
        assert_eq!(index, on.index());
        for number in 0..index.iter().sum() {
            on.send(Seen, down(), number);
        }
    }
}

impl Traces<Seen<false>> for Cube {
    fn closest_hit(&self, _: &Place<'_, ()>, number: u32, on: &mut On<'_, Self>) {
        *on.out() += 1;
        on.append((on.index(), number));
        if number == 3 {
            on.send(Seen, down(), 100);
        }
    }
}

#[test]
fn what_is_appended_is_in_the_order_of_indices_whatever_the_threads_and_tiles() {
    let scene = layers(2);
    let run = |threads: usize, tile: u32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let launch = Launch { tile, ..Launch::default() };
        let mut out = Buffer::space([5, 4, 3], 10);
        let launched = pool.install(|| scene.launch(&Cube, &launch, &mut out));
        (out, launched)
    };
    let (out, launched) = run(1, 64);
    let mut expected = vec![];
    for (z, y, x) in (0..3).flat_map(|z| (0..4).flat_map(move |y| (0..5).map(move |x| (z, y, x)))) {
        let (index, sum) = ([x, y, z], x + y + z);
        expected.extend((0..sum).map(|number| (index, number)));
        expected.extend((sum > 3).then_some((index, 100)));
        assert_eq!(out[index], 10 + sum + u32::from(sum > 3), "what was there is added to");
    }
    assert_eq!(launched.appended, expected);
    assert_eq!(launched.rays, [expected.len() as u64]);
    for (threads, tile) in [(2, 1), (3, 2), (4, 3)] {
        assert_eq!(run(threads, tile), (out.clone(), launched.clone()), "{threads} {tile}");
    }
}

#[test]
fn a_launch_that_is_stopped_says_so() {
    let stop = AtomicBool::new(true);
    let launch = Launch { stop: Some(&stop), ..Launch::default() };
    let mut out = Buffer::space([2, 2, 2], 0);
    let launched = layers(1).launch(&Cube, &launch, &mut out);
    assert!(launched.is_stopped && launched.rays == [0]);
}

/// A shape that counts how often its attributes are computed.
struct Watched;

static NORMALS: AtomicU32 = AtomicU32::new(0);
static ATTRIBUTES: AtomicU32 = AtomicU32::new(0);

impl Primitive for Watched {
    type Shape = Sphere;
    type Attributes = f32;
    type Tree = Leaves<Self>;

    fn bounds(shape: &Sphere) -> [Vec3; 2] {
        Sphere::bounds(shape)
    }

    fn cross(shape: &Sphere, ray: &Ray<f32>, report: &mut dyn FnMut(trisect_core::Hit<f32>)) {
        Sphere::cross(shape, ray, report);
    }

    fn normal(shape: &Sphere, ray: &Ray<f32>, hit: &trisect_core::Hit<f32>) -> Vec3 {
        NORMALS.fetch_add(1, Ordering::Relaxed);
        Sphere::normal(shape, ray, hit)
    }

    fn attributes(_: &Sphere, _: &Ray<f32>, hit: &trisect_core::Hit<f32>) -> f32 {
        ATTRIBUTES.fetch_add(1, Ordering::Relaxed);
        hit.t
    }
}

/// Reads attributes, or does not.
struct Reading<const READS: bool>;

impl<const READS: bool> Entry for Reading<READS> {
    type Material = ();
    type Rays = (Seen<false>,);
    type Out = f32;
    type Append = ();

    fn generate(&self, _: [u32; 3], on: &mut On<'_, Self>) {
        on.send(Seen, down(), 0);
    }
}

impl<const READS: bool> Traces<Seen<false>> for Reading<READS> {
    fn closest_hit(&self, at: &Place<'_, ()>, _: u32, on: &mut On<'_, Self>) {
        *on.out() = if READS {
            at.attributes::<Watched>().map_or(0.0, |t| t + at.front().y)
        } else {
            at.t()
        };
    }
}

#[test]
fn attributes_are_computed_once_for_the_nearest_hit_and_only_where_they_are_read() {
    let balls = (0_u8..9).map(|y| Sphere { center: Vec3::Y * f32::from(y), radius: 1.0 }).collect();
    let geometry = Geometry::of::<Watched>(balls, Builder::Binned);
    let mut graph = Graph::new();
    let geometry = graph.geometry(geometry.expect("they are taken"));
    let material = graph.material(());
    let root = graph.instance(geometry, material);
    let scene = graph.commit(root).expect("it is placed");
    let mut out = Buffer::line(5, 0.0);
    let counts = || [&NORMALS, &ATTRIBUTES].map(|count| count.load(Ordering::Relaxed));
    scene.launch(&Reading::<false>, &Launch::default(), &mut out);
    assert!(out.cells()[0] > 40.0 && counts() == [0, 0], "{:?}", counts());
    scene.launch(&Reading::<true>, &Launch::default(), &mut out);
    assert_eq!(counts(), [5, 5]);
}
