//! How thick is a part? All hits of a ray in order are where it enters and leaves, in turns.
use trisect::{Crossings, Ray, Scene};

fn main() -> Result<(), trisect::SceneError> {
    let scene = Scene::open("data/scenes/block.obj")?;
    let mut hits = Vec::new();
    for x in [-0.25, 0.25, 2.5] {
        let ray = Ray::new([x, 0.5, 9.0], [0.0, 0.0, -1.0]);
        // Of triangles that share the edge that a ray meets, one owns the crossing.
        scene.crossings(Crossings::Owned).all(&ray, &mut hits);
        let lengths = hits.chunks_exact(2).map(|pair| pair[1].t - pair[0].t);
        let inside = lengths.fold(0.0, |sum, length| sum + length);
        println!("x = {x}: {} crossings, {inside} of the ray inside", hits.len());
    }
    Ok(())
}
