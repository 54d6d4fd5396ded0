//! Nodes, variables, and what becomes of a graph when it is committed.
#![allow(missing_docs, reason = "tests")]

mod common;

use common::{add, mesh, square};
use glam::{Affine3A, Quat, Vec3};
use trisect_core::Ray;
use trisect_method::Culling;
use trisect_pipeline::random::Random;
use trisect_pipeline::{
    Builder, Change, CommitError, Disc, Geometry, Graph, GraphError, NodeId, Parallelogram,
    Primitive, ReshapeError, Scene, Scope, Shell, ShellSide, Sphere, Tracing, Update,
};
use trisect_tracer::Crossings;

/// Down from high above.
fn down(x: f32, z: f32) -> Ray<f32> {
    Ray::new([x, 50.0, z], [0.0, -1.0, 0.0])
}

/// The instance that is seen from above, and its distance.
fn seen<M>(scene: &Scene<M>, x: f32, z: f32) -> Option<(NodeId, f32)> {
    let at = scene.closest(Culling::None, &down(x, z));
    assert_eq!(at.is_some(), scene.is_blocked(Culling::None, &down(x, z)));
    at.map(|at| (at.node(), at.t()))
}

fn moved(x: f32, y: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::new(x, y, 0.0))
}

#[test]
fn transforms_and_groups_place_what_is_below_them() {
    let mut graph = Graph::new();
    let ball = add::<Sphere, _>(&mut graph, Sphere { center: Vec3::ZERO, radius: 1.0 }, ());
    let flat = graph.geometry(mesh(square(0.0, 1.0), Builder::Binned));
    let material = graph.material(());
    let flat = graph.instance(flat, material);
    let high = graph.transform(moved(0.0, 2.0), ball);
    let pair = graph.group([high, flat]);
    // Twice as large, and turned so that up is to the right and forth up.
    let turned = Affine3A::from_scale_rotation_translation(
        Vec3::splat(2.0),
        Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2),
        Vec3::new(10.0, 0.0, 0.0),
    );
    let other = graph.transform(turned, pair);
    let root = graph.group([pair, other]);
    let scene = graph.commit(root).expect("it is placed");
    assert_eq!(scene.instances(), 4);
    assert_eq!(seen(&scene, 0.0, 0.0), Some((ball, 47.0)));
    assert_eq!(seen(&scene, 0.9, 0.9), Some((flat, 50.0)));
    // The ball, which was 2 above, is 4 to the right there, with a radius of 2.
    let (node, t) = seen(&scene, 14.0, 0.0).expect("the ball");
    assert!(node == ball && (t - 48.0).abs() < 1e-4, "{t}");
    let at = scene.closest(Culling::None, &down(14.0 + 1.2, 0.0)).expect("the ball");
    assert!((at.front() - Vec3::new(0.6, 0.8, 0.0)).length() < 1e-4, "{}", at.front());
    assert_eq!(seen(&scene, 5.0, 0.0), None);
    // From any node.
    let scene = scene.edit().commit(flat).expect("it is placed");
    assert_eq!(seen(&scene, 0.0, 0.0), Some((flat, 50.0)));
    assert_eq!(scene.instances(), 1);
}

#[test]
fn instances_share_a_geometry_each_with_its_material() {
    let mut graph = Graph::new();
    let flat = graph.geometry(mesh(square(0.0, 1.0), Builder::Binned));
    let (red, blue) = (graph.material("red"), graph.material("blue"));
    let (one, two) = (graph.instance(flat, red), graph.instance(flat, blue));
    let two = graph.transform(moved(5.0, 0.0), two);
    let root = graph.group([one, two]);
    let scene = graph.commit(root).expect("it is placed");
    let material = |scene: &Scene<&'static str>, x| {
        scene.closest(Culling::None, &down(x, 0.0)).map(|at| *at.material())
    };
    assert_eq!([0.0, 5.0, 9.0].map(|x| material(&scene, x)), [Some("red"), Some("blue"), None]);
    // The tree is counted once.
    let tree = scene.geometry(flat).tree().statistics().bytes;
    assert!(scene.tree().statistics().bytes < 2 * tree + 4096);
    let mut graph = scene.edit();
    graph.set_material(one, blue).expect("an instance");
    let scene = graph.commit(root).expect("it is placed");
    assert_eq!(material(&scene, 0.0), Some("blue"));
}

#[test]
fn a_selector_chooses_for_each_ray() {
    let mut graph = Graph::new();
    let fine = add::<Sphere, _>(&mut graph, Sphere { center: Vec3::ZERO, radius: 1.0 }, "fine");
    let coarse = Disc { center: Vec3::ZERO, normal: Vec3::Y, radius: 1.0 };
    let coarse = add::<Disc, _>(&mut graph, coarse, "coarse");
    // By the distance of the origin in its own space; nothing from very far.
    let visit = |ray: &Ray<f32>| match Vec3::from(ray.o).length() {
        ..10.0 => 0,
        ..100.0 => 1,
        _ => 9,
    };
    let choice = graph.selector(visit, [fine, coarse]);
    let other = graph.transform(moved(30.0, 0.0), choice);
    let root = graph.group([choice, other]);
    let scene = graph.commit(root).expect("it is placed");
    let from = |x: f32, y: f32| {
        let at = scene.closest(Culling::None, &Ray::new([x, y, 0.1], [0.0, -1.0, 0.0]));
        let rays = [Ray::new([x, y, 0.1], [0.0, -1.0, 0.0]); 9];
        let mut found = [None; 9];
        scene.tree().closest(Tracing::Single, Culling::None, &rays, &mut found);
        assert_eq!(found[8].map(|hit| hit.triangle), at.map(|at| at.number()));
        at.map(|at| (*at.material(), at.instance()))
    };
    assert_eq!(from(0.0, 5.0), Some(("fine", 0)));
    assert_eq!(from(0.0, 20.0), Some(("coarse", 1)));
    assert_eq!(from(0.0, 200.0), None);
    assert_eq!(from(30.0, 5.0), Some(("fine", 2)));
    assert_eq!(from(30.0, 20.0), Some(("coarse", 3)));
}

#[test]
fn moved_transforms_fit_the_tree_and_reshaped_geometries_theirs() {
    let mut graph = Graph::new();
    let flat = graph.geometry(mesh(square(0.0, 1.0), Builder::Binned));
    // In a row; the step says in what order.
    let row = |step: u16, up: f32| {
        let center = move |at: u16| Vec3::new(f32::from(at * step % 64) * 4.0, up, 0.0);
        (0..64).map(|at| Sphere { center: center(at), radius: 1.0 }).collect::<Vec<_>>()
    };
    let balls = Geometry::of::<Sphere>(row(1, 0.0), Builder::Binned);
    let balls = graph.geometry(balls.expect("they are taken"));
    let material = graph.material(());
    let (square_node, balls_node) =
        (graph.instance(flat, material), graph.instance(balls, material));
    let mover = graph.transform(moved(0.0, 0.0), square_node);
    let aside = graph.transform(moved(20.0, 0.0), balls_node);
    let root = graph.group([mover, aside]);
    let scene = graph.commit(root).expect("it is placed");
    assert_eq!(scene.update(), Update::Rebuilt);

    let mut graph = scene.edit();
    graph.set_transform(mover, moved(0.5, 3.0)).expect("a transform");
    let scene = graph.commit(root).expect("it is placed");
    assert!(matches!(scene.update(), Update::Refitted { .. }));
    assert_eq!(seen(&scene, 1.4, 0.0), Some((square_node, 47.0)));

    let mut graph = scene.edit();
    let update = graph.reshape(flat, square(1.0, 1.0), Change::Refit);
    assert!(matches!(update, Ok(Update::Refitted { .. })), "{update:?}");
    let update = graph.reshape(flat, square(1.0, 1.0), Change::Rebuild);
    assert_eq!(update, Ok(Update::Rebuilt));
    let update = graph.reshape(balls, row(1, 1.0), Change::AsNeeded);
    assert!(matches!(update, Ok(Update::Refitted { .. })), "{update:?}");
    // Neighbours are far apart from now on: the tree is worn.
    assert_eq!(graph.reshape(balls, row(37, 0.0), Change::AsNeeded), Ok(Update::Rebuilt));
    // What cannot be is an error, and nothing has changed.
    assert_eq!(graph.reshape(balls, square(0.0, 1.0), Change::Refit), Err(ReshapeError::OtherKind));
    let fewer = row(1, 0.0)[..2].to_vec();
    assert!(matches!(graph.reshape(balls, fewer, Change::Refit), Err(ReshapeError::Refit(_))));
    let scene = graph.commit(root).expect("it is placed");
    assert_eq!(scene.update(), Update::Rebuilt);
    assert_eq!(seen(&scene, 1.4, 0.0), Some((square_node, 46.0)));
    assert_eq!(seen(&scene, 28.0, 0.0), Some((balls_node, 49.0)));
    assert_eq!(seen(&scene, 26.0, 0.0), None);
}

#[test]
fn variables_are_those_of_the_innermost_scope() {
    let mut graph = Graph::new();
    let flat = graph.geometry(mesh(square(0.0, 1.0), Builder::Binned));
    let (red, blue) = (graph.material(()), graph.material(()));
    let nodes: Vec<NodeId> = [red, red, blue].map(|of| graph.instance(flat, of)).into();
    let placed: Vec<NodeId> = (0_u8..3)
        .zip(&nodes)
        .map(|(at, &node)| graph.transform(moved(f32::from(at) * 5.0, 0.0), node))
        .collect();
    let root = graph.group(placed);
    let color = graph.variable::<Vec3>("color");
    let count = graph.variable::<u32>("count");
    graph.set(Scope::Context, count, 7);
    graph.set(Scope::Material(red), color, Vec3::X);
    let Err(uncommitted) = graph.commit(root) else { panic!("blue has no colour") };
    let unset = CommitError::Unset { variable: "color".into(), node: nodes[2].number() };
    assert_eq!(uncommitted.error, unset);
    let message = uncommitted.to_string();
    assert!(message.starts_with("variable `color` has no value at node 2: set it"), "{message}");
    // It comes back, and can be mended.
    let mut graph = uncommitted.graph;
    graph.set(Scope::Context, color, Vec3::Z);
    graph.set(Scope::Instance(nodes[1]), color, Vec3::Y);
    let scene = graph.commit(root).expect("it is placed");
    let at = |scene: &Scene<()>, x: f32| {
        let at = scene.closest(Culling::None, &down(x, 0.0)).expect("a square");
        (at.get(color), at.get(count))
    };
    assert_eq!(at(&scene, 0.0), (Vec3::X, 7));
    assert_eq!(at(&scene, 5.0), (Vec3::Y, 7));
    assert_eq!(at(&scene, 10.0), (Vec3::Z, 7));
    assert_eq!((scene.value(color), scene.value(count)), (Some(Vec3::Z), Some(7)));
    // That of a geometry goes before that of a material.
    let mut graph = scene.edit();
    graph.set(Scope::Geometry(flat), color, Vec3::ONE);
    let scene = graph.commit(root).expect("it is placed");
    assert_eq!([0.0, 5.0].map(|x| at(&scene, x).0), [Vec3::ONE, Vec3::Y]);
}

#[test]
fn what_cannot_be_committed_is_an_error_that_names_the_node() {
    let base = || {
        let mut graph = Graph::new();
        let ball = add::<Sphere, _>(&mut graph, Sphere { center: Vec3::ZERO, radius: 1.0 }, ());
        let group = graph.group([ball]);
        (graph, ball, group)
    };
    let (mut graph, _, group) = base();
    let above = graph.transform(Affine3A::IDENTITY, group);
    graph.set_children(group, [above]).expect("a group");
    let error = graph.commit(group).err().map(|uncommitted| uncommitted.error);
    assert_eq!(error, Some(CommitError::Cycle { node: group.number() }));

    let (mut graph, ball, _) = base();
    let chain = (0..300).fold(ball, |below, _| graph.transform(Affine3A::IDENTITY, below));
    let error = graph.commit(chain).err().map(|uncommitted| uncommitted.error);
    assert!(matches!(error, Some(CommitError::TooDeep { .. })), "{error:?}");

    let (mut graph, ball, _) = base();
    let flattened = graph.transform(Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0)), ball);
    let error = graph.commit(flattened).err().expect("it has no inverse").error;
    assert!(matches!(error, CommitError::Place { node, .. } if node == ball.number()), "{error}");

    let (mut graph, ball, group) = base();
    let not = GraphError::NotTransform(ball.number());
    assert_eq!(graph.set_transform(ball, Affine3A::IDENTITY), Err(not));
    assert_eq!(graph.set_children(ball, []), Err(GraphError::NotGroup(ball.number())));
    let material = graph.material(());
    assert_eq!(graph.set_material(group, material), Err(GraphError::NotInstance(group.number())));
}

#[test]
fn nothing_is_seen_of_nothing() {
    let mut graph = Graph::<()>::new();
    let root = graph.group([]);
    let scene = graph.commit(root).expect("there is nothing to place");
    assert_eq!(scene.instances(), 0);
    assert_eq!(seen(&scene, 0.0, 0.0), None);
}

/// Shapes against what is known of them.
#[test]
fn shapes_are_met_where_they_are() {
    let hits = |scene: &Scene<()>, ray: &Ray<f32>| {
        let mut hits = vec![];
        let every = Crossings::Every;
        let single = Tracing::Single;
        scene.tree().all(single, Culling::None, every, ray, &mut hits);
        assert_eq!(scene.tree().count(single, Culling::None, every, ray) as usize, hits.len());
        hits.into_iter().map(|hit| hit.hit.t).collect::<Vec<_>>()
    };
    let alone = |graph: &mut Graph<()>, node| std::mem::take(graph).commit(node).expect("placed");
    // A direction of length 2: `t` counts in lengths of it.
    let ray = Ray::new([0.0, 0.0, 8.0], [0.0, 0.0, -2.0]);
    let mut graph = Graph::new();
    let shell = Shell { center: Vec3::ZERO, inner: 1.0, outer: 2.0 };
    let node = add::<Shell, _>(&mut graph, shell, ());
    let scene = alone(&mut graph, node);
    assert_eq!(hits(&scene, &ray), [3.0, 3.5, 4.5, 5.0]);
    let inside = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
    let at = scene.closest(Culling::None, &inside).expect("the inner side");
    assert_eq!((at.t(), at.front()), (1.0, Vec3::NEG_Z));
    assert_eq!(at.attributes::<Shell>(), Some(ShellSide::Inner));
    assert_eq!(at.attributes::<Sphere>(), None);

    let shape = Parallelogram { corner: Vec3::NEG_ONE, u: Vec3::X * 2.0, v: Vec3::Y * 4.0 };
    let node = add::<Parallelogram, _>(&mut graph, shape, ());
    let scene = alone(&mut graph, node);
    let at = scene.closest(Culling::None, &ray).expect("it is met");
    assert_eq!((at.t(), at.front()), (4.5, Vec3::Z));
    assert_eq!(at.attributes::<Parallelogram>(), Some(glam::Vec2::new(0.5, 0.25)));
    // Its back is not seen where backs are not.
    let from_behind = Ray::new([0.0, 0.0, -8.0], [0.0, 0.0, 2.0]);
    assert!(scene.closest(Culling::Back, &ray).is_some());
    assert!(scene.closest(Culling::Back, &from_behind).is_none());
    assert!(scene.closest(Culling::Front, &from_behind).is_some());
    assert_eq!(hits(&scene, &ray.with_interval(0.0, 4.0)), [0.0; 0]);

    let disc = Disc { center: Vec3::ZERO, normal: Vec3::Z, radius: 2.0 };
    let node = add::<Disc, _>(&mut graph, disc, ());
    let scene = alone(&mut graph, node);
    let at = |x: f32| scene.closest(Culling::None, &Ray::new([x, 0.0, 1.0], [0.0, 0.0, -1.0]));
    assert_eq!(at(1.0).and_then(|at| at.attributes::<Disc>()), Some(0.5));
    assert!(at(1.999).is_some() && at(2.001).is_none());
}

/// Many shapes: the tree finds what testing every one finds.
#[test]
fn the_tree_over_shapes_loses_none() {
    let balls: Vec<Sphere> = (0..500)
        .map(|number| {
            let random = Random { seed: 1, pixel: number, sample: 0 };
            let [x, y, z, radius] = random.four(0);
            Sphere { center: Vec3::new(x, y, z) * 10.0, radius: 0.1 + radius * 0.3 }
        })
        .collect();
    let mut graph = Graph::new();
    let geometry = Geometry::of::<Sphere>(balls.clone(), Builder::Binned);
    let geometry = graph.geometry(geometry.expect("they are taken"));
    let material = graph.material(());
    let root = graph.instance(geometry, material);
    let scene = graph.commit(root).expect("it is placed");
    let mut met = 0;
    for number in 0..2000 {
        let random = Random { seed: 2, pixel: number, sample: 0 };
        let ([x, y, z, _], [a, b, c, _]) = (random.four(0), random.four(1));
        let to = Vec3::new(a, b, c) * 10.0 - Vec3::new(x, y, z) * 10.0;
        let ray = Ray::new(Vec3::new(x, y, z) * 10.0, to);
        let mut best: Option<(f32, usize)> = None;
        for (at, ball) in balls.iter().enumerate() {
            <Sphere as Primitive>::cross(ball, &ray, &mut |hit| {
                if hit.t >= 0.0 && best.is_none_or(|(old, _)| hit.t < old) {
                    best = Some((hit.t, at));
                }
            });
        }
        let found = scene.closest(Culling::None, &ray).map(|at| (at.t(), at.shape() as usize));
        assert_eq!(found, best, "ray {number}");
        met += u32::from(found.is_some());
    }
    assert!(met > 500, "{met}");
}
