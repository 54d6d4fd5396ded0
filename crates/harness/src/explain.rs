//! What a scene needs, what is left out for it, and what each omission gains on it.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use rand::SeedableRng as _;
use rand_pcg::Pcg64;
use rayon::ThreadPool;
use serde::Serialize;
use trisect_render::{Facts, Image, Part, Parts, Renderer, Settings, Stage, Watch};

use crate::Progress;
use crate::timing::{self, WrongAnswer, nanoseconds};

/// A part of the renderer, and whether a scene's picture does without it.
#[derive(Clone, Debug, Serialize)]
pub struct Omission {
    /// The part's name; `everything` for all that is left out together.
    pub part: &'static str,
    /// Whether it is left out.
    pub left_out: bool,
    /// How much longer pictures take with it than without, as a share: the median over pairs that were
    /// timed in the same round.
    pub gain: Option<f64>,
    /// The quartiles of these pairs.
    pub quartiles: Option<[f64; 2]>,
}

/// What was found about a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Explanation {
    /// Spheres, planes, and places: of meshes that rays are carried to, and of trees.
    pub shapes: [usize; 4],
    /// Materials with a texture, and triangles with interpolated normals.
    pub varying: [usize; 2],
    /// Lights.
    pub lights: usize,
    /// Materials that are mirrors, and clear ones.
    pub onward: [usize; 2],
    /// Every part, and everything that is left out together.
    pub omissions: Vec<Omission>,
    /// Pictures of each kind that were timed.
    pub rounds: usize,
    /// Rays of a picture.
    pub rays: u64,
    /// Median nanoseconds of a picture, with nothing that the scene does not need.
    pub picture_ns: u64,
}

/// A picture that is made in turn with others.
struct Contender<'a> {
    name: &'static str,
    renderer: Renderer<'a>,
    first: Option<Image>,
    samples_ns: Vec<u64>,
}

/// Finds what a scene needs for a picture, and times pictures with each part put back that is left out.
///
/// # Errors
/// When a part that is put back changes the picture.
///
/// # Panics
/// As [`Renderer::render`].
pub fn explain(
    stage: &Stage,
    settings: &Settings,
    (rounds, seed): (usize, u64),
    pool: &ThreadPool,
    progress: &mut dyn Progress,
) -> Result<Explanation, WrongAnswer> {
    let own = Renderer::new(stage);
    let facts = own.facts();
    let needs = facts.needs(settings);
    let contender = |name, renderer| Contender {
        name,
        renderer,
        first: None,
        samples_ns: Vec::with_capacity(rounds),
    };
    let mut contenders = vec![contender("own", own)];
    for part in Part::ALL.into_iter().filter(|part| !needs.has(*part)) {
        contenders.push(contender(part.name(), Renderer::new(stage).keeping(part.into())));
    }
    // Where one part alone is left out, everything is that part.
    if contenders.len() > 2 {
        contenders.push(contender("everything", Renderer::new(stage).keeping(Parts::ALL)));
    }
    progress.phase("pictures", (contenders.len() * (rounds + 1)) as u64);
    let watch = Watch { stop: &AtomicBool::new(false), tile: &|| () };
    let mut random = Pcg64::seed_from_u64(seed);
    timing::rounds(&mut contenders, rounds, &mut random, |contender, timed| {
        let start = Instant::now();
        let image = pool.install(|| contender.renderer.render(settings, &watch));
        let time = start.elapsed();
        let image = image.expect("nobody stops it");
        let same = contender.first.as_ref().is_none_or(|first| *first == image);
        contender.first = Some(image);
        if timed {
            contender.samples_ns.push(nanoseconds(time));
        }
        progress.step();
        if same { Ok(()) } else { Err(changed(contender.name)) }
    })?;
    let (own, others) = contenders.split_first().expect("the scene's own is there");
    if let Some(other) = others.iter().find(|other| other.first != own.first) {
        return Err(changed(other.name));
    }
    let mut omissions: Vec<Omission> = Part::ALL
        .into_iter()
        .map(|part| Omission {
            part: part.name(),
            left_out: !needs.has(part),
            gain: None,
            quartiles: None,
        })
        .collect();
    for other in others {
        let pairs = other.samples_ns.iter().zip(&own.samples_ns);
        let mut gains: Vec<f64> =
            pairs.map(|(with, without)| *with as f64 / (*without).max(1) as f64 - 1.0).collect();
        gains.sort_unstable_by(f64::total_cmp);
        let at = |quarter: usize| gains[gains.len() * quarter / 4];
        let measured = Omission {
            part: other.name,
            left_out: true,
            gain: Some(at(2)),
            quartiles: Some([at(1), at(3)]),
        };
        match omissions.iter_mut().find(|omission| omission.part == other.name) {
            Some(omission) => *omission = measured,
            None => omissions.push(measured),
        }
    }
    let Facts { spheres, planes, carried, trees, .. } = facts;
    let Facts { interpolated, textured, lights, mirrors, clear, .. } = facts;
    let mut samples = own.samples_ns.clone();
    samples.sort_unstable();
    Ok(Explanation {
        shapes: [spheres, planes, carried, trees],
        varying: [textured, interpolated],
        lights: lights.min(settings.lights),
        onward: [mirrors, clear],
        omissions,
        rounds,
        rays: own.renderer.counts().total() / (rounds as u64 + 1),
        picture_ns: samples[samples.len() / 2],
    })
}

fn changed(part: &str) -> WrongAnswer {
    WrongAnswer {
        kernel: format!("the renderer with {part}"),
        found: "another picture".to_owned(),
        expected: "the same picture".to_owned(),
    }
}
