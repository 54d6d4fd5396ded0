//! Pictures are drawn in turn by all ways, each sample held to the first.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rand::SeedableRng as _;
use rand_pcg::Pcg64;
use rayon::ThreadPool;
use trisect_catalog::{Builder, Entry, Tracing, Tree};
use trisect_core::{Ray, Triangle};
use trisect_raster::{
    Affine, Bare, Blocks, Culls, Edges, Filtered, Flat, Gouraud, Identity, NoCulling, NoTexture,
    Object, Painter, Perspective, PerspectiveCulling, Phong, Rasteriser, RoughCulling, Scan,
    Scenery, Shading, Texturing, Unlit,
};
use trisect_scene::PixelRays;
use trisect_tracer::TriangleHit;

use super::check::{all_rays, cast, exact};
use super::record::{Built, Seen, Series};
use super::settings::Raster;
use super::subjects::{Subject, frame, meshes};
use crate::kernels::reference;
use crate::study::{Run, StudyError, pool};
use crate::timing::{self, WrongAnswer, nanoseconds};

/// What is seen, pixel by pixel: numbers, or colours.
type Picture = Vec<u64>;

/// Nothing is seen.
const NOTHING: u64 = u64::MAX;

/// Something that draws: it says how long that took, and shows the picture when it is asked to.
type Draw<'a> = Box<dyn FnMut(&mut dyn FnMut(u64)) -> (Duration, u64) + 'a>;

/// A way to draw a picture.
struct Contender<'a> {
    seen: Seen,
    draw: Draw<'a>,
    first: Option<Picture>,
}

impl Contender<'_> {
    fn sample(&mut self, is_timed: bool) -> Result<(), WrongAnswer> {
        let mut picture = Picture::new();
        let (time, judged) = (self.draw)(&mut |pixel| picture.push(pixel));
        match &self.first {
            Some(first) if *first != picture => {
                return Err(WrongAnswer {
                    kernel: format!("{}, {}", self.seen.scene, self.seen.way),
                    found: "another picture".to_owned(),
                    expected: "the same picture".to_owned(),
                });
            }
            _ => self.first = Some(picture),
        }
        self.seen.judged = judged;
        if is_timed {
            self.seen.samples_ns.push(nanoseconds(time));
        }
        Ok(())
    }
}

/// What is drawn, and how.
struct At<'a> {
    series: Series,
    scene: &'a str,
    triangles: usize,
    rays: &'a PixelRays,
    pool: &'a ThreadPool,
}

impl<'a> At<'a> {
    fn contender(&self, way: &str, draw: Draw<'a>) -> Contender<'a> {
        let [width, height] = self.rays.size();
        let seen = Seen {
            series: self.series,
            way: way.to_owned(),
            scene: self.scene.to_owned(),
            triangles: self.triangles,
            width,
            height,
            threads: self.pool.current_num_threads(),
            covered: 0,
            different: None,
            judged: 0,
            samples_ns: Vec::new(),
        };
        Contender { seen, draw, first: None }
    }

    /// Rays through a tree.
    fn cast(
        &self,
        way: &str,
        tree: &'a dyn Tree,
        tracing: Tracing,
        rays: &'a [Ray<f32>],
    ) -> Contender<'a> {
        let (pool, mut found) = (self.pool, vec![None::<TriangleHit>; rays.len()]);
        self.contender(
            way,
            Box::new(move |show| {
                let start = Instant::now();
                pool.install(|| cast(tree, tracing, rays, &mut found));
                let time = start.elapsed();
                for hit in &found {
                    show(hit.map_or(NOTHING, |hit| u64::from(hit.triangle)));
                }
                (time, 0)
            }),
        )
    }

    /// Triangle by triangle.
    fn rasterised<C: Culls, E: Edges>(&self, way: &str, objects: &'a [Object]) -> Contender<'a> {
        let (pool, rays, mut raster) = (self.pool, self.rays, Rasteriser::<C, E>::new());
        self.contender(
            way,
            Box::new(move |show| {
                let start = Instant::now();
                pool.install(|| raster.draw(objects, rays));
                let time = start.elapsed();
                each(rays, |pixel| show(raster.seen(pixel).map_or(NOTHING, u64::from)));
                (time, raster.judged())
            }),
        )
    }

    /// By spans.
    fn spans(&self, objects: &'a [Object]) -> Contender<'a> {
        let (rays, mut scan) = (self.rays, Scan::default());
        self.contender(
            "spans",
            Box::new(move |show| {
                let start = Instant::now();
                scan.draw(objects, rays);
                let time = start.elapsed();
                each(rays, |pixel| show(scan.seen(pixel).map_or(NOTHING, u64::from)));
                (time, 0)
            }),
        )
    }

    /// In colours.
    fn painted<S: Shading, T: Texturing>(&self, way: &str, scenery: &'a Scenery) -> Contender<'a> {
        let (pool, rays) = (self.pool, self.rays);
        let mut painter = Painter::<S, T>::default();
        self.contender(
            way,
            Box::new(move |show| {
                let start = Instant::now();
                pool.install(|| painter.paint(scenery, rays));
                let time = start.elapsed();
                let colors = painter.pixels();
                let [width, height] = rays.size();
                for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                    let color = colors[y as usize * width as usize + x as usize].0;
                    let is_seen = painter.rasteriser().seen([x, y]).is_some();
                    show(if is_seen { u64::from(color) } else { NOTHING });
                }
                (time, 0)
            }),
        )
    }
}

fn each(rays: &PixelRays, of: impl FnMut([u32; 2])) {
    let [width, height] = rays.size();
    (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).for_each(of);
}

/// A study under way.
struct Drawing<'a, 'r> {
    study: &'a Raster,
    random: Pcg64,
    run: &'a mut Run<'r>,
}

/// Draws everything.
pub(super) fn measure(study: &Raster, run: &mut Run<'_>) -> Result<(), StudyError> {
    let mut drawing = Drawing { study, random: Pcg64::seed_from_u64(study.seed), run };
    for subject in meshes(study.copies) {
        drawing.visibility(&subject)?;
    }
    drawing.frame()
}

impl Drawing<'_, '_> {
    /// Times ways in turn, and counts where they differ from the one that they are held to.
    fn race(
        &mut self,
        name: &str,
        mut contenders: Vec<Contender<'_>>,
        held_to: usize,
    ) -> Result<(), WrongAnswer> {
        let steps = contenders.len() * (self.study.rounds + 1);
        self.run.progress.phase(name, steps as u64);
        let progress = &mut *self.run.progress;
        timing::rounds(
            &mut contenders,
            self.study.rounds,
            &mut self.random,
            |contender, timed| {
                contender.sample(timed)?;
                progress.step();
                Ok(())
            },
        )?;
        let right = contenders[held_to].first.clone();
        for mut contender in contenders {
            if let Some((right, own)) = right.as_ref().zip(contender.first.as_ref()) {
                let covered = own.iter().filter(|pixel| **pixel != NOTHING).count();
                let different = right.iter().zip(own).filter(|(a, b)| a != b).count();
                contender.seen.covered = covered as u64;
                contender.seen.different = Some(different as u64);
            }
            self.run.add(contender.seen);
        }
        Ok(())
    }

    /// Builds what a way needs, several times.
    fn build<T>(
        &mut self,
        what: &str,
        subject: &Subject,
        pool: &ThreadPool,
        build: impl Fn() -> T + Sync,
    ) -> T
    where
        T: Send,
    {
        let mut samples_ns = Vec::new();
        let mut built = None;
        for _ in 0..self.study.rounds.min(3) {
            let start = Instant::now();
            built = Some(pool.install(&build));
            samples_ns.push(nanoseconds(start.elapsed()));
        }
        self.run.add(Built {
            scene: subject.name.clone(),
            triangles: subject.triangles.len(),
            what: what.to_owned(),
            threads: pool.current_num_threads(),
            samples_ns,
        });
        built.expect("it was built")
    }

    /// What is seen of a mesh, by all ways, at all sizes.
    fn visibility(&mut self, subject: &Subject) -> Result<(), StudyError> {
        let (all, one) = (pool(self.study.threads)?, pool(1)?);
        let triangles: &[Triangle<f32>] = &subject.triangles;
        let blocks = self.build("blocks", subject, &all, || Arc::new(Blocks::new(triangles)));
        let tree = |entry: &Entry, builder: Builder| {
            entry.tree(triangles, builder).expect("it takes every mesh")
        };
        let mut quick = self.build("linear", subject, &all, || tree(reference(), Builder::Linear));
        let refit = Instant::now();
        all.install(|| quick.refit(triangles)).expect("they are the same triangles");
        self.run.add(Built {
            scene: subject.name.clone(),
            triangles: triangles.len(),
            what: "refit".to_owned(),
            threads: self.study.threads,
            samples_ns: vec![nanoseconds(refit.elapsed())],
        });
        let best = self.build("spatial", subject, &all, || tree(reference(), Builder::Spatial));
        let right = all.install(|| tree(exact(), Builder::Spatial));
        let objects = [Object::new(blocks)];
        for &size in &self.study.sizes {
            let rays = PixelRays::new(subject.camera.clone(), size);
            let list = all_rays(&rays);
            let at = At {
                series: Series::Visibility,
                scene: &subject.name,
                triangles: triangles.len(),
                rays: &rays,
                pool: &all,
            };
            let contenders = vec![
                at.cast("cast, exact", &*right, Tracing::Single, &list),
                at.cast("cast, single", &*best, Tracing::Single, &list),
                at.cast("cast, packets", &*best, Tracing::Packets, &list),
                at.cast("cast, linear", &*quick, Tracing::Packets, &list),
                at.rasterised::<NoCulling, Filtered>("rasterised, filtered", &objects),
                at.rasterised::<NoCulling, Bare>("rasterised, bare", &objects),
            ];
            let name = format!("{}, {} by {}", subject.name, size[0], size[1]);
            self.race(&name, contenders, 0)?;
            let at = At { series: Series::Ways, pool: &one, ..at };
            let contenders = vec![
                at.rasterised::<NoCulling, Filtered>("filtered", &objects),
                at.rasterised::<NoCulling, Bare>("bare", &objects),
                at.rasterised::<PerspectiveCulling, Bare>("bare, culled by the eye", &objects),
                at.rasterised::<RoughCulling, Bare>("bare, culled by the axis", &objects),
                at.spans(&objects),
            ];
            self.race(&format!("{name}, one thread"), contenders, 0)?;
        }
        Ok(())
    }

    /// The frame of 2012.
    fn frame(&mut self) -> Result<(), StudyError> {
        let (one, scene) = (pool(1)?, frame());
        let scenery = Scenery::new(&scene, scene.lights.len());
        let rays = scenery.rays(0, self.study.frame);
        let at = At {
            series: Series::Frame,
            scene: "three textured objects",
            triangles: scenery.triangles(),
            rays: &rays,
            pool: &one,
        };
        let contenders = vec![
            at.painted::<Unlit, Perspective>("unlit", &scenery),
            at.painted::<Flat, Perspective>("flat", &scenery),
            at.painted::<Gouraud, Perspective>("Gouraud", &scenery),
            at.painted::<Phong, Perspective>("Phong", &scenery),
            at.painted::<Identity, NoTexture>("numbers", &scenery),
        ];
        self.race("the frame of 2012", contenders, 3)?;
        let at = At { series: Series::Textures, ..at };
        let contenders = vec![
            at.painted::<Gouraud, NoTexture>("none", &scenery),
            at.painted::<Gouraud, Affine>("affine", &scenery),
            at.painted::<Gouraud, Perspective>("perspective", &scenery),
        ];
        Ok(self.race("textures", contenders, 2)?)
    }
}
