//! Rays from inside closed surfaces, aimed at edges and vertices: which pass through?

use std::ops::ControlFlow;

use rayon::prelude::*;
use trisect_catalog::{Entry, Finder};
use trisect_core::{MultiplyAdd, Ray, Triangle, Vec3};
use trisect_method::{Culling, Form};
use trisect_workloads::{Aim, Feature, Placement, Surface};

use super::measure::{Compiled, finders};
use super::record::{Site, SurfaceCracks};
use super::settings::Stability;
use crate::record::Line;
use crate::study::Run;

/// Offsets that the rays of watertight forms are multiplied at.
const OFFSETS: [f64; 3] = [0.0, 1e3, 1e6];

/// Rays that are tested against a whole surface at once.
const MISSED: usize = 1024;

/// A closed surface, put somewhere, with rays aimed at one kind of feature.
struct Place<'a> {
    surface: &'a Surface,
    features: &'a [Feature],
    aim: Aim,
    offset: f64,
    scale: f64,
}

impl Place<'_> {
    fn placement(&self) -> Placement {
        // A direction without zeros, so that every coordinate of a corner is moved.
        let along = Vec3::new(0.6, -0.48, 0.64);
        Placement { scale: self.scale, offset: along.scale(self.offset) }
    }

    /// Whether it is among those that watertight forms are held to with more rays.
    fn is_claimed(&self) -> bool {
        self.scale == 1.0 && OFFSETS.contains(&self.offset)
    }
}

/// Counts the rays that hit nothing, and those that hit more than one of the triangles that they are
/// aimed at.
pub(super) fn cracks(settings: &Stability, run: &mut Run<'_>) {
    let surfaces = [Surface::sphere(3), Surface::ragged_sphere(settings.seed), Surface::cube(4)];
    let aimed: Vec<(&Surface, Aim, Vec<Feature>)> = surfaces
        .iter()
        .flat_map(|surface| {
            [Aim::Edges, Aim::Vertices].map(|aim| (surface, aim, surface.features(aim)))
        })
        .collect();
    let mut places = Vec::new();
    for (surface, aim, features) in &aimed {
        let place = |offset, scale| Place { surface, features, aim: *aim, offset, scale };
        places.extend(OFFSETS.map(|offset| place(offset, 1.0)));
        if surface.name == "sphere" {
            places.extend([1e1, 1e2, 1e4, 1e5].map(|offset| place(offset, 1.0)));
            places.extend([1e-12, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9].map(|scale| place(0.0, scale)));
        }
    }
    run.each("stress: looking for cracks", settings.methods.iter(), |entry| {
        let mut lines = of_precision::<f32>(settings, entry, &places);
        lines.extend(of_precision::<f64>(settings, entry, &places));
        lines
    });
}

fn of_precision<E: Compiled>(
    settings: &Stability,
    entry: &Entry,
    places: &[Place<'_>],
) -> Vec<Line> {
    let kernels = E::kernels(entry);
    let finders = finders(kernels);
    let claimed = places.iter().filter(|place| place.is_claimed()).count() / OFFSETS.len() / 2;
    // The claim is about plain arithmetic and the deferred form.
    let is_claim = |finder: &Finder| {
        entry.info.claims.watertight
            && finder.variant.arithmetic == MultiplyAdd::Plain
            && finder.variant.division == Form::Deferred
    };
    let mut lines: Vec<SurfaceCracks> = finders
        .iter()
        .map(|finder| SurfaceCracks { variant: finder.variant.clone(), sites: Vec::new() })
        .collect();
    for place in places {
        let more = settings.watertight_rays.div_ceil(claimed.max(1));
        let triangles = place.surface.triangles::<E>(&place.placement());
        if (kernels.prepare)(&triangles, &[]).is_err() {
            continue;
        }
        for (finder, line) in finders.iter().zip(&mut lines) {
            let many = place.is_claimed() && is_claim(finder);
            let rays = if many { more } else { settings.crack_rays };
            line.sites.push(count::<E>(settings.seed, entry, finder, place, &triangles, rays));
        }
    }
    lines.into_iter().map(Line::from).collect()
}

/// A ray is tested against the triangles that meet where it is aimed; where it hits none of them,
/// against all.
fn count<E: Compiled>(
    seed: u64,
    entry: &Entry,
    finder: &Finder,
    place: &Place<'_>,
    triangles: &[Triangle<E>],
    rays: usize,
) -> Site {
    let kernels = E::kernels(entry);
    let each = rays.div_ceil(place.features.len());
    let around: Vec<(usize, Vec<Ray<E>>)> = place
        .features
        .par_iter()
        .map(|feature| {
            let rays = place.surface.aimed::<E>(feature, &place.placement(), seed, each);
            let near: Vec<Triangle<E>> =
                feature.faces.iter().map(|&number| triangles[number]).collect();
            let mut hits = vec![0_u32; rays.len()];
            if let Ok(scene) = (kernels.prepare)(&near, &rays) {
                finder.find(&scene, Culling::None, &mut |ray, _, _| {
                    hits[ray] += 1;
                    ControlFlow::Continue(())
                });
            }
            let many = hits.iter().filter(|&&hits| hits > 1).count();
            let missed = rays.into_iter().zip(hits).filter(|(_, hits)| *hits == 0);
            (many, missed.map(|(ray, _)| ray).collect())
        })
        .collect();
    let many_hits = around.iter().map(|(many, _)| many).sum();
    let missed: Vec<Ray<E>> = around.into_iter().flat_map(|(_, missed)| missed).collect();
    let no_hit = missed
        .par_chunks(MISSED)
        .map(|rays| {
            let scene = (kernels.prepare)(triangles, rays);
            let any = scene.map(|scene| finder.any(&scene, Culling::None, rays.len()));
            any.map_or(rays.len(), |any| any.iter().filter(|hit| !**hit).count())
        })
        .sum();
    Site {
        surface: place.surface.name.to_owned(),
        aim: place.aim.name().to_owned(),
        offset: place.offset,
        scale: place.scale,
        rays: each * place.features.len(),
        no_hit,
        many_hits,
    }
}
