//! A frame: what the window shows, with what is written over the picture.

use std::convert::Infallible;

use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{Dimensions as _, OriginDimensions, Point, Size};
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::iso_8859_1::FONT_7X13;
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::Rectangle;
use embedded_graphics::text::{Baseline, Text};

/// A colour of a frame, as the screen shows it.
pub type Rgb = [u8; 3];

/// Height of a line of text.
pub(crate) const LINE: i32 = 15;

/// Width of a letter.
const LETTER: u32 = 7;

/// Between a box and what is in it.
pub(crate) const MARGIN: i32 = 6;

/// What the window shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Row by row from above: red in bits 16 to 23, green in 8 to 15, blue in 0 to 7.
    pub pixels: Vec<u32>,
}

impl Frame {
    /// From the colours of a picture that may be coarser: each of its pixels becomes a square.
    pub(crate) fn of([width, height]: [u32; 2], coarse: [u32; 2], colors: &[Rgb]) -> Self {
        let place = |at: u32, of: u32, coarse: u32| at as usize * coarse as usize / of as usize;
        let columns: Vec<usize> = (0..width).map(|x| place(x, width, coarse[0])).collect();
        let pixels = (0..height).flat_map(|y| {
            let row = &colors[place(y, height, coarse[1]) * coarse[0] as usize..];
            columns.iter().map(|&x| number(row[x]))
        });
        Self { size: [width, height], pixels: pixels.collect() }
    }

    /// Three bytes a pixel, as files have it.
    pub fn to_rgb(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|pixel| pixel.to_be_bytes().into_iter().skip(1)).collect()
    }

    /// Darkens a box for what is written on it.
    pub(crate) fn shade(&mut self, at: [i32; 2], size: [i32; 2]) {
        let asked = Rectangle::new(Point::from(at), Size::from(size.map(i32::unsigned_abs)));
        let Rectangle { top_left, size } = self.bounding_box().intersection(&asked);
        for y in (0..size.height).map(|y| y + top_left.y.unsigned_abs()) {
            let start = (y * self.size[0] + top_left.x.unsigned_abs()) as usize;
            for pixel in &mut self.pixels[start..start + size.width as usize] {
                // A quarter of each colour.
                *pixel = *pixel >> 2 & 0x003f_3f3f;
            }
        }
    }

    /// Writes a line of text, from its upper left corner.
    pub(crate) fn write(&mut self, text: &str, at: [i32; 2], color: Rgb) {
        let style = MonoTextStyle::new(&FONT_7X13, color888(color));
        let Ok(_) = Text::with_baseline(text, Point::from(at), style, Baseline::Top).draw(self);
    }

    /// Writes lines of text on a dark box, from its upper left corner; how high it is.
    pub(crate) fn write_box(&mut self, lines: &[&str], [x, y]: [i32; 2]) -> i32 {
        let width = lines.iter().map(|line| width_of(line)).max().unwrap_or(0);
        let height = LINE * i32::try_from(lines.len()).unwrap_or(0) + 2 * MARGIN;
        self.shade([x, y], [width + 2 * MARGIN, height]);
        for (line, at) in lines.iter().zip((y + MARGIN..).step_by(LINE.unsigned_abs() as usize)) {
            self.write(line, [x + MARGIN, at], [255, 255, 255]);
        }
        height
    }

    /// Fills a box.
    pub(crate) fn fill(&mut self, at: [i32; 2], size: [i32; 2], color: Rgb) {
        let size = Size::from(size.map(i32::unsigned_abs));
        let Ok(()) = self.fill_solid(&Rectangle::new(Point::from(at), size), color888(color));
    }
}

/// Pixels across a line of text.
pub(crate) fn width_of(line: &str) -> i32 {
    i32::try_from(line.chars().count()).unwrap_or(i32::MAX / 8) * LETTER.cast_signed()
}

fn number([red, green, blue]: Rgb) -> u32 {
    u32::from_be_bytes([0, red, green, blue])
}

fn color888([red, green, blue]: Rgb) -> Rgb888 {
    Rgb888::new(red, green, blue)
}

impl OriginDimensions for Frame {
    fn size(&self) -> Size {
        self.size.into()
    }
}

impl DrawTarget for Frame {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I>(&mut self, pixels: I) -> Result<(), Infallible>
    where
        I: IntoIterator<Item = Pixel<Rgb888>>,
    {
        for Pixel(at, color) in pixels {
            if self.bounding_box().contains(at) {
                let place = at.y.unsigned_abs() * self.size[0] + at.x.unsigned_abs();
                self.pixels[place as usize] = number([color.r(), color.g(), color.b()]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgb = [255, 0, 0];
    const BLUE: Rgb = [0, 0, 255];

    #[test]
    fn coarse_pixels_become_squares() {
        let frame = Frame::of([4, 4], [2, 1], &[RED, BLUE]);
        assert_eq!(frame.pixels, [0x00ff_0000, 0x00ff_0000, 0xff, 0xff].repeat(4));
        assert_eq!(frame.to_rgb()[..6], [255, 0, 0, 255, 0, 0]);
    }

    #[test]
    fn text_is_written_inside_and_cut_off_outside() {
        let mut frame = Frame::of([40, 30], [1, 1], &[BLUE]);
        let before = frame.clone();
        frame.write("H", [2, 2], RED);
        let red = frame.pixels.iter().filter(|pixel| **pixel == 0x00ff_0000).count();
        assert!((10..40).contains(&red), "{red}");
        for at in [[-100, 0], [100, 0], [0, -100], [0, 100]] {
            let mut frame = before.clone();
            frame.write("Hhh", at, RED);
            frame.shade(at, [10, 10]);
            frame.fill(at, [20, 20], RED);
            assert_eq!(frame, before);
        }
        let mut frame = before;
        frame.shade([30, 20], [100, 100]);
        let shaded = frame.pixels.iter().filter(|pixel| **pixel == 0x3f).count();
        assert_eq!(shaded, 10 * 10);
    }
}
