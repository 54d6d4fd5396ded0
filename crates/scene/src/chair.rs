//! A chair of exactly 10,817 triangles, modelled by code: turned legs and stretchers, a rounded seat, a
//! back of posts, spindles and a rail, and a knob. It stands on y = 0, looks along +z, and is 0.97 high.

use std::f32::consts::{PI, TAU};

use glam::Vec3;
use trisect_core::Triangle;

use crate::mesh::Mesh;

/// Triangles of the chair.
#[cfg(test)]
const TRIANGLES: usize = 10_817;

/// How an end of a row of rings is closed.
#[derive(Clone, Copy, PartialEq)]
enum End {
    /// Not at all: it is inside another part, or on the floor.
    Open,
    /// By triangles to one point.
    Pole(Vec3),
}

impl Mesh {
    /// The chair, with interpolated normals.
    pub fn chair() -> Self {
        let mut triangles = Vec::new();
        let seat_height = 0.44;
        seat(&mut triangles, seat_height);
        for (x, z) in [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
            leg(&mut triangles, leg_top(x, z, seat_height), leg_foot(x, z));
        }
        // Stretchers: one on each side, and front and back, at a third of the legs' height.
        let at =
            |x: f32, z: f32, share: f32| leg_foot(x, z).lerp(leg_top(x, z, seat_height), share);
        for side in [-1.0, 1.0] {
            stretcher(&mut triangles, at(side, -1.0, 0.34), at(side, 1.0, 0.34));
            stretcher(&mut triangles, at(-1.0, side, 0.46), at(1.0, side, 0.46));
        }
        back(&mut triangles, seat_height);
        Self::of_triangles("chair", triangles)
    }
}

fn leg_top(x: f32, z: f32, height: f32) -> Vec3 {
    Vec3::new(x * 0.165, height, z * 0.165)
}

fn leg_foot(x: f32, z: f32) -> Vec3 {
    Vec3::new(x * 0.215, 0.0, z * 0.215)
}

/// A pillow: sides of a squircle, from pole to pole.
fn seat(triangles: &mut Vec<Triangle<f32>>, height: f32) {
    const SIDES: usize = 56;
    const RINGS: usize = 23;
    let (half_width, half_height) = (0.235, 0.028);
    let middle = Vec3::new(0.0, height, 0.0);
    let rings: Vec<Vec<Vec3>> = (1..=RINGS)
        .map(|ring| {
            let angle = PI * (ring as f32 / (RINGS + 1) as f32 - 0.5);
            // Flat above and below, round at the edge.
            let (out, up) = (angle.cos().powf(0.45), angle.sin());
            circle(SIDES, |cos, sin| {
                let squircle = (cos.powi(4) + sin.powi(4)).powf(-0.25);
                middle
                    + Vec3::new(
                        cos * squircle * out * half_width,
                        up * half_height,
                        -sin * squircle * out * half_width,
                    )
            })
        })
        .collect();
    let pole = Vec3::new(0.0, half_height, 0.0);
    skin(triangles, &rings, [End::Pole(middle - pole), End::Pole(middle + pole)]);
}

/// A turned leg, from the seat to its rounded foot.
fn leg(triangles: &mut Vec<Triangle<f32>>, top: Vec3, foot: Vec3) {
    const SIDES: usize = 20;
    const RINGS: usize = 17;
    let radius = |share: f32| {
        let slender = 0.013 + 0.008 * (PI * share).sin();
        let bulge = 0.007 * (-((share - 0.3) * 14.0).powi(2)).exp();
        let foot = ((1.0 - share) * 30.0).min(1.0).sqrt();
        (slender + bulge) * foot.max(0.55)
    };
    let spine = |share: f32| top.lerp(foot, share);
    tube(triangles, SIDES, RINGS, spine, radius, [End::Open, End::Pole(foot)]);
}

/// A rod that is thickest in its middle; its ends are inside the legs.
fn stretcher(triangles: &mut Vec<Triangle<f32>>, from: Vec3, to: Vec3) {
    let radius = |share: f32| 0.007 + 0.005 * (PI * share).sin();
    tube(triangles, 14, 9, |share| from.lerp(to, share), radius, [End::Open; 2]);
}

fn back(triangles: &mut Vec<Triangle<f32>>, seat: f32) {
    // Leans back more and more towards the top.
    let lean = |x: f32, share: f32| {
        let z = -0.18 - 0.09 * share - 0.03 * share * share;
        Vec3::new(x * (0.185 + 0.02 * share), seat + 0.46 * share, z)
    };
    for side in [-1.0, 1.0] {
        let radius = |share: f32| 0.016 * (1.0 - share).mul_add(20.0, 0.3).min(1.0);
        let end = [End::Open, End::Pole(lean(side, 1.0) + Vec3::Y * 0.004)];
        tube(triangles, 20, 25, |share| lean(side, share), radius, end);
    }
    // The rail bends backwards between the posts.
    let rail = |share: f32| {
        let x = share.mul_add(2.0, -1.0);
        lean(x * 1.12, 0.88) + Vec3::new(0.0, 0.02, -0.035) * (1.0 - x * x)
    };
    let radius = |share: f32| {
        let x = share.mul_add(2.0, -1.0).abs();
        0.021 * ((1.0 - x) * 12.0 + 0.12).min(1.0).sqrt()
    };
    let ends = [End::Pole(rail(0.0) - Vec3::X * 0.003), End::Pole(rail(1.0) + Vec3::X * 0.003)];
    tube(triangles, 24, 25, rail, radius, ends);
    for spindle in -2_i8..=2 {
        let x = f32::from(spindle) / 3.0;
        let (from, to) = (lean(x, 0.0), rail(x.mul_add(0.5 / 1.12, 0.5)));
        let radius = |share: f32| 0.006 + 0.004 * (PI * share).sin();
        tube(triangles, 12, 12, |share| from.lerp(to, share), radius, [End::Open; 2]);
    }
    // The knob on the rail: what is open below makes the number of triangles odd.
    let foot = rail(0.5);
    let radius = |share: f32| 0.008 + 0.017 * (PI * share.powf(1.4)).sin().max(0.0);
    let knob = |share: f32| foot + Vec3::Y * (0.075 * share);
    tube(triangles, 15, 8, knob, radius, [End::Open, End::Pole(knob(1.0) + Vec3::Y * 0.003)]);
}

/// Points around, by the cosine and sine of their angle.
fn circle(sides: usize, point: impl Fn(f32, f32) -> Vec3) -> Vec<Vec3> {
    (0..sides)
        .map(|side| {
            let (sin, cos) = (TAU * side as f32 / sides as f32).sin_cos();
            point(cos, sin)
        })
        .collect()
}

/// A tube of a thickness that varies along its spine; both are given by the share of the way.
fn tube(
    triangles: &mut Vec<Triangle<f32>>,
    sides: usize,
    rings: usize,
    spine: impl Fn(f32) -> Vec3,
    radius: impl Fn(f32) -> f32,
    ends: [End; 2],
) {
    let rings: Vec<Vec<Vec3>> = (0..rings)
        .map(|ring| {
            let share = ring as f32 / (rings - 1) as f32;
            let middle = spine(share);
            let along = (spine(share + 1e-2) - spine(share - 1e-2)).normalize();
            // No part here runs along z, so this never fails, and never turns over.
            let u = Vec3::Z.reject_from_normalized(along).normalize_or(Vec3::X);
            let v = along.cross(u);
            let radius = radius(share);
            circle(sides, |cos, sin| middle + (u * cos + v * sin) * radius)
        })
        .collect();
    skin(triangles, &rings, ends);
}

/// Triangles between rings of equally many points that turn to the left around the way from first to
/// last, seen from outside counter-clockwise.
fn skin(triangles: &mut Vec<Triangle<f32>>, rings: &[Vec<Vec3>], ends: [End; 2]) {
    let mut push = |a: Vec3, b: Vec3, c: Vec3| triangles.push(Triangle::new(a, b, c));
    let next = |ring: &[Vec3], side: usize| ring[(side + 1) % ring.len()];
    for pair in rings.windows(2) {
        let (low, high) = (&pair[0], &pair[1]);
        for side in 0..low.len() {
            push(low[side], next(low, side), next(high, side));
            push(low[side], next(high, side), high[side]);
        }
    }
    if let (End::Pole(pole), Some(ring)) = (ends[0], rings.first()) {
        for side in 0..ring.len() {
            push(pole, next(ring, side), ring[side]);
        }
    }
    if let (End::Pole(pole), Some(ring)) = (ends[1], rings.last()) {
        for side in 0..ring.len() {
            push(pole, ring[side], next(ring, side));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chair_has_its_number_of_triangles_all_with_an_area() {
        let chair = Mesh::chair();
        assert_eq!(chair.triangles.len(), TRIANGLES);
        assert!(chair.triangles.iter().all(Triangle::can_be_hit));
    }

    #[test]
    fn the_chair_stands_on_the_floor_and_faces_outwards() {
        let chair = Mesh::chair();
        let corners = chair.triangles.iter().flat_map(|triangle| triangle.corners());
        let heights: Vec<f32> = corners.map(|corner| corner.y).collect();
        let lowest = heights.iter().copied().fold(f32::INFINITY, f32::min);
        let highest = heights.iter().copied().fold(0.0, f32::max);
        assert!(lowest.abs() < 0.002, "{lowest}");
        assert!((0.9..1.0).contains(&highest), "{highest}");
        // The volume is positive where triangles face outwards (the openings are small).
        let volume: f32 = chair
            .triangles
            .iter()
            .map(|t| Vec3::from(t.a).dot(Vec3::from(t.b).cross(Vec3::from(t.c))) / 6.0)
            .sum();
        assert!((0.005..0.02).contains(&volume), "{volume}");
    }
}
