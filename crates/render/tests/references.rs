//! Small pictures of every feature against those that were looked at: `references/`.
//!
//! `TRISECT_UPDATE=1 cargo test -p trisect-render --test references` makes them anew; look at them then.
#![allow(missing_docs, reason = "tests")]

#[allow(dead_code, reason = "each test asks for a part")]
mod common;

use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::Path;

use common::{render, shipped, stage};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_render::{Image, ImageFormat, Mode, Occlusion, Sampling, Settings};
use trisect_scene::Vec3;
use trisect_tracer::Tracing;

fn read(path: &Path) -> Option<Image> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
    let mut bytes = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut bytes).ok()?;
    let linear = |x: u8| {
        let x = f32::from(x) / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    let pixels =
        bytes.chunks_exact(3).map(|rgb| Vec3::new(linear(rgb[0]), linear(rgb[1]), linear(rgb[2])));
    Some(Image { size: [info.width, info.height], pixels: pixels.collect() })
}

/// Renders a scene of `data/scenes` and holds it against its reference.
fn check(name: &str, scene: &str, change: impl FnOnce(&mut Settings)) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references").join(name);
    let path = path.with_extension("png");
    let mut settings = Settings { tracing: Tracing::Plain, ..Settings::new([128, 96]) };
    change(&mut settings);
    let image = render(&stage::<MollerTrumbore>(shipped(scene)), &settings);
    if std::env::var_os("TRISECT_UPDATE").is_some() {
        let mut out = BufWriter::new(File::create(&path).expect("the folder is there"));
        image.write(ImageFormat::Png, &mut out).expect("it is written");
        return;
    }
    let reference = read(&path).unwrap_or_else(|| panic!("{}: no reference", path.display()));
    let (root, share) = image.difference(&reference);
    // Other processors round sines and powers otherwise: a few pixels at edges may differ.
    if root > 0.01 || share > 0.005 {
        let seen = std::env::temp_dir().join(format!("trisect-{name}.png"));
        let mut out = BufWriter::new(File::create(&seen).expect("it can be written"));
        image.write(ImageFormat::Png, &mut out).expect("it is written");
        panic!(
            "{name}: differs by {root:.4}, {share:.4} of its pixels visibly; see {}",
            seen.display()
        );
    }
}

/// One picture a test, so that they run side by side and each is told by its name.
macro_rules! references {
    ($($name:ident: $scene:literal, $change:expr;)*) => {
        $(#[test]
        fn $name() {
            check(stringify!($name), $scene, $change);
        })*

        #[test]
        fn every_reference_belongs_to_a_test() {
            let names = [$(stringify!($name)),*];
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references");
            for entry in fs::read_dir(folder).expect("it is there") {
                let path = entry.expect("it can be read").path();
                let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                assert!(names.contains(&stem.as_str()), "{}", path.display());
            }
        }
    };
}

references! {
    mirrors: "mirror.toml", |s| s.sampling = Sampling::Grid(3);
    mirrors_to_depth_one: "mirror.toml", |s| { s.sampling = Sampling::Grid(3); s.depth = 1; };
    shadow_edges: "teapots.toml", |s| s.sampling = Sampling::Grid(3);
    shadows_from_above: "teapots.toml", |s| { s.sampling = Sampling::Grid(3); s.camera = 1; };
    total_internal_reflection: "glass.toml", |s| s.sampling = Sampling::Grid(3);
    texture_at_grazing_angle: "textures.toml", |s| s.sampling = Sampling::Grid(6);
    antialiasing_none: "textures.toml", |s| s.sampling = Sampling::ONE;
    antialiasing_grid: "textures.toml", |s| s.sampling = Sampling::Grid(2);
    antialiasing_circle: "textures.toml", |s| s.sampling = Sampling::Circle(4);
    antialiasing_jittered: "textures.toml", |s| s.sampling = Sampling::Jittered(2);
    antialiasing_adaptive: "textures.toml", |s| s.sampling = Sampling::Adaptive(4);
    thin_lens: "lens.toml", |s| s.sampling = Sampling::Jittered(8);
    ambient_occlusion: "teapots.toml", |s| {
        s.sampling = Sampling::Grid(2);
        s.lights = 0;
        s.mode = Mode::Whitted { occlusion: Some(Occlusion { rays: 32, distance: f32::INFINITY }) };
    };
    paths: "room.toml", |s| {
        s.size = [96, 96];
        s.sampling = Sampling::Circle(200);
        s.mode = Mode::Paths;
        s.depth = 8;
    };
}

/// More samples come nearer to the limit, and adaptive ones cost less than as many everywhere.
#[test]
fn samplings_come_near_the_limit() {
    let stage = stage::<MollerTrumbore>(shipped("textures.toml"));
    let picture = |sampling| {
        let settings = Settings { sampling, tracing: Tracing::Plain, ..Settings::new([96, 72]) };
        render(&stage, &settings)
    };
    let limit = picture(Sampling::Grid(16));
    let error = |sampling| picture(sampling).difference(&limit).0;
    let one = error(Sampling::ONE);
    for sampling in
        [Sampling::Grid(4), Sampling::Circle(8), Sampling::Jittered(4), Sampling::Adaptive(4)]
    {
        let error = error(sampling);
        assert!(error < 0.55 * one, "{sampling}: {error} of {one}");
    }
}
