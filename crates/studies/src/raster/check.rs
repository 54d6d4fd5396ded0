//! Pixels at which the rasteriser and the exact caster differ, counted.

use serde::Serialize;
use trisect_catalog::{Builder, Entry, Tracing, Tree, find};
use trisect_core::Ray;
use trisect_method::Culling;
use trisect_raster::{Blocks, NoCulling, Object, Rasteriser, hostile};
use trisect_render::Settings as Picture;
use trisect_report::document::{Content, Section};
use trisect_report::table::Table;
use trisect_scene::{Lens, PixelRays, SHIPPED, Scene};
use trisect_tracer::TriangleHit;

use super::settings::Settings;
use super::subjects::{meshes, objects, staged};
use crate::study::{Progress, StudyError, pool, threads};

/// Sizes at which pictures are compared.
const SIZES: [[u32; 2]; 5] = [[160, 120], [320, 240], [640, 480], [1024, 768], [1920, 1080]];

/// A scene, through all of its cameras, at all sizes.
#[derive(Clone, Debug, Serialize)]
pub struct Checked {
    /// Its name.
    pub scene: String,
    /// Pictures that were compared.
    pub pictures: u64,
    /// Their pixels.
    pub pixels: u64,
    /// Pixels at which anything is seen.
    pub covered: u64,
    /// Pairs of a pixel and a triangle that exact arithmetic decided.
    pub judged: u64,
    /// Pixels at which another triangle is seen, or another value of the hit.
    pub different: u64,
}

/// What was counted.
#[derive(Clone, Debug, Serialize)]
pub struct CheckSummary {
    /// Scene by scene.
    pub scenes: Vec<Checked>,
    /// Pixels that differ, of all.
    pub different: u64,
    /// All pixels.
    pub pixels: u64,
}

impl CheckSummary {
    /// As text.
    pub fn to_text(&self, width: usize) -> String {
        let table = Table::of(&self.scenes)
            .text("scene", |row| row.scene.clone())
            .count("pictures", |row| row.pictures)
            .count("pixels", |row| row.pixels)
            .count("covered", |row| row.covered)
            .count("judged", |row| row.judged)
            .count("different", |row| row.different)
            .done();
        let says = format!("{} of {} pixels differ.", self.different, self.pixels);
        let section =
            Section::new("check", "Rasterised and cast", Content::Table(table)).says(says);
        trisect_report::document::Document::text(vec![section], width)
    }
}

/// The exact method.
pub(super) fn exact() -> &'static Entry {
    find("exact").expect("it is in the catalogue")
}

/// All rays of a picture, row by row.
pub(super) fn all_rays(rays: &PixelRays) -> Vec<Ray<f32>> {
    let [width, height] = rays.size();
    (0..height)
        .flat_map(|y| (0..width).map(move |x| [x, y]))
        .map(|pixel| {
            let (o, d) = rays.ray(pixel);
            Ray { o: o.into(), d: d.into(), tmin: 0.0, tmax: f32::INFINITY }
        })
        .collect()
}

/// What a tree's rays hit.
pub(super) fn cast(
    tree: &dyn Tree,
    tracing: Tracing,
    rays: &[Ray<f32>],
    found: &mut [Option<TriangleHit>],
) {
    tree.closest(tracing, Culling::None, rays, found);
}

impl Checked {
    fn new(scene: impl Into<String>) -> Self {
        let scene = scene.into();
        Self { scene, pictures: 0, pixels: 0, covered: 0, judged: 0, different: 0 }
    }

    /// Compares a picture.
    fn compare(
        &mut self,
        objects: &[Object],
        rays: &PixelRays,
        cast: impl FnOnce(&[Ray<f32>], &mut [Option<TriangleHit>]),
    ) {
        let mut raster = Rasteriser::<NoCulling>::new();
        if !raster.draw(objects, rays) {
            return;
        }
        let all = all_rays(rays);
        let mut found = vec![None; all.len()];
        cast(&all, &mut found);
        let seen = raster.hits(objects, rays);
        self.pictures += 1;
        self.pixels += all.len() as u64;
        self.covered += seen.iter().flatten().count() as u64;
        self.judged += raster.judged();
        self.different += seen.iter().zip(&found).filter(|(a, b)| a != b).count() as u64;
    }
}

/// Counts, on every shipped scene, every mesh of the study and every hostile scene.
///
/// # Errors
/// When a shipped scene cannot be read, or the system gives no threads.
///
/// # Panics
/// Never: the exact method takes every mesh.
pub fn check(settings: &Settings, progress: &mut dyn Progress) -> Result<CheckSummary, StudyError> {
    let sizes = SIZES.map(|size| settings.size(size));
    let pool = pool(threads(settings.threads))?;
    let mut scenes: Vec<Checked> = Vec::new();
    let names: Vec<&str> = SHIPPED
        .iter()
        .map(|(path, _)| *path)
        .filter(|path| [".toml", ".obj", ".ply"].iter().any(|ending| path.ends_with(ending)))
        .collect();
    progress.phase("scenes", (names.len() + 3) as u64);
    for name in names {
        let scene = Scene::shipped(name)?;
        let mut checked = Checked::new(name);
        let (stage, blocks) = pool
            .install(|| staged(scene, exact(), Builder::Spatial))
            .expect("the exact method takes every mesh");
        let objects = objects(&stage, &blocks);
        for (camera, of) in stage.scene().cameras.iter().enumerate() {
            // Through a lens the middle ray is compared.
            let field_of_view = match of.lens {
                Lens::Thin { field_of_view, .. } => Some(field_of_view),
                _ => None,
            };
            for size in sizes {
                let mut rays = stage.pixel_rays(&Picture { camera, ..Picture::new(size) });
                if let Some(field_of_view) = field_of_view {
                    rays = rays.with_lens(Lens::Pinhole { field_of_view });
                }
                pool.install(|| {
                    checked.compare(&objects, &rays, |rays, found| {
                        stage.closest(Tracing::Single, rays, found);
                    });
                });
            }
        }
        scenes.push(checked);
        progress.step();
    }
    for subject in meshes(&[]) {
        let mut checked =
            Checked::new(format!("{}, {} triangles", subject.name, subject.triangles.len()));
        let objects = [Object::new(std::sync::Arc::new(Blocks::new(&subject.triangles)))];
        let tree = pool.install(|| exact().tree(&subject.triangles, Builder::Spatial));
        let tree = tree.expect("the exact method takes every mesh");
        for size in sizes {
            let rays = PixelRays::new(subject.camera.clone(), size);
            pool.install(|| {
                checked.compare(&objects, &rays, |rays, found| {
                    cast(&*tree, Tracing::Single, rays, found);
                });
            });
        }
        scenes.push(checked);
        progress.step();
    }
    progress.phase("hostile scenes", sizes.len() as u64);
    let mut hostile: Vec<Checked> = Vec::new();
    for size in sizes {
        for scene in hostile::scenes(size) {
            let objects = [Object::new(std::sync::Arc::new(Blocks::new(&scene.triangles)))];
            let tree = pool.install(|| exact().tree(&scene.triangles, Builder::Spatial));
            let tree = tree.expect("the exact method takes every mesh");
            let name = format!("hostile: {}", scene.name);
            let place = hostile.iter().position(|row| row.scene == name).unwrap_or_else(|| {
                hostile.push(Checked::new(name));
                hostile.len() - 1
            });
            let rays = PixelRays::new(scene.camera, size);
            pool.install(|| {
                hostile[place].compare(&objects, &rays, |rays, found| {
                    cast(&*tree, Tracing::Single, rays, found);
                });
            });
        }
        progress.step();
    }
    scenes.extend(hostile);
    Ok(CheckSummary {
        different: scenes.iter().map(|row| row.different).sum(),
        pixels: scenes.iter().map(|row| row.pixels).sum(),
        scenes,
    })
}
