//! Trees over boxes alone.
#![allow(missing_docs, reason = "tests")]

use trisect_core::{Ray, Vec3};
use trisect_tracer::{BoxTree, Tracing, Update, meets_box};
use trisect_workloads::Stream;

type Box3 = [Vec3<f32>; 2];

/// A point of a cube.
#[allow(clippy::cast_possible_truncation, reason = "rounds")]
fn point(stream: &mut Stream, low: f64, high: f64) -> Vec3<f32> {
    Vec3::from([0; 3].map(|_| stream.range_f64(low, high) as f32))
}

fn boxes(stream: &mut Stream, count: usize) -> Vec<Box3> {
    (0..count)
        .map(|_| {
            let low = point(stream, 0.0, 10.0);
            [low, low + point(stream, 0.0, 2.0)]
        })
        .collect()
}

fn visited(tree: &BoxTree, tracing: Tracing, ray: &Ray<f32>) -> Vec<usize> {
    let mut met = vec![];
    tree.visit(tracing, ray, &mut |index| {
        met.push(index);
        ray.tmax
    });
    met.sort_unstable();
    met
}

/// Every box that a ray meets is visited once, and few that it does not.
fn check(tree: &BoxTree, boxes: &[Box3], stream: &mut Stream) -> usize {
    let mut all = 0;
    for _ in 0..500 {
        let [o, to] = [0; 2].map(|_| point(stream, -1.0, 11.0));
        let ray = Ray { o, d: to - o, tmin: 0.0, tmax: 1.5 };
        let expected: Vec<usize> =
            (0..boxes.len()).filter(|&at| meets_box(&ray, boxes[at][0], boxes[at][1])).collect();
        for tracing in [Tracing::Single, Tracing::Plain] {
            let met = visited(tree, tracing, &ray);
            assert!(met.windows(2).all(|pair| pair[0] < pair[1]), "each once");
            assert!(expected.iter().all(|at| met.binary_search(at).is_ok()), "{ray:?}");
            assert!(met.len() <= expected.len() + 2, "{met:?} {expected:?}");
        }
        all += expected.len();
    }
    all
}

#[test]
fn all_boxes_are_visited_that_a_ray_meets_wherever_they_move() {
    let mut stream = Stream::new("boxes", 1);
    for count in [0, 1, 7, 9, 400] {
        let mut boxes = boxes(&mut stream, count);
        let mut tree = BoxTree::new(&boxes);
        let met = check(&tree, &boxes, &mut stream);
        assert!(count < 400 || met > 1000, "{met}");
        for corners in &mut boxes {
            *corners = corners.map(|corner| corner + Vec3::new(0.01, 0.0, -0.01));
        }
        assert!(count == 0 || matches!(tree.update(&boxes), Update::Refitted { .. }));
        check(&tree, &boxes, &mut stream);
        boxes.extend([[Vec3::new(0.0, 0.0, 0.0), Vec3::new(10.0, 10.0, 0.0)]]);
        assert_eq!(tree.update(&boxes), Update::Rebuilt);
        check(&tree, &boxes, &mut stream);
    }
}

#[test]
fn an_interval_that_ends_ends_the_walk_and_empty_boxes_are_not_met() {
    let at = |z: f32| [Vec3::new(-1.0, -1.0, z), Vec3::new(1.0, 1.0, z + 0.5)];
    let mut boxes: Vec<Box3> = (0_u8..20).map(|z| at(f32::from(z))).collect();
    boxes[3] = [boxes[3][1], boxes[3][0]];
    boxes[4][0].x = f32::NAN;
    let tree = BoxTree::new(&boxes);
    let ray = Ray::<f32>::new([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    let mut met = vec![];
    tree.visit(Tracing::Single, &ray, &mut |index| {
        met.push(index);
        // Nothing beyond the end of the box at 7.
        if index == 7 { 8.5 } else { f32::INFINITY }
    });
    assert!([0, 1, 2, 5, 6, 7].iter().all(|index| met.contains(index)), "{met:?}");
    assert!(!met.contains(&3) && !met.contains(&4) && !met.contains(&19), "{met:?}");
    assert_eq!(tree.extent().triangles(), 20);
}
