//! Pictures with what their scene does not need put back into the renderer.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use rand_pcg::Pcg64;
use rayon::ThreadPool;
use trisect_catalog::Builder;
use trisect_render::{Facts, Image, Part, Parts, Renderer, Settings, Stage, Watch};
use trisect_scene::{SHIPPED, Scene};

use super::measure::{Leaving, Raced, Subject, in_turn};
use super::record::{Layer, Omission};
use crate::kernels::{REFERENCE, reference};
use crate::study::Progress;
use crate::study::{StudyError, pool};
use crate::timing::WrongAnswer;

/// All parts that are left out together, where there are several.
const EVERYTHING: &str = "everything";

/// A picture that is made in turn with others.
struct Contender<'a> {
    name: &'static str,
    renderer: Renderer<'a>,
    first: Option<Image>,
}

/// What was found about the pictures of a scene.
pub(super) struct OfPictures {
    /// What there is in it.
    pub facts: Facts,
    /// What its picture needs.
    pub needs: Parts,
    /// What the rest costs.
    pub omissions: Vec<Omission>,
    /// Nanoseconds of each picture without it.
    pub without_ns: Vec<u64>,
    /// Rays of a picture.
    pub rays: u64,
}

/// Finds what a scene's picture needs, and times pictures with each part put back that it does without, and
/// with everything.
pub(super) fn of_pictures(
    (scene, of, method): (&str, &str, &str),
    (stage, settings): (&Stage, &Settings),
    rounds: usize,
    pool: &ThreadPool,
    random: &mut Pcg64,
    progress: &mut dyn Progress,
) -> Result<OfPictures, WrongAnswer> {
    let own = Renderer::new(stage);
    let facts = own.facts();
    let needs = facts.needs(settings);
    let contender = |name, renderer| Contender { name, renderer, first: None };
    let left_out = Part::ALL.into_iter().filter(|part| !needs.has(*part));
    let mut with: Vec<(&str, Contender<'_>)> = left_out
        .map(|part| {
            let renderer = Renderer::new(stage).keeping(part.into());
            (part.name(), contender(part.name(), renderer))
        })
        .collect();
    // Where one part alone is left out, everything is that part.
    if with.len() > 1 {
        let all = Renderer::new(stage).keeping(Parts::ALL);
        with.push((EVERYTHING, contender(EVERYTHING, all)));
    }
    progress.phase(&format!("{scene}: pictures"), ((with.len() + 1) * (rounds + 1)) as u64);
    let watch = Watch { stop: &AtomicBool::new(false), tile: &|| () };
    let subject = Subject { layer: Layer::Picture, scene, of, method };
    let raced = in_turn(&subject, contender("own", own), with, rounds, random, |contender| {
        let start = Instant::now();
        let image = pool.install(|| contender.renderer.render(settings, &watch));
        let time = start.elapsed();
        let image = image.expect("nobody stops it");
        let is_same = contender.first.as_ref().is_none_or(|first| *first == image);
        contender.first = Some(image);
        progress.step();
        if is_same { Ok(time) } else { Err(changed(contender.name)) }
    })?;
    let Raced { without_ns, omissions, contenders } = raced;
    let (own, others) = contenders.split_first().expect("the scene's own is there");
    if let Some(other) = others.iter().find(|other| other.first != own.first) {
        return Err(changed(other.name));
    }
    let rays = own.renderer.counts().total() / (rounds as u64 + 1);
    Ok(OfPictures { facts, needs, omissions, without_ns, rays })
}

fn changed(part: &str) -> WrongAnswer {
    WrongAnswer {
        kernel: format!("the renderer with {part}"),
        found: "another picture".to_owned(),
        expected: "the same picture".to_owned(),
    }
}

impl Leaving<'_, '_> {
    /// All scenes that are shipped, and a mesh alone, smooth and flat: each as it is, and in ambient light
    /// alone.
    pub(super) fn pictures(&mut self) -> Result<(), StudyError> {
        let one = pool(1)?;
        let mut scenes: Vec<(String, Scene)> = Vec::new();
        for (path, _) in SHIPPED {
            let name = path.rsplit('/').next().unwrap_or(path);
            match name.rsplit_once('.') {
                Some((_, "toml")) => scenes.push((name.to_owned(), Scene::shipped(path)?)),
                Some((_, "ply")) => {
                    let smooth = Scene::shipped(path)?;
                    let mut flat = smooth.clone();
                    flat.instances.iter_mut().for_each(|instance| instance.smooth = false);
                    scenes.extend([(name.to_owned(), smooth), (format!("{name}, flat"), flat)]);
                }
                _ => {}
            }
        }
        for (name, scene) in scenes {
            let lights = scene.lights.len();
            let stage =
                Stage::new(scene, |triangles| reference().tree(triangles, Builder::Spatial))
                    .expect("the reference takes every mesh");
            for (depth, lights) in [(16, lights), (0, 0)] {
                let settings = Settings { depth, lights, ..Settings::new(self.study.picture) };
                let of = format!("depth {depth}, lights {lights}");
                let pictures = of_pictures(
                    (&name, &of, REFERENCE),
                    (&stage, &settings),
                    self.study.rounds,
                    &one,
                    &mut self.random,
                    self.run.progress,
                )?;
                self.found(pictures.omissions);
            }
        }
        Ok(())
    }
}
