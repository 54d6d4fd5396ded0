//! Colours that vary over a surface.

use std::path::Path;

use glam::{Vec2, Vec3};

use crate::error::SceneProblem;
use crate::model::Color;

/// A texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// How often it repeats in one unit of the surface's coordinates.
    pub scale: Vec2,
    /// What it shows.
    pub pixels: Pixels,
}

/// What a texture shows between 0 and 1; beyond, it repeats.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Four squares, two of each colour.
    Checker([Color; 2]),
    /// A picture, row by row from above, interpolated between the middles of pixels.
    Picture {
        /// Pixels across, at least 1.
        width: usize,
        /// Pixels down, at least 1.
        height: usize,
        /// The pixels' linear colours.
        colors: Vec<Color>,
    },
}

impl Texture {
    /// The colour at coordinates of the surface; v grows downwards in a picture, as in glTF.
    #[inline]
    pub fn at(&self, coordinates: Vec2) -> Color {
        let at = coordinates * self.scale;
        let at = at - Vec2::new(floor(at.x), floor(at.y));
        match &self.pixels {
            Pixels::Checker(colors) => colors[usize::from((at.x < 0.5) != (at.y < 0.5))],
            Pixels::Picture { width, height, colors } => {
                let (x0, x1, x) = between(at.x, *width);
                let (y0, y1, y) = between(at.y, *height);
                let row = |y: usize| colors[y * width + x0].lerp(colors[y * width + x1], x);
                row(y0).lerp(row(y1), y)
            }
        }
    }

    /// Reads a PNG: grey or in colours, of 8 or 16 bits, sRGB. What it says of opacity is not used.
    pub(crate) fn load(path: &Path) -> Result<Pixels, SceneProblem> {
        let file = std::fs::read(path).map_err(SceneProblem::Unreadable)?;
        Self::decode(&file)
    }

    /// The same from memory.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Pixels, SceneProblem> {
        let faulty = |what: &dyn std::fmt::Display| SceneProblem::Faulty {
            place: "picture".to_owned(),
            field: "PNG".to_owned(),
            what: what.to_string(),
            mend: "save it as PNG".to_owned(),
        };
        let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info().map_err(|error| faulty(&error))?;
        let size = reader.output_buffer_size().ok_or_else(|| faulty(&"too large"))?;
        let mut buffer = vec![0; size];
        let frame = reader.next_frame(&mut buffer).map_err(|error| faulty(&error))?;
        let samples = frame.color_type.samples();
        let colors = buffer[..frame.buffer_size()]
            .chunks_exact(samples)
            .map(|pixel| match pixel {
                [red, green, blue, ..] => Vec3::new(linear(*red), linear(*green), linear(*blue)),
                [grey, ..] => Vec3::splat(linear(*grey)),
                [] => Vec3::ZERO,
            })
            .collect();
        Ok(Pixels::Picture { width: frame.width as usize, height: frame.height as usize, colors })
    }
}

/// As `f32::floor`, which is a call where a processor of 2003 must do; of what is beyond an i32 anything.
#[allow(clippy::cast_possible_truncation, reason = "saturates")]
#[inline]
fn floor(x: f32) -> f32 {
    let towards_zero = x as i32 as f32;
    if towards_zero > x { towards_zero - 1.0 } else { towards_zero }
}

/// The two pixels that a coordinate from 0 to 1 lies between, and how near it is to the second.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to the size")]
fn between(at: f32, size: usize) -> (usize, usize, f32) {
    let at = at * size as f32 + (size as f32 - 0.5);
    let low = at.floor();
    let first = low as usize % size;
    (first, (first + 1) % size, at - low)
}

/// The linear value of an 8-bit sRGB one (IEC 61966-2-1).
fn linear(value: u8) -> f32 {
    let value = f32::from(value) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checker_has_four_squares_and_repeats() {
        let (black, white) = (Vec3::ZERO, Vec3::ONE);
        let texture = Texture { scale: Vec2::splat(0.5), pixels: Pixels::Checker([black, white]) };
        for shift in [-4.0, 0.0, 6.0] {
            let at = |x: f32, y: f32| texture.at(Vec2::new(x + shift, y - shift));
            assert_eq!([at(0.1, 0.1), at(1.1, 0.1)], [black, white]);
            assert_eq!([at(0.1, 1.9), at(1.9, 1.9)], [white, black]);
        }
    }

    #[test]
    fn a_picture_is_interpolated_between_middles() {
        let colors = [0.0, 1.0, 0.5, 0.25].map(Vec3::splat).to_vec();
        let texture =
            Texture { scale: Vec2::ONE, pixels: Pixels::Picture { width: 2, height: 2, colors } };
        let at = |x, y| texture.at(Vec2::new(x, y)).x;
        assert_eq!([at(0.25, 0.25), at(0.75, 0.25), at(0.25, 0.75)], [0.0, 1.0, 0.5]);
        assert_eq!([at(0.5, 0.25), at(0.0, 0.25), at(0.5, 0.5)], [0.5, 0.5, 0.4375]);
    }

    #[test]
    fn what_is_no_png_is_refused() {
        let error = Texture::decode(b"JFIF").expect_err("no PNG");
        assert!(error.to_string().contains("PNG"), "{error}");
    }
}
