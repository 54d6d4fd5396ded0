//! Colours that vary over a surface.

use std::fmt::Display;
use std::io::Cursor;
use std::path::Path;
use std::sync::LazyLock;

use glam::{Vec2, Vec3};
use trisect_mesh::{Reading, cut};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::error::SceneProblem;
use crate::files::is_missing;
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
        /// The pixels' red, green and blue in sRGB.
        texels: Vec<[u8; 3]>,
    },
}

/// What is noted of a picture that a surface is shown without.
pub(crate) const UNUSABLE: &str = "a picture that cannot be used is left out";

impl Texture {
    /// The colour at coordinates of the surface; v grows downwards in a picture, as in glTF.
    #[inline]
    pub fn at(&self, coordinates: Vec2) -> Color {
        let at = coordinates * self.scale;
        let at = at - Vec2::new(floor(at.x), floor(at.y));
        match &self.pixels {
            Pixels::Checker(colors) => colors[usize::from((at.x < 0.5) != (at.y < 0.5))],
            Pixels::Picture { width, height, texels } => {
                let (x0, x1, x) = between(at.x, *width);
                let (y0, y1, y) = between(at.y, *height);
                let linear = &*LINEAR;
                let color = |x: usize, y: usize| {
                    Vec3::from(texels[y * width + x].map(|value| linear[usize::from(value)]))
                };
                let row = |y: usize| color(x0, y).lerp(color(x1, y), x);
                row(y0).lerp(row(y1), y)
            }
        }
    }

    /// Reads a PNG or a JPEG: grey or in colours, sRGB. What it says of opacity is not used.
    pub(crate) fn load(path: &Path, reading: &mut Reading) -> Result<Pixels, SceneProblem> {
        let file = reading.file(path)?;
        Self::decode(&file, &path.display().to_string(), reading)
    }

    /// Notes a picture that cannot be read where the surface has a colour without it. A limit that the
    /// reading keeps to stays an error.
    pub(crate) fn or_without(
        pixels: Result<Pixels, SceneProblem>,
        file: &str,
        place: &str,
        reading: &mut Reading,
    ) -> Result<Option<Pixels>, SceneProblem> {
        match pixels {
            Ok(pixels) => Ok(Some(pixels)),
            Err(SceneProblem::Unread(problem)) if !is_missing(&problem) => Err(problem.into()),
            Err(problem) => {
                let place = format!("{place}: {}", cut(&problem.to_string(), 300));
                reading.note(file, &place, UNUSABLE)?;
                Ok(None)
            }
        }
    }

    /// The same from memory; `name` stands for the picture in notes.
    pub(crate) fn decode(
        bytes: &[u8],
        name: &str,
        reading: &mut Reading,
    ) -> Result<Pixels, SceneProblem> {
        match bytes {
            [0xff, 0xd8, 0xff, ..] => decode_jpeg(bytes, name, reading),
            [0x89, b'P', b'N', b'G', ..] => decode_png(bytes, reading),
            _ => {
                let (what, mend) = ("it is neither", "save it as one of them");
                Err(SceneProblem::faulty("picture", "PNG or JPEG", what, mend))
            }
        }
    }
}

fn faulty(what: &dyn Display) -> SceneProblem {
    SceneProblem::faulty("picture", "PNG or JPEG", what.to_string(), "save it anew")
}

/// Refuses a size that so few bytes cannot be the picture of, before memory is asked for it.
fn check_size([width, height]: [usize; 2], needed: u64, most: u64) -> Result<(), SceneProblem> {
    if needed <= most {
        return Ok(());
    }
    Err(faulty(&format!("it is cut off: its header promises {width} × {height} pixels")))
}

/// Deflate makes no more of a byte than 1032: two bits for each 258.
const MOST_OF_DEFLATE: u64 = 1032;

fn decode_png(bytes: &[u8], reading: &mut Reading) -> Result<Pixels, SceneProblem> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|error| faulty(&error))?;
    let info = reader.info();
    // The library copies a palette without asking how long it is.
    if info.palette.as_ref().is_some_and(|palette| palette.len() > 768 || palette.len() % 3 != 0) {
        return Err(faulty(&"its palette is not of 1 to 256 colours"));
    }
    let size = [info.width as usize, info.height as usize];
    let packed = info.raw_bytes() as u64;
    check_size(size, packed, MOST_OF_DEFLATE.saturating_mul(bytes.len() as u64))?;
    let size = reader.output_buffer_size().ok_or_else(|| faulty(&"too large"))?;
    reading.afford((size as u64).saturating_mul(2))?;
    let mut buffer = vec![0; size];
    let frame = reader.next_frame(&mut buffer).map_err(|error| faulty(&error))?;
    let size = [frame.width as usize, frame.height as usize];
    picture(size, &buffer[..frame.buffer_size()], frame.color_type.samples(), reading)
}

/// Each block of 64 samples takes a bit or more, for its mean at least, and no picture has fewer blocks
/// than half of those that its pixels fill: components may be coarser than the picture, but not all of them
/// in the same direction.
const MOST_OF_JPEG: u64 = 8 * 64 * 2;

/// What decoding takes for a pixel: 4 coefficients of 16 bits where the file is progressive, and 3 samples
/// twice.
const JPEG_WORK: u64 = 14;

fn decode_jpeg(bytes: &[u8], name: &str, reading: &mut Reading) -> Result<Pixels, SceneProblem> {
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB);
    let decode = |options| -> Result<([usize; 2], Vec<u8>), SceneProblem> {
        let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
        decoder.decode_headers().map_err(|error| faulty(&error))?;
        let (width, height) = decoder.dimensions().ok_or_else(|| faulty(&"it has no size"))?;
        let pixels = width as u64 * height as u64;
        check_size([width, height], pixels, MOST_OF_JPEG.saturating_mul(bytes.len() as u64))?;
        reading.afford(pixels.saturating_mul(JPEG_WORK))?;
        let samples = decoder.decode().map_err(|error| faulty(&error))?;
        Ok(([width, height], samples))
    };
    let (size, samples) = if let Ok(decoded) = decode(options.set_strict_mode(true)) {
        decoded
    } else {
        let decoded = decode(options.set_strict_mode(false))?;
        reading.note(name, "picture", "a damaged JPEG, shown as far as it can be decoded")?;
        decoded
    };
    picture(size, &samples, 3, reading)
}

/// From sRGB of so many bytes a pixel.
fn picture(
    [width, height]: [usize; 2],
    bytes: &[u8],
    samples: usize,
    reading: &mut Reading,
) -> Result<Pixels, SceneProblem> {
    let count = width.saturating_mul(height);
    if width == 0 || height == 0 || bytes.len() / samples < count {
        return Err(faulty(&format!("it has fewer pixels than {width} × {height}")));
    }
    reading.claim(count as u64 * 3)?;
    let texel = |pixel: &[u8]| match *pixel {
        [red, green, blue, ..] => [red, green, blue],
        [grey, ..] => [grey; 3],
        [] => [0; 3],
    };
    let texels = bytes.chunks_exact(samples).take(count).map(texel).collect();
    Ok(Pixels::Picture { width, height, texels })
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

/// The linear values of the 8-bit sRGB ones (IEC 61966-2-1).
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|value| {
        let value = value as f32 / 255.0;
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    })
});

#[cfg(test)]
mod tests {
    use trisect_mesh::ReadOptions;

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

    fn decode(bytes: &[u8]) -> Result<Pixels, SceneProblem> {
        Texture::decode(bytes, "picture", &mut Reading::new(&ReadOptions::default()))
    }

    #[test]
    fn a_picture_is_interpolated_between_middles() {
        let texels = vec![[0; 3], [255; 3], [188; 3], [137; 3]];
        let texture =
            Texture { scale: Vec2::ONE, pixels: Pixels::Picture { width: 2, height: 2, texels } };
        let at = |x, y| texture.at(Vec2::new(x, y)).x;
        let (half, quarter) = (LINEAR[188], LINEAR[137]);
        assert!((half - 0.5).abs() < 0.005 && (quarter - 0.25).abs() < 0.005);
        assert_eq!([at(0.25, 0.25), at(0.75, 0.25), at(0.25, 0.75)], [0.0, 1.0, half]);
        assert_eq!([at(0.5, 0.25), at(0.0, 0.25)], [0.5, 0.5]);
        assert!((at(0.5, 0.5) - (1.0 + half + quarter) / 4.0).abs() < 1e-6);
    }

    /// Three fields of one colour each, as large as the blocks of the format.
    const FIELDS: [[u8; 3]; 3] = [[200, 30, 40], [128, 128, 128], [20, 60, 250]];

    fn jpeg() -> Vec<u8> {
        let row = FIELDS.iter().flat_map(|field| field.repeat(16));
        let pixels: Vec<u8> = row.collect::<Vec<u8>>().repeat(16);
        let mut file = Vec::new();
        let encoder = jpeg_encoder::Encoder::new(&mut file, 100);
        encoder.encode(&pixels, 48, 16, jpeg_encoder::ColorType::Rgb).expect("it is written");
        file
    }

    #[test]
    fn a_jpeg_is_read_as_it_was_written() {
        let file = jpeg();
        let pixels = decode(&file).expect("a JPEG");
        let Pixels::Picture { width, height, texels } = &pixels else { panic!("a picture") };
        assert_eq!((*width, *height, texels.len()), (48, 16, 48 * 16));
        for (place, field) in FIELDS.iter().enumerate() {
            let found = texels[5 * 48 + place * 16 + 8];
            for (found, expected) in found.iter().zip(field) {
                assert!(found.abs_diff(*expected) <= 3, "{found} {expected}");
            }
        }
        let error = decode(&file[..200]).expect_err("it is cut off");
        assert!(error.to_string().starts_with("picture: PNG or JPEG: "), "{error}");
    }

    #[test]
    fn a_damaged_jpeg_is_shown_as_far_as_it_goes_and_that_is_said() {
        let mut file = jpeg();
        file.truncate(file.len() - 60);
        let mut reading = Reading::new(&ReadOptions::default());
        Texture::decode(&file, "wood.jpg", &mut reading).expect("most of it is there");
        let notes: Vec<String> = reading.into_notes().iter().map(ToString::to_string).collect();
        assert_eq!(
            notes,
            ["wood.jpg: a damaged JPEG, shown as far as it can be decoded (picture)"]
        );
        let strict = ReadOptions { strict: true, ..ReadOptions::default() };
        Texture::decode(&file, "wood.jpg", &mut Reading::new(&strict)).expect_err("strictly");
    }

    /// A PNG of that size with nothing but a header and these bytes of data.
    fn png(width: u32, height: u32, data: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().expect("it is written");
        writer.write_chunk(png::chunk::IDAT, data).expect("it is written");
        drop(writer);
        file
    }

    #[test]
    fn no_memory_is_taken_for_what_a_header_says() {
        let error = decode(&png(100_000, 100_000, &[0; 64])).expect_err("30 GB").to_string();
        assert!(error.contains("cut off: its header promises 100000 × 100000"), "{error}");
        // The height and width of the frame are two big-endian words after its marker.
        let mut file = jpeg();
        let marker = file.windows(2).position(|two| two == [0xff, 0xc0]).expect("a frame");
        file[marker + 5..marker + 9].copy_from_slice(&[0x40, 0, 0x40, 0]);
        let error = decode(&file).expect_err("268 million pixels").to_string();
        assert!(error.contains("cut off: its header promises 16384 × 16384"), "{error}");
    }

    #[test]
    fn a_palette_of_any_length_is_read_or_refused() {
        for (length, is_sound) in [(48, true), (3, true), (768, true), (5, false), (771, false)] {
            let mut file = Vec::new();
            let mut encoder = png::Encoder::new(&mut file, 4, 1);
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(vec![7; length]);
            encoder.set_trns(vec![9; 16]);
            let mut writer = encoder.write_header().expect("it is written");
            writer.write_image_data(&[0, 1, 2, 255]).expect("it is written");
            drop(writer);
            assert_eq!(decode(&file).is_ok(), is_sound, "{length}");
        }
    }

    /// Every byte of pictures of all kinds, changed.
    #[test]
    fn a_changed_byte_of_a_picture_never_panics() {
        let colors = [
            (png::ColorType::Grayscale, png::BitDepth::One, 1),
            (png::ColorType::GrayscaleAlpha, png::BitDepth::Eight, 32),
            (png::ColorType::Indexed, png::BitDepth::Four, 8),
            (png::ColorType::Rgb, png::BitDepth::Sixteen, 96),
            (png::ColorType::Rgba, png::BitDepth::Eight, 64),
        ];
        let mut pictures: Vec<Vec<u8>> = colors
            .into_iter()
            .map(|(color, depth, bytes)| {
                let mut file = Vec::new();
                let mut encoder = png::Encoder::new(&mut file, if bytes == 1 { 8 } else { 16 }, 1);
                encoder.set_color(color);
                encoder.set_depth(depth);
                if color == png::ColorType::Indexed {
                    encoder.set_palette(vec![7; 48]);
                    encoder.set_trns(vec![0; 16]);
                }
                let mut writer = encoder.write_header().expect("it is written");
                let pixels: Vec<u8> = (0..bytes).map(|i: u8| i.wrapping_mul(3)).collect();
                writer.write_image_data(&pixels).expect("it is written");
                writer.finish().expect("it is written");
                file
            })
            .collect();
        for is_progressive in [false, true] {
            let mut file = Vec::new();
            let mut encoder = jpeg_encoder::Encoder::new(&mut file, 60);
            encoder.set_progressive(is_progressive);
            let pixels: Vec<u8> = (0..24 * 16 * 3_u32).map(|i| (i % 251) as u8).collect();
            encoder.encode(&pixels, 24, 16, jpeg_encoder::ColorType::Rgb).expect("it is written");
            pictures.push(file);
        }
        let options = ReadOptions { max_memory: 64 << 20, ..ReadOptions::default() };
        let decode = |bytes: &[u8]| {
            let mut reading = Reading::new(&options);
            Texture::decode(bytes, "picture", &mut reading).map(|_| reading.into_notes().len())
        };
        for mut picture in pictures {
            assert_eq!(decode(&picture).expect("it is sound"), 0);
            for at in 0..picture.len() {
                let sound = picture[at];
                for change in [0, 1, 3, 0x7f, 0x80, 0xff] {
                    picture[at] = change;
                    assert!(decode(&picture).unwrap_or_default() <= 1);
                }
                picture[at] = sound;
            }
        }
    }

    #[test]
    fn the_limit_on_memory_holds() {
        let options = ReadOptions { max_memory: 1000, ..ReadOptions::default() };
        let error = Texture::decode(&jpeg(), "", &mut Reading::new(&options)).expect_err("2 kB");
        assert!(error.to_string().contains("--max-memory"), "{error}");
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        for bytes in [&b"GIF89a"[..], b"", b"\x76\x2f\x31\x01", b"\xff\xd8"] {
            let error = decode(bytes).expect_err("neither").to_string();
            assert_eq!(error, "picture: PNG or JPEG: it is neither; save it as one of them");
        }
    }
}
