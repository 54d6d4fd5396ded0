//! Is a point lit? A shadow ray asks whether anything lies between it and the light; what it is does not matter.
use trisect::{Ray, Scene, SceneError};

/// Whether light reaches one point from the other. The ray begins and ends a little before both, so that it does
/// not meet the surfaces that they lie on.
fn sees(scene: &Scene, point: [f32; 3], light: [f32; 3]) -> bool {
    let to_light = [light[0] - point[0], light[1] - point[1], light[2] - point[2]];
    !scene.any(&Ray::new(point, to_light).with_interval(1e-4, 1.0 - 1e-4))
}

fn main() -> Result<(), SceneError> {
    // A floor, and a small roof above its middle.
    let vertices = [
        [-4.0, -4.0, 0.0],
        [4.0, -4.0, 0.0],
        [4.0, 4.0, 0.0],
        [-4.0, 4.0, 0.0],
        [-1.0, -1.0, 1.0],
        [1.0, -1.0, 1.0],
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, 1.0],
    ];
    let scene = Scene::new(&vertices, &[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])?;
    let light = [0.0, 0.0, 5.0];
    for x in [-3.0, 0.0, 0.5, 3.0] {
        let lit = if sees(&scene, [x, 0.0, 0.0], light) { "lit" } else { "in shadow" };
        println!("({x}, 0, 0) is {lit}");
    }
    Ok(())
}
