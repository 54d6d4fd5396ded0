//! How are coordinates kept that f32 cannot hold? A scene of f64: terrain in UTM coordinates, in meters.
use trisect::{Ray, Scene, SceneOptions};

/// The height of the terrain at so many meters east and north of its corner.
fn height(east: f64, north: f64) -> f64 {
    320.0 + 12.0 * (east / 37.0).sin() * (north / 29.0).cos()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A grid of half a meter; in f32 northings such as these are half a meter apart.
    let (east, north, step, side) = (448_262.25, 5_411_932.75, 0.5, 201_u32);
    let corner = |k: u32| {
        let [x, y] = [k % side, k / side].map(|cells| f64::from(cells) * step);
        [east + x, north + y, height(x, y)]
    };
    let vertices: Vec<[f64; 3]> = (0..side * side).map(corner).collect();
    let cells = (0..side * (side - 1)).filter(|k| k % side + 1 < side);
    let faces: Vec<[u32; 3]> =
        cells.flat_map(|k| [[k, k + 1, k + side + 1], [k, k + side + 1, k + side]]).collect();

    let scene = Scene::<f64>::new(&vertices, &faces)?;
    // Near its own origin f32 will do where a tenth of a millimeter is enough.
    let rounded = SceneOptions::<f32>::default().build_rounded(&vertices, &faces)?;
    for (x, y) in [(12.3, 45.6), (78.9, 10.1), (120.0, 50.0)] {
        let down = Ray::new([east + x, north + y, 400.0], [0.0, 0.0, -1.0]);
        match (scene.first(&down), rounded.first(&down)) {
            (Some(hit), Some(near)) => {
                let [height, nearly] = [hit, near].map(|hit| 400.0 - hit.t);
                println!("{x} m east, {y} m north: {height:.6} m high");
                assert!((height - nearly).abs() < 1e-4);
            }
            _ => println!("{x} m east, {y} m north: beyond the terrain"),
        }
    }
    Ok(())
}
