//! Frames per second of the mirror scene, and pictures of every feature.

use std::io::Cursor;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use rand::SeedableRng as _;
use rand_pcg::Pcg64;
use rayon::ThreadPool;
use trisect_catalog::{BuildTree, Builder, Leaves, Tree, every_triangle, scalar_tree};
use trisect_core::Triangle;
use trisect_method::UnsuitableMesh;
use trisect_render::{
    Image, ImageFormat, Mode, Occlusion, Renderer, Sampling, Settings, Stage, Watch,
};
use trisect_scene::Scene;

use super::morozov::{self, Asked, Row};
use super::record::{FrameSeries, Frames, Picture};
use super::settings::Pictures;
use crate::kernels::{REFERENCE, reference};
use crate::study::{Run, StudyError, pool};
use crate::timing::middle;
use crate::timing::{self, WrongAnswer, nanoseconds};
use crate::tracer::measure::thread_counts;

/// The scene that is timed.
const MIRROR: &str = "scenes/mirror.toml";

/// Name, samples, depth and lights, from low to very hard.
pub(super) const LEVELS: [(&str, u32, u32, usize); 4] =
    [("low", 1, 1, 1), ("middle", 2, 2, 1), ("hard", 3, 4, 2), ("very hard", 3, 8, 2)];

pub(super) const SIZES: [[u32; 2]; 4] = [[512, 512], [800, 600], [1024, 768], [1920, 1080]];

/// The picture that all series but the first are variations of.
const GOAL: [u32; 2] = [640, 480];

/// Small, as testing every triangle takes its time.
const SMALL: [u32; 2] = [160, 120];

/// Of pictures to look at.
const SHOWN: [u32; 2] = [320, 240];

/// How much pictures may differ that different kernels made: see [`Image::difference`].
const DIFFERENT: f64 = 0.02;

/// Pictures of the mirror scene, timed; then a picture of every feature.
pub(super) fn measure(study: &Pictures, run: &mut Run<'_>) -> Result<(), StudyError> {
    let mirror = Scene::shipped(MIRROR)?;
    let mut drawing = Drawing { study, random: Pcg64::seed_from_u64(study.seed), run };
    drawing.variations(&mirror)?;
    drawing.techniques(&mirror)?;
    if study.morozov {
        drawing.morozov()?;
    }
    drawing.features()
}

/// A study under way.
struct Drawing<'a, 'r> {
    study: &'a Pictures,
    random: Pcg64,
    run: &'a mut Run<'r>,
}

/// Pictures that are timed in turn with others.
struct Contender<'a> {
    frames: Frames,
    settings: Settings,
    renderer: Renderer<'a>,
    pool: &'a ThreadPool,
    /// The first one, which is not timed.
    first: Option<Image>,
}

impl Contender<'_> {
    /// Makes the picture once more; the first time it is not timed.
    fn sample(&mut self) -> Result<(), WrongAnswer> {
        let before = self.renderer.counts().total();
        let start = Instant::now();
        let image = draw(&mut self.renderer, &self.settings, self.pool);
        let time = start.elapsed();
        let rays = self.renderer.counts().total() - before;
        match &self.first {
            None => {
                self.frames.rays = rays;
                self.first = Some(image);
            }
            Some(first) if *first == image && self.frames.rays == rays => {
                self.frames.samples_ns.push(nanoseconds(time));
            }
            Some(first) => {
                let (root, _) = first.difference(&image);
                return Err(wrong(&self.frames, format!("another picture, different by {root}")));
            }
        }
        Ok(())
    }
}

fn wrong(frames: &Frames, found: String) -> WrongAnswer {
    WrongAnswer {
        kernel: format!("{:?}, {}", frames.series, frames.name),
        found,
        expected: "the same picture".to_owned(),
    }
}

fn draw(renderer: &mut Renderer<'_>, settings: &Settings, pool: &ThreadPool) -> Image {
    let watch = Watch { stop: &AtomicBool::new(false), tile: &|| () };
    pool.install(|| renderer.render(settings, &watch)).expect("nobody stops it")
}

/// One sample, one light, depth 16.
fn base(size: [u32; 2]) -> Settings {
    Settings { sampling: Sampling::Circle(1), lights: 1, depth: 16, ..Settings::new(size) }
}

impl Drawing<'_, '_> {
    /// A contender that is known by a name.
    fn contender<'a>(
        series: FrameSeries,
        name: impl Into<String>,
        (stage, leaves, method): (&'a Stage, Leaves, &str),
        settings: Settings,
        pool: &'a ThreadPool,
    ) -> Contender<'a> {
        let [width, height] = settings.size;
        let frames = Frames {
            series,
            name: name.into(),
            scene: "mirror".to_owned(),
            method: method.to_owned(),
            width,
            height,
            samples: settings.sampling.count(),
            depth: settings.depth,
            lights: settings.lights,
            threads: pool.current_num_threads(),
            tile: settings.tile,
            leaves: leaves.name().to_owned(),
            triangles: stage.triangles(),
            rays: 0,
            samples_ns: Vec::new(),
        };
        Contender { frames, settings, renderer: Renderer::new(stage), pool, first: None }
    }

    /// Times contenders in turn, in a new order each round.
    fn race(&mut self, contenders: &mut [Contender<'_>]) -> Result<(), WrongAnswer> {
        let progress = &mut *self.run.progress;
        timing::rounds(contenders, self.study.rounds, &mut self.random, |contender, _| {
            contender.sample()?;
            progress.step();
            Ok(())
        })
    }

    /// What the speed depends on, one thing after another.
    fn variations(&mut self, mirror: &Scene) -> Result<(), StudyError> {
        let all = pool(self.study.threads)?;
        let trees: Vec<(Leaves, Stage)> = Leaves::ALL
            .into_iter()
            .map(|leaves| {
                let tree = |triangles: &[Triangle<f32>]| {
                    reference().tree_with(triangles, Builder::Spatial, leaves)
                };
                (leaves, stage(mirror, tree))
            })
            .collect();
        let (leaves, stage) = &trees[0];
        let usual = (stage, *leaves, REFERENCE);
        let pools = thread_counts(self.study.threads)
            .into_iter()
            .map(pool)
            .collect::<Result<Vec<_>, _>>()?;
        let goal = || base(self.study.size(GOAL));
        let mut contenders = vec![Self::contender(FrameSeries::Goal, "goal", usual, goal(), &all)];
        for size in SIZES.into_iter().filter(|size| size[1] <= self.study.largest) {
            for (name, samples, depth, lights) in LEVELS {
                let sampling = Sampling::Circle(samples);
                let size = self.study.size(size);
                let settings = Settings { sampling, depth, lights, ..base(size) };
                contenders.push(Self::contender(FrameSeries::Sizes, name, usual, settings, &all));
            }
        }
        for pool in &pools {
            let threads = pool.current_num_threads().to_string();
            contenders.push(Self::contender(FrameSeries::Threads, threads, usual, goal(), pool));
        }
        for samples in [1, 2, 3, 4, 6, 8] {
            let settings = Settings { sampling: Sampling::Circle(samples), ..goal() };
            let name = samples.to_string();
            contenders.push(Self::contender(FrameSeries::Samples, name, usual, settings, &all));
        }
        for lights in 0..=mirror.lights.len() {
            let settings = Settings { lights, ..goal() };
            let name = lights.to_string();
            contenders.push(Self::contender(FrameSeries::Lights, name, usual, settings, &all));
        }
        for depth in [0, 1, 2, 4, 8, 16] {
            let settings = Settings { depth, ..goal() };
            let name = depth.to_string();
            contenders.push(Self::contender(FrameSeries::Depth, name, usual, settings, &all));
        }
        for (leaves, stage) in &trees {
            let of = (stage, *leaves, REFERENCE);
            let series = FrameSeries::Leaves;
            contenders.push(Self::contender(series, leaves.name(), of, goal(), &all));
        }
        for tile in [4, 8, 16, 32, 64, 128, 256] {
            let settings = Settings { tile, ..goal() };
            let name = tile.to_string();
            contenders.push(Self::contender(FrameSeries::Tiles, name, usual, settings, &all));
        }
        let steps = contenders.len() * (self.study.rounds + 1);
        self.run.progress.phase("mirror scene", steps as u64);
        self.race(&mut contenders)?;
        // Neither threads nor tiles nor leaves may change the picture.
        let goal = contenders[0].first.clone();
        for contender in &contenders {
            let same = match contender.frames.series {
                FrameSeries::Threads | FrameSeries::Tiles => contender.first == goal,
                FrameSeries::Leaves => is_like(contender.first.as_ref(), goal.as_ref()),
                _ => true,
            };
            if !same {
                return Err(wrong(&contender.frames, "another picture".to_owned()).into());
            }
        }
        self.run.lines.extend(contenders.into_iter().map(|contender| contender.frames.into()));
        Ok(())
    }

    /// From the plain tracer to this one, one technique after another.
    fn techniques(&mut self, mirror: &Scene) -> Result<(), StudyError> {
        let (one, all) = (pool(1)?, pool(self.study.threads)?);
        let leaves = Leaves::Cheapest;
        let of = |build: BuildTree| {
            Stage::new(mirror.clone(), |triangles: &[Triangle<f32>]| {
                build(triangles, Builder::Spatial, leaves)
            })
        };
        let [plain, scalar, lanes] = [every_triangle, scalar_tree, reference().erased_tree]
            .map(|build| of(build).expect("the reference takes every mesh"));
        // Tiles so small that all threads have their share of a small picture.
        let small = self.study.size(SMALL);
        let settings = || Settings { tile: 16, ..base(small) };
        let series = FrameSeries::Techniques;
        let mut contenders = Vec::new();
        for (name, stage, pool) in [
            ("every triangle, scalar, one thread", &plain, &one),
            ("tree", &scalar, &one),
            ("SIMD", &lanes, &one),
            ("threads", &lanes, &all),
        ] {
            let of = (stage, leaves, REFERENCE);
            contenders.push(Self::contender(series, name, of, settings(), pool));
        }
        // The kernel: all in turn with the rest, and the fastest is the technique.
        let techniques = contenders.len();
        let entries = self.study.methods.iter();
        let kernels: Vec<(&str, Stage)> = entries
            .filter_map(|entry| Some((entry.info.name, of(entry.erased_tree).ok()?)))
            .collect();
        for (name, stage) in &kernels {
            let of = (stage, leaves, *name);
            contenders.push(Self::contender(series, "kernel", of, settings(), &all));
        }
        let steps = contenders.len() * (self.study.rounds + 1);
        self.run.progress.phase("techniques", steps as u64);
        self.race(&mut contenders)?;
        let mut others = contenders.split_off(techniques);
        let expected = contenders[0].first.clone();
        for contender in &contenders {
            if !is_like(contender.first.as_ref(), expected.as_ref()) {
                return Err(wrong(&contender.frames, "another picture".to_owned()).into());
            }
        }
        // A method so imprecise that it is seen is no candidate, however fast.
        others.retain(|contender| is_like(contender.first.as_ref(), expected.as_ref()));
        let time = |contender: &Contender<'_>| middle(&contender.frames.samples_ns);
        others.sort_by(|a, b| time(a).total_cmp(&time(b)));
        contenders.extend(others.into_iter().take(1));
        self.run.lines.extend(contenders.into_iter().map(|contender| contender.frames.into()));
        Ok(())
    }

    /// A picture of Morozov's as this study asks for it.
    fn asked(&self, Asked { size, samples, depth, lights }: Asked) -> Settings {
        let sampling = Sampling::Circle(samples);
        Settings { sampling, depth, lights, ..base(self.study.size(size)) }
    }

    /// Morozov's headline settings, and the rows of his tables at each of his levels. What this tracer has no like of, leaves of other sizes
    /// than its own, is left out.
    fn morozov(&mut self) -> Result<(), StudyError> {
        let scene = Scene::shipped(&format!("scenes/{}.toml", morozov::SCENE))?;
        let all = pool(self.study.threads)?;
        let trees = Leaves::ALL.map(|leaves| {
            let tree = |triangles: &[Triangle<f32>]| {
                reference().tree_with(triangles, Builder::Spatial, leaves)
            };
            (leaves, stage(&scene, tree))
        });
        let (leaves, stage) = &trees[0];
        let usual = (stage, *leaves, REFERENCE);
        let mut goals: Vec<_> = morozov::GOALS
            .into_iter()
            .map(|(asked, _)| {
                let (series, settings) = (FrameSeries::Goal, self.asked(asked));
                let mut goal = Self::contender(series, asked.name(), usual, settings, &all);
                morozov::SCENE.clone_into(&mut goal.frames.scene);
                goal
            })
            .collect();
        let steps = goals.len() * (self.study.rounds + 1);
        self.run.progress.phase("Morozov's headline pictures", steps as u64);
        self.race(&mut goals)?;
        self.run.lines.extend(goals.into_iter().map(|goal| goal.frames.into()));
        for series in [
            FrameSeries::Threads,
            FrameSeries::Samples,
            FrameSeries::Lights,
            FrameSeries::Depth,
            FrameSeries::Leaves,
            FrameSeries::Tiles,
        ] {
            let mut rows: Vec<Row> = morozov::rows().filter(|row| row.series == series).collect();
            // Two of his tables are of threads.
            rows.sort_by_key(|row| row.x);
            rows.dedup_by_key(|row| row.x);
            let pools = rows.iter().map(|row| match series {
                FrameSeries::Threads => pool(row.x as usize).map(Some),
                _ => Ok(None),
            });
            let pools = pools.collect::<Result<Vec<_>, _>>()?;
            for (level, (name, ..)) in LEVELS.into_iter().enumerate() {
                let contender = |place: usize| {
                    let (row, pool) = (&rows[place], &pools[place]);
                    let (leaves, stage) = match series {
                        FrameSeries::Leaves => {
                            trees.iter().find(|(leaves, _)| leaves.name() == row.x.to_string())?
                        }
                        _ => &trees[0],
                    };
                    let mut settings = self.asked(row.at(level));
                    if series == FrameSeries::Tiles {
                        settings.tile = morozov::tile_of(row.x, self.study.threads, settings.size);
                    }
                    let pool = pool.as_ref().unwrap_or(&all);
                    let of = (stage, *leaves, REFERENCE);
                    let mut contender =
                        Self::contender(series, row.name(level), of, settings, pool);
                    morozov::SCENE.clone_into(&mut contender.frames.scene);
                    Some(contender)
                };
                let mut contenders: Vec<_> = (0..rows.len()).filter_map(contender).collect();
                let steps = contenders.len() * (self.study.rounds + 1);
                self.run.progress.phase(&format!("Morozov's {name} pictures"), steps as u64);
                self.race(&mut contenders)?;
                let frames = contenders.into_iter().map(|contender| contender.frames.into());
                self.run.lines.extend(frames);
            }
        }
        Ok(())
    }

    /// A picture of each feature.
    fn features(&mut self) -> Result<(), StudyError> {
        let features = features();
        self.run.progress.phase("features", features.len() as u64);
        for (name, says, scene, settings) in features {
            let settings = Settings { size: self.study.size(settings.size), ..settings };
            let tree = |triangles: &[Triangle<f32>]| reference().tree(triangles, Builder::Spatial);
            let stage = stage(&Scene::shipped(&format!("scenes/{scene}"))?, tree);
            let watch = Watch { stop: &AtomicBool::new(false), tile: &|| () };
            let image = Renderer::new(&stage).render(&settings, &watch).expect("nobody stops it");
            let mut file = Cursor::new(Vec::new());
            image.write(ImageFormat::Png, &mut file).expect("memory can be written");
            self.run.add(Picture {
                name: name.to_owned(),
                says: says.to_owned(),
                width: settings.size[0],
                height: settings.size[1],
                png: BASE64.encode(file.into_inner()),
            });
            self.run.progress.step();
        }
        Ok(())
    }
}

/// The scene in trees of a method that takes every mesh.
fn stage<B>(scene: &Scene, build: B) -> Stage
where
    B: Fn(&[Triangle<f32>]) -> Result<Box<dyn Tree>, UnsuitableMesh>,
{
    Stage::new(scene.clone(), build).expect("the reference takes every mesh")
}

/// Whether pictures differ no more than kernels make them.
fn is_like(image: Option<&Image>, other: Option<&Image>) -> bool {
    image.zip(other).is_some_and(|(image, other)| image.difference(other).0 < DIFFERENT)
}

/// Name, what is to be seen, scene and settings of each picture.
fn features() -> Vec<(&'static str, &'static str, &'static str, Settings)> {
    let with = |sampling| Settings { sampling, ..Settings::new(SHOWN) };
    let fine = || with(Sampling::Grid(4));
    let occlusion = Some(Occlusion { rays: 64, distance: f32::INFINITY });
    let occluded = Mode::Whitted { occlusion };
    let paths =
        Settings { mode: Mode::Paths, depth: 8, size: [240, 240], ..with(Sampling::Jittered(24)) };
    vec![
        (
            "Mirrors",
            "The mirror scene: a ball and a chair of 10,817 triangles, depth 16.",
            "mirror.toml",
            fine(),
        ),
        (
            "Mirrors, depth 1",
            "The same where a mirror in a mirror is black.",
            "mirror.toml",
            Settings { depth: 1, ..fine() },
        ),
        (
            "Shadow edges",
            "Instances of one mesh; lights from a point, a cone and a direction.",
            "teapots.toml",
            fine(),
        ),
        (
            "From above",
            "The same through an orthographic camera.",
            "teapots.toml",
            Settings { camera: 1, ..fine() },
        ),
        (
            "Ambient occlusion",
            "The same without lights: 64 rays a point.",
            "teapots.toml",
            Settings { mode: occluded, lights: 0, ..fine() },
        ),
        (
            "Total internal reflection",
            "The block's inner sides are mirrors at flat angles; the blue ball colours its shadow.",
            "glass.toml",
            fine(),
        ),
        (
            "Texture at grazing angles",
            "36 samples in a grid.",
            "textures.toml",
            with(Sampling::Grid(6)),
        ),
        ("One sample", "Antialiasing patterns: none.", "textures.toml", with(Sampling::ONE)),
        ("Grid", "Four samples in a grid.", "textures.toml", with(Sampling::Grid(2))),
        ("Circle", "Four samples on a circle.", "textures.toml", with(Sampling::Circle(4))),
        ("Jittered", "Four jittered samples.", "textures.toml", with(Sampling::Jittered(2))),
        (
            "Adaptive",
            "Four jittered samples, and 16 more where those differ.",
            "textures.toml",
            with(Sampling::Adaptive(4)),
        ),
        ("Thin lens", "64 samples over a lens.", "lens.toml", with(Sampling::Jittered(8))),
        (
            "Traced paths",
            "576 paths a pixel: light goes from wall to wall and through glass.",
            "room.toml",
            paths,
        ),
    ]
}
