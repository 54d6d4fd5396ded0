//! A tree over instances answers as asking every instance does, with the same carried rays, to the bit.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{Affine3A, Mat3, Quat, Vec3};
use trisect_core::{Ray, Triangle};
use trisect_exact::ExactInTrees;
use trisect_method::{Culling, Place};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_tracer::{
    Builder, Bvh, Crossings, EveryTriangle, InstanceError, Instances, RefitError, Tracing, Tree,
    TriangleHit, Update, Verdict,
};
use trisect_workloads::{Placement, Stream, Surface, bunny};

type Shared = Box<dyn Tree>;

/// The same scene in a tree over instances, and without one: all instances, all triangles.
struct Both {
    tree: Arc<Shared>,
    every: Every,
    /// Points that rays are aimed at.
    corners: Vec<Vec3>,
}

enum Every {
    Mesh(Arc<EveryTriangle<ExactInTrees>>),
    /// Each with where its triangles begin.
    Instances(Arc<Vec<(Both, trisect_tracer::Transform, u32)>>),
}

impl Clone for Both {
    fn clone(&self) -> Self {
        let every = match &self.every {
            Every::Mesh(mesh) => Every::Mesh(Arc::clone(mesh)),
            Every::Instances(instances) => Every::Instances(Arc::clone(instances)),
        };
        Self { tree: Arc::clone(&self.tree), every, corners: self.corners.clone() }
    }
}

impl Both {
    fn mesh(triangles: &[Triangle<f32>]) -> Self {
        let tree = Bvh::<ExactInTrees>::build(triangles, Builder::Binned).expect("it takes all");
        let every = EveryTriangle::new(triangles).expect("it takes all");
        let corners = triangles.iter().flat_map(|triangle| triangle.corners());
        Self {
            tree: Arc::new(Box::new(tree)),
            every: Every::Mesh(Arc::new(every)),
            corners: corners.map(Vec3::from).collect(),
        }
    }

    fn instances(placed: &[(Self, Affine3A)]) -> Self {
        let tree = Instances::new(placed.iter().map(|(of, at)| (Arc::clone(&of.tree), *at)));
        let tree = tree.expect("they are sound");
        let mut first = 0;
        let every = placed.iter().zip(tree.instances()).map(|((of, _), instance)| {
            let each = (of.clone(), *instance.transform(), first);
            first += of.count();
            each
        });
        let every = Every::Instances(Arc::new(every.collect()));
        let corners = placed.iter().flat_map(|(of, at)| {
            of.corners.iter().step_by(3).map(|&corner| at.transform_point3(corner))
        });
        Self { every, corners: corners.collect(), tree: Arc::new(Box::new(tree)) }
    }

    fn count(&self) -> u32 {
        match &self.every {
            Every::Mesh(every) => u32::try_from(every.statistics().references).expect("few"),
            Every::Instances(every) => every.iter().map(|(of, ..)| of.count()).sum(),
        }
    }

    /// All hits, instance by instance, and of each in exact order.
    fn all(&self, culling: Culling, crossings: Crossings, ray: &Ray<f32>) -> Vec<TriangleHit> {
        match &self.every {
            Every::Mesh(every) => {
                let mut hits = vec![];
                every.all(Tracing::Plain, culling, crossings, ray, &mut hits);
                hits
            }
            Every::Instances(every) => {
                let all = every.iter().flat_map(|(of, transform, first)| {
                    let hits = of.all(culling, crossings, &transform.carry(ray));
                    hits.into_iter()
                        .map(move |hit| TriangleHit { triangle: first + hit.triangle, ..hit })
                });
                let mut all: Vec<TriangleHit> = all.collect();
                // Stable: by the rounded `t`, then by instance, then in the order there.
                all.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t));
                all
            }
        }
    }
}

fn numbers(stream: &mut Stream) -> Vec3 {
    #[allow(clippy::cast_possible_truncation, reason = "rounds")]
    let numbers = stream.cube().map(|x| x as f32);
    Vec3::from(numbers)
}

/// Turned, stretched unevenly by up to a thousand times, mirrored, sheared, and elsewhere.
fn transform(stream: &mut Stream, size: f32) -> Affine3A {
    let turn = |stream: &mut Stream| {
        let axis = numbers(stream).normalize_or(Vec3::X);
        Mat3::from_quat(Quat::from_axis_angle(axis, 7.0 * numbers(stream).x))
    };
    let stretch = (numbers(stream) * 3.0).to_array().map(f32::exp);
    let mirror = numbers(stream).to_array().map(f32::signum);
    let stretch = Mat3::from_diagonal(Vec3::from(stretch) * Vec3::from(mirror));
    let place = numbers(stream) * (3.0 * size);
    Affine3A::from_mat3_translation(turn(stream) * stretch * turn(stream) * size, place)
}

fn soup(stream: &mut Stream, count: usize) -> Vec<Triangle<f32>> {
    let mut triangle = || {
        let a = numbers(stream);
        Triangle::new(a, a + numbers(stream) * 0.5, a + numbers(stream) * 0.5)
    };
    (0..count).map(|_| triangle()).collect()
}

/// Rays through corners, along edges and anywhere, from near, from inside and from afar.
fn rays(stream: &mut Stream, of: &Both, count: usize) -> Vec<Ray<f32>> {
    let size =
        of.corners.iter().fold(0.0, |size: f32, corner| size.max(corner.abs().max_element()));
    let pick = |stream: &mut Stream| {
        let share = (numbers(stream).x + 1.0) * 0.5;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
        let at = (share * of.corners.len() as f32) as usize;
        of.corners[at.min(of.corners.len() - 1)]
    };
    let ray = |number: usize| {
        let (at, other) = (pick(stream), pick(stream));
        let from = numbers(stream) * size;
        match number % 8 {
            0 => Ray::new(from, at - from),
            1 => Ray::new(at, other - at),
            2 => Ray::new(from * 1e5, at - from * 1e5),
            3 => Ray::new(from * 300.0, (at.lerp(other, 0.5) - from * 300.0).normalize()),
            4 => {
                let axis = Vec3::AXES[number / 8 % 3];
                Ray::new(at - axis * (size * 4.0), axis)
            }
            5 => Ray::new(from, (at - from) * 1e-25),
            6 => Ray::new(from * 2e3, (at - from * 2e3) * 1e15).with_interval(-1.0, 0.5),
            _ => Ray::new(from, numbers(stream)),
        }
    };
    (0..count).map(ray).collect()
}

/// Every query of the tree answers as every triangle of every instance does.
fn agree(of: &Both, rays: &[Ray<f32>], what: &str) -> usize {
    let tree = &**of.tree;
    let mut hits = 0;
    for culling in [Culling::None, Culling::Back, Culling::Front] {
        let all: Vec<_> = rays.iter().map(|ray| of.all(culling, Crossings::Every, ray)).collect();
        let firsts: Vec<_> = all.iter().map(|all| all.first().copied()).collect();
        for tracing in [Tracing::Single, Tracing::Packets, Tracing::Plain] {
            let (mut found, mut any) = (vec![None; rays.len()], vec![false; rays.len()]);
            tree.closest(tracing, culling, rays, &mut found);
            tree.any(tracing, culling, rays, &mut any);
            for (at, ray) in rays.iter().enumerate() {
                assert_eq!(found[at], firsts[at], "{what}, {tracing:?}, {culling:?}: {ray:?}");
                assert_eq!(any[at], firsts[at].is_some(), "{what}, {tracing:?}: {ray:?}");
            }
        }
        for (ray, all) in rays.iter().zip(&all) {
            let what = format!("{what}, {culling:?}: {ray:?}");
            hits += all.len();
            let first = all.first().copied();
            assert_eq!(tree.closest_hit(culling, ray).found(), first, "{what}");
            assert_eq!(tree.any_hit(culling, ray), first.is_some(), "{what}");
            let mut found = vec![];
            tree.all(Tracing::Single, culling, Crossings::Every, ray, &mut found);
            assert_eq!(&found, all, "{what}");
            assert_eq!(
                tree.count(Tracing::Plain, culling, Crossings::Every, ray) as usize,
                all.len()
            );
            let owned = of.all(culling, Crossings::Owned, ray).len();
            let count = tree.count(Tracing::Single, culling, Crossings::Owned, ray) as usize;
            assert_eq!(count, owned, "{what}");
            // The first whose id is even; and one that is left out.
            let mut accepted = f32::INFINITY;
            let even = tree.filtered(Tracing::Single, culling, ray, &mut |hit| {
                assert!(hit.hit.t <= accepted, "offered behind what was accepted, {what}");
                if hit.triangle % 2 == 1 {
                    return Verdict::Ignore;
                }
                accepted = hit.hit.t;
                Verdict::Accept
            });
            assert_eq!(even, all.iter().find(|hit| hit.triangle % 2 == 0).copied(), "{what}");
            if let Some(first) = first {
                let but = tree.closest_but(Tracing::Single, culling, ray, first.triangle);
                assert_eq!(but, all.get(1).copied(), "{what}");
                let mut offered = 0;
                let ended = tree.filtered(Tracing::Single, culling, ray, &mut |_| {
                    offered += 1;
                    Verdict::End
                });
                assert!(offered == 1 && all.contains(&ended.expect("one is offered")), "{what}");
            }
            if culling == Culling::None {
                assert_eq!(tree.inspect(ray).found, first, "{what}");
                let mut candidates = BTreeSet::new();
                tree.candidates(ray, &mut |id| {
                    candidates.insert(id);
                    ray.tmax
                });
                assert!(all.iter().all(|hit| candidates.contains(&hit.triangle)), "{what}");
            }
        }
    }
    hits
}

#[test]
fn random_scenes_answer_as_every_triangle_of_every_instance() {
    let (mut hits, mut far) = (0, 0);
    for seed in 0..40_u8 {
        let stream = &mut Stream::new("instances", seed.into());
        let meshes = [1, 3, 20, 60].map(|count| Both::mesh(&soup(stream, count)));
        // From a thousandth to a million.
        let size = 10_f32.powf(1.5 + 4.5 * numbers(stream).x);
        let count = [1, 2, 9, 30][usize::from(seed) % 4];
        let mut placed: Vec<(Both, Affine3A)> =
            (0..count).map(|at| (meshes[at % 4].clone(), transform(stream, size))).collect();
        if seed % 3 == 0 {
            placed[0].1 = Affine3A::IDENTITY;
        }
        let one = Both::instances(&placed);
        let of_one = rays(stream, &one, 80);
        hits += agree(&one, &of_one, &format!("one level, {seed}"));
        let mut placed: Vec<(Both, Affine3A)> =
            (0..4).map(|_| (one.clone(), transform(stream, 3.0))).collect();
        placed.push((meshes[3].clone(), transform(stream, size)));
        let two = Both::instances(&placed);
        let of_two = rays(stream, &two, 80);
        far += of_two.iter().filter(|ray| Vec3::from(ray.o).length() > 1e3 * size).count();
        hits += agree(&two, &of_two, &format!("two levels, {seed}"));
        let three =
            Both::instances(&[(two, transform(stream, 0.1)), (one, transform(stream, 2.0))]);
        let of_three = rays(stream, &three, 40);
        hits += agree(&three, &of_three, &format!("three levels, {seed}"));
    }
    assert!(hits > 15_000 && far > 100, "{hits} hits, {far} from afar");
}

/// Two copies of a wall that touch: a ray through their common edge may miss both, or hit both, as it is carried to each;
/// here the transforms round nothing, so that it hits what a mesh of both would have.
#[test]
fn where_carrying_rounds_nothing_instances_are_one_mesh() {
    let wall = Surface::square(4).triangles::<f32>(&Placement::HERE);
    let tree = || Bvh::<ExactInTrees>::build(&wall, Builder::Binned).expect("it takes all");
    let tree: Arc<Shared> = Arc::new(Box::new(tree()));
    let moves = [Vec3::ZERO, Vec3::new(16.0, 0.0, 0.0), Vec3::new(-8.0, 4.0, 2.0)];
    let placed = moves.map(|by| (Arc::clone(&tree), Affine3A::from_translation(by)));
    let instances = Instances::new(placed).expect("they are sound");
    let flat: Vec<Triangle<f32>> = moves
        .iter()
        .flat_map(|&by| {
            wall.iter().map(move |triangle| {
                let [a, b, c] = triangle.corners().map(|corner| Vec3::from(corner) + by);
                Triangle::new(a, b, c)
            })
        })
        .collect();
    let flat = Bvh::<ExactInTrees>::build(&flat, Builder::Binned).expect("it takes all");
    let mut hits = 0;
    for at in 0..2000_u16 {
        let step = |by: u16, of: u16| f32::from(at / by % of) / 8.0;
        let o = Vec3::new(step(1, 64) - 4.0, step(7, 32) - 2.0, 4.0);
        let ray = Ray::new(o, Vec3::new(step(3, 5), -step(5, 3), -1.0));
        let found = instances.closest_hit(Culling::None, &ray).found();
        assert_eq!(found, flat.closest_hit(Culling::None, &ray).found(), "{ray:?}");
        hits += usize::from(found.is_some());
    }
    assert!(hits > 200, "{hits}");
}

#[test]
fn points_are_inside_as_the_instances_say() {
    let ball = Surface::sphere(2).triangles::<f32>(&Placement::HERE);
    let tree: Arc<Shared> =
        Arc::new(Box::new(Bvh::<ExactInTrees>::build(&ball, Builder::Binned).expect("all")));
    let stream = &mut Stream::new("inside", 1);
    let placed: Vec<_> = (0..12).map(|_| (Arc::clone(&tree), transform(stream, 1.0))).collect();
    let instances = Instances::new(placed).expect("they are sound");
    let mut counts = [0; 3];
    for number in 0..4000 {
        let mut point: trisect_core::Vec3<f32> = (numbers(stream) * 4.0).into();
        if number % 8 == 0 {
            // A corner, which may be on it, if rounding permits.
            let corner = ball[number % ball.len()].a;
            let to_world = instances.instances()[number % 12].transform().to_world();
            point = to_world.transform_point3(corner.into()).into();
        }
        let mut places = vec![];
        for instance in instances.instances() {
            let carried = instance.transform().carry_point(point);
            places.push(instance.of().contains(carried).expect("it is exact"));
        }
        let inside = places.iter().filter(|place| **place == Place::Inside).count();
        let expected = if places.contains(&Place::On) {
            Place::On
        } else if inside % 2 == 1 {
            Place::Inside
        } else {
            Place::Outside
        };
        assert_eq!(instances.contains(point), Ok(expected), "{point:?}");
        counts[expected as usize] += 1;
    }
    assert!(counts.iter().filter(|count| **count > 100).count() >= 2, "{counts:?}");
    let rounds = Bvh::<MollerTrumbore>::build(&ball, Builder::Binned).expect("all");
    let rounds: Arc<Shared> = Arc::new(Box::new(rounds));
    let mixed = Instances::new([(tree, Affine3A::IDENTITY), (rounds, Affine3A::IDENTITY)]);
    let mixed = mixed.expect("they are sound");
    assert!(mixed.contains(trisect_core::Vec3::new(9.0, 0.0, 0.0)).is_err());
}

#[test]
fn a_scene_that_moves_answers_as_a_new_one() {
    let stream = &mut Stream::new("moving", 1);
    let mesh = Both::mesh(&soup(stream, 20));
    let small = |stream: &mut Stream| {
        let mut small = transform(stream, 1.0);
        small.matrix3 *= 0.02;
        small
    };
    let mut placed: Vec<(Both, Affine3A)> =
        (0..200).map(|_| (mesh.clone(), small(stream))).collect();
    let trees = |placed: &[(Both, Affine3A)]| -> Vec<_> {
        placed.iter().map(|(of, at)| (Arc::clone(&of.tree), *at)).collect()
    };
    let mut moving = Instances::new(trees(&placed)).expect("they are sound");
    let mut updates = BTreeSet::new();
    for round in 0..20 {
        let update = if round % 2 == 0 {
            let by = Vec3::splat(0.01);
            for (_, at) in &mut placed {
                *at = Affine3A::from_translation(by) * *at;
            }
            moving.set_transforms(placed.iter().map(|(_, at)| *at))
        } else if round < 17 {
            placed[round].1 = small(stream);
            moving.set_transform(round, placed[round].1)
        } else {
            for (_, at) in &mut placed {
                *at = small(stream);
            }
            moving.set_transforms(placed.iter().map(|(_, at)| *at))
        };
        let update = update.expect("they are sound");
        if let Update::Refitted { cost } = update {
            assert!(cost <= 1.25, "{cost}");
        }
        updates.insert(update == Update::Rebuilt);
        let new = Instances::new(trees(&placed)).expect("they are sound");
        if update == Update::Rebuilt {
            assert_eq!(moving.statistics(), new.statistics());
        }
        let of = Both::instances(&placed);
        for ray in rays(stream, &of, 200) {
            assert_eq!(
                moving.closest_hit(Culling::None, &ray).found(),
                new.closest_hit(Culling::None, &ray).found()
            );
        }
    }
    assert_eq!(updates.len(), 2, "both happen");
}

#[test]
fn what_cannot_be_placed_is_refused_by_name() {
    let triangle = Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let tree = Bvh::<MollerTrumbore>::build(&[triangle], Builder::Binned).expect("it takes all");
    let tree: Arc<Shared> = Arc::new(Box::new(tree));
    let place =
        |at: &[Affine3A]| Instances::new(at.iter().map(|at| (Arc::clone(&tree), *at))).map(|_| ());
    let sound = Affine3A::IDENTITY;
    let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let message = place(&[sound, flat]).expect_err("it flattens").to_string();
    assert_eq!(
        message,
        "the transform of instance 1 is singular, as far as f32 can tell: it flattens what it places; its rows are \
         [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]"
    );
    let nearly =
        Mat3::from_cols(Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.0 + 1e-7, 0.0), Vec3::Z);
    let nearly = Affine3A::from_mat3(nearly);
    assert!(matches!(place(&[nearly]), Err(InstanceError::Singular { instance: 0, .. })));
    for number in [f32::NAN, f32::INFINITY] {
        let mut broken = sound;
        broken.translation.y = number;
        let error = place(&[sound, sound, broken]);
        assert!(matches!(error, Err(InstanceError::NotFinite { instance: 2, .. })), "{error:?}");
    }
    // Stretched by as much as there is room for is not singular.
    for stretch in [Vec3::new(1.0, 1e-20, 1e20), Vec3::splat(1e-30), Vec3::splat(1e30)] {
        place(&[Affine3A::from_scale(stretch)]).expect("it has an inverse");
    }
    let mut scene = Instances::new([(Arc::clone(&tree), sound)]).expect("it is sound");
    let error = scene.set_transforms([sound, sound]);
    assert_eq!(error, Err(InstanceError::Count { instances: 1, given: 2 }));
    assert!(scene.set_transform(0, flat).is_err());
    assert_eq!(*scene.instances()[0].transform().to_world(), sound);
    assert_eq!(scene.refit(&[triangle]), Err(RefitError::Placed));
    let mut deep: Shared = Box::new(scene);
    for _ in 1..16 {
        deep = Box::new(Instances::new([(Arc::new(deep), sound)]).expect("there may be as many"));
    }
    let ray = Ray::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
    assert!(deep.any_hit(Culling::None, &ray));
    let deeper = Instances::new([(Arc::new(deep), sound)]).map(|_| ());
    assert_eq!(deeper, Err(InstanceError::TooDeep { instance: 0 }));
    // Fifteen times doubled 2¹⁵ times is too many.
    let mut many: Shared = Box::new(place_many(&tree, 1 << 12));
    many = Box::new(place_many(&Arc::new(many), 1 << 12));
    let error = Instances::new((0..1 << 8).map({
        let many = Arc::new(many);
        move |_| (Arc::clone(&many), sound)
    }));
    assert!(matches!(error.map(|_| ()), Err(InstanceError::TooMany { instance: 255 })));
}

fn place_many(of: &Arc<Shared>, count: usize) -> Instances<Shared> {
    let at = |_| (Arc::clone(of), Affine3A::IDENTITY);
    Instances::new((0..count).map(at)).expect("there may be as many")
}

#[test]
fn what_is_shared_counts_once() {
    let bunny = bunny();
    let tree = Bvh::<MollerTrumbore>::build(&bunny.triangles, Builder::Binned).expect("all");
    let own = tree.statistics().bytes;
    let tree: Arc<Shared> = Arc::new(Box::new(tree));
    let pairs = [1.0, 2.0].map(|x| (Arc::clone(&tree), Affine3A::from_translation(Vec3::X * x)));
    let pair: Arc<Shared> = Arc::new(Box::new(Instances::new(pairs).expect("they are sound")));
    let other = [(Arc::clone(&tree), Affine3A::from_scale(Vec3::splat(-2.0)))];
    let other: Arc<Shared> = Arc::new(Box::new(Instances::new(other).expect("they are sound")));
    let all = [pair, other, tree].map(|of| (of, Affine3A::IDENTITY));
    let all = Instances::new(all).expect("they are sound").statistics();
    assert!(all.bytes > own && all.bytes < own + 4000, "{} and {own}", all.bytes);
}
