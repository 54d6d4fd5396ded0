//! Which points are inside a solid? Those that its surface encloses; those on it are told apart.
use trisect::Scene;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::open("data/scenes/block.obj")?;
    for y in [0.5, 1.0, 1.5] {
        println!("(0, {y}, 0): {:?}", scene.contains([0.0, y, 0.0])?);
    }
    Ok(())
}
