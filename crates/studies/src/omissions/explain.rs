//! What a scene needs, what is left out for it, and what each omission gains on it.

use rand::SeedableRng as _;
use rand_pcg::Pcg64;
use rayon::ThreadPool;
use serde::Serialize;
use trisect_render::{Facts, Part, Settings, Stage};

use super::pictures::{OfPictures, of_pictures};
use crate::study::Progress;
use crate::timing::WrongAnswer;
use crate::timing::middle;

/// A part of the renderer, and whether a scene's picture does without it.
#[derive(Clone, Debug, Serialize)]
pub struct ExplainedPart {
    /// The part's name; `everything` for all that is left out together.
    pub part: String,
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
    /// Samples of each pixel, the first ones where there may be more.
    pub samples: u32,
    /// Materials that are mirrors, and clear ones.
    pub onward: [usize; 2],
    /// Every part, and everything that is left out together.
    pub omissions: Vec<ExplainedPart>,
    /// Pictures of each kind that were timed.
    pub rounds: usize,
    /// Rays of a picture.
    pub rays: u64,
    /// Median nanoseconds of a picture, with nothing that the scene does not need.
    pub picture_ns: f64,
}

/// Finds what a scene needs for a picture, and times pictures with each part put back that is left out.
///
/// # Errors
/// When a part that is put back changes the picture.
///
/// # Panics
/// As [`trisect_render::Renderer::render`].
pub fn explain(
    stage: &Stage,
    settings: &Settings,
    (rounds, seed): (usize, u64),
    pool: &ThreadPool,
    progress: &mut dyn Progress,
) -> Result<Explanation, WrongAnswer> {
    let mut random = Pcg64::seed_from_u64(seed);
    let found = of_pictures(
        ("scene", "picture", ""),
        (stage, settings),
        rounds,
        pool,
        &mut random,
        progress,
    )?;
    let OfPictures { facts, needs, omissions: measured, without_ns, rays } = found;
    let mut omissions: Vec<ExplainedPart> = Part::ALL
        .into_iter()
        .map(|part| ExplainedPart {
            part: part.name().to_owned(),
            left_out: !needs.has(part),
            gain: None,
            quartiles: None,
        })
        .collect();
    for measured in measured {
        let Some((ratio, quartiles)) = measured.ratio() else { continue };
        let measured = ExplainedPart {
            part: measured.part,
            left_out: true,
            gain: Some(ratio - 1.0),
            quartiles: Some(quartiles.map(|ratio| ratio - 1.0)),
        };
        match omissions.iter_mut().find(|omission| omission.part == measured.part) {
            Some(omission) => *omission = measured,
            None => omissions.push(measured),
        }
    }
    let Facts { spheres, planes, carried, trees, .. } = facts;
    let Facts { interpolated, textured, lights, mirrors, clear, .. } = facts;
    Ok(Explanation {
        shapes: [spheres, planes, carried, trees],
        varying: [textured, interpolated],
        lights: lights.min(settings.lights),
        samples: settings.sampling.count(),
        onward: [mirrors, clear],
        omissions,
        rounds,
        rays,
        picture_ns: middle(&without_ns),
    })
}
