//! How are many copies of a mesh traced, and how do they move? Each is the same mesh in another place.
use std::sync::Arc;

use trisect::{Ray, Scene, Transform};

/// A block, turned about the vertical axis, mirrored where `width` is negative, at `x`.
fn place(angle: f32, width: f32, x: f32) -> Transform {
    let (sin, cos) = angle.sin_cos();
    [[width * cos, 0.0, sin, x], [0.0, 1.0, 0.0, 0.0], [-width * sin, 0.0, cos, 0.0]]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let block = Arc::new(Scene::open("data/scenes/block.obj")?);
    let row =
        [-1.0, 1.0, 3.0].map(|width: f32| (Arc::clone(&block), place(0.0, width, 4.0 * width)));
    let row = Arc::new(Scene::instances(&row)?);
    // A row of blocks, and another one behind it: a scene of scenes of instances.
    let far = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -20.0]];
    let mut scene = Scene::instances(&[(Arc::clone(&row), place(0.0, 1.0, 0.0)), (row, far)])?;
    let rays = [-4.0, 4.0, 12.0].map(|x| Ray::new([x, 0.5, 30.0], [0.0, 0.0, -1.0]));
    for angle in [0.0, 0.5] {
        scene.set_transform(0, &place(angle, 1.0, 0.0))?;
        for ray in &rays {
            match scene.first(ray) {
                Some(hit) => {
                    let path: Vec<usize> = hit.path(&scene).collect();
                    let (_, triangle) = hit.in_mesh(&scene);
                    let normal = hit.normal(&scene).map(|x| (10.0 * x).round() / 10.0 + 0.0);
                    let t = hit.t;
                    println!("{path:?}, triangle {triangle} at {t:.2}, normal {normal:?}");
                }
                None => println!("nothing"),
            }
        }
    }
    Ok(())
}
