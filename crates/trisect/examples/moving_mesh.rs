//! How does a scene follow a mesh that moves? The tree is fitted to the new vertices, which is far quicker than
//! building it.
use trisect::{Ray, Scene};

/// A strip of a flag at a time, in the wind.
fn flag(time: f32) -> Vec<[f32; 3]> {
    let column = |k: usize| {
        let x = k as f32 / 16.0;
        let z = (6.0 * x - time).sin() * 0.2 * x;
        [[x, 0.0, z], [x, 1.0, z]]
    };
    (0..=16).flat_map(column).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let faces: Vec<[u32; 3]> =
        (0..16).map(|k| 2 * k).flat_map(|k| [[k, k + 2, k + 3], [k, k + 3, k + 1]]).collect();
    let mut scene = Scene::options().moving().build(&flag(0.0), &faces)?;
    let ray = Ray::new([0.9, 0.5, 2.0], [0.0, 0.0, -1.0]);
    for time in [0.0, 0.5, 1.0] {
        scene.update(&flag(time))?;
        let hit = scene.first(&ray).ok_or("the flag is wide enough")?;
        println!("at {time}: triangle {} at height {:.3}", hit.triangle, hit.point(&scene)[2]);
    }
    Ok(())
}
