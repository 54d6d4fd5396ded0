//! A new primitive in one file: a cone, beside the shapes and programs that are there.
#![allow(missing_docs, reason = "tests")]

mod common;

use common::add;
use glam::Vec3;
use trisect_core::{Hit, Ray};
use trisect_method::Culling;
use trisect_pipeline::{Disc, Graph, Leaves, Primitive};

/// The side of a cone whose axis runs down from its tip.
#[derive(Clone, Copy)]
struct Cone {
    tip: Vec3,
    height: f32,
    radius: f32,
}

impl Primitive for Cone {
    type Shape = Self;
    /// How far below the tip, in heights.
    type Attributes = f32;
    type Tree = Leaves<Self>;

    fn bounds(shape: &Self) -> [Vec3; 2] {
        let Self { tip, height, radius } = *shape;
        [tip - Vec3::new(radius, height, radius), tip + Vec3::new(radius, 0.0, radius)]
    }

    fn cross(shape: &Self, ray: &Ray<f32>, report: &mut dyn FnMut(Hit<f32>)) {
        // x² + z² = (slope·y)², from the tip.
        let (o, d) = (Vec3::from(ray.o) - shape.tip, Vec3::from(ray.d));
        let slope = shape.radius / shape.height;
        let product = |a: Vec3, b: Vec3| a.x * b.x + a.z * b.z - slope * slope * a.y * b.y;
        let (a, b, c) = (product(d, d), product(o, d), product(o, o));
        let discriminant = b * b - a * c;
        if discriminant >= 0.0 {
            for root in [-discriminant.sqrt(), discriminant.sqrt()] {
                let t = (root - b) / a;
                let down = -(o.y + t * d.y) / shape.height;
                if (0.0..=1.0).contains(&down) {
                    report(Hit { t, beta: down, gamma: 0.0 });
                }
            }
        }
    }

    fn normal(shape: &Self, ray: &Ray<f32>, hit: &Hit<f32>) -> Vec3 {
        let at = Vec3::from(ray.o) + Vec3::from(ray.d) * hit.t - shape.tip;
        let out = Vec3::new(at.x, 0.0, at.z).normalize_or_zero();
        out * shape.height + Vec3::Y * shape.radius
    }

    fn attributes(_: &Self, _: &Ray<f32>, hit: &Hit<f32>) -> f32 {
        hit.beta
    }
}

#[test]
fn a_cone_is_hit_as_any_shape() {
    let mut graph = Graph::new();
    let cone = Cone { tip: Vec3::Y * 2.0, height: 2.0, radius: 1.0 };
    let cone = add::<Cone, _>(&mut graph, cone, "cone");
    let ground = Disc { center: Vec3::ZERO, normal: Vec3::Y, radius: 5.0 };
    let ground = add::<Disc, _>(&mut graph, ground, "ground");
    let root = graph.group([cone, ground]);
    let scene = graph.commit(root).expect("it is placed");
    let across = Ray::new([-5.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    let at = scene.closest(Culling::None, &across).expect("the cone");
    assert_eq!((*at.material(), at.t(), at.attributes::<Cone>()), ("cone", 4.5, Some(0.5)));
    assert!((at.front() - Vec3::new(-2.0, 1.0, 0.0).normalize()).length() < 1e-6);
    let down = |x: f32| Ray::new([x, 9.0, 0.0], [0.0, -1.0, 0.0]);
    let seen = |x| scene.closest(Culling::None, &down(x)).map(|at| (*at.material(), at.t()));
    assert_eq!(seen(0.5), Some(("cone", 8.0)));
    assert_eq!(seen(1.5), Some(("ground", 9.0)));
    assert_eq!(seen(5.5), None);
    assert!(!scene.is_blocked(Culling::Back, &Ray::new([0.0, 0.5, 0.0], [0.0, 0.1, 1.0])));
}
