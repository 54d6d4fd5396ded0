//! `trisect-viewer`: a window on a scene.
#![forbid(unsafe_code)]

mod window;

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, anyhow, bail};
use clap::Parser;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use trisect_catalog::Builder;
use trisect_scene::Scene;
use trisect_viewer::{Action, Frame, View, Viewer};

/// A window on a scene: pictures that get finer while nothing moves, by any method of the catalogue, and
/// heat maps of tests per pixel and of error against the exact oracle.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
struct Arguments {
    /// Scene: TOML, glTF, OBJ with its materials, or a mesh alone (PLY, STL)
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// What is shown first
    #[arg(long, value_name = "NAME", default_value_t = View::Picture, value_parser = views())]
    view: View,
    /// A method of `trisect list`
    #[arg(long, value_name = "NAME", default_value = "moller-trumbore")]
    method: String,
    /// Camera of the scene, by its name or its number from 1
    #[arg(long, value_name = "NAME", default_value = "1")]
    camera: String,
    /// Pixels across; the scene says it if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192))]
    width: Option<u32>,
    /// Pixels down; the scene says it if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192))]
    height: Option<u32>,
    /// Threads; all processors if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Write what the window would show as PNG, and open none
    #[arg(long, value_name = "FILE")]
    screenshot: Option<PathBuf>,
    /// Samples of a pixel, or paths, before the screenshot
    #[arg(long, value_name = "N", default_value_t = 16, requires = "screenshot", value_parser = clap::value_parser!(u32).range(1..=64))]
    samples: u32,
}

/// Lists the views in help.
fn views() -> impl TypedValueParser<Value = View> {
    PossibleValuesParser::new(View::ALL.map(View::name))
        .map(|name| name.parse().expect("it is listed"))
}

fn main() -> ExitCode {
    let done = match Arguments::try_parse() {
        Ok(arguments) => run(&arguments),
        Err(message) => match message.print() {
            Err(error) if !message.use_stderr() => Err(error.into()),
            _ => return ExitCode::from(if message.use_stderr() { 2 } else { 0 }),
        },
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // A stream that is closed or full is no reason to panic.
            let _ = writeln!(io::stderr(), "trisect-viewer: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let path = &arguments.scene;
    if let Some(out) = &arguments.screenshot {
        check(out)?;
    }
    let scene = Scene::load(path)?;
    let size =
        [arguments.width.unwrap_or(scene.size[0]), arguments.height.unwrap_or(scene.size[1])];
    let camera = scene
        .camera(&arguments.camera)
        .map_err(|unknown| anyhow!("{}: {unknown}", path.display()))?;
    rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads.map_or(0, usize::from))
        .build_global()
        .context("the system gives no threads; ask for fewer with --threads")?;
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let mut viewer = Viewer::new(name, scene, camera, &arguments.method, Builder::default(), size)?;
    viewer.act(Action::View(arguments.view));
    let Some(out) = &arguments.screenshot else { return window::show(&mut viewer) };
    let go_on = AtomicBool::new(false);
    while viewer.passes() < arguments.samples && viewer.advance(&go_on) {}
    write(&viewer.frame(), out)
}

/// Refuses a place that cannot be written before anything is computed.
fn check(out: &Path) -> Result<()> {
    if !out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        bail!("{}: unknown type of picture; name a .png with --screenshot", out.display());
    }
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    if out.is_dir() || !folder.is_dir() {
        bail!("{}: cannot be written; name a file in a folder that there is", out.display());
    }
    Ok(())
}

fn write(frame: &Frame, out: &Path) -> Result<()> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, frame.size[0], frame.size[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&frame.to_rgb())?;
    writer.finish()?;
    Ok(trisect_studies::file::replace(out, |out| out.write_all(&file))?)
}
