//! `trisect render`: a picture of a scene.

use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context as _, Result, anyhow, bail};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;
use trisect_catalog::{Tracing, TriangleHit};
use trisect_raster::{Blocks, NoCulling, Rasteriser};
use trisect_render::{
    Image, ImageFormat, Mode, Occlusion, Renderer, Sampling, Settings, Stage, Watch,
};
use trisect_scene::Scene;
use trisect_studies::raster::{objects, staged};
use trisect_studies::{Progress as _, file, input, nanoseconds};

use crate::arguments::{Light, Primary, Render};
use crate::progress::Bar;
use crate::{output, paint, reading};

/// Pixels of the largest picture: it takes 32 bytes a pixel while it is made.
const LARGEST: u64 = 1 << 26;

/// What is printed as JSON.
#[derive(Serialize)]
struct Report {
    scene: String,
    picture: String,
    width: u32,
    height: u32,
    mode: &'static str,
    sampling: String,
    depth: u32,
    lights: usize,
    method: String,
    threads: usize,
    /// In trees; what instances share counts once.
    triangles: usize,
    instances: usize,
    /// Reading the scene, without the trees.
    load_ns: u64,
    build_ns: u64,
    render_ns: u64,
    primary_rays: u64,
    secondary_rays: u64,
    shadow_rays: u64,
    million_rays_per_second: f64,
}

pub(crate) fn run(arguments: &Render) -> Result<()> {
    let entry = input::method(&arguments.method)?;
    let out = &arguments.out;
    let format = ImageFormat::of(out).map_err(|error| anyhow!("{}: {error}", out.display()))?;
    output::check_file_for(out, "--out")?;
    let start = Instant::now();
    let scene = reading::load_scene(&arguments.scene, &arguments.reading)?;
    let load = start.elapsed();
    let settings = settings(arguments, &scene)?;
    if arguments.raster {
        return paint::run(arguments, &scene, &settings, format);
    }
    let (lights, instances) = (scene.lights.len().min(settings.lights), scene.instances.len());

    let pool = pool(arguments)?;
    let start = Instant::now();
    let (stage, blocks) = pool
        .install(|| match arguments.primary {
            Primary::Cast => {
                Stage::new(scene, |triangles| entry.tree(triangles, arguments.builder))
                    .map(|stage| (stage, Vec::new()))
            }
            Primary::Raster => staged(scene, entry, arguments.builder),
        })
        .map_err(|unsuitable| anyhow!("{}: {unsuitable}", arguments.scene.display()))?;
    let build = start.elapsed();

    // Nothing is open while rays are traced: the system's own answer to an interrupt is the quickest,
    // and leaves nothing behind.
    let mut bar = Bar::new();
    bar.phase("render", Renderer::tiles(&settings));
    let watch = Watch { stop: &AtomicBool::new(false), tile: &|| bar.advance() };
    let start = Instant::now();
    let hits = match arguments.primary {
        Primary::Cast => None,
        Primary::Raster => Some(pool.install(|| seen(&stage, &blocks, &settings))?),
    };
    let mut renderer = Renderer::new(&stage);
    if let Some(hits) = &hits {
        renderer = renderer.seeing(hits);
    }
    let image = pool.install(|| renderer.render(&settings, &watch))?;
    let render = start.elapsed();
    drop(bar);

    write(&image, format, out)?;

    let counts = renderer.counts();
    let report = Report {
        scene: shown(&arguments.scene),
        picture: shown(out),
        width: settings.size[0],
        height: settings.size[1],
        mode: match settings.mode {
            Mode::Whitted { .. } => "whitted",
            Mode::Paths => "paths",
        },
        sampling: settings.sampling.to_string(),
        depth: settings.depth,
        lights,
        method: arguments.method.clone(),
        threads: pool.current_num_threads(),
        triangles: stage.triangles(),
        instances,
        load_ns: nanoseconds(load),
        build_ns: nanoseconds(build),
        render_ns: nanoseconds(render),
        primary_rays: counts.primary,
        secondary_rays: counts.secondary,
        shadow_rays: counts.shadow,
        million_rays_per_second: counts.total() as f64 / render.as_secs_f64() / 1e6,
    };
    output::print_as(arguments.json, &report, |out| report.print(out))
}

/// The threads that were asked for.
pub(crate) fn pool(arguments: &Render) -> Result<ThreadPool> {
    ThreadPoolBuilder::new()
        .num_threads(arguments.threads.map_or(0, usize::from))
        .build()
        .context("the system gives no threads; ask for fewer with --threads")
}

/// Writes a picture, all of it or nothing.
pub(crate) fn write(image: &Image, format: ImageFormat, out: &Path) -> Result<()> {
    let mut encoded = Cursor::new(Vec::new());
    image
        .write(format, &mut encoded)
        .with_context(|| format!("{}: cannot write", out.display()))?;
    Ok(file::replace(out, |file| file.write_all(encoded.get_ref()))?)
}

/// What the rasteriser sees.
fn seen(
    stage: &Stage,
    blocks: &[Arc<Blocks>],
    settings: &Settings,
) -> Result<Vec<Option<TriangleHit>>> {
    let (objects, rays) = (objects(stage, blocks), stage.pixel_rays(settings));
    let mut raster = Rasteriser::<NoCulling>::new();
    if !raster.draw(&objects, &rays) {
        bail!(LENS);
    }
    Ok(raster.hits(&objects, &rays))
}

/// Why a picture is not rasterised.
pub(crate) const LENS: &str = "through a lens rays go from everywhere; leave out --raster and --primary raster, or choose a camera \
     without a lens with --camera";

pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string()
}

fn settings(arguments: &Render, scene: &Scene) -> Result<Settings> {
    let size =
        [arguments.width.unwrap_or(scene.size[0]), arguments.height.unwrap_or(scene.size[1])];
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    if pixels > LARGEST {
        bail!(
            "a picture of {} by {} pixels is too large; give at most {LARGEST} pixels with --width and \
             --height",
            size[0],
            size[1]
        );
    }
    let camera = scene
        .camera(&arguments.camera)
        .map_err(|unknown| anyhow!("{}: {unknown}", arguments.scene.display()))?;
    let (mode, usual) = match arguments.mode {
        Light::Whitted => {
            let occlusion = arguments
                .occlusion
                .map(|rays| Occlusion { rays, distance: arguments.occlusion_distance });
            (Mode::Whitted { occlusion }, Sampling::Adaptive(4))
        }
        Light::Paths => (Mode::Paths, Sampling::Jittered(8)),
    };
    let is_cast = arguments.primary == Primary::Cast && !arguments.raster;
    let usual = if is_cast { usual } else { Sampling::ONE };
    let sampling = arguments.sampling.unwrap_or(usual);
    if arguments.primary == Primary::Raster && (mode == Mode::Paths || sampling != Sampling::ONE) {
        bail!(
            "the rasteriser sees the middle of each pixel; leave out --primary raster, or --sampling and \
             --mode paths"
        );
    }
    if mode == Mode::Paths && matches!(sampling, Sampling::Adaptive(_)) {
        bail!("paths are not sampled adaptively; give grid, jittered or circle with --sampling");
    }
    if mode == Mode::Paths && arguments.occlusion.is_some() {
        bail!("paths find what is occluded by themselves; leave out --occlusion or --mode paths");
    }
    Ok(Settings {
        size,
        camera,
        sampling,
        mode,
        depth: arguments.depth,
        cutoff: arguments.cutoff,
        lights: arguments.lights.map_or(usize::MAX, usize::from),
        seed: arguments.seed,
        tile: arguments.tile,
        tracing: Tracing::Single,
    })
}

impl Report {
    fn print(&self, out: &mut dyn Write) -> std::io::Result<()> {
        writeln!(
            out,
            "{}: {} triangles in trees, {} instances, {} lights\n\
             built    {:.1} ms for {}\n\
             rendered {:.1} ms, {} by {} pixels, {} {}, on {} thread(s)\n\
             traced   {} rays ({} primary, {} secondary, {} to lights), {:.2} million/s\n\
             picture  {}",
            self.scene,
            self.triangles,
            self.instances,
            self.lights,
            self.build_ns as f64 / 1e6,
            self.method,
            self.render_ns as f64 / 1e6,
            self.width,
            self.height,
            self.mode,
            self.sampling,
            self.threads,
            self.primary_rays + self.secondary_rays + self.shadow_rays,
            self.primary_rays,
            self.secondary_rays,
            self.shadow_rays,
            self.million_rays_per_second,
            self.picture,
        )
    }
}
