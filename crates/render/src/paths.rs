//! Path tracing: each sample follows one way of the light, chosen by chance.
//!
//! Kajiya: The Rendering Equation. SIGGRAPH 1986; with rays to the lights at every point.

use std::f32::consts::TAU;

use glam::Vec3;
use trisect_core::Ray;

use crate::needs::Paths;
use crate::random::{Random, cosine_about};
use crate::settings::Settings;
use crate::stage::Stage;
use crate::surface::{Target, refracted};
use crate::wave::{Carrying, Wave, chance};
use crate::whitted::mirror;

/// Paths may end by chance once they are so long.
const ROULETTE: u32 = 3;

/// Where random numbers of paths begin; those of the camera come before.
const PATHS: u32 = 16;

impl Wave {
    /// Adds what a point gives off, sends rays to lights, and one on: scattered, reflected or refracted.
    #[inline]
    pub(crate) fn shade_path(
        &mut self,
        stage: &Stage,
        settings: &Settings,
        depth: u32,
        ray: &Ray<f32>,
        carrying: Carrying,
        target: Target,
    ) {
        let surface = stage.surface::<Paths>(ray, target);
        let material = surface.material;
        let direction = Vec3::from(ray.d);
        let Carrying { slot, weight } = carrying;
        self.add(carrying, material.emission);
        if surface.is_lit {
            self.light(stage, settings, &surface, direction, carrying);
        }
        if depth == settings.depth {
            return;
        }
        // Which way the light came, in proportion to what it would bring.
        let ways = [surface.diffuse, material.specular, material.reflection, material.transmission];
        let likely = ways.map(|way| chance(weight * way));
        let sum: f32 = likely.iter().sum();
        if sum.is_nan() || sum <= 0.0 {
            return;
        }
        let [pixel, sample] = self.samples[slot as usize];
        let random = Random { seed: settings.seed, pixel, sample };
        let [u, v, choice, end] = random.four(PATHS.wrapping_add(depth));
        let mut left = choice * sum;
        let mut way = 0;
        while way < 3 && left >= likely[way] {
            left -= likely[way];
            way += 1;
        }
        if likely[way] <= 0.0 {
            return;
        }
        let mut weight = weight * ways[way] * (sum / likely[way]);
        let mut side = 1.0;
        let on = match way {
            0 => cosine_about(surface.normal, u, v),
            1 => {
                let towards = about(mirror(&surface, direction), material.shininess, u, v);
                // Directions are as likely as the highlight without its normalisation.
                let exponent = material.shininess;
                weight *= surface.normal.dot(towards) * (exponent + 2.0) / (exponent + 1.0);
                towards
            }
            2 => mirror(&surface, direction),
            _ => {
                let index = material.index_of_refraction;
                let ratio = if surface.from_front { 1.0 / index } else { index };
                match refracted(direction, surface.normal, ratio) {
                    (share, Some(through)) if u >= share => {
                        side = -1.0;
                        through
                    }
                    _ => mirror(&surface, direction),
                }
            }
        };
        if on.dot(surface.true_normal) * side <= 0.0 || weight.max_element() <= 0.0 {
            return;
        }
        if depth >= ROULETTE {
            let stay = chance(weight).clamp(0.05, 1.0);
            if end >= stay {
                return;
            }
            weight /= stay;
        }
        self.push(surface.start(side), on, slot, weight);
    }
}

/// A direction about another, as likely as a power of the cosine between them.
fn about(axis: Vec3, exponent: f32, u: f32, v: f32) -> Vec3 {
    let cosine = u.powf(1.0 / (exponent + 1.0));
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin, cos) = (TAU * v).sin_cos();
    let (x, y) = axis.any_orthonormal_pair();
    debug_assert!(axis.is_normalized(), "directions have unit length");
    (x * cos + y * sin) * sine + axis * cosine
}
