//! Pictures: in memory as light, in files as PNG for the eye or EXR for further work.

use std::io::{self, Seek, Write};
use std::path::Path;

use exr::prelude::WritableImage as _;
use glam::Vec3;
use trisect_scene::Color;

/// A picture, as linear radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// The pixels, row by row from above.
    pub pixels: Vec<Color>,
}

/// What a picture's file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// 8 bits of sRGB a colour; what is brighter than 1 is 1.
    Png,
    /// `OpenEXR`: 32-bit floats, linear, run-length encoded.
    Exr,
}

/// A picture cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The ending of the file's name is not known.
    #[error("unknown type of picture; known are .png and .exr")]
    UnknownType,
    /// The PNG encoder failed.
    #[error("{0}")]
    Png(#[from] png::EncodingError),
    /// The EXR encoder failed.
    #[error("{0}")]
    Exr(#[from] exr::error::Error),
    /// The writer failed.
    #[error("{0}")]
    Io(#[from] io::Error),
}

impl ImageFormat {
    /// The format of a file by its ending, in either case.
    ///
    /// # Errors
    /// When the ending is not known.
    pub fn of(path: &Path) -> Result<Self, ImageError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        match ending.to_ascii_lowercase().as_str() {
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            _ => Err(ImageError::UnknownType),
        }
    }
}

impl Image {
    /// A black picture.
    pub fn black(size: [u32; 2]) -> Self {
        Self { size, pixels: vec![Vec3::ZERO; size[0] as usize * size[1] as usize] }
    }

    /// Three bytes of sRGB a pixel, rounded to the nearest.
    pub fn to_srgb(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|color| color.to_array().map(encode)).collect()
    }

    /// Writes the picture as a file.
    ///
    /// # Errors
    /// When the writer or the encoder fails.
    pub fn write(
        &self,
        format: ImageFormat,
        out: &mut (impl Write + Seek),
    ) -> Result<(), ImageError> {
        let [width, height] = self.size;
        match format {
            ImageFormat::Png => {
                let mut encoder = png::Encoder::new(&mut *out, width, height);
                encoder.set_color(png::ColorType::Rgb);
                encoder.set_depth(png::BitDepth::Eight);
                encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
                let mut writer = encoder.write_header()?;
                writer.write_image_data(&self.to_srgb())?;
                writer.finish()?;
            }
            ImageFormat::Exr => {
                let size = (width as usize, height as usize);
                let pixel =
                    |at: exr::math::Vec2<usize>| self.pixels[at.y() * size.0 + at.x()].into();
                let channels = exr::image::SpecificChannels::rgb(|at| {
                    let color: [f32; 3] = pixel(at);
                    (color[0], color[1], color[2])
                });
                exr::image::Image::from_channels(size, channels).write().to_buffered(&mut *out)?;
            }
        }
        Ok(out.flush()?)
    }

    /// How much two pictures differ, as the eye sees them: the square root of the mean squared difference
    /// of their sRGB values, from 0 to 1; and the share of pixels that differ by more than a 32nd in any
    /// colour.
    ///
    /// # Panics
    /// When they have different sizes.
    pub fn difference(&self, other: &Self) -> (f64, f64) {
        assert!(self.size == other.size, "pictures of one size are compared");
        let (a, b) = (self.to_srgb(), other.to_srgb());
        let (mut squares, mut wrong) = (0.0, 0);
        for (a, b) in a.chunks_exact(3).zip(b.chunks_exact(3)) {
            let mut largest = 0;
            for (a, b) in a.iter().zip(b) {
                let apart = a.abs_diff(*b);
                largest = largest.max(apart);
                squares += (f64::from(apart) / 255.0).powi(2);
            }
            wrong += u32::from(largest > 8);
        }
        let count = self.pixels.len().max(1) as f64;
        ((squares / (3.0 * count)).sqrt(), f64::from(wrong) / count)
    }
}

/// The 8-bit sRGB value of a linear one (IEC 61966-2-1); of NaN 0.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
fn encode(linear: f32) -> u8 {
    // Negative or NaN.
    let linear = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    let curved =
        if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (curved * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use exr::prelude::{ReadChannels as _, ReadLayers as _};

    use super::*;

    fn picture() -> Image {
        let pixels = (0..12).map(|i| Vec3::new(i as f32 / 8.0, 0.25, -0.0)).collect();
        Image { size: [4, 3], pixels }
    }

    #[test]
    fn srgb_is_that_of_the_standard() {
        assert_eq!(
            [0.0, 0.001, 0.215_861, 0.5, 1.0, 7.0, -1.0].map(encode),
            [0, 3, 128, 188, 255, 255, 0]
        );
        assert_eq!(encode(f32::NAN), 0);
    }

    #[test]
    fn a_png_reads_back_as_it_was_seen() {
        let mut file = Cursor::new(Vec::new());
        picture().write(ImageFormat::Png, &mut file).expect("it is written");
        let mut reader =
            png::Decoder::new(Cursor::new(file.into_inner())).read_info().expect("a PNG");
        let mut bytes = vec![0; reader.output_buffer_size().expect("it is small")];
        reader.next_frame(&mut bytes).expect("a picture");
        assert_eq!(bytes, picture().to_srgb());
    }

    #[test]
    fn an_exr_reads_back_to_the_bit() {
        let mut file = Cursor::new(Vec::new());
        picture().write(ImageFormat::Exr, &mut file).expect("it is written");
        let (magic, length) = (file.get_ref()[..4].to_vec(), file.get_ref().len());
        assert_eq!(magic, [0x76, 0x2f, 0x31, 0x01]);
        assert!(length > 12 * 12);
        let read = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                |size, _| {
                    Image::black([
                        u32::try_from(size.0).unwrap_or(0),
                        u32::try_from(size.1).unwrap_or(0),
                    ])
                },
                |image, at, (red, green, blue): (f32, f32, f32)| {
                    let place = at.y() * image.size[0] as usize + at.x();
                    image.pixels[place] = Vec3::new(red, green, blue);
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(file.into_inner()))
            .expect("an EXR");
        assert_eq!(read.layer_data.channel_data.pixels, picture());
    }

    #[test]
    fn differences_count_pixels_and_size() {
        let (mut other, one) = (picture(), picture());
        assert_eq!(one.difference(&other), (0.0, 0.0));
        other.pixels[0] = Vec3::new(1.0, 0.25, 0.0);
        let (root, share) = one.difference(&other);
        assert!((root - (1.0_f64 / 36.0).sqrt()).abs() < 1e-9, "{root}");
        assert!((share - 1.0 / 12.0).abs() < 1e-9);
    }
}
