//! Colours: each pixel is painted once, after it is known what is seen there, as many pixels at a time as there are
//! lanes.

use std::marker::PhantomData;
use std::sync::LazyLock;

use glam::{Vec2, Vec3 as Point};
use rayon::prelude::*;
use trisect_core::{Lanes, Token as _, Vec3};
use trisect_scene::{Color, Material, PixelRays, Texture};
use trisect_tracer::{Job, on_lanes};

use crate::frame::Rasteriser;
use crate::judge::locate;
use crate::light::{inverse_root, lit, splat, unit};
use crate::model::Scenery;
use crate::options::{Bare, Perspective, Phong};
use crate::options::{Culls, Edges, MapBy, PerspectiveCulling, ShadeBy, Shading, Texturing};
use crate::tile::{NOTHING, STRIDE, TILE, Tile};
use crate::view::View;

/// What a picture is made of.
pub trait Pixel: Copy + Send + Sync + 'static {
    /// Of linear red, green and blue.
    fn of(color: Color) -> Self;
}

/// As it is.
impl Pixel for Color {
    #[inline(always)]
    fn of(color: Color) -> Self {
        color
    }
}

/// Eight bits of sRGB a colour: `0x00RRGGBB`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Srgb(pub u32);

/// Values of sRGB, by the linear one in [`STEPS`].
static SRGB: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let encode = |step: u16| {
        let linear = f32::from(step) / f32::from(STEPS);
        let curved = if linear <= 0.003_130_8 {
            linear * 12.92
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
        let byte = (curved * 255.0 + 0.5) as u8;
        byte
    };
    (0..=STEPS).map(encode).collect()
});

const STEPS: u16 = 8192;

impl Pixel for Srgb {
    #[inline(always)]
    fn of(color: Color) -> Self {
        let table = &**SRGB;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        let byte = |x: f32| {
            u32::from(table[(x.clamp(0.0, 1.0) * f32::from(STEPS) + 0.5) as usize % table.len()])
        };
        Self(byte(color.x) << 16 | byte(color.y) << 8 | byte(color.z))
    }
}

/// A quantity that varies over a triangle: in the middle of the picture, and by pixels right and down.
#[derive(Clone, Copy, Default)]
struct Varying([f32; 3]);

impl Varying {
    #[inline(always)]
    fn at<L: Lanes<Elem = f32>>(self, token: L::Token, [right, down]: [L; 2]) -> L {
        let [middle, x, y] = self.0;
        let row = down.mul_add(L::splat(token, y), L::splat(token, middle));
        right.mul_add(L::splat(token, x), row)
    }

    /// Of weights that vary, and what they weigh.
    fn of(weights: &[Self; 3], values: [f32; 3]) -> Self {
        let [a, b, c] = weights;
        Self([0, 1, 2].map(|i| a.0[i] * values[0] + b.0[i] * values[1] + c.0[i] * values[2]))
    }

    fn of_points(weights: &[Self; 3], [a, b, c]: [Point; 3]) -> [Self; 3] {
        [0, 1, 2].map(|axis| Self::of(weights, [a[axis], b[axis], c[axis]]))
    }
}

/// A triangle that is painted: what its pixels ask for, and no more.
#[derive(Clone, Copy, Default)]
struct Fragment {
    material: u32,
    /// What all below but a texture that lies in the picture is divided by.
    weight: Varying,
    coordinates: [Varying; 2],
    /// A colour, or the normal.
    first: [Varying; 3],
    position: [Varying; 3],
}

/// Fragments that a tile remembers.
const KEPT: usize = 128;

/// A tile's pixels.
struct Canvas<P> {
    pixels: Vec<P>,
    numbers: Vec<u32>,
    fragments: Vec<Fragment>,
    /// Of what colour all of it is, where nothing is seen.
    empty: Option<Color>,
}

/// Paints pictures of a scene. Its memory is kept from picture to picture.
pub struct Painter<S = Phong, T = Perspective, C = PerspectiveCulling, E = Bare, P = Srgb> {
    rasteriser: Rasteriser<C, E>,
    canvases: Vec<Canvas<P>>,
    options: PhantomData<(S, T)>,
}

impl<S: Shading, T: Texturing, C: Culls, E: Edges, P: Pixel> Default for Painter<S, T, C, E, P> {
    fn default() -> Self {
        Self { rasteriser: Rasteriser::new(), canvases: Vec::new(), options: PhantomData }
    }
}

impl<S: Shading, T: Texturing, C: Culls, E: Edges, P: Pixel> Painter<S, T, C, E, P> {
    /// Paints a picture, on the threads of the pool that it is called in. Whether it did: see
    /// [`Rasteriser::draw`].
    ///
    /// # Panics
    /// As [`Rasteriser::draw`].
    pub fn paint(&mut self, scenery: &Scenery, rays: &PixelRays) -> bool {
        let Some(view) = View::new(rays, None) else { return false };
        if !self.rasteriser.draw(&scenery.objects, rays) {
            return false;
        }
        let tiles = self.rasteriser.tiles();
        self.canvases.resize_with(tiles.len(), || Canvas {
            pixels: vec![P::of(Point::ZERO); TILE[0] * TILE[1]],
            numbers: vec![NOTHING; KEPT],
            fragments: vec![Fragment::default(); KEPT],
            empty: None,
        });
        let (view, firsts) = (&view, self.rasteriser.firsts());
        let paint = |(tile, canvas): (&Tile, &mut Canvas<P>)| {
            on_lanes(Paint::<S, T, P> {
                tile,
                canvas,
                scenery,
                view,
                firsts,
                options: PhantomData,
            });
        };
        if rayon::current_num_threads() == 1 {
            tiles.iter().zip(&mut self.canvases).for_each(paint);
        } else {
            tiles.par_iter().zip(&mut self.canvases).for_each(paint);
        }
        true
    }

    /// The picture, row by row.
    pub fn pixels(&self) -> Vec<P> {
        let [width, height] = self.rasteriser.size().map(|side| side as usize);
        let across = width.div_ceil(TILE[0]);
        let at = |(x, y): (usize, usize)| {
            let canvas = &self.canvases[y / TILE[1] * across + x / TILE[0]];
            canvas.pixels[y % TILE[1] * TILE[0] + x % TILE[0]]
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(at).collect()
    }

    /// What is seen.
    pub fn rasteriser(&self) -> &Rasteriser<C, E> {
        &self.rasteriser
    }
}

/// Paints a tile.
struct Paint<'a, S, T, P> {
    tile: &'a Tile,
    canvas: &'a mut Canvas<P>,
    scenery: &'a Scenery,
    view: &'a View,
    firsts: &'a [u32],
    options: PhantomData<(S, T)>,
}

impl<S: Shading, T: Texturing, P: Pixel> Job for Paint<'_, S, T, P> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        token.run(
            #[inline(always)]
            || self.tile::<L>(token),
        );
    }
}

impl<S: Shading, T: Texturing, P: Pixel> Paint<'_, S, T, P> {
    #[inline(always)]
    fn tile<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { tile, canvas, scenery, view, firsts, .. } = self;
        canvas.numbers.fill(NOTHING);
        let is_even = scenery.sky[0] == scenery.sky[1];
        let is_empty = tile.is_clear();
        let empty = (is_empty && is_even).then_some(scenery.sky[0]);
        if empty.is_some() && canvas.empty == empty {
            return;
        }
        canvas.empty = empty;
        let even = P::of(scenery.sky[0]);
        let ramp = L::load(token, &RAMP);
        for y in 0..tile.size[1] {
            let down = L::splat(token, (tile.corner[1] + y) as f32 + 0.5 - view.half[1]);
            let mut x = 0;
            while x < tile.size[0] {
                let right = (tile.corner[0] + x) as f32 + 0.5 - view.half[0];
                let at = [ramp + L::splat(token, right), down];
                let seen = &tile.seen[y * STRIDE + x..][..L::N];
                let out = &mut canvas.pixels[y * TILE[0] + x..][..L::N];
                let mut left = (1_u64 << L::N) - 1;
                while left != 0 {
                    let number = seen[left.trailing_zeros() as usize].to_bits();
                    let mut same = 0;
                    let mut lane = 0;
                    while lane < L::N {
                        same |= u64::from(seen[lane].to_bits() == number) << lane;
                        lane += 1;
                    }
                    left &= !same;
                    if number == NOTHING && is_even {
                        put(out, same, |_| even);
                        continue;
                    }
                    let color = if number == NOTHING {
                        sky::<L>(token, scenery, view, at)
                    } else if S::BY == ShadeBy::Identity {
                        splat(token, of_number(number))
                    } else {
                        let slot = number as usize % KEPT;
                        if canvas.numbers[slot] != number {
                            canvas.numbers[slot] = number;
                            canvas.fragments[slot] = prepare::<S, T>(scenery, view, firsts, number);
                        }
                        shade::<L, S, T>(token, &canvas.fragments[slot], scenery, view, at)
                    };
                    let mut rows = [[0.0_f32; 16]; 3];
                    color.x.store(&mut rows[0]);
                    color.y.store(&mut rows[1]);
                    color.z.store(&mut rows[2]);
                    put(out, same, |i| P::of(Point::new(rows[0][i], rows[1][i], rows[2][i])));
                }
                x += L::N;
            }
        }
    }
}

/// Writes some lanes.
#[inline(always)]
fn put<P>(out: &mut [P], mut lanes: u64, of: impl Fn(usize) -> P) {
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize % 16;
        lanes &= lanes - 1;
        out[lane] = of(lane);
    }
}

/// The numbers of lanes.
const RAMP: [f32; 16] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// A colour for a number.
fn of_number(number: u32) -> Color {
    let mixed = (number.wrapping_add(1)).wrapping_mul(0x9e37_79b1);
    let part = |shift: u32| (mixed >> shift & 0xff) as f32 / 255.0;
    Point::new(part(24), part(16), part(8))
}

/// The directions of rays, not of unit length.
#[inline(always)]
fn directions<L: Lanes<Elem = f32>>(token: L::Token, view: &View, [x, y]: [L; 2]) -> Vec3<L> {
    let [g0, gx, gy] = view.g.map(Point::from);
    let middle = splat::<L>(token, g0);
    if view.is_parallel {
        return middle;
    }
    splat::<L>(token, gx).mul_add(x, splat::<L>(token, gy).mul_add(y, middle))
}

#[inline(always)]
fn sky<L: Lanes<Elem = f32>>(
    token: L::Token,
    scenery: &Scenery,
    view: &View,
    at: [L; 2],
) -> Vec3<L> {
    let direction = directions(token, view, at);
    let rise = direction.y * inverse_root(token, direction.dot(direction));
    let rise = rise.max(L::splat(token, 0.0)).min(L::splat(token, 1.0));
    let [level, zenith] = scenery.sky;
    splat::<L>(token, zenith - level).mul_add(rise, splat(token, level))
}

/// What a triangle's pixels ask for.
#[inline(never)]
fn prepare<S: Shading, T: Texturing>(
    scenery: &Scenery,
    view: &View,
    firsts: &[u32],
    number: u32,
) -> Fragment {
    let (object, place) = locate(firsts, number);
    let (object, look) = (&scenery.objects[object], &scenery.looks[object]);
    let corners = object.triangles().triangle(place).corners().map(Point::from);
    let origin = Point::from(view.origin);
    let ways = corners.map(|corner| corner - origin);
    let [g0, gx, gy] = view.g.map(Point::from);
    // As in the setup of the edges, of which these are the same numbers.
    let weights = [0, 1, 2].map(|i| {
        let from = ways[(i + 1) % 3];
        let edge = corners[(i + 2) % 3] - corners[(i + 1) % 3];
        if view.is_parallel {
            let m = edge.cross(g0);
            Varying([from.dot(m), m.dot(gx), m.dot(gy)])
        } else {
            let m = from.cross(edge);
            Varying([m.dot(g0), m.dot(gx), m.dot(gy)])
        }
    });
    let material = look.materials[place];
    let mut fragment =
        Fragment { material, weight: Varying::of(&weights, [1.0; 3]), ..Fragment::default() };
    let described = &scenery.materials[material as usize];
    if T::BY != MapBy::Nothing && described.texture.is_some() {
        let at = look.coordinates.get(place).copied().unwrap_or_default();
        let depth = Point::from(view.dual[0]);
        let depths = ways.map(|way| if view.is_parallel { 1.0 } else { way.dot(depth) });
        let (x, y) = (at.map(|at| at.x), at.map(|at| at.y));
        fragment.coordinates = if T::BY == MapBy::Surface {
            [Varying::of(&weights, x), Varying::of(&weights, y)]
        } else {
            // What the weights times the depths add up to is the same at all pixels.
            let whole = 1.0 / Varying::of(&weights, depths).0[0];
            let of = |values: [f32; 3]| {
                Varying::of(&weights, [0, 1, 2].map(|i| values[i] * depths[i] * whole))
            };
            [of(x), of(y)]
        };
    }
    let normals = look.normals[place];
    let lights = (&scenery.lights[..], scenery.ambient);
    let lit_at = |corner: Point, normal: Point| {
        let view = if view.is_parallel { g0 } else { (corner - origin).normalize() };
        let diffuse = described.diffuse;
        let of = |v: Point| Vec3::<f32>::from(v);
        let light =
            lit::<f32>((), lights, described, of(diffuse), (of(corner), of(normal), of(view)));
        Point::from(light)
    };
    match S::BY {
        ShadeBy::Identity | ShadeBy::Nothing => {}
        ShadeBy::Triangle => {
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let color = lit_at(middle, normal.normalize_or_zero());
            fragment.first = color.to_array().map(|x| Varying([x, 0.0, 0.0]));
        }
        ShadeBy::Corners => {
            let colors = [0, 1, 2].map(|i| lit_at(corners[i], normals[i]));
            fragment.first = Varying::of_points(&weights, colors);
        }
        ShadeBy::Pixels => {
            fragment.first = Varying::of_points(&weights, normals);
            fragment.position = Varying::of_points(&weights, corners);
        }
    }
    fragment
}

#[inline(always)]
fn three<L: Lanes<Elem = f32>>(token: L::Token, at: [L; 2], of: &[Varying; 3]) -> Vec3<L> {
    Vec3::new(of[0].at(token, at), of[1].at(token, at), of[2].at(token, at))
}

/// The colours of pixels that a triangle is seen at.
#[inline(always)]
fn shade<L: Lanes<Elem = f32>, S: Shading, T: Texturing>(
    token: L::Token,
    fragment: &Fragment,
    scenery: &Scenery,
    view: &View,
    at: [L; 2],
) -> Vec3<L> {
    let material = &scenery.materials[fragment.material as usize];
    let whole = L::splat(token, 1.0) / fragment.weight.at(token, at);
    let texture = if T::BY == MapBy::Nothing { None } else { material.texture };
    let shown = texture.map(|texture| {
        let [u, v] = fragment.coordinates;
        let (mut u, mut v) = (u.at(token, at), v.at(token, at));
        if T::BY == MapBy::Surface {
            (u, v) = (u * whole, v * whole);
        }
        sample::<L>(token, &scenery.textures[texture], u, v)
    });
    match S::BY {
        ShadeBy::Identity | ShadeBy::Nothing => own(token, material, shown),
        ShadeBy::Triangle => textured(three(token, at, &fragment.first), shown),
        ShadeBy::Corners => textured(three(token, at, &fragment.first).scale(whole), shown),
        ShadeBy::Pixels => {
            let normal = unit(token, three(token, at, &fragment.first).scale(whole));
            let position = three(token, at, &fragment.position).scale(whole);
            let direction = unit(token, directions(token, view, at));
            let lights = (&scenery.lights[..], scenery.ambient);
            let diffuse = own(token, material, shown);
            lit::<L>(token, lights, material, diffuse, (position, normal, direction))
        }
    }
}

#[inline(always)]
fn own<L: Lanes<Elem = f32>>(
    token: L::Token,
    material: &Material,
    shown: Option<Vec3<L>>,
) -> Vec3<L> {
    textured(splat(token, material.diffuse), shown)
}

#[inline(always)]
fn textured<L: Lanes<Elem = f32>>(color: Vec3<L>, shown: Option<Vec3<L>>) -> Vec3<L> {
    match shown {
        None => color,
        Some(by) => Vec3::new(color.x * by.x, color.y * by.y, color.z * by.z),
    }
}

/// What a texture shows, lane by lane: what it is read from is not in a row.
#[inline(always)]
fn sample<L: Lanes<Elem = f32>>(token: L::Token, texture: &Texture, u: L, v: L) -> Vec3<L> {
    let mut at = [[0.0_f32; 16]; 2];
    u.store(&mut at[0]);
    v.store(&mut at[1]);
    let mut rows = [[0.0_f32; 16]; 3];
    for lane in 0..L::N {
        let color = texture.at(Vec2::new(at[0][lane], at[1][lane]));
        (rows[0][lane], rows[1][lane], rows[2][lane]) = (color.x, color.y, color.z);
    }
    Vec3::new(L::load(token, &rows[0]), L::load(token, &rows[1]), L::load(token, &rows[2]))
}
