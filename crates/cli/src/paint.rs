//! `trisect render --raster`: a picture painted triangle by triangle.

use std::time::Instant;

use anyhow::{Result, bail};
use serde::Serialize;
use trisect_raster::{
    Affine, Filtered, Flat, Gouraud, Identity, NoCulling, NoTexture, Painter, Perspective, Phong,
    Scenery, Shading, Texturing, Unlit,
};
use trisect_render::{Image, ImageFormat, Settings};
use trisect_scene::{Color, PixelRays, Scene};
use trisect_studies::nanoseconds;

use crate::arguments::{Render, Shade, Textures};
use crate::output;
use crate::render::{LENS, pool, shown, write};

/// What is printed as JSON.
#[derive(Serialize)]
struct Report {
    scene: String,
    picture: String,
    width: u32,
    height: u32,
    threads: usize,
    triangles: usize,
    /// Making the scene ready.
    prepare_ns: u64,
    paint_ns: u64,
    /// Pairs of a pixel and a triangle that exact arithmetic decided.
    judged: u64,
}

/// What is painted.
struct Job<'a> {
    scenery: &'a Scenery,
    rays: &'a PixelRays,
}

/// The colours, and how many pairs were judged.
type Painted = Option<(Vec<Color>, u64)>;

pub(crate) fn run(
    arguments: &Render,
    scene: &Scene,
    settings: &Settings,
    format: ImageFormat,
) -> Result<()> {
    let pool = pool(arguments)?;
    let start = Instant::now();
    let scenery = Scenery::new(scene, settings.lights);
    let prepare_ns = nanoseconds(start.elapsed());
    let rays = scenery.rays(settings.camera, settings.size);
    let start = Instant::now();
    let job = Job { scenery: &scenery, rays: &rays };
    let painted = pool.install(|| match arguments.textures {
        Textures::None => job.shaded::<NoTexture>(arguments.shade),
        Textures::Affine => job.shaded::<Affine>(arguments.shade),
        Textures::Perspective => job.shaded::<Perspective>(arguments.shade),
    });
    let paint_ns = nanoseconds(start.elapsed());
    let Some((pixels, judged)) = painted else { bail!(LENS) };
    write(&Image { size: settings.size, pixels }, format, &arguments.out)?;
    let report = Report {
        scene: shown(&arguments.scene),
        picture: shown(&arguments.out),
        width: settings.size[0],
        height: settings.size[1],
        threads: pool.current_num_threads(),
        triangles: scenery.triangles(),
        prepare_ns,
        paint_ns,
        judged,
    };
    output::print_as(arguments.json, &report, |out| {
        writeln!(
            out,
            "{}: {} triangles\n\
             prepared {:.1} ms\n\
             painted  {:.1} ms, {} by {} pixels, on {} thread(s); {} pairs judged exactly\n\
             picture  {}",
            report.scene,
            report.triangles,
            report.prepare_ns as f64 / 1e6,
            report.paint_ns as f64 / 1e6,
            report.width,
            report.height,
            report.threads,
            report.judged,
            report.picture,
        )
    })
}

impl Job<'_> {
    fn shaded<T: Texturing>(&self, shade: Shade) -> Painted {
        match shade {
            Shade::Id => self.painted::<Identity, T>(),
            Shade::Unlit => self.painted::<Unlit, T>(),
            Shade::Flat => self.painted::<Flat, T>(),
            Shade::Gouraud => self.painted::<Gouraud, T>(),
            Shade::Phong => self.painted::<Phong, T>(),
        }
    }

    fn painted<S: Shading, T: Texturing>(&self) -> Painted {
        let mut painter = Painter::<S, T, NoCulling, Filtered, Color>::default();
        let is_done = painter.paint(self.scenery, self.rays);
        is_done.then(|| (painter.pixels(), painter.rasteriser().judged()))
    }
}
