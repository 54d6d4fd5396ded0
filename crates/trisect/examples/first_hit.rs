//! What does a ray hit first, and where in the triangle?
use trisect::{Ray, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::open("data/scenes/block.obj")?;
    for x in [-0.25, 0.25, 2.5] {
        let ray = Ray::new([x, 0.5, 9.0], [0.0, 0.0, -1.0]);
        match scene.first(&ray) {
            Some(hit) => println!("{hit:?}"),
            None => println!("nothing"),
        }
    }
    Ok(())
}
