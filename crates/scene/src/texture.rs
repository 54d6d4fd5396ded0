//! Colours that vary over a surface.

use std::fmt::Display;
use std::io::Cursor;
use std::path::Path;

use glam::{Vec2, Vec3};
use trisect_mesh::Reading;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

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

    /// Reads a PNG or a JPEG: grey or in colours, sRGB. What it says of opacity is not used.
    pub(crate) fn load(path: &Path, reading: &mut Reading) -> Result<Pixels, SceneProblem> {
        let file = reading.file(path)?;
        Self::decode(&file)
    }

    /// The same from memory.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Pixels, SceneProblem> {
        if bytes.starts_with(&JPEG) { decode_jpeg(bytes) } else { decode_png(bytes) }
    }
}

/// How every JPEG begins.
const JPEG: [u8; 3] = [0xff, 0xd8, 0xff];

fn faulty(what: &dyn Display) -> SceneProblem {
    SceneProblem::faulty("picture", "PNG or JPEG", what.to_string(), "save it anew")
}

fn decode_png(bytes: &[u8]) -> Result<Pixels, SceneProblem> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|error| faulty(&error))?;
    let size = reader.output_buffer_size().ok_or_else(|| faulty(&"too large"))?;
    let mut buffer = vec![0; size];
    let frame = reader.next_frame(&mut buffer).map_err(|error| faulty(&error))?;
    let size = [frame.width as usize, frame.height as usize];
    Ok(picture(size, &buffer[..frame.buffer_size()], frame.color_type.samples()))
}

fn decode_jpeg(bytes: &[u8]) -> Result<Pixels, SceneProblem> {
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    let buffer = decoder.decode().map_err(|error| faulty(&error))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| faulty(&"it has no size"))?;
    Ok(picture([width, height], &buffer, 3))
}

/// From sRGB of so many bytes a pixel.
fn picture([width, height]: [usize; 2], bytes: &[u8], samples: usize) -> Pixels {
    let colors = bytes
        .chunks_exact(samples)
        .map(|pixel| match pixel {
            [red, green, blue, ..] => Vec3::new(linear(*red), linear(*green), linear(*blue)),
            [grey, ..] => Vec3::splat(linear(*grey)),
            [] => Vec3::ZERO,
        })
        .collect();
    Pixels::Picture { width, height, colors }
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

    /// Three fields of one colour each, as large as the blocks of the format.
    #[test]
    fn a_jpeg_is_read_as_it_was_written() {
        const FIELDS: [[u8; 3]; 3] = [[200, 30, 40], [128, 128, 128], [20, 60, 250]];
        let row = FIELDS.iter().flat_map(|field| field.repeat(16));
        let pixels: Vec<u8> = row.collect::<Vec<u8>>().repeat(16);
        let mut file = Vec::new();
        let encoder = jpeg_encoder::Encoder::new(&mut file, 100);
        encoder.encode(&pixels, 48, 16, jpeg_encoder::ColorType::Rgb).expect("it is written");
        let pixels = Texture::decode(&file).expect("a JPEG");
        let Pixels::Picture { width, height, colors } = &pixels else { panic!("a picture") };
        assert_eq!((*width, *height, colors.len()), (48, 16, 48 * 16));
        for (place, field) in FIELDS.iter().enumerate() {
            let expected = Vec3::from(field.map(linear));
            let found = colors[5 * 48 + place * 16 + 8];
            assert!((found - expected).abs().max_element() < 0.02, "{found} {expected}");
        }
        let error = Texture::decode(&file[..200]).expect_err("it is cut off");
        assert!(error.to_string().starts_with("picture: PNG or JPEG: "), "{error}");
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let error = Texture::decode(b"GIF89a").expect_err("no PNG");
        assert!(error.to_string().ends_with("; save it anew"), "{error}");
    }
}
