//! Renders a scene with one method, and says how fast.
//!
//! `cargo run --release -p trisect-render --example picture -- SCENE OUT.png [SAMPLING [TIMES [LIGHTS]]]`

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use trisect_moller_trumbore::MollerTrumbore;
use trisect_render::{ImageFormat, Mode, Occlusion, Renderer, Settings, Stage, Watch};
use trisect_scene::Scene;
use trisect_tracer::{Builder, Bvh, Tree};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, scene, out, rest @ ..] = &arguments[..] else {
        return Err("give a scene and a file for the picture".into());
    };
    let scene = Scene::load(scene)?;
    let mut settings = Settings::new(scene.size);
    if let Some(sampling) = rest.first() {
        settings.sampling = sampling.parse()?;
    }
    let times: u32 = rest.get(1).map_or(Ok(1), |times| times.parse())?;
    if let Some(lights) = rest.get(2) {
        settings.lights = lights.parse()?;
    }
    match rest.get(3).map(String::as_str) {
        Some("paths") => settings.mode = Mode::Paths,
        Some("occlusion") => {
            let occlusion = Some(Occlusion { rays: 16, distance: f32::INFINITY });
            settings.mode = Mode::Whitted { occlusion };
        }
        _ => {}
    }
    if let Some(tile) = rest.get(4) {
        settings.tile = tile.parse()?;
    }
    let stage = Stage::new(scene, |triangles| {
        let tree = Bvh::<MollerTrumbore>::build(triangles, Builder::Spatial)?;
        Ok(Box::new(tree) as Box<dyn Tree>)
    })?;
    let stop = AtomicBool::new(false);
    let watch = Watch { stop: &stop, tile: &|| () };
    let mut renderer = Renderer::new(&stage);
    let mut best = f64::INFINITY;
    let mut image = None;
    for _ in 0..times {
        let start = Instant::now();
        image = Some(renderer.render(&settings, &watch)?);
        best = best.min(start.elapsed().as_secs_f64());
    }
    let counts = renderer.counts();
    println!(
        "{:.2} ms, {:.2} frames per second at best; {} rays a frame ({} primary, {} shadow)",
        best * 1e3,
        1.0 / best,
        counts.total() / u64::from(times),
        counts.primary / u64::from(times),
        counts.shadow / u64::from(times),
    );
    if let Some(image) = image {
        let format = ImageFormat::of(Path::new(out))?;
        image.write(format, &mut BufWriter::new(File::create(out)?))?;
    }
    Ok(())
}
