//! Pictures, tile by tile.

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use trisect_scene::{Color, Lens, PixelRays};
use trisect_tracer::TriangleHit;

use crate::image::Image;
use crate::needs::{self, Facts, Job, Needs, Part, Parts, Paths};
use crate::random::{Random, on_disc};
use crate::sampling::CONTRAST;
use crate::settings::{Mode, Settings};
use crate::stage::Stage;
use crate::wave::{Counts, Wave, ray};

/// Samples that go together: so many that a batch is worth its calls, and few enough for the second
/// cache.
const BATCH: usize = 4096;

/// Who looks on while a picture is made.
pub struct Watch<'a> {
    /// Set, it ends the work within a batch of rays.
    pub stop: &'a AtomicBool,
    /// Called from any thread whenever a tile is done.
    pub tile: &'a (dyn Fn() + Sync),
}

/// The picture was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before the picture was done")]
pub struct Interrupted;

/// A part of a picture.
#[derive(Clone, Copy)]
struct Tile {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

/// Makes pictures of a scene, on the threads of the pool that it is called in. What memory that takes is
/// kept from picture to picture.
pub struct Renderer<'s> {
    stage: &'s Stage,
    facts: Facts,
    kept: Parts,
    /// What a thread works with, and a tile's colours.
    rooms: Mutex<Vec<(Wave, Vec<Color>)>>,
    counts: Mutex<Counts>,
    /// What the last paths brought.
    brought: Image,
    /// What the rays of the camera hit, where that is known.
    primary: Option<&'s [Option<TriangleHit>]>,
}

impl<'s> Renderer<'s> {
    /// For a scene.
    pub fn new(stage: &'s Stage) -> Self {
        Self {
            stage,
            facts: Facts::of(stage),
            kept: Parts::NONE,
            rooms: Mutex::default(),
            counts: Mutex::default(),
            brought: Image::black([0, 0]),
            primary: None,
        }
    }

    /// Takes what the camera's ray through the middle of each pixel hits among the triangles, row by row, from
    /// elsewhere: pictures after Whitted of one sample a pixel trace no such rays. Triangles are numbered as
    /// [`Stage::placed`] has them, and values are in the stage's units.
    pub fn seeing(mut self, hits: &'s [Option<TriangleHit>]) -> Self {
        self.primary = Some(hits);
        self
    }

    /// Keeps parts that a picture can do without, to see what they cost; it is the same to the bit.
    pub fn keeping(mut self, parts: Parts) -> Self {
        self.kept = parts;
        self
    }

    /// What is in the scene.
    pub fn facts(&self) -> Facts {
        self.facts
    }

    /// How many tiles a picture is done in; where paths are traced, each sample goes over all of them.
    pub fn tiles(settings: &Settings) -> u64 {
        let rounds = if settings.mode == Mode::Paths { settings.sampling.count() } else { 1 };
        tiles(settings).len() as u64 * u64::from(rounds)
    }

    /// Rays of all pictures so far.
    pub fn counts(&self) -> Counts {
        *lock(&self.counts)
    }

    /// What a picture is made with.
    fn parts(&self, settings: &Settings) -> Parts {
        self.facts.needs(settings) | self.kept
    }

    /// Makes a picture.
    ///
    /// # Errors
    /// When it is stopped.
    ///
    /// # Panics
    /// When the scene has no such camera, or the picture or its tiles have no pixels.
    pub fn render(&mut self, settings: &Settings, watch: &Watch<'_>) -> Result<Image, Interrupted> {
        let mut image = Image::black(settings.size);
        if settings.mode == Mode::Paths {
            for sample in 0..settings.sampling.count() {
                self.accumulate(settings, sample, &mut image, watch)?;
            }
            let share = 1.0 / settings.sampling.count() as f32;
            image.pixels.iter_mut().for_each(|pixel| *pixel *= share);
            return Ok(image);
        }
        let stage = self.stage;
        let parts = self.parts(settings);
        let drawing = Drawing { renderer: self, stage, settings, parts, watch, image: &mut image };
        needs::with(parts, drawing)?;
        Ok(image)
    }

    /// Traces one more path for each pixel, and adds what it brings to the image; divided by the number of
    /// paths, the image is the picture.
    ///
    /// # Errors
    /// When it is stopped; the image is as it was then.
    ///
    /// # Panics
    /// As [`render`](Renderer::render), and when the image is of another size.
    pub fn accumulate(
        &mut self,
        settings: &Settings,
        sample: u32,
        image: &mut Image,
        watch: &Watch<'_>,
    ) -> Result<(), Interrupted> {
        assert!(image.size == settings.size, "the image has another size");
        let (stage, parts) = (self.stage, self.parts(settings));
        let mut brought = std::mem::replace(&mut self.brought, Image::black([0, 0]));
        if brought.size != settings.size {
            brought = Image::black(settings.size);
        }
        let done = self.pass(settings, watch, &mut brought, |wave, tile, out| {
            stage.draw_paths((settings, parts), sample, wave, tile, out, watch);
        });
        if done.is_ok() {
            image
                .pixels
                .iter_mut()
                .zip(&brought.pixels)
                .for_each(|(pixel, color)| *pixel += *color);
        }
        self.brought = brought;
        done
    }

    /// Draws all tiles of an image.
    fn pass<D>(
        &self,
        settings: &Settings,
        watch: &Watch<'_>,
        image: &mut Image,
        draw: D,
    ) -> Result<(), Interrupted>
    where
        D: Fn(&mut Wave, Tile, &mut [Color]) + Sync,
    {
        let width = settings.size[0] as usize;
        let pixels = Mutex::new(&mut image.pixels[..]);
        tiles(settings).into_par_iter().with_max_len(1).for_each(|tile| {
            if watch.stop.load(Ordering::Relaxed) {
                return;
            }
            let (mut wave, mut colors) = lock(&self.rooms).pop().unwrap_or_default();
            colors.resize(tile.width as usize * tile.height as usize, Vec3::ZERO);
            draw(&mut wave, tile, &mut colors);
            let mut pixels = lock(&pixels);
            for (y, row) in (tile.y as usize..).zip(colors.chunks_exact(tile.width as usize)) {
                let start = y * width + tile.x as usize;
                pixels[start..start + row.len()].copy_from_slice(row);
            }
            drop(pixels);
            lock(&self.counts).add(std::mem::take(&mut wave.counts));
            lock(&self.rooms).push((wave, colors));
            (watch.tile)();
        });
        if watch.stop.load(Ordering::Relaxed) { Err(Interrupted) } else { Ok(()) }
    }
}

/// What a mutex holds; a panic elsewhere ends the picture anyway.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// The parts of a picture, row by row.
fn tiles(settings: &Settings) -> Vec<Tile> {
    let ([width, height], side) = (settings.size, settings.tile);
    assert!(width > 0 && height > 0 && side > 0, "a picture and its tiles have pixels");
    let starts = |length: u32| (0..length).step_by(side as usize);
    starts(height)
        .flat_map(|y| {
            starts(width).map(move |x| Tile {
                x,
                y,
                width: side.min(width - x),
                height: side.min(height - y),
            })
        })
        .collect()
}

/// All tiles of an image, drawn after Whitted.
struct Drawing<'a, 's> {
    renderer: &'a Renderer<'s>,
    stage: &'s Stage,
    settings: &'a Settings,
    parts: Parts,
    watch: &'a Watch<'a>,
    image: &'a mut Image,
}

impl Job for Drawing<'_, '_> {
    type Output = Result<(), Interrupted>;
    fn run<N: Needs>(self) -> Self::Output {
        let Self { renderer, stage, settings, parts, watch, image } = self;
        renderer.pass(settings, watch, image, |wave, tile, out| {
            stage.draw::<N>((settings, parts), renderer.primary, wave, tile, out, watch);
        })
    }
}

impl Stage {
    /// Draws a tile after Whitted. Out of line, so that the program says how much code that is.
    #[inline(never)]
    fn draw<N: Needs>(
        &self,
        (settings, parts): (&Settings, Parts),
        primary: Option<&[Option<TriangleHit>]>,
        wave: &mut Wave,
        tile: Tile,
        out: &mut [Color],
        watch: &Watch<'_>,
    ) {
        let sampling = settings.sampling;
        let (first, more) = (sampling.count() as usize, sampling.more() as usize);
        let eye = Eye::new(self, settings);
        let pixels = u32::try_from(out.len()).expect("a tile has few pixels");
        // Those whose samples differ, with their sums.
        let mut rough: Vec<u32> = Vec::new();
        let batch = u32::try_from((BATCH / first).max(1)).expect("it is small");
        for start in (0..pixels).step_by(batch as usize) {
            let end = pixels.min(start + batch);
            eye.look_at::<N>(parts, wave, tile, start..end);
            if let Some(hits) = primary.filter(|_| !parts.has(Part::Samples)) {
                wave.see((start..end).map(|pixel| {
                    let [x, y] = tile.pixel(pixel);
                    hits[y as usize * settings.size[0] as usize + x as usize]
                }));
            }
            let radiance = wave.follow::<N>(self, settings, parts, watch.stop);
            let out = &mut out[start as usize..end as usize];
            if !parts.has(Part::Samples) {
                out.copy_from_slice(radiance);
                continue;
            }
            for ((pixel, out), samples) in (start..).zip(out).zip(radiance.chunks_exact(first)) {
                *out = mean(samples);
                if more > 0 && differ(samples) {
                    rough.push(pixel);
                }
            }
        }
        for pixels in rough.chunks((BATCH / more.max(1)).max(1)) {
            wave.clear();
            for &pixel in pixels {
                let samples = sampling.count()..sampling.count() + sampling.more();
                eye.look::<N>(wave, tile.pixel(pixel), samples);
            }
            let radiance = wave.follow::<N>(self, settings, parts, watch.stop);
            for (&pixel, samples) in pixels.iter().zip(radiance.chunks_exact(more)) {
                let few = out[pixel as usize];
                let share = more as f32 / (first + more) as f32;
                out[pixel as usize] = few.lerp(mean(samples), share);
            }
        }
    }

    /// Draws one path for each pixel of a tile; out of line likewise.
    #[inline(never)]
    fn draw_paths(
        &self,
        (settings, parts): (&Settings, Parts),
        sample: u32,
        wave: &mut Wave,
        tile: Tile,
        out: &mut [Color],
        watch: &Watch<'_>,
    ) {
        let eye = Eye::new(self, settings);
        let all: Vec<u32> = (0..).take(out.len()).collect();
        for pixels in all.chunks(BATCH) {
            wave.clear();
            for &pixel in pixels {
                eye.look::<Paths>(wave, tile.pixel(pixel), sample..sample + 1);
            }
            let radiance = wave.follow::<Paths>(self, settings, parts, watch.stop);
            for (&pixel, color) in pixels.iter().zip(radiance) {
                out[pixel as usize] = *color;
            }
        }
    }
}

impl Tile {
    /// Where in the picture one of its pixels is.
    fn pixel(self, number: u32) -> [u32; 2] {
        [self.x + number % self.width, self.y + number / self.width]
    }
}

fn mean(samples: &[Color]) -> Color {
    samples.iter().sum::<Color>() * (1.0 / samples.len() as f32)
}

/// Whether samples differ as the eye sees them.
fn differ(samples: &[Color]) -> bool {
    let seen = |color: &Color| color.min(Vec3::ONE).max(Vec3::ZERO).map(f32::sqrt);
    let (mut low, mut high) = (Vec3::ONE, Vec3::ZERO);
    for sample in samples.iter().map(seen) {
        (low, high) = (low.min(sample), high.max(sample));
    }
    (high - low).max_element() > CONTRAST
}

/// A camera and where its rays go through.
pub(crate) struct Eye<'a> {
    /// In the stage's frame.
    rays: PixelRays,
    settings: &'a Settings,
}

impl<'a> Eye<'a> {
    pub(crate) fn new(stage: &Stage, settings: &'a Settings) -> Self {
        Self { rays: stage.pixel_rays(settings), settings }
    }

    /// Sends the rays of the first samples of some pixels of a tile, and no others.
    fn look_at<N: Needs>(&self, parts: Parts, wave: &mut Wave, tile: Tile, pixels: Range<u32>) {
        let is_straight = !parts.has(Part::Samples);
        // A loop for each lens: the compiler computes several rays at a time, and would compute those of all
        // lenses, of numbers that are not there.
        match self.rays.camera().lens {
            Lens::Pinhole { field_of_view } if is_straight => {
                self.look_straight::<N>(wave, tile, pixels, Lens::Pinhole { field_of_view });
            }
            Lens::Orthographic { height } if is_straight => {
                self.look_straight::<N>(wave, tile, pixels, Lens::Orthographic { height });
            }
            _ => {
                wave.clear();
                for pixel in pixels {
                    self.look::<N>(wave, tile.pixel(pixel), 0..self.settings.sampling.count());
                }
            }
        }
    }

    /// Sends a ray through the middle of each of these pixels, as [`look`](Eye::look) would, without its
    /// questions.
    #[inline(always)]
    fn look_straight<N: Needs>(&self, wave: &mut Wave, tile: Tile, pixels: Range<u32>, lens: Lens) {
        let middle = Vec2::splat(0.5);
        // On the stack: nothing that is written can change it, so that what is the same for a row is computed
        // once.
        let eye = Eye { rays: self.rays.with_lens(lens), ..*self };
        let mut rays = wave.primary(pixels.len());
        let mut start = pixels.start;
        while !rays.is_empty() {
            let [x, y] = tile.pixel(start);
            let of_row = ((tile.x + tile.width - x) as usize).min(rays.len());
            let (row, rest) = rays.split_at_mut(of_row);
            for (x, to) in (x..).zip(row) {
                let (o, d) = eye.ray([x, y], middle, || Vec2::ZERO);
                *to = ray(o, d, f32::INFINITY);
            }
            rays = rest;
            start = (start / tile.width + 1) * tile.width;
        }
        if N::SHADOWS {
            let width = self.settings.size[0];
            wave.samples.extend(pixels.map(|pixel| {
                let [x, y] = tile.pixel(pixel);
                [y * width + x, 0]
            }));
        }
    }

    /// Sends the rays of a pixel's samples.
    fn look<N: Needs>(&self, wave: &mut Wave, at: [u32; 2], samples: Range<u32>) {
        let Settings { size, seed, mode, sampling, .. } = self.settings;
        let pixel = at[1] * size[0] + at[0];
        for sample in samples {
            let random = Random { seed: *seed, pixel, sample };
            let point = match mode {
                Mode::Paths => {
                    let [u, v, ..] = random.four(0);
                    Vec2::new(u, v)
                }
                Mode::Whitted { .. } => sampling.point(random),
            };
            let on_lens = || {
                let at = match mode {
                    Mode::Paths => {
                        let [.., u, v] = random.four(0);
                        Vec2::new(u, v)
                    }
                    Mode::Whitted { .. } => sampling.on_lens(random),
                };
                on_disc(at.x, at.y)
            };
            let (o, d) = self.ray(at, point, on_lens);
            wave.push_primary::<N>(pixel, sample, o, d);
        }
    }

    /// The ray through a point of a pixel, from 0 to 1 across and down, its direction of unit length.
    #[inline(always)]
    pub(crate) fn ray(
        &self,
        pixel: [u32; 2],
        point: Vec2,
        on_lens: impl FnOnce() -> Vec2,
    ) -> (Vec3, Vec3) {
        self.rays.ray_at(pixel, point, on_lens)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_picture_once() {
        for side in [1, 7, 64, 1000] {
            let settings = Settings { tile: side, ..Settings::new([37, 23]) };
            let mut seen = vec![0; 37 * 23];
            for tile in tiles(&settings) {
                for number in 0..tile.width * tile.height {
                    let [x, y] = tile.pixel(number);
                    seen[(y * 37 + x) as usize] += 1;
                }
            }
            assert!(seen.iter().all(|&times| times == 1), "{side}");
        }
    }
}
