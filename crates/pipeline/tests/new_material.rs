//! A new material in one file: velvet, beside the materials of the path tracer that is a demonstration.
#![allow(missing_docs, reason = "tests")]

#[allow(dead_code, unused_imports, reason = "the test asks for a part")]
#[path = "../examples/paths.rs"]
mod paths;

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;
use paths::common::Camera;
use paths::{Bsdf, Lambert, Local, Paths};
use trisect_pipeline::{Launch, Sphere};

/// Brighter where it is seen flatly: a share of the light of Lambert's that grows towards the rim.
struct Velvet;

impl Bsdf for Velvet {
    fn evaluate(&self, local: &Local, from: Vec3) -> Vec3 {
        let flat = 1.0 - local.normal.dot(local.to).clamp(0.0, 1.0);
        Vec3::new(0.9, 0.2, 0.3) * (flat * local.normal.dot(from).max(0.0) * FRAC_1_PI)
    }

    /// All directions above the surface are as likely.
    fn density(&self, local: &Local, from: Vec3) -> f32 {
        if local.normal.dot(from) > 0.0 { 1.0 / TAU } else { 0.0 }
    }

    fn sample(&self, local: &Local, [u, v]: [f32; 2]) -> Vec3 {
        let (sin, cos) = (TAU * u).sin_cos();
        let (x, y) = local.normal.any_orthonormal_pair();
        (x * cos + y * sin) * (1.0 - v * v).sqrt() + local.normal * v
    }
}

#[test]
fn velvet_is_brighter_at_its_rim() {
    let ball = |x: f32| Sphere { center: Vec3::X * x, radius: 1.0 };
    let spheres: Vec<(Sphere, paths::Material)> =
        vec![(ball(-1.5), Box::new(Velvet)), (ball(1.5), Box::new(Lambert(Vec3::splat(0.5))))];
    let scene = paths::scene(spheres, vec![]).expect("it is placed");
    let camera = Camera::orthographic(Vec3::Z * 5.0, Vec3::ZERO, 3.0);
    // 10 pixels a unit. One surface alone counts: what comes of the other is left out.
    let size = [60, 30];
    let mut paths = Paths { camera, size, sample: 0, sky: Vec3::ONE, lamp: None, depth: 1 };
    let pixels = paths::mean(&scene, &mut paths, 400, &Launch::default());
    let at = |x: usize| pixels[15 * 60 + x];
    // In the middle of the velvet, and nine tenths of the way to its rim, away from the other ball.
    let (middle, rim) = (at(15), at(6));
    assert!(middle.x < 0.1, "{middle}");
    assert!(rim.x > 0.3 && rim.x > 2.5 * rim.y, "{rim}");
    assert!((at(45) - 0.5).abs().max_element() < 0.03, "the other is as it was: {}", at(45));
}
