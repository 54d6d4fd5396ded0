//! Times pictures of a mesh: `cargo run --release -p trisect-raster --example frames -- FILE [WIDTH HEIGHT]`.

use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;
use trisect_raster::{
    Bare, Blocks, Culls, Edges, Filtered, NoCulling, Object, PerspectiveCulling, Rasteriser,
};
use trisect_scene::{Camera, Lens, PixelRays};
use trisect_workloads::Mesh;

fn time<C: Culls, E: Edges>(name: &str, objects: &[Object], rays: &PixelRays) {
    let mut raster = Rasteriser::<C, E>::new();
    let mut times = Vec::new();
    for _ in 0..25 {
        let start = Instant::now();
        raster.draw(objects, rays);
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    println!(
        "{name}: {:.2} ms in the middle, {:.2} at best, {} judged",
        times[times.len() / 2],
        times[0],
        raster.judged()
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mesh = match arguments.first() {
        Some(path) => Mesh::load(path).expect("a mesh"),
        None => trisect_workloads::bunny(),
    };
    let side = |at: usize, usual| arguments.get(at).map_or(usual, |x| x.parse().expect("pixels"));
    let (middle, size) = (Vec3::from(mesh.bounds.center()), mesh.bounds.diagonal());
    let lens = Lens::Pinhole { field_of_view: 0.7 };
    let eye = middle + Vec3::new(0.25, 0.3, 1.0).normalize() * size * 1.1;
    let camera = Camera::looking(eye, middle, Vec3::Y, lens).expect("a direction");
    let rays = PixelRays::new(camera, [side(1, 1920), side(2, 1080)]);
    let objects = [Object::new(Arc::new(Blocks::new(&mesh.triangles)))];
    for threads in [1, 0] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        println!("{} triangles, {} thread(s)", mesh.triangles.len(), pool.current_num_threads());
        pool.install(|| {
            time::<NoCulling, Filtered>("filtered", &objects, &rays);
            time::<NoCulling, Bare>("bare", &objects, &rays);
            time::<PerspectiveCulling, Filtered>("filtered, culled", &objects, &rays);
        });
    }
}
