//! Light over lanes: of one point, or of as many pixels as there are lanes.
//!
//! The formulas are the renderer's, without shadows: Lambert, and Phong's highlight as Lafortune and Willems
//! normalise it (Using the Modified Phong Reflectance Model for Physically Based Rendering, 1994), whose
//! exponent is rounded to a whole number here.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3 as Point;
use trisect_core::{Lanes, Vec3};
use trisect_scene::{Color, Light, Material};

/// A vector in all lanes.
#[inline(always)]
pub(crate) fn splat<L: Lanes<Elem = f32>>(token: L::Token, v: Point) -> Vec3<L> {
    Vec3::new(L::splat(token, v.x), L::splat(token, v.y), L::splat(token, v.z))
}

/// One over the square root: of each lane, which the compiler turns into instructions over lanes.
#[inline(always)]
pub(crate) fn inverse_root<L: Lanes<Elem = f32>>(token: L::Token, x: L) -> L {
    let mut row = [1.0_f32; 16];
    x.store(&mut row);
    let mut lane = 0;
    while lane < L::N {
        row[lane] = 1.0 / row[lane].sqrt();
        lane += 1;
    }
    L::load(token, &row)
}

/// A vector of unit length.
#[inline(always)]
pub(crate) fn unit<L: Lanes<Elem = f32>>(token: L::Token, v: Vec3<L>) -> Vec3<L> {
    v.scale(inverse_root(token, v.dot(v)))
}

/// A whole power.
#[inline(always)]
fn power<L: Lanes<Elem = f32>>(x: L, mut exponent: u32) -> L {
    let (mut result, mut square) = (x.constant(1.0), x);
    while exponent != 0 {
        if exponent & 1 != 0 {
            result = result * square;
        }
        square = square * square;
        exponent >>= 1;
    }
    result
}

#[inline(always)]
fn times<L: Lanes<Elem = f32>>(a: Vec3<L>, b: Vec3<L>) -> Vec3<L> {
    Vec3::new(a.x * b.x, a.y * b.y, a.z * b.z)
}

/// What comes from a point towards the eye. `view` is the direction from the eye to it, and `normal` the surface's,
/// both of unit length, the latter on either side.
#[inline(always)]
pub(crate) fn lit<L: Lanes<Elem = f32>>(
    token: L::Token,
    (lights, ambient): (&[Light], Color),
    material: &Material,
    diffuse: Vec3<L>,
    (position, normal, view): (Vec3<L>, Vec3<L>, Vec3<L>),
) -> Vec3<L> {
    let zero = L::splat(token, 0.0);
    // On the side of the eye.
    let facing = -normal.dot(view);
    let normal =
        Vec3::new(normal.x.xor_sign(facing), normal.y.xor_sign(facing), normal.z.xor_sign(facing));
    // The mirror image of the way to the eye.
    let away = normal.scale(facing.magnitude() * L::splat(token, 2.0)) + view;
    let mut spread = splat(token, ambient);
    let mut shine = Vec3::new(zero, zero, zero);
    let is_shiny = material.specular != Point::ZERO;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
    let exponent = material.shininess.round() as u32;
    for light in lights {
        let (towards, irradiance) = match *light {
            Light::Directional { direction, irradiance } => {
                (splat(token, -direction), splat(token, irradiance))
            }
            Light::Point { position: from, intensity } => {
                arriving(token, position, from, intensity)
            }
            Light::Spot { position: from, direction, intensity, inner, outer } => {
                let (towards, irradiance) = arriving(token, position, from, intensity);
                let cosine = -towards.dot(splat(token, direction));
                let share = (cosine - L::splat(token, outer))
                    * L::splat(token, 1.0 / (inner - outer).max(1e-4));
                let share = share.max(zero).min(L::splat(token, 1.0));
                (towards, irradiance.scale(share * share))
            }
        };
        let cosine = normal.dot(towards).max(zero);
        let arriving = irradiance.scale(cosine);
        spread = spread + arriving.scale(L::splat(token, FRAC_1_PI));
        if is_shiny {
            let cosine = away.dot(towards).max(zero);
            let share = power(cosine, exponent) * L::splat(token, (material.shininess + 2.0) / TAU);
            shine = shine + arriving.scale(share);
        }
    }
    let back = times(spread, diffuse) + splat(token, material.emission);
    if is_shiny { back + times(shine, splat(token, material.specular)) } else { back }
}

/// Light of a point: from where, and the irradiance of what faces it.
#[inline(always)]
fn arriving<L: Lanes<Elem = f32>>(
    token: L::Token,
    position: Vec3<L>,
    from: Point,
    intensity: Color,
) -> (Vec3<L>, Vec3<L>) {
    let way = splat::<L>(token, from) - position;
    let inverse = inverse_root(token, way.dot(way));
    (way.scale(inverse), splat::<L>(token, intensity).scale(inverse * inverse))
}
