//! How it was done before: triangles clipped by the plane in front of the eye into none, one or two, and filled
//! by spans between sorted edges. What the rasteriser is compared with; in f32, on one thread.

use glam::{Vec2, Vec3};
use trisect_scene::PixelRays;

use crate::blocks::Object;
use crate::view::View;

/// The part of a triangle whose last coordinates are at least `near`: so many triangles, on the stack. Cut by one
/// plane a triangle leaves a triangle or a quadrangle at most.
pub fn clip(corners: [Vec3; 3], near: f32) -> ([[Vec3; 3]; 2], usize) {
    let cut = |from: Vec3, to: Vec3| from + (to - from) * ((near - from.z) / (to.z - from.z));
    let is_in = corners.map(|corner| corner.z >= near);
    let count = is_in.iter().filter(|is_in| **is_in).count();
    let none = [[Vec3::ZERO; 3]; 2];
    match count {
        0 => (none, 0),
        3 => ([corners, none[0]], 1),
        _ => {
            // The corner that is alone on its side comes first.
            let alone = is_in.iter().position(|&is_in| is_in == (count == 1)).unwrap_or(0);
            let [a, b, c] = [0, 1, 2].map(|step| corners[(alone + step) % 3]);
            let (ab, ac) = (cut(a, b), cut(a, c));
            if count == 1 { ([[a, ab, ac], none[0]], 1) } else { ([[ab, b, c], [ab, c, ac]], 2) }
        }
    }
}

/// A picture that is filled by spans.
#[derive(Default)]
pub struct Scan {
    width: usize,
    /// The nearness of what is seen, and its number.
    near: Vec<f32>,
    seen: Vec<u32>,
}

impl Scan {
    /// Finds what is seen of some objects. Whether it did: the camera must be a pinhole.
    pub fn draw(&mut self, objects: &[Object], rays: &PixelRays) -> bool {
        let [width, height] = rays.size().map(|side| side as usize);
        self.width = width;
        self.near.clear();
        self.near.resize(width * height, 0.0);
        self.seen.clear();
        self.seen.resize(width * height, u32::MAX);
        let mut number = 0;
        for object in objects {
            let Some(view) = View::new(rays, object.transform()).filter(|view| !view.is_parallel)
            else {
                return false;
            };
            let (origin, dual) = (Vec3::from(view.origin), view.dual.map(Vec3::from));
            let half = Vec2::from(view.half);
            let triangles = object.triangles();
            for place in 0..triangles.len() {
                let corners = triangles.triangle(place).corners().map(|corner| {
                    let way = Vec3::from(corner) - origin;
                    Vec3::new(way.dot(dual[1]), way.dot(dual[2]), way.dot(dual[0]))
                });
                let (parts, count) = clip(corners, 1e-3);
                for part in &parts[..count] {
                    let projected = part.map(|corner| {
                        let near = 1.0 / corner.z;
                        (corner.truncate() * near + half).extend(near)
                    });
                    self.fill(projected, number, height);
                }
                number += 1;
            }
        }
        true
    }

    /// Fills a triangle: pixels across and down, and nearness.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "pixels are brought into the picture first"
    )]
    fn fill(&mut self, mut corners: [Vec3; 3], number: u32, height: usize) {
        corners.sort_unstable_by(|a, b| a.y.total_cmp(&b.y));
        let [top, middle, bottom] = corners;
        let across = (bottom - top) / (bottom.y - top.y);
        // Where the long edge is level with the middle corner.
        let other = top + across * (middle.y - top.y);
        let per_pixel = (other.z - middle.z) / (other.x - middle.x);
        let first = |from: f32| (from - 0.5).ceil().max(0.0) as usize;
        for y in first(top.y)..first(bottom.y).min(height) {
            let down = y as f32 + 0.5;
            let long = top + across * (down - top.y);
            let [from, to] = if down < middle.y { [top, middle] } else { [middle, bottom] };
            let short = from + (to - from) * ((down - from.y) / (to.y - from.y));
            let (left, right) = if long.x < short.x { (long, short) } else { (short, long) };
            let (start, end) = (first(left.x), first(right.x).min(self.width));
            let mut near = left.z + (start as f32 + 0.5 - left.x) * per_pixel;
            let row = y * self.width;
            for at in row + start..row + end.max(start) {
                if near > self.near[at] {
                    (self.near[at], self.seen[at]) = (near, number);
                }
                near += per_pixel;
            }
        }
    }

    /// The number of the triangle that is seen at a pixel.
    ///
    /// # Panics
    /// When the picture has no such pixel.
    pub fn seen(&self, [x, y]: [u32; 2]) -> Option<u32> {
        let seen = self.seen[y as usize * self.width + x as usize];
        (seen != u32::MAX).then_some(seen)
    }
}
