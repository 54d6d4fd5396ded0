//! Which points are inside a solid? Those that its surface encloses; those on it are told apart.
use trisect::Scene;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::open("data/scenes/block.obj")?;
    for x in [0.0, 0.5, 1.0] {
        println!("(0, 0, {x}): {:?}", scene.contains([0.0, 0.0, x])?);
    }
    Ok(())
}
