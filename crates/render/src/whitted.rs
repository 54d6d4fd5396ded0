//! Whitted's shading: lights, ambient light, mirrors and glass.
//!
//! Whitted: An Improved Illumination Model for Shaded Display. Communications of the ACM 23(6), 1980;
//! with Fresnel's equations at glass, and light that falls off with the square of the distance.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;
use trisect_core::Ray;
use trisect_scene::{Color, Light};

use crate::needs::Needs;
use crate::random::{Random, cosine_about};
use crate::settings::{Occlusion, Settings};
use crate::stage::Stage;
use crate::surface::{Surface, Target, reflected, refracted};
use crate::wave::{Carrying, Wave, largest};

/// Where random numbers of ambient occlusion begin; those of the camera come before.
const OCCLUSION: u32 = 16;

impl Wave {
    /// Adds what a point gives off and the ambient light that it returns, and sends rays to lights, for
    /// its mirror image and into glass.
    #[allow(
        clippy::too_many_arguments,
        reason = "the innermost loop: what it needs, nothing packed"
    )]
    #[inline(always)]
    pub(crate) fn shade_whitted<N: Needs>(
        &mut self,
        stage: &Stage,
        settings: &Settings,
        occlusion: Option<Occlusion>,
        depth: u32,
        ray: &Ray<f32>,
        carrying: Carrying,
        target: Target,
    ) {
        let surface = stage.surface::<N>(ray, target);
        let direction = Vec3::from(ray.d);
        let Carrying { slot, weight } = carrying;
        let ambient = surface.diffuse * stage.scene.ambient;
        self.add(carrying, surface.material.emission);
        match occlusion.filter(|_| N::SHADOWS) {
            None => self.add(carrying, ambient),
            Some(occlusion) => {
                let weight = weight * ambient / occlusion.rays as f32;
                if largest(weight) > settings.cutoff / occlusion.rays as f32 {
                    self.look_around(settings, &surface, occlusion, depth, slot, weight);
                }
            }
        }
        if N::SHADOWS && surface.is_lit {
            self.light(stage, settings, &surface, direction, carrying);
        }
        if !N::ONWARD || depth == settings.depth {
            return;
        }
        let material = surface.material;
        let mut mirrored = weight * material.reflection;
        if material.is_clear() {
            let index = material.index_of_refraction;
            let ratio = if surface.from_front { 1.0 / index } else { index };
            let (share, through) = refracted(direction, surface.normal, ratio);
            let clear = weight * material.transmission;
            mirrored += clear * share;
            if let Some(through) = through {
                let weight = clear * (1.0 - share);
                // An interpolated normal may bend it out again.
                if largest(weight) > settings.cutoff && through.dot(surface.true_normal) < 0.0 {
                    self.push(surface.start(-1.0), through, slot, weight);
                }
            }
        }
        if largest(mirrored) > settings.cutoff {
            self.push(surface.start(1.0), mirror(&surface, direction), slot, mirrored);
        }
    }

    /// Sends a ray to each light that a point may see.
    #[inline]
    pub(crate) fn light(
        &mut self,
        stage: &Stage,
        settings: &Settings,
        surface: &Surface<'_>,
        direction: Vec3,
        Carrying { slot, weight }: Carrying,
    ) {
        let start = surface.start(1.0);
        for light in stage.lights(settings.lights) {
            let (towards, distance, irradiance) = arriving(light, start);
            let cosine = surface.normal.dot(towards);
            if cosine > 0.0 && surface.true_normal.dot(towards) > 0.0 {
                let back = surface.diffuse * FRAC_1_PI + highlight(surface, direction, towards);
                let weight = weight * irradiance * back * cosine;
                if largest(weight) > settings.cutoff {
                    self.push_shadow(start, towards, distance, slot, weight);
                }
            }
        }
    }

    /// Sends rays to all sides for the ambient light, which adds the weight for each that gets away.
    fn look_around(
        &mut self,
        settings: &Settings,
        surface: &Surface<'_>,
        Occlusion { rays, distance }: Occlusion,
        depth: u32,
        slot: u32,
        weight: Color,
    ) {
        let [pixel, sample] = self.samples[slot as usize];
        let random = Random { seed: settings.seed, pixel, sample };
        let start = surface.start(1.0);
        for number in 0..rays {
            let place = OCCLUSION.wrapping_add(depth.wrapping_mul(rays)).wrapping_add(number);
            let [u, v, ..] = random.four(place);
            let towards = cosine_about(surface.normal, u, v);
            if surface.true_normal.dot(towards) > 0.0 {
                self.push_shadow(start, towards, distance, slot, weight);
            }
        }
    }
}

/// The direction of a point's mirror image; of the surface as it is where an interpolated normal would
/// send it below.
#[inline]
pub(crate) fn mirror(surface: &Surface<'_>, direction: Vec3) -> Vec3 {
    let away = reflected(direction, surface.normal);
    if away.dot(surface.true_normal) > 0.0 {
        return away;
    }
    reflected(direction, surface.true_normal)
}

/// Phong's highlight, as a reflectance per solid angle.
///
/// Lafortune, Willems: Using the Modified Phong Reflectance Model for Physically Based Rendering. 1994.
#[inline]
fn highlight(surface: &Surface<'_>, direction: Vec3, towards: Vec3) -> Color {
    let material = surface.material;
    if material.specular == Vec3::ZERO {
        return Vec3::ZERO;
    }
    let cosine = reflected(direction, surface.normal).dot(towards).max(0.0);
    material.specular * ((material.shininess + 2.0) / TAU * cosine.powf(material.shininess))
}

/// Towards a light: the direction, of unit length, the distance, and the irradiance of what faces it.
#[inline]
fn arriving(light: &Light, point: Vec3) -> (Vec3, f32, Color) {
    let from_point = |position: Vec3, intensity: Color| {
        let way = position - point;
        let squared = way.length_squared();
        let distance = squared.sqrt();
        (way * (1.0 / distance), distance, intensity * (1.0 / squared))
    };
    match *light {
        Light::Point { position, intensity } => from_point(position, intensity),
        Light::Directional { direction, irradiance } => (-direction, f32::INFINITY, irradiance),
        Light::Spot { position, direction, intensity, inner, outer } => {
            let (towards, distance, irradiance) = from_point(position, intensity);
            let cosine = -towards.dot(direction);
            // As glTF has it: fades with the square of the share of the way between the cones.
            let share = ((cosine - outer) / (inner - outer).max(1e-4)).clamp(0.0, 1.0);
            (towards, distance, irradiance * (share * share))
        }
    }
}
