//! Rays in the sides of an instance's box meet it.
#![allow(missing_docs, reason = "tests")]

#[allow(dead_code, reason = "each test asks for a part")]
mod common;

use common::{render, stage};
use trisect_core::Triangle;
use trisect_moller_trumbore::MollerTrumbore;
use trisect_render::Settings;
use trisect_scene::{Affine3A, Camera, Instance, Lens, Mesh, Scene, Vec3};
use trisect_tracer::Tracing;

/// A cube between two corners, which are seen from along an axis through a point at its rim.
fn cube(low: Vec3, high: Vec3) -> Mesh {
    let mut triangles = Vec::new();
    let (x, y, z) = (Vec3::X * (high - low), Vec3::Y * (high - low), Vec3::Z * (high - low));
    for (u, v) in [(x, y), (y, z), (z, x)] {
        for (corner, u, v) in [(low, v, u), (high, -u, -v)] {
            triangles.push(Triangle::new(corner, corner + u, corner + u + v));
            triangles.push(Triangle::new(corner, corner + u + v, corner + v));
        }
    }
    Mesh { materials: vec![0; triangles.len()], ..Mesh::of_triangles("cube", triangles) }
}

/// The middle pixel of a camera that looks along an axis, from before or behind, through the origin.
fn middle(scene: &Scene, axis: usize, towards: f32, zero: f32, tracing: Tracing) -> Vec3 {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let mut forward = Vec3::splat(zero);
    forward[axis] = towards;
    let camera = Camera {
        name: String::new(),
        eye: axes[axis] * (-5.0 * towards),
        right: axes[(axis + 1) % 3],
        up: axes[(axis + 2) % 3],
        forward,
        lens: Lens::Orthographic { height: 3.0 },
    };
    let scene = Scene { cameras: vec![camera], ..scene.clone() };
    let settings = Settings { tracing, ..Settings::new([3, 3]) };
    render(&stage::<MollerTrumbore>(scene), &settings).pixels[4]
}

#[test]
fn rays_in_every_side_of_an_instances_box_meet_it() {
    let text = "[picture]\nambient = [1, 1, 1]\nbackground = [0, 0, 1]\n\
                [material.m]\ndiffuse = [1, 0, 0]\n";
    let mut scene = common::scene(text);
    let instance = |translation: Vec3| Instance {
        mesh: 0,
        to_world: Affine3A::from_translation(translation),
        material: None,
        smooth: false,
    };
    let (red, blue) = (Vec3::X, Vec3::Z);
    for axis in 0..3 {
        // The origin is on each side of the cube and each of its edges along the axis, and in its middle.
        for (u, v) in (0..3).flat_map(|u| (0..3).map(move |v| (u, v))) {
            let mut low = Vec3::NEG_ONE;
            low[(axis + 1) % 3] = -(u as f32);
            low[(axis + 2) % 3] = -(v as f32);
            scene.meshes = vec![cube(low, low + Vec3::splat(2.0))];
            for (towards, zero) in [(1.0, 0.0), (1.0, -0.0), (-1.0, 0.0), (-1.0, -0.0)] {
                for tracing in [Tracing::Single, Tracing::Packets, Tracing::Plain] {
                    let what = format!("{axis} {u} {v} {towards} {zero} {tracing:?}");
                    for far in [&[][..], &[Vec3::splat(50.0)], &[Vec3::X * -9.0, Vec3::Z * 9.0]] {
                        scene.instances = vec![instance(Vec3::ZERO)];
                        scene.instances.extend(far.iter().map(|&far| instance(far)));
                        let seen = middle(&scene, axis, towards, zero, tracing);
                        assert_eq!(seen, red, "{what}, {} more", far.len());
                    }
                }
            }
            // And no ray beside it.
            scene.instances = vec![instance(Vec3::splat(2.5)), instance(Vec3::splat(-50.0))];
            assert_eq!(middle(&scene, axis, 1.0, 0.0, Tracing::Single), blue);
        }
    }
}
